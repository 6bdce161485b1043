//! How a light projects.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use crate::Aabb;

/// How a light projects, before its map's rectangle and range of depths are known: a fitted map is
/// [`matrix`](Self::matrix) of these.
///
/// Positions are taken relative to any one origin: the camera's position, to keep f32 matrices exact
/// far from the world's.
#[derive(Clone, Debug, PartialEq)]
pub struct Lens {
    /// Rows: x and y across the map, distance from the light along its axis (metres), and the w by
    /// which x and y are divided.
    to_light: DMat4,
    perspective: bool,
}

/// A rectangle in a lens's plane: metres of a directional light, metres at 1 m from others. y points
/// up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// The lower left corner.
    pub min: DVec2,
    /// The upper right corner.
    pub max: DVec2,
}

/// Directions that each face of WebGPU's cube map takes as u and as v (Vulkan specification, "Cube Map Face
/// Selection"; v points down), and its axis. The faces are seen from inside, mirrored: turned by no
/// rotation into one another's camera.
const CUBE_FACES: [[DVec3; 3]; 6] = [
    [DVec3::NEG_Z, DVec3::NEG_Y, DVec3::X],
    [DVec3::Z, DVec3::NEG_Y, DVec3::NEG_X],
    [DVec3::X, DVec3::Z, DVec3::Y],
    [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y],
    [DVec3::X, DVec3::NEG_Y, DVec3::Z],
    [DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z],
];

impl Lens {
    /// A light that shines along `direction` (unit) from infinitely far away.
    pub fn directional(direction: DVec3) -> Self {
        let axes = light_basis(direction);
        let to_light = from_rows(
            axes.x_axis.extend(0.0),
            axes.y_axis.extend(0.0),
            (-axes.z_axis).extend(0.0),
            DVec4::W,
        );
        Self {
            to_light,
            perspective: false,
        }
    }

    /// A light at `position` that shines along `direction` (unit).
    pub fn spot(position: DVec3, direction: DVec3) -> Self {
        let axes = light_basis(direction);
        Self::at(position, axes.x_axis, axes.y_axis, -axes.z_axis)
    }

    /// The faces of a cube map about `position` (+x, −x, +y, −y, +z, −z), in WebGPU's orientation: what
    /// is drawn through them is where a cube lookup with (point − `position`) finds it. Each face is
    /// the rectangle −1..1.
    pub fn cube(position: DVec3) -> [Self; 6] {
        CUBE_FACES.map(|[u, v, axis]| Self::at(position, u, -v, axis))
    }

    fn at(position: DVec3, right: DVec3, up: DVec3, forward: DVec3) -> Self {
        let row = |axis: DVec3| axis.extend(-axis.dot(position));
        let to_light = from_rows(row(right), row(up), row(forward), row(forward));
        Self {
            to_light,
            perspective: true,
        }
    }

    /// Where `point` lies in the lens's plane (see [`Rect`]), and its distance from the light along
    /// the axis, metres; of a directional light, from the plane through the origin. A perspective
    /// lens wants a distance above 0.
    pub fn place(&self, point: DVec3) -> (DVec2, f64) {
        let at = self.to_light * point.extend(1.0);
        (at.truncate().truncate() / at.w, at.z)
    }

    /// Bounds of where the points of a box lie: x and y as [`place`](Self::place) has them, z the distance; none where
    /// some of it is not in front of a light with a perspective.
    pub fn bound(&self, aabb: &Aabb) -> Option<Aabb> {
        let linear = aabb.transform(&self.to_light);
        if !self.perspective {
            return Some(linear);
        }
        if linear.min.z > 0.0 {
            let place = |corner| {
                let (at, distance) = self.place(corner);
                at.extend(distance)
            };
            return Aabb::from_points(aabb.corners().map(place));
        }
        None
    }

    /// A + B · distance (directional) or A + B / distance is the depth at a distance (metres) from
    /// the light: 1 at `near`, 0 at `far`. Gives (A, B).
    pub fn depth_terms(&self, near: f64, far: f64) -> DVec2 {
        let span = far - near;
        if self.perspective {
            DVec2::new(-near / span, near * far / span)
        } else {
            DVec2::new(far / span, -1.0 / span)
        }
    }

