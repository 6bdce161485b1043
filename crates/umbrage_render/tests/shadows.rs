//! Shadows lie where geometry puts them.

mod common;

use common::{example, methods, renderer, scene, small, term};
use glam::DVec3;
use umbrage_render::{Picture, RenderOptions, Scene, What};
use umbrage_shadow::LightKind;

fn options() -> RenderOptions {
    RenderOptions {
        what: What::ShadowTerm,
        ..RenderOptions::default()
    }
}

/// Where the ground lies in the shadow of the bunny's head; the body hides the rest of its shadow.
fn under_the_head(scene: &Scene) -> DVec3 {
    let LightKind::Directional { direction } = scene.lights[0].light.kind else {
        unreachable!("it has a sun")
    };
    let head = DVec3::new(-0.5, 1.35, 0.3);
    head - direction * (head.y / direction.y)
}

#[test]
fn a_sun_throws_the_bunny_onto_the_ground() {
    let scene = example("bunny_sun.ron");
    let rendered = renderer(methods())
        .render(&scene, &options())
        .expect("renders");
    assert_eq!(term(&scene, &rendered, under_the_head(&scene)), 0.0);
    for lit in [DVec3::new(1.2, 0.0, -0.5), DVec3::new(0.5, 0.0, -3.0)] {
        assert_eq!(term(&scene, &rendered, lit), 1.0);
    }
}

#[test]
fn no_light_comes_through_a_screen() {
    let scene = example("room_point.ron");
    let rendered = renderer(methods())
        .render(&scene, &options())
        .expect("renders");
    for step in 0..20 {
        let z = -0.2 - 0.05 * f64::from(step);
        for wall in [
            DVec3::new(3.0, 0.6, z),
            DVec3::new(3.0, 1.0, z),
            DVec3::new(3.0, 1.4, z),
        ] {
            assert_eq!(term(&scene, &rendered, wall), 0.0, "{wall}");
        }
    }
    // Above the screen's shadow, and on the floor before it.
    assert_eq!(term(&scene, &rendered, DVec3::new(3.0, 2.2, -1.0)), 1.0);
    assert_eq!(term(&scene, &rendered, DVec3::new(0.3, 0.0, 0.5)), 1.0);
}

#[test]
fn a_point_light_casts_to_all_sides() {
    let balls = "shape: sphere(radius: 0.1), name: \"ball\"";
    for axis in 0..6 {
        let forward = DVec3::AXES[axis / 2] * if axis % 2 == 0 { 1.0 } else { -1.0 };
        let (right, up) = (
            DVec3::AXES[(axis / 2 + 1) % 3],
            DVec3::AXES[(axis / 2 + 2) % 3],
        );
        let DVec3 { x, y, z } = forward;
        let ball = forward + 0.3 * right + 0.15 * up;
        let scene = scene(&format!(
            r#"(
            camera: (position: (0, 0, 0), target: ({x}, {y}, {z}), fov_degrees: 60),
            lights: [(
                kind: point(position: (0, 0, 0), range: 20),
                shadow: (method: "basic", settings: {{"resolution": 512}}),
            )],
            models: [
                ({balls}, translation: ({}, {}, {})),
                (shape: box(size: (1, 1, 1)), name: "room", scale: (-6, 6, 6)),
            ])"#,
            ball.x, ball.y, ball.z
        ));
        // The camera stands at the light: the ball hides its shadow, so look past it from aside.
        let mut aside = scene.clone();
        aside.camera.position = -0.4 * right;
        let rendered = renderer(methods())
            .render(&aside, &options())
            .expect("renders");
        let wall = |r: f64, u: f64| term(&aside, &rendered, 3.0 * forward + r * right + u * up);
        assert_eq!(wall(0.9, 0.45), 0.0, "face {axis}");
        for (r, u) in [
            (-0.9, 0.45),
            (0.9, -0.45),
            (-0.9, -0.45),
            (0.45, 0.9),
            (0.0, 0.0),
        ] {
            assert_eq!(wall(r, u), 1.0, "face {axis}: {r} {u}");
        }
    }
}

#[test]
fn holes_in_leaves_let_the_light_through() {
    let scene = example("leaves.ron");
    let mut renderer = renderer(methods());
    let shaded = |picture: &Picture| {
        let Picture::ShadowTerm(lights) = picture else {
            unreachable!("a shadow term was asked for")
        };
        lights[0].iter().filter(|term| **term < 0.5).count()
    };
    let leaves = renderer.render(&scene, &options()).expect("renders");
    let mut solid = scene.clone();
    let mut material = (*scene.objects[0].material).clone();
    material.alpha_cutoff = None;
    solid.objects[0].material = material.into();
    let solid = renderer.render(&solid, &options()).expect("renders");
    let (leaves, solid) = (shaded(&leaves.picture), shaded(&solid.picture));
    assert!(leaves > 1000 && 2 * leaves < solid, "{leaves} of {solid}");
}

#[test]
fn what_does_not_cast_throws_no_shadow_but_receives() {
    let mut scene = example("bunny_sun.ron");
    let mut material = (*scene.objects[0].material).clone();
    material.casts = false;
    scene.objects[0].material = material.into();
    let rendered = renderer(methods())
        .render(&scene, &options())
        .expect("renders");
    assert_eq!(term(&scene, &rendered, under_the_head(&scene)), 1.0);
}

#[test]
fn what_a_light_does_not_reach_hides_what_it_does() {
    let scene = scene(
        r#"(
        camera: (position: (0, 1, 6), target: (0, 1, 0)),
        lights: [(
            kind: spot(position: (0, 3, 0), target: (0, 0, 0), outer_degrees: 40, range: 5),
            shadow: (method: "basic"),
        )],
        models: [
            (shape: plane(size: (8, 8))),
            (shape: box(size: (0.5, 0.5, 0.5)), translation: (0, 1, 0)),
            (shape: box(size: (3, 1, 0.1)), translation: (0, 0.5, 5)),
        ])"#,
    );
    let mut renderer = renderer(methods());
    let rendered = renderer
        .render(&scene, &small(What::ShadowTerm))
        .expect("renders");
    // The shadow lies behind the board, which no light reaches.
    assert_eq!(term(&scene, &rendered, DVec3::ZERO), 1.0);
    let mut open = scene.clone();
    open.objects.truncate(2);
    let rendered = renderer
        .render(&open, &small(What::ShadowTerm))
        .expect("renders");
    assert_eq!(term(&open, &rendered, DVec3::ZERO), 0.0);
}
