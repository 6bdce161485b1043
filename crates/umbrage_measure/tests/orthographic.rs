//! An orthographic camera: the truth against closed forms, and every way to draw it against the truth.

mod common;

use glam::{DVec2, DVec3};
use umbrage_measure::truth::{Source, Tracer, Truth};
use umbrage_render::{Path, Picture, RenderOptions, Renderer, Scene, Shadow, What};
use umbrage_shadow::Field;

use common::renderer;

const SIZE: (u32, u32) = (320, 240);

/// Posts, a ball and a board on a ground, with more lights than one; what `camera` and `lights` say.
fn scene(camera: &str, lights: &str) -> Scene {
    load(&format!(
        r#"(
        camera: ({camera}),
        lights: [{lights}],
        models: [
            (shape: plane(size: (30, 30))),
            (shape: box(size: (0.4, 2.2, 0.4)), translation: (-1.6, 1.1, 0.3)),
            (shape: box(size: (0.4, 1.4, 0.4)), translation: (1.9, 0.7, -1.7)),
            (shape: box(size: (2, 0.1, 1.2)), translation: (0.4, 1.2, 1.1), rotation: degrees(20, 30, 0)),
            (shape: sphere(radius: 0.7, segments: 96), translation: (0.2, 0.7, -0.6)),
        ])"#
    ))
}

fn load(text: &str) -> Scene {
    let dir = tempfile::TempDir::new().expect("a folder");
    let path = dir.path().join("scene.ron");
    std::fs::write(&path, text).expect("written");
    Scene::load(path).expect("a sound scene")
}

const ASLANT: &str = "position: (6, 7, 8), target: (0, 0.5, 0), orthographic_height: 7, far: 60";
const SUN: &str = r#"(kind: directional(direction: (0.5, -1, -0.35)), color: (3, 3, 3), shadow: (method: "basic"))"#;
const SPOT: &str = r#"(kind: spot(position: (-3, 4.5, 2), target: (0.2, 0, 0), outer_degrees: 45, range: 30), color: (90, 90, 90), shadow: (method: "basic"))"#;
const LAMP: &str = r#"(kind: point(position: (1.2, 3, 0.4), range: 20), color: (30, 30, 30), shadow: (method: "basic"))"#;

fn draw(renderer: &mut Renderer, scene: &Scene, options: RenderOptions) -> Picture {
    let options = RenderOptions {
        width: SIZE.0,
        height: SIZE.1,
        ..options
    };
    renderer.render(scene, &options).expect("renders").picture
}

fn term(renderer: &mut Renderer, scene: &Scene, options: RenderOptions) -> Vec<f32> {
    let what = What::ShadowTerm;
    match draw(renderer, scene, RenderOptions { what, ..options }) {
        Picture::ShadowTerm(mut lights) => lights.remove(0),
        _ => unreachable!("a shadow term was asked for"),
    }
}

/// The share of the pixels that are on another side than in truth, and how many there are.
fn wrong(truth: &Truth, terms: &[f32]) -> (f64, usize) {
    let known = truth.terms[0].iter().zip(terms);
    let sides = known.filter_map(|(truth, term)| Some((truth.as_ref()? >= &0.5, *term >= 0.5)));
    let (mut all, mut wrong) = (0, 0);
    for (truth, term) in sides {
        all += 1;
        wrong += usize::from(truth != term);
    }
    (wrong as f64 / all as f64, all)
}

