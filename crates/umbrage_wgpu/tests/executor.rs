//! An engine with one box, and what it hears when something is wrong.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use umbrage_compose::{Composer, Library, Target};
use umbrage_shadow::{
    Aabb, Constants, Frame, Light, LightKind, Part, PlanError, Registry, ShadowMethod, ShadowPlan,
    Support, View,
};
use umbrage_testkit::headless;
use umbrage_wgpu::{
    Drawn, Draws, Error, Executed, Executor, Host, Identity, Job, Run, Shadow, Sides, device,
};

const VERTEX: wgpu::VertexBufferLayout<'_> = wgpu::VertexBufferLayout {
    array_stride: 12,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3],
};

/// Spoils the plans of `basic`.
struct Spoilt(Spoil);

type Spoil = fn(&mut ShadowPlan);

impl Part for Spoilt {
    fn name(&self) -> &str {
        "basic"
    }
    fn settings(&self) -> &[umbrage_shadow::Setting] {
        umbrage_methods::methods::basic::Basic.settings()
    }
    fn axes(&self) -> &[&str] {
        umbrage_methods::methods::basic::Basic.axes()
    }
}

impl ShadowMethod for Spoilt {
    fn supports(&self, _: &Light) -> Support {
        Support::Yes
    }
    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        let mut plan = umbrage_methods::methods::basic::Basic.plan(frame)?;
        (self.0)(&mut plan);
        Ok(plan)
    }
}

/// Draws a triangle for a box, or says that it cannot.
struct Engine {
    device: wgpu::Device,
    queue: wgpu::Queue,
    refuses: bool,
    drawn: usize,
}

impl Host for Engine {
    fn draw(&mut self, casters: &[usize], draws: &mut Draws<'_, '_>) -> Drawn {
        if self.refuses {
            return Err("the meshes are not there yet".into());
        }
        let gpu = (&self.device, &self.queue);
        let corners = [[-1.0f32, 0.0, -5.0], [1.0, 0.0, -5.0], [0.0, 2.0, -5.0]];
        let bytes: Vec<_> = corners
            .concat()
            .into_iter()
            .flat_map(f32::to_le_bytes)
            .collect();
        let vertices = device::buffer(gpu, "a box", wgpu::BufferUsages::VERTEX, &bytes)?;
        let pipeline = draws.pipeline(&[], &[VERTEX], Sides::default())?.pipeline;
        draws.set(&pipeline)?;
        let key = &pipeline.program.permutation.key;
        let one = Constants::new().with("model", glam::Mat4::IDENTITY);
        let one = vec![one.with("normal", glam::Mat4::IDENTITY).into()].into();
        let has = |group: &usize| {
            let mut bindings = pipeline.program.bindings(*group);
            bindings.any(|binding| binding.name == "instances")
        };
        let objects = (0..4).find(has).expect("a group of objects");
        let drawn = vec![0_u32.into()].into();
        let group = (draws.binder()).bind(&pipeline.program, objects, |binder, binding| {
            let is_drawn = binding.name == "drawn";
            binder.storage(key, binding, if is_drawn { &drawn } else { &one })
        })?;
        let pass = draws.pass();
        pass.set_bind_group(objects as u32, &group, &[]);
        pass.set_vertex_buffer(0, vertices.slice(..));
        for _ in casters {
            pass.draw(0..3, 0..1);
            self.drawn += 1;
        }
        Ok(())
    }
}

struct Studio {
    engine: Engine,
    executor: Executor,
    library: Library,
    /// Height of the box, metres.
    height: f64,
}

impl Studio {
    fn new() -> Self {
        Self::with_groups(&[])
    }

    /// An engine whose bind groups have these numbers.
    fn with_groups(groups: &[(u32, u32)]) -> Self {
        let (device, queue) = headless::device().expect("a device");
        let package = umbrage_shader_lib::package().expect("the shader library");
        let package = package.with_groups(groups.iter().copied());
        let library = Library::new([package]).expect("the library");
        let composer = Arc::new(Composer::new(library.clone(), Target::webgpu()));
        Self {
            executor: Executor::new(&device, &queue, composer),
            engine: Engine {
                device,
                queue,
                refuses: false,
                drawn: 0,
            },
            library,
            height: 2.0,
        }
    }

