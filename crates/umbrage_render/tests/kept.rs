//! Shadow maps that stand are not drawn again, and nothing else is kept.

mod common;

use std::sync::Arc;

use common::{example, methods, renderer};
use glam::DVec3;
use umbrage_render::{Picture, RenderOptions, Renderer, Report, Scene, Shadow, What};
use umbrage_shadow::LightKind;

fn options(method: &str, axes: &[(&str, &str)]) -> RenderOptions {
    let mut shadow = Shadow::new(method).with_setting("resolution", 128.0);
    if axes.contains(&("filter", "hpsm")) {
        shadow = shadow.with_setting("always_bounded", 1.0);
    }
    RenderOptions {
        width: 96,
        height: 64,
        what: What::ShadowTerm,
        shadow: axes.iter().fold(shadow, |shadow, (a, v)| shadow.with(a, v)),
        ..RenderOptions::default()
    }
}

/// The report of a picture, which is the one that a renderer makes that keeps nothing.
fn render(renderer: &mut Renderer, scene: &Scene, options: &RenderOptions) -> Report {
    let kept = renderer.render(scene, options).expect("renders");
    let fresh = RenderOptions {
        fresh: true,
        ..options.clone()
    };
    let alone = self::renderer(methods()).render(scene, &fresh);
    let alone = alone.expect("renders");
    let terms = |picture: &Picture| match picture {
        Picture::ShadowTerm(terms) => terms.concat(),
        _ => unreachable!("shadow terms were asked for"),
    };
    assert!(
        terms(&kept.picture) == terms(&alone.picture),
        "{}: what was kept is not what would be drawn",
        options.shadow.method
    );
    kept.report
}

/// Passes of plans that were run, and that were not.
fn runs(report: &Report) -> [u32; 2] {
    let run = report.caster_passes + report.derived_passes + report.repaired_passes;
    [run, report.kept_passes]
}

/// A scene, a method and values of axes.
type Chosen = (
    &'static str,
    &'static str,
    &'static [(&'static str, &'static str)],
);

/// Parts with passes of each kind, in lights of each kind.
const CHOICES: [Chosen; 8] = [
    ("bunny_sun", "basic", &[]),
    ("room_point", "basic", &[]),
    ("suzanne_spot", "pssm", &[]),
    (
        "bunny_sun",
        "basic",
        &[("depth", "midpoint"), ("filter", "hpsm")],
    ),
    ("avenue", "pssm", &[("filter", "esm_half")]),
    ("avenue", "pssm", &[("lookup", "channels")]),
    ("avenue", "pssm", &[("lookup", "matrix_texture")]),
    ("avenue", "pssm", &[("depth", "midpoint_two_passes")]),
];

fn scene(name: &str) -> Scene {
    example(&format!("{name}.ron"))
}

#[test]
fn a_still_scene_draws_no_map() {
    for (name, method, axes) in CHOICES {
        let (mut renderer, scene) = (renderer(methods()), scene(name));
        let options = options(method, axes);
        let [first, none] = runs(&render(&mut renderer, &scene, &options));
        assert!(first > 0 && none == 0, "{name}, {method}: {first}, {none}");
        for _ in 0..2 {
            let again = runs(&render(&mut renderer, &scene, &options));
            assert_eq!(again, [0, first], "{name}, {method}, {axes:?}");
        }
        // Other pictures of the same maps draw none, either.
        let shaded = RenderOptions {
            what: What::Shaded,
            ..options.clone()
        };
        let shaded = renderer.render(&scene, &shaded).expect("renders");
        assert_eq!(runs(&shaded.report), [0, first], "{name}, {method}");
        // A measurement has all of it drawn.
        let fresh = RenderOptions {
            fresh: true,
            ..options
        };
        let fresh = renderer.render(&scene, &fresh).expect("renders");
        assert_eq!(runs(&fresh.report), [first, 0], "{name}, {method}");
    }
}

