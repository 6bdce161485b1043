//! The shader of the method `pssm` on the CPU, in f64, whatever its lookup: the oracle that all of them are
//! compared with.
//!
//! Where a split's map is, it takes from the passes that draw the maps, not from what the shader reads; only
//! the bias is the shader's own number. The filter is the one of [`BasicTwin`](super::BasicTwin).

use glam::{DMat4, DVec2, DVec3, DVec4};
use umbrage_shadow::{Constants, Pass, ShadowPlan, Value};

use super::{
    esm::EsmTwin,
    filter::Filter,
    slope::{ASTRAY, Followed, STEEPEST, reach},
};

/// `calc_shadow` for one plan of the method `pssm`.
#[derive(Clone, Debug, PartialEq)]
pub struct PssmTwin {
    splits: Vec<Split>,
    forward: DVec3,
    /// The filter's width in the first split's map, texels.
    width: u32,
    receiver_plane: bool,
    choice: Choice,
    esm: Option<EsmTwin>,
}

/// Choices for the method besides its filter.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The axis `lookup`.
    pub lookup: String,
    /// Whether the axis `taper` is on.
    pub taper: bool,
    /// The axis `transition`.
    pub transition: String,
    /// The axis `depth`.
    pub depth: String,
    /// The setting `band`.
    pub band: f64,
}

#[derive(Clone, Debug, PartialEq)]
struct Split {
    depths: [f64; 2],
    view_proj: DMat4,
    size: u32,
    bias: DVec2,
}

/// Where a point lies in a split's map: texels, depth, and how its plane is followed there; and the way there.
struct Place {
    to_map: DMat4,
    at: DVec3,
    followed: Followed,
}

impl PssmTwin {
    /// The shader's twin for `plan`, the filter's `width` (odd, texels), whether `receiver_bias` is `plane`, and
    /// what else was chosen. None where the plan is not one of `pssm`'s.
    pub fn new(
        plan: &ShadowPlan,
        width: u32,
        receiver_plane: bool,
        choice: Choice,
    ) -> Option<Self> {
        let Value::Array(crops) = plan.constants.get("crops")? else {
            return None;
        };
        let Value::Vec3(forward) = plan.constants.get("forward")? else {
            return None;
        };
        let drawn = plan.passes.iter().filter_map(|pass| match pass {
            Pass::Casters(pass) => Some(pass),
            _ => None,
        });
        // A map's contents may take several passes, the first of all maps first.
        let mut drawn: Vec<_> = drawn.collect();
        let first = drawn.first().map(|pass| pass.receivers)?;
        let again = drawn
            .iter()
            .skip(1)
            .position(|pass| pass.receivers == first);
        drawn.truncate(again.map_or(drawn.len(), |number| number + 1));
        let splits = drawn.into_iter().zip(crops).map(|(pass, crop)| {
            let Value::Struct(crop) = crop else {
                return None;
            };
            Some(Split {
                depths: pass.receivers?,
                view_proj: pass.view_proj.as_dmat4(),
                size: pass.viewport.width,
                bias: bias(crop)?,
            })
        });
        let esm = EsmTwin::new(plan);
        Some(Self {
            splits: splits.collect::<Option<_>>()?,
            forward: forward.as_dvec3(),
            width,
            // Exponential maps are sampled for a point.
            receiver_plane: receiver_plane && esm.is_none(),
            choice,
            esm,
        })
    }

    /// The least and the greatest shadow term at `position_ws` (metres, world axes, relative to the camera) on a
    /// plane with the unit `normal` (on the viewer's side; zero where unknown): they differ where noise decides.
    /// `depth_at(pass, x, y)` is what the map of a pass of the plan holds, counted from its viewport's corner.
    pub fn calc_shadow(
        &self,
        position_ws: DVec3,
        normal: DVec3,
        depth_at: impl Fn(usize, u32, u32) -> f32,
    ) -> [f64; 2] {
        let Some((split, share)) = self.split(position_ws) else {
            return [1.0; 2];
        };
        let lit = |split| self.lit(split, position_ws, normal, &depth_at);
        let near = lit(split);
        if share == 0.0 {
            return [near; 2];
        }
        let far = lit(split + 1);
        if self.choice.transition == "blend" {
            return [near + (far - near) * share; 2];
        }
        [near.min(far), near.max(far)]
    }

    /// The least and the most fetches that the shader makes at `position_ws`: they may differ where noise decides.
    pub fn fetches(&self, position_ws: DVec3) -> [u32; 2] {
        let Some((split, share)) = self.split(position_ws) else {
            return [0; 2];
        };
        let near = self.fetches_of(split, position_ws);
        if share == 0.0 {
            return [near; 2];
        }
        let far = self.fetches_of(split + 1, position_ws);
        if self.choice.transition == "blend" {
            return [near + far; 2];
        }
        [near.min(far), near.max(far)]
    }

