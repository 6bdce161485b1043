//! Resources of a shadow's shaders on the device: textures, samplers, buffers.

use std::collections::{BTreeMap, BTreeSet};

use umbrage_shadow::{
    BufferContents, BufferDesc, Constants, Contents, Pass, Region, SamplerDesc, ShadowPlan,
    TextureDesc, TextureShape, Value,
};

use crate::{Binder, Error, Job, Unfiltered, bind::Part, check::bad_plan, device, program::STORED};

/// Resources of `calc_shadow`, or of a pass of its plan: each by the name of the binding that reads it.
#[derive(Clone, Default)]
pub struct ShadowResources {
    /// Members of uniform blocks.
    pub constants: Constants,
    /// Members of the uniform block `light`.
    pub light: Constants,
    /// Textures with their formats.
    pub textures: BTreeMap<String, (wgpu::TextureFormat, wgpu::TextureView)>,
    /// Samplers with their descriptions.
    pub samplers: BTreeMap<String, (SamplerDesc, wgpu::Sampler)>,
    /// Storage buffers, not on the device yet: each shader may lay them out in its own way.
    pub buffers: BTreeMap<String, Value>,
    /// Storage buffers that passes of the plan wrote.
    pub written: BTreeMap<String, wgpu::Buffer>,
    /// Where other permutations give the same.
    pub regions: Vec<Region>,
    /// Whether textures of 32 bits a channel may be filtered, beyond the baseline.
    pub filters_all_floats: bool,
}

/// A plan's textures by name.
pub(crate) type Textures = BTreeMap<String, (TextureDesc, wgpu::Texture)>;

/// The plan's textures, those of `kept` where they are the same, to be copied where that is asked for; and the names of those
/// that are new.
pub(crate) fn textures(
    device: &wgpu::Device,
    (kept, copies): (&Textures, bool),
    job: &Job<'_>,
    plan: &ShadowPlan,
) -> Result<(Textures, BTreeSet<String>), Error> {
    use wgpu::TextureUsages as Usage;
    let (mut textures, mut new) = (Textures::new(), BTreeSet::new());
    for desc in &plan.textures {
        let depth = desc.format.has_depth_aspect();
        if !desc.empty.is_finite() || (depth && !(0.0..=1.0).contains(&desc.empty)) {
            let problem = format!(
                "the texture `{}`, empty at {}: a finite number, of depth from 0 to 1, is needed",
                desc.name, desc.empty
            );
            return Err(bad_plan(job, &problem));
        }
        let filled = match contents(job, plan, desc)? {
            Some(_) => Usage::COPY_DST,
            None => written(plan, &desc.name),
        };
        let mut usage = Usage::TEXTURE_BINDING | filled;
        usage.set(Usage::COPY_SRC, copies);
        let stored = STORED.contains(&desc.format) && desc.shape != TextureShape::Cube;
        if usage.contains(Usage::STORAGE_BINDING) && !stored {
            let problem = format!(
                "the texture `{}` is written by a compute shader, but is a cube, or in no format to store to ({:?})",
                desc.name, desc.format
            );
            return Err(bad_plan(job, &problem));
        }
        let known = kept.get(&desc.name);
        let known = known.filter(|(known, kept)| known == desc && kept.usage() == usage);
        let texture = match known {
            Some((_, texture)) => texture.clone(),
            None => {
                new.insert(desc.name.clone());
                let what = what(job, "texture", &desc.name);
                device::texture(device, &what, size(desc), desc.levels, desc.format, usage)?
            }
        };
        textures.insert(desc.name.clone(), (desc.clone(), texture));
    }
    let unknown = |contents: &&Contents| !textures.contains_key(&contents.texture);
    if let Some(contents) = plan.contents.iter().find(unknown) {
        let problem = format!(
            "contents for `{}`, which is none of its textures",
            contents.texture
        );
        return Err(bad_plan(job, &problem));
    }
    Ok((textures, new))
}

/// A resource as errors call it.
fn what(job: &Job<'_>, kind: &str, name: &str) -> String {
    let (light, method) = (job.name, job.shadow.method().name());
    format!("light `{light}`, method `{method}`: the {kind} `{name}`")
}

/// Buffers that passes write, by name.
pub(crate) type Buffers = BTreeMap<String, wgpu::Buffer>;

