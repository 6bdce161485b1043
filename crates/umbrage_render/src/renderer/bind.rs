//! Binds what a shader reads, by the names that its reflection gives.

use std::sync::Arc;

use umbrage_compose::{Binding, BindingKind, Key};
use umbrage_shadow::Constants;
use umbrage_wgpu::{Binder, Error, Program, Resource};

use super::{
    Renderer,
    assets::{self, Assets},
    frame::{FrameState, PassInputs, SEEN_DEPTH, SEEN_PLANES},
    objects::{DRAWN, INSTANCES},
};
use crate::{
    Gpu, RenderError,
    scene::{Image, Object},
};

impl Renderer {
    /// Bind groups of a program, for an object where it draws one.
    pub(super) fn bind(
        &mut self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        program: &Program,
        object: Option<&Object>,
    ) -> Result<Vec<Option<wgpu::BindGroup>>, RenderError> {
        let mut stock = Stock {
            gpu: &self.gpu,
            assets: &mut self.assets,
            white: &self.white,
        };
        let key = &program.permutation.key;
        let binder = self.executor.binder();
        let groups = (0..program.groups.len()).map(|group| {
            binder.bind(program, group, |binder, binding| match group {
                LIGHT => stock.of_light(binder, inputs, key, binding),
                MATERIAL => stock.of_material(binder, object, key, binding),
                _ => of_frame(binder, frame, (&self.gpu, inputs), key, binding),
            })
        });
        groups.collect()
    }
}

fn of_frame(
    binder: &mut Binder,
    frame: &mut FrameState<'_>,
    (gpu, inputs): (&Gpu, &PassInputs<'_>),
    key: &Key,
    binding: &Binding,
) -> Result<Resource, RenderError> {
    match (binding.name.as_str(), &binding.kind) {
        ("frame", _) => {
            let constants = Constants::new().with("view_proj", inputs.view_proj);
            Ok(binder.block(key, binding, &constants)?)
        }
        ("ambient", _) => {
            let constants = Constants::new().with("radiance", inputs.ambient);
            Ok(binder.block(key, binding, &constants)?)
        }
        ("rays", _) => Ok(binder.block(key, binding, &frame.rays)?),
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
        (INSTANCES | DRAWN, _) => frame.objects.resource(gpu, key, binding),
        _ => Err(unknown(
            key,
            binding,
            "what the frame gives, `frame`, `ambient`, `rays`, `instances`, `drawn`, to a mask `seen_planes`, and to air \
             `seen_depth`",
        )),
    }
}

/// Where objects' meshes and pictures come from.
pub(super) struct Stock<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) assets: &'a mut Assets,
    /// Stands in for a texture that an object does not have.
    pub(super) white: &'a Arc<Image>,
}

impl Stock<'_> {
    fn of_light(
        &mut self,
        binder: &mut Binder,
        inputs: &PassInputs<'_>,
        key: &Key,
        binding: &Binding,
    ) -> Result<Resource, RenderError> {
        let own = "what its light and shadow method give";
        let Some(light) = inputs.lights.get(binding.instance) else {
            return Err(unknown(key, binding, "what a pass without a light gives"));
        };
        match (binding.name.as_str(), &binding.kind) {
            ("light", kind) if kind.block().is_some() => {
                Ok(binder.block(key, binding, light.constants)?)
            }
            ("cookie_texture", _) => {
                let cookie = light.setup.source.cookie.clone();
                let what = || format!("the cookie of light `{}`", light.setup.source.name);
                Ok(Resource::Texture(self.image(what, cookie)?))
            }
            ("cookie_sampler", _) => Ok(Resource::Sampler(binder.sampler(&assets::sampler(None)))),
            _ => {
                let shadow = light.shadow.ok_or_else(|| unknown(key, binding, own))?;
                let found = binder.of_light(shadow, key, binding)?;
                found.ok_or_else(|| unknown(key, binding, own))
            }
        }
    }

    /// The resource of an object's material for `binding`.
    pub(super) fn of_material(
        &mut self,
        binder: &mut Binder,
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
                Ok(binder.block(key, binding, &constants)?)
            }
            "base_color_texture" => {
                let what = || format!("the texture of object `{}`", object.name);
                let image = texture.map(|texture| Arc::clone(&texture.image));
                Ok(Resource::Texture(self.image(what, image)?))
            }
            "base_color_sampler" => {
                let sampler = binder.sampler(&assets::sampler(texture));
                Ok(Resource::Sampler(sampler))
            }
            _ => Err(unknown(key, binding, "what a material gives")),
        }
    }

    /// The picture on the device; white where an axis was forced on without one.
    fn image(
        &mut self,
        what: impl Fn() -> String,
        image: Option<Arc<Image>>,
    ) -> Result<wgpu::TextureView, RenderError> {
        let image = image.unwrap_or_else(|| Arc::clone(self.white));
        self.assets.image(self.gpu, what, &image)
    }
}

/// The groups whose owners are not the frame: see `Binding::group`.
const LIGHT: usize = 1;
const MATERIAL: usize = 2;

fn unknown(key: &Key, binding: &Binding, known: &str) -> RenderError {
    let problem = format!("the shader reads it, but it is none of {known}");
    Error::binding(key, binding, problem).into()
}
