//! Turns a list of objects into draw commands: composes what they need, binds what it reads.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    ops::Range,
    sync::Arc,
};

use glam::{Mat4, Vec3};
use umbrage_compose::{BindingKind, Composed, Key, Layout, Permutation, Purpose};
use umbrage_shadow::Constants;
use umbrage_wgpu::{
    DrawState, Pipeline, Resource, ShadowResources, Unfiltered, reads_facing, vertices_read,
};

use super::{
    RenderOptions, Renderer,
    assets::{GpuMesh, Vertices, layouts},
    bind::MATERIAL,
    lights::{self, LightSetup},
    objects::{Objects, Run},
    passes::NamedPass,
    timer::Timer,
};
use crate::{
    PermutationUse, RenderError, Report,
    scene::{Material, Object},
};

/// What is being rendered, and what has been found out on the way.
pub(super) struct FrameState<'a> {
    pub(super) options: &'a RenderOptions,
    pub(super) objects: Objects<'a>,
    pub(super) encoder: wgpu::CommandEncoder,
    pub(super) report: Report,
    pub(super) timer: Timer,
    /// The lights whose shadow maps this frame uses, by their numbers.
    pub(super) shadow_maps: BTreeSet<u64>,
    /// What is seen, where it was laid down.
    pub(super) planes: Option<wgpu::TextureView>,
    /// The depth of what is seen, once it is there for the air.
    pub(super) seen_depth: Option<wgpu::TextureView>,
    /// The members of the shader's block `rays`.
    pub(super) rays: Constants,
    /// Whether the camera's rays are parallel.
    pub(super) orthographic: bool,
    /// By the full keys, so that each is asked for once.
    composed: BTreeMap<Vec<Key>, Arc<Permutation>>,
    /// The array of instances, by the layout of its element.
    pub(super) instances: Vec<(Layout, wgpu::Buffer)>,
    /// The shadow methods' storage buffers, by the light's number, the binding's name and its kind.
    pub(super) buffers: Vec<((usize, String, BindingKind), Resource)>,
}

/// What all draws of one pass share.
pub(super) struct PassInputs<'a> {
    pub(super) pass: NamedPass<'a>,
    /// The light on whose account it is drawn.
    pub(super) cause: Option<&'a str>,
    pub(super) view_proj: Mat4,
    pub(super) ambient: Vec3,
    /// The lights that the shader reads, in this order.
    pub(super) lights: Vec<LightInputs<'a>>,
    pub(super) vertices: Vertices,
    /// With `front` as it is for objects that are not mirrored.
    pub(super) state: DrawState,
}

/// The light that a pass is for.
#[derive(Clone, Copy)]
pub(super) struct LightInputs<'a> {
    pub(super) setup: &'a LightSetup<'a>,
    pub(super) constants: &'a Constants,
    pub(super) shadow: Option<&'a ShadowResources>,
    pub(super) term: Term<'a>,
}

/// Where a shader has a light's shadow term from.
#[derive(Clone, Copy)]
pub(super) enum Term<'a> {
    /// The light's method.
    Method,
    /// The light's method, with these values of its axes in place of the light's.
    Region(&'a BTreeMap<String, String>),
    /// A mask.
    Mask,
    /// The light's method, at points in the air.
    Air,
}

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

impl<'a> FrameState<'a> {
    pub(super) fn new(
        options: &'a RenderOptions,
        objects: Objects<'a>,
        encoder: wgpu::CommandEncoder,
        timer: Timer,
        rays: Constants,
        orthographic: bool,
    ) -> Self {
        Self {
            planes: None,
            seen_depth: None,
            rays,
            orthographic,
            options,
            objects,
            encoder,
            report: Report::default(),
            timer,
            shadow_maps: BTreeSet::new(),
            composed: BTreeMap::new(),
            instances: Vec::new(),
            buffers: Vec::new(),
        }
    }
}

impl FrameState<'_> {
    /// Reports a permutation that was needed: for an object (or what stands for one), and for a light where it was for one.
    pub(super) fn note(
        &mut self,
        composed: &Composed,
        purpose: Purpose,
        (object, light): (&str, Option<&str>),
    ) {
        let (key, others) = (&composed.permutation.key, &composed.permutation.others);
        let mut reported = self.report.permutations.iter();
        if reported.any(|used| used.key == *key && used.others == *others) {
            return;
        }
        self.report.warnings.extend(composed.warnings.clone());
        self.report.permutations.push(PermutationUse {
            key: key.clone(),
            others: others.clone(),
            purpose,
            source: composed.source,
            object: object.to_owned(),
            light: light.map(str::to_owned),
        });
    }
}

/// What of the lights' resources must not be filtered.
pub(super) fn unfiltered(lights: &[LightInputs<'_>]) -> Unfiltered {
    let none = ShadowResources::default();
    let shadows: Vec<_> = lights.iter().map(|l| l.shadow.unwrap_or(&none)).collect();
    umbrage_wgpu::unfiltered(&shadows)
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
        let mut shared: HashMap<(*const Pipeline, usize), wgpu::BindGroup> = HashMap::new();
        let mut materials: HashMap<(*const Pipeline, *const Material), wgpu::BindGroup> =
            HashMap::new();
        for run in frame.objects.runs(slots) {
            let Run {
                object,
                mirrored,
                instances,
            } = run;
            if object.mesh.indices.is_empty() {
                continue;
            }
            let permutation = self.compose(frame, inputs, &object.name, Some(object))?;
            let (_, vertices) = vertices_read(&permutation, &layouts(object));
            let locations = vertices.iter().map(|v| v.attributes[0].shader_location);
            let attributes = locations.collect();
            let pipeline = self.pipeline(&permutation, &inputs.state, mirrored, &vertices)?;
            let mut groups = Vec::new();
            for group in 0..pipeline.program.groups.len() {
                let id = Arc::as_ptr(&pipeline);
                let material = Arc::as_ptr(&object.material);
                let known = match group {
                    MATERIAL => materials.get(&(id, material)),
                    _ => shared.get(&(id, group)),
                };
                let bound = match known {
                    Some(bound) => Some(bound.clone()),
                    None => self.bind(frame, inputs, &pipeline.program, group, Some(object))?,
                };
                if let Some(bound) = &bound {
                    match group {
                        MATERIAL => materials.insert((id, material), bound.clone()),
                        _ => shared.insert((id, group), bound.clone()),
                    };
                }
                groups.push(bound);
            }
            let mesh = self.assets.mesh(&self.gpu, object, inputs.vertices)?;
            commands.push(Command {
                pipeline,
                attributes,
                groups,
                mesh: Some(mesh),
                instances,
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
        let groups = self.bind_all(frame, inputs, &pipeline.program)?;
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
