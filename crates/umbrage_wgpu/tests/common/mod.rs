//! An engine without casters to speak of, and a method whose plan and shaders a test makes up.
#![allow(dead_code, reason = "each test program uses its own part")]

use std::sync::Arc;

use glam::{DVec3, Vec3};
use umbrage_compose::{Composer, Library, Package, Target};
use umbrage_shadow::{
    Aabb, Answers, Constants, Frame, Light, LightKind, Part, PlanError, Registry, ShadowMethod,
    ShadowPlan, Support, View,
};
use umbrage_testkit::headless;
use umbrage_wgpu::{
    CameraDepth, Drawn, Draws, Error, Executed, Executor, Host, Identity, Job, Question, Shadow,
    Sides,
};

type Planner = Arc<dyn Fn(&Frame<'_>) -> Result<ShadowPlan, PlanError> + Send + Sync>;

struct Probe(Planner);

impl Part for Probe {
    fn name(&self) -> &str {
        "probe"
    }
}

impl ShadowMethod for Probe {
    fn supports(&self, _: &Light) -> Support {
        Support::Yes
    }
    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        (self.0)(frame)
    }
}

/// Draws one triangle around the viewport for each caster.
pub(crate) struct Engine;

impl Host for Engine {
    fn draw(&mut self, casters: &[usize], draws: &mut Draws<'_, '_>) -> Drawn {
        let pipeline = draws.pipeline(&[], &[], Sides::default())?.pipeline;
        draws.set(&pipeline)?;
        for _ in casters {
            draws.pass().draw(0..3, 0..1);
        }
        Ok(())
    }
}

/// A device, and lights that the method `probe` shadows.
pub(crate) struct Lab {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    executor: Executor,
    library: Library,
    parts: Registry,
    pub(crate) depth: Option<(wgpu::TextureView, u64)>,
    /// How large frames say that it is.
    pub(crate) told: [u32; 2],
}

impl Lab {
    /// A lab whose passes are these: a name, and the WESL of a module `package::NAME`.
    pub(crate) fn new(
        passes: &[(&str, &str)],
        plan: impl Fn(&Frame<'_>) -> ShadowPlan + Send + Sync + 'static,
    ) -> Self {
        let values = passes.iter().map(|(name, text)| {
            let over = match (text.contains("@compute"), text.contains("frame")) {
                (true, _) => "Compute",
                (_, true) => "Casters",
                _ => "Screen",
            };
            format!("\"{name}\": (root: \"package::{name}\", pass: (over: {over}, purpose: Maps)),")
        });
        let axes = format!(
            "(axes: {{ \"pass\": (values: {{ {} }}), \"method\": (values: {{ \"probe\": (bind: {{ \
             \"umbrage::interface::shadow\": \"package::shadow\" }}) }}) }})",
            values.collect::<String>()
        );
        let shadow = "fn calc_shadow(position_ws: vec3f) -> f32 { return 1.0; }";
        let mut files = vec![
            ("axes.ron".to_owned(), axes),
            ("shadow.wesl".to_owned(), shadow.to_owned()),
        ];
        let passes = passes.iter();
        files.extend(passes.map(|(name, text)| (format!("{name}.wesl"), (*text).to_owned())));
        let own = Package::from_sources("probe", "probe", files).expect("a package");
        let ours = umbrage_shader_lib::package().expect("the shader library");
        let library = Library::new([ours, own]).expect("the library");
        let (device, queue) = headless::device().expect("a device");
        let composer = Arc::new(Composer::new(library.clone(), Target::webgpu()));
        let mut lab = Self {
            executor: Executor::new(&device, &queue, composer),
            device,
            queue,
            library,
            parts: Registry::new(),
            depth: None,
            told: [4, 4],
        };
        lab.plan_by(plan);
        lab
    }

    /// Has plans be these from now on.
    pub(crate) fn plan_by(
        &mut self,
        plan: impl Fn(&Frame<'_>) -> ShadowPlan + Send + Sync + 'static,
    ) {
        self.try_plan_by(move |frame| Ok(plan(frame)));
    }

    pub(crate) fn try_plan_by(
        &mut self,
        plan: impl Fn(&Frame<'_>) -> Result<ShadowPlan, PlanError> + Send + Sync + 'static,
    ) {
        let mut parts = Registry::new();
        let added = parts.methods.add(Probe(Arc::new(plan)));
        added.expect("the only one");
        self.parts = parts;
    }

    /// The shadow of light `number`, with these answers.
    pub(crate) fn shadow(&mut self, number: u64, answers: &Answers) -> Result<Executed, Error> {
        let light = Light {
            kind: LightKind::Directional {
                direction: DVec3::NEG_Y,
            },
            color: Vec3::ONE,
        };
        let view = View::perspective(DVec3::Y, DVec3::NEG_Z, (1.0, 1.5), [0.1, 100.0]);
        let shadow = Shadow::new("probe");
        let shadow = shadow.check(&self.parts, &self.library).expect("parts");
        let bounds = [Aabb::new([-1.0, 0.0, -6.0], [1.0, 2.0, -5.0])];
        let constants = Constants::new();
        let depth = self.depth.as_ref();
        let job = Job {
            light: number,
            name: "sun",
            shadow: &shadow,
            frame: &Frame {
                answers,
                camera_depth: depth.map(|_| self.told),
                ..shadow.frame(&view, &light, &bounds, &bounds)
            },
            casters: &Identity::unchanging(1),
            choices: &[],
            constants: &constants,
            camera_depth: depth.map(|(view, revision)| CameraDepth {
                view,
                revision: *revision,
            }),
        };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let done = self.executor.shadow(&mut encoder, &job, &mut Engine);
        if done.is_ok() {
            self.queue.submit([encoder.finish()]);
        }
        let refused = pollster::block_on(scope.pop());
        assert!(refused.is_none(), "{refused:?}");
        done
    }

    /// Why light `number` gets no shadow.
    pub(crate) fn refusal(&mut self, number: u64) -> String {
        let refused = self.shadow(number, Answers::none());
        refused.err().expect("refused").to_string()
    }

    /// The answers to a question.
    pub(crate) fn answer(&self, question: &Question) -> Answers {
        let buffer = question.buffer();
        buffer.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("mapped"));
        let done = self.device.poll(wgpu::PollType::wait_indefinitely());
        done.expect("done");
        question.answer(&buffer.get_mapped_range(..).expect("mapped"))
    }

    /// The answer about `buffer` to what light `number` asks first, as words.
    pub(crate) fn words(&mut self, number: u64, buffer: &str) -> Vec<u32> {
        let done = self.shadow(number, Answers::none()).expect("executed");
        words(&self.answer(&done.question.expect("a question")), buffer)
    }
}

/// The words that a buffer held.
pub(crate) fn words(answers: &Answers, buffer: &str) -> Vec<u32> {
    let (words, rest) = answers.get(buffer).expect("an answer").as_chunks::<4>();
    assert!(rest.is_empty());
    words.iter().copied().map(u32::from_le_bytes).collect()
}
