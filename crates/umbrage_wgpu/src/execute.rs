//! Executes plans.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    sync::Arc,
};

use umbrage_compose::{Composed, Composer, Permutation, ProjectedKey};
use umbrage_shadow::{
    BufferDesc, CasterPass, ComputePass, Constants, Cull, Frame, Pass, ScreenPass, ShadowPlan,
    Source, Viewport, Workgroups,
};

use crate::{
    Backlog, Binder, CheckedShadow, Computation, DrawState, Draws, Error, Groups, Host, Identity,
    Pipeline, Program, Question, Readiness, ShadowResources, Times, Unfiltered, Wanted,
    ahead::Ahead,
    area::{Area, Empty, Shadower},
    asked::{Asked, Outcome},
    check,
    kept::Kept,
    program::PipelineId,
    record::{self, Memory, Place, Ready, Record, Shader, Work},
    resources::{self, unfiltered},
    sides,
    targets::{Targets, attachment, depth_attachment},
    touches::{reads_camera_depth, source},
};

/// Executes plans, and keeps from frame to frame what it made for them: textures and what stands in them, pipelines.
pub struct Executor {
    pub(crate) shared: Shared,
    ahead: Ahead,
    pub(crate) lights: BTreeMap<u64, Memory>,
}

/// A light's shadow, asked for.
pub struct Job<'a> {
    /// The light, the same number from frame to frame.
    pub light: u64,
    /// The light's name, for errors.
    pub name: &'a str,
    /// The parts that make its shadow, and what is chosen for them.
    pub shadow: &'a CheckedShadow,
    /// The frame that they plan for.
    pub frame: &'a Frame<'a>,
    /// Which casters these are: one for each of the frame's.
    pub casters: &'a [Identity],
    /// Values for axes of the shader library in all passes, before the parts' own.
    pub choices: &'a [(&'a str, &'a str)],
    /// Members of the uniform block `light`, where passes read one.
    pub constants: &'a Constants,
    /// The camera's depth, where there is one. The frame tells how large it is.
    pub camera_depth: Option<CameraDepth<'a>>,
}

/// The camera's depth, for passes that plan by what is seen.
#[derive(Clone, Copy, Debug)]
pub struct CameraDepth<'a> {
    /// A view of depth alone, of one sample, to bind: reversed, 0 where nothing is seen. When the passes are run, it is
    /// filled.
    pub view: &'a wgpu::TextureView,
    /// Its state: another whenever it may hold something else.
    pub revision: u64,
}

/// A plan, executed.
pub struct Executed {
    /// Resources that the light's shaders read.
    pub resources: Arc<ShadowResources>,
    /// The plan, and for each of its passes what became of it.
    pub plan: Arc<ShadowPlan>,
    /// In the order of the plan's passes.
    pub runs: Vec<Run>,
    /// The question that the plan ends in: then the light has no shadow yet, and is to be asked for again with the answer.
    pub question: Option<Question>,
}

/// Outcome of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Run {
    /// Its targets stand already.
    Kept,
    /// It was recorded for the part of its targets that casters changed.
    Repaired,
    /// It was recorded.
    Recorded,
}

/// The keys of a permutation.
type Keys = Vec<ProjectedKey>;

/// A device, and what was made for it.
pub(crate) struct Shared {
    pub(crate) device: wgpu::Device,
    queue: wgpu::Queue,
    composer: Arc<Composer>,
    pub(crate) binder: Binder,
    /// Whether textures are made so that they can be copied.
    pub(crate) copies: bool,
    pipelines: Kept<PipelineId, Arc<Pipeline>>,
    computations: Kept<(Keys, Unfiltered), Arc<Computation>>,
    /// Pipelines that make a part of targets empty.
    emptied: HashMap<Empty, wgpu::RenderPipeline>,
}

impl Shared {
    fn begin_frame(&mut self) {
        self.binder.begin_frame();
        self.pipelines.begin_frame();
        self.computations.begin_frame();
    }

