//! The shader of the method `basic` on the CPU, in f64: the oracle that its pictures are compared with.
//!
//! The filter is computed the plain way, texel by texel. Expect differences where a GPU rounds:
//! in depth at a shadow's very edge, and in bilinear weights (often 8 bits). Across a cube's edges a
//! bilinear fetch's texels are found by their directions; hardware may choose others at the corners.

use glam::{DMat4, DVec2, DVec3, Mat4};
use umbrage_shadow::{Constants, Lens, Rect, ShadowPlan, Value};

use super::{
    esm::EsmTwin,
    filter::Filter,
    slope::{ASTRAY, Followed, STEEPEST, reach},
};

/// `calc_shadow` for one plan of the method `basic`.
#[derive(Clone, Debug, PartialEq)]
pub struct BasicTwin {
    map: Map,
    size: u32,
    /// The filter's width, texels.
    width: u32,
    /// Whether the depth compared follows the receiver's plane.
    receiver_plane: bool,
    bias: DVec2,
    esm: Option<EsmTwin>,
}

#[derive(Clone, Debug, PartialEq)]
enum Map {
    D2 {
        world_to_map: Mat4,
        plane_to_map: Mat4,
        texel_depth: DVec2,
    },
    Cube {
        light_position: DVec3,
        projection: DVec2,
    },
}

impl BasicTwin {
    /// The shader's twin for `plan`, the filter's `width` (odd, texels), and whether `receiver_bias`
    /// is `plane`. None where the plan is not one of `basic`'s.
    pub fn new(plan: &ShadowPlan, width: u32, receiver_plane: bool) -> Option<Self> {
        let constants = &plan.constants;
        let map = match matrix(constants, "world_to_map") {
            Some(world_to_map) => Map::D2 {
                world_to_map,
                plane_to_map: matrix(constants, "plane_to_map")?,
                texel_depth: pair(constants, "texel_depth")?,
            },
            None => {
                let Value::Vec3(light_position) = constants.get("light_position")? else {
                    return None;
                };
                Map::Cube {
                    light_position: light_position.as_dvec3(),
                    projection: pair(constants, "projection")?,
                }
            }
        };
        let size = plan.textures.first()?.width;
        let esm = EsmTwin::new(plan);
        Some(Self {
            map,
            size,
            width,
            // Exponential maps are sampled for a point.
            receiver_plane: receiver_plane && esm.is_none(),
            bias: pair(constants, "bias")?,
            esm,
        })
    }

    /// The shadow term at `position_ws` (metres, world axes, relative to the camera) on a plane with
    /// the unit `normal` (on the viewer's side; zero where unknown). `depth_at(layer, x, y)` is what the map
    /// holds.
    pub fn calc_shadow(
        &self,
        position_ws: DVec3,
        normal: DVec3,
        depth_at: impl Fn(u32, u32, u32) -> f32,
    ) -> f64 {
        let normal = if self.receiver_plane {
            normal
        } else {
            DVec3::ZERO
        };
        match &self.map {
            Map::D2 {
                world_to_map,
                plane_to_map,
                texel_depth,
            } => {
                let projected = world_to_map.as_dmat4() * position_ws.extend(1.0);
                let at = projected.truncate() / projected.w;
                if !(projected.w > 0.0
                    && (0.0..=1.0).contains(&at.x)
                    && (0.0..=1.0).contains(&at.y))
                {
                    return 1.0;
                }
                let plane = plane_to_map.as_dmat4() * normal.extend(-normal.dot(position_ws));
                let width = texel_depth.x + texel_depth.y * at.z;
                let across = -plane.truncate().truncate() / f64::from(self.size);
                let followed = Followed::new(across, STEEPEST * width, plane.z);
                let to_map = world_to_map.as_dmat4();
                self.filter_2d(at, followed, to_map, |x, y| depth_at(0, x, y))
            }
            Map::Cube {
                light_position,
                projection,
            } => self.filter_cube(position_ws - light_position, normal, *projection, depth_at),
        }
    }

    fn filter_2d(
        &self,
        at: DVec3,
        Followed { slope, aside }: Followed,
        to_map: DMat4,
        depth_at: impl Fn(u32, u32) -> f32,
    ) -> f64 {
        let size = f64::from(self.size);
        let slope_bias = (1.0 + ASTRAY) * slope.abs().element_sum();
        let depth = at.z + self.bias.x + self.bias.y * at.z + slope_bias;
        let filter = Filter {
            width: self.width,
            size: self.size,
        };
        let place = at.truncate() * size + reach(self.width) * aside;
        let place = place.clamp(DVec2::ZERO, DVec2::splat(size));
        if let Some(esm) = &self.esm {
            let to_texels = DMat4::from_scale(DVec3::new(size, size, 1.0)) * to_map;
            return esm.lit(0, filter, (place, depth), to_texels, depth_at);
        }
        filter.lit(place, depth, slope, depth_at)
    }