/// The buffers that the plan's passes write, those of `kept` where they are as large; and the names of those that are new.
pub(crate) fn buffers(
    device: &wgpu::Device,
    kept: &Buffers,
    job: &Job<'_>,
    plan: &ShadowPlan,
) -> Result<(Buffers, BTreeSet<String>), Error> {
    use wgpu::BufferUsages as Usage;
    let (mut buffers, mut new) = (Buffers::new(), BTreeSet::new());
    for desc in &plan.buffers {
        let BufferContents::Written(size) = desc.contents else {
            continue;
        };
        if size % wgpu::COPY_BUFFER_ALIGNMENT != 0 {
            let problem = format!(
                "{size} bytes of the buffer `{}`, no multiple of 4",
                desc.name
            );
            return Err(bad_plan(job, &problem));
        }
        let known = kept.get(&desc.name).filter(|known| known.size() == size);
        let buffer = match known {
            Some(buffer) => buffer.clone(),
            None => {
                new.insert(desc.name.clone());
                let usage = Usage::STORAGE | Usage::COPY_SRC | Usage::INDIRECT;
                device::zeros(device, &what(job, "buffer", &desc.name), usage, size)?
            }
        };
        buffers.insert(desc.name.clone(), buffer);
    }
    Ok((buffers, new))
}

/// Resources of a plan, its constants and regions apart.
pub(crate) fn resources(
    binder: &mut Binder,
    plan: &ShadowPlan,
    (textures, buffers): (&Textures, &Buffers),
) -> ShadowResources {
    let needs = |features| {
        let mut needs = plan.needs.iter();
        needs.any(|need| need.features.contains(features))
    };
    let mut resources = ShadowResources {
        filters_all_floats: needs(wgpu::Features::FLOAT32_FILTERABLE),
        ..ShadowResources::default()
    };
    let own = plan.textures.iter();
    for (desc, texture) in own.filter_map(|desc| textures.get(&desc.name)) {
        let part = Part {
            dimension: match desc.shape {
                TextureShape::D2 => wgpu::TextureViewDimension::D2,
                TextureShape::Array(_) => wgpu::TextureViewDimension::D2Array,
                TextureShape::Cube => wgpu::TextureViewDimension::Cube,
            },
            layers: [0, desc.shape.layers()],
            level: (0, None),
        };
        let view = binder.view(texture, part);
        resources
            .textures
            .insert(desc.name.clone(), (desc.format, view));
    }
    for desc in &plan.samplers {
        let sampler = (desc.clone(), binder.plans_sampler(desc));
        resources.samplers.insert(desc.name.clone(), sampler);
    }
    for BufferDesc { name, contents } in &plan.buffers {
        match (contents, buffers.get(name)) {
            (BufferContents::Value(value), _) => {
                resources.buffers.insert(name.clone(), value.clone());
            }
            (BufferContents::Written(_), Some(buffer)) => {
                resources.written.insert(name.clone(), buffer.clone());
            }
            (BufferContents::Written(_), None) => {}
        }
    }
    resources
}

/// Fills a texture, before whatever is recorded.
pub(crate) fn upload(
    queue: &wgpu::Queue,
    (desc, texture): &(TextureDesc, wgpu::Texture),
    contents: &Contents,
) {
    queue.write_texture(
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

/// A texture's extent.
pub fn size(desc: &TextureDesc) -> wgpu::Extent3d {
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
        .filter(|pass| pass.writes().contains(&name));
    let usages = writers.map(|pass| match pass {
        Pass::Compute(_) => Usage::STORAGE_BINDING,
        _ => Usage::RENDER_ATTACHMENT,
    });
    // A texture that no pass writes is cleared by the first that reads it, which asks for this.
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

/// Contents that `plan` has for the texture, checked.
fn contents<'a>(
    job: &Job<'_>,
    plan: &'a ShadowPlan,
    desc: &TextureDesc,
) -> Result<Option<&'a Contents>, Error> {
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
    Err(bad_plan(job, &problem))
}

/// Resources of `lights` that must not be filtered, each light's as an instance: textures of formats that not every device
/// can filter, where the plan does not ask for one that can, and samplers that do not ask to.
pub fn unfiltered(lights: &[&ShadowResources]) -> Unfiltered {
    let lights = lights.iter().enumerate();
    let names = lights.flat_map(|(instance, light)| {
        let names = light.unfiltered();
        names.map(move |name| (instance, name.clone()))
    });
    names.collect()
}

impl ShadowResources {
    fn unfiltered(&self) -> impl Iterator<Item = &String> {
        use wgpu::TextureFormat::{R32Float, Rg32Float, Rgba32Float};
        let textures = self
            .textures
            .iter()
            .filter(|(_, (format, _))| matches!(format, R32Float | Rg32Float | Rgba32Float))
            .filter(|_| !self.filters_all_floats)
            .map(|(name, _)| name);
        let samplers = self
            .samplers
            .iter()
            .filter(|(_, (desc, _))| desc.filter == wgpu::FilterMode::Nearest)
            .map(|(name, _)| name);
        textures.chain(samplers)
    }
}
