//! Meshes that are closed: of which no one outside sees the back of a triangle.

use std::collections::HashMap;

use glam::Vec3;

use super::Mesh;

impl Mesh {
    /// Whether it can be shown that the mesh bounds solids: every edge is shared by two triangles that are wound alike, and
    /// each connected part turns its fronts outwards. Vertices of one position are one, so that seams of normals and of texture
    /// coordinates open nothing; triangles of fewer than three positions count for nothing.
    pub fn is_closed(&self) -> bool {
        let mut numbers = HashMap::new();
        // Zero has two signs.
        let bits = |p: &Vec3| (*p + Vec3::ZERO).to_array().map(f32::to_bits);
        let welded: Vec<u32> = (self.positions.iter())
            .map(|position| {
                let next = numbers.len() as u32;
                *numbers.entry(bits(position)).or_insert(next)
            })
            .collect();
        let mut edges = HashMap::new();
        let mut parts = Parts::new(numbers.len());
        let triangles = self.indices.as_chunks::<3>().0;
        for triangle in triangles {
            let Some([a, b, c]) = corners(&welded, triangle) else {
                continue;
            };
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0_u32) += 1;
                parts.join(edge.0, edge.1);
            }
        }
        let is_paired = |(&(a, b), &count): (&(u32, u32), &u32)| {
            count == 1 && edges.get(&(b, a)).is_some_and(|count| *count == 1)
        };
        if edges.is_empty() || !edges.iter().all(is_paired) {
            return false;
        }
        let mut volumes = HashMap::new();
        for triangle in triangles {
            let Some([a, ..]) = corners(&welded, triangle) else {
                continue;
            };
            let place = |corner: u32| self.positions.get(corner as usize).copied();
            let [p, q, r] = triangle.map(|corner| place(corner).unwrap_or_default().as_dvec3());
            *volumes.entry(parts.of(a)).or_insert(0.0) += p.dot(q.cross(r));
        }
        volumes.values().all(|volume| *volume > 0.0)
    }
}

/// A triangle's corners as welded; none where two are one, or one is none of the mesh's.
fn corners(welded: &[u32], triangle: &[u32; 3]) -> Option<[u32; 3]> {
    let corner = |index: u32| welded.get(index as usize).copied();
    let [a, b, c] = triangle.map(corner);
    let all = [a?, b?, c?];
    (all[0] != all[1] && all[1] != all[2] && all[2] != all[0]).then_some(all)
}

/// Connected parts, as a forest: each vertex points to another of its part, a root to itself.
struct Parts(Vec<u32>);

impl Parts {
    fn new(vertices: usize) -> Self {
        Self((0..vertices as u32).collect())
    }

    /// The root of a vertex's part.
    fn of(&mut self, mut vertex: u32) -> u32 {
        while self.0[vertex as usize] != vertex {
            let above = self.0[vertex as usize];
            self.0[vertex as usize] = self.0[above as usize];
            vertex = above;
        }
        vertex
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a as usize] = b;
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// A cube of side 1 from `at` on, each face with vertices of its own.
    fn cube(at: Vec3) -> Mesh {
        // Bits of a corner's number are x, y and z.
        const FACES: [[u32; 4]; 6] = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let mut mesh = Mesh::default();
        for face in FACES {
            let first = mesh.positions.len() as u32;
            let corner = |n: u32| Vec3::from([n & 1, n >> 1 & 1, n >> 2].map(|bit| bit as f32));
            mesh.positions.extend(face.map(|n| at + corner(n)));
            let quad = [0, 1, 2, 0, 2, 3].map(|n| first + n);
            mesh.indices.extend(quad);
        }
        mesh
    }

    fn both(mut a: Mesh, b: &Mesh) -> Mesh {
        let first = a.positions.len() as u32;
        a.positions.extend(&b.positions);
        a.indices
            .extend(b.indices.iter().map(|index| first + index));
        a
    }

    fn turned(mut mesh: Mesh) -> Mesh {
        mesh.indices
            .as_chunks_mut::<3>()
            .0
            .iter_mut()
            .for_each(|t| t.swap(0, 1));
        mesh
    }

    #[test]
    fn solids_are_closed() {
        assert!(cube(Vec3::ZERO).is_closed());
        // The place of the origin has no say.
        assert!(cube(Vec3::splat(-7.5)).is_closed());
        assert!(both(cube(Vec3::ZERO), &cube(Vec3::splat(0.5))).is_closed());
        let mut flat = cube(Vec3::ZERO);
        flat.indices.extend([0, 0, 1, 2, 2, 2]);
        assert!(flat.is_closed(), "triangles of no area open nothing");
    }

    #[test]
    fn what_is_seen_from_behind_is_not() {
        assert!(!Mesh::default().is_closed());
        let mut open = cube(Vec3::ZERO);
        open.indices.truncate(33);
        assert!(!open.is_closed(), "a triangle is missing");
        let mut mixed = cube(Vec3::ZERO);
        mixed.indices.swap(0, 1);
        assert!(!mixed.is_closed(), "a triangle is wound the other way");
        let inwards = turned(cube(Vec3::ZERO));
        assert!(!inwards.is_closed(), "fronts are turned inwards");
        let room = both(cube(Vec3::ZERO), &turned(cube(Vec3::splat(3.0))));
        assert!(!room.is_closed(), "one of two parts is turned inwards");
        let mut stray = cube(Vec3::ZERO);
        stray.indices[0] = 99;
        assert!(!stray.is_closed(), "a corner is none of its vertices");
    }
}
