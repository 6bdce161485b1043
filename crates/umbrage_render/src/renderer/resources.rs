//! What a shadow method's shader reads, on the device: textures, samplers, buffers.

use std::collections::{BTreeMap, BTreeSet};

use umbrage_shadow::{
    Constants, Contents, Pass, Reads, Region, SamplerDesc, ShadowPlan, TextureDesc, TextureShape,
    Value,
};

use super::{Renderer, draw::FrameState, lights::LightSetup, pipelines::STORED, shadows::bad_plan};
use crate::{RenderError, scene::CheckedShadow};

/// What `calc_shadow` reads, or a pass of its plan.
#[derive(Clone, Default)]
pub(super) struct ShadowResources {
    pub(super) constants: Constants,
    pub(super) textures: BTreeMap<String, (wgpu::TextureFormat, wgpu::TextureView)>,
    pub(super) samplers: BTreeMap<String, (SamplerDesc, wgpu::Sampler)>,
    /// Not on the device yet: each shader may lay them out in its own way.
    pub(super) buffers: BTreeMap<String, Value>,
    /// Where other permutations give the same.
    pub(super) regions: Vec<Region>,
    /// Whether textures of 32 bits a channel may be filtered, beyond the baseline.
    pub(super) filters_all_floats: bool,
}

impl ShadowResources {
    /// What a pass of the plan reads, under the names that it has for them.
    pub(super) fn given_to(&self, reads: &Reads) -> Self {
        let mut given = self.clone();
        given.constants = reads.constants.clone();
        for (binding, texture) in &reads.renamed {
            if let Some(found) = self.textures.get(texture) {
                given.textures.insert(binding.clone(), found.clone());
            }
        }
        given
    }
}

/// A texture kept from frame to frame: which, by the light's number, the method and the name.
pub(super) type TextureId = (usize, String, String);

/// A plan's textures by name.
pub(super) type Textures = BTreeMap<String, (TextureDesc, wgpu::Texture)>;

impl Renderer {
    /// The plan's textures, kept from the last frame where they are the same, and filled where the plan
    /// says with what.
    pub(super) fn textures(
        &mut self,
        frame: &mut FrameState<'_>,
        light: &LightSetup<'_>,
        setup: &CheckedShadow<'_>,
        plan: &ShadowPlan,
    ) -> Result<Textures, RenderError> {
        use wgpu::TextureUsages as Usage;
        let method = setup.method().name();
        let mut textures = Textures::new();
        for desc in &plan.textures {
            let contents = contents(setup, plan, desc)?;
            let filled = match contents {
                Some(_) => Usage::COPY_DST,
                None => written(plan, &desc.name),
            };
            let usage = Usage::TEXTURE_BINDING | filled;
            let stored = STORED.contains(&desc.format) && desc.shape == TextureShape::D2;
            if usage.contains(Usage::STORAGE_BINDING) && !stored {
                let problem = format!(
                    "the texture `{}` is written by a compute shader, but is not one rectangle in a format to store to ({:?})",
                    desc.name, desc.format
                );
                return Err(bad_plan(setup, &problem));
            }
            let id = (light.index, method.to_owned(), desc.name.clone());
            frame.shadow_maps.insert(id.clone());
            let known = self.shadow_maps.get(&id);
            let known = known.filter(|(known, kept)| known == desc && kept.usage() == usage);
            let texture = match known {
                Some((_, texture)) => texture.clone(),
                None => {
                    let what = format!("texture `{}` of light `{}`", desc.name, light.source.name);
                    let texture = self.gpu.texture(&what, size(desc), 1, desc.format, usage)?;
                    self.shadow_maps.insert(id, (desc.clone(), texture.clone()));
                    texture
                }
            };
            if let Some(contents) = contents {
                self.upload(desc, &texture, contents);
            }
            textures.insert(desc.name.clone(), (desc.clone(), texture));
        }
        let unknown = |contents: &&Contents| !textures.contains_key(&contents.texture);
        if let Some(contents) = plan.contents.iter().find(unknown) {
            let problem = format!(
                "contents for `{}`, which is none of its textures",
                contents.texture
            );
            return Err(bad_plan(setup, &problem));
        }
        Ok(textures)
    }