    /// The shadow of light `number` by `parts`, with so many casters told of.
    fn shadow(
        &mut self,
        parts: &Registry,
        light: (u64, &str),
        told: usize,
    ) -> Result<Executed, Error> {
        let (done, refused) = self.try_shadow(parts, light, told);
        assert!(refused.is_none(), "{refused:?}");
        done
    }

    /// The same, with what the device says.
    fn try_shadow(
        &mut self,
        parts: &Registry,
        (number, filter): (u64, &str),
        told: usize,
    ) -> (Result<Executed, Error>, Option<wgpu::Error>) {
        let light = Light {
            kind: LightKind::Directional {
                direction: DVec3::new(0.3, -1.0, -0.2).normalize(),
            },
            color: Vec3::ONE,
        };
        let view = View::perspective(DVec3::Y, DVec3::NEG_Z, (1.0, 1.5), [0.1, 100.0]);
        let shadow = Shadow::new("basic").with("filter", filter);
        let shadow = shadow.check(parts, &self.library).expect("parts");
        let bounds = [Aabb::new([-1.0, 0.0, -6.0], [1.0, self.height, -5.0])];
        let constants = light.constants(view.position);
        let job = Job {
            light: number,
            name: "sun",
            shadow: &shadow,
            frame: &shadow.frame(&view, &light, &bounds, &bounds),
            casters: &Identity::unchanging(told),
            choices: &[],
            constants: &constants,
            camera_depth: None,
        };
        let device = self.engine.device.clone();
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut encoder = device.create_command_encoder(&Default::default());
        let done = self.executor.shadow(&mut encoder, &job, &mut self.engine);
        if done.is_ok() {
            self.engine.queue.submit([encoder.finish()]);
        }
        let refused = pollster::block_on(scope.pop());
        (done, refused)
    }
}

fn ours() -> Registry {
    umbrage_methods::registry().expect("names are unique")
}

fn spoilt(spoil: Spoil) -> Registry {
    let mut parts = Registry {
        methods: Registry::new().methods,
        ..ours()
    };
    parts.methods.add(Spoilt(spoil)).expect("the only one");
    parts
}

#[test]
fn what_stands_is_kept_until_it_is_forgotten() {
    let mut studio = Studio::new();
    let runs = |studio: &mut Studio, light| {
        let done = studio
            .shadow(&ours(), (light, "hpsm"), 1)
            .expect("a shadow");
        assert!(done.resources.textures.contains_key("shadow_map"));
        done.runs
    };
    assert_eq!(runs(&mut studio, 0), [Run::Recorded; 2]);
    assert_eq!(runs(&mut studio, 0), [Run::Kept; 2]);
    assert_eq!(studio.engine.drawn, 1);
    // Another light has maps of its own.
    assert_eq!(runs(&mut studio, 1), [Run::Recorded; 2]);
    assert_eq!(studio.executor.textures().count(), 4);
    // For what was recorded and not submitted.
    studio.executor.forget(0);
    assert_eq!(runs(&mut studio, 0), [Run::Recorded; 2]);
    assert_eq!(runs(&mut studio, 1), [Run::Kept; 2]);
    studio.executor.retain(|light| light == 1);
    assert_eq!(studio.executor.textures().count(), 2);
    assert_eq!(runs(&mut studio, 0), [Run::Recorded; 2]);
    studio.executor.clear();
    assert_eq!(studio.executor.textures().count(), 0);
}

