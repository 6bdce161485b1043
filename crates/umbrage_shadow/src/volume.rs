//! Where boxes and frusta overlap: what a light's map is fitted to.

use glam::DVec3;

use crate::{Aabb, Frustum, bounds::FACES};

/// The space that lies in all of some frusta, to hold boxes against: what depends on the frusta alone is found once, and
/// cutting box after box needs no allocation.
#[derive(Clone, Debug)]
pub struct Volume<'a> {
    frusta: Vec<Sides<'a>>,
    /// The planes that cross a box.
    crossing: Vec<(DVec3, f64)>,
    vertices: Vec<DVec3>,
    polygon: Polygon,
}

/// Where a box lies about a [`Volume`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Beside it.
    Outside,
    /// Within it, all of it.
    Inside,
    /// Partly within; or close by a corner.
    Across,
}

/// A frustum and its faces.
#[derive(Clone, Debug)]
struct Sides<'a> {
    frustum: &'a Frustum,
    faces: [[DVec3; 4]; 6],
    /// Bounds of the faces.
    bounds: [Aabb; 6],
}

/// The vertices of the part of `aabb` that lies in all of `frusta` (some more than once); none where
/// there is no such part. All in one space. For many boxes, make a [`Volume`] once.
pub fn overlap(aabb: &Aabb, frusta: &[&Frustum]) -> Vec<DVec3> {
    let mut volume = Volume::new(frusta);
    match volume.side(aabb) {
        Side::Outside => Vec::new(),
        Side::Inside => aabb.corners().to_vec(),
        Side::Across => volume.cut(aabb).to_vec(),
    }
}

impl<'a> Volume<'a> {
    /// The space that lies in all of `frusta`.
    pub fn new(frusta: &[&'a Frustum]) -> Self {
        Self {
            frusta: frusta.iter().map(|frustum| Sides::new(frustum)).collect(),
            crossing: Vec::new(),
            vertices: Vec::new(),
            polygon: Polygon::default(),
        }
    }

    /// Where the box lies: never outside where it touches the volume, sometimes across where it passes a corner by.
    pub fn side(&self, aabb: &Aabb) -> Side {
        let mut side = Side::Inside;
        for (normal, d) in self.frusta.iter().flat_map(|sides| &sides.frustum.planes) {
            let [least, most] = aabb.along(*normal).map(|height| height + d);
            if most >= 0.0 {
                if least < 0.0 {
                    side = Side::Across;
                }
            } else {
                return Side::Outside;
            }
        }
        side
    }

    /// The vertices of the part of the box that lies in the volume (some more than once); none where there is no such part.
    ///
    /// A vertex of an overlap lies on a face of one of the volumes and inside the others, so each
    /// volume's faces are clipped by the planes of the others (Sutherland and Hodgman 1974). A volume
    /// without thickness is met by its own faces.
    pub fn cut(&mut self, aabb: &Aabb) -> &[DVec3] {
        let Self {
            frusta,
            crossing,
            vertices,
            polygon,
        } = self;
        vertices.clear();
        crossing.clear();
        let planes = frusta.iter().flat_map(|sides| &sides.frustum.planes);
        crossing.extend(planes.filter(|(normal, d)| aabb.along(*normal)[0] + d < 0.0));
        let corners = aabb.corners();
        for face in FACES {
            vertices.extend(polygon.clip(face.map(|i| corners[i]), &*crossing));
        }
        let box_planes = aabb.planes();
        for (i, sides) in frusta.iter().enumerate() {
            for (face, bounds) in sides.faces.iter().zip(&sides.bounds) {
                if !bounds.intersects(aabb) {
                    continue;
                }
                let others = frusta.iter().enumerate().filter(|(j, _)| *j != i);
                let others = others.flat_map(|(_, other)| &other.frustum.planes);
                vertices.extend(polygon.clip(*face, box_planes.iter().chain(others)));
            }
        }
        vertices
    }
}

impl<'a> Sides<'a> {
    fn new(frustum: &'a Frustum) -> Self {
        let corners = frustum.corners();
        let faces = FACES.map(|face| face.map(|i| corners[i]));
        let bounds = faces.map(|face| {
            let rest = face.map(|corner| Aabb::new(corner, corner));
            rest.into_iter().fold(rest[0], Aabb::union)
        });
        Self {
            frustum,
            faces,
            bounds,
        }
    }
}

/// Room for a polygon while it is clipped.
#[derive(Clone, Debug, Default)]
struct Polygon {
    corners: Vec<DVec3>,
    kept: Vec<DVec3>,
}

impl Polygon {
    /// The part of a convex polygon that lies inside all planes.
    fn clip<'p>(
        &mut self,
        face: [DVec3; 4],
        planes: impl IntoIterator<Item = &'p (DVec3, f64)>,
    ) -> impl Iterator<Item = DVec3> {
        let Self { corners, kept } = self;
        corners.clear();
        corners.extend(face);
        for (normal, d) in planes {
            let Some(&last) = corners.last() else { break };
            let height = |p: DVec3| normal.dot(p) + d;
            kept.clear();
            let (mut from, mut from_height) = (last, height(last));
            for &to in &*corners {
                let to_height = height(to);
                if (from_height < 0.0) != (to_height < 0.0) {
                    kept.push(from.lerp(to, from_height / (from_height - to_height)));
                }
                if to_height >= 0.0 {
                    kept.push(to);
                }
                (from, from_height) = (to, to_height);
            }
            std::mem::swap(corners, kept);
        }
        corners.iter().copied()
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DQuat};
    use proptest::prelude::*;

