//! Binds what a shader reads, by the names that its reflection gives.

use umbrage_compose::{Binding, BindingKind, Key};
use umbrage_shadow::{Constants, Value};

use crate::{Error, Program, ShadowResources, device, pack, pack_buffer};

/// A device and its queue.
pub type Gpu<'a> = (&'a wgpu::Device, &'a wgpu::Queue);

/// A resource to bind.
#[derive(Clone, Debug)]
pub enum Resource {
    /// All of a buffer.
    Buffer(wgpu::Buffer),
    /// A view of a texture.
    Texture(wgpu::TextureView),
    /// A sampler.
    Sampler(wgpu::Sampler),
}

impl Resource {
    /// A buffer with the values that the block of `binding` reads of `constants`.
    ///
    /// # Errors
    /// A binding that is no [block](BindingKind::block); a member without a value, or with one of another type.
    pub fn block(
        gpu: Gpu<'_>,
        key: &Key,
        binding: &Binding,
        constants: &Constants,
    ) -> Result<Self, Error> {
        let Some(layout) = binding.kind.block() else {
            let problem = "a block of constants was expected";
            return Err(Error::binding(key, binding, problem));
        };
        let bytes = pack(layout, constants).map_err(|e| Error::binding(key, binding, e))?;
        let usage = match &binding.kind {
            BindingKind::Uniform(_) => wgpu::BufferUsages::UNIFORM,
            _ => wgpu::BufferUsages::STORAGE,
        };
        Self::buffer(gpu, binding, usage, &bytes)
    }

    /// A storage buffer that holds `value` as `binding` lays it out.
    ///
    /// # Errors
    /// A binding of another kind; a value of another type.
    pub fn storage(
        gpu: Gpu<'_>,
        key: &Key,
        binding: &Binding,
        value: &Value,
    ) -> Result<Self, Error> {
        let BindingKind::Storage {
            layout, run_time, ..
        } = &binding.kind
        else {
            let problem = "a storage buffer was expected";
            return Err(Error::binding(key, binding, problem));
        };
        let bytes = pack_buffer(&binding.name, (layout, *run_time), value)
            .map_err(|error| Error::binding(key, binding, error))?;
        Self::buffer(gpu, binding, wgpu::BufferUsages::STORAGE, &bytes)
    }

    fn buffer(
        gpu: Gpu<'_>,
        binding: &Binding,
        usage: wgpu::BufferUsages,
        bytes: &[u8],
    ) -> Result<Self, Error> {
        let made = device::buffer(gpu, &binding.name, usage, bytes)?;
        Ok(Self::Buffer(made))
    }
}

/// All bind groups of a shader that reads lights and their shadows, one for each of its permutation's keys, and uniform
/// blocks of these names.
///
/// # Errors
/// Another binding; a member without a value, or with one of another type.
pub fn groups(
    gpu: Gpu<'_>,
    program: &Program,
    lights: &[&ShadowResources],
    blocks: &[(&str, &Constants)],
) -> Result<Groups, Error> {
    let key = &program.permutation.key;
    program.groups(gpu.0, |binding| {
        let mut blocks = blocks.iter();
        match blocks.find(|(name, _)| *name == binding.name) {
            Some((_, constants)) => Resource::block(gpu, key, binding, constants).map(Some),
            None => match lights.get(binding.instance) {
                Some(light) => light.resource(gpu, key, binding),
                None => Ok(None),
            },
        }
    })
}

impl ShadowResources {
    /// The light's resource for `binding`; none where it has nothing of that name.
    ///
    /// # Errors
    /// A value of another type than the shader's.
    pub fn resource(
        &self,
        gpu: Gpu<'_>,
        key: &Key,
        binding: &Binding,
    ) -> Result<Option<Resource>, Error> {
        let name = binding.name.as_str();
        if let Some(buffer) = self.written.get(name) {
            return Ok(Some(Resource::Buffer(buffer.clone())));
        }
        if let Some(value) = self.buffers.get(name) {
            return Resource::storage(gpu, key, binding, value).map(Some);
        }
        Ok(match &binding.kind {
            kind if kind.block().is_some() => {
                let constants = match name {
                    "light" => &self.light,
                    _ => &self.constants,
                };
                Some(Resource::block(gpu, key, binding, constants)?)
            }
            BindingKind::Storage { .. } => None,
            BindingKind::Sampler { .. } => {
                let found = self.samplers.get(name);
                found.map(|(_, sampler)| Resource::Sampler(sampler.clone()))
            }
            _ => {
                let found = self.textures.get(name);
                found.map(|(_, view)| Resource::Texture(view.clone()))
            }
        })
    }
}

impl Program {
    /// The bind group number `group`, each binding as `resource` gives it; none where the shader reads nothing of it.
    ///
    /// # Errors
    /// Errors of `resource`.
    pub fn bind<E>(
        &self,
        device: &wgpu::Device,
        group: usize,
        mut resource: impl FnMut(&Binding) -> Result<Resource, E>,
    ) -> Result<Option<wgpu::BindGroup>, E> {
        let Some(layout) = self.groups.get(group).and_then(Option::as_ref) else {
            return Ok(None);
        };
        let bindings = self.bindings(group);
        let resources = bindings.map(|binding| Ok((binding.binding, resource(binding)?)));
        let resources = resources.collect::<Result<Vec<_>, E>>()?;
        let entries: Vec<_> = resources
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: match resource {
                    Resource::Buffer(buffer) => buffer.as_entire_binding(),
                    Resource::Texture(view) => wgpu::BindingResource::TextureView(view),
                    Resource::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
                },
            })
            .collect();
        Ok(Some(device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("bindings"),
            layout,
            entries: &entries,
        })))
    }
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

impl Program {
    /// All bind groups, each binding as `resource` gives it.
    ///
    /// # Errors
    /// A binding for which it gives nothing, and its own errors.
    pub fn groups(
        &self,
        device: &wgpu::Device,
        mut resource: impl FnMut(&Binding) -> Result<Option<Resource>, Error>,
    ) -> Result<Groups, Error> {
        let key = &self.permutation.key;
        let mut given = |binding: &Binding| {
            resource(binding)?.ok_or_else(|| {
                let problem =
                    "the shader reads it, but it is none of what its light and shadow method give";
                Error::binding(key, binding, problem)
            })
        };
        let all = (0..self.groups.len()).map(|group| {
            let bound = self.bind(device, group, &mut given)?;
            Ok(bound.map(|bound| (group as u32, bound)))
        });
        let all = all.collect::<Result<Vec<_>, Error>>()?;
        Ok(Groups(all.into_iter().flatten().collect()))
    }
}