    /// From positions to the space in which a crop is a scale and an offset, so that maps of parts of the
    /// plane and of distances share one matrix: x / w and y / w are the [`place`](Self::place), z / w is a depth
    /// that grows towards the light, minus the distance (directional, metres) or one over the distance. The
    /// depth of [`depth_terms`](Self::depth_terms) (A, B) is A − B · z / w or A + B · z / w.
    pub fn base(&self) -> DMat4 {
        let [x, y, distance, w] = [0, 1, 2, 3].map(|i| self.to_light.row(i));
        let depth = if self.perspective {
            DVec4::W
        } else {
            -distance
        };
        from_rows(x, y, depth, w)
    }

    /// Whether places are divided by the distance.
    pub fn is_perspective(&self) -> bool {
        self.perspective
    }

    /// From positions to the clip space of the map that holds `rect` and the distances from `near`
    /// to `far` (metres).
    pub fn matrix(&self, rect: &Rect, near: f64, far: f64) -> DMat4 {
        let [x, y, distance, w] = [0, 1, 2, 3].map(|i| self.to_light.row(i));
        // The crop comes before the division by w, so its offset is multiplied by w.
        let scale = 2.0 / rect.size();
        let offset = -(rect.min + rect.max) / rect.size();
        let terms = self.depth_terms(near, far);
        let depth = if self.perspective {
            terms.x * distance + terms.y * DVec4::W
        } else {
            terms.x * DVec4::W + terms.y * distance
        };
        from_rows(
            x * scale.x + w * offset.x,
            y * scale.y + w * offset.y,
            depth,
            w,
        )
    }
}

impl Rect {
    /// The square of `half` to each side of the axis.
    pub fn square(half: f64) -> Self {
        Self {
            min: DVec2::splat(-half),
            max: DVec2::splat(half),
        }
    }

    /// The rectangle of the places in `bound`: see [`Lens::bound`].
    pub fn of(bound: &Aabb) -> Self {
        Self {
            min: bound.min.truncate(),
            max: bound.max.truncate(),
        }
    }

    /// The smallest rectangle around `points`; none where there is no point.
    pub fn from_points(points: impl IntoIterator<Item = DVec2>) -> Option<Self> {
        points
            .into_iter()
            .map(|p| Self { min: p, max: p })
            .reduce(|a, b| Self {
                min: a.min.min(b.min),
                max: a.max.max(b.max),
            })
    }

    /// The part that lies in both; none where they are apart.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let both = Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        };
        both.min.cmple(both.max).all().then_some(both)
    }

    /// Width and height.
    pub fn size(&self) -> DVec2 {
        self.max - self.min
    }

    /// The rectangle about the same middle with this `size`.
    pub fn resized(&self, size: DVec2) -> Self {
        let middle = 0.5 * (self.min + self.max);
        Self {
            min: middle - 0.5 * size,
            max: middle + 0.5 * size,
        }
    }
}

/// Right-handed unit axes for a light that shines along `direction` (unit): its right, its up, and
/// backwards, against the light. Duff et al. 2017, "Building an orthonormal basis, revisited", with y
/// in z's place: no up vector, so none that a light overhead could run along, and the one jump is
/// where the light crosses the horizon.
pub fn light_basis(direction: DVec3) -> DMat3 {
    let n = -direction;
    let sign = 1f64.copysign(n.y);
    let a = -1.0 / (sign + n.y);
    let b = n.z * n.x * a;
    DMat3::from_cols(
        DVec3::new(sign * b, -sign * n.z, 1.0 + sign * n.z * n.z * a),
        DVec3::new(sign + n.x * n.x * a, -n.x, b),
        n,
    )
}

