//! Midpoint shadow maps (Woo 1992, "The Shadow Depth Map Revisited"): a map holds a depth *inside* what casts, between
//! the nearest face that is turned to the light and the nearest back-facing one. A lit surface then has half of
//! a body's thickness between itself and its own map, whatever the slope and the resolution; and so has what the body
//! stands on, on the other side. Values of the axis `depth`, for any method with tiles and any filter. The shader half
//! is `depths/midpoint.wesl`.
//!
//! # How it works
//! - `midpoint`: one pass without a depth texture (Kayamon 2011, "Single-pass midpoint shadow maps"). Fronts write their
//!   depth into one channel, backs into another, and blending keeps the larger one (reversed depth: the nearest) of
//!   each. A full-screen pass over each tile then makes a depth map of the two, which is read as any other.
//! - `midpoint_sampled`: the same pass, and no depth map: each fetch's four texels are resolved as they are compared.
//! - `midpoint_two_passes`: fronts into one depth map, backs into another, and the full-screen pass. It asks for no
//!   feature of the device, where the others blend 32-bit floats (`float32-blendable`).
//!
//! All three give one picture, up to the weights of a bilinear blend. A mirrored transform turns its triangles' winding; the
//! renderer turns what counts as front with it.
//!
//! # What a map holds
//! With f and b the nearest front and the nearest back along a texel's ray:
//!
//! - Where b is behind f by 2 · `least` or more, there is an inside: the middle of f and b, but no more than `most`
//!   behind f.
//! - Elsewhere the nearer one of the two, whichever it is, moved away from the light by `bias`. So it is for open meshes,
//!   leaves without thickness, faces that are inside out, and all else that has no back. They need a bias, and what they
//!   get is what receivers get with `nearest`: their shadows are the same.
//!
//! So the map holds the bias, and receivers are compared at their own depth, but for what a filter asks of any map: the
//! depth compared follows the receiver's plane, and each fetch's is biased by a texel's slope besides, as in
//! [`crate::methods::basic`].
//!
//! `bias` is the setting `depth_bias`, and what rounding may be. The other two follow from what a surface needs against
//! its own map, in texels' widths:
//!
//! | `receiver_bias` | `least` | `most`, and `bias` at the least |
//! | --- | --- | --- |
//! | `plane` | 1/16, and rounding | 1.5 |
//! | `constant` | `bias` | 19 · (W + 1) / 2 |
//!
//! A plane that is followed needs only room for rounding: a fetch's slope bias is large enough to cover the rasteriser's
//! grid as well (`slope.rs`). For the rest, facets steeper than the plane that is followed, the default `depth_bias` of
//! 1.5 is enough (see [`crate::methods::basic`]). A deeper map would prevent no more acne, but let in light; so no caster
//! is held deeper than `nearest` with its default would have it, and thinner casters are held less deep. Where no plane is
//! followed, only the middle prevents acne on a slope: up to 19 over the (W + 1) / 2 texels that the filter reaches.
//!
//! The middle is taken of depths. Of a directional light they are linear, and it is the middle. Of a spot light depth
//! is A + B / d, and it is the harmonic mean of the distances, 2 d₁ d₂ / (d₁ + d₂): between the two as well, and nearer to
//! the front, by a share of (d₂ − d₁) / (d₂ + d₁) of half the thickness. Reversed depth in f32 is exact to 6e-8 of itself,
//! and half of a sum of two to half a unit in the last place: wherever front and back can be told apart by more than `least`,
//! what is held lies between them.
//!
//! # Cost
//! Per map's texel 12 bytes, or 8 sampled, where `nearest` has 4. `midpoint` draws casters once without early depth
//! tests, all that overlap are blended; two passes draw half of the faces each. Sampling takes two fetches for each
//! one of `nearest`.
//!
//! # Limits
//! The nearest front and the nearest back may be of different bodies. Of closed bodies that is harmless: a body whose
//! back comes before the first body's begins within that, so that the middle lies inside of the first. An open mesh
//! before a closed body is not harmless: the middle of its front and that body's back may lie behind that body's front, which
//! would then be lit in the open mesh's shadow. `most` bounds it: with `plane`, by what the bias of `nearest` does there.
//!
//! Slope bias, by which a receiver follows its plane, takes from the half thickness of a thin body, as it takes from the
//! whole with `nearest`: steep receivers show as much peter-panning with the one as with the other. In the hard case
//! `contact` (2 cm under texels of 8 mm) 0.19 % of the picture is falsely lit, with `nearest` 0.23 %; it would be 0.25 %
//! with middles at any depth, and 0.28 % if they were no less than `bias` deep besides.
//!
//! Under `constant`, a body shades itself where it ends in an edge on the side away from the light: there it is thin.
//! A closed body that is inside out has its back before its front, and is biased as an open one. A hollow of a body
//! that is thinner than its curvature needs under the filter shades itself: model it with one side.
//!
//! Point lights are not supported, nor are lookups of [`crate::methods::pssm`] with a texture for each split.

