//! Plans: a method's textures, passes and constants for a frame, as plain data.

use std::collections::BTreeMap;

use glam::Mat4;
use wgpu_types::{ColorWrites, CompareFunction, Face, Features, FilterMode, TextureFormat};

use crate::{Constants, MAX_SPLITS, Value};

/// Passes that a method wants run this frame, and all that `calc_shadow` reads. The renderer only executes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowPlan {
    /// The textures that it owns, by the name of the binding that reads each. The renderer keeps a
    /// texture from frame to frame while its description stays the same.
    pub textures: Vec<TextureDesc>,
    /// The samplers that it owns, by the name of the binding that reads each.
    pub samplers: Vec<SamplerDesc>,
    /// Contents of textures that no pass draws into: uploaded before the passes.
    pub contents: Vec<Contents>,
    /// The storage buffers that its passes and `calc_shadow` use, by the name of the binding of each.
    pub buffers: Vec<BufferDesc>,
    /// Passes to run, in order.
    pub passes: Vec<Pass>,
    /// The members of the uniform blocks that `calc_shadow` reads.
    pub constants: Constants,
    /// The plan's question: names of buffers that its passes write. Where there are any, nothing is shaded by this plan; the
    /// parts are asked again, with what the buffers held in [`Frame::answers`](crate::Frame::answers).
    ///
    /// A later plan repeats the passes whose outcome it goes on from: what they filled stands, and they are not run again.
    /// [`MAX_QUESTIONS`] may follow each other.
    pub asks: Vec<String>,
    /// Needs beyond WebGPU's baseline.
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

/// The most questions that a shadow's plans may end in before one ends in none. Each costs a way to the GPU and back, so that
/// one or two are all that a frame has time for; what asks more often than this asks without end.
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
    /// Its mip levels, 1 at the least: each half as large as the one before.
    pub levels: u32,
    /// The value of each channel, or the depth, where nothing was drawn: a slice is cleared to it before the first pass into it.
    pub empty: f32,
}

/// A texture's shape as the shader sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureShape {
    /// One rectangle.
    D2,
    /// So many rectangles, 1 at the least: layers.
    Array(u32),
    /// Six faces: +x, −x, +y, −y, +z, −z, WebGPU's (left-handed) cube map.
    Cube,
}

impl TextureShape {
    /// How many layers it has.
    pub fn layers(self) -> u32 {
        match self {
            Self::D2 => 1,
            Self::Array(layers) => layers,
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

/// Texels that the method itself computed, such as a row of matrices.
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
    /// Its contents.
    pub contents: BufferContents,
}

/// Contents of a storage buffer.
#[derive(Clone, Debug, PartialEq)]
pub enum BufferContents {
    /// Numbers that the method computed, for shaders that only read them: for `array<T>` a [`Value::Array`] of one element at the
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
    /// Its shader: a value of the shader library's axis `pass`.
    pub fn shader(&self) -> &str {
        match self {
            Self::Casters(pass) => &pass.shader,
            Self::Screen(pass) => &pass.shader,
            Self::Compute(pass) => &pass.shader,
        }
    }

    /// Reads of its shader; none of a pass of casters.
    pub fn reads(&self) -> Option<&Reads> {
        match self {
            Self::Casters(_) => None,
            Self::Screen(pass) => Some(&pass.reads),
            Self::Compute(pass) => Some(&pass.reads),
        }
    }

    /// The names of the textures and buffers that it writes.
    pub fn writes(&self) -> Vec<&str> {
        match self {
            Self::Casters(pass) => {
                let depth = pass.depth.iter().map(|depth| &depth.target);
                let colors = pass.colors.iter().map(|color| &color.target);
                depth
                    .chain(colors)
                    .map(|target| target.texture.as_str())
                    .collect()
            }
            Self::Screen(pass) => {
                let targets = pass.targets.iter();
                targets.map(|target| target.texture.as_str()).collect()
            }
            Self::Compute(pass) => pass.writes.iter().map(|part| part.name.as_str()).collect(),
        }
    }
}

/// One layer and one mip level of a texture: what a pass draws into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slice {
    /// The texture's name.
    pub texture: String,
    /// The layer; of a cube, the face.
    pub layer: u32,
    /// The mip level, 0 the largest.
    pub level: u32,
}

impl Slice {
    /// Level 0 of a layer.
    pub fn new(texture: impl Into<String>, layer: u32) -> Self {
        Self {
            texture: texture.into(),
            layer,
            level: 0,
        }
    }
}

impl From<&str> for Slice {
    /// Layer 0, level 0.
    fn from(texture: &str) -> Self {
        Self::new(texture, 0)
    }
}

/// A buffer, a texture, or a part of one, that a binding of a pass reads or writes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The buffer's or the texture's name.
    pub name: String,
    /// The one layer, or face, that is bound; none for all of them.
    pub layer: Option<u32>,
    /// The one mip level that is bound; none for all of them, where it is read, and for the largest where it is written.
    pub level: Option<u32>,
}

impl Source {
    /// One mip level of a texture, in all layers.
    pub fn level(texture: &str, level: u32) -> Self {
        Self {
            level: Some(level),
            ..texture.into()
        }
    }
}

impl From<&str> for Source {
    /// All of it.
    fn from(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            layer: None,
            level: None,
        }
    }
}

