//! What a method wants drawn this frame, as plain data.

use std::collections::BTreeMap;

use glam::Mat4;
use wgpu_types::{ColorWrites, CompareFunction, Face, Features, FilterMode, TextureFormat};

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
    /// The storage buffers that its passes and `calc_shadow` use, by the name of the binding of each.
    pub buffers: Vec<BufferDesc>,
    /// What to draw, in order.
    pub passes: Vec<Pass>,
    /// The members of the uniform blocks that `calc_shadow` reads.
    pub constants: Constants,
    /// The plan's question: names of buffers that its passes write. Where there are any, nothing is shaded by this plan; the
    /// parts are asked again, with what the buffers held in [`Frame::answers`](crate::Frame::answers).
    ///
    /// A later plan repeats the passes whose outcome it goes on from: what they filled stands, and they are not run again.
    /// [`MAX_QUESTIONS`] may follow each other.
    pub asks: Vec<String>,
    /// What it takes beyond WebGPU's baseline.
    pub needs: Vec<Need>,
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

impl ShadowPlan {
    /// The place in `passes` of the one whose map is read at a view depth (metres), where passes tell
    /// their [receivers' depths](CasterPass::receivers); compared as `f32`, as shaders do.
    pub fn split_at(&self, view_depth: f32) -> Option<u32> {
        let holds = |pass: &Pass| match pass {
            Pass::Casters(pass) => pass
                .receivers
                .is_some_and(|[start, end]| (start as f32..end as f32).contains(&view_depth)),
            _ => false,
        };
        let number = self.passes.iter().position(holds)?;
        u32::try_from(number).ok()
    }
}

/// The most questions that a shadow's plans may end in before one ends in none. Each costs a way to the GPU and back: resolution
/// matched maps, the most curious method known, refine their list of pages in three.
pub const MAX_QUESTIONS: usize = 4;

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

/// A storage buffer that a method owns.
#[derive(Clone, Debug, PartialEq)]
pub struct BufferDesc {
    /// Its binding.
    pub name: String,
    /// What it holds.
    pub contents: BufferContents,
}

/// Contents of a storage buffer.
#[derive(Clone, Debug, PartialEq)]
pub enum BufferContents {
    /// What the method computed, for shaders that only read it: for `array<T>` a [`Value::Array`] of one element at the
    /// least, laid out with the stride that the linked shader gives it.
    Value(Value),
    /// So many bytes, a multiple of 4, that compute passes write and others read: the plan's first pass that writes it finds
    /// zeros. Its shaders must lay it out alike.
    Written(u64),
}

/// One pass of a plan.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Pass {
    /// Casters into a texture.
    Casters(CasterPass),
    /// One triangle around a part of a texture: what can be computed for each texel by itself.
    Screen(ScreenPass),
    /// A compute shader: where texels share their work.
    Compute(ComputePass),
}

impl Pass {
    /// What shader it runs: a value of the shader library's axis `pass`.
    pub fn shader(&self) -> &str {
        match self {
            Self::Casters(pass) => &pass.shader,
            Self::Screen(pass) => &pass.shader,
            Self::Compute(pass) => &pass.shader,
        }
    }

    /// What it reads; none of a pass of casters.
    pub fn reads(&self) -> Option<&Reads> {
        match self {
            Self::Casters(_) => None,
            Self::Screen(pass) => Some(&pass.reads),
            Self::Compute(pass) => Some(&pass.reads),
        }
    }

    /// The names of the textures and buffers that it writes.
    pub fn writes(&self) -> impl Iterator<Item = &str> {
        let (two, many): ([Option<&String>; 2], &[String]) = match self {
            Self::Casters(pass) => {
                let depth = pass.depth.as_ref().map(|depth| &depth.texture);
                let color = pass.color.as_ref().map(|color| &color.texture);
                ([depth, color], &[])
            }
            Self::Screen(pass) => ([Some(&pass.target), None], &[]),
            Self::Compute(pass) => ([None, None], &pass.writes),
        };
        two.into_iter()
            .flatten()
            .chain(many)
            .map(|name| name.as_str())
    }
}