    /// Keeps what workers made, unless it was made here meanwhile.
    fn take_in(&mut self, made: Vec<(PipelineId, Arc<Pipeline>)>) {
        for (id, pipeline) in made {
            if self.pipelines.get(&id).is_none() {
                self.pipelines.insert(id, pipeline);
            }
        }
    }

    pub(crate) fn compose<'a>(
        &self,
        choices: impl Iterator<Item = (&'a str, &'a str)>,
    ) -> Result<Composed, Error> {
        // Of two values for one axis, the later one counts.
        let choices: BTreeMap<_, _> = choices.collect();
        let key = self.composer.library().key(choices)?;
        Ok(self.composer.compose(&key)?)
    }

    pub(crate) fn pipeline(
        &mut self,
        permutation: &Arc<Permutation>,
        state: DrawState,
        vertices: &[wgpu::VertexBufferLayout<'_>],
    ) -> Result<Arc<Pipeline>, Error> {
        let id = PipelineId::new(permutation, state, vertices);
        if let Some(known) = self.pipelines.get(&id) {
            return Ok(Arc::clone(known));
        }
        let made = Pipeline::new(&self.device, Arc::clone(permutation), &id.state, vertices)?;
        let made = Arc::new(made);
        self.pipelines.insert(id, Arc::clone(&made));
        Ok(made)
    }

    fn emptied(&mut self, empty: Empty) -> wgpu::RenderPipeline {
        let made = self.emptied.entry(empty);
        made.or_insert_with_key(|empty| empty.pipeline(&self.device))
            .clone()
    }

    fn computation(
        &mut self,
        permutation: &Arc<Permutation>,
        unfiltered: Unfiltered,
    ) -> Result<Arc<Computation>, Error> {
        let id = (permutation.keys().cloned().collect(), unfiltered);
        if let Some(known) = self.computations.get(&id) {
            return Ok(Arc::clone(known));
        }
        let made = Computation::new(&self.device, Arc::clone(permutation), &id.1)?;
        let made = Arc::new(made);
        self.computations.insert(id, Arc::clone(&made));
        Ok(made)
    }
}

/// Most pipelines of a kind that are kept, where a frame does not use more.
const MOST_PIPELINES: usize = 4_096;

