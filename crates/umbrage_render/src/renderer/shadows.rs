//! Executes what a shadow method plans.

use std::collections::BTreeSet;

use glam::Vec3;
use umbrage_shadow::{
    Aabb, Blend, CasterPass, ColorTarget, DepthTarget, Pass, ShadowPlan, TextureDesc, TextureShape,
    View, Viewport,
};

use super::{
    Renderer,
    air::{AIR, LitAir},
    assets::Vertices,
    draw::{FrameState, PassInputs, record},
    lights::LightSetup,
    passes::NamedPass,
    pipelines::{ColorState, DrawState, MAX},
    regions,
    resources::{ShadowResources, Textures},
    timer::Mark,
};
use crate::{RenderError, scene::CheckedShadow};

impl Renderer {
    /// Draws the shadow maps of a light for the objects at `receivers`, and for the air.
    pub(super) fn cast(
        &mut self,
        frame: &mut FrameState<'_>,
        (view, seen): (&View, Option<[f64; 2]>),
        light: &LightSetup<'_>,
        setup: &CheckedShadow<'_>,
        (receivers, air): (&[usize], Option<&LitAir>),
    ) -> Result<ShadowResources, RenderError> {
        let mut casting = Vec::new();
        let (mut caster_bounds, mut receiver_bounds) = (Vec::new(), Vec::new());
        for (slot, object) in frame.objects.iter() {
            if object.material.casts {
                casting.push(slot);
                caster_bounds.push(object.bounds);
            }
            if receivers.binary_search(&slot).is_ok() {
                receiver_bounds.push(object.bounds);
            }
        }
        receiver_bounds.extend(air.and_then(|air| air.shaded));
        let plan = plan(
            (view, seen),
            (light, setup),
            &caster_bounds,
            &receiver_bounds,
        )?;
        regions::check(setup, &plan.regions)?;
        self.check_needs(light, setup, &plan)?;
        let textures = self.textures(frame, light, setup, &plan)?;
        frame.report.fetches_per_pixel += plan.fetches_per_pixel;
        let mut resources = self.resources(frame, &plan, &textures);
        let receiver = frame
            .objects
            .iter()
            .find_map(|(slot, object)| receivers.contains(&slot).then_some(object));
        let mut job = Job {
            light,
            setup,
            textures: &textures,
            cause: receiver.map_or(AIR, |object| &object.name),
            filled: BTreeSet::new(),
        };
        for pass in &plan.passes {
            match pass {
                Pass::Casters(pass) => {
                    let slots = slots(setup, pass, &casting)?;
                    self.draw_casters(frame, &mut job, pass, &slots)?;
                }
                Pass::Screen(pass) => {
                    self.draw_screen(frame, &mut job, pass, view.position, &resources)?;
                }
                Pass::Compute(pass) => {
                    self.compute_maps(frame, &job, pass, view.position, &resources)?;
                }
                _ => return Err(bad_plan(setup, "a pass of a kind that is not known here")),
            }
        }
        resources.constants = plan.constants.clone();
        resources.regions = plan.regions.clone();
        frame.report.plans.resize(light.index, None);
        frame.report.plans.push(Some(plan));
        Ok(resources)
    }

    /// Whether the device has what the plan needs.
    fn check_needs(
        &self,
        light: &LightSetup<'_>,
        setup: &CheckedShadow<'_>,
        plan: &ShadowPlan,
    ) -> Result<(), RenderError> {
        let there = self.gpu.device.features();
        match plan
            .needs
            .iter()
            .find(|need| !there.contains(need.features))
        {
            None => Ok(()),
            Some(need) => {
                let missing = (need.features - there).iter_names();
                let missing: Vec<_> = missing
                    .map(|(name, _)| name.to_lowercase().replace('_', "-"))
                    .collect();
                Err(RenderError::Missing {
                    light: light.source.name.clone(),
                    method: setup.method().name().to_owned(),
                    adapter: self.gpu.adapter().to_owned(),
                    features: missing.join(", "),
                    instead: need.instead.clone(),
                })
            }
        }
    }

