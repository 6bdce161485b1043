//! Casters that are not seen, and casters far from what they shade: `behind`, `exponent`.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use umbrage_render::Mesh;

use super::{
    Case, shapes,
    stage::{BLUE, BRICK, GREEN, OCHRE, STONE, Stage, at, camera, scattered, turned, vec},
};

pub(super) fn cases() -> Vec<Case> {
    vec![
        behind(),
        behind_light(),
        behind_spot(),
        exponent(),
        overlap(),
        overlap_spot(),
        contact(),
        contact_spot(),
    ]
}

/// Only the shadows of a gate, trees and a ball fall into view.
fn behind() -> Case {
    let mut stage = Stage::new(camera(vec(0.0, 1.7, 0.0), vec(0.0, 0.6, -6.0), 55.0));
    stage.ground(80.0, 80.0);
    for x in [-2.4, 0.6] {
        stage.block("pillar", vec(0.5, 6.0, 0.5), STONE, vec(x, 0.0, 4.5));
    }
    stage
        .block("beam", vec(4.0, 0.6, 0.6), STONE, vec(-0.9, 6.0, 4.5))
        .put("tree", shapes::tree(7.0), GREEN, at(4.4, 0.0, 3.0))
        .put("tree", shapes::tree(5.0), GREEN, at(-5.6, 0.0, 1.5))
        .ball(0.8, OCHRE, vec(-1.0, 5.0, 3.0))
        .sun(vec(0.08, -0.52, -0.85));
    stage.case(
        "behind",
        "all casters stand behind the viewer; their shadows fall into view",
    )
}

/// Clouds of plates from 40 to 150 m up the light.
fn behind_light() -> Case {
    let mut stage = Stage::new(camera(vec(0.0, 3.0, 8.0), vec(0.0, 0.4, 0.0), 50.0));
    stage
        .ground(60.0, 60.0)
        .ball(0.8, OCHRE, vec(1.2, 0.8, 0.0))
        .put(
            "stairs",
            shapes::stairs(6, Vec3::new(2.0, 0.2, 0.35)),
            BRICK,
            at(-2.2, 0.0, -1.0),
        );
    let light = vec(-0.62, -0.7, -0.2).normalize();
    let disc = Arc::new(shapes::torus(0.9, 0.5));
    for (index, share) in scattered(10).enumerate() {
        let shaded = vec(11.0 * share.x - 5.5, 0.0, 10.0 * share.y - 6.0);
        let distance = 40.0 + 12.0 * index as f64;
        let place = turned(shaded - distance * light, 30.0 * index as f64, 10.0);
        stage.put("ring", Arc::clone(&disc), STONE, place);
    }
    stage.sun(light);
    stage.case(
        "behind-light",
        "casters 40 to 150 m towards the sun, beside the view: a map's depth must reach them",
    )
}

/// Bars between a spot light and a viewer who stands before it.
fn behind_spot() -> Case {
    let light = vec(0.6, 3.4, 6.0);
    let mut stage = Stage::new(camera(vec(0.0, 1.7, 1.0), vec(0.0, 1.1, -5.0), 60.0));
    stage
        .ground(20.0, 20.0)
        .block("wall", vec(12.0, 4.0, 0.2), STONE, vec(0.0, 0.0, -5.0))
        .ball(0.6, OCHRE, vec(-1.1, 0.6, -3.2));
    for index in 0..6 {
        let x = -0.55 + 0.4 * f64::from(index);
        let bar = Mesh::cuboid(Vec3::new(0.08, 1.6, 0.08));
        stage.put("bar", bar, BLUE, at(x, 2.9, 4.6));
    }
    let cross = Mesh::cuboid(Vec3::new(2.4, 0.08, 0.08));
    stage.put("bar", cross, BLUE, at(0.45, 2.75, 4.55)).spot(
        light,
        vec(0.0, 1.2, -5.0),
        32.0,
        30.0,
    );
    stage.case(
        "behind-spot",
        "a spot light and a grating before it, both behind the viewer",
    )
}

/// Beams 80 m over a floor that also has shadows from half a metre.
fn exponent() -> Case {
    let mut stage = Stage::new(camera(vec(1.6, 2.6, 5.2), vec(0.2, 0.5, -0.2), 48.0));
    stage
        .ground(30.0, 30.0)
        .block("table", vec(1.6, 0.08, 1.2), BRICK, vec(0.9, 0.5, 0.5))
        .ball(0.4, OCHRE, vec(-0.6, 0.7, 0.6))
        .block("step", vec(2.2, 0.35, 1.0), STONE, vec(-0.5, 0.0, -1.3));
    let light = vec(-0.22, -1.0, -0.16).normalize();
    for (x, turn) in [(-2.2, 20.0), (0.1, -35.0), (2.4, 10.0)] {
        let beam = Mesh::cuboid(Vec3::new(0.7, 0.4, 5.0));
        let up = light * (80.0 / light.y.abs());
        stage.put("beam", beam, BLUE, turned(vec(x, 0.0, 0.0) - up, turn, 0.0));
    }
    stage.sun(light);
    stage.case(
        "exponent",
        "occluders 80 m before a receiver, and others half a metre before it: depths apart by any exponent",
    )
}

