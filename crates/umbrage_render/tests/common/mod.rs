//! Helpers that the tests of whole pictures share.
#![allow(dead_code, reason = "each test program uses its own part")]

pub(crate) mod air;
pub(crate) mod probe;

use std::{path::PathBuf, sync::Arc};

use glam::DVec3;
use umbrage_compose::{Composer, Library, Target};
use umbrage_render::{Gpu, Picture, RenderOptions, Rendered, Renderer, Scene, What};
use umbrage_shadow::Registry;

/// A renderer of its own device and caches.
pub(crate) fn renderer(registry: Registry) -> Renderer {
    let package = umbrage_shader_lib::package().expect("the shader library");
    let library = Library::new([package]).expect("the library");
    let composer = Arc::new(Composer::new(library, Target::default()));
    Renderer::new(
        Arc::new(Gpu::new().expect("an adapter")),
        composer,
        registry,
    )
}

/// The methods that come with the project.
pub(crate) fn methods() -> Registry {
    umbrage_methods::registry().expect("names are unique")
}

/// An example scene.
pub(crate) fn example(name: &str) -> Scene {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    Scene::load(folder.join(name)).expect("a sound scene")
}

/// The scene that `text` describes.
pub(crate) fn scene(text: &str) -> Scene {
    let dir = tempfile::TempDir::new().expect("a folder");
    let path = dir.path().join("scene.ron");
    std::fs::write(&path, text).expect("written");
    Scene::load(path).expect("a sound scene")
}

/// Options for a small picture.
pub(crate) fn small(what: What) -> RenderOptions {
    RenderOptions {
        width: 160,
        height: 120,
        what,
        // Costs are those of a picture by itself.
        fresh: true,
        ..RenderOptions::default()
    }
}

/// The pixel's number at which a point in the world is seen.
pub(crate) fn pixel(scene: &Scene, rendered: &Rendered, point: DVec3) -> usize {
    let (width, height) = (rendered.width, rendered.height);
    let view = scene.view(width, height);
    let clip = view.view_proj_relative() * (point - view.position).extend(1.0);
    let x = (0.5 + 0.5 * clip.x / clip.w) * f64::from(width);
    let y = (0.5 - 0.5 * clip.y / clip.w) * f64::from(height);
    assert!(
        (0.0..width.into()).contains(&x) && (0.0..height.into()).contains(&y),
        "unseen"
    );
    y as usize * width as usize + x as usize
}

/// The shadow term of the first light at a point in the world.
pub(crate) fn term(scene: &Scene, rendered: &Rendered, point: DVec3) -> f32 {
    let Picture::ShadowTerm(lights) = &rendered.picture else {
        unreachable!("a shadow term was asked for")
    };
    lights[0][pixel(scene, rendered, point)]
}

/// The linear colour at a point in the world.
pub(crate) fn color(scene: &Scene, rendered: &Rendered, point: DVec3) -> [f32; 3] {
    let Picture::Shaded(pixels) = &rendered.picture else {
        unreachable!("a shaded picture was asked for")
    };
    pixels[pixel(scene, rendered, point)]
}
