//! Binds what a shader reads, by the names that its reflection gives.

use std::sync::Arc;

use umbrage_compose::{Binding, BindingKind, Key};
use umbrage_shadow::{Constants, Value};

use super::{
    Renderer,
    air::SEEN_DEPTH,
    assets,
    draw::{FrameState, PassInputs},
    pipelines::Program,
    seen::{SEEN_DEPTHS, SEEN_PLANES},
};
use crate::{
    RenderError, pack, pack_buffer,
    scene::{Image, Object},
};

impl Renderer {
    /// What a program reads that draws no object, group by group.
    pub(super) fn bind_all(
        &mut self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        program: &Program,
    ) -> Result<Vec<Option<wgpu::BindGroup>>, RenderError> {
        let groups = program.groups.iter().enumerate();
        groups
            .map(|(group, layout)| match layout {
                Some(layout) => self
                    .bind(frame, inputs, program, (group, layout), None)
                    .map(Some),
                None => Ok(None),
            })
            .collect()
    }

    pub(super) fn bind(
        &mut self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        program: &Program,
        (group, layout): (usize, &wgpu::BindGroupLayout),
        object: Option<&Object>,
    ) -> Result<wgpu::BindGroup, RenderError> {
        let mut resources = Vec::new();
        for binding in program.bindings(group) {
            let key = &program.permutation.key;
            let resource = match group {
                LIGHT => self.light_resource(frame, inputs, key, binding)?,
                MATERIAL => self.material_resource(object, key, binding)?,
                _ => self.frame_resource(frame, inputs, key, binding)?,
            };
            resources.push((binding.binding, resource));
        }
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
        let label = Some("bindings");
        let descriptor = wgpu::BindGroupDescriptor {
            label,
            layout,
            entries: &entries,
        };
        Ok(self.gpu.device.create_bind_group(&descriptor))
    }

    fn uniform(
        &self,
        key: &Key,
        binding: &Binding,
        constants: &Constants,
    ) -> Result<Resource, RenderError> {
        let BindingKind::Uniform(layout) = &binding.kind else {
            return Err(RenderError::binding(
                key,
                binding,
                "a uniform buffer was expected",
            ));
        };
        let bytes =
            pack(layout, constants).map_err(|error| RenderError::binding(key, binding, error))?;
        let usage = wgpu::BufferUsages::UNIFORM;
        Ok(Resource::Buffer(self.gpu.buffer(
            &binding.name,
            usage,
            &bytes,
        )?))
    }

    /// The buffer of a light's shadow method, made once for each layout that is read.
    fn storage(
        &self,
        frame: &mut FrameState<'_>,
        light: usize,
        key: &Key,
        binding: &Binding,
        value: &Value,
    ) -> Result<Resource, RenderError> {
        let BindingKind::Storage {
            layout, run_time, ..
        } = &binding.kind
        else {
            let problem = "a storage buffer was expected";
            return Err(RenderError::binding(key, binding, problem));
        };
        let id = (light, binding.name.clone(), binding.kind.clone());
        if let Some((_, known)) = frame.buffers.iter().find(|(known, _)| *known == id) {
            return Ok(Resource::Buffer(known.clone()));
        }
        let bytes = pack_buffer(&binding.name, (layout, *run_time), value)
            .map_err(|error| RenderError::binding(key, binding, error))?;
        let usage = wgpu::BufferUsages::STORAGE;
        let buffer = self.gpu.buffer(&binding.name, usage, &bytes)?;
        frame.buffers.push((id, buffer.clone()));
        Ok(Resource::Buffer(buffer))
    }

    fn frame_resource(
        &self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        key: &Key,
        binding: &Binding,
    ) -> Result<Resource, RenderError> {
        match (binding.name.as_str(), &binding.kind) {
            ("frame", _) => {
                let constants = Constants::new()
                    .with("view_proj", Value::Mat4(inputs.view_proj))
                    .with("ambient", Value::Vec3(inputs.ambient));
                self.uniform(key, binding, &constants)
            }
            ("rays", _) => self.uniform(key, binding, &frame.rays),
            (SEEN_PLANES, BindingKind::Texture { .. }) => {
                let nothing = "what passes before the masks give";
                let planes = frame.planes.clone();
                let planes = planes.ok_or_else(|| unknown(key, binding, nothing))?;
                Ok(Resource::Texture(planes))
            }
            (SEEN_DEPTH, BindingKind::Texture { .. }) => {
                let nothing = "what passes before the air's give";
                let depth = frame.seen_depth.clone();
                let depth = depth.ok_or_else(|| unknown(key, binding, nothing))?;
                Ok(Resource::Texture(depth))
            }
            (SEEN_DEPTHS, BindingKind::StorageTexture { .. }) => {
                let nothing = "what passes that look for no depths give";
                let depths = frame.depths.clone();
                let depths = depths.ok_or_else(|| unknown(key, binding, nothing))?;
                Ok(Resource::Texture(depths))
            }
            ("instances", BindingKind::Storage { layout, .. }) => {
                if let Some((_, known)) = frame.instances.iter().find(|(l, _)| l == layout) {
                    return Ok(Resource::Buffer(known.clone()));
                }
                let bytes = frame
                    .objects
                    .instances(layout)
                    .map_err(|error| RenderError::binding(key, binding, error))?;
                let usage = wgpu::BufferUsages::STORAGE;
                let buffer = self.gpu.buffer("the list of objects", usage, &bytes)?;
                frame.instances.push((layout.clone(), buffer.clone()));
                Ok(Resource::Buffer(buffer))
            }
            _ => Err(unknown(
                key,
                binding,
                "what the frame gives, `frame`, `rays`, `instances`, to a mask `seen_planes`, and to air \
                 `seen_depth`",
            )),
        }
    }