    fn draw_casters<'a>(
        &mut self,
        frame: &mut FrameState<'_>,
        job: &mut Job<'a>,
        pass: &'a CasterPass,
        slots: &[usize],
    ) -> Result<(), RenderError> {
        let setup = job.setup;
        check_casters(setup, pass)?;
        let depth = match &pass.depth {
            Some(target) => Some((target, depth_target(setup, target, &pass.viewport, job)?)),
            None => None,
        };
        let color = match &pass.color {
            Some(target) => {
                let size = depth.as_ref().map(|(_, (desc, _))| *desc);
                Some((
                    color_target(setup, target, size, &pass.viewport, job.textures)?,
                    job.filled.insert(&target.texture),
                ))
            }
            None => None,
        };
        let inputs = PassInputs {
            pass: NamedPass::planned(&pass.shader),
            cause: Some(&job.light.source.name),
            view_proj: pass.view_proj,
            ambient: Vec3::ZERO,
            light: None,
            vertices: Vertices::Shared,
            state: DrawState {
                color: color.as_ref().map(|((state, _), _)| *state),
                depth: depth.as_ref().map(|(_, (desc, _))| desc.format),
                compare: pass
                    .depth
                    .as_ref()
                    .map_or(wgpu::CompareFunction::Always, |depth| depth.compare),
                write_depth: depth.is_some(),
                cull: pass.cull,
                front: wgpu::FrontFace::Ccw,
                unfiltered: BTreeSet::new(),
            },
        };
        let commands = self.prepare(frame, &inputs, slots)?;
        let colors = color
            .as_ref()
            .map(|((_, view), clear)| attachment(view, *clear));
        let depths = depth.as_ref().map(|(target, (_, view))| {
            let load = target.clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear);
            depth_attachment(view, load)
        });
        let name = Some(job.light.source.name.as_str());
        let mark = frame
            .timer
            .mark(&self.gpu, ("casters", inputs.pass.purpose), name, false);
        let mut recorded = frame
            .encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("casters"),
                color_attachments: colors.as_slice(),
                depth_stencil_attachment: depths,
                timestamp_writes: mark.as_ref().map(Mark::writes),
                ..Default::default()
            });
        set_viewport(&mut recorded, &pass.viewport);
        record(&mut recorded, &commands);
        frame.report.passes += 1;
        frame.report.caster_passes += 1;
        frame.report.caster_draws += commands.len() as u32;
        Ok(())
    }
}

/// What the passes of one plan share.
pub(super) struct Job<'a> {
    pub(super) light: &'a LightSetup<'a>,
    pub(super) setup: &'a CheckedShadow<'a>,
    pub(super) textures: &'a Textures,
    /// What passes that draw no object run on behalf of: a receiver's name, or the air's.
    pub(super) cause: &'a str,
    /// The textures that a pass has filled in part, or whole: only the first one into a texture clears it.
    pub(super) filled: BTreeSet<&'a str>,
}

pub(super) fn set_viewport(pass: &mut wgpu::RenderPass<'_>, area: &Viewport) {
    let [x, y, width, height] = [area.x, area.y, area.width, area.height].map(|n| n as f32);
    pass.set_viewport(x, y, width, height, 0.0, 1.0);
}

fn plan(
    (view, seen): (&View, Option<[f64; 2]>),
    (light, setup): (&LightSetup<'_>, &CheckedShadow<'_>),
    casters: &[Aabb],
    receivers: &[Aabb],
) -> Result<ShadowPlan, RenderError> {
    let frame = setup.frame((view, seen), &light.source.light, casters, receivers);
    let light = light.source.name.clone();
    setup
        .method()
        .plan(&frame)
        .map_err(|source| RenderError::Plan { light, source })
}

/// The slots of the casters that `pass` lists, ascending.
fn slots(
    setup: &CheckedShadow<'_>,
    pass: &CasterPass,
    casting: &[usize],
) -> Result<Vec<usize>, RenderError> {
    let slots = pass
        .casters
        .iter()
        .map(|caster| casting.get(*caster).copied());
    let Some(mut slots) = slots.collect::<Option<Vec<_>>>() else {
        return Err(bad_plan(setup, "a caster that there is not"));
    };
    slots.sort_unstable();
    slots.dedup();
    Ok(slots)
}