use glam::{DVec2, Vec2};
use umbrage_shadow::{
    Blend, CasterPass, ColorTarget, Constants, Cull, DepthSource, Frame, MAX_SPLITS, Map, Maps,
    Need, Part, Pass, PlanError, SamplerDesc, ScreenPass, ShadowPlan, Value,
};
use wgpu_types::{ColorWrites, Face, Features, FilterMode, TextureFormat};

/// The binding of the two channels: nearest fronts and nearest backs.
const FACES: &str = "faces";

/// The bindings of the same as two depth maps.
const FRONTS: &str = "front_faces";
const BACKS: &str = "back_faces";

/// Distance between a followed plane and its own map, in texels' widths: room for rounding.
const LEAST: f64 = 1.0 / 16.0;

/// The slope that a middle holds off where no plane is followed: the tangent of 87°.
const STEEPEST: f64 = 19.0;

/// Depth that is enough there for all else: the default `depth_bias`.
const MOST: f64 = 1.5;

/// The depth sources `midpoint`, `midpoint_sampled` and `midpoint_two_passes`: where the middle is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Midpoint {
    /// In a pass over the map, from faces drawn in one pass.
    Resolved,
    /// Where the map is sampled.
    Sampled,
    /// In a pass over the map, from faces drawn in two passes.
    TwoPasses,
}

/// Demands of a filter on a surface's distance to its own middle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Demand {
    /// How far from its middle the filter reads, texels.
    reach: f64,
    /// Whether what is compared follows the receiver's plane.
    plane: bool,
}

impl Demand {
    /// The least that there is to be between a surface and its middle, and the most that is of use, in texels' widths.
    fn bounds(self, bias: f64) -> (f64, f64) {
        let (least, most) = match self.plane {
            true => (LEAST, MOST),
            false => (bias, STEEPEST * self.reach),
        };
        (least, most.max(bias))
    }
}

impl Midpoint {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Resolved, Self::Sampled, Self::TwoPasses];
}

impl Part for Midpoint {
    fn name(&self) -> &str {
        match self {
            Self::Resolved => "midpoint",
            Self::Sampled => "midpoint_sampled",
            Self::TwoPasses => "midpoint_two_passes",
        }
    }
}

impl DepthSource for Midpoint {
    fn holds_bias(&self) -> bool {
        true
    }

    fn fetches(&self) -> u32 {
        match self {
            Self::Resolved | Self::TwoPasses => 1,
            Self::Sampled => 2,
        }
    }

    fn fill(&self, frame: &Frame<'_>, maps: &Maps, plan: &mut ShadowPlan) -> Result<(), PlanError> {
        maps.check_reversed(self.name())?;
        let demand = Demand {
            reach: frame.reach(0)?,
            plane: maps.follows_plane,
        };
        match self {
            Self::Resolved | Self::Sampled => faces(plan, maps),
            Self::TwoPasses => {
                side(plan, maps, FRONTS, Face::Back);
                side(plan, maps, BACKS, Face::Front);
            }
        }
        match self {
            Self::Resolved | Self::TwoPasses => resolve(plan, maps, demand),
            Self::Sampled => sample(plan, maps, demand),
        }
        Ok(())
    }
}

