//! The hash of all that the truth of a scene depends on.

use std::{collections::HashMap, sync::Arc};

use glam::DVec3;
use umbrage_render::{Material, Mesh, Scene, Texture, Wrap};
use umbrage_shadow::{Field, LightKind};

use super::Source;

/// The tracer itself: another tracer may find another truth.
const CODE: [&str; 6] = [
    include_str!("mod.rs"),
    include_str!("lamp.rs"),
    include_str!("opacity.rs"),
    include_str!("ray.rs"),
    include_str!("record.rs"),
    include_str!("triangles.rs"),
];

/// The hash of what decides the truth of `scene` in a picture of the given size, as hexadecimal digits.
/// Colours but for their opacity, names and shadow methods decide nothing, but for whether a light casts shadows.
pub(super) fn content(scene: &Scene, size: (u32, u32), sources: &[Source]) -> String {
    let mut hash = Hash::default();
    CODE.iter().for_each(|code| hash.bytes(code.as_bytes()));
    hash.number(size.0);
    hash.number(size.1);
    let camera = &scene.camera;
    hash.point(camera.position);
    hash.floats(&camera.rotation.to_array());
    let (kind, across) = match camera.field {
        Field::Perspective { fov_y } => (0, fov_y),
        Field::Orthographic { height } => (1, height),
    };
    hash.number(kind);
    hash.floats(&[across, camera.near, camera.far]);
    hash.number(scene.lights.len() as u32);
    for (index, light) in scene.lights.iter().enumerate() {
        hash.light(&light.light.kind);
        hash.number(u32::from(scene.casts_shadow(light)));
        match sources.get(index).copied().unwrap_or_default() {
            Source::Sharp => hash.number(0),
            Source::Round { size, strata } => {
                hash.number(strata);
                hash.float(size);
            }
        }
    }
    hash.number(scene.objects.len() as u32);
    let (mut meshes, mut materials) = (Shared::default(), Shared::default());
    for object in &scene.objects {
        hash.floats(&object.transform.to_cols_array());
        let (number, is_new) = meshes.number(&object.mesh);
        hash.number(number);
        if is_new {
            hash.mesh(&object.mesh);
        }
        let (number, is_new) = materials.number(&object.material);
        hash.number(number);
        if is_new {
            hash.material(&object.material);
        }
    }
    hash.0.finalize().to_hex().to_string()
}

/// Numbers what objects share, by first appearance.
struct Shared<T>(HashMap<*const T, u32>);

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<T> Shared<T> {
    fn number(&mut self, shared: &Arc<T>) -> (u32, bool) {
        let next = self.0.len() as u32;
        let number = *self.0.entry(Arc::as_ptr(shared)).or_insert(next);
        (number, number == next)
    }
}

#[derive(Default)]
struct Hash(blake3::Hasher);

impl Hash {
    fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
    }

    fn number(&mut self, number: u32) {
        self.0.update(&number.to_le_bytes());
    }

    fn float(&mut self, number: f64) {
        self.0.update(&number.to_le_bytes());
    }

    fn floats(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|number| self.float(*number));
    }

    fn point(&mut self, point: DVec3) {
        self.floats(&point.to_array());
    }

    fn light(&mut self, kind: &LightKind) {
        match *kind {
            LightKind::Directional { direction } => {
                self.number(0);
                self.point(direction);
            }
            LightKind::Spot {
                position,
                direction,
                outer_angle,
                range,
                inner_angle: _,
            } => {
                self.number(1);
                self.point(position);
                self.point(direction);
                self.float(outer_angle);
                self.float(range);
            }
            LightKind::Point { position, range } => {
                self.number(2);
                self.point(position);
                self.float(range);
            }
        }
    }

    fn mesh(&mut self, mesh: &Mesh) {
        self.number(mesh.positions.len() as u32);
        for number in mesh.positions.iter().flat_map(|p| p.to_array()) {
            self.0.update(&number.to_le_bytes());
        }
        self.number(mesh.uvs.len() as u32);
        for number in mesh.uvs.iter().flat_map(|uv| uv.to_array()) {
            self.0.update(&number.to_le_bytes());
        }
        self.number(mesh.colors.len() as u32);
        for color in &mesh.colors {
            self.float(color.w.into());
        }
        self.number(mesh.indices.len() as u32);
        mesh.indices.iter().for_each(|index| self.number(*index));
    }

    fn material(&mut self, material: &Material) {
        self.number(u32::from(material.casts));
        let Some(cutoff) = material.alpha_cutoff else {
            return self.number(0);
        };
        self.number(1);
        self.float(cutoff.into());
        self.float(material.base_color.w.into());
        match &material.base_color_texture {
            None => self.number(0),
            Some(texture) => self.opacity(texture),
        }
    }

    fn opacity(&mut self, texture: &Texture) {
        self.number(1 + u32::from(texture.smooth));
        for wrap in texture.wrap {
            self.number(match wrap {
                Wrap::Repeat => 0,
                Wrap::Mirror => 1,
                Wrap::Clamp => 2,
            });
        }
        let Some(level) = texture.image.levels.first() else {
            return self.number(0);
        };
        self.number(level.width);
        self.number(level.height);
        let opacities: Vec<u8> = level.rgba.iter().map(|texel| texel[3]).collect();
        self.bytes(&opacities);
    }
}