impl Executor {
    /// An executor for `device`, whose passes' permutations come from `composer`.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, composer: Arc<Composer>) -> Self {
        Self {
            ahead: Ahead::new(device, &composer, MOST_PIPELINES),
            shared: Shared {
                device: device.clone(),
                queue: queue.clone(),
                composer,
                binder: Binder::new(device, queue),
                copies: false,
                pipelines: Kept::new(MOST_PIPELINES),
                computations: Kept::new(MOST_PIPELINES),
                emptied: HashMap::new(),
            },
            lights: BTreeMap::new(),
        }
    }

    /// The light's shadow: its parts plan, and what does not stand yet of their plan is recorded into `encoder`.
    ///
    /// # Errors
    /// Refusals of the parts, a plan that cannot be executed, faults of shaders, and errors of `host`. What was recorded for
    /// the light does no harm then, and is drawn anew the next time.
    pub fn shadow(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        job: &Job<'_>,
        host: &mut dyn Host,
    ) -> Result<Executed, Error> {
        let asked = self.lights.get(&job.light);
        let asked = asked.and_then(|memory| memory.asked.as_ref());
        if let Some((executed, composed)) = asked.and_then(|asked| asked.again(job)) {
            for (shader, composed) in composed {
                host.composed(shader, composed);
            }
            return Ok(executed);
        }
        let plan = check::plan(job, self.shared.device.features())?;
        let shaders = self.shaders(job, &plan, host)?;
        // Put back once all is recorded.
        let mut memory = self.lights.remove(&job.light).unwrap_or_default();
        let before = memory.asked.take();
        let mut execution = Execution::new(&mut self.shared, job, memory, &plan)?;
        let runs = execution.run(encoder, &plan, &shaders, host)?;
        let Execution {
            mut memory,
            mut resources,
            ..
        } = execution;
        resources.constants = plan.constants.clone();
        resources.regions = plan.regions.clone();
        let (device, answers) = (&self.shared.device, job.frame.answers);
        let question = Question::record(device, encoder, &plan, &memory.buffers, answers);
        let (plan, resources) = (Arc::new(plan), Arc::new(resources));
        if question.is_none() {
            let passes = plan.passes.iter().zip(shaders);
            let composed = passes.filter_map(|(pass, composed)| Some((pass, composed?)));
            let composed: Vec<_> = composed.collect();
            let mut reads = composed.iter();
            let reads = reads.any(|(pass, shader)| reads_camera_depth(pass, &shader.permutation));
            let depth = job.camera_depth.filter(|_| reads);
            let named = |(pass, composed): (&Pass, _)| (pass.shader().to_owned(), composed);
            let outcome = Outcome {
                plan: Arc::clone(&plan),
                resources: Arc::clone(&resources),
                composed: composed.into_iter().map(named).collect(),
                depth: depth.map(|depth| depth.revision),
            };
            memory.asked = Some(Asked::new(job, outcome, before));
        }
        self.lights.insert(job.light, memory);
        Ok(Executed {
            resources,
            plan,
            runs,
            question,
        })
    }

    /// The shaders of the plan's passes that draw no caster.
    fn shaders(
        &self,
        job: &Job<'_>,
        plan: &ShadowPlan,
        host: &mut dyn Host,
    ) -> Result<Vec<Option<Composed>>, Error> {
        let own: Vec<_> = job.shadow.choices(job.frame.light).collect();
        let all = job.choices.iter().chain(&own).copied();
        let shader = |pass: &Pass| {
            if matches!(pass, Pass::Casters(_)) {
                return Ok(None);
            }
            let choices = all.clone().chain([("pass", pass.shader())]);
            let composed = self.shared.compose(choices)?;
            host.composed(pass.shader(), &composed);
            if reads_camera_depth(pass, &composed.permutation) {
                check::camera_depth(job, pass)?;
            }
            Ok(Some(composed))
        };
        plan.passes.iter().map(shader).collect()
    }

    /// Lets go of all that was made for the lights that `is_kept` does not hold for.
    pub fn retain(&mut self, mut is_kept: impl FnMut(u64) -> bool) {
        self.lights.retain(|light, _| is_kept(*light));
    }

    /// Has everything be drawn anew for `light`: for one whose recorded passes were not submitted. Its textures are kept.
    pub fn forget(&mut self, light: u64) {
        if let Some(memory) = self.lights.get_mut(&light) {
            memory.asked = None;
            memory.drawn.clear();
            memory.contents.clear();
        }
    }

    /// Begins a frame, when all that was recorded before is submitted: buffers that the frame before did not need take the
    /// next values, what workers made is there from now on, and of too many pipelines those go that were not used the
    /// longest. To be called once a frame.
    pub fn begin_frame(&mut self) {
        self.shared.begin_frame();
        let made = self.ahead.begin_frame();
        self.shared.take_in(made);
    }

    /// Whether the pipeline that is `wanted` is made; if not, workers make it, and frames go on without. Of all that
    /// waits, comes first what a later frame asked for, and then that of which more is `seen`: pixels, say, or objects. A
    /// frame asks again for what it still wants. Asked for long before it is needed, nothing need wait for it.
    ///
    /// A pipeline that is ready is had by [`pipeline`](Self::pipeline), from the permutation that the composer has by now, at the cost of
    /// two look-ups.
    ///
    /// # Errors
    /// Faults of the shaders, and what the device refuses: once for each that is wanted, then it has
    /// [failed](Readiness::Failed).
    pub fn prepare(&mut self, wanted: &Wanted, seen: u32) -> Result<Readiness, Error> {
        let kept = &mut self.shared.pipelines;
        let is_kept = |id: &PipelineId| kept.get(id).is_some();
        self.ahead.prepare(wanted, seen, is_kept)
    }

    /// Waits until workers have made all that they were asked for: behind a loading screen, say.
    pub fn settle(&mut self) {
        let made = self.ahead.settle();
        self.shared.take_in(made);
    }

    /// How much waits for workers, and what there was no room for.
    pub fn backlog(&self) -> Backlog {
        Backlog {
            let_go: self.shared.pipelines.let_go() + self.shared.computations.let_go(),
            ..self.ahead.backlog()
        }
    }

    /// The binder of shaders' resources, the engine's own among them.
    pub fn binder(&mut self) -> &mut Binder {
        &mut self.shared.binder
    }

    /// Lets go of all lights, pipelines and bindings.
    pub fn clear(&mut self) {
        self.lights.clear();
        self.shared.binder.clear();
        self.shared.pipelines.clear();
        self.shared.computations.clear();
        self.ahead.clear();
        self.shared.emptied.clear();
    }

    /// The pipeline that draws vertices in buffers of these layouts with `permutation`; made once.
    ///
    /// # Errors
    /// A binding that no render pass can have.
    pub fn pipeline(
        &mut self,
        permutation: &Arc<Permutation>,
        state: DrawState,
        vertices: &[wgpu::VertexBufferLayout<'_>],
    ) -> Result<Arc<Pipeline>, Error> {
        self.shared.pipeline(permutation, state, vertices)
    }

    /// The pipeline that runs `permutation`, in which `unfiltered` names what is not to be filtered; made once.
    ///
    /// # Errors
    /// A binding that no compute pass can have.
    pub fn computation(
        &mut self,
        permutation: &Arc<Permutation>,
        unfiltered: Unfiltered,
    ) -> Result<Arc<Computation>, Error> {
        self.shared.computation(permutation, unfiltered)
    }

    /// All render pipelines that were made.
    pub fn pipelines(&self) -> impl Iterator<Item = &Arc<Pipeline>> {
        self.shared.pipelines.values()
    }

    /// The textures that stand for lights.
    pub fn textures(&self) -> impl Iterator<Item = &wgpu::Texture> {
        let lights = self.lights.values();
        lights.flat_map(|memory| memory.textures.values().map(|(_, texture)| texture))
    }
}

