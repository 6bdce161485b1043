//! All triangles of a scene, and the tree that rays find them by.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};
use parry3d_f64::{
    bounding_volume::Aabb,
    math::Vector,
    partitioning::{Bvh, BvhBuildStrategy},
};
use umbrage_render::{Material, Mesh, Object, Scene};

use super::{
    TruthError,
    opacity::is_solid,
    ray::{Meeting, Place, Ray},
};

/// As many as the tree can count.
const MOST_TRIANGLES: usize = (1 << 30) - 1;
/// Metres from the camera; products of four such lengths are far from f64's end.
const FARTHEST: f64 = 1e15;

/// Relative error of a mesh's coordinates: a step of f32, in which they are given.
const GIVEN: f64 = f32::EPSILON as f64;

/// The sine of the angle between a ray and a plane, in four steps of an f32, below which which side of the
/// plane the ray is on cannot be told.
const EDGE_ON: f64 = 4.0 * f32::EPSILON as f64;

/// The triangles, numbered through all objects, relative to an origin.
pub(super) struct Triangles {
    objects: Vec<Part>,
    vertices: Vec<DVec3>,
    corners: Vec<[u32; 3]>,
    tree: Bvh,
}

/// Triangles and vertices of one object.
struct Part {
    first_triangle: u32,
    first_vertex: u32,
    mesh: Arc<Mesh>,
    material: Arc<Material>,
    /// How far each axis of the mesh moves along each of the world's, by the transform's linear part.
    stretch: DMat3,
}

impl Triangles {
    pub(super) fn new(scene: &Scene, origin: DVec3) -> Result<Self, TruthError> {
        let count = |object: &Object| object.mesh.indices.len() / 3;
        let found = scene.objects.iter().map(count).sum();
        let vertices = scene.objects.iter().map(|o| o.mesh.positions.len()).sum();
        if found == 0 {
            return Err(TruthError::NoTriangles);
        }
        if found > MOST_TRIANGLES || vertices > u32::MAX as usize {
            let most = MOST_TRIANGLES;
            return Err(TruthError::TooManyTriangles { found, most });
        }
        let mut triangles = Self {
            objects: Vec::with_capacity(scene.objects.len()),
            vertices: Vec::with_capacity(vertices),
            corners: Vec::with_capacity(found),
            tree: Bvh::new(),
        };
        for object in &scene.objects {
            triangles.add(object, origin)?;
        }
        triangles.plant();
        Ok(triangles)
    }

    fn add(&mut self, object: &Object, origin: DVec3) -> Result<(), TruthError> {
        let first_vertex = self.vertices.len() as u32;
        self.objects.push(Part {
            first_triangle: self.corners.len() as u32,
            first_vertex,
            mesh: object.mesh.clone(),
            material: object.material.clone(),
            stretch: object.transform.matrix3.abs(),
        });
        let transform = object.transform;
        // Before anything is rounded: far out, both are large and nearly the same.
        let place = transform.translation - origin;
        for (vertex, position) in object.mesh.positions.iter().enumerate() {
            let position = transform.matrix3 * position.as_dvec3() + place;
            let farthest = position.abs().max_element();
            if !position.is_finite() || farthest > FARTHEST {
                return Err(TruthError::Vertex {
                    object: object.name.clone(),
                    vertex,
                    position,
                });
            }
            self.vertices.push(position);
        }
        let count = object.mesh.positions.len();
        for corners in object.mesh.indices.as_chunks::<3>().0 {
            if let Some(vertex) = corners.iter().find(|corner| **corner as usize >= count) {
                return Err(TruthError::NoSuchVertex {
                    object: object.name.clone(),
                    vertex: *vertex,
                    count,
                });
            }
            self.corners
                .push(corners.map(|corner| corner + first_vertex));
        }
        Ok(())
    }

    /// Builds the tree. Its boxes are wider than their triangles by more than the rounding of what is
    /// computed of any ray that starts among them, so that no box is missed whose triangle is met.
    fn plant(&mut self) {
        let extent = self.vertices.iter().map(|v| v.abs().max_element());
        let padding = DVec3::splat(16.0 * f64::EPSILON * extent.fold(0.0, f64::max));
        let vector = |v: DVec3| Vector::new(v.x, v.y, v.z);
        let boxes = (0..self.corners.len() as u32).map(|index| {
            let [a, b, c] = self.corners(index);
            let (low, high) = (a.min(b).min(c) - padding, a.max(b).max(c) + padding);
            (index as usize, Aabb::new(vector(low), vector(high)))
        });
        self.tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
    }

    pub(super) fn len(&self) -> usize {
        self.corners.len()
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.corners[triangle as usize].map(|corner| self.vertices[corner as usize])
    }

    /// The object that a triangle is of, and its number there.
    pub(super) fn owner(&self, triangle: u32) -> (u32, u32) {
        // Objects without triangles begin where the next one does.
        let next = self
            .objects
            .partition_point(|part| part.first_triangle <= triangle);
        let object = next.saturating_sub(1);
        (
            object as u32,
            triangle - self.objects[object].first_triangle,
        )
    }

