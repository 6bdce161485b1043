//! What the study puts together itself, against what it must come to.

use std::{collections::BTreeMap, path::Path, sync::Arc};

use umbrage_compose::{Composer, Library, RonFile, Target};
use umbrage_render::{Gpu, RenderOptions, Scene};

use super::{
    Config, Lab,
    lab::{pixels, terms},
    motion::cameras,
    timing::baseline,
};
use crate::{report::Spread, truth::Truth};

const SIZE: (u32, u32) = (160, 90);

fn lab() -> Lab {
    let package = umbrage_shader_lib::package().expect("the shader library");
    let library = Library::new([package]).expect("the library");
    let composer = Arc::new(Composer::new(library, Target::default()));
    let methods = umbrage_methods::registry().expect("names are unique");
    Lab::new(Arc::new(Gpu::new().expect("an adapter")), composer, methods)
}

fn example(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    Scene::load(folder.join(name)).expect("a sound scene")
}

/// With a method's own shadows in the truth's place, the picture that FLIP compares with must be the
/// picture that the renderer shades: they are put together in different places.
#[test]
fn lights_and_shadow_terms_add_up_to_the_shaded_picture() {
    let mut lab = lab();
    for name in ["bunny_sun.ron", "suzanne_spot.ron", "room_point.ron"] {
        let scene = example(name);
        let mut truth = Truth::trace(&scene, SIZE, &[], &|| ()).expect("traced");
        let options = RenderOptions {
            width: SIZE.0,
            height: SIZE.1,
            method: Some("basic".to_owned()),
            ..RenderOptions::default()
        };
        let subject = lab.subject(&scene, &truth).expect("drawn");
        let rendered = lab.terms(&subject, &options).expect("drawn");
        let shaded = lab.shaded(&subject, &options).expect("drawn");
        let unshadowed = lab.unshadowed(&subject).expect("drawn");
        let own = terms(&rendered).iter();
        truth.terms = own.map(|t| t.iter().copied().map(Some).collect()).collect();
        let subject = lab.subject(&scene, &truth).expect("drawn");
        let added = subject.shaded_truth(&unshadowed);
        let drawn = pixels(&shaded.picture);
        assert_eq!(added.len(), drawn.len());
        for (pixel, (added, drawn)) in added.iter().zip(drawn).enumerate() {
            for (added, drawn) in added.iter().zip(drawn) {
                // The renderer adds up half floats, and each of the pictures is rounded to one.
                let off = (added - drawn).abs() / added.max(0.01);
                assert!(off < 4.0 / 1024.0, "{name}, pixel {pixel}: {added} {drawn}");
            }
        }
        // And FLIP sees no more than that rounding.
        let flip = subject.flip(&unshadowed, &shaded).expect("of one size");
        assert!(flip < 0.01, "{name}: {flip}");
    }
}

#[test]
fn a_motion_goes_aside_and_then_turns_by_less_than_a_pixel() {
    let scene = example("bunny_sun.ron");
    let truth = Truth::trace(&scene, SIZE, &[], &|| ()).expect("traced");
    let found = cameras(&scene, &truth.sight, SIZE.1, 9);
    assert_eq!(found.len(), 9);
    assert_eq!(found[0].position, scene.camera.position);
    let pixel = 2.0 * (0.5 * scene.camera.fov_y).tan() / f64::from(SIZE.1);
    let mut kinds = Vec::new();
    for pair in found.windows(2) {
        let moved = pair[0].position.distance(pair[1].position);
        let turned = pair[0].rotation.angle_between(pair[1].rotation);
        assert!(
            (moved > 0.0) != (turned > 1e-9),
            "one of the two: {moved} {turned}"
        );
        assert!(turned < pixel && moved < pixel * scene.camera.far);
        kinds.push(moved > 0.0);
    }
    assert_eq!(kinds, [true, true, true, true, true, false, false, false]);
}

#[test]
fn what_is_standard_is_known_and_holds_the_baseline() {
    let lab = lab();
    let text = include_str!("../../configs.ron");
    let file = RonFile::new("configs.ron", text);
    let configs = Config::read(&file, lab.registry(), lab.library()).expect("sound");
    let standard = Config::standard(&["basic".to_owned()], lab.registry(), lab.library());
    let standard = standard.expect("sound");
    assert!(standard.len() > 5 && standard.iter().all(|config| configs.contains(config)));
    let plainest = BTreeMap::from([("pcf".to_owned(), "1".to_owned())]);
    assert_eq!(
        (baseline().method.as_str(), baseline().axes),
        ("basic", plainest)
    );
    assert!(Config::standard(&["none".to_owned()], lab.registry(), lab.library()).is_err());
}

#[test]
fn a_spread_has_its_middle() {
    let spread = |values: &[f64]| {
        let Spread { min, median, max } = Spread::of(values);
        [min, median, max]
    };
    assert_eq!(spread(&[3.0, 1.0, 2.0]), [1.0, 2.0, 3.0]);
    assert_eq!(spread(&[4.0, 1.0, 2.0, 3.0]), [1.0, 2.5, 4.0]);
    assert!(spread(&[]).iter().all(|value| value.is_nan()));
}
