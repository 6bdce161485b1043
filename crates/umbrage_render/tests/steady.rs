//! Frames of a steady loop: drawn into an engine's texture, with no more draws than there are kinds of objects.

use std::sync::Arc;

use glam::DVec3;
use umbrage_compose::{Composer, Library, Target};
use umbrage_render::{Gpu, Picture, RenderError, RenderOptions, Rendered, Renderer, Scene, What};
use umbrage_testkit::headless;

/// An engine with a device of its own.
struct Engine {
    device: wgpu::Device,
    queue: wgpu::Queue,
    gpu: Arc<Gpu>,
    renderer: Renderer,
}

const SIZE: [u32; 2] = [64, 48];

fn options() -> RenderOptions {
    RenderOptions {
        width: SIZE[0],
        height: SIZE[1],
        ..RenderOptions::default()
    }
}

impl Engine {
    fn new() -> Self {
        let (device, queue) = headless::device().expect("a device");
        let gpu = Gpu::from_wgpu(device.clone(), queue.clone(), "the engine's");
        let package = umbrage_shader_lib::package().expect("the shader library");
        let library = Library::new([package]).expect("the library");
        let composer = Arc::new(Composer::new(library, Target::webgpu()));
        let methods = umbrage_methods::registry().expect("names are unique");
        let gpu = Arc::new(gpu);
        Self {
            renderer: Renderer::new(Arc::clone(&gpu), composer, methods),
            device,
            queue,
            gpu,
        }
    }

    fn texture(&self, [width, height]: [u32; 2], samples: u32) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("the engine's picture"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// The texture's pixels, red, green and blue.
    fn read(&self, texture: &wgpu::Texture) -> Vec<[f32; 3]> {
        let row = (8 * texture.width()).next_multiple_of(256);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * texture.height()),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            texture.size(),
        );
        self.queue.submit([encoder.finish()]);
        buffer.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("maps"));
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        waited.expect("the device works");
        let mapped = buffer.get_mapped_range(..).expect("it is mapped");
        let half = |bytes: &[u8]| half::f16::from_le_bytes([bytes[0], bytes[1]]).to_f32();
        let rows = mapped.chunks_exact(row as usize);
        let pixels = rows.flat_map(|row| row[..8 * texture.width() as usize].chunks_exact(8));
        pixels
            .map(|p| [half(p), half(&p[2..]), half(&p[4..])])
            .collect()
    }

    fn picture(&mut self, scene: &Scene) -> Vec<[f32; 3]> {
        shaded(self.renderer.render(scene, &options()).expect("renders"))
    }
}

fn shaded(rendered: Rendered) -> Vec<[f32; 3]> {
    match rendered.picture {
        Picture::Shaded(pixels) => pixels,
        _ => unreachable!("a shaded picture was asked for"),
    }
}

fn scene(name: &str) -> Scene {
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    Scene::load(scenes.join(name)).expect("a sound scene")
}

/// Each frame of a loop is the picture that is rendered by itself, whatever the frames before it left.
#[test]
fn frames_are_pictures() {
    let (mut engine, mut alone) = (Engine::new(), Engine::new());
    let texture = engine.texture(SIZE, 1);
    let view = texture.create_view(&Default::default());
    for name in ["bunny_sun.ron", "leaves.ron", "shafts.ron"] {
        let mut scene = scene(name);
        for frame in 0..6 {
            // The camera stands, moves, and comes back; an object moves, and one goes.
            scene.camera.position.x += [0.0, 0.3, 0.0, -0.3, 0.0, 0.0][frame];
            if frame == 4 {
                let object = &mut scene.objects[0];
                object.transform.translation += DVec3::Y * 0.125;
                object.bounds = object.bounds.translate(DVec3::Y * 0.125);
            }
            if frame == 5 {
                scene.objects.pop();
            }
            let report = engine.renderer.draw(&scene, &options(), &view);
            let report = report.expect("draws");
            assert!(report.draws > 0, "{name}, frame {frame}");
            let drawn = engine.read(&texture);
            assert_eq!(drawn, alone.picture(&scene), "{name}, frame {frame}");
            assert_eq!(
                drawn,
                engine.picture(&scene),
                "{name}, frame {frame}, again"
            );
        }
    }
    assert_eq!(engine.gpu.adapter(), "the engine's");
}

#[test]
fn textures_that_do_not_fit_are_named() {
    let mut engine = Engine::new();
    let scene = scene("bunny_sun.ron");
    let try_draw = |engine: &mut Engine, size, samples, what| {
        let view = engine
            .texture(size, samples)
            .create_view(&Default::default());
        let options = RenderOptions { what, ..options() };
        engine.renderer.draw(&scene, &options, &view)
    };
    for (size, samples, what) in [
        ([64, 47], 1, What::Shaded),
        (SIZE, 4, What::Shaded),
        (SIZE, 1, What::ShadowTerm),
    ] {
        let refused = try_draw(&mut engine, size, samples, what);
        let refused = refused.expect_err("it does not fit");
        assert!(matches!(refused, RenderError::Target { .. }), "{refused}");
        let told = refused.to_string();
        assert!(told.contains("64 by 48"), "{told}");
    }
    assert!(try_draw(&mut engine, SIZE, 1, What::Shaded).is_ok());
}

/// Objects that share a mesh and a material are one draw a pass, wherever they stand in the scene, and whichever are seen.
#[test]
fn draws_do_not_depend_on_the_order_of_objects() {
    let mut engine = Engine::new();
    let mut scene = scene("avenue.ron");
    let [trunk, crown] = [6, 7].map(|i| scene.objects[i].clone());
    for i in 0..20 {
        let by = DVec3::new(0.3 * f64::from(i % 5), 0.0, -2.0 * f64::from(i));
        for model in [&trunk, &crown] {
            let mut object = model.clone();
            object.transform.translation += by;
            object.bounds = object.bounds.translate(by);
            scene.objects.push(object);
        }
    }
    scene.objects.sort_by_key(|object| object.name.clone());
    let counts = |engine: &mut Engine, scene: &Scene| {
        let options = RenderOptions {
            fresh: true,
            ..options()
        };
        let rendered = engine.renderer.render(scene, &options).expect("renders");
        (rendered.report.draws, shaded(rendered))
    };
    let (draws, picture) = counts(&mut engine, &scene);
    // Neighbours are of different kinds now, as far as they can be.
    let all = scene.objects.len();
    scene.objects = (0..all)
        .map(|i| scene.objects[i * 37 % all].clone())
        .collect();
    let (shuffled, same) = counts(&mut engine, &scene);
    assert!(!all.is_multiple_of(37), "each object once");
    assert_eq!(draws, shuffled);
    assert_eq!(picture, same);
    // One more of a kind makes no more draws.
    let mut more = trunk.clone();
    more.transform.translation.x += 0.1;
    scene.objects.push(more);
    assert_eq!(counts(&mut engine, &scene).0, draws);
}
