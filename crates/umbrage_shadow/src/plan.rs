//! What a method wants drawn this frame, as plain data.

use glam::Mat4;
use wgpu_types::{CompareFunction, Face, FilterMode, TextureFormat};

use crate::Constants;

/// What a method wants drawn this frame, and what `calc_shadow` reads. The renderer only executes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowPlan {
    /// The textures that it owns, by the name of the binding that reads each. The renderer keeps a
    /// texture from frame to frame while its description stays the same.
    pub textures: Vec<TextureDesc>,
    /// The samplers that it owns, by the name of the binding that reads each.
    pub samplers: Vec<SamplerDesc>,
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
    /// The texture's name.
    pub target: String,
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