    fn fetches_of(&self, number: usize, position_ws: DVec3) -> u32 {
        let inside = |number: usize| {
            let place = self.splits[number].place(position_ws, DVec3::ZERO);
            u32::from(place.is_some())
        };
        let comparison = match self.choice.depth.as_str() {
            "midpoint_sampled" => 2,
            _ => 1,
        };
        let each = |number| match &self.esm {
            Some(esm) => esm.fetches,
            None => self.width_of(number).div_ceil(2).pow(2) * comparison,
        };
        let filter = |number| inside(number) * each(number);
        match self.choice.lookup.as_str() {
            "matrix_texture" => 5 + filter(number),
            "weights" => (0..self.splits.len()).map(filter).sum(),
            "channels" => inside(number) * (self.width_of(number) + 1).pow(2),
            _ => filter(number),
        }
    }

    /// The width in texels of the filter in a split's map: two less than in the one before, if at all.
    fn width_of(&self, number: usize) -> u32 {
        let narrower = 2 * number as u32 * u32::from(self.choice.taper);
        self.width.saturating_sub(narrower).max(1)
    }

    /// The split that holds the point, and how far into its band the point is; none beyond the last one.
    pub fn split(&self, position_ws: DVec3) -> Option<(usize, f64)> {
        let depth = self.forward.dot(position_ws);
        let number = self.splits.iter().position(|s| depth < s.depths[1])?;
        let [start, end] = self.splits[number].depths;
        let next = self.splits.get(number + 1);
        let passes = self.choice.transition != "hard" && next.is_some_and(|n| n.depths[0] == end);
        let length = self.choice.band * (end - start);
        let share = (depth - (end - length)) / length;
        Some((number, if passes { share.max(0.0) } else { 0.0 }))
    }

    fn lit(
        &self,
        number: usize,
        position_ws: DVec3,
        normal: DVec3,
        depth_at: impl Fn(usize, u32, u32) -> f32,
    ) -> f64 {
        let split = &self.splits[number];
        let normal = if self.receiver_plane {
            normal
        } else {
            DVec3::ZERO
        };
        let Some(Place {
            to_map,
            at,
            followed: Followed { slope, aside },
        }) = split.place(position_ws, normal)
        else {
            return 1.0;
        };
        let slope_bias = (1.0 + ASTRAY) * slope.abs().element_sum();
        let depth = at.z + split.bias.x + split.bias.y * at.z + slope_bias;
        let filter = Filter {
            width: self.width_of(number),
            size: split.size,
        };
        let depth_at = |x, y| depth_at(number, x, y);
        let place = at.truncate() + reach(filter.width) * aside;
        let place = place.clamp(DVec2::ZERO, DVec2::splat(f64::from(split.size)));
        if let Some(esm) = &self.esm {
            return esm.lit(number, filter, (place, depth), to_map, depth_at);
        }
        filter.lit(place, depth, slope, depth_at)
    }
}

impl Split {
    /// Where a point lies in the map, if it does.
    fn place(&self, position_ws: DVec3, normal: DVec3) -> Option<Place> {
        let size = f64::from(self.size);
        let texture = DMat4::from_cols(
            DVec4::new(0.5 * size, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -0.5 * size, 0.0, 0.0),
            DVec4::Z,
            DVec4::new(0.5 * size, 0.5 * size, 0.0, 1.0),
        );
        let to_map = texture * self.view_proj;
        let projected = to_map * position_ws.extend(1.0);
        let at = projected.truncate() / projected.w;
        let inside = |along: f64| (0.0..=size).contains(&along);
        if !(projected.w > 0.0 && inside(at.x) && inside(at.y)) {
            return None;
        }
        let plane = to_map.inverse().transpose() * normal.extend(-normal.dot(position_ws));
        // How far a step of a texel's width towards the light is, as depth: the map's axes in the world.
        let step = |axis: DVec3| {
            to_map.inverse().project_point3(at + axis) - to_map.inverse().project_point3(at)
        };
        let width = step(DVec3::X).length().max(step(DVec3::Y).length());
        // Along the light's axis: of a spot light, w grows with the distance.
        let (depth, w) = (to_map.row(2).truncate(), to_map.row(3).truncate());
        let axis = if w == DVec3::ZERO { depth } else { w };
        let deep = step(DVec3::Z * 1e-7).dot(axis.normalize()).abs() / 1e-7;
        let across = -plane.truncate().truncate();
        let followed = Followed::new(across, STEEPEST * width / deep, plane.z);
        Some(Place {
            to_map,
            at,
            followed,
        })
    }
}

/// A receiver's bias in depth, as the shader reads it.
fn bias(crop: &Constants) -> Option<DVec2> {
    match crop.get("depth")? {
        Value::Vec4(depth) => Some(DVec2::new(depth.z.into(), depth.w.into())),
        _ => None,
    }
}
