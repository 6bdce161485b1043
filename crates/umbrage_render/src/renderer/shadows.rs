//! Executes what a shadow method plans.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec3;
use umbrage_shadow::{
    Aabb, CasterPass, Casters, Constants, Frame, Pass, SamplerDesc, ShadowPlan, TextureDesc,
    TextureShape, View,
};

use super::{
    Renderer,
    assets::Vertices,
    draw::{FrameState, PassInputs, record},
    lights::{LightSetup, MethodSetup},
    pipelines::DrawState,
    timer::Mark,
};
use crate::RenderError;

/// What `calc_shadow` reads, on the device.
pub(super) struct ShadowResources {
    pub(super) constants: Constants,
    pub(super) textures: BTreeMap<String, (wgpu::TextureFormat, wgpu::TextureView)>,
    pub(super) samplers: BTreeMap<String, (SamplerDesc, wgpu::Sampler)>,
}

/// A texture kept from frame to frame: which, by the light's number, the method and the name.
pub(super) type TextureId = (usize, String, String);

impl Renderer {
    /// Draws the shadow maps of a light for the objects at `receivers`.
    pub(super) fn cast(
        &mut self,
        frame: &mut FrameState<'_>,
        view: &View,
        light: &LightSetup<'_>,
        setup: &MethodSetup<'_>,
        receivers: &[usize],
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
        let plan = plan(view, light, setup, &caster_bounds, &receiver_bounds)?;
        let textures = self.textures(frame, light, setup, &plan)?;
        frame.report.fetches_per_pixel += plan.fetches_per_pixel;
        for pass in &plan.passes {
            match pass {
                Pass::Casters(pass) => {
                    let slots = slots(setup, pass, &casting)?;
                    self.draw_casters(frame, (light, setup), pass, &textures, &slots)?;
                }
                _ => return Err(bad_plan(setup, "a pass of a kind that is not known here")),
            }
        }
        let mut resources = ShadowResources {
            constants: plan.constants.clone(),
            textures: BTreeMap::new(),
            samplers: BTreeMap::new(),
        };
        for (desc, texture) in textures.into_values() {
            let size = size(&desc);
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
            resources.textures.insert(desc.name, (desc.format, view));
        }
        for desc in &plan.samplers {
            let sampler = self.gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: desc.filter,
                min_filter: desc.filter,
                compare: desc.compare,
                ..Default::default()
            });
            resources
                .samplers
                .insert(desc.name.clone(), (desc.clone(), sampler));
        }
        frame.report.plans.resize(light.index, None);
        frame.report.plans.push(Some(plan));
        Ok(resources)
    }

    /// The plan's textures by name, kept from the last frame where they are the same.
    fn textures(
        &mut self,
        frame: &mut FrameState<'_>,
        light: &LightSetup<'_>,
        setup: &MethodSetup<'_>,
        plan: &ShadowPlan,
    ) -> Result<BTreeMap<String, (TextureDesc, wgpu::Texture)>, RenderError> {
        let method = setup.method.name();
        let mut textures = BTreeMap::new();
        for desc in &plan.textures {
            let id = (light.index, method.to_owned(), desc.name.clone());
            frame.shadow_maps.insert(id.clone());
            let known = self.shadow_maps.get(&id).filter(|(known, _)| known == desc);
            let texture = match known {
                Some((_, texture)) => texture.clone(),
                None => {
                    let what = format!("texture `{}` of light `{}`", desc.name, light.source.name);
                    let usage = wgpu::TextureUsages::TEXTURE_BINDING
                        | wgpu::TextureUsages::RENDER_ATTACHMENT;
                    let texture = self.gpu.texture(&what, size(desc), 1, desc.format, usage)?;
                    self.shadow_maps.insert(id, (desc.clone(), texture.clone()));
                    texture
                }
            };
            textures.insert(desc.name.clone(), (desc.clone(), texture));
        }
        Ok(textures)
    }

    fn draw_casters(
        &mut self,
        frame: &mut FrameState<'_>,
        (light, setup): (&LightSetup<'_>, &MethodSetup<'_>),
        pass: &CasterPass,
        textures: &BTreeMap<String, (TextureDesc, wgpu::Texture)>,
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
        let inputs = PassInputs {
            pass: "caster",
            cause: Some(&light.source.name),
            view_proj: pass.view_proj,
            ambient: Vec3::ZERO,
            light: None,
            vertices: Vertices::Shared,
            state: DrawState {
                color: None,
                depth: desc.format,
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
        let mark = frame
            .timer
            .mark(&self.gpu, "casters", Some(&light.source.name));
        let mut recorded = frame
            .encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("casters"),
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

fn size(desc: &TextureDesc) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width: desc.width,
        height: desc.height,
        depth_or_array_layers: desc.shape.layers(),
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

fn bad_plan(setup: &MethodSetup<'_>, problem: &str) -> RenderError {
    RenderError::BadPlan {
        method: setup.method.name().to_owned(),
        problem: problem.to_owned(),
    }
}
