//! Shapes that scene files do not have. Flat: each triangle has its own normal. Metres.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use umbrage_render::Mesh;

/// A triangle's corners, counter-clockwise seen from the front.
type Triangle = [Vec3; 3];

/// The triangles as a mesh; one without area has zeros for its normals.
pub(super) fn flat(triangles: impl IntoIterator<Item = Triangle>) -> Mesh {
    let mut mesh = Mesh::default();
    for [a, b, c] in triangles {
        // In f64: the cross product of a small triangle's edges would lose digits.
        let (ab, ac) = ((b - a).as_dvec3(), (c - a).as_dvec3());
        let normal = ab.cross(ac).normalize_or_zero().as_vec3();
        mesh.positions.extend([a, b, c]);
        mesh.normals.extend([normal; 3]);
        mesh.uvs.extend([Vec2::ZERO; 3]);
    }
    mesh.indices = (0..mesh.positions.len() as u32).collect();
    mesh
}

/// The surface that a line of (radius, height) sweeps in a turn about the y axis, in `segments` steps. The front is to
/// the right of the line: outside, where the line goes up. Closed where the line begins and ends
/// on the axis, or where it began.
pub(super) fn lathe(line: &[Vec2], segments: u32) -> Mesh {
    let place = |point: Vec2, segment: u32| {
        let (sin, cos) = (TAU * (segment % segments) as f32 / segments as f32).sin_cos();
        Vec3::new(point.x * cos, point.y, point.x * sin)
    };
    let mut triangles = Vec::new();
    for ends in line.windows(2) {
        let (low, high) = (ends[0], ends[1]);
        for segment in 0..segments {
            let next = segment + 1;
            if high.x > 0.0 {
                triangles.push([place(low, segment), place(high, segment), place(high, next)]);
            }
            if low.x > 0.0 {
                triangles.push([place(low, segment), place(high, next), place(low, next)]);
            }
        }
    }
    flat(triangles)
}

/// A cone that stands on its tip at the origin. Closed.
pub(super) fn cone(radius: f32, height: f32) -> Mesh {
    let line = [(0.0, 0.0), (radius, height), (0.0, height)].map(Vec2::from);
    lathe(&line, 48)
}

/// A tree about the origin's y axis: a stem and a round crown, `height` tall. Closed, and all of it in
/// proportion to its height.
pub(super) fn tree(height: f32) -> Mesh {
    let mut line: Vec<_> = [(0.0, 0.0), (0.035, 0.0), (0.03, 0.35)]
        .map(Vec2::from)
        .into();
    line.extend((1..16).map(|step| {
        let (sin, cos) = (PI * step as f32 / 16.0).sin_cos();
        Vec2::new(0.28 * sin, 0.65 - 0.35 * cos)
    }));
    line.push(Vec2::new(0.0, 1.0));
    let line: Vec<_> = line.into_iter().map(|point| height * point).collect();
    lathe(&line, 24)
}

/// The lower half of a hollow ball about the origin, without thickness. Open.
pub(super) fn bowl(radius: f32) -> Mesh {
    let line: Vec<_> = (0..=12)
        .map(|step| {
            let angle = 0.5 * PI * step as f32 / 12.0;
            // The axis is met exactly.
            let (sin, cos) = if step == 0 {
                (0.0, 1.0)
            } else {
                angle.sin_cos()
            };
            radius * Vec2::new(sin, -cos)
        })
        .collect();
    lathe(&line, 48)
}

/// A pipe that stands on the origin, without thickness and without ends. Open.
pub(super) fn tube(radius: f32, height: f32) -> Mesh {
    lathe(&[Vec2::new(radius, 0.0), Vec2::new(radius, height)], 48)
}

/// A ring about the y axis: `radius` to the middle of a pipe that is `thickness` thick. Closed.
pub(super) fn torus(radius: f32, thickness: f32) -> Mesh {
    let line: Vec<_> = (0..=24)
        .map(|step| {
            let (sin, cos) = (TAU * (step % 24) as f32 / 24.0).sin_cos();
            Vec2::new(radius, 0.0) + 0.5 * thickness * Vec2::new(cos, sin)
        })
        .collect();
    lathe(&line, 48)
}