    use super::*;
    use crate::{Field, Projection, View};

    fn frustum(yaw: f64, pitch: f64, fov_y: f64) -> Frustum {
        let view = View {
            position: DVec3::new(1.0, 2.0, 3.0),
            rotation: DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch),
            projection: Projection {
                field: Field::Perspective { fov_y },
                aspect: 1.5,
                near: 0.1,
                far: 100.0,
            },
            eye: 0.0,
        };
        view.frustum()
    }

    fn inside(frustum: &Frustum, point: DVec3, margin: f64) -> bool {
        frustum
            .planes
            .iter()
            .all(|(n, d)| n.dot(point) + d >= -margin)
    }

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        [-range..range, -range..range, -range..range].prop_map(DVec3::from)
    }

    proptest! {
        /// Every point of the overlap lies between its vertices on any line.
        #[test]
        fn holds_the_overlap(
            (a, b) in (vector(60.0), vector(60.0)), flat in 0usize..4, yaw in -3.0..3.0,
            pitch in -1.5..1.5, fov in 0.1..2.5, at in prop::collection::vec(vector(1.0), 64),
            along in vector(1.0),
        ) {
            let mut aabb = Aabb { min: a.min(b), max: a.max(b) };
            if flat < 3 {
                aabb.max[flat] = aabb.min[flat];
            }
            let (first, second) = (frustum(yaw, pitch, fov), frustum(yaw + 0.4, pitch, 0.9));
            let vertices = overlap(&aabb, &[&first, &second]);
            let reach = vertices.iter().map(|v| v.dot(along)).fold(f64::NEG_INFINITY, f64::max);
            for v in &vertices {
                prop_assert!(inside(&first, *v, 1e-7) && inside(&second, *v, 1e-7));
            }
            for t in at {
                let point = aabb.center() + 0.5 * t * (aabb.max - aabb.min);
                if inside(&first, point, -1e-9) && inside(&second, point, -1e-9) {
                    prop_assert!(point.dot(along) <= reach + 1e-7);
                }
            }
        }

        #[test]
        fn culling_never_drops_what_is_inside(
            (a, b) in (vector(60.0), vector(60.0)), t in vector(1.0), yaw in -3.0..3.0,
        ) {
            let aabb = Aabb { min: a.min(b), max: a.max(b) };
            let volume = frustum(yaw, 0.3, 1.0);
            let point = aabb.center() + 0.5 * t * (aabb.max - aabb.min);
            prop_assert!(!volume.contains(point) || volume.intersects(&aabb));
        }

        #[test]
        fn a_transformed_box_holds_its_corners(a in vector(9.0), b in vector(9.0), turn in -3.0..3.0) {
            let aabb = Aabb { min: a.min(b), max: a.max(b) };
            let matrix = DMat4::from_scale_rotation_translation(
                DVec3::new(-2.0, 0.5, 0.0), DQuat::from_rotation_y(turn), b,
            );
            let moved = aabb.transform(&matrix);
            for corner in aabb.corners() {
                prop_assert!(moved.intersects_sphere(matrix.transform_point3(corner), 1e-9));
            }
        }
    }

    #[test]
    fn a_view_that_holds_the_box_leaves_it_whole() {
        let aabb = Aabb {
            min: DVec3::new(-1.0, 1.0, -20.0),
            max: DVec3::new(3.0, 3.0, -18.0),
        };
        assert_eq!(overlap(&aabb, &[&frustum(0.0, 0.0, 1.0)]), aabb.corners());
    }

    #[test]
    fn a_box_around_the_view_is_cut_to_it() {
        let volume = frustum(0.0, 0.0, 1.0);
        let aabb = Aabb {
            min: DVec3::splat(-1e4),
            max: DVec3::splat(1e4),
        };
        let expected = Aabb::from_points(volume.corners());
        let found = Aabb::from_points(overlap(&aabb, &[&volume]));
        let (Some(expected), Some(found)) = (expected, found) else {
            panic!("no overlap")
        };
        assert!(expected.min.distance(found.min) < 1e-6 && expected.max.distance(found.max) < 1e-6);
    }
}