fn from_rows(x: DVec4, y: DVec4, z: DVec4, w: DVec4) -> DMat4 {
    DMat4::from_cols(x, y, z, w).transpose()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn direction() -> impl Strategy<Value = DVec3> {
        prop_oneof![
            [-1.0..1.0, -1.0..1.0, -1.0..1.0]
                .prop_map(DVec3::from)
                .prop_filter("a direction", |v: &DVec3| v.length() > 1e-3)
                .prop_map(DVec3::normalize),
            prop::sample::select(vec![
                DVec3::Y,
                DVec3::NEG_Y,
                DVec3::X,
                DVec3::NEG_Z,
                DVec3::new(1e-9, -1.0, 0.0),
                DVec3::new(0.0, -1.0, -1e-300),
            ]),
        ]
    }

    proptest! {
        #[test]
        fn any_direction_has_a_basis(direction in direction()) {
            let axes = light_basis(direction);
            prop_assert!((axes.transpose() * axes).abs_diff_eq(DMat3::IDENTITY, 1e-12));
            prop_assert!((axes.determinant() - 1.0).abs() < 1e-12);
            prop_assert!(axes.z_axis.abs_diff_eq(-direction, 1e-12));
        }

        #[test]
        fn a_map_spans_its_rectangle_and_distances(
            direction in direction(), position in [-9.0..9.0, -9.0..9.0, -9.0..9.0],
            u in 0.0..1.0, v in 0.0..1.0, d in 0.0..1.0,
        ) {
            let rect = Rect { min: DVec2::new(-0.3, -0.2), max: DVec2::new(0.7, 0.1) };
            let axes = light_basis(direction);
            let position = DVec3::from(position);
            let xy = rect.min + DVec2::new(u, v) * rect.size();
            for perspective in [false, true] {
                let distance = 2.0 + 3.0 * d;
                let (lens, spread, origin) = if perspective {
                    (Lens::spot(position, direction), distance, position)
                } else {
                    (Lens::directional(direction), 1.0, DVec3::ZERO)
                };
                let point = origin
                    + axes * (xy * spread).extend(-distance);
                let clip = lens.matrix(&rect, 2.0, 5.0).project_point3(point);
                let terms = lens.depth_terms(2.0, 5.0);
                let depth = terms.x + terms.y * if perspective { 1.0 / distance } else { distance };
                let expected = DVec3::new(2.0 * u - 1.0, 2.0 * v - 1.0, depth);
                prop_assert!(clip.abs_diff_eq(expected, 1e-9), "{clip} {expected}");
                prop_assert!(lens.place(point).0.abs_diff_eq(xy, 1e-9));
                prop_assert!((0.0..=1.0 + 1e-12).contains(&depth));
            }
        }

        /// Against the table of the specification, written out: major axis, then s and t.
        #[test]
        fn cube_faces_draw_where_lookups_read(
            r in [-1.0..1.0, -1.0..1.0, -1.0..1.0], position in [-9.0..9.0, -9.0..9.0, -9.0..9.0],
        ) {
            let (r, position) = (DVec3::from(r), DVec3::from(position));
            let (face, sc, tc, ma) = match r.abs().max_position() {
                0 if r.x > 0.0 => (0, -r.z, -r.y, r.x),
                0 => (1, r.z, -r.y, r.x),
                1 if r.y > 0.0 => (2, r.x, r.z, r.y),
                1 => (3, r.x, -r.z, r.y),
                _ if r.z > 0.0 => (4, r.x, -r.y, r.z),
                _ => (5, -r.x, -r.y, r.z),
            };
            let (s, t) = (0.5 * (sc / ma.abs() + 1.0), 0.5 * (tc / ma.abs() + 1.0));
            for (other, lens) in Lens::cube(position).into_iter().enumerate() {
                let clip = lens.matrix(&Rect::square(1.0), 1e-3, 10.0) * (position + r).extend(1.0);
                let inside = clip.w > 0.0 && clip.x.abs() <= clip.w && clip.y.abs() <= clip.w;
                prop_assert_eq!(inside, other == face);
                if inside {
                    let drawn = DVec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w);
                    prop_assert!(drawn.abs_diff_eq(DVec2::new(s, t), 1e-9));
                }
            }
        }
    }
}
