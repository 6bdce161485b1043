//! The objects of a scene in the order in which they are drawn: those that share a mesh and a
//! material stand together, and are drawn as instances.

use std::{collections::HashMap, ops::Range, sync::Arc};

use glam::{DVec3, Mat4};
use umbrage_compose::Layout;
use umbrage_shadow::{Constants, Value};

use crate::{PackError, Scene, normals::normal_matrix, pack, scene::Object};

/// The objects in drawing order; an object's place in it is its slot.
pub(super) struct Objects<'a> {
    entries: Vec<Entry<'a>>,
}

struct Entry<'a> {
    object: &'a Object,
    /// Its place in the scene.
    index: usize,
    /// Key that the instances of one draw share: mesh, material, and whether the transform mirrors.
    batch: (usize, usize, bool),
    model: Mat4,
    normal: Mat4,
}

/// Neighbouring slots that one draw covers.
pub(super) struct Run<'a> {
    pub(super) object: &'a Object,
    pub(super) mirrored: bool,
    pub(super) instances: Range<u32>,
}

impl<'a> Objects<'a> {
    /// The objects of `scene` relative to a camera at `eye`.
    pub(super) fn new(scene: &'a Scene, eye: DVec3) -> Self {
        // By first appearance, as addresses would change from run to run.
        let mut meshes = HashMap::new();
        let mut materials = HashMap::new();
        let mut order = Vec::new();
        for (index, object) in scene.objects.iter().enumerate() {
            let next = meshes.len();
            let mesh = *meshes.entry(Arc::as_ptr(&object.mesh)).or_insert(next);
            let next = materials.len();
            let material = *materials
                .entry(Arc::as_ptr(&object.material))
                .or_insert(next);
            let mirrored = object.transform.matrix3.determinant() < 0.0;
            order.push(((mesh, material, mirrored), index));
        }
        order.sort_unstable();
        let mut entries = Vec::new();
        for (batch, index) in order {
            let object = &scene.objects[index];
            let mut transform = object.transform;
            transform.translation -= eye;
            let model = glam::DMat4::from(transform).as_mat4();
            let normal = Mat4::from_mat3(normal_matrix(transform.matrix3).as_mat3());
            entries.push(Entry {
                object,
                index,
                batch,
                model,
                normal,
            });
        }
        Self { entries }
    }

    /// All slots with their objects.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, &'a Object)> {
        self.entries.iter().map(|entry| entry.object).enumerate()
    }

    /// The place in the scene of the object at `slot`.
    pub(super) fn index(&self, slot: usize) -> Option<usize> {
        self.entries.get(slot).map(|entry| entry.index)
    }

    /// The draws that cover `slots`, which ascend.
    pub(super) fn runs(&self, slots: &[usize]) -> Vec<Run<'a>> {
        let mut runs: Vec<(Run<'a>, (usize, usize, bool))> = Vec::new();
        for &slot in slots {
            let Some(entry) = self.entries.get(slot) else {
                continue;
            };
            let instance = slot as u32;
            match runs.last_mut() {
                Some((run, batch)) if *batch == entry.batch && run.instances.end == instance => {
                    run.instances.end += 1;
                }
                _ => {
                    let instances = instance..instance + 1;
                    let run = Run {
                        object: entry.object,
                        mirrored: entry.batch.2,
                        instances,
                    };
                    runs.push((run, entry.batch));
                }
            }
        }
        runs.into_iter().map(|(run, _)| run).collect()
    }

    /// The bytes of the shader's array of instances, whose element has this layout.
    pub(super) fn instances(&self, layout: &Layout) -> Result<Vec<u8>, PackError> {
        let mut bytes = Vec::with_capacity(self.entries.len() * layout.size as usize);
        for entry in &self.entries {
            let constants = Constants::new()
                .with("model", Value::Mat4(entry.model))
                .with("normal", Value::Mat4(entry.normal));
            bytes.extend(pack(layout, &constants)?);
        }
        Ok(bytes)
    }
}
