//! Executes what a shadow method plans.

use std::collections::BTreeSet;

use glam::Vec3;
use umbrage_shadow::{
    Aabb, CasterPass, Casters, ColorTarget, Frame, Pass, ShadowPlan, TextureDesc, TextureShape,
    View,
};

use super::{
    Renderer,
    air::LitAir,
    assets::Vertices,
    draw::{FrameState, PassInputs, record},
    lights::{LightSetup, MethodSetup},
    pipelines::{Blend, ColorState, DrawState},
    resources::{ShadowResources, Textures},
    timer::Mark,
};
use crate::RenderError;

impl Renderer {
    /// Draws the shadow maps of a light for the objects at `receivers`, and for the air.
    pub(super) fn cast(
        &mut self,
        frame: &mut FrameState<'_>,
        view: &View,
        light: &LightSetup<'_>,
        setup: &MethodSetup<'_>,
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
        let plan = plan(view, light, setup, &caster_bounds, &receiver_bounds)?;
        let textures = self.textures(frame, light, setup, &plan)?;
        frame.report.fetches_per_pixel += plan.fetches_per_pixel;
        // A pass may fill one channel of many: only the first one clears them all.
        let mut colored = BTreeSet::new();
        for pass in &plan.passes {
            match pass {
                Pass::Casters(pass) => {
                    let slots = slots(setup, pass, &casting)?;
                    let color = pass.color.as_ref().map(|color| color.texture.as_str());
                    let clear = color.is_some_and(|texture| colored.insert(texture));
                    let drawn = (pass, clear);
                    self.draw_casters(frame, (light, setup), drawn, &textures, &slots)?;
                }
                _ => return Err(bad_plan(setup, "a pass of a kind that is not known here")),
            }
        }
        let resources = self.resources(frame, &plan, textures);
        frame.report.plans.resize(light.index, None);
        frame.report.plans.push(Some(plan));
        Ok(resources)
    }

    fn draw_casters(
        &mut self,
        frame: &mut FrameState<'_>,
        (light, setup): (&LightSetup<'_>, &MethodSetup<'_>),
        (pass, clear_color): (&CasterPass, bool),
        textures: &Textures,
        slots: &[usize],
    ) -> Result<(), RenderError> {
        let Some((desc, texture)) = textures.get(&pass.target) else {
            let problem = format!(
                "the target `{}`, which is none of its textures",
                pass.target
            );
            return Err(bad_plan(setup, &problem));
        };
        check_target(setup, pass, desc)?;
        let color = match &pass.color {
            Some(color) => Some(color_target(setup, color, desc, textures)?),
            None => None,
        };
        let inputs = PassInputs {
            pass: if color.is_some() {
                "caster_depth"
            } else {
                "caster"
            },
            cause: Some(&light.source.name),
            view_proj: pass.view_proj,
            ambient: Vec3::ZERO,
            light: None,
            vertices: Vertices::Shared,
            state: DrawState {
                color: color.as_ref().map(|(state, _)| *state),
                depth: Some(desc.format),
                compare: pass.depth_test.compare,
                write_depth: true,
                cull: pass.cull,
                front: wgpu::FrontFace::Ccw,
                unfiltered: BTreeSet::new(),
            },
        };
        let commands = self.prepare(frame, &inputs, slots)?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: pass.layer,
            array_layer_count: Some(1),
            ..Default::default()
        });
        let attachments = color
            .as_ref()
            .map(|(_, view)| attachment(view, clear_color));
        let mark = frame
            .timer
            .mark(&self.gpu, "casters", Some(&light.source.name));
        let mut recorded = frame
            .encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("casters"),
                color_attachments: attachments.as_slice(),
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &view,
                    depth_ops: Some(wgpu::Operations {
                        load: pass.clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: mark.as_ref().map(Mark::writes),
                ..Default::default()
            });
        let area = &pass.viewport;
        let [x, y, width, height] = [area.x, area.y, area.width, area.height].map(|n| n as f32);
        recorded.set_viewport(x, y, width, height, 0.0, 1.0);
        record(&mut recorded, &commands);
        frame.report.passes += 1;
        frame.report.caster_passes += 1;
        frame.report.caster_draws += commands.len() as u32;
        Ok(())
    }
}

