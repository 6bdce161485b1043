//! The objects of a scene in the order in which they are drawn: those that share a mesh and a material stand together, and
//! are drawn as instances. The order, and where each object stands, is kept from frame to frame while the scene is the same.

use std::{
    collections::HashMap,
    sync::{Arc, Weak},
};

use glam::{DAffine3, DMat4, DVec3, Mat4};
use umbrage_compose::{Binding, BindingKind, Key, Layout, MemberType};
use umbrage_shadow::Aabb;
use umbrage_wgpu::{Error, Identity, Resource};

use super::lists::{Draw, Lists};
use crate::{
    Gpu, RenderError, Scene,
    normals::normal_matrix,
    scene::{Material, Mesh, Object},
};

/// The objects of a frame; an object's place in drawing order is its slot.
pub(super) struct Objects<'a> {
    scene: &'a Scene,
    kept: Kept,
}

/// State of a scene's objects that is kept from frame to frame.
#[derive(Default)]
pub(super) struct Kept {
    batches: Vec<Batch>,
    /// By slot.
    entries: Vec<Entry>,
    /// The camera that matrices are relative to.
    eye: DVec3,
    /// Counts the changes of matrices.
    changes: u64,
    /// The array of instances for each layout of its element, and the change that it has.
    instances: Vec<(Layout, wgpu::Buffer, u64)>,
    /// Numbers that casters are known by, none of which is given twice.
    next_number: u64,
    lists: Lists,
    casters: Casters,
    visible: Arc<Vec<usize>>,
}

/// The objects whose material casts, in the order of their slots.
#[derive(Default)]
pub(super) struct Casters {
    pub(super) slots: Vec<usize>,
    pub(super) identities: Vec<Identity>,
    pub(super) bounds: Vec<Aabb>,
}

/// Objects that one draw may cover.
struct Batch {
    /// Held weakly, so that no other gets their addresses.
    mesh: Weak<Mesh>,
    material: Weak<Material>,
    mirrored: bool,
}

struct Entry {
    /// Its place in the scene.
    index: usize,
    batch: usize,
    transform: DAffine3,
    identity: Identity,
    model: Mat4,
    normal: Mat4,
}

impl Batch {
    fn holds(&self, object: &Object) -> bool {
        std::ptr::eq(self.mesh.as_ptr(), Arc::as_ptr(&object.mesh))
            && std::ptr::eq(self.material.as_ptr(), Arc::as_ptr(&object.material))
            && self.mirrored == is_mirrored(object)
    }
}

fn is_mirrored(object: &Object) -> bool {
    object.transform.matrix3.determinant() < 0.0
}

impl<'a> Objects<'a> {
    /// The objects of `scene` relative to a camera at `eye`, with what was `kept` of the frame before.
    pub(super) fn new(scene: &'a Scene, eye: DVec3, mut kept: Kept) -> Self {
        let objects = &scene.objects;
        let same = |entry: &Entry| {
            let object = objects.get(entry.index);
            object.is_some_and(|object| kept.batches[entry.batch].holds(object))
        };
        if kept.entries.len() != objects.len() || !kept.entries.iter().all(same) {
            kept.order(objects);
        }
        kept.place(objects, eye);
        kept.lists.begin_frame(objects.len());
        Self { scene, kept }
    }

    /// State that the next frame needs.
    pub(super) fn keep(self) -> Kept {
        self.kept
    }

    /// Slots of what may be seen, ascending.
    pub(super) fn visible(&self) -> Arc<Vec<usize>> {
        Arc::clone(&self.kept.visible)
    }

    /// The casters, with their bounds and identities.
    pub(super) fn casters(&mut self) -> &mut Casters {
        &mut self.kept.casters
    }

    /// The object at `slot`, which is one.
    pub(super) fn at(&self, slot: usize) -> &'a Object {
        &self.scene.objects[self.kept.entries[slot].index]
    }

    /// All objects in the order of their slots.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, &'a Object)> {
        (0..self.kept.entries.len()).map(|slot| (slot, self.at(slot)))
    }

    /// The place in the scene of the object at `slot`.
    pub(super) fn index(&self, slot: usize) -> Option<usize> {
        self.kept.entries.get(slot).map(|entry| entry.index)
    }

    /// Has the visible objects be those that `sees` holds for.
    pub(super) fn look(&mut self, sees: impl Fn(&Aabb) -> bool) {
        let mut visible = std::mem::take(&mut self.kept.visible);
        let slots = Arc::make_mut(&mut visible);
        slots.clear();
        let seen = self.iter().filter(|(_, object)| sees(&object.bounds));
        slots.extend(seen.map(|(slot, _)| slot));
        self.kept.visible = visible;
    }

    /// The draws that cover the objects at `slots`, which ascend: one for each batch.
    pub(super) fn draws(&mut self, gpu: &Gpu, slots: &[usize]) -> Result<Vec<Draw>, RenderError> {
        let Kept { lists, entries, .. } = &mut self.kept;
        lists.list(gpu, slots, |slot| entries[slot].batch)
    }

    /// Whether the front faces of the objects at `draw` are wound the other way.
    pub(super) fn is_mirrored(&self, draw: &Draw) -> bool {
        self.kept.batches[draw.batch].mirrored
    }

    /// Puts the lists of objects where the device reads them: before what was recorded with them is submitted.
    pub(super) fn upload(&mut self, gpu: &Gpu) {
        self.kept.lists.upload(gpu);
    }

    /// The array of the frame's objects, laid out as `binding` reads it, or the list of those that are drawn.
    pub(super) fn resource(
        &mut self,
        gpu: &Gpu,
        key: &Key,
        binding: &Binding,
    ) -> Result<Resource, RenderError> {
        let BindingKind::Storage { layout, .. } = &binding.kind else {
            let problem = "a storage buffer was expected";
            return Err(Error::binding(key, binding, problem).into());
        };
        if binding.name == DRAWN {
            return Ok(Resource::Buffer(self.kept.lists.buffer(gpu)?));
        }
        let kept = &mut self.kept;
        let size = kept.entries.len().max(1) as u64 * u64::from(layout.size);
        let mut instances = kept.instances.iter();
        let known = instances.position(|(known, ..)| known == layout);
        if let Some((_, buffer, change)) = known.map(|place| &kept.instances[place])
            && buffer.size() == size
            && *change == kept.changes
        {
            return Ok(Resource::Buffer(buffer.clone()));
        }
        let bytes = kept.bytes(key, binding, layout)?;
        let known = known.map(|place| kept.instances.swap_remove(place).1);
        let buffer = match known.filter(|buffer| buffer.size() == size) {
            Some(buffer) => {
                gpu.queue.write_buffer(&buffer, 0, &bytes);
                buffer
            }
            None => gpu.buffer("the array of objects", wgpu::BufferUsages::STORAGE, &bytes)?,
        };
        let entry = (layout.clone(), buffer.clone(), kept.changes);
        kept.instances.push(entry);
        Ok(Resource::Buffer(buffer))
    }
}