/// A map whose contents change is drawn again, and all that is made of it.
#[test]
fn what_moves_is_drawn_again() {
    type Change = (&'static str, fn(&mut Scene));
    let changes: [Change; 6] = [
        ("an object moves", |scene| {
            scene.objects[0].transform.translation.x += 0.05;
            scene.objects[0].bounds = scene.objects[0].bounds.translate(DVec3::X * 0.05);
        }),
        ("a mesh is another", |scene| {
            let mut mesh = (*scene.objects[0].mesh).clone();
            for position in &mut mesh.positions {
                position.y *= 0.9;
            }
            scene.objects[0].mesh = Arc::new(mesh);
        }),
        ("a material is another", |scene| {
            let mut material = (*scene.objects[0].material).clone();
            material.alpha_cutoff = Some(0.5);
            material.base_color.w = 0.25;
            scene.objects[0].material = Arc::new(material);
        }),
        ("the camera moves", |scene| {
            scene.camera.position += DVec3::new(0.1, 0.02, -0.1);
        }),
        ("the light turns", |scene| {
            match &mut scene.lights[0].light.kind {
                LightKind::Directional { direction } | LightKind::Spot { direction, .. } => {
                    *direction = (*direction + DVec3::new(0.02, 0.0, 0.01)).normalize();
                }
                LightKind::Point { position, .. } => position.x += 0.1,
            }
        }),
        ("an object is gone", |scene| {
            scene.objects.remove(0);
        }),
    ];
    for (name, method, axes) in CHOICES {
        for (what, change) in changes {
            let (mut renderer, mut scene) = (renderer(methods()), scene(name));
            let options = options(method, axes);
            render(&mut renderer, &scene, &options);
            change(&mut scene);
            let [run, _] = runs(&render(&mut renderer, &scene, &options));
            assert!(
                run > 0,
                "{name}, {method}, {axes:?}: {what}, and nothing is drawn"
            );
            let again = runs(&render(&mut renderer, &scene, &options));
            assert_eq!(again[0], 0, "{name}, {method}, {axes:?}: {what}");
        }
    }
}

/// Choices for one light leave the maps of others alone.
#[test]
fn other_lights_keep_their_maps() {
    let mut scene = scene("bunny_sun");
    let mut other = scene.lights[0].clone();
    other.name = "other".to_owned();
    if let LightKind::Directional { direction } = &mut other.light.kind {
        *direction = DVec3::new(0.3, -1.0, 0.2).normalize();
    }
    scene.lights.push(other);
    for light in &mut scene.lights {
        light.shadow = Some(Shadow {
            method: "basic".to_owned(),
            ..Shadow::default()
        });
    }
    let mut renderer = renderer(methods());
    let all = options("", &[]);
    let [first, _] = runs(&render(&mut renderer, &scene, &all));
    if let Some(shadow) = &mut scene.lights[1].shadow {
        shadow.axes.insert("filter".to_owned(), "hpsm".to_owned());
        let always = ("always_bounded".to_owned(), 1.0);
        shadow.settings.extend([always]);
    }
    let [run, kept] = runs(&render(&mut renderer, &scene, &all));
    // The map stands, and bounds of it are made.
    assert_eq!([run, kept], [1, first]);
}

/// A filter's width says nothing of the map that it samples.
#[test]
fn what_is_made_of_a_map_may_change_by_itself() {
    let (mut renderer, scene) = (renderer(methods()), scene("avenue"));
    let filtered = |exponent: f64| {
        let mut options = options("pssm", &[("filter", "esm")]);
        options
            .shadow
            .settings
            .insert("exponent".to_owned(), exponent);
        options
    };
    let [first, _] = runs(&render(&mut renderer, &scene, &filtered(40.0)));
    let report = render(&mut renderer, &scene, &filtered(60.0));
    assert_eq!(report.caster_passes, 0, "the maps stand");
    assert_eq!(
        report.derived_passes, 2,
        "rows and columns are filtered anew"
    );
    assert_eq!(runs(&report).iter().sum::<u32>(), first);
}

/// A picture that fails half-way has recorded maps that are never drawn: they do not count as standing.
#[test]
fn a_picture_that_fails_keeps_no_map() {
    let (mut renderer, sound) = (renderer(methods()), scene("bunny_sun"));
    let mut broken = sound.clone();
    // It casts nothing, so that its fault is met after the maps are recorded.
    let ground = broken.objects.iter_mut().find(|o| o.name == "ground");
    let ground = ground.expect("a ground");
    let mut mesh = (*ground.mesh).clone();
    mesh.normals.pop();
    ground.mesh = Arc::new(mesh);
    let mut material = (*ground.material).clone();
    material.casts = false;
    ground.material = Arc::new(material.clone());
    let mut sound = sound;
    let ground = sound.objects.iter_mut().find(|o| o.name == "ground");
    ground.expect("a ground").material = Arc::new(material);
    let options = options("basic", &[]);
    renderer
        .render(&broken, &options)
        .expect_err("a mesh whose arrays do not fit");
    let [run, kept] = runs(&render(&mut renderer, &sound, &options));
    assert!(run > 0 && kept == 0, "{run}, {kept}");
}