fn plan(
    view: &View,
    light: &LightSetup<'_>,
    setup: &MethodSetup<'_>,
    casters: &[Aabb],
    receivers: &[Aabb],
) -> Result<ShadowPlan, RenderError> {
    let frame = Frame {
        view,
        light: &light.source.light,
        casters: Casters { casters, receivers },
        settings: &setup.settings,
        axes: &setup.axes,
    };
    let light = light.source.name.clone();
    setup
        .method
        .plan(&frame)
        .map_err(|source| RenderError::Plan { light, source })
}

/// The slots of the casters that `pass` lists, ascending.
fn slots(
    setup: &MethodSetup<'_>,
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

fn check_target(
    setup: &MethodSetup<'_>,
    pass: &CasterPass,
    desc: &TextureDesc,
) -> Result<(), RenderError> {
    let area = &pass.viewport;
    let inside = |start: u32, extent: u32, all: u32| {
        extent > 0 && start.checked_add(extent).is_some_and(|end| end <= all)
    };
    let problem = if !desc.format.has_depth_aspect() || desc.format.has_stencil_aspect() {
        format!(
            "casters into `{}`, whose format {:?} is not of depth alone",
            desc.name, desc.format
        )
    } else if !inside(area.x, area.width, desc.width) || !inside(area.y, area.height, desc.height) {
        format!(
            "casters into {area:?}, outside the {} by {} texels of `{}`",
            desc.width, desc.height, desc.name
        )
    } else if pass.layer >= desc.shape.layers() {
        format!("casters into layer {} of `{}`", pass.layer, desc.name)
    } else if pass.depth_test.unclipped {
        "casters that are flattened onto the near plane, which WebGPU's baseline cannot".to_owned()
    } else if !pass.view_proj.is_finite() {
        "casters under a matrix that is not finite".to_owned()
    } else {
        return Ok(());
    };
    Err(bad_plan(setup, &problem))
}

/// What a pass that writes depth as a colour draws into.
fn color_target(
    setup: &MethodSetup<'_>,
    color: &ColorTarget,
    depth: &TextureDesc,
    textures: &Textures,
) -> Result<(ColorState, wgpu::TextureView), RenderError> {
    let name = &color.texture;
    let bad = |problem: String| bad_plan(setup, &problem);
    let (desc, texture) = textures.get(name).ok_or_else(|| {
        bad(format!(
            "the target `{name}`, which is none of its textures"
        ))
    })?;
    let components = desc.format.components();
    let format = desc.format;
    let floats = format.sample_type(None, None);
    let floats = matches!(floats, Some(wgpu::TextureSampleType::Float { .. }));
    let there = wgpu::ColorWrites::from_bits_truncate((1 << components) - 1);
    if !floats || !format.has_color_aspect() || desc.shape != TextureShape::D2 {
        let problem = format!(
            "depth as a colour into `{name}`, which is not one rectangle of floats ({format:?})"
        );
        return Err(bad(problem));
    }
    if [desc.width, desc.height] != [depth.width, depth.height] {
        let problem = format!(
            "depth as a colour into the {} by {} texels of `{name}` and into the {} by {} of `{}`:              both must be as large",
            desc.width, desc.height, depth.width, depth.height, depth.name
        );
        return Err(bad(problem));
    }
    if color.channels.is_empty() || !there.contains(color.channels) {
        let (wanted, there) = (channel_names(color.channels), channel_names(there));
        let problem = format!(
            "depth into the channels `{wanted}` of `{name}`, whose format {format:?} has `{there}`"
        );
        return Err(bad(problem));
    }
    let state = ColorState {
        format,
        blend: Blend::Replace,
        channels: color.channels,
    };
    Ok((state, texture.create_view(&Default::default())))
}

fn channel_names(channels: wgpu::ColorWrites) -> String {
    let names = [(1, 'r'), (2, 'g'), (4, 'b'), (8, 'a')].into_iter();
    let set = names.filter(|(bit, _)| channels.bits() & bit != 0);
    set.map(|(_, name)| name).collect()
}

/// A colour's attachment; cleared to 0, the farthest, or kept.
fn attachment(
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

pub(super) fn bad_plan(setup: &MethodSetup<'_>, problem: &str) -> RenderError {
    RenderError::BadPlan {
        method: setup.method.name().to_owned(),
        problem: problem.to_owned(),
    }
}