/// Seen from straight above, the shadow of a box is a polygon: the convex hull of its foot and of its top as the light
/// projects it.
#[test]
fn the_shadow_of_a_box_seen_from_above_is_a_polygon() {
    let scene = load(
        r#"(
        camera: (position: (0.3, 50, -0.2), target: (0.3, 0, -0.2), orthographic_height: 6),
        lights: [(kind: directional(direction: (0.5, -1, 0.25)))],
        models: [(shape: plane(size: (40, 40))), (shape: box(size: (1, 2, 0.6)), translation: (-0.5, 1, 0))])"#,
    );
    let tracer = Tracer::new(&scene).expect("a sound scene");
    let sight = tracer.look(SIZE.0, SIZE.1, &|| ()).expect("a size");
    let found = tracer
        .shadow(&sight, 0, Source::Sharp, &|| ())
        .expect("a light");
    let mut counts = [0; 3];
    for (pixel, (seen, found)) in (0..).zip(sight.seen().iter().zip(found)) {
        // Rows of the picture go down as z grows: the camera's up is -z where it looks straight down.
        let at = DVec2::new(f64::from(pixel % SIZE.0), f64::from(pixel / SIZE.0)) + 0.5;
        let at = (at - DVec2::new(f64::from(SIZE.0), f64::from(SIZE.1)) * 0.5)
            * (6.0 / f64::from(SIZE.1))
            + DVec2::new(0.3, -0.2);
        let seen = seen.expect("the ground is everywhere");
        let point = seen.position + scene.camera.position;
        assert!(point.x.max(at.x) - point.x.min(at.x) < 1e-9 && (point.z - at.y).abs() < 1e-9);
        let within = |at: DVec2| {
            (at + DVec2::X * 0.5)
                .abs()
                .cmple(DVec2::new(0.5, 0.3))
                .all()
        };
        let on_box = within(at);
        assert_eq!(seen.object, u32::from(on_box), "{at}");
        // Some height below 2 m from which light comes to `at` through the box.
        let offset = |height: f64| at - height * DVec2::new(0.5, 0.25);
        let dark = !on_box && (1..=20_000).any(|step| within(offset(1e-4 * f64::from(step))));
        let near_edge = (0..8).any(|turn| {
            let by = DVec2::from_angle(f64::from(turn)) * 2e-3;
            let near = at + by - 0.0;
            let dark_there = (0..=2000)
                .any(|step| within(near - 1e-3 * f64::from(step) * DVec2::new(0.5, 0.25)));
            dark_there != (dark || on_box)
        });
        if !near_edge {
            assert_eq!(found, Some(if dark { 0.0 } else { 1.0 }), "{at}");
            counts[usize::from(dark)] += 1;
        }
        counts[2] += 1;
    }
    assert!(counts[0] > 50_000 && counts[1] > 1_000, "{counts:?}");
}

#[test]
fn what_is_drawn_is_near_to_the_truth() {
    let mut renderer = renderer();
    for (light, methods) in [(SUN, 3), (SPOT, 3), (LAMP, 1)] {
        let scene = scene(ASLANT, light);
        let truth = Truth::trace(&scene, SIZE, &[], &|| ()).expect("a sound scene");
        for (method, fit) in [("basic", "stable"), ("pssm", "stable"), ("pssm", "tight")]
            .into_iter()
            .take(methods)
        {
            for path in [Path::Forward, Path::Mask, Path::MaskBySplit] {
                let mut options = RenderOptions {
                    shadow: Shadow::new(method),
                    path,
                    ..RenderOptions::default()
                };
                if method == "pssm" {
                    options.shadow.axes.insert("fit".to_owned(), fit.to_owned());
                }
                let terms = term(&mut renderer, &scene, options);
                let (share, all) = wrong(&truth, &terms);
                // 1,500 pixels of edge in 76,800, a third of them displaced by a pixel.
                assert!(
                    share < 0.007 && all > 50_000,
                    "{method} {fit} {path:?}: {share} of {all}"
                );
            }
        }
    }
}

/// The picture of an orthographic camera does not depend on where along its axis it stands: behind all objects, a
/// thousand kilometres away, or among them.
#[test]
fn the_place_along_the_axis_does_not_matter() {
    let mut renderer = renderer();
    let near = scene(ASLANT, &[SUN, SPOT, LAMP].join(", "));
    for method in ["basic", "pssm"] {
        let options = |what| RenderOptions {
            what,
            shadow: Shadow::default().with("range", "depths"),
            ..RenderOptions::default()
        };
        let with = |scene: &Scene, by: f64| {
            let mut scene = scene.clone();
            scene.lights.truncate(2);
            for light in &mut scene.lights {
                if let Some(shadow) = &mut light.shadow {
                    shadow.method = method.to_owned();
                }
            }
            let forward = scene.camera.rotation * DVec3::NEG_Z;
            scene.camera.position -= by * forward;
            scene.camera.near += by;
            scene.camera.far += by;
            scene
        };
        let own = draw(&mut renderer, &with(&near, 0.0), options(What::Shaded));
        let Picture::Shaded(own) = own else {
            unreachable!("a shaded picture was asked for")
        };
        for by in [-20.0, 1e3, 1e6] {
            let moved = draw(&mut renderer, &with(&near, by), options(What::Shaded));
            let Picture::Shaded(moved) = moved else {
                unreachable!("a shaded picture was asked for")
            };
            let apart = |a: &[f32; 3], b: &[f32; 3]| (0..3).any(|i| (a[i] - b[i]).abs() > 0.01);
            let differ = own.iter().zip(&moved).filter(|(a, b)| apart(a, b)).count();
            // Pixels whose middle lies on an edge, within the digits that 1e6 m leave.
            assert!(differ < 40, "{method}, {by} m: {differ} pixels differ");
        }
    }
}

