//! Views, boxes and frusta, in f64.

use glam::{DMat4, DQuat, DVec3};

/// A camera: world space, metres, right-handed, y up; it looks along −z of its own axes.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Where it stands.
    pub position: DVec3,
    /// From its axes to the world's.
    pub rotation: DQuat,
    /// How it projects.
    pub projection: Projection,
}

/// A perspective projection. Clip space is WebGPU's, depth reversed: 1 at `near`, 0 at `far`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Full vertical angle, radians.
    pub fov_y: f64,
    /// Width over height.
    pub aspect: f64,
    /// Metres, above 0.
    pub near: f64,
    /// Metres, above `near`.
    pub far: f64,
}

/// An axis-aligned box, world space, metres.
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
    /// The matrix that it came from, world to clip.
    pub view_proj: DMat4,
}