/// A flat hill on the origin's level: a cap of a ball. Open below.
pub(super) fn dome(radius: f32, height: f32) -> Mesh {
    let line: Vec<_> = (0..=32)
        .map(|step| {
            let share = step as f32 / 32.0;
            Vec2::new(
                radius * (1.0 - share),
                height * (1.0 - (1.0 - share).powi(2)),
            )
        })
        .collect();
    lathe(&line, 64)
}

/// A pointed leaf without thickness from the origin along +x, level, its face up, folded a little
/// along its middle. Open.
pub(super) fn leaf(length: f32, width: f32) -> Mesh {
    let half = |share: f32| 0.5 * width * (PI * share).sin().max(0.0);
    let steps: u32 = 8;
    let mut triangles = Vec::new();
    for step in 0..steps {
        let [from, to] = [step, step + 1].map(|s| s as f32 / steps as f32);
        for side in [-1.0, 1.0] {
            let middle = |share: f32| Vec3::X * length * share;
            let rim = |share: f32| {
                let wide = half(share);
                middle(share) + Vec3::new(0.0, 0.3 * wide, side * wide)
            };
            let quad = [middle(from), middle(to), rim(to), rim(from)];
            let quad = if side > 0.0 {
                [quad[3], quad[2], quad[1], quad[0]]
            } else {
                quad
            };
            if step + 1 < steps {
                triangles.push([quad[0], quad[1], quad[2]]);
            }
            triangles.push([quad[0], quad[2], quad[3]]);
        }
    }
    flat(
        triangles
            .into_iter()
            .filter(|[a, b, c]| a != b && b != c && a != c),
    )
}

/// A wedge on the origin's level: `size`, its upper edge towards −x, its lower one towards +x; no
/// turn makes it its own mirror image, as one end is cut slantwise. Closed.
pub(super) fn wedge(size: Vec3) -> Mesh {
    let at = |x: f32, y: f32, z: f32| size * Vec3::new(x, y, z);
    let (a, b, c) = (at(-0.5, 0.0, 0.5), at(0.5, 0.0, 0.5), at(-0.5, 1.0, 0.5));
    // The far end leans: its upper corner stands nearer than its lower ones.
    let (d, e, f) = (at(-0.5, 0.0, -0.5), at(0.5, 0.0, -0.5), at(-0.5, 1.0, -0.1));
    flat([
        [a, b, c],
        [e, d, f],
        [a, d, e],
        [a, e, b],
        [b, e, f],
        [b, f, c],
        [d, a, c],
        [d, c, f],
    ])
}

/// Ground over `size` (along x and z) around the origin in `cells`, `height` above the level. Open.
pub(super) fn terrain(size: Vec2, cells: [u32; 2], height: impl Fn(Vec2) -> f32) -> Mesh {
    let at = |x: u32, z: u32| {
        let share = Vec2::new(x as f32, z as f32) / Vec2::new(cells[0] as f32, cells[1] as f32);
        let place = size * (share - 0.5);
        Vec3::new(place.x, height(place), place.y)
    };
    let cells = (0..cells[1]).flat_map(|z| (0..cells[0]).map(move |x| (x, z)));
    flat(cells.flat_map(|(x, z)| {
        let [a, b, c, d] = [at(x, z), at(x, z + 1), at(x + 1, z + 1), at(x + 1, z)];
        [[a, b, c], [a, c, d]]
    }))
}