/// Two plates one above the other, so that their shadows overlap in part; and one that lies in the
/// other's shadow.
fn plates(stage: &mut Stage) {
    let plate = |x: f32, z: f32| Mesh::cuboid(Vec3::new(x, 0.04, z));
    stage
        .ground(14.0, 14.0)
        .put(
            "high",
            plate(1.8, 1.4),
            BLUE,
            turned(vec(-0.2, 3.2, 0.0), 15.0, 0.0),
        )
        .put(
            "low",
            plate(1.6, 1.2),
            OCHRE,
            turned(vec(0.4, 0.7, 0.2), -20.0, 0.0),
        )
        .put(
            "low",
            plate(0.8, 0.8),
            BRICK,
            turned(vec(-1.6, 0.25, 0.7), 35.0, 0.0),
        );
}

fn overlap() -> Case {
    let mut stage = Stage::new(camera(vec(1.5, 2.4, 4.6), vec(-0.1, 0.6, 0.0), 50.0));
    plates(&mut stage);
    stage.sun(vec(-0.3, -1.0, 0.12));
    stage.case(
        "exponent-overlap",
        "two occluders at different depths overlap: a filter's depths are a mixture, and light leaks",
    )
}

fn overlap_spot() -> Case {
    let mut stage = Stage::new(camera(vec(1.5, 2.4, 4.6), vec(-0.1, 0.6, 0.0), 50.0));
    plates(&mut stage);
    let wall = Mesh::quad(Vec2::new(8.0, 4.0), Vec2::ONE);
    stage.put("wall", wall, STONE, at(0.0, 2.0, -2.2)).spot(
        vec(0.8, 5.0, 1.2),
        DVec3::ZERO,
        38.0,
        16.0,
    );
    stage.case(
        "exponent-overlap-spot",
        "the same under a spot light, whose depth is no longer linear",
    )
}

/// A kerb, a plinth, a pillar and a ramp on the ground, their shadows towards the viewer.
fn standing() -> Stage {
    let mut stage = Stage::new(camera(vec(0.3, 2.5, 4.8), vec(0.2, 0.3, 0.0), 46.0));
    stage
        .ground(12.0, 12.0)
        .block("kerb", vec(2.2, 0.07, 0.3), STONE, vec(-0.6, 0.0, 1.2))
        .block("plinth", vec(0.7, 0.3, 0.6), BRICK, vec(1.2, 0.0, 0.5))
        .block("pillar", vec(0.25, 1.3, 0.25), OCHRE, vec(-1.1, 0.0, -0.4))
        .put(
            "ramp",
            shapes::wedge(Vec3::new(0.9, 0.4, 0.7)),
            GREEN,
            turned(vec(0.2, 0.0, -0.9), 200.0, 0.0),
        );
    stage
}

fn contact() -> Case {
    let mut stage = standing();
    let light = vec(0.32, -1.0, 0.4).normalize();
    // Across the shadows of plinth and kerb, from 80 m up.
    for (x, z, turn) in [(-1.2, 1.5, 25.0), (1.8, 1.0, -10.0)] {
        let beam = Mesh::cuboid(Vec3::new(0.4, 0.3, 2.4));
        let up = light * (80.0 / light.y.abs());
        stage.put("beam", beam, BLUE, turned(vec(x, 0.0, z) - up, turn, 0.0));
    }
    stage.sun(light);
    stage.case(
        "exponent-contact",
        "shadows that begin at the caster, in a map whose depths span 80 m: contact is lit by any exponent",
    )
}

fn contact_spot() -> Case {
    let mut stage = standing();
    let (lamp, target) = (vec(-2.4, 6.0, -3.2), vec(0.2, 0.0, 0.4));
    // Bars so near to the lamp that most of its depths lie before them.
    for (index, distance) in [0.12, 0.2].into_iter().enumerate() {
        let across = (0.5 - index as f64) * 0.5 * distance;
        let bar = Mesh::cuboid(Vec3::new(0.1, 0.1, 1.6) * distance as f32);
        let place = lamp + distance * (target - lamp).normalize() + vec(across, 0.0, 0.0);
        stage.put("bar", bar, BLUE, turned(place, 20.0, 0.0));
    }
    stage.spot(lamp, target, 34.0, 14.0);
    stage.case(
        "exponent-contact-spot",
        "the same under a spot light with a grating 12 cm before it: depths in a ratio of 80",
    )
}
