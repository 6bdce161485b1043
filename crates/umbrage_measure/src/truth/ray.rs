//! Rays, boxes and triangles.

use glam::DVec3;
use parry3d_f64::partitioning::BvhNode;

use super::lamp::Aim;

/// A point, as well as it is known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Metres, world axes, relative to the camera.
    pub(crate) at: DVec3,
    /// Greatest error of its coordinates; metres.
    pub(crate) error: f64,
}

/// A ray, with what it takes to meet many boxes and triangles.
pub(super) struct Ray {
    origin: DVec3,
    error: f64,
    /// Where it ends, one length of the direction from the origin.
    end: Option<Place>,
    direction: [f64; 3],
    inverse: [f64; 3],
    /// The direction's longest axis, and the two others.
    axes: [usize; 3],
    /// Takes the direction to the unit vector of its longest axis.
    shear: [f64; 3],
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    /// In lengths of the ray's direction.
    pub(super) distance: f64,
    /// The corners' shares of the place; they add up to 1.
    pub(super) shares: [f64; 3],
    /// Greatest `distance` found where in truth it is 0.
    pub(super) rounding: f64,
}

impl Place {
    /// Error that a few roundings may make in coordinates up to `size`; metres.
    pub(crate) fn rounding(size: f64) -> f64 {
        4.0 * f64::EPSILON * size
    }
}

impl Ray {
    /// A ray; its direction is finite and not zero.
    pub(super) fn new(origin: Place, Aim { direction, end }: Aim) -> Self {
        let longest = direction.abs().max_position();
        let axes = [longest, (longest + 1) % 3, (longest + 2) % 3];
        let direction = direction.to_array();
        let along = direction[axes[0]];
        Self {
            origin: origin.at,
            error: origin.error,
            end,
            direction,
            inverse: direction.map(f64::recip),
            axes,
            shear: [
                1.0 / along,
                direction[axes[1]] / along,
                direction[axes[2]] / along,
            ],
        }
    }

    /// How far it goes, in lengths of its direction.
    pub(super) fn limit(&self) -> f64 {
        self.end.map_or(f64::INFINITY, |_| 1.0)
    }

    /// Where the ray enters the node's box, 0 where it starts inside. None where it passes by, or
    /// enters it beyond `limit`.
    pub(super) fn enter(&self, node: &BvhNode, limit: f64) -> Option<f64> {
        let (low, high) = (node.mins().to_array(), node.maxs().to_array());
        let origin = self.origin.to_array();
        let (mut near, mut far) = (0.0_f64, limit);
        for axis in 0..3 {
            let (to_low, to_high) = (low[axis] - origin[axis], high[axis] - origin[axis]);
            if self.direction[axis] == 0.0 {
                // A quotient would be no number where the ray runs in the box's side.
                if to_low > 0.0 || to_high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (to_low * self.inverse[axis], to_high * self.inverse[axis]);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near <= far).then_some(near)
    }

    /// Where the ray's line meets a triangle, on either side (Woop, Benthin and Wald 2013). The signs
    /// along an edge are the same for both triangles that share it, so that no line passes between.
    pub(super) fn meet(&self, corners: [DVec3; 3]) -> Option<Meeting> {
        let corners = corners.map(|corner| corner - self.origin);
        let [a, b, c] = corners.map(|corner| {
            let along = corner[self.axes[0]];
            (
                corner[self.axes[1]] - self.shear[1] * along,
                corner[self.axes[2]] - self.shear[2] * along,
            )
        });
        let areas = [
            c.0 * b.1 - c.1 * b.0,
            a.0 * c.1 - a.1 * c.0,
            b.0 * a.1 - b.1 * a.0,
        ];
        let outside = areas.iter().any(|area| *area < 0.0) && areas.iter().any(|area| *area > 0.0);
        let whole = areas[0] + areas[1] + areas[2];
        if outside || whole == 0.0 {
            return None;
        }
        let shares = areas.map(|area| area / whole);
        let along: f64 = (0..3)
            .map(|i| shares[i] * corners[i][self.axes[0]])
            .sum::<f64>();
        Some(Meeting {
            distance: along * self.shear[0],
            shares,
            rounding: self.rounding(corners, whole),
        })
    }

    /// Whether the ray, which meets the plane of these corners, ends on the plane's other side: farther from the plane
    /// than the error of the end and the corners' error along each axis (`coarse`, metres). All is computed relative to
    /// the end, and does not depend on where the ray comes from.
    pub(super) fn crosses(&self, [a, b, c]: [DVec3; 3], coarse: impl Fn() -> DVec3) -> bool {
        let Some(end) = self.end else {
            return true;
        };
        let normal = (b - a).cross(c - a);
        let onwards = normal.dot(DVec3::from_array(self.direction));
        let beyond = normal.dot(end.at - a) * onwards.signum();
        let edges = (b - a).length() * (c - a).length();
        let reach = [a, b, c].map(|corner| corner.distance(end.at));
        let reach = reach.into_iter().fold(0.0, f64::max);
        let rounding = 16.0 * edges * (f64::EPSILON * reach + end.error);
        beyond > rounding + normal.abs().dot(coarse())
    }

    /// The distance is n · a / n · d, for the triangle's normal n (unnormalised), a corner a seen from
    /// the origin and the direction d. The products that n is made of are at most |e1| |e2|, and a is
    /// off by its own rounding and the origin's error; 16 is more than the roundings on the way.
    fn rounding(&self, [a, b, c]: [DVec3; 3], whole: f64) -> f64 {
        let edges = (b - a).length() * (c - a).length();
        let reach = a.length().max(b.length()).max(c.length());
        let facing = (whole * self.direction[self.axes[0]]).abs();
        16.0 * edges * (f64::EPSILON * reach + self.error) / facing
    }
}
