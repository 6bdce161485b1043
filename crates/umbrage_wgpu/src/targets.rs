//! Targets of passes, checked against the plan's textures.

use umbrage_compose::{BindingKind, Permutation};
use umbrage_shadow::{
    Blend, ColorTarget, ComputePass, DepthTarget, MAX_REGIONS, Pass, Region, TextureDesc,
    TextureShape, Viewport,
};

use crate::{
    ColorState, Error, Job, MAX,
    execute::{Execution, named},
};

impl Execution<'_> {
    pub(crate) fn bad(&self, problem: &str) -> Error {
        bad_plan(self.job, problem)
    }

    /// A texture of the plan.
    pub(crate) fn target(&self, name: &str) -> Result<(TextureDesc, wgpu::Texture), Error> {
        let found = self.memory.textures.get(name).cloned();
        found.ok_or_else(|| {
            let problem = format!("the target `{name}`, which is none of its textures");
            self.bad(&problem)
        })
    }

    /// Whether a viewport lies in a texture.
    pub(crate) fn check_viewport(&self, area: &Viewport, desc: &TextureDesc) -> Result<(), Error> {
        let inside = |start: u32, extent: u32, all: u32| {
            extent > 0 && start.checked_add(extent).is_some_and(|end| end <= all)
        };
        if inside(area.x, area.width, desc.width) && inside(area.y, area.height, desc.height) {
            return Ok(());
        }
        let problem = format!(
            "what is drawn into {area:?}, outside the {} by {} texels of `{}`",
            desc.width, desc.height, desc.name
        );
        Err(self.bad(&problem))
    }

    /// The depth texture that a pass draws into.
    pub(crate) fn depth_target(
        &self,
        target: &DepthTarget,
        viewport: &Viewport,
    ) -> Result<(TextureDesc, wgpu::TextureView), Error> {
        let (desc, texture) = self.target(&target.texture)?;
        self.check_viewport(viewport, &desc)?;
        let problem = if !is_depth(desc.format) {
            format!(
                "casters into `{}`, whose format {:?} is not of depth alone",
                desc.name, desc.format
            )
        } else if target.layer >= desc.shape.layers() {
            format!("casters into layer {} of `{}`", target.layer, desc.name)
        } else {
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: target.layer,
                array_layer_count: Some(1),
                ..Default::default()
            });
            return Ok((desc, view));
        };
        Err(self.bad(&problem))
    }

    /// The colour texture that a pass draws into, as large as `depth`, where it has that as well.
    pub(crate) fn color_target(
        &self,
        color: &ColorTarget,
        depth: Option<&TextureDesc>,
        viewport: &Viewport,
    ) -> Result<(ColorState, wgpu::TextureView), Error> {
        let name = &color.texture;
        let (desc, texture) = self.target(name)?;
        let format = desc.format;
        if !is_floats(&desc) {
            let problem = format!(
                "a colour into `{name}`, which is not one rectangle of floats ({format:?})"
            );
            return Err(self.bad(&problem));
        }
        if let Some(depth) = depth
            && [desc.width, desc.height] != [depth.width, depth.height]
        {
            let problem = format!(
                "a colour into the {} by {} texels of `{name}` and depth into the {} by {} of `{}`: both must be as large",
                desc.width, desc.height, depth.width, depth.height, depth.name
            );
            return Err(self.bad(&problem));
        }
        let there = wgpu::ColorWrites::from_bits_truncate((1 << format.components()) - 1);
        if color.channels.is_empty() || !there.contains(color.channels) {
            let (wanted, there) = (channel_names(color.channels), channel_names(there));
            let problem = format!(
                "a colour into the channels `{wanted}` of `{name}`, whose format {format:?} has `{there}`"
            );
            return Err(self.bad(&problem));
        }
        self.check_viewport(viewport, &desc)?;
        let state = ColorState {
            format,
            blend: match color.blend {
                Blend::Replace => None,
                Blend::Max => Some(MAX),
            },
            channels: color.channels,
        };
        Ok((state, texture.create_view(&Default::default())))
    }

    /// Whether a pass that draws no caster can be run, and writes what it says.
    pub(crate) fn check_stores(&self, pass: &Pass, permutation: &Permutation) -> Result<(), Error> {
        let (writes, renamed) = match pass {
            Pass::Compute(pass) => {
                self.check_compute(pass)?;
                (&pass.writes[..], &pass.reads.renamed[..])
            }
            _ => (&[][..], &[][..]),
        };
        let bindings = permutation.reflection.bindings.iter();
        let stored = bindings.filter(|binding| is_stored(&binding.kind));
        for name in stored.map(|binding| &binding.name) {
            let target = named(renamed, name);
            if writes.iter().all(|written| written != target) {
                let problem = format!(
                    "`{}` stores to `{target}`, which is not among what it `writes`",
                    pass.shader()
                );
                return Err(self.bad(&problem));
            }
        }
        Ok(())
    }

    fn check_compute(&self, pass: &ComputePass) -> Result<(), Error> {
        let limits = self.shared.device.limits();
        let limit = limits.max_compute_workgroups_per_dimension;
        if pass.workgroups.iter().any(|n| !(1..=limit).contains(n)) {
            let problem = format!(
                "{:?} workgroups of `{}`, where the device allows from 1 to {limit} each way",
                pass.workgroups, pass.shader
            );
            return Err(self.bad(&problem));
        }
        for name in &pass.writes {
            if !self.memory.buffers.contains_key(name) {
                self.target(name)?;
            }
        }
        Ok(())
    }
}

