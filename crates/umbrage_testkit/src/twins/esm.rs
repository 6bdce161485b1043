//! The shader of the exponential filters on the CPU, in f64, from the depths of a map: whatever its values hold, full floats, half ones
//! or logarithms, they stand for the same mean.
//!
//! The kernel is that of percentage-closer filtering of the same width. How far a depth lies along the map's range is
//! found by the matrix that drew it, not by the shader's formula.

use glam::{DMat4, DVec2, DVec3};
use umbrage_shadow::{ShadowPlan, Value};

use super::filter::Filter;

/// How the maps of a plan are sampled.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EsmTwin {
    /// Of each map.
    exponents: Vec<f64>,
    /// Fetches of one lookup.
    pub fetches: u32,
}

impl EsmTwin {
    /// The twin of `plan`; none where it has no exponential maps.
    pub(super) fn new(plan: &ShadowPlan) -> Option<Self> {
        let Value::Array(tiles) = plan.constants.get("esm_tiles")? else {
            return None;
        };
        let exponent = |tile: &Value| match tile {
            Value::Struct(members) => match members.get("exponent")? {
                Value::F32(exponent) => Some(f64::from(*exponent)),
                _ => None,
            },
            _ => None,
        };
        let filters = plan.samplers.iter().any(|s| s.name == "esm_sampler");
        Some(Self {
            exponents: tiles.iter().map(exponent).collect::<Option<_>>()?,
            fetches: if filters { 1 } else { 4 },
        })
    }

    /// The share of the light that passes about `at` (texels) in the map `number` for a receiver at `depth`. `to_map`
    /// takes positions to places and depths in the map; `depth_at` is what the map holds.
    pub(super) fn lit(
        &self,
        number: usize,
        filter: Filter,
        (at, depth): (DVec2, f64),
        to_map: DMat4,
        depth_at: impl Fn(u32, u32) -> f32,
    ) -> f64 {
        let exponent = self.exponents[number];
        let range = Range::new(to_map, at);
        let receiver = range.share(depth.clamp(0.0, 1.0));
        let above = |x: u32, y: u32| {
            let depth = f64::from(depth_at(x, y));
            let count = if depth == 0.0 { 2.0 } else { 1.0 };
            count * (exponent * (range.share(depth) - receiver)).exp()
        };
        // A fetch stays within the map.
        let inside = at.clamp(
            DVec2::splat(0.5),
            DVec2::splat(f64::from(filter.size) - 0.5),
        );
        let mean = filter.mean(inside, above);
        mean.min(1.0)
    }
}

/// The distances between a map's near and far end, along one ray.
struct Range {
    to_world: DMat4,
    at: DVec2,
    near: DVec3,
    length: f64,
}

impl Range {
    fn new(to_map: DMat4, at: DVec2) -> Self {
        let to_world = to_map.inverse();
        let [near, far] = [1.0, 0.0].map(|depth| to_world.project_point3(at.extend(depth)));
        Self {
            to_world,
            at,
            near,
            length: near.distance(far),
        }
    }

    /// How far from the near end to the far one a depth lies: along a ray, distances are in one proportion to those along
    /// the light's axis.
    fn share(&self, depth: f64) -> f64 {
        let there = self.to_world.project_point3(self.at.extend(depth));
        there.distance(self.near) / self.length
    }
}
