//! Scenes made in code.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3};
use umbrage_render::{Camera, Material, Mesh, Object, Scene, SceneLight};
use umbrage_shadow::{Field, Light, LightKind};

/// Where a scene stands and how large it is: what is at `p` stands at `origin + scale * p`.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub(crate) origin: DVec3,
    pub(crate) scale: f64,
}

pub(crate) const HERE: Place = Place {
    origin: DVec3::ZERO,
    scale: 1.0,
};

impl Place {
    pub(crate) fn at(&self, point: DVec3) -> DVec3 {
        self.origin + self.scale * point
    }

    pub(crate) fn object(&self, name: &str, mesh: Mesh, at: DVec3) -> Object {
        let transform = DAffine3::from_scale_rotation_translation(
            DVec3::splat(self.scale),
            DQuat::IDENTITY,
            self.at(at),
        );
        Object {
            name: name.to_owned(),
            bounds: mesh.bounds(&transform),
            mesh: Arc::new(mesh),
            material: Arc::new(Material::plain("lambert")),
            transform,
        }
    }

    /// A camera at `eye` that looks at `target`, with `up` upwards; its angle is 60°.
    pub(crate) fn camera(&self, eye: DVec3, target: DVec3, up: DVec3) -> Camera {
        let back = (eye - target).normalize();
        let right = up.cross(back).normalize();
        let axes = DMat3::from_cols(right, back.cross(right), back);
        Camera {
            position: self.at(eye),
            rotation: DQuat::from_mat3(&axes),
            field: Field::Perspective {
                fov_y: 60_f64.to_radians(),
            },
            near: 0.01 * self.scale,
            far: 1000.0 * self.scale,
        }
    }
}

pub(crate) fn scene(objects: Vec<Object>, light: LightKind, camera: Camera) -> Scene {
    Scene {
        objects,
        lights: vec![SceneLight {
            name: "light".to_owned(),
            light: Light {
                kind: light,
                color: Vec3::ONE,
            },
            cookie: None,
            shadow: None,
        }],
        camera,
        ambient: Vec3::ZERO,
        background: Vec3::ZERO,
        medium: None,
        left_out: Vec::new(),
    }
}

/// A level square around the origin, its corners `half` away on both axes.
pub(crate) fn square(half: f32) -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(Vec2::from);
    Mesh {
        positions: corners
            .map(|c| Vec3::new(half * c.x, 0.0, half * c.y))
            .into(),
        normals: vec![Vec3::Y; 4],
        uvs: corners.map(|c| 0.5 + 0.5 * c).into(),
        indices: vec![0, 2, 1, 0, 3, 2],
        ..Mesh::default()
    }
}

/// A box around the origin.
pub(crate) fn block(half: Vec3) -> Mesh {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
    let faces = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    Mesh {
        positions: (0..8).map(|i| half * (2.0 * corner(i) - 1.0)).collect(),
        normals: vec![Vec3::ZERO; 8],
        uvs: vec![Vec2::ZERO; 8],
        indices: faces
            .iter()
            .flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d])
            .collect(),
        ..Mesh::default()
    }
}

/// A ball around the origin, of `around` × `around / 2` patches.
pub(crate) fn ball(radius: f32, around: u32) -> Mesh {
    let (rings, row) = (around / 2, around + 1);
    let mut mesh = Mesh::default();
    for ring in 0..=rings {
        let (sin_polar, cos_polar) = (std::f32::consts::PI * ring as f32 / rings as f32).sin_cos();
        for segment in 0..=around {
            let turn = std::f32::consts::TAU * (segment % around) as f32 / around as f32;
            let normal = Vec3::new(sin_polar * turn.sin(), cos_polar, sin_polar * turn.cos());
            mesh.positions.push(radius * normal);
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::ZERO);
        }
    }
    for first in (0..rings).flat_map(|ring| (0..around).map(move |segment| ring * row + segment)) {
        let next = first + row;
        mesh.indices
            .extend([first, next, next + 1, first, next + 1, first + 1]);
    }
    mesh
}
