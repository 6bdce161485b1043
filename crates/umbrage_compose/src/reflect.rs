//! Interface of a linked permutation to its host: entry points, vertex inputs, bindings and overrides.

use naga::{
    AddressSpace, ArraySize, Binding as IoBinding, GlobalVariable, Handle, ImageClass,
    ImageDimension, Module, ScalarKind, ShaderStage, StorageAccess, Type, TypeInner,
};
use serde::{Deserialize, Serialize};

use crate::overrides::Override;

/// Demands of a permutation on its host.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reflection {
    /// The entry points, in the order of the pass's module.
    pub entry_points: Vec<EntryPoint>,
    /// Resources to be bound, by group and binding number.
    pub bindings: Vec<Binding>,
    /// The overrides that a host may set, sorted by name.
    pub overrides: Vec<Override>,
}

impl Reflection {
    /// The first entry point of `stage`: the one that a pipeline is made of.
    pub fn entry_point(&self, stage: Stage) -> Option<&EntryPoint> {
        self.entry_points.iter().find(|entry| entry.stage == stage)
    }

    /// The bindings of each group, from 0 to the last that has any, as pipeline layouts list them: nothing in a
    /// group between that the shader reads nothing of.
    pub fn groups(&self) -> Vec<&[Binding]> {
        let mut groups = Vec::new();
        let mut rest = self.bindings.as_slice();
        while !rest.is_empty() {
            let count = rest.partition_point(|binding| binding.group as usize <= groups.len());
            let (own, others) = rest.split_at(count);
            groups.push(own);
            rest = others;
        }
        groups
    }
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
    /// Workgroup size of a compute stage, with overrides at their defaults (0 where it depends on one without a
    /// default); zeros for other stages.
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
    /// Scalar type of each component.
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
    /// Its name in that module. The permutation's WGSL uses the same name, unless another module's resource has it.
    pub name: String,
    /// Of a permutation of [several keys](crate::Composer::compose_all), the place of the key that it belongs to; 0 as
    /// well for what is there once.
    pub instance: usize,
    /// The stages that use it.
    pub stages: Vec<Stage>,
    /// Kind of resource.
    pub kind: BindingKind,
}

