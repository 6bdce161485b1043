//! What a linked permutation asks of its host: entry points, vertex inputs and bindings.

use naga::{
    AddressSpace, Binding as IoBinding, ImageClass, ImageDimension, Module, ScalarKind, ShaderStage,
    StorageAccess, TypeInner, VectorSize, valid::ModuleInfo,
};
use serde::{Deserialize, Serialize};

/// What a permutation asks of its host.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reflection {
    /// The entry points, in the order of the pass's module.
    pub entry_points: Vec<EntryPoint>,
    /// What is to be bound, by group and binding number.
    pub bindings: Vec<Binding>,
}

/// An entry point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EntryPoint {
    /// Its name.
    pub name: String,
    /// Its stage.
    pub stage: Stage,
    /// A vertex stage's inputs by location; of other stages, none.
    pub inputs: Vec<VertexInput>,
    /// A compute stage's invocations a workgroup; of other stages, zeros.
    pub workgroup_size: [u32; 3],
}

/// A shader stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Vertex.
    Vertex,
    /// Fragment.
    Fragment,
    /// Compute.
    Compute,
}

/// An attribute that a vertex stage reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VertexInput {
    /// Its location.
    pub location: u32,
    /// Its name in the shader.
    pub name: String,
    /// How many components, 1 to 4.
    pub components: u32,
    /// What each component is.
    pub scalar: Scalar,
}

/// A component's type; each is 4 bytes, but for `F16`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scalar {
    /// `f32`.
    F32,
    /// `i32`.
    I32,
    /// `u32`.
    U32,
    /// `f16`.
    F16,
}

/// A resource that a permutation reads or writes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Binding {
    /// Its bind group: 0 the frame or pass, 1 the light and its method, 2 the material, 3 the objects.
    pub group: u32,
    /// Its number in the group, given by the linker.
    pub binding: u32,
    /// The module that declares it, as `package::folder::module`.
    pub module: String,
    /// Its name in that module.
    pub name: String,
    /// The stages that use it.
    pub stages: Vec<Stage>,
    /// What it is.
    pub kind: BindingKind,
}

/// What kind of resource a binding is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BindingKind {
    /// A uniform buffer of this layout.
    Uniform(Layout),
    /// A storage buffer.
    Storage {
        /// Whether the shader only reads it.
        read_only: bool,
        /// The layout; of a run-time array, that of one element.
        layout: Layout,
    },
    /// A texture to sample or load from.
    Texture {
        /// Its shape.
        dimension: TextureDimension,
        /// What it holds.
        sample: TextureSample,
        /// Whether a texel has several samples.
        multisampled: bool,
    },
    /// A texture to write to.
    StorageTexture {
        /// Its shape.
        dimension: TextureDimension,
        /// Its format, by naga's name, such as `R32Float`.
        format: String,
        /// Whether the shader reads it.
        read: bool,
        /// Whether the shader writes it.
        write: bool,
    },
    /// A sampler.
    Sampler {
        /// Whether it compares.
        comparison: bool,
    },
}

/// A texture's shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TextureDimension {
    /// A line.
    D1,
    /// A rectangle.
    D2,
    /// An array of rectangles.
    D2Array,
    /// Six faces.
    Cube,
    /// An array of six faces.
    CubeArray,
    /// A box.
    D3,
}

/// What a texture holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TextureSample {
    /// Floats.
    Float,
    /// Depths.
    Depth,
    /// Signed integers.
    Sint,
    /// Unsigned integers.
    Uint,
}

/// How a buffer's bytes lie.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layout {
    /// Bytes in all; of a run-time array, of one element with its padding.
    pub size: u32,
    /// The members of its struct; of another type, one member without a name.
    pub members: Vec<Member>,
}

/// A member of a struct in a buffer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// Bytes from the struct's start.
    pub offset: u32,
    /// Bytes that it fills.
    pub size: u32,
    /// What it is.
    pub ty: MemberType,
}

/// A member's type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MemberType {
    /// A scalar, or a vector of this many components.
    Vector {
        /// 1 to 4.
        components: u32,
        /// Each component.
        scalar: Scalar,
    },
    /// A matrix of columns.
    Matrix {
        /// 2 to 4.
        columns: u32,
        /// 2 to 4.
        rows: u32,
    },
    /// An array.
    Array {
        /// The element.
        element: Box<MemberType>,
        /// How many; 0 for a run-time array.
        count: u32,
        /// Bytes from one to the next.
        stride: u32,
    },
    /// A struct within.
    Struct(Layout),
}
