//! A light's maps in one texture, and how they are read.
//!
//! Three choices make a method: how maps are fitted (the method's own), which depth they hold (the axis `depth`),
//! and how they are asked about a receiver (the axis `filter`). None knows the others: a method hands a [`Sheet`]
//! to [`Reading::add`], and its shader a place in a tile to `interface::filter`.

use glam::{DMat4, DVec2};
use umbrage_shadow::{
    CasterPass, DepthTarget, Frame, Pass, PlanError, SamplerDesc, ShadowPlan, TextureDesc,
    TextureShape, Viewport,
};
use wgpu_types::{CompareFunction, FilterMode, TextureFormat};

use crate::{
    hpsm::{self, Bounds},
    job::{self, Bias},
    midpoint::{Midpoint, Need},
};

/// The binding of the texture that holds the maps' depths.
pub(crate) const MAP: &str = "shadow_map";

/// The format of depths.
pub(crate) const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// A light's maps, in one texture.
pub(crate) struct Sheet {
    /// Texels across and down the texture.
    pub size: [u32; 2],
    /// The maps: tiles of one size, from the left, then from the top.
    pub maps: Vec<Map>,
}

impl Sheet {
    /// The least that a shader can bind, where there is no map.
    pub(crate) fn empty() -> Self {
        Self {
            size: [1, 1],
            maps: Vec::new(),
        }
    }
}

/// One map.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Map {
    /// Where it lies in the texture.
    pub tile: Viewport,
    /// World (camera-relative) to clip space.
    pub view_proj: DMat4,
    /// What is drawn into it.
    pub casters: Vec<usize>,
    /// The view depths that it is read for: see [`CasterPass::receivers`].
    pub receivers: Option<[f64; 2]>,
    /// What keeps its receivers from shading themselves.
    pub bias: Bias,
}

/// How maps are read: which depth they hold, and how they are asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reading {
    depth: Depth,
    filter: Filter,
    /// The filter's width in the first map, texels: the axis `pcf`.
    pub width: u32,
    /// The side of a block, texels: the axis `block`.
    block: u32,
    /// Whether what is compared follows the receiver's plane: the axis `receiver_bias`.
    plane: bool,
    /// Whether it is two texels less from map to map.
    pub taper: bool,
}

/// The axis `depth`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Depth {
    Midpoint(Midpoint),
    Nearest,
}

/// The axis `filter`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Filter {
    Bounded(Bounds),
    Pcf,
}

