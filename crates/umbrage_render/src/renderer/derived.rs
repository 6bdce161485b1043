//! What a plan computes from its maps: full-screen and compute passes.

use std::sync::Arc;

use glam::{DVec3, Mat4, Vec3};
use umbrage_compose::{BindingKind, Permutation, Purpose};
use umbrage_shadow::{ComputePass, Constants, ScreenPass};

use super::{
    Renderer,
    assets::Vertices,
    draw::{FrameState, LightInputs, PassInputs, Term, record},
    lights,
    passes::NamedPass,
    pipelines::{ColorState, Computation, DrawState},
    resources::{ShadowResources, unfiltered},
    shadows::{
        Job, attachment, bad_plan, check_viewport, depth_attachment, is_depth, is_floats,
        set_viewport, target,
    },
    timer::Mark,
};
use crate::RenderError;

impl Renderer {
    /// Draws one triangle around a part of a texture.
    pub(super) fn draw_screen<'a>(
        &mut self,
        frame: &mut FrameState<'_>,
        job: &mut Job<'a>,
        pass: &'a ScreenPass,
        eye: DVec3,
        resources: &ShadowResources,
    ) -> Result<(), RenderError> {
        let setup = job.setup;
        let (desc, texture) = target(setup, job.textures, &pass.target)?;
        check_viewport(setup, &pass.viewport, desc)?;
        let deep = is_depth(desc.format);
        if !deep && !is_floats(desc) {
            let problem = format!(
                "what is computed into `{}`, which is not one rectangle of floats or of depth ({:?})",
                desc.name, desc.format
            );
            return Err(bad_plan(setup, &problem));
        }
        let state = DrawState {
            color: (!deep).then_some(ColorState {
                format: desc.format,
                blend: None,
                channels: wgpu::ColorWrites::ALL,
            }),
            depth: deep.then_some(desc.format),
            write_depth: deep,
            ..DrawState::NOTHING
        };
        let light = lights::constants(&job.light.source.light, eye);
        let command = {
            let given = resources.given_to(&pass.reads);
            let inputs = inputs(job, &pass.shader, &light, &given, state);
            self.prepare_screen(frame, &inputs, job.cause)?
        };
        let view = texture.create_view(&Default::default());
        let clear = job.filled.insert(&pass.target);
        let load = match clear {
            true => wgpu::LoadOp::Clear(0.0),
            false => wgpu::LoadOp::Load,
        };
        let colors = [(!deep).then(|| attachment(&view, clear)).flatten()];
        let name = Some(job.light.source.name.as_str());
        let mark = frame
            .timer
            .mark(&self.gpu, (&pass.shader, Purpose::Maps), name, false);
        let mut recorded = frame
            .encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(&pass.shader),
                color_attachments: if deep { &[] } else { &colors },
                depth_stencil_attachment: deep.then(|| depth_attachment(&view, load)),
                timestamp_writes: mark.as_ref().map(Mark::writes),
                ..Default::default()
            });
        set_viewport(&mut recorded, &pass.viewport);
        record(&mut recorded, std::slice::from_ref(&command));
        frame.report.passes += 1;
        frame.report.derived_passes += 1;
        Ok(())
    }

    /// Runs a compute shader of a plan.
    pub(super) fn compute_maps(
        &mut self,
        frame: &mut FrameState<'_>,
        job: &Job<'_>,
        pass: &ComputePass,
        eye: DVec3,
        resources: &ShadowResources,
    ) -> Result<(), RenderError> {
        self.check_compute(job, pass)?;
        let light = lights::constants(&job.light.source.light, eye);
        let given = resources.given_to(&pass.reads);
        let inputs = inputs(job, &pass.shader, &light, &given, DrawState::NOTHING);
        let permutation = self.compose(frame, &inputs, job.cause, None)?;
        check_stores(job, pass, &permutation)?;
        let what = (inputs.pass.name, Purpose::Maps);
        let mark = frame.timer.mark(&self.gpu, what, inputs.cause, true);
        self.compute(frame, &inputs, permutation, pass.workgroups, mark)?;
        frame.report.derived_passes += 1;
        Ok(())
    }

    /// Runs a compute shader.
    pub(super) fn compute(
        &mut self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        permutation: Arc<Permutation>,
        [x, y, z]: [u32; 3],
        mark: Option<Mark>,
    ) -> Result<(), RenderError> {
        let id = (permutation.key.clone(), inputs.state.unfiltered.clone());
        let computation = match self.computations.get(&id) {
            Some(known) => Arc::clone(known),
            None => {
                let made = Arc::new(Computation::new(&self.gpu, permutation, &id.1)?);
                self.computations.insert(id, Arc::clone(&made));
                made
            }
        };
        let groups = self.bind_all(frame, inputs, &computation.program)?;
        let mut recorded = frame
            .encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(inputs.pass.name),
                timestamp_writes: mark.as_ref().map(Mark::compute_writes),
            });
        recorded.set_pipeline(&computation.pipeline);
        for (group, bound) in (0..).zip(&groups) {
            if let Some(bound) = bound {
                recorded.set_bind_group(group, bound, &[]);
            }
        }
        recorded.dispatch_workgroups(x, y, z);
        drop(recorded);
        frame.report.passes += 1;
        Ok(())
    }

    fn check_compute(&self, job: &Job<'_>, pass: &ComputePass) -> Result<(), RenderError> {
        let limit = self
            .gpu
            .device
            .limits()
            .max_compute_workgroups_per_dimension;
        if pass.workgroups.iter().any(|n| !(1..=limit).contains(n)) {
            let problem = format!(
                "{:?} workgroups of `{}`, where the device allows from 1 to {limit} each way",
                pass.workgroups, pass.shader
            );
            return Err(bad_plan(job.setup, &problem));
        }
        for name in &pass.writes {
            target(job.setup, job.textures, name)?;
        }
        Ok(())
    }
}

/// Whether all that a compute shader stores to is among what its pass says that it writes.
fn check_stores(
    job: &Job<'_>,
    pass: &ComputePass,
    permutation: &Permutation,
) -> Result<(), RenderError> {
    let bindings = permutation.reflection.bindings.iter();
    let stored = bindings.filter(|b| matches!(b.kind, BindingKind::StorageTexture { .. }));
    for name in stored.map(|binding| &binding.name) {
        let mut renamed = pass.reads.renamed.iter();
        let texture = renamed.find(|(binding, _)| binding == name);
        let texture = texture.map_or(name, |(_, texture)| texture);
        if !pass.writes.contains(texture) {
            let problem = format!(
                "`{}` stores to `{texture}`, which is not among what it `writes`",
                pass.shader
            );
            return Err(bad_plan(job.setup, &problem));
        }
    }
    Ok(())
}

fn inputs<'a>(
    job: &Job<'a>,
    shader: &'a str,
    light: &'a Constants,
    given: &'a ShadowResources,
    mut state: DrawState,
) -> PassInputs<'a> {
    state.unfiltered = unfiltered(Some(given));
    PassInputs {
        pass: NamedPass::planned(shader),
        cause: Some(&job.light.source.name),
        view_proj: Mat4::IDENTITY,
        ambient: Vec3::ZERO,
        light: Some(LightInputs {
            setup: job.light,
            constants: light,
            shadow: Some(given),
            term: Term::Method,
        }),
        vertices: Vertices::Shared,
        state,
    }
}