/// A plan under way.
pub(crate) struct Execution<'a> {
    pub(crate) shared: &'a mut Shared,
    pub(crate) job: &'a Job<'a>,
    pub(crate) memory: Memory,
    pub(crate) resources: ShadowResources,
    /// Textures and buffers that hold nothing yet, or were uploaded anew.
    new: BTreeSet<String>,
    /// Where a pass has written: only the first one into each place clears it, or, where parts are repaired, the first one into
    /// each viewport, known by its corner.
    pub(crate) filled: BTreeSet<(Place, Option<[u32; 2]>)>,
}

/// Where a pass is recorded, and where its times are noted.
type Recording<'a> = (&'a mut wgpu::CommandEncoder, Option<&'a Times>);

impl<'a> Execution<'a> {
    fn new(
        shared: &'a mut Shared,
        job: &'a Job<'a>,
        mut memory: Memory,
        plan: &ShadowPlan,
    ) -> Result<Self, Error> {
        // A later plan may be shaded by textures that stand.
        if plan.asks.is_empty() {
            memory.let_go(plan);
        }
        let device = &shared.device;
        let kept = (&memory.textures, shared.copies);
        let (textures, mut new) = resources::textures(device, kept, job, plan)?;
        let (buffers, new_buffers) = resources::buffers(device, &memory.buffers, job, plan)?;
        memory.textures.extend(textures);
        memory.buffers.extend(buffers);
        new.extend(new_buffers);
        memory.drawn.retain(|(name, ..), _| !new.contains(name));
        memory.contents.retain(|name, _| !new.contains(name));
        for contents in &plan.contents {
            if memory.contents.get(&contents.texture) == Some(&contents.bytes) {
                continue;
            }
            if let Some(texture) = memory.textures.get(&contents.texture) {
                resources::upload(&shared.queue, texture, contents);
            }
            let (name, bytes) = (contents.texture.clone(), contents.bytes.clone());
            new.insert(name.clone());
            memory.contents.insert(name, bytes);
        }
        let kept = (&memory.textures, &memory.buffers);
        let mut resources = resources::resources(&mut shared.binder, plan, kept);
        resources.light = job.constants.clone();
        Ok(Self {
            shared,
            job,
            memory,
            resources,
            new,
            filled: BTreeSet::new(),
        })
    }

