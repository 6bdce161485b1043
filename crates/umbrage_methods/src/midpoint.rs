//! Midpoint shadow maps (Woo 1992, "The Shadow Depth Map Revisited"): a map holds a depth *inside* what casts, between
//! the nearest face that is turned to the light and the nearest that is turned away. What is lit then has half
//! of a body's thickness between itself and its own map, whatever the slope and the resolution; and so has what the body
//! stands on, on the other side. Values of the axis `depth`, for any method with tiles and any filter. The shader half
//! is `methods/midpoint.wesl`; [`MidpointTwin`] is the same rule on the CPU.
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
//! depth compared follows the receiver's plane, and each fetch's leans a texel over it, as in [`crate::basic`].
//!
//! `bias` is the setting `depth_bias`, and what rounding may be. The other two follow from what a surface needs against
//! its own map, in texels' widths:
//!
//! | `receiver_bias` | `least` | `most`, and `bias` at the least |
//! | --- | --- | --- |
//! | `plane` | 1/16, and rounding | 1.5 |
//! | `constant` | `bias` | 19 · (W + 1) / 2 |
//!
//! A plane that is followed needs only room for rounding: a fetch leans far enough to cover the rasteriser's grid as
//! well (`slope.rs`). For the rest, facets steeper than the plane that is followed, the default `depth_bias` of 1.5 is
//! enough (see [`crate::basic`]). A deeper map would prevent no more acne, but let in light; so no caster is held
//! deeper than `nearest` with its default would have it, and thinner casters are held less deep. Where no plane is
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
//! What a receiver is raised by to follow its plane takes from the half thickness of a thin body, as it takes from
//! the whole with `nearest`: steep receivers are as detached with the one as with the other. In the hard case `contact`
//! (2 cm under texels of 8 mm) 0.19 % of the picture is falsely lit, with `nearest` 0.23 %; it would be 0.25 % with
//! middles at any depth, and 0.28 % if they were no less than `bias` deep besides.
//!
//! Under `constant`, a body shades itself where it ends in an edge on the side away from the light: there it is thin.
//! A closed body that is inside out has its back before its front, and is biased as an open one. A hollow of a body
//! that is thinner than its curvature needs under the filter shades itself: model it with one side.
//!
//! Point lights are not supported, nor are lookups of [`crate::pssm`] with a texture for each split.

use glam::{DVec2, Vec2};
use umbrage_shadow::{
    Blend, CasterPass, ColorTarget, Constants, MAX_SPLITS, Pass, Reads, SamplerDesc, ScreenPass,
    ShadowPlan, Value,
};
use wgpu_types::{ColorWrites, Face, Features, FilterMode, TextureFormat};

use crate::maps::{DEPTH, MAP, Map, Sheet, casters, comparison, texture};

/// The binding of the two channels: nearest fronts and nearest backs.
const FACES: &str = "faces";

/// The bindings of the same as two depth maps.
const FRONTS: &str = "front_faces";
const BACKS: &str = "back_faces";

/// Distance between a followed plane and its own map, in texels' widths: room for rounding.
const LEAST: f64 = 1.0 / 16.0;

/// The slope that a middle holds off where no plane is followed: the tangent of 87°.
const STEEPEST: f64 = 19.0;

/// What is enough there for all else: the default `depth_bias`.
const MOST: f64 = 1.5;

/// Where the middle is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Midpoint {
    Resolved,
    Sampled,
    TwoPasses,
}

/// What a filter asks of a surface's distance to its own middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Need {
    /// How far from its middle the filter reads, texels.
    pub reach: f64,
    /// Whether what is compared follows the receiver's plane.
    pub plane: bool,
}

impl Need {
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
    /// Adds to `plan` what fills the maps.
    pub(crate) fn add(self, plan: &mut ShadowPlan, sheet: &Sheet, need: Need) {
        match self {
            Self::Resolved => {
                faces(plan, sheet);
                resolve(plan, sheet, need);
            }
            Self::Sampled => {
                faces(plan, sheet);
                sample(plan, sheet, need);
            }
            Self::TwoPasses => {
                side(plan, sheet, FRONTS, Face::Back);
                side(plan, sheet, BACKS, Face::Front);
                resolve(plan, sheet, need);
            }
        }
    }

