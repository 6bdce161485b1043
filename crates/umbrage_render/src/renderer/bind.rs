//! Binds what a shader reads, by the names that its reflection gives.

use std::sync::Arc;

use umbrage_compose::{Binding, BindingKind, Key};
use umbrage_shadow::{Constants, Value};

use umbrage_wgpu::{Error, Program, Resource};

use super::{
    Renderer,
    assets::{self, Assets},
    frame::{FrameState, PassInputs, SEEN_DEPTH, SEEN_PLANES},
};
use crate::{
    Gpu, RenderError,
    scene::{Image, Object},
};

impl Renderer {
    /// Bind groups of a program that draws no object.
    pub(super) fn bind_all(
        &mut self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        program: &Program,
    ) -> Result<Vec<Option<wgpu::BindGroup>>, RenderError> {
        let groups = 0..program.groups.len();
        groups
            .map(|group| self.bind(frame, inputs, program, group, None))
            .collect()
    }

    pub(super) fn bind(
        &mut self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        program: &Program,
        group: usize,
        object: Option<&Object>,
    ) -> Result<Option<wgpu::BindGroup>, RenderError> {
        let gpu = Arc::clone(&self.gpu);
        let key = &program.permutation.key;
        program.bind(&gpu.device, group, |binding| match group {
            LIGHT => self.light_resource(frame, inputs, key, binding),
            MATERIAL => self.stock().material(&gpu, object, key, binding),
            _ => self.frame_resource(frame, inputs, key, binding),
        })
    }

    fn stock(&mut self) -> Stock<'_> {
        Stock {
            assets: &mut self.assets,
            white: &self.white,
        }
    }

    fn block(
        &self,
        key: &Key,
        binding: &Binding,
        constants: &Constants,
    ) -> Result<Resource, RenderError> {
        Ok(Resource::block(self.gpu.parts(), key, binding, constants)?)
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
        let id = (light, binding.name.clone(), binding.kind.clone());
        if let Some((_, known)) = frame.buffers.iter().find(|(known, _)| *known == id) {
            return Ok(known.clone());
        }
        let made = Resource::storage(self.gpu.parts(), key, binding, value)?;
        frame.buffers.push((id, made.clone()));
        Ok(made)
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
                let constants = Constants::new().with("view_proj", inputs.view_proj);
                self.block(key, binding, &constants)
            }
            ("ambient", _) => {
                let constants = Constants::new().with("radiance", inputs.ambient);
                self.block(key, binding, &constants)
            }
            ("rays", _) => self.block(key, binding, &frame.rays),
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
            ("instances", _) => frame.instances(&self.gpu, key, binding),
            _ => Err(unknown(
                key,
                binding,
                "what the frame gives, `frame`, `ambient`, `rays`, `instances`, to a mask `seen_planes`, and to air \
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
        let Some(light) = inputs.lights.get(binding.instance) else {
            return Err(unknown(key, binding, "what a pass without a light gives"));
        };
        match (binding.name.as_str(), &binding.kind) {
            ("light", kind) if kind.block().is_some() => self.block(key, binding, light.constants),
            ("cookie_texture", _) => {
                let cookie = light.setup.source.cookie.clone();
                let what = format!("the cookie of light `{}`", light.setup.source.name);
                let gpu = Arc::clone(&self.gpu);
                Ok(Resource::Texture(self.stock().image(&gpu, &what, cookie)?))
            }
            ("cookie_sampler", _) => Ok(Resource::Sampler(assets::sampler(&self.gpu, None))),
            (name, _) => {
                let shadow = light.shadow.ok_or_else(|| unknown(key, binding, own))?;
                if let Some(value) = shadow.buffers.get(name) {
                    return self.storage(frame, light.setup.index, key, binding, value);
                }
                let found = shadow.resource(self.gpu.parts(), key, binding)?;
                found.ok_or_else(|| unknown(key, binding, own))
            }
        }
    }
}

/// Where objects' meshes and pictures come from.
pub(super) struct Stock<'a> {
    pub(super) assets: &'a mut Assets,
    /// Stands in for a texture that an object does not have.
    pub(super) white: &'a Arc<Image>,
}

impl Stock<'_> {
    /// The resource of an object's material for `binding`.
    pub(super) fn material(
        &mut self,
        gpu: &Gpu,
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
                    .with("base_color", material.base_color)
                    .with("roughness", material.roughness)
                    .with("metallic", material.metallic)
                    .with("alpha_cutoff", material.alpha_cutoff.unwrap_or_default());
                Ok(Resource::block(gpu.parts(), key, binding, &constants)?)
            }
            "base_color_texture" => {
                let what = format!("the texture of object `{}`", object.name);
                let image = texture.map(|texture| Arc::clone(&texture.image));
                Ok(Resource::Texture(self.image(gpu, &what, image)?))
            }
            "base_color_sampler" => Ok(Resource::Sampler(assets::sampler(gpu, texture))),
            _ => Err(unknown(key, binding, "what a material gives")),
        }
    }

    /// The picture on the device; white where an axis was forced on without one.
    fn image(
        &mut self,
        gpu: &Gpu,
        what: &str,
        image: Option<Arc<Image>>,
    ) -> Result<wgpu::TextureView, RenderError> {
        let image = image.unwrap_or_else(|| Arc::clone(self.white));
        self.assets.image(gpu, what, &image)
    }
}

impl FrameState<'_> {
    /// The array of the frame's objects, laid out as `binding` reads it.
    pub(super) fn instances(
        &mut self,
        gpu: &Gpu,
        key: &Key,
        binding: &Binding,
    ) -> Result<Resource, RenderError> {
        let BindingKind::Storage { layout, .. } = &binding.kind else {
            let problem = "a storage buffer was expected";
            return Err(Error::binding(key, binding, problem).into());
        };
        if let Some((_, known)) = self.instances.iter().find(|(l, _)| l == layout) {
            return Ok(Resource::Buffer(known.clone()));
        }
        let bytes = self.objects.instances(layout);
        let bytes = bytes.map_err(|error| Error::binding(key, binding, error))?;
        let usage = wgpu::BufferUsages::STORAGE;
        let buffer = gpu.buffer("the list of objects", usage, &bytes)?;
        self.instances.push((layout.clone(), buffer.clone()));
        Ok(Resource::Buffer(buffer))
    }
}

/// The groups whose owners are not the frame: see `Binding::group`.
const LIGHT: usize = 1;
pub(super) const MATERIAL: usize = 2;

fn unknown(key: &Key, binding: &Binding, known: &str) -> RenderError {
    let problem = format!("the shader reads it, but it is none of {known}");
    Error::binding(key, binding, problem).into()
}