/// Kind of resource that a binding is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BindingKind {
    /// A uniform buffer of this layout.
    Uniform(Layout),
    /// A storage buffer.
    Storage {
        /// Whether the shader only reads it.
        read_only: bool,
        /// Whether it is a run-time array: of as many elements as the buffer has room for.
        run_time: bool,
        /// The layout; of a run-time array, that of one element.
        layout: Layout,
    },
    /// A texture to sample or load from.
    Texture {
        /// Its shape.
        dimension: TextureDimension,
        /// Kind of its contents.
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

impl BindingKind {
    /// The layout of a block of constants: of a uniform buffer, or of a storage buffer of a fixed size that the shader only
    /// reads.
    pub fn block(&self) -> Option<&Layout> {
        match self {
            Self::Uniform(layout)
            | Self::Storage {
                read_only: true,
                run_time: false,
                layout,
            } => Some(layout),
            _ => None,
        }
    }
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

/// Kind of a texture's contents.
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
    /// Type of the member.
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

/// Reflects a valid `module`. `used` tells whether an entry point uses a variable, `owner` gives the module and name
/// that a variable came from, `settable` the overrides that may be set, and `size` an entry point's workgroup size.
/// Declaration of a variable: its module's path, its name there, and its instance.
pub(crate) struct Owner {
    pub(crate) module: String,
    pub(crate) name: String,
    pub(crate) instance: usize,
}

pub(crate) fn reflect(
    module: &Module,
    used: impl Fn(usize, Handle<GlobalVariable>) -> bool,
    owner: impl Fn(Handle<GlobalVariable>) -> Option<Owner>,
    settable: Vec<Override>,
    size: impl Fn(&naga::EntryPoint) -> [u32; 3],
) -> Reflection {
    let entry_points = module.entry_points.iter().map(|entry| EntryPoint {
        name: entry.name.clone(),
        stage: stage(entry.stage),
        inputs: match entry.stage {
            ShaderStage::Vertex => vertex_inputs(module, entry),
            _ => Vec::new(),
        },
        workgroup_size: size(entry),
    });
    let mut bindings: Vec<_> = module
        .global_variables
        .iter()
        .filter_map(|(handle, global)| {
            let at = global.binding?;
            let owner = owner(handle)?;
            Some(Binding {
                group: at.group,
                binding: at.binding,
                module: owner.module,
                name: owner.name,
                instance: owner.instance,
                stages: stages(module, |entry| used(entry, handle)),
                kind: kind(module, global)?,
            })
        })
        .collect();
    bindings.sort_by_key(|binding| (binding.group, binding.binding));
    Reflection {
        entry_points: entry_points.collect(),
        bindings,
        overrides: settable,
    }
}

fn stage(stage: ShaderStage) -> Stage {
    match stage {
        ShaderStage::Vertex => Stage::Vertex,
        ShaderStage::Fragment => Stage::Fragment,
        // The linker lets no other stage through.
        _ => Stage::Compute,
    }
}

/// Stages of the entry points that are `used`.
fn stages(module: &Module, used: impl Fn(usize) -> bool) -> Vec<Stage> {
    let mut stages: Vec<_> = module
        .entry_points
        .iter()
        .enumerate()
        .filter(|(index, _)| used(*index))
        .map(|(_, entry)| stage(entry.stage))
        .collect();
    stages.sort();
    stages.dedup();
    stages
}

fn vertex_inputs(module: &Module, entry: &naga::EntryPoint) -> Vec<VertexInput> {
    let mut inputs = Vec::new();
    let mut input = |name: &Option<String>, ty: Handle<Type>, binding: &Option<IoBinding>| {
        let Some(IoBinding::Location { location, .. }) = binding else {
            return;
        };
        let (components, scalar) = match module.types[ty].inner {
            TypeInner::Scalar(scalar) => (1, scalar),
            TypeInner::Vector { size, scalar } => (u32::from(size), scalar),
            _ => return,
        };
        inputs.push(VertexInput {
            location: *location,
            name: name.clone().unwrap_or_default(),
            components,
            scalar: scalar_of(scalar),
        });
    };
    for argument in &entry.function.arguments {
        match &module.types[argument.ty].inner {
            TypeInner::Struct { members, .. } => {
                for member in members {
                    input(&member.name, member.ty, &member.binding);
                }
            }
            _ => input(&argument.name, argument.ty, &argument.binding),
        }
    }
    inputs.sort_by_key(|input| input.location);
    inputs
}

fn scalar_of(scalar: naga::Scalar) -> Scalar {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 2) => Scalar::F16,
        (ScalarKind::Sint, _) => Scalar::I32,
        (ScalarKind::Uint | ScalarKind::Bool, _) => Scalar::U32,
        _ => Scalar::F32,
    }
}

fn kind(module: &Module, global: &GlobalVariable) -> Option<BindingKind> {
    match global.space {
        AddressSpace::Uniform => Some(BindingKind::Uniform(layout(module, global.ty))),
        AddressSpace::Storage { access } => Some(BindingKind::Storage {
            read_only: !access.contains(StorageAccess::STORE),
            run_time: matches!(
                module.types[global.ty].inner,
                TypeInner::Array {
                    size: ArraySize::Dynamic,
                    ..
                }
            ),
            layout: layout(module, global.ty),
        }),
        _ => match module.types[global.ty].inner {
            TypeInner::Sampler { comparison } => Some(BindingKind::Sampler { comparison }),
            TypeInner::Image {
                dim,
                arrayed,
                class,
            } => texture(dim, arrayed, class),
            _ => None,
        },
    }
}

