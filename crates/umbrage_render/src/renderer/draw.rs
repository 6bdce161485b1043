//! Turns a list of objects into draw commands: composes what they need, binds what it reads.

use std::{ops::Range, sync::Arc};

use umbrage_compose::Permutation;
use umbrage_wgpu::{DrawState, Pipeline, reads_facing, vertices_read};

use super::{
    Renderer,
    assets::{GpuMesh, layouts},
    frame::{FrameState, LightInputs, PassInputs},
    lights,
};
use crate::{RenderError, scene::Object};

/// A draw, ready to be recorded.
pub(super) struct Command {
    pipeline: Arc<Pipeline>,
    /// The location that each vertex buffer is for.
    attributes: Vec<u32>,
    groups: Vec<Option<wgpu::BindGroup>>,
    /// None for one triangle around the picture.
    mesh: Option<Arc<GpuMesh>>,
    instances: Range<u32>,
}

/// Records `commands`.
pub(super) fn record(pass: &mut wgpu::RenderPass<'_>, commands: &[Command]) {
    for command in commands {
        pass.set_pipeline(&command.pipeline.pipeline);
        for (group, bound) in command.groups.iter().enumerate() {
            if let Some(bound) = bound {
                pass.set_bind_group(group as u32, bound, &[]);
            }
        }
        let Some(mesh) = &command.mesh else {
            pass.draw(0..3, command.instances.clone());
            continue;
        };
        for (slot, location) in command.attributes.iter().enumerate() {
            if let Some(buffer) = mesh.attribute(*location) {
                pass.set_vertex_buffer(slot as u32, buffer.slice(..));
            }
        }
        mesh.draw(pass, command.instances.clone());
    }
}

impl Renderer {
    /// The commands that draw the objects at `slots` (ascending).
    pub(super) fn prepare(
        &mut self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        slots: &[usize],
    ) -> Result<Vec<Command>, RenderError> {
        let mut commands = Vec::new();
        for draw in frame.objects.draws(&self.gpu, slots)? {
            let (object, mirrored) = (
                frame.objects.at(draw.first),
                frame.objects.is_mirrored(&draw),
            );
            if object.mesh.indices.is_empty() {
                continue;
            }
            let permutation = self.compose(frame, inputs, &object.name, Some(object))?;
            let (_, vertices) = vertices_read(&permutation, &layouts(object));
            let locations = vertices.iter().map(|v| v.attributes[0].shader_location);
            let attributes = locations.collect();
            let pipeline = self.pipeline(&permutation, &inputs.state, mirrored, &vertices)?;
            let groups = self.bind(frame, inputs, &pipeline.program, Some(object))?;
            let mesh = self.assets.mesh(&self.gpu, object, inputs.vertices)?;
            commands.push(Command {
                pipeline,
                attributes,
                groups,
                mesh: Some(mesh),
                instances: draw.instances,
            });
        }
        frame.report.draws += commands.len() as u32;
        Ok(commands)
    }

    /// The command that draws one triangle around the picture, for the sake of what is called `cause`.
    pub(super) fn prepare_screen(
        &mut self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        cause: &str,
    ) -> Result<Command, RenderError> {
        // The shader is no object's: the material has no say.
        let permutation = self.compose(frame, inputs, cause, None)?;
        let pipeline = self.pipeline(&permutation, &inputs.state, false, &[])?;
        let groups = self.bind(frame, inputs, &pipeline.program, None)?;
        frame.report.draws += 1;
        Ok(Command {
            pipeline,
            attributes: Vec::new(),
            groups,
            mesh: None,
            instances: 0..1,
        })
    }

    /// The permutation that this pass needs for `cause` (the name that faults give), for an object where one is drawn;
    /// composed on first need.
    pub(super) fn compose(
        &self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        cause: &str,
        object: Option<&Object>,
    ) -> Result<Arc<Permutation>, RenderError> {
        let library = self.composer.library();
        let view = (frame.options, frame.orthographic);
        let key = |light: Option<&LightInputs<'_>>| {
            let light = light.map(|light| (light.setup, light.term));
            lights::key(library, view, inputs.pass, light, object)
        };
        let keys = match inputs.lights.as_slice() {
            [] => vec![key(None)?],
            lights => lights
                .iter()
                .map(|light| key(Some(light)))
                .collect::<Result<_, _>>()?,
        };
        if let Some(known) = frame.composed.get(&keys) {
            return Ok(Arc::clone(known));
        }
        let composed = self.composer.compose_all(&keys)?;
        frame.note(&composed, inputs.pass.purpose, (cause, inputs.cause));
        frame
            .composed
            .insert(keys, Arc::clone(&composed.permutation));
        Ok(composed.permutation)
    }

    fn pipeline(
        &mut self,
        permutation: &Arc<Permutation>,
        state: &DrawState,
        mirrored: bool,
        vertices: &[wgpu::VertexBufferLayout<'_>],
    ) -> Result<Arc<Pipeline>, RenderError> {
        let mut state = state.clone();
        // Where it makes no difference which side is the front, one pipeline serves both.
        if mirrored && (state.cull.is_some() || reads_facing(permutation)) {
            state.front = wgpu::FrontFace::Cw;
        }
        Ok(self.executor.pipeline(permutation, state, vertices)?)
    }
}
