//! A light's shadow maps: what a method fits, a depth source fills and a filter samples.

use glam::DMat4;
use wgpu_types::{CompareFunction, FilterMode, TextureFormat};

use crate::{
    Bias, CasterPass, Constants, Cull, DepthTarget, Extent, Lens, Pass, PlanError, Reads,
    SamplerDesc, ScreenPass, ShadowPlan, Slice, TextureDesc, TextureShape, Viewport,
};

/// Which of two depths is the nearer one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DepthOrder {
    /// The larger one: 1 near, 0 far and empty. With f32 it keeps a light's precision over a ratio of 1e5.
    #[default]
    Reversed,
    /// The smaller one: 0 near, 1 far and empty.
    Forward,
}

impl DepthOrder {
    /// The depth where nothing is: the farthest.
    pub fn empty(self) -> f32 {
        match self {
            Self::Reversed => 0.0,
            Self::Forward => 1.0,
        }
    }

    /// Holds for a depth that is as near as another, or nearer. A caster is kept by it, and a receiver lit.
    pub fn nearer(self) -> CompareFunction {
        match self {
            Self::Reversed => CompareFunction::GreaterEqual,
            Self::Forward => CompareFunction::LessEqual,
        }
    }

    /// The slice `target` of a depth texture, of which the nearest is kept.
    pub fn nearest(self, target: Slice) -> DepthTarget {
        DepthTarget {
            target,
            clears: false,
            compare: self.nearer(),
        }
    }
}

/// A light's shadow maps, in one texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Maps {
    /// Which of their depths is the nearer one.
    pub order: DepthOrder,
    /// The texture's shape: tiles of one rectangle, or a cube's faces.
    pub shape: TextureShape,
    /// Texels across and down the texture.
    pub size: [u32; 2],
    /// The maps. A map's place in this list is its number: `Tile.number` in shaders. As tiles they are squares of one size,
    /// from the left, then from the top.
    pub maps: Vec<Map>,
    /// Whether what is compared with the maps follows the receiver's plane.
    pub follows_plane: bool,
}

/// One shadow map.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Where it lies in the texture.
    pub tile: Viewport,
    /// The texture's layer; of a cube, its face.
    pub layer: u32,
    /// World (camera-relative) to clip space.
    pub view_proj: DMat4,
    /// The casters to draw: indices into the frame's casters, ascending.
    pub casters: Vec<usize>,
    /// The view depths that it is read for: see [`CasterPass::receivers`].
    pub receivers: Option<[f64; 2]>,
    /// The view depths of all that is looked up in it: beside its `receivers`, those of which other maps are read as well.
    pub held: Option<[f64; 2]>,
    /// Bias of its receivers.
    pub bias: Bias,
    /// The distances that it holds.
    pub range: MapRange,
}

/// The distances that a map's depths stand for: from the light along its axis, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapRange {
    /// The distance at the nearest depth.
    pub near: f64,
    /// The distance at the farthest, empty depth.
    pub far: f64,
    /// Whether depth is linear in one over the distance, and not in the distance.
    pub perspective: bool,
    /// The width of a texel at the far end.
    pub texel: f64,
}

impl MapRange {
    /// The range of a map of what is `seen`, with `side` texels.
    pub fn new(lens: &Lens, seen: &Extent, side: u32) -> Self {
        let perspective = lens.is_perspective();
        let spread = if perspective { seen.far } else { 1.0 };
        Self {
            near: seen.near,
            far: seen.far,
            perspective,
            texel: spread * seen.rect.size().max_element() / f64::from(side),
        }
    }

    /// The number that makes reversed depths linear: a depth z lies at the share (1 − z) / (1 + ratio · z) of the way from near to far,
    /// which is A + B / d solved for d. 0 without a perspective.
    pub fn ratio(&self) -> f64 {
        if self.perspective {
            (self.far - self.near) / self.near
        } else {
            0.0
        }
    }
}

