//! Binds what a shader reads, by the names that its reflection gives; what was bound before is there already.

use std::collections::HashMap;

use umbrage_compose::{Binding, BindingKind, Key};
use umbrage_shadow::{Constants, SamplerDesc, Value};

use crate::{Error, Program, ShadowResources, device, pack::pack_into, pack_buffer};

/// A device and its queue.
pub type Gpu<'a> = (&'a wgpu::Device, &'a wgpu::Queue);

/// A resource to bind.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Resource {
    /// All of a buffer.
    Buffer(wgpu::Buffer),
    /// A view of a texture.
    Texture(wgpu::TextureView),
    /// A sampler.
    Sampler(wgpu::Sampler),
}

/// Makes blocks, storage buffers, samplers, views and bind groups, and keeps them from frame to frame: a block of the same
/// bytes is the same buffer, and a group of the same resources the same group. A buffer whose bytes no one asked for
/// in the last frame takes others.
///
/// A frame ends where [`begin_frame`](Self::begin_frame) is called for the next one; what was recorded with resources
/// of a frame must be submitted by then, as the next frame may put other bytes into its buffers.
pub struct Binder {
    device: wgpu::Device,
    queue: wgpu::Queue,
    frame: u64,
    uniforms: Pool,
    storages: Pool,
    samplers: HashMap<SamplerKey, wgpu::Sampler>,
    views: HashMap<(wgpu::Texture, Part), Used<wgpu::TextureView>>,
    groups: HashMap<wgpu::BindGroupLayout, HashMap<Vec<Resource>, Used<wgpu::BindGroup>>>,
    bytes: Vec<u8>,
}

/// Frames for which a view or a group is kept that no one asks for.
const KEPT: u64 = 8;

/// A thing, and the frame that asked for it last.
struct Used<T>(T, u64);

/// A sampler's description, in numbers.
type SamplerKey = (
    [wgpu::AddressMode; 2],
    [wgpu::FilterMode; 2],
    bool,
    Option<wgpu::CompareFunction>,
);

/// The part of a texture that a view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Part {
    pub(crate) dimension: wgpu::TextureViewDimension,
    /// The first layer, and how many.
    pub(crate) layers: [u32; 2],
    /// The first mip level, and how many where not all.
    pub(crate) level: (u32, Option<u32>),
}

/// Buffers of one usage, by their bytes.
struct Pool {
    usage: wgpu::BufferUsages,
    used: HashMap<Vec<u8>, Used<Numbered>>,
    /// Buffers whose bytes no one needs, by descending number, and since when.
    free: Vec<Used<Numbered>>,
    made: u64,
}

/// A buffer and its number, in the order of making: what is free is taken in this order, so that a frame like the last but
/// one gets its buffers, and so its groups.
struct Numbered(wgpu::Buffer, u64);

impl Pool {
    fn new(usage: wgpu::BufferUsages) -> Self {
        Self {
            usage,
            used: HashMap::new(),
            free: Vec::new(),
            made: 0,
        }
    }

    fn begin_frame(&mut self, ended: u64) {
        let stale = self.used.extract_if(|_, used| used.1 < ended);
        self.free.extend(stale.map(|(_, used)| used));
        self.free.retain(|free| free.1 + KEPT > ended);
        self.free.sort_unstable_by_key(|free| u64::MAX - free.0.1);
    }

    /// The buffer that holds `bytes`; `what` names it in an error.
    fn buffer(
        &mut self,
        gpu: Gpu<'_>,
        (what, frame): (&str, u64),
        bytes: &[u8],
    ) -> Result<wgpu::Buffer, Error> {
        if let Some(known) = self.used.get_mut(bytes) {
            known.1 = frame;
            return Ok(known.0.0.clone());
        }
        let size = bytes.len() as u64;
        let fits = |free: &Used<Numbered>| free.0.0.size() == size;
        let numbered = match self.free.iter().rposition(fits) {
            Some(place) => {
                let Used(numbered, _) = self.free.remove(place);
                gpu.1.write_buffer(&numbered.0, 0, bytes);
                numbered
            }
            None => {
                self.made += 1;
                Numbered(device::buffer(gpu, what, self.usage, bytes)?, self.made)
            }
        };
        let buffer = numbered.0.clone();
        self.used.insert(bytes.to_vec(), Used(numbered, frame));
        Ok(buffer)
    }
}