/// A staircase that goes up towards −z: `steps` of `step` (width along x, rise, going), its foot on the
/// origin. Open behind and below.
pub(super) fn stairs(steps: u32, step: Vec3) -> Mesh {
    let mut triangles = Vec::new();
    let mut quad = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| triangles.extend([[a, b, c], [a, c, d]]);
    let (left, right) = (-0.5 * step.x, 0.5 * step.x);
    for index in 0..steps {
        let (low, front) = (step.y * index as f32, -step.z * index as f32);
        let (high, back) = (low + step.y, front - step.z);
        let at = Vec3::new;
        quad(
            at(left, low, front),
            at(right, low, front),
            at(right, high, front),
            at(left, high, front),
        );
        quad(
            at(left, high, front),
            at(right, high, front),
            at(right, high, back),
            at(left, high, back),
        );
        // The sides reach the ground.
        quad(
            at(right, 0.0, front),
            at(right, 0.0, back),
            at(right, high, back),
            at(right, high, front),
        );
        quad(
            at(left, 0.0, back),
            at(left, 0.0, front),
            at(left, high, front),
            at(left, high, back),
        );
    }
    flat(triangles)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Each edge is shared by two triangles, once in each direction.
    fn is_closed(mesh: &Mesh) -> bool {
        let mut edges = BTreeMap::<_, [u32; 2]>::new();
        // −0 and 0 are one place.
        let place = |index: u32| {
            mesh.positions[index as usize]
                .to_array()
                .map(|x| (x + 0.0).to_bits())
        };
        for triangle in mesh.indices.as_chunks::<3>().0 {
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let (from, to) = (place(triangle[from]), place(triangle[to]));
                let (edge, way) = if from < to {
                    ((from, to), 0)
                } else {
                    ((to, from), 1)
                };
                edges.entry(edge).or_default()[way] += 1;
            }
        }
        edges.values().all(|ways| *ways == [1, 1])
    }

    /// The volume that the triangles enclose: above 0 where a closed mesh faces outwards.
    fn volume(mesh: &Mesh) -> f64 {
        let corner = |index: u32| mesh.positions[index as usize].as_dvec3();
        let triangles = mesh.indices.as_chunks::<3>().0.iter();
        triangles
            .map(|[a, b, c]| corner(*a).dot(corner(*b).cross(corner(*c))) / 6.0)
            .sum()
    }

    fn every_shape() -> Vec<(&'static str, Mesh, bool)> {
        vec![
            ("cone", cone(1.0, 2.0), true),
            ("tree", tree(4.0), true),
            ("torus", torus(1.0, 0.4), true),
            ("wedge", wedge(Vec3::new(1.0, 2.0, 3.0)), true),
            ("bowl", bowl(1.0), false),
            ("tube", tube(1.0, 2.0), false),
            ("dome", dome(1.0, 0.1), false),
            ("leaf", leaf(1.0, 0.4), false),
            ("stairs", stairs(4, Vec3::new(1.0, 0.2, 0.3)), false),
            (
                "terrain",
                terrain(Vec2::ONE, [3, 4], |at| at.x * at.y),
                false,
            ),
        ]
    }

    #[test]
    fn closed_shapes_are_closed_and_open_ones_open() {
        for (name, mesh, closed) in every_shape() {
            assert_eq!(is_closed(&mesh), closed, "{name}");
        }
    }

    #[test]
    fn normals_are_unit_and_those_of_the_triangles() {
        for (name, mesh, _) in every_shape() {
            for [a, b, c] in mesh.indices.as_chunks::<3>().0 {
                let [p, q, r] = [a, b, c].map(|i| mesh.positions[*i as usize].as_dvec3());
                let normal = mesh.normals[*a as usize].as_dvec3();
                assert!((normal.length() - 1.0).abs() < 1e-6, "{name}");
                assert!(
                    (q - p).cross(r - p).normalize().dot(normal) > 1.0 - 1e-6,
                    "{name}"
                );
            }
        }
    }

    /// The volumes are those of the round solids, but for the corners that flat facets cut.
    #[test]
    fn closed_shapes_face_outwards() {
        let third = std::f64::consts::PI * 2.0 / 3.0;
        assert!((volume(&cone(1.0, 2.0)) / third - 1.0).abs() < 0.01);
        let ring = 2.0 * std::f64::consts::PI.powi(2) * 0.2_f64.powi(2);
        assert!((volume(&torus(1.0, 0.4)) / ring - 1.0).abs() < 0.02);
        // A prism of 3 m² over 3 m, less the corner that leans: a pyramid of height 1.2 m on the lower
        // right triangle's other half.
        assert!(volume(&wedge(Vec3::new(1.0, 2.0, 3.0))) > 0.0);
        assert!(volume(&tree(4.0)) > 0.0);
    }

    #[test]
    fn open_shapes_face_up_or_out() {
        for mesh in [
            leaf(1.0, 0.4),
            dome(1.0, 0.1),
            terrain(Vec2::ONE, [2, 2], |_| 0.0),
        ] {
            assert!(mesh.normals.iter().all(|normal| normal.y > 0.0));
        }
        let pipe = tube(1.0, 2.0);
        for (place, normal) in pipe.positions.iter().zip(&pipe.normals) {
            assert!(place.dot(*normal) > 0.9);
        }
        // Outside is below.
        for (place, normal) in bowl(1.0).positions.iter().zip(&bowl(1.0).normals) {
            assert!(place.dot(*normal) > 0.9);
        }
    }
}