    fn filter_cube(
        &self,
        offset: DVec3,
        normal: DVec3,
        projection: DVec2,
        depth_at: impl Fn(u32, u32, u32) -> f32,
    ) -> f64 {
        let axis = face_axis(offset);
        let distance = offset.abs().dot(axis);
        if distance <= 0.0 || distance.is_nan() {
            return 1.0;
        }
        let texel = 2.0 / f64::from(self.size);
        let right = DVec3::new(axis.y, axis.z, axis.x);
        let down = DVec3::new(axis.z, axis.x, axis.y);
        // Over its distance from the light, the normal is the whole tilt.
        let height = normal.dot(offset);
        let across = DVec2::new(normal.dot(right), normal.dot(down));
        let Followed { slope, aside } = Followed::new(-across, STEEPEST / distance, -height);
        // The part along the face is the slope that is followed; the rest shrinks in proportion.
        let tilt = if height < 0.0 {
            let followed = (slope.length() * -height / across.length()).min(1.0);
            followed * normal / height
        } else {
            DVec3::ZERO
        };
        let aside = texel * distance * reach(self.width) * (aside.x * right + aside.y * down);
        let middle = 0.5 * f64::from(self.width - 1);
        let mut lit = 0.0;
        for j in 0..self.width {
            for i in 0..self.width {
                let cell = DVec2::new(f64::from(i), f64::from(j)) - middle;
                let across = texel * distance * (cell.x * right + cell.y * down);
                let tap = offset + aside + across;
                let face = face_axis(tap);
                let slope_bias = (1.0 + ASTRAY) * texel * tilt.abs().dot(1.0 - face);
                let inverse = (1.0 + tilt.dot(across)) / tap.abs().dot(face) + slope_bias;
                let depth = projection.x + projection.y * inverse;
                let reference = (depth + self.bias.x + self.bias.y * depth).clamp(0.0, 1.0);
                lit += self.compare_cube(tap, reference, &depth_at);
            }
        }
        lit / f64::from(self.width * self.width)
    }

    /// One bilinear comparison in the direction `tap`.
    fn compare_cube(
        &self,
        tap: DVec3,
        reference: f64,
        depth_at: impl Fn(u32, u32, u32) -> f32,
    ) -> f64 {
        let (lens, _, at) = look_up(tap);
        let place = at * f64::from(self.size) - 0.5;
        let (first, part) = (place.floor(), place - place.floor());
        let mut lit = 0.0;
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let cell = DVec2::new(x, y);
            let weight = (1.0 - cell - part).abs();
            // The direction of the texel's centre, on whichever face it is.
            let place = (first + cell + 0.5) / f64::from(self.size);
            let clip = DVec3::new(2.0 * place.x - 1.0, 1.0 - 2.0 * place.y, 0.5);
            let (_, layer, at) = look_up(lens.inverse().project_point3(clip));
            let texel = (at * f64::from(self.size))
                .clamp(DVec2::ZERO, DVec2::splat(f64::from(self.size) - 1.0));
            if reference >= f64::from(depth_at(layer, texel.x as u32, texel.y as u32)) {
                lit += weight.x * weight.y;
            }
        }
        lit
    }
}

/// The axis of the cube's face that `direction` looks at, without its sign.
fn face_axis(direction: DVec3) -> DVec3 {
    let along = direction.abs();
    if along.x >= along.y.max(along.z) {
        return DVec3::X;
    }
    if along.y >= along.z {
        DVec3::Y
    } else {
        DVec3::Z
    }
}

/// The face that `direction` looks at: its matrix, its layer, and where in it (0..1, v down).
fn look_up(direction: DVec3) -> (DMat4, u32, DVec2) {
    let axis = face_axis(direction);
    let layer =
        2 * axis.dot(DVec3::new(0.0, 1.0, 2.0)) as usize + usize::from(direction.dot(axis) < 0.0);
    // Any depth range will do.
    let matrix = Lens::cube(DVec3::ZERO)[layer].matrix(&Rect::square(1.0), 1.0, 2.0);
    let clip = matrix.project_point3(direction);
    (
        matrix,
        layer as u32,
        DVec2::new(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y),
    )
}

fn matrix(constants: &Constants, name: &str) -> Option<Mat4> {
    match constants.get(name)? {
        Value::Mat4(value) => Some(*value),
        _ => None,
    }
}

fn pair(constants: &Constants, name: &str) -> Option<DVec2> {
    match constants.get(name)? {
        Value::Vec2(value) => Some(value.as_dvec2()),
        _ => None,
    }
}
