//! Lights' shadows, by the executor, with the scene's objects for casters.

use std::{mem, sync::Arc};

use umbrage_compose::{Composed, Purpose};
use umbrage_shadow::{Answers, Frame, Pass};
use umbrage_wgpu::{
    Binder, CameraDepth, CheckedShadow, Drawn, Draws, Executed, Host, Job, Program, Run,
    ShadowResources, Sides, Times, size,
};

use super::{
    Renderer, Shot,
    air::{AIR, LitAir},
    assets::{Vertices, layouts},
    bind::Stock,
    frame::FrameState,
    lights::{self, LightSetup},
    lists::Draw,
    objects::{Casters, DRAWN, INSTANCES},
    target::Target,
};
use crate::{RenderError, scene::Object};

impl Renderer {
    /// Draws the shadow maps of a light for the objects at `receivers`, and for the air. Where parts ask what is on the
    /// device, what was recorded is run and waited for. `fresh` tells that the target has no depth yet.
    pub(super) fn cast(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        to: (&Target, bool),
        light: (&LightSetup<'_>, &CheckedShadow),
        receivers: (&[usize], Option<&LitAir>),
    ) -> Result<Arc<ShadowResources>, RenderError> {
        // They are borrowed while the frame changes.
        let casters = mem::take(frame.objects.casters());
        let done = self.cast_by(&casters, frame, shot, to, light, receivers);
        *frame.objects.casters() = casters;
        done
    }

    fn cast_by(
        &mut self,
        casters: &Casters,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        (target, fresh): (&Target, bool),
        (light, setup): (&LightSetup<'_>, &CheckedShadow),
        (receivers, air): (&[usize], Option<&LitAir>),
    ) -> Result<Arc<ShadowResources>, RenderError> {
        let receiver = receivers.first().map(|slot| frame.objects.at(*slot));
        let received = receivers.iter().map(|slot| frame.objects.at(*slot).bounds);
        let received: Vec<_> = received.collect();
        let view = &shot.view;
        let mut planned = setup.frame(view, &light.source.light, &casters.bounds, &received);
        planned.casters.air = air.and_then(|air| air.shaded);
        planned.camera_depth = Some([frame.options.width, frame.options.height]);
        let constants = lights::constants(&light.source.light, view.position);
        let choices = lights::choices(frame.options, frame.orthographic);
        let number = light.index as u64;
        if frame.options.fresh {
            self.executor.forget(number);
        }
        frame.shadow_maps.insert(number);
        let mut answers = Answers::default();
        loop {
            let laid = !fresh || frame.planes.is_some();
            let job = Job {
                light: number,
                name: &light.source.name,
                shadow: setup,
                frame: &Frame {
                    answers: &answers,
                    ..planned
                },
                casters: &casters.identities,
                choices: &choices,
                constants: &constants,
                camera_depth: laid.then_some(CameraDepth {
                    view: &target.depth,
                    revision: self.pictures,
                }),
            };
            let next = self.gpu.device.create_command_encoder(&Default::default());
            let mut encoder = mem::replace(&mut frame.encoder, next);
            let mut stage = Stage {
                stock: Stock {
                    gpu: &self.gpu,
                    assets: &mut self.assets,
                    white: &self.white,
                },
                frame: &mut *frame,
                casting: &casters.slots,
                light: &light.source.name,
                cause: receiver.map_or(AIR, |object| &object.name),
                draws: 0,
            };
            let done = self.executor.shadow(&mut encoder, &job, &mut stage);
            let draws = stage.draws;
            frame.encoder = encoder;
            let executed = match done {
                Err(umbrage_wgpu::Error::NoDepth { .. }) if !laid => {
                    // It is laid down before all else only where a light asks for it.
                    self.lay_planes(frame, shot, (target, fresh))?;
                    continue;
                }
                done => done.map_err(own)?,
            };
            report(frame, &executed, draws);
            let Some(question) = executed.question else {
                frame.report.plans.resize(light.index, None);
                frame.report.plans.push(Some(executed.plan));
                return Ok(executed.resources);
            };
            self.submit(frame)?;
            self.gpu.read(question.buffer(), |bytes| {
                answers = question.answer(bytes);
            })?;
        }
    }
}

/// The scene's own errors, as they are.
fn own(error: umbrage_wgpu::Error) -> RenderError {
    match error {
        umbrage_wgpu::Error::Casters { light, source } => match source.downcast() {
            Ok(own) => *own,
            Err(source) => umbrage_wgpu::Error::Casters { light, source }.into(),
        },
        other => other.into(),
    }
}

/// Adds a plan's cost to the report.
fn report(frame: &mut FrameState<'_>, executed: &Executed, draws: u32) {
    let report = &mut frame.report;
    report.fetches_per_pixel += executed.plan.fetches_per_pixel;
    for desc in &executed.plan.textures {
        let size = size(desc);
        let layer = u64::from(size.width) * u64::from(size.height);
        report.texels += layer * u64::from(size.depth_or_array_layers);
        report.shadow_bytes += desc.format.theoretical_memory_footprint(size);
    }
    for (pass, run) in executed.plan.passes.iter().zip(&executed.runs) {
        let count = match (run, pass) {
            (Run::Kept, _) => {
                report.kept_passes += 1;
                continue;
            }
            (Run::Repaired, _) => &mut report.repaired_passes,
            (Run::Recorded, Pass::Casters(_)) => &mut report.caster_passes,
            (Run::Recorded, _) => &mut report.derived_passes,
        };
        *count += 1;
        report.passes += 1;
        // A pass without casters draws one triangle, or none.
        report.draws += u32::from(matches!(pass, Pass::Screen(_)));
    }
    report.caster_draws += draws;
    report.draws += draws;
}

/// The scene's objects, where a plan draws casters.
struct Stage<'s, 'f> {
    stock: Stock<'s>,
    frame: &'s mut FrameState<'f>,
    /// Slots of the casters.
    casting: &'s [usize],
    /// The light's name.
    light: &'s str,
    /// Whose sake passes run for that draw no object: a receiver's name, or the air's.
    cause: &'s str,
    draws: u32,
}

impl Host for Stage<'_, '_> {
    fn draw(&mut self, casters: &[usize], draws: &mut Draws<'_, '_>) -> Drawn {
        // Casters are in the order of their slots.
        let slots = casters.iter().filter_map(|i| self.casting.get(*i));
        let slots: Vec<_> = slots.copied().collect();
        for draw in self.frame.objects.draws(self.stock.gpu, &slots)? {
            self.draw_batch(&draw, draws)?;
        }
        Ok(())
    }

    fn times(&mut self, pass: &Pass) -> Option<Times> {
        let (name, computes) = match pass {
            Pass::Casters(_) => ("casters", false),
            Pass::Compute(pass) => (pass.shader.as_str(), true),
            other => (other.shader(), false),
        };
        let (gpu, what) = (self.stock.gpu, (name, Purpose::Maps));
        let mark = self.frame.timer.mark(gpu, what, Some(self.light), computes);
        mark.map(|mark| mark.queries())
    }

    fn composed(&mut self, _: &str, composed: &Composed) {
        let by = (self.cause, Some(self.light));
        self.frame.note(composed, Purpose::Maps, by);
    }
}

impl Stage<'_, '_> {
    fn draw_batch(&mut self, draw: &Draw, draws: &mut Draws<'_, '_>) -> Result<(), RenderError> {
        let object = self.frame.objects.at(draw.first);
        if object.mesh.indices.is_empty() {
            return Ok(());
        }
        let axes = lights::object_axes(object);
        let vertices = layouts(object);
        let gpu = self.stock.gpu;
        let mesh = self.stock.assets.mesh(gpu, object, Vertices::Shared)?;
        let sides = Sides {
            mirrored: self.frame.objects.is_mirrored(draw),
            // Holes show what is inside.
            closed: object.material.alpha_cutoff.is_none() && mesh.is_closed(&object.mesh),
        };
        let prepared = draws.pipeline(&axes, &vertices, sides)?;
        let by = (object.name.as_str(), Some(self.light));
        self.frame.note(&prepared.composed, Purpose::Maps, by);
        let program = &prepared.pipeline.program;
        draws.set(&prepared.pipeline)?;
        for group in 0..program.groups.len() {
            let mut bindings = program.bindings(group);
            if bindings.any(|binding| binding.name == "frame") {
                continue;
            }
            if let Some(bound) = self.bind(draws.binder(), program, group, object)? {
                draws.pass().set_bind_group(group as u32, &bound, &[]);
            }
        }
        for (slot, place) in prepared.vertices.iter().enumerate() {
            let location = vertices[*place].attributes[0].shader_location;
            if let Some(buffer) = mesh.attribute(location) {
                let pass = draws.pass();
                pass.set_vertex_buffer(slot as u32, buffer.slice(..));
            }
        }
        mesh.draw(draws.pass(), draw.instances.clone());
        self.draws += 1;
        let count = draw.instances.len() as u64;
        let report = &mut self.frame.report;
        report.caster_triangles += count * (object.mesh.indices.len() / 3) as u64;
        report.caster_vertices += count * object.mesh.positions.len() as u64;
        Ok(())
    }

    fn bind(
        &mut self,
        binder: &mut Binder,
        program: &Program,
        group: usize,
        object: &Object,
    ) -> Result<Option<wgpu::BindGroup>, RenderError> {
        let key = &program.permutation.key;
        binder.bind(program, group, |binder, binding| {
            match binding.name.as_str() {
                INSTANCES | DRAWN => self.frame.objects.resource(self.stock.gpu, key, binding),
                _ => self.stock.of_material(binder, Some(object), key, binding),
            }
        })
    }
}
