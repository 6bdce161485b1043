//! The hard cases through the renderer: whatever else a method gets wrong, no pixel is bad.

use std::sync::Arc;

use umbrage_compose::{Composer, Library, Target};
use umbrage_measure::cases;
use umbrage_render::{Gpu, Picture, Renderer, Scene, What};

#[test]
fn basic_has_no_bad_pixel_in_any_frame_of_any_case() {
    let package = umbrage_shader_lib::package().expect("the shader library");
    let library = Library::new([package]).expect("the library");
    let composer = Arc::new(Composer::new(library, Target::default()));
    let methods = umbrage_methods::registry().expect("names are unique");
    let basic = Arc::clone(methods.get("basic").expect("the method"));
    let mut renderer = Renderer::new(Arc::new(Gpu::new().expect("an adapter")), composer, methods);
    let mut frames = 0;
    for case in cases::all() {
        let options = case.options(basic.as_ref(), What::ShadowTerm);
        for camera in case.cameras() {
            let scene = Scene {
                camera: *camera,
                ..case.scene.clone()
            };
            let rendered = renderer.render(&scene, &options).expect("renders");
            let Picture::ShadowTerm(lights) = rendered.picture else {
                unreachable!("a shadow term was asked for")
            };
            assert_eq!(lights.len(), case.scene.lights.len());
            let bad = lights
                .iter()
                .flatten()
                .filter(|term| !(0.0..=1.0).contains(*term));
            assert_eq!(bad.count(), 0, "{}", case.name);
            frames += 1;
        }
    }
    assert!(frames > 2 * 64);
}
