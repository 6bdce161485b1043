//! Maps of casters that move: what is drawn of them in part is, to the last bit, what drawing them as a whole gives.

use std::{f64::consts::TAU, sync::Arc};

use glam::{DAffine3, DMat4, DQuat, DVec3, Mat4, Vec3};
use umbrage_compose::{Composer, Library, Target};
use umbrage_shadow::{Aabb, Constants, Light, LightKind, Registry, View};
use umbrage_testkit::headless;
use umbrage_wgpu::{
    Drawn, Draws, Executor, Host, Identity, Job, Run, Shadow, Sides, device::buffer,
};

/// Blocks: all of one mesh, which is closed.
struct Blocks {
    vertices: wgpu::Buffer,
    /// Where they stand, relative to the camera.
    places: Vec<Mat4>,
    /// One that is not drawn.
    lies: Option<usize>,
}

const VERTEX: wgpu::VertexBufferLayout<'_> = wgpu::VertexBufferLayout {
    array_stride: 12,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3],
};

/// A cube's triangles, counter-clockwise from outside, by the corners' numbers, in whose bits are x, y and z.
const CORNERS: [usize; 36] = [
    0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5,
    7, 4, 7, 6,
];

impl Host for Blocks {
    fn draw(&mut self, casters: &[usize], draws: &mut Draws<'_, '_>) -> Drawn {
        let pipeline = draws.pipeline(&[], &[VERTEX], Sides::SOLID)?.pipeline;
        draws.set(&pipeline)?;
        let one = |place: &Mat4| {
            Constants::new()
                .with("model", *place)
                .with("normal", *place)
        };
        let instances: Vec<_> = self.places.iter().map(|place| one(place).into()).collect();
        let drawn: Vec<_> = (0..self.places.len() as u32).map(Into::into).collect();
        let (instances, drawn) = (instances.into(), drawn.into());
        let (program, key) = (&pipeline.program, &pipeline.program.permutation.key);
        let group = draws.binder().bind(program, 3, |binder, binding| {
            let is_drawn = binding.name == "drawn";
            binder.storage(key, binding, if is_drawn { &drawn } else { &instances })
        })?;
        draws.pass().set_bind_group(3, &group, &[]);
        draws.pass().set_vertex_buffer(0, self.vertices.slice(..));
        for caster in casters.iter().filter(|caster| self.lies != Some(**caster)) {
            let caster = *caster as u32;
            draws.pass().draw(0..36, caster..caster + 1);
        }
        Ok(())
    }
}

/// Numbers that look drawn by lot, the same ones each time (Steele, Lea, Flood 2014, "Fast splittable pseudorandom number
/// generators").
struct Lots(u64);

impl Lots {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, [least, most]: [f64; 2]) -> f64 {
        least + (most - least) * self.next()
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }

    /// A block somewhere before the camera, or behind it.
    fn block(&mut self) -> DAffine3 {
        let at = DVec3::new(
            self.between([-12.0, 12.0]),
            self.between([0.0, 4.0]),
            self.between([-30.0, 6.0]),
        );
        let turn = DQuat::from_rotation_y(self.between([0.0, TAU]))
            * DQuat::from_rotation_x(self.between([0.0, TAU]));
        let size = DVec3::new(
            self.between([0.1, 2.0]),
            self.between([0.1, 2.0]),
            self.between([0.1, 2.0]),
        );
        DAffine3::from_scale_rotation_translation(size, turn, at)
    }
}

/// The box around a cube from −½ to ½ that is placed so.
fn bounds(place: &DAffine3) -> Aabb {
    let corners = (0..8).map(|i| place.transform_point3(corner(i)));
    Aabb::from_points(corners).expect("corners")
}

fn corner(i: usize) -> DVec3 {
    DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) - 0.5
}

struct Stage {
    device: wgpu::Device,
    queue: wgpu::Queue,
    library: Library,
    executor: Executor,
    parts: Registry,
    blocks: Blocks,
}

/// A frame's casters and camera.
struct Set {
    places: Vec<(DAffine3, Identity)>,
    eye: DVec3,
}

impl Stage {
    fn new() -> Self {
        let (device, queue) = headless::device().expect("a device");
        let package = umbrage_shader_lib::package().expect("the shader library");
        let library = Library::new([package]).expect("the library");
        let composer = Arc::new(Composer::new(library.clone(), Target::webgpu()));
        let corners = CORNERS.map(|i| corner(i).as_vec3().to_array()).concat();
        let bytes: Vec<_> = corners.into_iter().flat_map(f32::to_le_bytes).collect();
        let usage = wgpu::BufferUsages::VERTEX;
        let vertices = buffer((&device, &queue), "a cube", usage, &bytes).expect("small");
        Self {
            executor: Executor::new(&device, &queue, composer),
            device,
            queue,
            library,
            parts: umbrage_methods::registry().expect("names are unique"),
            blocks: Blocks {
                vertices,
                places: Vec::new(),
                lies: None,
            },
        }
    }

