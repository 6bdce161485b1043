//! What a method wants drawn this frame, as plain data.

use std::collections::BTreeMap;

use glam::Mat4;
use wgpu_types::{ColorWrites, CompareFunction, Face, FilterMode, TextureFormat};

use crate::{Constants, MAX_SPLITS, Value};

/// What a method wants drawn this frame, and what `calc_shadow` reads. The renderer only executes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowPlan {
    /// The textures that it owns, by the name of the binding that reads each. The renderer keeps a
    /// texture from frame to frame while its description stays the same.
    pub textures: Vec<TextureDesc>,
    /// The samplers that it owns, by the name of the binding that reads each.
    pub samplers: Vec<SamplerDesc>,
    /// What textures hold that no pass draws into: uploaded before the passes.
    pub contents: Vec<Contents>,
    /// The storage buffers that `calc_shadow` reads, by the name of the binding that reads each.
    pub buffers: Vec<BufferDesc>,
    /// What to draw, in order.
    pub passes: Vec<Pass>,
    /// The members of the uniform block that `calc_shadow` reads.
    pub constants: Constants,
    /// Texture fetches that `calc_shadow` makes at the most for a pixel: the method's own promise,
    /// for a report to check.
    pub fetches_per_pixel: u32,
    /// How far from the receiver's place in the map `calc_shadow` reads, in texels, a fetch's own
    /// blending included: within it, an edge may be blurred or displaced.
    pub filter_radius: f64,
    /// The view depth beyond which `calc_shadow` is 1 whatever stands between, in metres; none where
    /// receivers at all depths are shadowed.
    pub shadow_distance: Option<f64>,
    /// Where a narrower shader than the light's own gives the same term: by ascending view depth,
    /// [`MAX_REGIONS`] at the most. None where one shader is for all.
    pub regions: Vec<Region>,
}

/// The most [regions](ShadowPlan::regions) of a plan: for each of the most splits two.
pub const MAX_REGIONS: usize = 2 * MAX_SPLITS;

/// View depths whose pixels a pass of their own may shade, with a permutation of its own. It begins where the
/// region before it ends, the first one at the eye; beyond the last one, `calc_shadow` is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The view depth at which it ends, metres: what lies there is the next one's. It is compared as `f32`.
    pub end: f64,
    /// Values of the method's axes in place of the light's own, with which `calc_shadow` gives the same here.
    pub axes: BTreeMap<String, String>,
}

/// A texture that a method owns.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureDesc {
    /// The binding that reads it.
    pub name: String,
    /// Its format.
    pub format: TextureFormat,
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Its shape as the shader sees it.
    pub shape: TextureShape,
}

/// A texture's shape as the shader sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureShape {
    /// One rectangle.
    D2,
    /// Six faces: +x, −x, +y, −y, +z, −z, WebGPU's (left-handed) cube map.
    Cube,
}

impl TextureShape {
    /// How many layers it has.
    pub fn layers(self) -> u32 {
        match self {
            Self::D2 => 1,
            Self::Cube => 6,
        }
    }
}

/// A sampler that a method owns. It clamps to the edge.
#[derive(Clone, Debug, PartialEq)]
pub struct SamplerDesc {
    /// The binding that reads it.
    pub name: String,
    /// Nearest, or linear.
    pub filter: FilterMode,
    /// How it compares, where it does.
    pub compare: Option<CompareFunction>,
}

/// What a texture holds that the method itself computed, such as a row of matrices.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// The texture: one of the plan's, of one rectangle and a format of whole texels that is not of
    /// depth, that no pass draws into.
    pub texture: String,
    /// All of its texels, as the format has them (numbers least significant byte first): rows from the
    /// top, texels from the left, nothing between.
    pub bytes: Vec<u8>,
}

/// A storage buffer that a method owns and its shader only reads.
#[derive(Clone, Debug, PartialEq)]
pub struct BufferDesc {
    /// The binding that reads it.
    pub name: String,
    /// What it holds: for `array<T>` a [`Value::Array`] of one element at the least, laid out with the
    /// stride that the linked shader gives it.
    pub value: Value,
}

/// One pass of a plan.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Pass {
    /// Casters into a texture.
    Casters(CasterPass),
}

/// Casters drawn into a viewport of a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct CasterPass {
    /// The name of the depth texture.
    pub target: String,
    /// A colour texture that depth is written into as well: for shaders that read depth in channels of
    /// their own choice. `target` then only finds which caster is nearest, and no shader need read it.
    pub color: Option<ColorTarget>,
    /// The texture's layer; of a cube, its face.
    pub layer: u32,
    /// Where in the layer.
    pub viewport: Viewport,
    /// The depth that the layer is cleared to first; none keeps what it holds.
    pub clear: Option<f32>,
    /// How depths are compared. Reversed depth (1 near, 0 far) is cleared to 0 and keeps what is
    /// `GreaterEqual`.
    pub depth_test: DepthTest,
    /// Which faces are left out. A cube's faces are mirrored: there, front and back change places.
    pub cull: Option<Face>,
    /// World (camera-relative) to clip space.
    pub view_proj: Mat4,
    /// The casters to draw: indices into the frame's casters, ascending.
    pub casters: Vec<usize>,
    /// The view depths (metres along the way that the camera looks, nearest and farthest) of the
    /// receivers that this pass's map is read for; none where it is read for all that it holds. Nothing is
    /// drawn by it: it tells a measurement which of several maps a pixel reads.
    pub receivers: Option<[f64; 2]>,
}

/// Where a pass writes depth as a colour: window depth (reversed, 0..1), as the depth texture holds it.
///
/// The plan's first pass into a texture clears all of its channels to 0, the farthest, whatever
/// [`CasterPass::clear`] says of the depth: later passes fill further channels, or further viewports.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorTarget {
    /// The name of a texture of one rectangle, as large as the pass's depth texture, in a format of
    /// floats.
    pub texture: String,
    /// The channels to write. Each gets the same depth; the others keep what they hold.
    pub channels: ColorWrites,
}

/// How a pass compares depths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepthTest {
    /// What passes.
    pub compare: CompareFunction,
    /// Whether what lies before the near plane is flattened onto it rather than cut away.
    pub unclipped: bool,
}

/// A rectangle of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Viewport {
    /// The left edge.
    pub x: u32,
    /// The top edge.
    pub y: u32,
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
}