    /// Fetches that one comparison takes.
    pub(crate) fn fetches(self) -> u32 {
        match self {
            Self::Resolved | Self::TwoPasses => 1,
            Self::Sampled => 2,
        }
    }
}

/// The nearest fronts and backs in two channels, in one pass a map.
fn faces(plan: &mut ShadowPlan, sheet: &Sheet) {
    let format = TextureFormat::Rg32Float;
    plan.textures.push(texture(FACES, format, sheet.size));
    plan.needs.push(umbrage_shadow::Need {
        features: Features::FLOAT32_BLENDABLE,
        instead: "`midpoint_two_passes` on the axis `depth`".to_owned(),
    });
    plan.passes.extend(sheet.maps.iter().map(|map| {
        Pass::Casters(CasterPass {
            shader: "caster_faces".to_owned(),
            depth: None,
            color: Some(ColorTarget {
                texture: FACES.to_owned(),
                channels: ColorWrites::RED | ColorWrites::GREEN,
                blend: Blend::Max,
            }),
            ..casters(map, FACES)
        })
    }));
}

/// The nearest faces of one side as a depth map.
fn side(plan: &mut ShadowPlan, sheet: &Sheet, target: &str, cull: Face) {
    plan.textures.push(texture(target, DEPTH, sheet.size));
    for (number, map) in sheet.maps.iter().enumerate() {
        let mut pass = casters(map, target);
        pass.cull = Some(cull);
        // The whole texture is cleared once.
        if let Some(depth) = pass.depth.as_mut().filter(|_| number > 0) {
            depth.clear = None;
        }
        plan.passes.push(Pass::Casters(pass));
    }
}

/// A depth map of what was drawn.
fn resolve(plan: &mut ShadowPlan, sheet: &Sheet, need: Need) {
    plan.textures.push(texture(MAP, DEPTH, sheet.size));
    plan.samplers.push(comparison());
    plan.passes.extend(sheet.maps.iter().map(|map| {
        let margin = Margin::of(map, need).value();
        Pass::Screen(ScreenPass {
            shader: "midpoint".to_owned(),
            target: MAP.to_owned(),
            viewport: map.tile,
            reads: Reads {
                constants: Constants::new().with("margin", margin),
                ..Reads::default()
            },
        })
    }));
}

