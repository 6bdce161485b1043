//! Boxes and frusta, in f64.

use glam::{DMat4, DVec3, DVec4};

/// An axis-aligned box, metres; in world space unless a function says otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The least corner.
    pub min: DVec3,
    /// The greatest corner.
    pub max: DVec3,
}

/// A convex volume between planes; a point p is inside where n · p + d ≥ 0 for each.
#[derive(Clone, Debug, PartialEq)]
pub struct Frustum {
    /// Unit inward normals with their distances (metres).
    pub planes: Vec<(DVec3, f64)>,
    /// The matrix that it came from, to clip space. The planes lie in the space that it takes.
    pub view_proj: DMat4,
}

/// The corners of each face, in order around it, by their numbers: bit 0 is x, bit 1 y, bit 2 z.
pub(crate) const FACES: [[usize; 4]; 6] = [
    [0, 2, 6, 4],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 3, 7, 6],
    [0, 1, 3, 2],
    [4, 5, 7, 6],
];

impl Aabb {
    /// The box between two corners, of which `min` is the lower one on each axis.
    pub fn new(min: impl Into<DVec3>, max: impl Into<DVec3>) -> Self {
        Self {
            min: min.into(),
            max: max.into(),
        }
    }

    /// The smallest box around `points`; none where there is no point.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Option<Self> {
        points
            .into_iter()
            .map(|p| Self { min: p, max: p })
            .reduce(Self::union)
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The part that lies in both; none where nothing does.
    pub fn intersection(self, other: Self) -> Option<Self> {
        self.intersects(&other).then(|| Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        })
    }

    /// The box moved by `offset`.
    pub fn translate(self, offset: DVec3) -> Self {
        Self {
            min: self.min + offset,
            max: self.max + offset,
        }
    }

    /// The smallest box around this one under the affine `matrix` (Arvo 1990): mirrored,
    /// degenerate and sheared transforms too.
    pub fn transform(&self, matrix: &DMat4) -> Self {
        let (mut min, mut max) = (matrix.w_axis.truncate(), matrix.w_axis.truncate());
        for (axis, column) in [matrix.x_axis, matrix.y_axis, matrix.z_axis]
            .into_iter()
            .enumerate()
        {
            let (a, b) = (
                column.truncate() * self.min[axis],
                column.truncate() * self.max[axis],
            );
            min += a.min(b);
            max += a.max(b);
        }
        Self { min, max }
    }

    /// The eight corners: bit 0 of a corner's number chooses `max.x`, bit 1 `max.y`, bit 2 `max.z`.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize| {
                if i & (1 << bit) == 0 {
                    self.min[bit]
                } else {
                    self.max[bit]
                }
            };
            DVec3::new(pick(0), pick(1), pick(2))
        })
    }

    /// The middle.
    pub fn center(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Whether both corners are finite, and in order.
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }

    /// Whether the boxes touch.
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Whether the box touches the ball of `radius` metres about `center`.
    pub fn intersects_sphere(&self, center: DVec3, radius: f64) -> bool {
        center.clamp(self.min, self.max).distance(center) <= radius
    }

    /// Whether `other` lies in the box.
    pub fn contains(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    /// The least and the greatest `direction` · p of the points p of the box.
    pub fn along(&self, direction: DVec3) -> [f64; 2] {
        let (a, b) = (direction * self.min, direction * self.max);
        [a.min(b), a.max(b)].map(DVec3::element_sum)
    }

    /// The greatest distance of a point of the box from the origin.
    pub fn reach(&self) -> f64 {
        self.min.abs().max(self.max.abs()).length()
    }

    pub(crate) fn planes(&self) -> [(DVec3, f64); 6] {
        std::array::from_fn(|i| {
            let axis = DVec3::AXES[i / 2];
            if i % 2 == 0 {
                (axis, -self.min[i / 2])
            } else {
                (-axis, self.max[i / 2])
            }
        })
    }
}

impl Frustum {
    /// The volume that `view_proj` takes into WebGPU's clip volume (−w ≤ x, y ≤ w; 0 ≤ z ≤ w), by
    /// the method of Gribb and Hartmann (2001). A far plane at infinity is left out.
    pub fn from_matrix(view_proj: DMat4) -> Self {
        let (x, y, z, w) = (
            view_proj.row(0),
            view_proj.row(1),
            view_proj.row(2),
            view_proj.row(3),
        );
        let unit = |plane: DVec4| {
            let length = plane.truncate().length();
            (length > 0.0).then(|| (plane.truncate() / length, plane.w / length))
        };
        let planes = [w + x, w - x, w + y, w - y, z, w - z]
            .into_iter()
            .filter_map(unit)
            .collect();
        Self { planes, view_proj }
    }

    /// The eight corners: bit 0 of a corner's number chooses right (x = w), bit 1 top (y = w), bit
    /// 2 the plane z = w, which is the near one where depth is reversed. Finite where the matrix is
    /// invertible and the far plane is not at infinity.
    pub fn corners(&self) -> [DVec3; 8] {
        let to_space = self.view_proj.inverse();
        let clip = Aabb {
            min: DVec3::new(-1.0, -1.0, 0.0),
            max: DVec3::ONE,
        };
        clip.corners().map(|corner| to_space.project_point3(corner))
    }

    /// Whether `point` is inside.
    pub fn contains(&self, point: DVec3) -> bool {
        self.planes
            .iter()
            .all(|(normal, d)| normal.dot(point) + d >= 0.0)
    }

    /// Whether the box may touch the volume: never false where it does, sometimes true where it
    /// passes a corner by.
    pub fn intersects(&self, aabb: &Aabb) -> bool {
        self.planes
            .iter()
            .all(|(normal, d)| aabb.along(*normal)[1] + d >= 0.0)
    }
}