/// Casters drawn into a viewport of a depth texture, of a colour texture, or of both.
#[derive(Clone, Debug, PartialEq)]
pub struct CasterPass {
    /// How each caster is drawn: a value of the shader library's axis `pass`, such as `caster`, which draws
    /// depth alone, or `caster_depth`, which writes depth as a colour as well.
    pub shader: String,
    /// Where depth goes; none where nothing is compared with what is there.
    pub depth: Option<DepthTarget>,
    /// Where colours go.
    pub color: Option<ColorTarget>,
    /// Where in the textures.
    pub viewport: Viewport,
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

/// Where a pass's depth goes, and what of old and new depth is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthTarget {
    /// The name of a texture of depth alone.
    pub texture: String,
    /// The texture's layer; of a cube, its face.
    pub layer: u32,
    /// The depth that the layer is cleared to first; none keeps what it holds.
    pub clear: Option<f32>,
    /// How depths are compared. Reversed depth (1 near, 0 far) is cleared to 0 and keeps what is
    /// `GreaterEqual`.
    pub compare: CompareFunction,
}

impl DepthTarget {
    /// Layer 0 of `texture`, cleared, of which the nearest is kept.
    pub fn nearest(texture: impl Into<String>) -> Self {
        Self {
            texture: texture.into(),
            layer: 0,
            clear: Some(0.0),
            compare: CompareFunction::GreaterEqual,
        }
    }
}

/// Where a pass's colours go.
///
/// The plan's first pass into a texture clears all of its channels to 0, the farthest in reversed depth,
/// whatever [`DepthTarget::clear`] says of the depth: later passes fill further channels, or further viewports.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorTarget {
    /// The name of a texture of one rectangle, as large as the pass's depth texture where it has one,
    /// in a format of floats.
    pub texture: String,
    /// The channels to write; the others keep what they hold.
    pub channels: ColorWrites,
    /// What is kept.
    pub blend: Blend,
}

/// What of an old and a new colour is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// The new one.
    #[default]
    Replace,
    /// In each channel the larger one: of reversed depth, the nearest. A texture of 32 bits a channel asks for the
    /// feature `float32-blendable`: say so in [`ShadowPlan::needs`].
    Max,
}

/// One triangle around a part of a texture, whose fragments read the plan's other textures.
#[derive(Clone, Debug, PartialEq)]
pub struct ScreenPass {
    /// What is computed: a value of the shader library's axis `pass`.
    pub shader: String,
    /// The name of the texture to fill, of one rectangle. One of depth takes what the shader gives as its
    /// fragment's depth. The plan's first pass into it clears it to 0.
    pub target: String,
    /// Where in it.
    pub viewport: Viewport,
    /// What the shader reads.
    pub reads: Reads,
}

/// A compute shader that reads some of the plan's textures and buffers and writes others.
#[derive(Clone, Debug, PartialEq)]
pub struct ComputePass {
    /// What is computed: a value of the shader library's axis `pass`.
    pub shader: String,
    /// Workgroups across, down and deep.
    pub workgroups: [u32; 3],
    /// The names of the textures and buffers that it writes: textures of one rectangle, in a format that WebGPU's baseline
    /// can store to, and [written](BufferContents::Written) buffers.
    pub writes: Vec<String>,
    /// What the shader reads.
    pub reads: Reads,
}

/// What the shader of a pass reads beside the plan's textures, samplers and buffers, which have the names of
/// the bindings that read them, and the camera's depth, which is the texture [`Reads::CAMERA_DEPTH`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reads {
    /// Bindings that go by another name than the texture or buffer that they read or write: binding, texture. So that one
    /// shader may work from a first texture into a second, and then from there into a third.
    pub renamed: Vec<(String, String)>,
    /// The members of the pass's own uniform blocks.
    pub constants: Constants,
}

impl Reads {
    /// The binding of the camera's depth, a `texture_depth_2d` as large as [`Frame::camera_depth`](crate::Frame::camera_depth)
    /// says: reversed, 0 where nothing is seen; [`Projection::view_depth`](crate::Projection::view_depth) makes it linear.
    pub const CAMERA_DEPTH: &str = "camera_depth";
}

/// What a plan asks of the device beyond WebGPU's baseline.
#[derive(Clone, Debug, PartialEq)]
pub struct Need {
    /// The features.
    pub features: Features,
    /// What to choose where the device does not have them: the end of the sentence "…; choose".
    pub instead: String,
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
