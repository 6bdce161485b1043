//! A light's maps in one texture, and how they are read.
//!
//! Three choices make a method: how maps are fitted (the method's own), which depth they hold (the axis `depth`),
//! and how they are asked about a receiver (the axis `filter`). None knows the others: a method hands a [`Sheet`]
//! to [`Reading::add`], and its shader a place in a tile to `interface::filter`.

use glam::{DMat4, DVec2};
use umbrage_shadow::{
    CasterPass, DepthTarget, Extent, Frame, Lens, LightKind, Pass, PlanError, SamplerDesc,
    ShadowPlan, TextureDesc, TextureShape, Viewport,
};
use wgpu_types::{CompareFunction, FilterMode, TextureFormat};

use crate::{
    esm::{self, Esm},
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
    /// The distances that it holds.
    pub range: Range,
}

/// What a map's depths stand for: distances from the light along its axis, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    /// Depth 1.
    pub near: f64,
    /// Depth 0.
    pub far: f64,
    /// Whether depth is linear in one over the distance, and not in the distance.
    pub perspective: bool,
    /// The width of a texel at the far end.
    pub texel: f64,
}

impl Range {
    /// That of a map of what is `seen`, with `side` texels.
    pub(crate) fn new(lens: &Lens, seen: &Extent, side: u32) -> Self {
        let perspective = lens.is_perspective();
        let spread = if perspective { seen.far } else { 1.0 };
        Self {
            near: seen.near,
            far: seen.far,
            perspective,
            texel: spread * seen.rect.size().max_element() / f64::from(side),
        }
    }

    /// A depth z lies at the share (1 − z) / (1 + ratio · z) of the way from near to far: A + B / d solved for d.
    pub(crate) fn ratio(&self) -> f64 {
        if self.perspective {
            (self.far - self.near) / self.near
        } else {
            0.0
        }
    }
}

/// How maps are read: which depth they hold, and how they are asked.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// The values of the axis `filter`.
#[derive(Clone, Copy)]
enum Asked {
    Bounded(Bounds),
    Esm(esm::Kind),
    Pcf,
}

/// The axis `filter`, with the numbers that belong to its value.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Filter {
    Bounded(Bounds),
    Esm(Esm),
    Pcf,
}

impl Reading {
    const DEPTHS: [(&'static str, Depth); 4] = [
        ("midpoint", Depth::Midpoint(Midpoint::Resolved)),
        ("midpoint_sampled", Depth::Midpoint(Midpoint::Sampled)),
        ("midpoint_two_passes", Depth::Midpoint(Midpoint::TwoPasses)),
        ("nearest", Depth::Nearest),
    ];
    const FILTERS: [(&'static str, Asked); 8] = [
        ("esm", Asked::Esm(esm::Kind::Full)),
        ("esm_half", Asked::Esm(esm::Kind::Half)),
        ("esm_log", Asked::Esm(esm::Kind::Log)),
        ("hpsm", Asked::Bounded(Bounds::Hpsm)),
        ("hpsm_naive", Asked::Bounded(Bounds::HpsmNaive)),
        ("min_max", Asked::Bounded(Bounds::MinMax)),
        ("min_max_tree", Asked::Bounded(Bounds::MinMaxTree)),
        ("pcf", Asked::Pcf),
    ];

    /// That of a frame.
    pub(crate) fn of(frame: &Frame<'_>) -> Result<Self, PlanError> {
        let reading = Self {
            depth: job::choice(frame, "depth", &Self::DEPTHS)?,
            filter: match job::choice(frame, "filter", &Self::FILTERS)? {
                Asked::Bounded(bounds) => Filter::Bounded(bounds),
                Asked::Esm(kind) => Filter::Esm(Esm::of(frame, kind)?),
                Asked::Pcf => Filter::Pcf,
            },
            block: hpsm::block(frame)?,
            width: job::filter_width(frame)?,
            plane: job::axis(frame, "receiver_bias") == "plane",
            taper: false,
        };
        reading.check(frame)?;
        Ok(reading)
    }

    /// Whether it is the plain one: the nearest depths, filtered by comparing them. A method that binds maps in
    /// ways of its own can do no other.
    pub(crate) fn is_plain(self) -> bool {
        self.depth == Depth::Nearest && self.filter == Filter::Pcf
    }

    /// Whether what is chosen goes together.
    fn check(self, frame: &Frame<'_>) -> Result<(), PlanError> {
        let is_cube = matches!(frame.light.kind, LightKind::Point { .. });
        for (axis, plain) in [("depth", "nearest"), ("filter", "pcf")] {
            let value = job::axis(frame, axis);
            PlanError::check(
                value == plain || !is_cube,
                &format!("the axis `{axis}`"),
                value,
                &format!("{plain} under a point light, whose cube map knows no other"),
            )?;
        }
        let sampled = self.depth == Depth::Midpoint(Midpoint::Sampled);
        PlanError::check(
            !sampled || self.filter == Filter::Pcf,
            "the axis `depth`",
            job::axis(frame, "depth"),
            "midpoint or midpoint_two_passes where `filter` is not `pcf`: what computes from a map wants its depths",
        )
    }

    /// By what a receiver's depth in a map is raised before it is compared: x + y · depth.
    pub(crate) fn raise(self, bias: &Bias) -> DVec2 {
        match self.depth {
            // The map itself holds it.
            Depth::Midpoint(_) => DVec2::ZERO,
            Depth::Nearest => bias.raise,
        }
    }

    /// How far a receiver is to be moved towards the light in a map of `side` texels, where `setting` texels are asked for.
    /// An exponential filter needs it only where its window may be cut off by the edge of a small map: see [`crate::esm`].
    pub(crate) fn depth_bias(self, setting: f64, side: u32) -> f64 {
        let is_small = 4.0 * job::margin(self.width) > f64::from(side);
        match self.filter {
            Filter::Esm(_) if !is_small => 0.0,
            _ => setting,
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
            Filter::Esm(esm) => esm.add(plan, sheet, self),
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
            Filter::Esm(esm) => esm.fetches(),
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