fn check_casters(setup: &CheckedShadow<'_>, pass: &CasterPass) -> Result<(), RenderError> {
    let problem = if pass.depth.is_none() && pass.color.is_none() {
        "casters into no texture"
    } else if !pass.view_proj.is_finite() {
        "casters under a matrix that is not finite"
    } else {
        return Ok(());
    };
    Err(bad_plan(setup, problem))
}

/// A texture of the plan.
pub(super) fn target<'a>(
    setup: &CheckedShadow<'_>,
    textures: &'a Textures,
    name: &str,
) -> Result<(&'a TextureDesc, &'a wgpu::Texture), RenderError> {
    match textures.get(name) {
        Some((desc, texture)) => Ok((desc, texture)),
        None => {
            let problem = format!("the target `{name}`, which is none of its textures");
            Err(bad_plan(setup, &problem))
        }
    }
}

/// Whether a viewport lies in a texture.
pub(super) fn check_viewport(
    setup: &CheckedShadow<'_>,
    area: &Viewport,
    desc: &TextureDesc,
) -> Result<(), RenderError> {
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
    Err(bad_plan(setup, &problem))
}

/// The depth texture that a pass draws into.
fn depth_target<'a>(
    setup: &CheckedShadow<'_>,
    target: &DepthTarget,
    viewport: &Viewport,
    job: &Job<'a>,
) -> Result<(&'a TextureDesc, wgpu::TextureView), RenderError> {
    let (desc, texture) = self::target(setup, job.textures, &target.texture)?;
    check_viewport(setup, viewport, desc)?;
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
    Err(bad_plan(setup, &problem))
}

/// Whether a format is of depth alone.
pub(super) fn is_depth(format: wgpu::TextureFormat) -> bool {
    format.has_depth_aspect() && !format.has_stencil_aspect()
}

/// The colour texture that a pass draws into, as large as `depth`, where it has that as well.
fn color_target(
    setup: &CheckedShadow<'_>,
    color: &ColorTarget,
    depth: Option<&TextureDesc>,
    viewport: &Viewport,
    textures: &Textures,
) -> Result<(ColorState, wgpu::TextureView), RenderError> {
    let name = &color.texture;
    let bad = |problem: String| bad_plan(setup, &problem);
    let (desc, texture) = target(setup, textures, name)?;
    let format = desc.format;
    if !is_floats(desc) {
        let problem =
            format!("a colour into `{name}`, which is not one rectangle of floats ({format:?})");
        return Err(bad(problem));
    }
    if let Some(depth) = depth
        && [desc.width, desc.height] != [depth.width, depth.height]
    {
        let problem = format!(
            "a colour into the {} by {} texels of `{name}` and depth into the {} by {} of `{}`: both must be as large",
            desc.width, desc.height, depth.width, depth.height, depth.name
        );
        return Err(bad(problem));
    }
    let there = wgpu::ColorWrites::from_bits_truncate((1 << format.components()) - 1);
    if color.channels.is_empty() || !there.contains(color.channels) {
        let (wanted, there) = (channel_names(color.channels), channel_names(there));
        let problem = format!(
            "a colour into the channels `{wanted}` of `{name}`, whose format {format:?} has `{there}`"
        );
        return Err(bad(problem));
    }
    check_viewport(setup, viewport, desc)?;
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

/// Whether a texture is one rectangle of floats that can be drawn into.
pub(super) fn is_floats(desc: &TextureDesc) -> bool {
    let sample = desc.format.sample_type(None, None);
    let floats = matches!(sample, Some(wgpu::TextureSampleType::Float { .. }));
    floats && desc.format.has_color_aspect() && desc.shape == TextureShape::D2
}

fn channel_names(channels: wgpu::ColorWrites) -> String {
    let names = [(1, 'r'), (2, 'g'), (4, 'b'), (8, 'a')].into_iter();
    let set = names.filter(|(bit, _)| channels.bits() & bit != 0);
    set.map(|(_, name)| name).collect()
}

/// A colour's attachment; cleared to 0, the farthest, or kept.
pub(super) fn attachment(
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

pub(super) fn depth_attachment(
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

pub(super) fn bad_plan(setup: &CheckedShadow<'_>, problem: &str) -> RenderError {
    RenderError::BadPlan {
        method: setup.method().name().to_owned(),
        problem: problem.to_owned(),
    }
}
