//! Turns a list of objects into draw commands: composes what they need, binds what it reads.

use std::{collections::BTreeMap, ops::Range, sync::Arc};

use umbrage_compose::{Key, Permutation};
use umbrage_wgpu::{DrawState, Pipeline, vertices_read};

use super::{
    Renderer,
    assets::{GpuMesh, layouts},
    frame::{FrameState, LightInputs, PassInputs},
    lights,
    meanwhile::{StandIn, Way},
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
        let draws = frame.objects.draws(&self.gpu, slots)?;
        let instead = match self.way(frame, inputs, &draws)? {
            Way::Wanted => None,
            Way::StandIn(stand_in) => Some(stand_in),
            Way::Skip => return Ok(Vec::new()),
        };
        let mut commands = Vec::new();
        for draw in draws {
            let (object, mirrored) = (
                frame.objects.at(draw.first),
                frame.objects.is_mirrored(&draw),
            );
            if object.mesh.indices.is_empty() {
                continue;
            }
            let keys = self.keys(frame, inputs, Some(object), instead)?;
            let permutation = self.compose(frame, inputs, &object.name, keys)?;
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
        let keys = self.keys(frame, inputs, None, None)?;
        let permutation = self.compose(frame, inputs, cause, keys)?;
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

    /// Keys of the permutation that this pass needs, for an object where one is drawn; or of what stands in for it.
    pub(super) fn keys(
        &self,
        frame: &FrameState<'_>,
        inputs: &PassInputs<'_>,
        object: Option<&Object>,
        instead: Option<&StandIn>,
    ) -> Result<Vec<Key>, RenderError> {
        let library = self.composer.library();
        let view = (frame.options, frame.orthographic);
        let key = |light: Option<&LightInputs<'_>>| {
            let light = light.map(|light| (light.setup, light.term));
            let key = lights::key(library, view, inputs.pass, light, object)?;
            let Some(StandIn { axes, .. }) = instead else {
                return Ok(key);
            };
            let mut choices: BTreeMap<_, _> = key.choices().collect();
            choices.extend(axes.iter().map(|(axis, value)| (&**axis, &**value)));
            Ok(library.key(choices)?)
        };
        match inputs.lights.as_slice() {
            [] => Ok(vec![key(None)?]),
            lights => lights.iter().map(|light| key(Some(light))).collect(),
        }
    }

    /// The permutation of `keys`, that this pass needs for `cause` (the name that faults give); composed on first need.
    fn compose(
        &self,
        frame: &mut FrameState<'_>,
        inputs: &PassInputs<'_>,
        cause: &str,
        keys: Vec<Key>,
    ) -> Result<Arc<Permutation>, RenderError> {
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
        let state = state.clone().facing(mirrored, permutation);
        Ok(self.executor.pipeline(permutation, state, vertices)?)
    }
}
