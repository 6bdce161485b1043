//! Where a box and frusta overlap: what a light's map is fitted to.

use glam::DVec3;

use crate::{Aabb, Frustum, bounds::FACES};

/// The vertices of the part of `aabb` that lies in all of `frusta` (some more than once); none where
/// there is no such part. All in one space.
///
/// A vertex of an overlap lies on a face of one of the volumes and inside the others, so each
/// volume's faces are clipped by the planes of the others (Sutherland and Hodgman 1974). A volume
/// without thickness is met by its own faces.
pub fn overlap(aabb: &Aabb, frusta: &[&Frustum]) -> Vec<DVec3> {
    if !frusta.iter().all(|frustum| frustum.intersects(aabb)) {
        return Vec::new();
    }
    let corners = aabb.corners();
    if frusta
        .iter()
        .all(|frustum| corners.iter().all(|corner| frustum.contains(*corner)))
    {
        return corners.to_vec();
    }
    let mut vertices = Vec::new();
    let all_frusta = || frusta.iter().flat_map(|frustum| &frustum.planes);
    for face in FACES {
        vertices.extend(clip(face.map(|i| corners[i]), all_frusta()));
    }
    let box_planes = aabb.planes();
    for (i, frustum) in frusta.iter().enumerate() {
        let corners = frustum.corners();
        for face in FACES {
            let others = frusta.iter().enumerate().filter(|(j, _)| *j != i);
            let planes = others
                .flat_map(|(_, other)| &other.planes)
                .chain(&box_planes);
            vertices.extend(clip(face.map(|i| corners[i]), planes));
        }
    }
    vertices
}

/// The part of a convex polygon that lies inside all planes.
fn clip<'a>(polygon: [DVec3; 4], planes: impl IntoIterator<Item = &'a (DVec3, f64)>) -> Vec<DVec3> {
    let mut polygon = polygon.to_vec();
    for (normal, d) in planes {
        let Some(&last) = polygon.last() else { break };
        let height = |p: DVec3| normal.dot(p) + d;
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        let (mut from, mut from_height) = (last, height(last));
        for to in polygon {
            let to_height = height(to);
            if (from_height < 0.0) != (to_height < 0.0) {
                kept.push(from.lerp(to, from_height / (from_height - to_height)));
            }
            if to_height >= 0.0 {
                kept.push(to);
            }
            (from, from_height) = (to, to_height);
        }
        polygon = kept;
    }
    polygon
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