    /// Outcome of the light's passes, and which of its textures differ from what drawing them as a whole gives.
    fn audit(&mut self, shadow: &Shadow, kind: &LightKind, set: &Set) -> (Vec<Run>, Vec<String>) {
        let light = Light {
            kind: kind.clone(),
            color: Vec3::ONE,
        };
        let view = View::perspective(
            set.eye,
            DVec3::new(0.1, -0.2, -1.0),
            (1.0, 1.5),
            [0.1, 60.0],
        );
        let shadow = shadow.check(&self.parts, &self.library).expect("parts");
        let boxes: Vec<_> = set.places.iter().map(|(place, _)| bounds(place)).collect();
        let ground = [Aabb::new([-40.0, -1.0, -60.0], [40.0, 0.0, 20.0])];
        let identities: Vec<_> = set.places.iter().map(|(_, identity)| *identity).collect();
        let place = |(place, _): &(DAffine3, Identity)| {
            (DMat4::from_translation(-set.eye) * *place).as_mat4()
        };
        self.blocks.places = set.places.iter().map(place).collect();
        let constants = light.constants(set.eye);
        let job = Job {
            light: 0,
            name: "light",
            shadow: &shadow,
            frame: &shadow.frame(&view, &light, &boxes, &ground),
            casters: &identities,
            choices: &[],
            constants: &constants,
            camera_depth: None,
        };
        self.executor.begin_frame();
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let audited = self.executor.audit(&mut encoder, &job, &mut self.blocks);
        let (executed, audit) = audited.expect("a shadow");
        self.queue.submit([encoder.finish()]);
        for buffer in audit.buffers() {
            buffer.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("maps"));
        }
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        waited.expect("the device works");
        let bytes = |buffer: &wgpu::Buffer| {
            let mapped = buffer.get_mapped_range(..).expect("it is mapped");
            mapped.to_vec()
        };
        let differing = audit.differing(bytes);
        (
            executed.runs,
            differing.into_iter().map(str::to_owned).collect(),
        )
    }
}

const BLOCKS: usize = 24;

/// Motions for each of the kinds of shadow below: 10,000 in all.
const MOTIONS: usize = 2_000;

fn start(lots: &mut Lots) -> Set {
    let identity = |id| Identity { id, revision: 0 };
    let places = (0..BLOCKS as u64).map(|id| (lots.block(), identity(id)));
    Set {
        places: places.collect(),
        eye: DVec3::new(0.0, 3.0, 8.0),
    }
}

/// Moves blocks, and sees that parts of maps are often enough.
fn check(shadow: Shadow, kind: LightKind, seed: u64) {
    let (mut stage, mut lots) = (Stage::new(), Lots(seed));
    let mut set = start(&mut lots);
    let mut next = BLOCKS as u64;
    let mut repaired = 0;
    for motion in 0..MOTIONS {
        for _ in 0..1 + lots.below(3) {
            let which = lots.below(set.places.len());
            match lots.below(8) {
                // One goes, and another comes.
                0 => {
                    set.places.remove(which);
                    next += 1;
                    let identity = Identity {
                        id: next,
                        revision: 0,
                    };
                    set.places.push((lots.block(), identity));
                }
                1 => {
                    set.places[which].0 = lots.block();
                    set.places[which].1.revision += 1;
                }
                _ => {
                    let [x, y, z] = [0; 3].map(|_| lots.between([-0.3, 0.3]));
                    set.places[which].0.translation += DVec3::new(x, y, z);
                    set.places[which].1.revision += 1;
                }
            }
        }
        if lots.below(50) == 0 {
            set.eye.x += lots.between([-0.2, 0.2]);
        }
        let (runs, differing) = stage.audit(&shadow, &kind, &set);
        assert!(differing.is_empty(), "motion {motion}: {differing:?}");
        repaired += usize::from(runs.contains(&Run::Repaired));
    }
    assert!(repaired > MOTIONS / 4, "only {repaired} were repaired");
}

fn sun() -> LightKind {
    LightKind::Directional {
        direction: DVec3::new(0.5, -1.0, -0.3).normalize(),
    }
}

fn small(method: &str) -> Shadow {
    Shadow::new(method).with_setting("resolution", 128.0)
}

#[test]
fn maps_of_splits() {
    check(small("pssm"), sun(), 1);
}

#[test]
fn two_sides() {
    let shadow = small("pssm").with("depth", "midpoint");
    check(shadow, sun(), 2);
}

#[test]
fn a_map_of_a_cone() {
    let cone = LightKind::Spot {
        position: DVec3::new(2.0, 9.0, 2.0),
        direction: DVec3::new(-0.2, -1.0, -0.9).normalize(),
        inner_angle: 0.7,
        outer_angle: 0.9,
        range: 40.0,
    };
    check(small("basic"), cone, 3);
}

#[test]
fn faces_of_a_cube() {
    let lamp = LightKind::Point {
        position: DVec3::new(1.0, 3.5, -9.0),
        range: 30.0,
    };
    check(small("basic"), lamp, 4);
}

#[test]
fn filtered_maps() {
    // A filter's work on a map is done anew where the map changes.
    check(small("basic").with("filter", "esm"), sun(), 5);
}

#[test]
fn a_caster_that_lies_is_found() {
    let (mut stage, mut lots) = (Stage::new(), Lots(6));
    let mut set = start(&mut lots);
    set.places[0].0.translation = DVec3::new(0.0, 2.0, -4.0);
    let audit = |stage: &mut Stage, set: &Set| stage.audit(&small("pssm"), &sun(), set).1;
    audit(&mut stage, &set);
    assert!(audit(&mut stage, &set).is_empty());
    // It is not drawn any more, and says nothing of it.
    stage.blocks.lies = Some(0);
    assert_eq!(audit(&mut stage, &set), ["shadow_map"]);
    set.places[0].1.revision += 1;
    assert!(audit(&mut stage, &set).is_empty(), "a new revision tells");
}
