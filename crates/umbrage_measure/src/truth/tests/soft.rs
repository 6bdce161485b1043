//! Lights with an extent.

use std::f64::consts::PI;

use glam::DVec3;
use umbrage_render::{Mesh, Scene};
use umbrage_shadow::LightKind;

use super::stage::{HERE, ball, scene, square};
use crate::truth::{Source, Tracer};

const STRATA: u32 = 32;
/// Metres from the floor to the edge.
const HEIGHT: f64 = 5.0;

/// A floor, and a plane above it that ends at x = 0, seen at the floor's point (x, 0, 0).
fn half_covered(x: f64, light: LightKind) -> Scene {
    let half_plane = Mesh {
        positions: square(1000.0)
            .positions
            .iter()
            .map(|p| p.with_x(p.x + 1000.0))
            .collect(),
        ..square(1000.0)
    };
    let objects = vec![
        HERE.object("floor", square(10.0), DVec3::ZERO),
        HERE.object("half plane", half_plane, DVec3::new(0.0, HEIGHT, 0.0)),
    ];
    let target = DVec3::new(x, 0.0, 0.0);
    let camera = HERE.camera(target + DVec3::new(-2.0, 2.0, 1.0), target, DVec3::Y);
    scene(objects, light, camera)
}

fn share(scene: &Scene, size: f64) -> f64 {
    let tracer = Tracer::new(scene).expect("a sound scene");
    let sight = tracer.look(1, 1, &|| ()).expect("a size");
    let source = Source::Round {
        size,
        strata: STRATA,
    };
    let terms = tracer.shadow(&sight, 0, source, &|| ()).expect("a light");
    f64::from(terms[0].expect("the floor is seen"))
}

/// Share of a disc of radius 1 that the edge cuts off at a distance from its middle.
fn segment(distance: f64) -> f64 {
    (distance.acos() - distance * (1.0 - distance * distance).sqrt()) / PI
}

/// A part of the disc that the edge runs through may fall to either side whole: the edge runs through
/// no more than two columns and two rows of parts, and half of that would already be bad luck.
const MARGIN: f64 = 2.0 / STRATA as f64;

#[test]
fn half_a_ball_of_light_is_half_the_light() {
    let position = DVec3::new(0.0, 10.0, 0.0);
    let bulb = LightKind::Point {
        position,
        range: 100.0,
    };
    let lit = share(&half_covered(0.0, bulb), 1.0);
    assert!((lit - 0.5).abs() < MARGIN, "{lit}");
}

#[test]
fn a_sun_sets_behind_an_edge_as_a_disc_does() {
    let sun = LightKind::Directional {
        direction: DVec3::NEG_Y,
    };
    // So small that the disc in the sky is flat.
    let angle = 0.02_f64;
    for part in [-1.5, -0.7, -0.3, 0.0, 0.4, 0.8, 1.5_f64] {
        // Seen from x, the edge stands `part` of the disc's radius from its middle.
        let x = HEIGHT * (part * angle).tan();
        let lit = share(&half_covered(x, sun.clone()), angle);
        let expected = segment(part.clamp(-1.0, 1.0));
        assert!((lit - expected).abs() < MARGIN, "{part}: {lit} {expected}");
    }
}

#[test]
fn a_point_within_the_light_is_lit() {
    let bulb = LightKind::Point {
        position: DVec3::new(0.0, 0.5, 0.0),
        range: 100.0,
    };
    assert_eq!(share(&half_covered(0.0, bulb), 1.0), 1.0);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let objects = vec![
        HERE.object("floor", square(10.0), DVec3::ZERO),
        HERE.object("ball", ball(1.0, 64), DVec3::new(0.0, 1.5, 0.0)),
    ];
    let direction = DVec3::new(0.3, -1.0, 0.2).normalize();
    let camera = HERE.camera(DVec3::new(2.0, 4.0, 5.0), DVec3::ZERO, DVec3::Y);
    let scene = scene(objects, LightKind::Directional { direction }, camera);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| {
            let tracer = Tracer::new(&scene).expect("a sound scene");
            let sight = tracer.look(61, 47, &|| ()).expect("a size");
            let source = Source::Round {
                size: 0.1,
                strata: 4,
            };
            let terms = tracer.shadow(&sight, 0, source, &|| ()).expect("a light");
            (sight, terms)
        })
    };
    let one = run(1);
    assert!(
        one.1
            .iter()
            .flatten()
            .any(|term| *term > 0.0 && *term < 1.0)
    );
    for threads in [2, 5] {
        assert!(run(threads) == one, "{threads} threads");
    }
}