/// The nearest fronts and backs in two channels, in one pass a map.
fn faces(plan: &mut ShadowPlan, maps: &Maps) {
    let format = TextureFormat::Rg32Float;
    plan.textures.push(maps.texture(FACES, format));
    plan.needs.push(Need {
        features: Features::FLOAT32_BLENDABLE,
        instead: "`midpoint_two_passes` on the axis `depth`".to_owned(),
    });
    plan.passes.extend(maps.maps.iter().map(|map| {
        Pass::Casters(CasterPass {
            shader: "caster_faces".to_owned(),
            depth: None,
            colors: vec![ColorTarget {
                target: FACES.into(),
                channels: ColorWrites::RED | ColorWrites::GREEN,
                blend: Blend::Max,
            }],
            cull: Cull::Nothing,
            ..map.nearest(FACES, maps.order)
        })
    }));
}

/// The nearest faces of one side as a depth map.
fn side(plan: &mut ShadowPlan, maps: &Maps, target: &str, cull: Face) {
    let before = plan.passes.len();
    maps.nearest(target, plan);
    for pass in &mut plan.passes[before..] {
        if let Pass::Casters(pass) = pass {
            pass.cull = Cull::Side(cull);
        }
    }
}

/// A depth map of what was drawn.
fn resolve(plan: &mut ShadowPlan, maps: &Maps, demand: Demand) {
    plan.textures
        .push(maps.texture(Maps::BINDING, Maps::FORMAT));
    plan.samplers.push(SamplerDesc::comparison(maps.order));
    plan.passes.extend(maps.maps.iter().map(|map| {
        let margin = Margin::of(map, demand).value();
        let constants = Constants::new().with("margin", margin);
        Pass::Screen(ScreenPass::new(
            "midpoint",
            Maps::BINDING,
            map.tile,
            constants,
        ))
    }));
}

/// Plans maps that are resolved while they are sampled.
fn sample(plan: &mut ShadowPlan, maps: &Maps, demand: Demand) {
    plan.samplers
        .push(SamplerDesc::new("faces_sampler", FilterMode::Nearest));
    let [width, height] = maps.size;
    let tiles = maps.maps.first().map_or(Vec2::ONE, |map| {
        Vec2::new(
            (width / map.tile.width) as f32,
            (height / map.tile.height) as f32,
        )
    });
    let margin = |i: usize| {
        let map = maps.maps.get(i);
        map.map_or(Margin::NONE, |map| Margin::of(map, demand))
            .value()
    };
    let margins = (0..MAX_SPLITS).map(margin).collect();
    plan.constants = std::mem::take(&mut plan.constants)
        .with("midpoint_tiles", Value::Vec2(tiles))
        .with("midpoint_margins", Value::Array(margins));
}

/// How far behind the first surface a map holds it, in texels' widths: the shader's struct of this name.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Margin {
    /// A texel's width as depth is x + y · depth.
    texel: DVec2,
    bias: f64,
    least: f64,
    most: f64,
}

impl Margin {
    /// Where there is no map.
    const NONE: Self = Self {
        texel: DVec2::ZERO,
        bias: 0.0,
        least: 0.0,
        most: 0.0,
    };

    fn of(map: &Map, demand: Demand) -> Self {
        let bias = map.bias;
        let (least, most) = demand.bounds(bias.texels);
        Self {
            texel: bias.texel,
            bias: bias.texels,
            least: least + bias.rounding,
            most,
        }
    }

    fn value(self) -> Value {
        let members = Constants::new()
            .with("texel", Value::Vec2(self.texel.as_vec2()))
            .with("bias", Value::F32(self.bias as f32))
            .with("least", Value::F32(self.least as f32))
            .with("most", Value::F32(self.most as f32));
        Value::Struct(members)
    }
}