impl Binder {
    /// A binder of a device.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self {
            device: device.clone(),
            queue: queue.clone(),
            frame: 0,
            uniforms: Pool::new(wgpu::BufferUsages::UNIFORM),
            storages: Pool::new(wgpu::BufferUsages::STORAGE),
            samplers: HashMap::new(),
            views: HashMap::new(),
            groups: HashMap::new(),
            bytes: Vec::new(),
        }
    }

    /// Begins a frame, when all that was recorded before is submitted: what the frame before did not ask for is let go.
    pub fn begin_frame(&mut self) {
        let ended = self.frame;
        self.frame += 1;
        self.uniforms.begin_frame(ended);
        self.storages.begin_frame(ended);
        self.views.retain(|_, used| used.1 + KEPT > ended);
        self.groups.retain(|_, groups| {
            groups.retain(|_, used| used.1 + KEPT > ended);
            !groups.is_empty()
        });
    }

    /// Lets go of everything.
    pub fn clear(&mut self) {
        let (device, queue) = (self.device.clone(), self.queue.clone());
        *self = Self::new(&device, &queue);
    }

    /// A buffer with the values that the block of `binding` reads of `constants`.
    ///
    /// # Errors
    /// A binding that is no [block](BindingKind::block); a member without a value, or with one of another type.
    pub fn block(
        &mut self,
        key: &Key,
        binding: &Binding,
        constants: &Constants,
    ) -> Result<Resource, Error> {
        let Some(layout) = binding.kind.block() else {
            let problem = "a block of constants was expected";
            return Err(Error::binding(key, binding, problem));
        };
        pack_into(&mut self.bytes, layout, constants)
            .map_err(|error| Error::binding(key, binding, error))?;
        let pool = match &binding.kind {
            BindingKind::Uniform(_) => &mut self.uniforms,
            _ => &mut self.storages,
        };
        let gpu = (&self.device, &self.queue);
        let made = pool.buffer(gpu, (&binding.name, self.frame), words(&mut self.bytes))?;
        Ok(Resource::Buffer(made))
    }

    /// A storage buffer that holds `value` as `binding` lays it out.
    ///
    /// # Errors
    /// A binding of another kind; a value of another type.
    pub fn storage(
        &mut self,
        key: &Key,
        binding: &Binding,
        value: &Value,
    ) -> Result<Resource, Error> {
        let BindingKind::Storage {
            layout, run_time, ..
        } = &binding.kind
        else {
            let problem = "a storage buffer was expected";
            return Err(Error::binding(key, binding, problem));
        };
        let mut bytes = pack_buffer(&binding.name, (layout, *run_time), value)
            .map_err(|error| Error::binding(key, binding, error))?;
        let (gpu, what) = ((&self.device, &self.queue), (&*binding.name, self.frame));
        let made = self.storages.buffer(gpu, what, words(&mut bytes))?;
        Ok(Resource::Buffer(made))
    }

    /// A sampler that clamps to the edge.
    pub(crate) fn plans_sampler(&mut self, desc: &SamplerDesc) -> wgpu::Sampler {
        self.sampler(&wgpu::SamplerDescriptor {
            mag_filter: desc.filter,
            min_filter: desc.filter,
            compare: desc.compare,
            ..Default::default()
        })
    }

    /// The sampler of this description, of which the address modes across and down, the filters, and the comparison count.
    pub fn sampler(&mut self, desc: &wgpu::SamplerDescriptor<'_>) -> wgpu::Sampler {
        let smooth = desc.mipmap_filter == wgpu::MipmapFilterMode::Linear;
        let key = (
            [desc.address_mode_u, desc.address_mode_v],
            [desc.mag_filter, desc.min_filter],
            smooth,
            desc.compare,
        );
        let made = self.samplers.entry(key);
        made.or_insert_with(|| self.device.create_sampler(desc))
            .clone()
    }

    /// The view of a part of a texture.
    pub(crate) fn view(&mut self, texture: &wgpu::Texture, part: Part) -> wgpu::TextureView {
        let id = (texture.clone(), part);
        let view = self.views.entry(id).or_insert_with_key(|(texture, _)| {
            let [first, count] = part.layers;
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(part.dimension),
                base_array_layer: first,
                array_layer_count: Some(count),
                base_mip_level: part.level.0,
                mip_level_count: part.level.1,
                ..Default::default()
            });
            Used(view, 0)
        });
        view.1 = self.frame;
        view.0.clone()
    }

    #[allow(
        clippy::mutable_key_type,
        reason = "a handle's hash is that of its identity, which does not change"
    )]
    /// The bind group number `group` of a program, each binding as `resource` gives it; none where the shader reads nothing
    /// of it.
    ///
    /// # Errors
    /// Errors of `resource`.
    pub fn bind<E>(
        &mut self,
        program: &Program,
        group: usize,
        mut resource: impl FnMut(&mut Self, &Binding) -> Result<Resource, E>,
    ) -> Result<Option<wgpu::BindGroup>, E> {
        let Some(layout) = program.groups.get(group).and_then(Option::as_ref) else {
            return Ok(None);
        };
        let bindings = program.bindings(group);
        let resources = bindings.map(|binding| resource(self, binding));
        let resources = resources.collect::<Result<Vec<_>, E>>()?;
        let known = self.groups.get_mut(layout);
        if let Some(known) = known.and_then(|known| known.get_mut(&resources)) {
            known.1 = self.frame;
            return Ok(Some(known.0.clone()));
        }
        let entries: Vec<_> = (program.bindings(group).zip(&resources))
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: binding.binding,
                resource: match resource {
                    Resource::Buffer(buffer) => buffer.as_entire_binding(),
                    Resource::Texture(view) => wgpu::BindingResource::TextureView(view),
                    Resource::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
                },
            })
            .collect();
        let made = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("bindings"),
            layout,
            entries: &entries,
        });
        let groups = self.groups.entry(layout.clone()).or_default();
        groups.insert(resources, Used(made.clone(), self.frame));
        Ok(Some(made))
    }

    /// All bind groups of a shader that reads lights and their shadows, one for each of its permutation's keys, and uniform
    /// blocks of these names.
    ///
    /// # Errors
    /// Another binding; a member without a value, or with one of another type.
    pub fn groups(
        &mut self,
        program: &Program,
        lights: &[&ShadowResources],
        blocks: &[(&str, &Constants)],
    ) -> Result<Groups, Error> {
        let key = &program.permutation.key;
        let mut given = |binder: &mut Self, binding: &Binding| {
            let mut blocks = blocks.iter();
            if let Some((_, constants)) = blocks.find(|(name, _)| *name == binding.name) {
                return binder.block(key, binding, constants);
            }
            let light = lights.get(binding.instance);
            let found = light.map(|light| binder.of_light(light, key, binding));
            found.transpose()?.flatten().ok_or_else(|| {
                let problem =
                    "the shader reads it, but it is none of what its light and shadow method give";
                Error::binding(key, binding, problem)
            })
        };
        let all = (0..program.groups.len()).map(|group| {
            let bound = self.bind(program, group, &mut given)?;
            Ok(bound.map(|bound| (group as u32, bound)))
        });
        let all = all.collect::<Result<Vec<_>, Error>>()?;
        Ok(Groups(all.into_iter().flatten().collect()))
    }

    /// A light's resource for `binding`; none where it has nothing of that name.
    ///
    /// # Errors
    /// A value of another type than the shader's.
    pub fn of_light(
        &mut self,
        light: &ShadowResources,
        key: &Key,
        binding: &Binding,
    ) -> Result<Option<Resource>, Error> {
        let name = binding.name.as_str();
        if let Some(buffer) = light.written.get(name) {
            return Ok(Some(Resource::Buffer(buffer.clone())));
        }
        if let Some(value) = light.buffers.get(name) {
            return self.storage(key, binding, value).map(Some);
        }
        Ok(match &binding.kind {
            kind if kind.block().is_some() => {
                let constants = match name {
                    "light" => &light.light,
                    _ => &light.constants,
                };
                Some(self.block(key, binding, constants)?)
            }
            BindingKind::Storage { .. } => None,
            BindingKind::Sampler { .. } => {
                let found = light.samplers.get(name);
                found.map(|(_, sampler)| Resource::Sampler(sampler.clone()))
            }
            _ => {
                let found = light.textures.get(name);
                found.map(|(_, view)| Resource::Texture(view.clone()))
            }
        })
    }
}

/// The bytes, with zeros up to the next word: copies come in words.
fn words(bytes: &mut Vec<u8>) -> &[u8] {
    let padded = bytes.len().div_ceil(4).max(1) * 4;
    bytes.resize(padded, 0);
    bytes
}

/// All bind groups that a shader reads.
pub struct Groups(Vec<(u32, wgpu::BindGroup)>);

impl Groups {
    /// Sets them for the draws that follow.
    pub fn set(&self, pass: &mut wgpu::RenderPass<'_>) {
        for (group, bound) in &self.0 {
            pass.set_bind_group(*group, bound, &[]);
        }
    }

    /// Sets them for the dispatches that follow.
    pub fn set_compute(&self, pass: &mut wgpu::ComputePass<'_>) {
        for (group, bound) in &self.0 {
            pass.set_bind_group(*group, bound, &[]);
        }
    }
}