    fn light_resource(
        &mut self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        key: &Key,
        binding: &Binding,
    ) -> Result<Resource, RenderError> {
        let own = "what its light and shadow method give";
        let Some(light) = inputs.light else {
            return Err(unknown(key, binding, "what a pass without a light gives"));
        };
        match (binding.name.as_str(), &binding.kind) {
            ("light", BindingKind::Uniform(_)) => self.uniform(key, binding, light.constants),
            ("cookie_texture", _) => {
                let cookie = light.setup.source.cookie.clone();
                let what = format!("the cookie of light `{}`", light.setup.source.name);
                Ok(Resource::Texture(self.image(&what, cookie)?))
            }
            ("cookie_sampler", _) => Ok(Resource::Sampler(assets::sampler(&self.gpu, None))),
            (name, kind) => {
                let shadow = light.shadow.ok_or_else(|| unknown(key, binding, own))?;
                let found = match kind {
                    BindingKind::Uniform(_) => {
                        return self.uniform(key, binding, &shadow.constants);
                    }
                    BindingKind::Storage { .. } => match shadow.buffers.get(name) {
                        Some(value) => {
                            let light = light.setup.index;
                            return self.storage(frame, light, key, binding, value);
                        }
                        None => None,
                    },
                    BindingKind::Sampler { .. } => shadow
                        .samplers
                        .get(name)
                        .map(|(_, s)| Resource::Sampler(s.clone())),
                    _ => shadow
                        .textures
                        .get(name)
                        .map(|(_, t)| Resource::Texture(t.clone())),
                };
                found.ok_or_else(|| unknown(key, binding, own))
            }
        }
    }

    fn material_resource(
        &mut self,
        object: Option<&Object>,
        key: &Key,
        binding: &Binding,
    ) -> Result<Resource, RenderError> {
        let nothing = "what a pass that draws no object gives";
        let object = object.ok_or_else(|| unknown(key, binding, nothing))?;
        let material = &object.material;
        let texture = material.base_color_texture.as_ref();
        match binding.name.as_str() {
            "material" => {
                let constants = Constants::new()
                    .with("base_color", Value::Vec4(material.base_color))
                    .with("roughness", Value::F32(material.roughness))
                    .with("metallic", Value::F32(material.metallic))
                    .with(
                        "alpha_cutoff",
                        Value::F32(material.alpha_cutoff.unwrap_or_default()),
                    );
                self.uniform(key, binding, &constants)
            }
            "base_color_texture" => {
                let what = format!("the texture of object `{}`", object.name);
                let image = texture.map(|texture| Arc::clone(&texture.image));
                Ok(Resource::Texture(self.image(&what, image)?))
            }
            "base_color_sampler" => Ok(Resource::Sampler(assets::sampler(&self.gpu, texture))),
            _ => Err(unknown(key, binding, "what a material gives")),
        }
    }

    /// The picture on the device; white where an axis was forced on without one.
    fn image(
        &mut self,
        what: &str,
        image: Option<Arc<Image>>,
    ) -> Result<wgpu::TextureView, RenderError> {
        let image = image.unwrap_or_else(|| Arc::clone(&self.white));
        self.assets.image(&self.gpu, what, &image)
    }
}

/// The groups whose owners are not the frame: see `Binding::group`.
const LIGHT: usize = 1;
pub(super) const MATERIAL: usize = 2;

enum Resource {
    Buffer(wgpu::Buffer),
    Texture(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

fn unknown(key: &Key, binding: &Binding, known: &str) -> RenderError {
    let problem = format!("the shader reads it, but it is none of {known}");
    RenderError::binding(key, binding, problem)
}