impl Map {
    /// The pass that draws the nearest depths of this map, in this order, into the depth texture `target`.
    ///
    /// Both sides of each triangle are drawn, but for closed casters, whose backs are never nearest: a mesh may be open, a leaf
    /// without thickness, a transform a mirror.
    pub fn nearest(&self, target: &str, order: DepthOrder) -> CasterPass {
        CasterPass {
            shader: "caster".to_owned(),
            depth: Some(order.nearest(Slice::new(target, self.layer))),
            colors: Vec::new(),
            viewport: self.tile,
            cull: Cull::Hidden,
            view_proj: self.view_proj.as_mat4(),
            constants: Constants::new(),
            casters: self.casters.clone(),
            receivers: self.receivers,
        }
    }
}

impl Maps {
    /// The binding of the depth texture that depth sources fill and filters sample.
    pub const BINDING: &str = "shadow_map";

    /// The binding of the sampler with which the hardware compares depths.
    pub const SAMPLER: &str = "shadow_sampler";

    /// The format of depths.
    pub const FORMAT: TextureFormat = TextureFormat::Depth32Float;

    /// The least that a shader can bind, where there is no map.
    pub fn none(follows_plane: bool) -> Self {
        Self {
            order: DepthOrder::default(),
            shape: TextureShape::D2,
            size: [1, 1],
            maps: Vec::new(),
            follows_plane,
        }
    }

    /// A texture as large as the maps' own, and as empty.
    pub fn texture(&self, name: &str, format: TextureFormat) -> TextureDesc {
        TextureDesc {
            shape: self.shape,
            empty: self.order.empty(),
            ..TextureDesc::d2(name, format, self.size)
        }
    }

    /// Checks that depths are reversed, for a part that knows no others.
    ///
    /// # Errors
    /// They are not.
    pub fn check_reversed(&self, part: &str) -> Result<(), PlanError> {
        PlanError::check(
            self.order == DepthOrder::Reversed,
            "the order of the maps' depths",
            format!("{:?}", self.order),
            &format!(
                "Reversed, as `{part}` knows no other; choose the depths `nearest` and the filter `pcf`"
            ),
        )
    }

    /// Texels along each map's side.
    pub fn side(&self) -> u32 {
        self.maps.first().map_or(1, |map| map.tile.width)
    }

    /// Adds a depth texture of the nearest depths to `plan`, and the passes that draw them.
    pub fn nearest(&self, target: &str, plan: &mut ShadowPlan) {
        plan.textures.push(self.texture(target, Self::FORMAT));
        let passes = self.maps.iter().map(|map| map.nearest(target, self.order));
        plan.passes.extend(passes.map(Pass::Casters));
    }
}

impl TextureDesc {
    /// A texture of one rectangle and one level, empty at 0.
    pub fn d2(name: &str, format: TextureFormat, [width, height]: [u32; 2]) -> Self {
        Self {
            name: name.to_owned(),
            format,
            width,
            height,
            shape: TextureShape::D2,
            levels: 1,
            empty: 0.0,
        }
    }
}

impl SamplerDesc {
    /// A sampler that compares nothing.
    pub fn new(name: &str, filter: FilterMode) -> Self {
        Self {
            name: name.to_owned(),
            filter,
            compare: None,
        }
    }

    /// The sampler with which the hardware compares depths of this order, and blends four comparisons.
    pub fn comparison(order: DepthOrder) -> Self {
        Self {
            name: Maps::SAMPLER.to_owned(),
            filter: FilterMode::Linear,
            compare: Some(order.nearer()),
        }
    }
}

impl ScreenPass {
    /// A pass of `shader` over `viewport` of the texture `target`, whose own uniform block has these `constants`.
    pub fn new(shader: &str, target: &str, viewport: Viewport, constants: Constants) -> Self {
        Self {
            shader: shader.to_owned(),
            targets: vec![target.into()],
            viewport,
            reads: Reads {
                constants,
                ..Reads::default()
            },
        }
    }
}

impl Viewport {
    /// All of a square of `side` texels.
    pub fn square(side: u32) -> Self {
        Self {
            x: 0,
            y: 0,
            width: side,
            height: side,
        }
    }
}