    fn run(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        plan: &ShadowPlan,
        shaders: &[Option<Composed>],
        host: &mut dyn Host,
    ) -> Result<Vec<Run>, Error> {
        let passes = plan.passes.iter().zip(shaders);
        let ready = passes.map(|(pass, shader)| self.ready(pass, shader.as_ref(), plan));
        let ready = ready.collect::<Result<Vec<_>, Error>>()?;
        self.check_reads(plan, ready.iter().map(|(_, touches)| touches))?;
        let wanted = record::by_place(&ready);
        let work = record::work(&ready, (&wanted, &self.memory.drawn), &self.new);
        let mut runs = Vec::with_capacity(work.len());
        for ((pass, composed), work) in plan.passes.iter().zip(shaders).zip(work) {
            let (run, area) = match work {
                Work::Nothing => (Run::Kept, None),
                Work::Repair(area) => (Run::Repaired, Some(area)),
                Work::Whole => (Run::Recorded, None),
            };
            runs.push(run);
            if run == Run::Kept {
                continue;
            }
            let times = host.times(pass);
            let times = times.as_ref();
            match (pass, composed) {
                (Pass::Casters(pass), _) => {
                    self.draw_casters((encoder, times), (pass, area), host)?;
                }
                (Pass::Screen(pass), Some(composed)) => {
                    self.draw_screen((encoder, times), pass, composed)?;
                }
                (Pass::Compute(pass), Some(composed)) => {
                    self.compute((encoder, times), pass, composed)?;
                }
                _ => return Err(self.bad("a pass of a kind that is not known here")),
            }
        }
        self.memory.drawn.extend(wanted);
        Ok(runs)
    }

    /// All that `pass` depends on, and what it touches. Faults are told before anything is recorded, as far as they can be.
    fn ready(
        &self,
        pass: &Pass,
        composed: Option<&Composed>,
        plan: &ShadowPlan,
    ) -> Result<Ready, Error> {
        let mut record = Record {
            pass: pass.clone(),
            origin: self.job.frame.view.position,
            casters: Vec::new(),
            choices: Vec::new(),
            shader: None,
        };
        if let Pass::Casters(pass) = pass {
            if pass.depth.is_none() && pass.colors.is_empty() {
                return Err(self.bad("casters into no texture"));
            }
            if !pass.view_proj.is_finite() {
                return Err(self.bad("casters under a matrix that is not finite"));
            }
            let bounds = self.job.frame.casters.casters;
            let one = |i: &usize| Some((*self.job.casters.get(*i)?, *bounds.get(*i)?));
            let casters = pass.casters.iter().map(one).collect::<Option<Vec<_>>>();
            record.casters = casters.ok_or_else(|| self.bad("a caster that there is not"))?;
            let choices = self.job.choices.iter();
            record.choices = choices
                .map(|(axis, value)| ((*axis).to_owned(), (*value).to_owned()))
                .collect();
        }
        if let Pass::Screen(pass) = pass
            && pass.targets.is_empty()
        {
            return Err(self.bad("a full-screen pass into no texture"));
        }
        let permutation = composed.map(|composed| &*composed.permutation);
        let touches = self.touches(pass, permutation)?;
        if let Some(permutation) = permutation {
            record.shader = Some(self.shader(pass, permutation, plan));
        }
        Ok((Arc::new(record), touches))
    }