/// Whether a shader writes what is bound there.
pub(crate) fn is_stored(kind: &BindingKind) -> bool {
    matches!(
        kind,
        BindingKind::StorageTexture { .. }
            | BindingKind::Storage {
                read_only: false,
                ..
            }
    )
}

/// Whether a format is of depth alone.
pub(crate) fn is_depth(format: wgpu::TextureFormat) -> bool {
    format.has_depth_aspect() && !format.has_stencil_aspect()
}

/// Whether a texture is one rectangle of floats that can be drawn into.
pub(crate) fn is_floats(desc: &TextureDesc) -> bool {
    let sample = desc.format.sample_type(None, None);
    let floats = matches!(sample, Some(wgpu::TextureSampleType::Float { .. }));
    floats && desc.format.has_color_aspect() && desc.shape == TextureShape::D2
}

pub(crate) fn channel_names(channels: wgpu::ColorWrites) -> String {
    let names = [(1, 'r'), (2, 'g'), (4, 'b'), (8, 'a')].into_iter();
    let set = names.filter(|(bit, _)| channels.bits() & bit != 0);
    set.map(|(_, name)| name).collect()
}

/// A colour's attachment; cleared to 0, the farthest, or kept.
pub(crate) fn attachment(
    view: &wgpu::TextureView,
    clear: bool,
) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    let load = match clear {
        true => wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
        false => wgpu::LoadOp::Load,
    };
    Some(wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load,
            store: wgpu::StoreOp::Store,
        },
    })
}

pub(crate) fn depth_attachment(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<f32>,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load,
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

pub(crate) fn bad_plan(job: &Job<'_>, problem: &str) -> Error {
    Error::BadPlan {
        light: job.name.to_owned(),
        method: job.shadow.method().name().to_owned(),
        problem: problem.to_owned(),
    }
}

/// Whether regions of view depth follow each other, with axes of the chosen parts.
pub(crate) fn check_regions(job: &Job<'_>, regions: &[Region]) -> Result<(), Error> {
    if regions.len() > MAX_REGIONS {
        let problem = format!(
            "{} regions of view depth: {MAX_REGIONS} at the most",
            regions.len()
        );
        return Err(bad_plan(job, &problem));
    }
    let mut start = 0.0;
    for Region { end, axes } in regions {
        // NaN is not beyond.
        if !(*end > start && end.is_finite()) {
            let problem = format!("a region of view depth from {start} m to {end} m");
            return Err(bad_plan(job, &problem));
        }
        let known = job.shadow.choice.axes();
        if let Some(axis) = axes.keys().find(|axis| !known.contains(&axis.as_str())) {
            let problem = format!("a region with the axis `{axis}`, which is none of its axes");
            return Err(bad_plan(job, &problem));
        }
        start = *end;
    }
    Ok(())
}