impl Reading {
    const DEPTHS: [(&'static str, Depth); 4] = [
        ("midpoint", Depth::Midpoint(Midpoint::Resolved)),
        ("midpoint_sampled", Depth::Midpoint(Midpoint::Sampled)),
        ("midpoint_two_passes", Depth::Midpoint(Midpoint::TwoPasses)),
        ("nearest", Depth::Nearest),
    ];
    const FILTERS: [(&'static str, Filter); 5] = [
        ("hpsm", Filter::Bounded(Bounds::Hpsm)),
        ("hpsm_naive", Filter::Bounded(Bounds::HpsmNaive)),
        ("min_max", Filter::Bounded(Bounds::MinMax)),
        ("min_max_tree", Filter::Bounded(Bounds::MinMaxTree)),
        ("pcf", Filter::Pcf),
    ];

    /// That of a frame.
    pub(crate) fn of(frame: &Frame<'_>) -> Result<Self, PlanError> {
        let depth = job::choice(frame, "depth", &Self::DEPTHS)?;
        let filter = job::choice(frame, "filter", &Self::FILTERS)?;
        let sampled = depth == Depth::Midpoint(Midpoint::Sampled);
        PlanError::check(
            !(sampled && matches!(filter, Filter::Bounded(_))),
            "the axis `filter`",
            name_of(filter, &Self::FILTERS),
            "pcf where `depth` is `midpoint_sampled`, of which no map is made that could be bounded; or choose `midpoint`",
        )?;
        Ok(Self {
            depth,
            filter,
            block: hpsm::block(frame)?,
            width: job::filter_width(frame)?,
            plane: job::axis(frame, "receiver_bias") == "plane",
            taper: false,
        })
    }

    /// Whether it is the plain one: the nearest depths, filtered by comparing them. A method that binds maps in
    /// ways of its own can do no other.
    pub(crate) fn is_plain(self) -> bool {
        self.depth == Depth::Nearest && self.filter == Filter::Pcf
    }

    /// Whether a cube map can be read so.
    pub(crate) fn check_cube(self) -> Result<(), PlanError> {
        let depth = name_of(self.depth, &Self::DEPTHS);
        let filter = name_of(self.filter, &Self::FILTERS);
        for (axis, plain, value) in [("depth", "nearest", depth), ("filter", "pcf", filter)] {
            PlanError::check(
                value == plain,
                &format!("the axis `{axis}`"),
                value,
                &format!("{plain} under a point light, whose cube map knows no other"),
            )?;
        }
        Ok(())
    }

    /// By what a receiver's depth in a map is raised before it is compared: x + y · depth.
    pub(crate) fn raise(self, bias: &Bias) -> DVec2 {
        match self.depth {
            // The map itself holds it.
            Depth::Midpoint(_) => DVec2::ZERO,
            Depth::Nearest => bias.raise,
        }
    }

    /// Adds to `plan` what fills the maps, and what the filter reads.
    pub(crate) fn add(self, plan: &mut ShadowPlan, sheet: &Sheet) {
        match self.depth {
            Depth::Midpoint(midpoint) => midpoint.add(plan, sheet, self.need()),
            Depth::Nearest => nearest(plan, sheet),
        }
        match self.filter {
            Filter::Bounded(bounds) => bounds.add(plan, sheet, self.width, self.block),
            Filter::Pcf => {}
        }
        plan.fetches_per_pixel += self.fetches(0);
        plan.filter_radius = 0.5 * f64::from(self.width) + 0.5;
    }

    /// The filter's width in a map, texels, by the map's number.
    pub(crate) fn width_of(self, map: usize) -> u32 {
        let narrower = if self.taper { 2 * map as u32 } else { 0 };
        self.width.saturating_sub(narrower).max(1)
    }

    /// The most fetches that one question to a map takes, by the map's number.
    pub(crate) fn fetches(self, map: usize) -> u32 {
        let pcf = self.width_of(map).div_ceil(2).pow(2) * self.fetches_a_comparison();
        match self.filter {
            // The bounds are those of the widest filter.
            Filter::Bounded(bounds) => bounds.fetches(self.width, self.block) + pcf,
            Filter::Pcf => pcf,
        }
    }

    fn fetches_a_comparison(self) -> u32 {
        match self.depth {
            Depth::Midpoint(midpoint) => midpoint.fetches(),
            Depth::Nearest => 1,
        }
    }

    /// How far a surface has to be behind its own middle.
    fn need(self) -> Need {
        Need {
            reach: 0.5 * f64::from(self.width) + 0.5,
            plane: self.plane,
        }
    }
}

/// What a choice is called.
fn name_of<T: PartialEq>(choice: T, known: &[(&'static str, T)]) -> &'static str {
    let found = known.iter().find(|(_, known)| *known == choice);
    found.map_or("unknown", |(name, _)| *name)
}

/// The nearest depths, and the hardware's comparison.
fn nearest(plan: &mut ShadowPlan, sheet: &Sheet) {
    plan.textures.push(texture(MAP, DEPTH, sheet.size));
    plan.samplers.push(comparison());
    for (number, map) in sheet.maps.iter().enumerate() {
        let mut pass = casters(map, MAP);
        // The whole texture is cleared once.
        if let Some(depth) = pass.depth.as_mut().filter(|_| number > 0) {
            depth.clear = None;
        }
        plan.passes.push(Pass::Casters(pass));
    }
}

/// The pass that draws the nearest depths of `map` into `target`, which it clears.
///
/// Both sides of each triangle are drawn: a mesh may be open, a leaf without thickness, a transform a mirror.
pub(crate) fn casters(map: &Map, target: &str) -> CasterPass {
    CasterPass {
        shader: "caster".to_owned(),
        depth: Some(DepthTarget::nearest(target)),
        color: None,
        viewport: map.tile,
        cull: None,
        view_proj: map.view_proj.as_mat4(),
        casters: map.casters.clone(),
        receivers: map.receivers,
    }
}

/// The sampler with which the hardware compares depths.
pub(crate) fn comparison() -> SamplerDesc {
    SamplerDesc {
        name: "shadow_sampler".to_owned(),
        filter: FilterMode::Linear,
        compare: Some(CompareFunction::GreaterEqual),
    }
}

/// A texture of one rectangle.
pub(crate) fn texture(name: &str, format: TextureFormat, [width, height]: [u32; 2]) -> TextureDesc {
    TextureDesc {
        name: name.to_owned(),
        format,
        width,
        height,
        shape: TextureShape::D2,
    }
}

/// All of a square of `side` texels.
pub(crate) fn whole(side: u32) -> Viewport {
    Viewport {
        x: 0,
        y: 0,
        width: side,
        height: side,
    }
}