    /// The shader of `pass` and all that it depends on, textures and buffers that passes fill apart.
    fn shader(&self, pass: &Pass, permutation: &Permutation, plan: &ShadowPlan) -> Shader {
        let bindings = &permutation.reflection.bindings;
        let reads = |name: &str| bindings.iter().any(|binding| binding.name == name);
        let renamed = pass.reads().map_or(&[][..], |reads| &reads.renamed);
        let stored = |desc: &&BufferDesc| {
            let mut sources = bindings
                .iter()
                .map(|binding| source(renamed, &binding.name));
            sources.any(|source| source.name == desc.name)
        };
        let depth = self.job.camera_depth;
        let depth = depth.filter(|_| reads_camera_depth(pass, permutation));
        Shader {
            key: permutation.key.clone(),
            light: self.job.constants.clone(),
            samplers: (plan.samplers.iter())
                .filter(|desc| reads(&desc.name))
                .cloned()
                .collect(),
            buffers: plan.buffers.iter().filter(stored).cloned().collect(),
            camera_depth: depth.map(|depth| depth.revision),
        }
    }

    fn draw_casters(
        &mut self,
        (encoder, times): Recording<'_>,
        (pass, area): (&CasterPass, Option<Area>),
        host: &mut dyn Host,
    ) -> Result<(), Error> {
        let mut targets = self.caster_targets(pass, area)?;
        let emptied = area.and_then(|_| targets.keep());
        let emptied = emptied.map(|empty| self.shared.emptied(empty));
        let (depth, colors) = (&targets.depth, &targets.colors);
        let state = DrawState {
            colors: colors.iter().map(|color| color.state).collect(),
            depth: depth.as_ref().map(|(format, ..)| *format),
            compare: pass
                .depth
                .as_ref()
                .map_or(wgpu::CompareFunction::Always, |depth| depth.compare),
            write_depth: depth.is_some(),
            cull: match pass.cull {
                Cull::Side(face) => Some(face),
                Cull::Nothing | Cull::Hidden => None,
            },
            ..DrawState::NOTHING
        };
        let colors: Vec<_> = colors.iter().map(attachment).collect();
        let mut recorded = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&pass.shader),
            color_attachments: &colors,
            depth_stencil_attachment: depth.as_ref().map(depth_attachment),
            timestamp_writes: times.map(render_times),
            ..Default::default()
        });
        set_viewport(&mut recorded, &pass.viewport);
        let mut casters = pass.casters.clone();
        casters.sort_unstable();
        casters.dedup();
        let (bounds, origin) = (self.job.frame.casters.casters, self.job.frame.view.position);
        let boxes = casters.iter().filter_map(|caster| bounds.get(*caster));
        // Of all casters, so that a part is drawn as the whole is.
        let hidden = sides::hidden(pass, boxes, origin);
        if let Some(area) = area {
            let size = [0, 1].map(|i| area.to[i] - area.from[i]);
            recorded.set_scissor_rect(area.from[0], area.from[1], size[0], size[1]);
            if let Some(emptied) = &emptied {
                recorded.set_pipeline(emptied);
                recorded.draw(0..3, 0..1);
            }
            let shadower = Shadower::new(pass, origin);
            let reaches = |caster: &usize| {
                let drawn = bounds.get(*caster).and_then(|aabb| shadower.area(aabb));
                drawn.is_some_and(|drawn| drawn.meets(area))
            };
            casters.retain(reaches);
        }
        let mut draws = Draws {
            shared: &mut *self.shared,
            pass: recorded,
            shader: &pass.shader,
            choices: self.job.choices,
            state,
            hidden,
            constants: (pass.constants.clone()).with("view_proj", pass.view_proj),
            groups: HashMap::new(),
        };
        host.draw(&casters, &mut draws)
            .map_err(|source| match source.downcast::<Error>() {
                Ok(own) => own.in_pass(self.job),
                Err(source) => Error::Casters {
                    light: self.job.name.to_owned(),
                    source,
                },
            })
    }

    fn draw_screen(
        &mut self,
        (encoder, times): Recording<'_>,
        pass: &ScreenPass,
        composed: &Composed,
    ) -> Result<(), Error> {
        let Targets { depth, colors } = self.screen_targets(pass)?;
        let given = self.given_to(&pass.reads, &composed.permutation)?;
        let state = DrawState {
            colors: colors.iter().map(|color| color.state).collect(),
            depth: depth.as_ref().map(|(format, ..)| *format),
            write_depth: depth.is_some(),
            unfiltered: unfiltered(&[&given]),
            ..DrawState::NOTHING
        };
        let pipeline = self.shared.pipeline(&composed.permutation, state, &[]);
        let pipeline = pipeline.map_err(|error| error.in_pass(self.job))?;
        let groups = self.groups(&pipeline.program, &given)?;
        let colors: Vec<_> = colors.iter().map(attachment).collect();
        let mut recorded = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&pass.shader),
            color_attachments: &colors,
            depth_stencil_attachment: depth.as_ref().map(depth_attachment),
            timestamp_writes: times.map(render_times),
            ..Default::default()
        });
        set_viewport(&mut recorded, &pass.viewport);
        recorded.set_pipeline(&pipeline.pipeline);
        groups.set(&mut recorded);
        recorded.draw(0..3, 0..1);
        Ok(())
    }

    fn compute(
        &mut self,
        (encoder, times): Recording<'_>,
        pass: &ComputePass,
        composed: &Composed,
    ) -> Result<(), Error> {
        for Source { name, .. } in &pass.writes {
            if let Some(buffer) = self.resources.written.get(name)
                && self.filled.insert(((name.clone(), 0, 0), None))
            {
                encoder.clear_buffer(buffer, 0, None);
            }
        }
        let given = self.given_to(&pass.reads, &composed.permutation)?;
        let unfiltered = unfiltered(&[&given]);
        let computation = self.shared.computation(&composed.permutation, unfiltered)?;
        let groups = self.groups(&computation.program, &given)?;
        let mut recorded = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(&pass.shader),
            timestamp_writes: times.map(|(set, [begin, end])| wgpu::ComputePassTimestampWrites {
                query_set: set,
                beginning_of_pass_write_index: Some(*begin),
                end_of_pass_write_index: Some(*end),
            }),
        });
        recorded.set_pipeline(&computation.pipeline);
        groups.set_compute(&mut recorded);
        match &pass.workgroups {
            Workgroups::Count([x, y, z]) => recorded.dispatch_workgroups(*x, *y, *z),
            Workgroups::Indirect { buffer, offset } => {
                if let Some(buffer) = self.resources.written.get(buffer) {
                    recorded.dispatch_workgroups_indirect(buffer, *offset);
                }
            }
        }
        Ok(())
    }

    /// Bind groups of a shader that draws no caster.
    fn groups(&mut self, program: &Program, given: &ShadowResources) -> Result<Groups, Error> {
        let groups = self.shared.binder.groups(program, &[given], &[]);
        groups.map_err(|error| error.in_pass(self.job))
    }
}

fn set_viewport(pass: &mut wgpu::RenderPass<'_>, area: &Viewport) {
    let [x, y, width, height] = [area.x, area.y, area.width, area.height].map(|n| n as f32);
    pass.set_viewport(x, y, width, height, 0.0, 1.0);
}

fn render_times((set, [begin, end]): &Times) -> wgpu::RenderPassTimestampWrites<'_> {
    wgpu::RenderPassTimestampWrites {
        query_set: set,
        beginning_of_pass_write_index: Some(*begin),
        end_of_pass_write_index: Some(*end),
    }
}