fn texture(dim: ImageDimension, arrayed: bool, class: ImageClass) -> Option<BindingKind> {
    let dimension = match (dim, arrayed) {
        (ImageDimension::D1, _) => TextureDimension::D1,
        (ImageDimension::D2, false) => TextureDimension::D2,
        (ImageDimension::D2, true) => TextureDimension::D2Array,
        (ImageDimension::Cube, false) => TextureDimension::Cube,
        (ImageDimension::Cube, true) => TextureDimension::CubeArray,
        (ImageDimension::D3, _) => TextureDimension::D3,
    };
    let sampled = |sample, multisampled| BindingKind::Texture {
        dimension,
        sample,
        multisampled,
    };
    Some(match class {
        ImageClass::Depth { multi } => sampled(TextureSample::Depth, multi),
        ImageClass::Sampled {
            kind: ScalarKind::Sint,
            multi,
        } => sampled(TextureSample::Sint, multi),
        ImageClass::Sampled {
            kind: ScalarKind::Uint,
            multi,
        } => sampled(TextureSample::Uint, multi),
        ImageClass::Sampled { multi, .. } => sampled(TextureSample::Float, multi),
        ImageClass::Storage { format, access } => BindingKind::StorageTexture {
            dimension,
            format: format!("{format:?}"),
            read: access.contains(StorageAccess::LOAD),
            write: access.contains(StorageAccess::STORE),
        },
        ImageClass::External => return None,
    })
}

fn layout(module: &Module, ty: Handle<Type>) -> Layout {
    match &module.types[ty].inner {
        TypeInner::Struct { members, span } => Layout {
            size: *span,
            members: members
                .iter()
                .map(|member| Member {
                    name: member.name.clone().unwrap_or_default(),
                    offset: member.offset,
                    size: module.types[member.ty].inner.size(module.to_ctx()),
                    ty: member_type(module, member.ty),
                })
                .collect(),
        },
        TypeInner::Array {
            base,
            size: ArraySize::Dynamic,
            stride,
        } => {
            let mut element = layout(module, *base);
            element.size = *stride;
            element
        }
        other => Layout {
            size: other.size(module.to_ctx()),
            members: vec![Member {
                name: String::new(),
                offset: 0,
                size: other.size(module.to_ctx()),
                ty: member_type(module, ty),
            }],
        },
    }
}

fn member_type(module: &Module, ty: Handle<Type>) -> MemberType {
    match module.types[ty].inner {
        TypeInner::Vector { size, scalar } => MemberType::Vector {
            components: size.into(),
            scalar: scalar_of(scalar),
        },
        TypeInner::Matrix { columns, rows, .. } => MemberType::Matrix {
            columns: columns.into(),
            rows: rows.into(),
        },
        TypeInner::Array { base, size, stride } => MemberType::Array {
            element: Box::new(member_type(module, base)),
            count: match size {
                ArraySize::Constant(count) => count.get(),
                _ => 0,
            },
            stride,
        },
        TypeInner::Struct { .. } => MemberType::Struct(layout(module, ty)),
        TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => MemberType::Vector {
            components: 1,
            scalar: scalar_of(scalar),
        },
        // No other type lies in a buffer.
        _ => MemberType::Vector {
            components: 1,
            scalar: Scalar::U32,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_listed_with_those_that_nothing_is_in() {
        let binding = |group, binding| Binding {
            group,
            binding,
            module: "demo::pass".to_owned(),
            name: format!("b{group}{binding}"),
            stages: vec![Stage::Fragment],
            instance: 0,
            kind: BindingKind::Sampler { comparison: false },
        };
        let reflection = Reflection {
            bindings: vec![binding(1, 0), binding(1, 4), binding(3, 2)],
            ..Reflection::default()
        };
        let groups = reflection.groups();
        let counts: Vec<_> = groups.iter().map(|group| group.len()).collect();
        assert_eq!(counts, [0, 2, 0, 1]);
        assert_eq!(groups[3][0].binding, 2);
        assert!(Reflection::default().groups().is_empty());
    }
}