    /// What shaders read of a plan, its constants apart.
    pub(super) fn resources(
        &self,
        frame: &mut FrameState<'_>,
        plan: &ShadowPlan,
        textures: &Textures,
    ) -> ShadowResources {
        let needs = |features| {
            plan.needs
                .iter()
                .any(|need| need.features.contains(features))
        };
        let mut resources = ShadowResources {
            filters_all_floats: needs(wgpu::Features::FLOAT32_FILTERABLE),
            ..ShadowResources::default()
        };
        for (desc, texture) in textures.values() {
            let size = size(desc);
            let layer = u64::from(size.width) * u64::from(size.height);
            frame.report.texels += layer * u64::from(size.depth_or_array_layers);
            frame.report.shadow_bytes += desc.format.theoretical_memory_footprint(size);
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(match desc.shape {
                    TextureShape::D2 => wgpu::TextureViewDimension::D2,
                    TextureShape::Cube => wgpu::TextureViewDimension::Cube,
                }),
                ..Default::default()
            });
            resources
                .textures
                .insert(desc.name.clone(), (desc.format, view));
        }
        for desc in &plan.samplers {
            let sampler = self.gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: desc.filter,
                min_filter: desc.filter,
                compare: desc.compare,
                ..Default::default()
            });
            let sampler = (desc.clone(), sampler);
            resources.samplers.insert(desc.name.clone(), sampler);
        }
        for desc in &plan.buffers {
            let value = desc.value.clone();
            resources.buffers.insert(desc.name.clone(), value);
        }
        resources
    }

    /// Before whatever is recorded in this frame.
    fn upload(&self, desc: &TextureDesc, texture: &wgpu::Texture, contents: &Contents) {
        self.gpu.queue.write_texture(
            texture.as_image_copy(),
            &contents.bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: bytes_per_row(desc),
                rows_per_image: None,
            },
            size(desc),
        );
    }
}

fn size(desc: &TextureDesc) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width: desc.width,
        height: desc.height,
        depth_or_array_layers: desc.shape.layers(),
    }
}

/// How the plan's passes write a texture.
fn written(plan: &ShadowPlan, name: &str) -> wgpu::TextureUsages {
    use wgpu::TextureUsages as Usage;
    let writers = plan
        .passes
        .iter()
        .filter(|pass| pass.writes().any(|written| written == name));
    let usages = writers.map(|pass| match pass {
        Pass::Compute(_) => Usage::STORAGE_BINDING,
        _ => Usage::RENDER_ATTACHMENT,
    });
    // What no pass writes is cleared by the first that reads it, which asks for this.
    usages
        .reduce(|all, usage| all | usage)
        .unwrap_or(Usage::RENDER_ATTACHMENT)
}

/// None for what cannot be filled texel by texel: blocks, and depth.
fn bytes_per_row(desc: &TextureDesc) -> Option<u32> {
    let format = desc.format;
    let texels = format.block_dimensions() == (1, 1) && !format.is_depth_stencil_format();
    let texel = format.block_copy_size(None).filter(|_| texels)?;
    desc.width.checked_mul(texel)
}

/// What `plan` fills the texture with, checked.
fn contents<'a>(
    setup: &CheckedShadow<'_>,
    plan: &'a ShadowPlan,
    desc: &TextureDesc,
) -> Result<Option<&'a Contents>, RenderError> {
    let name = &desc.name;
    let mut all = plan.contents.iter().filter(|c| c.texture == *name);
    let Some(contents) = all.next() else {
        return Ok(None);
    };
    let given = contents.bytes.len() as u64;
    let mut written = plan.passes.iter().flat_map(Pass::writes);
    let drawn = written.any(|written| written == name);
    let problem = if all.next().is_some() {
        format!("contents for `{name}` twice")
    } else if drawn {
        format!("contents for `{name}`, which a pass draws into as well")
    } else if desc.shape != TextureShape::D2 {
        format!("contents for `{name}`, which is not one rectangle")
    } else {
        let expected = bytes_per_row(desc).map(|row| u64::from(row) * u64::from(desc.height));
        match expected {
            None => format!(
                "contents for `{name}`, whose format {:?} cannot be filled texel by texel",
                desc.format
            ),
            Some(expected) if expected != given => format!(
                "{given} bytes for `{name}`, whose {} by {} texels of {:?} take {expected}",
                desc.width, desc.height, desc.format
            ),
            Some(_) => return Ok(Some(contents)),
        }
    };
    Err(bad_plan(setup, &problem))
}

/// The names in a light's group that must not be filtered: textures of formats that not every device can
/// filter, where the plan does not ask for one that can, and samplers that do not ask to.
pub(super) fn unfiltered(shadow: Option<&ShadowResources>) -> BTreeSet<String> {
    use wgpu::TextureFormat::{R32Float, Rg32Float, Rgba32Float};
    let Some(shadow) = shadow else {
        return BTreeSet::new();
    };
    let textures = shadow
        .textures
        .iter()
        .filter(|(_, (format, _))| matches!(format, R32Float | Rg32Float | Rgba32Float))
        .filter(|_| !shadow.filters_all_floats)
        .map(|(name, _)| name);
    let samplers = shadow
        .samplers
        .iter()
        .filter(|(_, (desc, _))| desc.filter == wgpu::FilterMode::Nearest)
        .map(|(name, _)| name);
    textures.chain(samplers).cloned().collect()
}