/// A perspective from far away and narrow sees the same, highlights included.
#[test]
fn a_perspective_from_far_away_tends_to_the_same_picture() {
    let mut renderer = renderer();
    let mut orthographic = scene(ASLANT, SUN);
    for object in &mut orthographic.objects {
        let mut material = (*object.material).clone();
        material.surface = "ggx".to_owned();
        material.roughness = 0.3;
        object.material = material.into();
    }
    let away = 2e3;
    let mut far = orthographic.clone();
    far.camera.position -= away * (far.camera.rotation * DVec3::NEG_Z);
    far.camera.near += away;
    far.camera.far += away;
    // Of that height where the first camera looks at.
    let distance = away + DVec3::new(6.0, 6.5, 8.0).length();
    far.camera.field = Field::Perspective {
        fov_y: 2.0 * (3.5 / distance).atan(),
    };
    let mut shaded = |scene: &Scene| match draw(&mut renderer, scene, RenderOptions::default()) {
        Picture::Shaded(pixels) => pixels,
        _ => unreachable!("a shaded picture was asked for"),
    };
    let (a, b) = (shaded(&orthographic), shaded(&far));
    let off = |a: &[f32; 3], b: &[f32; 3]| f64::from((a[0] - b[0]).abs());
    let mean = a.iter().zip(&b).map(|(a, b)| off(a, b)).sum::<f64>() / a.len() as f64;
    // Edges: 1,500 pixels of 76,800, a tenth of a pixel off at the most, by a brightness of 1.
    assert!(mean < 0.002, "{mean}");
}

/// The term of a light that casts no shadow is 1 in pictures and in truth, whatever the method, alone or among others.
#[test]
fn lights_without_shadows_count_alike_in_pictures_and_in_truth() {
    let mut renderer = renderer();
    let fill = r#"(kind: point(position: (-2, 3, 3), range: 30), color: (20, 20, 20))"#;
    let none = r#"(kind: point(position: (2, 3, 3), range: 30), color: (20, 20, 20), shadow: (method: "none"))"#;
    let mixed = scene(ASLANT, &[fill, SUN, none].join(", "));
    assert_eq!(
        mixed
            .lights
            .iter()
            .map(|light| mixed.casts_shadow(light))
            .collect::<Vec<_>>(),
        [false, true, false]
    );
    let product = |terms: &[Vec<f32>]| -> Vec<f32> {
        let pixels = 0..terms[0].len();
        pixels
            .map(|pixel| terms.iter().map(|light| light[pixel]).product())
            .collect()
    };
    let truth = Truth::trace(&mixed, SIZE, &[], &|| ()).expect("a sound scene");
    let truth = |light: usize| -> Vec<f32> {
        truth.terms[light]
            .iter()
            .map(|term| term.unwrap_or(1.0))
            .collect()
    };
    let truths = [truth(0), truth(1), truth(2)];
    assert!(truths[0].iter().chain(&truths[2]).all(|term| *term == 1.0));
    assert!(truths[1].contains(&0.0));
    for method in [None, Some("basic"), Some("pssm")] {
        let options = RenderOptions {
            what: What::ShadowTerm,
            shadow: method.map(Shadow::new).unwrap_or_default(),
            ..RenderOptions::default()
        };
        let Picture::ShadowTerm(terms) = draw(&mut renderer, &mixed, options) else {
            unreachable!("a shadow term was asked for")
        };
        let pairs = product(&terms);
        let pairs = pairs.iter().zip(product(&truths));
        let differ = pairs.filter(|(a, b)| (**a >= 0.5) != (*b >= 0.5)).count();
        assert!(differ < 540, "{method:?}: {differ} pixels differ");
        assert!(terms[0].iter().chain(&terms[2]).all(|term| *term == 1.0));
    }
    // Alone, the light does not make a scene that leaves open which lights cast.
    let alone = mixed.clone().lit_by(0).expect("a light");
    assert!(!alone.casts_shadow(&alone.lights[0]));
    let alone = mixed.clone().lit_by(1).expect("a light");
    assert!(alone.casts_shadow(&alone.lights[0]));
    assert!(mixed.lit_by(3).is_none());
    // Where no light has a `shadow`, all cast.
    let open = scene(ASLANT, fill);
    assert!(open.casts_shadow(&open.lights[0]));
}