/// Casters drawn into a viewport of a depth texture, of colour textures, or of both, which are all as large.
#[derive(Clone, Debug, PartialEq)]
pub struct CasterPass {
    /// How each caster is drawn: a value of the shader library's axis `pass`, such as `caster`, which draws
    /// depth alone, or `caster_depth`, which writes depth as a colour as well.
    pub shader: String,
    /// Where depth goes; none where nothing is compared with what is there.
    pub depth: Option<DepthTarget>,
    /// Where colours go, by the locations that the shader gives them.
    pub colors: Vec<ColorTarget>,
    /// Where in the textures.
    pub viewport: Viewport,
    /// Which faces are left out.
    pub cull: Cull,
    /// World (camera-relative) to clip space: the member `view_proj` of the shader's block `frame`.
    pub view_proj: Mat4,
    /// Members of `frame` and of further uniform blocks in its group.
    pub constants: Constants,
    /// The casters to draw: indices into the frame's casters, ascending.
    pub casters: Vec<usize>,
    /// The view depths (metres along the way that the camera looks, nearest and farthest) of the
    /// receivers that this pass's map is read for; none where it is read for all that it holds. Nothing is
    /// drawn by it: it tells a measurement which of several maps a pixel reads.
    pub receivers: Option<[f64; 2]>,
}

/// Which faces of casters a pass leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cull {
    /// None.
    Nothing,
    /// These, as the map shows them: a cube's faces are mirrored, so that there front and back change places.
    Side(Face),
    /// Those that cannot be nearest to the light: the backs of closed casters, where the map's near plane cuts none. Of other
    /// casters none. For passes whose outcome is the nearest depth.
    Hidden,
}

/// Where a pass's depth goes, and what of old and new depth is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthTarget {
    /// A slice of a texture of depth alone.
    pub target: Slice,
    /// Whether all of it is made [empty](TextureDesc::empty) though an earlier pass drew into it. The plan's first pass into a
    /// slice does so in any case.
    pub clears: bool,
    /// How a new depth is compared with an old one.
    pub compare: CompareFunction,
}

/// Where a pass's colours go.
///
/// The plan's first pass into a slice makes all of it [empty](TextureDesc::empty): later passes fill further channels, or
/// further viewports.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorTarget {
    /// A slice of a texture in a format of floats.
    pub target: Slice,
    /// The channels to write; the others keep what they hold.
    pub channels: ColorWrites,
    /// Choice between what is there and what is drawn.
    pub blend: Blend,
}

/// Choice between an old and a new colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// The new one.
    #[default]
    Replace,
    /// In each channel the larger one: of [reversed](crate::DepthOrder) depth, the nearest. A texture of 32 bits a channel asks for the
    /// feature `float32-blendable`: say so in [`ShadowPlan::needs`].
    Max,
}

/// One triangle around a part of a texture, whose fragments read the plan's other textures.
#[derive(Clone, Debug, PartialEq)]
pub struct ScreenPass {
    /// Its shader: a value of the shader library's axis `pass`.
    pub shader: String,
    /// Its targets, all as large: textures of floats by the locations that the shader gives their colours, and at most one
    /// of depth, which takes the fragment's depth. The plan's first pass into each makes it [empty](TextureDesc::empty).
    pub targets: Vec<Slice>,
    /// Where in them.
    pub viewport: Viewport,
    /// Inputs of the shader.
    pub reads: Reads,
}

/// A compute shader that reads some of the plan's textures and buffers and writes others.
#[derive(Clone, Debug, PartialEq)]
pub struct ComputePass {
    /// Its shader: a value of the shader library's axis `pass`.
    pub shader: String,
    /// How many workgroups are run.
    pub workgroups: Workgroups,
    /// Its outputs: textures of rectangles, in a format that WebGPU's baseline can store to, and
    /// [written](BufferContents::Written) buffers.
    pub writes: Vec<Source>,
    /// Inputs of the shader.
    pub reads: Reads,
}

/// How many workgroups a compute pass runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Workgroups {
    /// So many across, down and deep.
    Count([u32; 3]),
    /// As many as a buffer says that an earlier pass wrote: three words from byte `offset` on, a multiple of 4. More than the
    /// device allows are none.
    Indirect {
        /// The buffer's name.
        buffer: String,
        /// Where the words begin, bytes.
        offset: u64,
    },
}

impl From<[u32; 3]> for Workgroups {
    fn from(count: [u32; 3]) -> Self {
        Self::Count(count)
    }
}

/// Inputs of a pass's shader beside the plan's textures, samplers and buffers, which have the names of
/// the bindings that read them, and the camera's depth, which is the texture [`Reads::CAMERA_DEPTH`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reads {
    /// Bindings that go by another name than the texture or buffer that they read or write, or that have a part of a texture.
    /// So that one shader may work from a first texture into a second, and then from there into a third; or from level to
    /// level of one.
    pub renamed: Vec<(String, Source)>,
    /// The members of the pass's own uniform blocks.
    pub constants: Constants,
}

impl Reads {
    /// The binding of the camera's depth, a `texture_depth_2d` as large as [`Frame::camera_depth`](crate::Frame::camera_depth)
    /// says: reversed, 0 where nothing is seen; [`Projection::view_depth`](crate::Projection::view_depth) makes it linear.
    pub const CAMERA_DEPTH: &str = "camera_depth";
}

/// A plan's demand on the device beyond WebGPU's baseline.
#[derive(Clone, Debug, PartialEq)]
pub struct Need {
    /// The features.
    pub features: Features,
    /// Advice where the device does not have them: the end of the sentence "…; choose".
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
