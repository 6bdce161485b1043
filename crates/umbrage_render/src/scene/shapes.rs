//! Simple shapes, so that grounds and rooms need no model files.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::Mesh;

impl Mesh {
    /// A rectangle around the origin: level, facing up, `size` along x and z in metres. Its texture is
    /// repeated `tiles` times across and down.
    pub fn plane(size: Vec2, tiles: Vec2) -> Self {
        rectangle(size, tiles, Vec3::NEG_Z)
    }

    /// A rectangle around the origin: upright, facing +z, `size` along x and y in metres. Its texture
    /// is repeated `tiles` times across and down.
    pub fn quad(size: Vec2, tiles: Vec2) -> Self {
        rectangle(size, tiles, Vec3::Y)
    }

    /// A box around the origin, its faces outwards; `size` in metres. Closed.
    pub fn cuboid(size: Vec3) -> Self {
        let mut mesh = Self::default();
        let half = 0.5 * size;
        let faces = [
            (Vec3::X, Vec3::NEG_Z, Vec3::Y),
            (Vec3::NEG_X, Vec3::Z, Vec3::Y),
            (Vec3::Y, Vec3::X, Vec3::NEG_Z),
            (Vec3::NEG_Y, Vec3::X, Vec3::Z),
            (Vec3::Z, Vec3::X, Vec3::Y),
            (Vec3::NEG_Z, Vec3::NEG_X, Vec3::Y),
        ];
        for (out, across, up) in faces {
            push_face(&mut mesh, out * half, across * half, up * half, Vec2::ONE);
        }
        mesh
    }

    /// A ball around the origin of `segments` by `segments / 2` patches, at least 3 by 2; `radius` in
    /// metres. Closed, with the ball's own normals.
    pub fn sphere(radius: f32, segments: u32) -> Self {
        let segments = segments.max(3);
        let rings = (segments / 2).max(2);
        let mut mesh = Self::default();
        for ring in 0..=rings {
            let v = ring as f32 / rings as f32;
            // Exact at the poles and at the seam, so that the mesh is closed.
            let sin_polar = if ring == 0 || ring == rings {
                0.0
            } else {
                (PI * v).sin()
            };
            for segment in 0..=segments {
                let u = segment as f32 / segments as f32;
                let (sin, cos) = (TAU * (segment % segments) as f32 / segments as f32).sin_cos();
                let normal = Vec3::new(sin_polar * sin, (PI * v).cos(), sin_polar * cos);
                mesh.positions.push(radius * normal);
                mesh.normals.push(normal);
                mesh.uvs.push(Vec2::new(u, v));
            }
        }
        let row = segments + 1;
        for ring in 0..rings {
            for segment in 0..segments {
                let first = ring * row + segment;
                // A patch at a pole is one triangle.
                if ring + 1 < rings {
                    mesh.indices.extend([first, first + row, first + row + 1]);
                }
                if ring > 0 {
                    mesh.indices.extend([first, first + row + 1, first + 1]);
                }
            }
        }
        mesh
    }
}

/// A rectangle around the origin, its sides along x and `up`.
fn rectangle(size: Vec2, tiles: Vec2, up: Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    let (across, up) = (Vec3::X * (0.5 * size.x), up * (0.5 * size.y));
    push_face(&mut mesh, Vec3::ZERO, across, up, tiles);
    mesh
}

fn push_face(mesh: &mut Mesh, centre: Vec3, across: Vec3, up: Vec3, tiles: Vec2) {
    let first = mesh.positions.len() as u32;
    let normal = across.cross(up).normalize_or_zero();
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        mesh.positions.push(centre + x * across + y * up);
        mesh.normals.push(normal);
        mesh.uvs
            .push(tiles * Vec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y));
    }
    mesh.indices
        .extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Each triangle looks away from the origin, as its normals do.
    fn assert_outward(mesh: &Mesh) {
        for triangle in mesh.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|i| mesh.positions[triangle[i] as usize]);
            let plane = (b - a).cross(c - a);
            assert!(plane.dot(a + b + c) > 0.0, "{a} {b} {c}");
            assert!(plane.dot(mesh.normals[triangle[0] as usize]) > 0.0);
        }
    }

    /// Each edge is shared by two triangles, once in each direction.
    fn assert_closed(mesh: &Mesh) {
        let mut edges = BTreeMap::<_, i32>::new();
        let place = |index: u32| {
            mesh.positions[index as usize]
                .to_array()
                .map(|x| (x + 0.0).to_bits())
        };
        for triangle in mesh.indices.chunks(3) {
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let (from, to) = (place(triangle[from]), place(triangle[to]));
                *edges.entry((from, to)).or_default() += 1;
                *edges.entry((to, from)).or_default() -= 1;
            }
        }
        assert!(edges.values().all(|count| *count == 0));
    }

    #[test]
    fn solids_are_closed_and_face_outwards() {
        for mesh in [
            Mesh::cuboid(Vec3::new(1.0, 2.0, 3.0)),
            Mesh::sphere(2.0, 12),
            Mesh::sphere(1.0, 4),
        ] {
            assert_outward(&mesh);
            assert_closed(&mesh);
        }
    }

    #[test]
    fn rectangles_face_up_or_forwards() {
        let level = Mesh::plane(Vec2::new(2.0, 4.0), Vec2::ONE);
        assert_eq!(level.normals[0], Vec3::Y);
        let upright = Mesh::quad(Vec2::ONE, Vec2::splat(3.0));
        assert_eq!(upright.normals[0], Vec3::Z);
        // The picture's top is up.
        let top = upright
            .positions
            .iter()
            .position(|p| p.y > 0.0)
            .expect("a top");
        assert_eq!(upright.uvs[top].y, 0.0);
    }
}