    /// A triangle's number through all objects; none where there is no such triangle.
    pub(super) fn number(&self, object: u32, triangle: u32) -> Option<u32> {
        let part = self.objects.get(object as usize)?;
        let number = part.first_triangle.checked_add(triangle)?;
        ((number as usize) < self.corners.len()).then_some(number)
    }

    /// The nearest surface on the ray's way from `near` to `far`, in lengths of its direction: the
    /// triangle, and the place on it.
    pub(super) fn nearest(&self, ray: &Ray, near: f64, far: f64) -> Option<(u32, DVec3)> {
        let enter = |node: &_, best: f64| ray.enter(node, best).unwrap_or(f64::MAX);
        let meet = |triangle: u32, _| {
            let meeting = ray.meet(self.corners(triangle))?;
            let met = (near..=far).contains(&meeting.distance) && self.is_solid(triangle, &meeting);
            met.then_some((meeting.distance, meeting))
        };
        let (triangle, (_, meeting)) = self.tree.find_best(far, enter, meet)?;
        // Of the corners, not along the ray: so the place is off the plane by no more than the
        // corners' rounding, however flat the ray meets it.
        let [a, b, c] = self.corners(triangle);
        let [u, v, w] = meeting.shares;
        Some((triangle, u * a + v * b + w * c))
    }

    /// Whether a direction runs along the triangle's plane, as far as its corners tell: meshes have them
    /// in f32. Not where it has no plane.
    pub(super) fn runs_along(&self, triangle: u32, direction: DVec3) -> bool {
        let [a, b, c] = self.corners(triangle);
        // Unit edges, so that no triangle is too small for the products.
        let normal = (b - a)
            .normalize_or_zero()
            .cross((c - a).normalize_or_zero());
        let sine = normal
            .normalize_or_zero()
            .dot(direction.normalize_or_zero());
        normal != DVec3::ZERO && sine.abs() < EDGE_ON
    }

    /// By how much the coordinates of a place on a triangle may be off; metres.
    pub(super) fn rounding(&self, triangle: u32) -> f64 {
        let corners = self
            .corners(triangle)
            .map(|corner| corner.abs().max_element());
        Place::rounding(corners.into_iter().fold(0.0, f64::max))
    }

    /// Greatest error of a triangle's corners along the world's axes, as they were given; metres.
    fn coarseness(&self, triangle: u32) -> DVec3 {
        let part = &self.objects[self.owner(triangle).0 as usize];
        let given = |corner: u32| {
            let position = part.mesh.positions[(corner - part.first_vertex) as usize];
            position.abs().as_dvec3()
        };
        let [a, b, c] = self.corners[triangle as usize].map(given);
        GIVEN * (part.stretch * a.max(b).max(c))
    }

    /// Whether a caster other than the triangle `own` stands on the ray's way.
    pub(super) fn is_blocked(&self, ray: &Ray, own: u32) -> bool {
        self.tree
            .leaves(|node| ray.enter(node, ray.limit()).is_some())
            .any(|triangle| self.block(ray, own, triangle).is_some())
    }

    /// How far away the nearest thing is that makes [`is_blocked`](Self::is_blocked) true, in lengths of
    /// the ray's direction.
    pub(super) fn blocker(&self, ray: &Ray, own: u32) -> Option<f64> {
        let enter = |node: &_, best: f64| {
            let entered = ray.enter(node, best.min(ray.limit()));
            entered.unwrap_or(f64::MAX)
        };
        let block = |triangle: u32, _| {
            let distance = self.block(ray, own, triangle)?;
            Some((distance, ()))
        };
        // A triangle just before the end may, by rounding, be met just behind it.
        let (_, (distance, ())) = self.tree.find_best(f64::INFINITY, enter, block)?;
        Some(distance)
    }

    /// Distance at which a triangle keeps light from the triangle `own`, if it does: if the two ends of the ray lie on
    /// different sides of it. A triangle that an end lies on shades nothing.
    fn block(&self, ray: &Ray, own: u32, triangle: u32) -> Option<f64> {
        if triangle == own {
            return None;
        }
        let corners = self.corners(triangle);
        let meeting = ray.meet(corners)?;
        let blocks = meeting.distance > meeting.rounding
            && ray.crosses(corners, || self.coarseness(triangle))
            && self.objects[self.owner(triangle).0 as usize].material.casts
            && self.is_solid(triangle, &meeting);
        blocks.then_some(meeting.distance)
    }

    fn is_solid(&self, triangle: u32, meeting: &Meeting) -> bool {
        let part = &self.objects[self.owner(triangle).0 as usize];
        is_solid(&part.material, || {
            let vertices =
                self.corners[triangle as usize].map(|corner| (corner - part.first_vertex) as usize);
            let corners = vertices.into_iter().zip(meeting.shares);
            corners.fold((DVec2::ZERO, 0.0), |(uv, opacity), (vertex, share)| {
                let own = part.mesh.uvs.get(vertex).copied().unwrap_or_default();
                let color = part.mesh.colors.get(vertex);
                let own_opacity = color.map_or(1.0, |color| f64::from(color.w));
                (uv + share * own.as_dvec2(), opacity + share * own_opacity)
            })
        })
    }
}
