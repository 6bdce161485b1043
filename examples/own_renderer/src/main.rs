//! Shadows in a renderer of one's own: plain wgpu, own meshes, an own surface shader, and two lights whose shadows are found
//! in different ways. `cargo run -p umbrage_example_own_renderer -- blocks.png` draws a picture.

use std::{error::Error, sync::Arc};

use umbrage::{
    compose::{Composer, Library, Package, Target},
    execute::{
        self, ColorState, DrawState, Drawn, Draws, Executor, Host, Identity, Job, Shadow, Sides,
        device::buffer,
    },
    glam::{DVec3, Mat4, Vec3},
    shadow::{Aabb, Constants, Light, LightKind, View},
    wgpu::{self, BufferUsages, CompareFunction, VertexBufferLayout, VertexStepMode},
};
use umbrage_testkit::headless::{self, Canvas};

const VERTEX: VertexBufferLayout<'_> = VertexBufferLayout {
    array_stride: 24,
    step_mode: VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
};

/// Blocks on a ground, 36 vertices each.
struct Blocks {
    vertices: wgpu::Buffer,
    instance: Constants,
}

impl Host for Blocks {
    fn draw(&mut self, casters: &[usize], draws: &mut Draws<'_, '_>) -> Drawn {
        let pipeline = draws.pipeline(&[], &[VERTEX], Sides::SOLID)?.pipeline;
        draws.set(&pipeline)?;
        let instances = vec![self.instance.clone().into()].into();
        let drawn = vec![0_u32.into()].into();
        let (program, key) = (&pipeline.program, &pipeline.program.permutation.key);
        let group = draws.binder().bind(program, 3, |binder, binding| {
            let is_drawn = binding.name == "drawn";
            binder.storage(key, binding, if is_drawn { &drawn } else { &instances })
        })?;
        draws.pass().set_bind_group(3, &group, &[]);
        draws.pass().set_vertex_buffer(0, self.vertices.slice(..));
        for first in casters.iter().map(|caster| 36 * *caster as u32) {
            draws.pass().draw(first..first + 36, 0..1);
        }
        Ok(())
    }
}

/// A box's triangles, by its corners' numbers, in whose bits are x, y and z.
const CORNERS: [usize; 36] = [
    0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5,
    7, 1, 7, 3,
];

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or("blocks.png".to_owned());
    let (device, queue) = headless::device()?;
    let (canvas, gpu) = (Canvas::new(&device, [960, 540]), (&device, &queue));
    let files = [
        ("axes.ron", include_str!("../shaders/axes.ron")),
        ("blocks.wesl", include_str!("../shaders/blocks.wesl")),
    ];
    let own = Package::from_sources("blocks", "shaders", files)?;
    let library = Library::new([umbrage::shader_package()?, own])?;
    let composer = Arc::new(Composer::new(library.clone(), Target::webgpu()));
    let parts = umbrage::methods::registry()?;

    let block = |i: i32| {
        let [x, z] = [i % 5, i / 5].map(|place| f64::from(3 * place - 6));
        let height = 0.5 + 0.8 * f64::from(7 * i % 4);
        Aabb::new([x - 0.7, 0.0, z - 0.7], [x + 0.7, height, z + 0.7])
    };
    let mut bounds = vec![Aabb::new([-40.0, -1.0, -40.0], [40.0, 0.0, 40.0])];
    bounds.extend((0..25).map(block));
    let mut vertices = Vec::new();
    for (i, aabb) in bounds.iter().enumerate() {
        let color = Vec3::new(0.4 + 0.02 * i as f32, 0.45, 0.5 - 0.01 * i as f32);
        for corner in CORNERS {
            let numbers = [aabb.corners()[corner].as_vec3(), color].map(|v| v.to_array());
            vertices.extend(numbers.concat().into_iter().flat_map(f32::to_le_bytes));
        }
    }
    let eye = DVec3::new(-8.0, 7.0, 11.0);
    let (field, depths) = ((0.8, 16.0 / 9.0), [0.1, 200.0]);
    let view = View::perspective(eye, DVec3::new(8.0, -7.0, -10.0), field, depths);
    // Vertices are the world's; positions in shaders are relative to the eye.
    let model = Mat4::from_translation(-eye.as_vec3());
    let mut blocks = Blocks {
        vertices: buffer(gpu, "blocks", BufferUsages::VERTEX, &vertices)?,
        instance: Constants::new().with("model", model).with("normal", model),
    };
    let direction = DVec3::new(0.8, -1.0, 0.35).normalize();
    let sun = LightKind::Directional { direction };
    let lamp = LightKind::Spot {
        position: DVec3::new(5.0, 8.0, 5.0),
        direction: DVec3::new(-0.55, -1.0, -0.55).normalize(),
        inner_angle: 0.4,
        outer_angle: 0.6,
        range: 30.0,
    };
    let lights = [
        (sun, Vec3::new(3.5, 3.1, 2.8), "pssm", "hpsm"),
        (lamp, Vec3::new(31.0, 63.0, 126.0), "basic", "esm"),
    ];
    let seen = Constants::new().with("view_proj", view.view_proj_relative().as_mat4());
    let seen = seen.with("eye", eye.as_vec3());
    let mut executor = Executor::new(&device, &queue, Arc::clone(&composer));
    let mut encoder = device.create_command_encoder(&Default::default());
    let (mut keys, mut lit) = (Vec::new(), Vec::new());
    for (number, (kind, color, method, filter)) in lights.into_iter().enumerate() {
        let (light, shadow) = (Light { kind, color }, Shadow::new(method));
        let shadow = shadow.with("filter", filter).check(&parts, &library)?;
        let job = Job {
            light: number as u64,
            name: light.kind.name(),
            shadow: &shadow,
            frame: &shadow.frame(&view, &light, &bounds, &bounds),
            casters: &Identity::unchanging(bounds.len()),
            choices: &[],
            constants: &light.constants(eye),
            camera_depth: None,
        };
        // Draws those of the light's maps that do not stand yet.
        lit.push(executor.shadow(&mut encoder, &job, &mut blocks)?.resources);
        keys.push(library.key(shadow.choices(&light).chain([("pass", "blocks")]))?);
    }
    // The blocks in all lights, by one shader.
    let lit: Vec<_> = lit.iter().map(Arc::as_ref).collect();
    let permutation = composer.compose_all(&keys)?.permutation;
    let state = DrawState {
        colors: vec![ColorState::new(canvas.color.format(), None)],
        depth: Some(canvas.depth.format()),
        compare: CompareFunction::GreaterEqual,
        write_depth: true,
        unfiltered: execute::unfiltered(&lit),
        ..DrawState::NOTHING
    };
    let pipeline = executor.pipeline(&permutation, state, &[VERTEX])?;
    let groups = (executor.binder()).groups(&pipeline.program, &lit, &[("view", &seen)])?;
    let mut pass = canvas.begin(&mut encoder, true);
    pass.set_pipeline(&pipeline.pipeline);
    groups.set(&mut pass);
    pass.set_vertex_buffer(0, blocks.vertices.slice(..));
    pass.draw(0..36 * bounds.len() as u32, 0..1);
    drop(pass);
    queue.submit([encoder.finish()]);
    canvas.read(&device, &queue)?.save(&path)?;
    Ok(())
}