/// The binding of the objects' matrices.
pub(super) const INSTANCES: &str = "instances";

/// The binding of the numbers of those that are drawn.
pub(super) const DRAWN: &str = "drawn";

impl Kept {
    /// Puts `objects` in order.
    fn order(&mut self, objects: &[Object]) {
        let known: HashMap<usize, Entry> = self.entries.drain(..).map(|e| (e.index, e)).collect();
        let known_batches = std::mem::take(&mut self.batches);
        // By first appearance, as addresses would change from run to run.
        let (mut meshes, mut materials) = (HashMap::new(), HashMap::new());
        let mut order = Vec::new();
        for (index, object) in objects.iter().enumerate() {
            let next = meshes.len();
            let mesh = *meshes.entry(Arc::as_ptr(&object.mesh)).or_insert(next);
            let next = materials.len();
            let material = Arc::as_ptr(&object.material);
            let material = *materials.entry(material).or_insert(next);
            order.push(((mesh, material, is_mirrored(object)), index));
        }
        order.sort_unstable();
        let mut last = None;
        for (batch, index) in order {
            let object = &objects[index];
            if last != Some(batch) {
                last = Some(batch);
                self.batches.push(Batch {
                    mesh: Arc::downgrade(&object.mesh),
                    material: Arc::downgrade(&object.material),
                    mirrored: batch.2,
                });
            }
            // An object that looks as it did stays the caster that it was.
            let same = known.get(&index).filter(|entry| {
                let batch = &known_batches[entry.batch];
                batch.holds(object) && entry.transform == object.transform
            });
            let identity = same.map(|entry| entry.identity).unwrap_or_else(|| {
                self.next_number += 1;
                Identity {
                    id: self.next_number,
                    revision: 0,
                }
            });
            self.entries.push(Entry {
                index,
                batch: self.batches.len() - 1,
                transform: object.transform,
                identity,
                model: Mat4::NAN,
                normal: Mat4::NAN,
            });
        }
        self.changes += 1;
        self.eye = DVec3::NAN;
    }

    /// Finds where objects stand relative to `eye`, and the casters among them.
    fn place(&mut self, objects: &[Object], eye: DVec3) {
        let all = self.eye != eye;
        self.eye = eye;
        let casters = &mut self.casters;
        casters.slots.clear();
        casters.identities.clear();
        casters.bounds.clear();
        let mut changed = all;
        for (slot, entry) in self.entries.iter_mut().enumerate() {
            let object = &objects[entry.index];
            let moved = entry.transform != object.transform;
            if moved {
                entry.transform = object.transform;
                entry.identity.revision += 1;
            }
            if moved || all {
                let mut transform = object.transform;
                transform.translation -= eye;
                entry.model = DMat4::from(transform).as_mat4();
            }
            if moved || entry.normal.is_nan() {
                let linear = object.transform.matrix3;
                entry.normal = Mat4::from_mat3(normal_matrix(linear).as_mat3());
            }
            changed |= moved;
            if object.material.casts {
                casters.slots.push(slot);
                casters.identities.push(entry.identity);
                casters.bounds.push(object.bounds);
            }
        }
        self.changes += u64::from(changed);
    }

    /// The bytes of the shader's array of instances, whose element has this layout.
    fn bytes(&self, key: &Key, binding: &Binding, layout: &Layout) -> Result<Vec<u8>, RenderError> {
        let size = layout.size as usize;
        let mut bytes = vec![0; self.entries.len().max(1) * size];
        for member in &layout.members {
            let matrix = match member.name.as_str() {
                "model" => |entry: &Entry| entry.model,
                "normal" => |entry: &Entry| entry.normal,
                other => {
                    let problem = format!(
                        "the shader reads `{other}` of an object, but it has `model` and `normal` alone"
                    );
                    return Err(Error::binding(key, binding, problem).into());
                }
            };
            let matrices = MemberType::Matrix {
                columns: 4,
                rows: 4,
            };
            if member.ty != matrices {
                let problem = format!("`{}` of an object is a matrix of 4 by 4", member.name);
                return Err(Error::binding(key, binding, problem).into());
            }
            let start = member.offset as usize;
            for (entry, bytes) in self.entries.iter().zip(bytes.chunks_exact_mut(size)) {
                let matrix = matrix(entry);
                bytes[start..start + 64].copy_from_slice(bytemuck::bytes_of(&matrix));
            }
        }
        Ok(bytes)
    }
}
