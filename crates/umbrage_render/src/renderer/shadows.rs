//! Lights' shadows, by the executor, with the scene's objects for casters.

use std::{
    collections::{HashMap, hash_map::Entry},
    hash::{DefaultHasher, Hash as _, Hasher as _},
    mem,
    sync::Arc,
};

use umbrage_compose::{Composed, Purpose};
use umbrage_shadow::{Answers, Frame, Pass};
use umbrage_wgpu::{
    CameraDepth, CheckedShadow, Drawn, Draws, Executed, Host, Identity, Job, Pipeline, Run,
    ShadowResources, Times, size,
};

use super::{
    Renderer, Shot,
    air::{AIR, LitAir},
    assets::{Vertices, layouts},
    bind::Stock,
    frame::FrameState,
    lights::{self, LightSetup},
    objects::Run as Batch,
    target::Target,
};
use crate::{
    Gpu, RenderError,
    scene::{Material, Object},
};

impl Renderer {
    /// Draws the shadow maps of a light for the objects at `receivers`, and for the air. Where parts ask what is on the
    /// device, what was recorded is run and waited for. `fresh` tells that the target has no depth yet.
    pub(super) fn cast(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        (target, fresh): (&Target, bool),
        (light, setup): (&LightSetup<'_>, &CheckedShadow<'_>),
        (receivers, air): (&[usize], Option<&LitAir>),
    ) -> Result<ShadowResources, RenderError> {
        let (mut casting, mut casters) = (Vec::new(), Vec::new());
        let (mut caster_bounds, mut receiver_bounds) = (Vec::new(), Vec::new());
        let mut receiver = None;
        for (slot, object) in frame.objects.iter() {
            if object.material.casts {
                casting.push(slot);
                casters.push(self.identity(object));
                caster_bounds.push(object.bounds);
            }
            if receivers.binary_search(&slot).is_ok() {
                receiver_bounds.push(object.bounds);
                receiver = receiver.or(Some(object));
            }
        }
        let view = &shot.view;
        let mut planned = setup.frame(view, &light.source.light, &caster_bounds, &receiver_bounds);
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
                casters: &casters,
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
                gpu: &self.gpu,
                stock: Stock {
                    assets: &mut self.assets,
                    white: &self.white,
                },
                frame: &mut *frame,
                casting: &casting,
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

    /// Which caster an object is. Scenes are plain data: whatever makes it look as it does makes it another.
    fn identity(&mut self, object: &Object) -> Identity {
        let mut state = DefaultHasher::new();
        self.assets.number(&object.material).hash(&mut state);
        for number in object.transform.to_cols_array() {
            number.to_bits().hash(&mut state);
        }
        Identity {
            id: self.assets.number(&object.mesh),
            revision: state.finish(),
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
    gpu: &'s Gpu,
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
        let slots = casters
            .iter()
            .filter_map(|caster| self.casting.get(*caster));
        let mut slots: Vec<_> = slots.copied().collect();
        slots.sort_unstable();
        let mut groups = Groups::default();
        for batch in self.frame.objects.runs(&slots) {
            if !batch.object.mesh.indices.is_empty() {
                self.draw_batch(&batch, draws, &mut groups)?;
            }
        }
        Ok(())
    }

    fn times(&mut self, pass: &Pass) -> Option<Times> {
        let (name, computes) = match pass {
            Pass::Casters(_) => ("casters", false),
            Pass::Compute(pass) => (pass.shader.as_str(), true),
            other => (other.shader(), false),
        };
        let (gpu, what) = (self.gpu, (name, Purpose::Maps));
        let mark = self.frame.timer.mark(gpu, what, Some(self.light), computes);
        mark.map(|mark| mark.queries())
    }

    fn composed(&mut self, _: &str, composed: &Composed) {
        let by = (self.cause, Some(self.light));
        self.frame.note(composed, Purpose::Maps, by);
    }
}

/// The groups of objects in one pass, by pipeline, group and material; other groups are the same for all objects.
#[derive(Default)]
struct Groups(HashMap<(*const Pipeline, usize, *const Material), Option<wgpu::BindGroup>>);

impl Stage<'_, '_> {
    fn draw_batch(
        &mut self,
        batch: &Batch<'_>,
        draws: &mut Draws<'_, '_>,
        groups: &mut Groups,
    ) -> Result<(), RenderError> {
        let object = batch.object;
        let axes = lights::object_axes(object);
        let vertices = layouts(object);
        let prepared = draws.pipeline(&axes, &vertices, batch.mirrored)?;
        let by = (object.name.as_str(), Some(self.light));
        self.frame.note(&prepared.composed, Purpose::Maps, by);
        let pipeline = &prepared.pipeline;
        draws.set(pipeline)?;
        for group in 0..pipeline.program.groups.len() {
            let mut bindings = pipeline.program.bindings(group);
            if bindings.any(|binding| binding.name == "frame") {
                continue;
            }
            let id = (Arc::as_ptr(pipeline), group, Arc::as_ptr(&object.material));
            let bound = match groups.0.entry(id) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(place) => place.insert(self.bind(pipeline, group, object)?),
            };
            if let Some(bound) = bound {
                draws.pass().set_bind_group(group as u32, &*bound, &[]);
            }
        }
        let mesh = self.stock.assets.mesh(self.gpu, object, Vertices::Shared)?;
        for (slot, place) in prepared.vertices.iter().enumerate() {
            let location = vertices[*place].attributes[0].shader_location;
            if let Some(buffer) = mesh.attribute(location) {
                let pass = draws.pass();
                pass.set_vertex_buffer(slot as u32, buffer.slice(..));
            }
        }
        mesh.draw(draws.pass(), batch.instances.clone());
        self.draws += 1;
        Ok(())
    }

    fn bind(
        &mut self,
        pipeline: &Pipeline,
        group: usize,
        object: &Object,
    ) -> Result<Option<wgpu::BindGroup>, RenderError> {
        let program = &pipeline.program;
        let key = &program.permutation.key;
        program.bind(&self.gpu.device, group, |binding| {
            match binding.name.as_str() {
                "instances" => self.frame.instances(self.gpu, key, binding),
                _ => self.stock.material(self.gpu, Some(object), key, binding),
            }
        })
    }
}