/// An error names the light and what is wrong; other lights go on, and the light itself once all is well.
#[test]
fn what_goes_wrong_is_told_and_nothing_wrong_is_kept() {
    let mut studio = Studio::new();
    studio.shadow(&ours(), (1, "pcf"), 1).expect("a shadow");
    let spoilt: [(Spoil, &str); 6] = [
        (
            |plan| {
                for pass in &mut plan.passes {
                    if let umbrage_shadow::Pass::Casters(pass) = pass {
                        pass.view_proj.x_axis.x = f32::NAN;
                    }
                }
            },
            "a matrix that is not finite",
        ),
        (|plan| plan.textures.clear(), "none of its textures"),
        (
            |plan| plan.textures[0].width = 1 << 20,
            "texels, but the device allows",
        ),
        (
            |plan| plan.textures[0].height = 0,
            "texels, but the device allows",
        ),
        (
            |plan| plan.textures[0].format = wgpu::TextureFormat::R32Float,
            "is not of depth alone",
        ),
        (
            |plan| {
                for pass in &mut plan.passes {
                    if let umbrage_shadow::Pass::Casters(pass) = pass {
                        pass.casters = vec![7];
                    }
                }
            },
            "a caster that there is not",
        ),
    ];
    for (spoil, expected) in spoilt {
        let refused = studio.shadow(&self::spoilt(spoil), (0, "pcf"), 1);
        let said = refused.err().expect(expected).to_string();
        assert!(said.contains(expected), "{said}");
        let done = studio.shadow(&ours(), (0, "pcf"), 1).expect("a shadow");
        assert_eq!(done.runs, [Run::Recorded], "{expected}");
        let other = studio.shadow(&ours(), (1, "pcf"), 1).expect("a shadow");
        assert_eq!(other.runs, [Run::Kept], "{expected}");
    }
    // Fewer casters are told of than there are.
    let refused = studio.shadow(&ours(), (0, "pcf"), 0);
    let said = refused.err().expect("refused").to_string();
    assert!(said.contains("a caster that there is not"), "{said}");
    studio.engine.refuses = true;
    let refused = studio.shadow(&ours(), (0, "pcf"), 1);
    assert_eq!(
        refused.err().expect("refused").to_string(),
        "light `sun`: its casters cannot be drawn: the meshes are not there yet"
    );
    studio.engine.refuses = false;
    let done = studio.shadow(&ours(), (0, "pcf"), 1).expect("a shadow");
    assert_eq!(done.runs, [Run::Recorded]);
}

/// An engine that tells of another box and not of another revision is not believed: its map would stand for the old one.
#[test]
fn a_caster_that_moves_is_drawn_again_whatever_its_revision() {
    let mut studio = Studio::new();
    // The ground's map is the same: the box is a part of it.
    let runs = |studio: &mut Studio| {
        let done = studio.shadow(&ours(), (0, "pcf"), 1).expect("a shadow");
        done.runs
    };
    assert_eq!(runs(&mut studio), [Run::Recorded]);
    assert_eq!(runs(&mut studio), [Run::Kept]);
    studio.height = 1.999;
    assert_eq!(runs(&mut studio), [Run::Recorded]);
    assert_eq!(runs(&mut studio), [Run::Kept]);
}

/// A lost device ends nothing: wgpu tells the engine's handler of errors, and another device has another executor.
#[test]
fn a_lost_device_makes_no_panic() {
    let mut studio = Studio::new();
    studio.shadow(&ours(), (0, "hpsm"), 1).expect("a shadow");
    studio.engine.device.destroy();
    for light in 0..2 {
        let (_, refused) = studio.try_shadow(&ours(), (light, "hpsm"), 1);
        assert!(refused.is_some() || light == 0, "the device is gone");
        studio.executor.forget(light);
    }
    let mut other = Studio::new();
    other.shadow(&ours(), (0, "hpsm"), 1).expect("a shadow");
}

/// Passes run whatever the numbers of an engine's groups.
#[test]
fn groups_have_the_engines_numbers() {
    for groups in [[(0, 1), (1, 0), (3, 2)], [(0, 3), (1, 2), (3, 0)]] {
        let mut studio = Studio::with_groups(&groups);
        for (light, filter) in [(0, "hpsm"), (1, "esm")] {
            let done = studio.shadow(&ours(), (light, filter), 1);
            let runs = done.expect("a shadow").runs;
            assert!(runs.len() > 1 && runs.iter().all(|run| *run == Run::Recorded));
        }
        assert_eq!(studio.engine.drawn, 2);
    }
}