/// What resolves while sampling.
fn sample(plan: &mut ShadowPlan, sheet: &Sheet, need: Need) {
    plan.samplers.push(SamplerDesc {
        name: "faces_sampler".to_owned(),
        filter: FilterMode::Nearest,
        compare: None,
    });
    let [width, height] = sheet.size;
    let tiles = sheet.maps.first().map_or(Vec2::ONE, |map| {
        Vec2::new(
            (width / map.tile.width) as f32,
            (height / map.tile.height) as f32,
        )
    });
    let margin = |i: usize| {
        let map = sheet.maps.get(i);
        map.map_or(Margin::NONE, |map| Margin::of(map, need))
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

    fn of(map: &Map, need: Need) -> Self {
        let bias = map.bias;
        let (least, most) = need.bounds(bias.texels);
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

/// What a map holds, on the CPU: an oracle's rule, in the terms of its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MidpointTwin {
    /// The setting `depth_bias`, texels.
    pub depth_bias: f64,
    /// The filter's width, texels.
    pub width: u32,
    /// Whether `receiver_bias` is `plane`.
    pub receiver_plane: bool,
}

impl MidpointTwin {
    /// The depth (reversed, 0..1) that a texel holds where the nearest face turned to the light is at the depth `front`
    /// and the nearest one turned away at `back`, 0 for none. `texel` is a texel's width, as depth, about a depth. What
    /// rounding may be is left out.
    pub fn depth(self, front: f64, back: f64, texel: impl Fn(f64) -> f64) -> f64 {
        let need = Need {
            reach: 0.5 * f64::from(self.width) + 0.5,
            plane: self.receiver_plane,
        };
        let (least, most) = need.bounds(self.depth_bias);
        let first = front.max(back);
        let width = texel(first);
        let room = 0.5 * (front - back);
        let behind = if back > 0.0 && room >= least * width {
            room.min(most * width)
        } else {
            self.depth_bias * width
        };
        (first - behind).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Texels of 1 cm over 10 m: a thousandth of the depth each.
    const TEXEL: f64 = 0.001;

    fn twin(receiver_plane: bool) -> MidpointTwin {
        MidpointTwin {
            depth_bias: 1.5,
            width: 3,
            receiver_plane,
        }
    }

    /// How many texels behind the nearer of a front and a back the map holds it.
    fn behind(twin: MidpointTwin, front: f64, back: f64) -> f64 {
        (front.max(back) - twin.depth(front, back, |_| TEXEL)) / TEXEL
    }

    fn assert_behind(twin: MidpointTwin, [front, back]: [f64; 2], expected: f64) {
        let found = behind(twin, front, back);
        assert!((found - expected).abs() < 1e-9, "{found} texels");
    }

    #[test]
    fn the_middle_of_a_body_is_held_but_no_deeper_than_is_of_use() {
        // 1 texel, then 2 and 100: as deep as the default bias.
        assert_behind(twin(true), [0.8, 0.799], 0.5);
        assert_behind(twin(true), [0.8, 0.798], 1.0);
        assert_behind(twin(true), [0.8, 0.7], 1.5);
        // Without the receiver's plane, half of 100, and 19 times the reach of 2.
        assert_behind(twin(false), [0.8, 0.75], 25.0);
        assert_behind(twin(false), [0.8, 0.1], 38.0);
        // A larger bias is for bodies as well.
        let biased = MidpointTwin {
            depth_bias: 4.0,
            ..twin(true)
        };
        assert_behind(biased, [0.8, 0.7], 4.0);
        // Without any, a body keeps its middle, and an open mesh has none.
        let unbiased = MidpointTwin {
            depth_bias: 0.0,
            ..twin(true)
        };
        assert_behind(unbiased, [0.8, 0.7], 1.5);
        assert_behind(unbiased, [0.8, 0.0], 0.0);
    }

    #[test]
    fn what_has_no_inside_is_biased() {
        for twin in [twin(true), twin(false)] {
            // No back; no front; the back before the front; both at once, and nearly so.
            for sides in [
                [0.8, 0.0],
                [0.0, 0.8],
                [0.7, 0.8],
                [0.8, 0.8],
                [0.8, 0.79999],
            ] {
                assert_behind(twin, sides, 1.5);
            }
        }
        // Thinner than the bias: a middle only where the plane is followed.
        assert_behind(twin(false), [0.8, 0.7975], 1.5);
        assert_behind(twin(true), [0.8, 0.7975], 1.25);
    }

    #[test]
    fn nothing_is_held_where_nothing_is_and_nothing_beyond_the_far_end() {
        assert_eq!(twin(true).depth(0.0, 0.0, |_| TEXEL), 0.0);
        assert_eq!(twin(true).depth(0.001, 0.0, |_| TEXEL), 0.0);
    }

    /// Depth is A + B / d: the middle is the harmonic mean, between both and nearer to the front.
    #[test]
    fn under_a_spot_light_the_middle_lies_between() {
        let (near, far) = (0.1, 20.0);
        let depth = |d: f64| (near / d * far - near) / (far - near);
        let distance = |depth: f64| near * far / (depth * (far - near) + near);
        for (front, back) in [(0.2, 0.21), (1.0, 1.5), (2.0, 19.0)] {
            let unbiased = MidpointTwin {
                depth_bias: 0.0,
                ..twin(false)
            };
            let middle = distance(unbiased.depth(depth(front), depth(back), |_| 1.0));
            let harmonic = 2.0 * front * back / (front + back);
            assert!((middle - harmonic).abs() < 1e-9, "{middle}");
            assert!(front < middle && middle < 0.5 * (front + back));
        }
    }

    /// A plate under a table: the farthest surface in the place of the second would light it.
    #[test]
    fn the_farthest_surface_is_not_the_second() {
        let [top, underside, plate, floor] = [0.9, 0.89, 0.7, 0.1];
        let held = |back| twin(false).depth(top, back, |_| 0.01);
        assert!(held(underside) > plate, "in shadow");
        assert!(held(floor) < plate, "lit: what (depth, −depth) would find");
    }
}
