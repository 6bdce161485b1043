//! Light from where it is awkward: `duelling-frusta`, `overhead`, `grazing`.

use std::sync::Arc;

use glam::{DQuat, DVec2, DVec3, Vec2, Vec3};
use umbrage_render::{Camera, Mesh};

use super::{
    Case, shapes,
    stage::{BLUE, BRICK, GREEN, OCHRE, STONE, Stage, at, camera, scattered, turned, vec},
};

pub(super) fn cases() -> Vec<Case> {
    let mut cases = vec![
        along(),
        against(),
        duelling_lamp(),
        overhead(),
        overhead_down(),
        overhead_spot(),
    ];
    cases.extend(GRAZING.map(|(name, hard, angle)| grazing(name, hard, angle)));
    cases
}

/// Posts, balls and trees to all sides of a way that leads away from the viewer.
fn avenue(stage: &mut Stage) {
    stage.ground(120.0, 120.0);
    for row in 0..5 {
        let z = -1.0 - 4.5 * f64::from(row);
        stage
            .block("post", vec(0.5, 2.2, 0.5), STONE, vec(-3.2, 0.0, z))
            .ball(0.6, OCHRE, vec(2.6, 0.6, z - 1.2))
            .block("post", vec(0.5, 2.6, 0.5), BRICK, vec(5.6, 0.0, z - 0.4))
            .put("tree", shapes::tree(3.6), GREEN, at(-6.4, 0.0, z - 2.0));
    }
}

fn along() -> Case {
    let (eye, target) = (vec(0.0, 3.4, 4.5), vec(0.0, 0.4, -6.0));
    let mut stage = Stage::new(camera(eye, target, 70.0));
    avenue(&mut stage);
    stage.sun(target - eye);
    stage.case(
        "duelling-frusta-along",
        "the sun shines exactly along the view: near and far fall on the same texels",
    )
}

fn against() -> Case {
    let (eye, target) = (vec(0.0, 1.3, 7.0), vec(0.0, 3.2, -5.0));
    let mut stage = Stage::new(camera(eye, target, 70.0));
    avenue(&mut stage);
    stage.sun(eye - target);
    stage.case(
        "duelling-frusta-against",
        "the sun shines exactly against the view: what is near the viewer is far from the light",
    )
}

fn duelling_lamp() -> Case {
    let eye = vec(0.0, 2.4, 8.0);
    let mut stage = Stage::new(camera(eye, vec(0.0, 0.8, -3.0), 62.0));
    avenue(&mut stage);
    stage.point(vec(0.0, 1.6, -5.0), 4.0, 40.0);
    stage.case(
        "duelling-frusta-lamp",
        "a lamp in the middle of the view: nearer to it is farther from the viewer, and the reverse",
    )
}

/// A table, a ring and a tilted board: undersides, edges and slopes.
fn still_life(stage: &mut Stage) {
    stage.block("top", vec(2.0, 0.08, 1.2), BRICK, vec(-0.9, 0.9, 0.0));
    for (x, z) in [(-1.8, -0.5), (0.0, -0.5), (-1.8, 0.5), (0.0, 0.5)] {
        stage.block("leg", vec(0.08, 0.9, 0.08), BRICK, vec(x, 0.0, z));
    }
    let board = Mesh::cuboid(Vec3::new(0.9, 0.05, 1.4));
    stage
        .ball(0.32, OCHRE, vec(-0.9, 1.3, 0.1))
        .put(
            "board",
            board,
            BLUE,
            turned(vec(1.6, 0.5, -0.6), 30.0, 35.0),
        )
        .put(
            "ring",
            shapes::torus(0.5, 0.18),
            STONE,
            turned(vec(1.3, 0.6, 1.0), 20.0, 70.0),
        );
}

fn overhead() -> Case {
    let mut stage = Stage::new(camera(vec(2.4, 3.0, 4.6), vec(0.1, 0.4, 0.0), 48.0));
    stage.ground(16.0, 16.0);
    still_life(&mut stage);
    stage.sun(DVec3::NEG_Y);
    stage.case(
        "overhead",
        "the sun stands straight above: an up vector of (0, 1, 0) is along the light",
    )
}

fn overhead_down() -> Case {
    let mut stage = Stage::new(camera(vec(0.0, 9.0, 0.0), DVec3::ZERO, 60.0));
    stage.ground(40.0, 40.0);
    let plate = Arc::new(Mesh::cuboid(Vec3::new(1.5, 0.06, 1.1)));
    for (index, place) in scattered(12).enumerate() {
        let offset = (place - 0.5) * DVec2::new(15.0, 8.0);
        let height = 1.6 + 0.22 * index as f64;
        let color = [BRICK, OCHRE, BLUE][index % 3];
        let place = turned(vec(offset.x, height, offset.y), 37.0 * index as f64, 0.0);
        stage.put("plate", Arc::clone(&plate), color, place);
    }
    stage.sun(DVec3::NEG_Y);
    stage.case(
        "overhead-down",
        "sun and viewer both look straight down: neither has an up of its own",
    )
}

fn overhead_spot() -> Case {
    let mut stage = Stage::new(camera(vec(0.3, 1.9, 5.6), vec(0.0, 1.6, 0.0), 66.0));
    stage.ground(10.0, 10.0);
    let ceiling = Mesh::plane(Vec2::splat(10.0), Vec2::ONE);
    stage.put(
        "ceiling",
        ceiling,
        STONE,
        turned(vec(0.0, 4.0, 0.0), 0.0, 180.0),
    );
    still_life(&mut stage);
    stage
        .ball(0.35, GREEN, vec(2.3, 1.6, -0.8))
        .spot(vec(-1.0, 3.8, 0.2), vec(-1.0, 0.0, 0.2), 52.0, 12.0)
        .spot(vec(2.0, 0.15, -0.8), vec(2.0, 4.0, -0.8), 52.0, 12.0);
    stage.case(
        "overhead-spot",
        "one spot light straight down and one straight up, between floor and ceiling",
    )
}

/// Name, what is hard, and degrees between the light and the ground's normal.
pub(super) const GRAZING: [(&str, &str, f64); 3] = [
    (
        "grazing-80",
        "light at 80° to the ground's normal: a texel stretches 5.8 times",
        80.0,
    ),
    (
        "grazing-85",
        "light at 85° to the ground's normal: a texel stretches 11.5 times",
        85.0,
    ),
    (
        "grazing-89",
        "light at 89° to the ground's normal: a texel stretches 57 times",
        89.0,
    ),
];

fn grazing(name: &'static str, hard: &'static str, angle: f64) -> Case {
    let view = camera(vec(0.4, 2.6, 5.2), vec(0.2, 0.0, -0.4), 46.0);
    low_things(view, angle.to_radians()).case(name, hard)
}

/// Casters so low that their shadows are two metres long, and a dome so flat that the light leaves it
/// somewhere on its far side, in light at `angle` (radians) to the ground's normal.
pub(super) fn low_things(view: Camera, angle: f64) -> Stage {
    let mut stage = Stage::new(view);
    stage.ground(30.0, 30.0);
    let low = 2.0 / angle.tan();
    for (index, place) in scattered(9).enumerate() {
        let foot = vec(7.0 * place.x - 4.4, 0.0, 5.0 * place.y - 3.4);
        let color = [BRICK, OCHRE, BLUE][index % 3];
        let tile = Mesh::cuboid(Vec3::new(0.35, low as f32, 0.5));
        let tile_place = turned(foot + 0.5 * low * DVec3::Y, 25.0 * index as f64, 0.0);
        stage.put("tile", tile, color, tile_place);
    }
    let dome = shapes::dome(1.1, (1.2 * low) as f32);
    stage.put("dome", dome, STONE, at(0.3, 0.0, 0.6));
    // Turned about the ground's normal, which leaves the angle as it is.
    let turn = DQuat::from_rotation_y(0.35);
    stage.sun(turn * vec(angle.sin(), -angle.cos(), 0.0));
    stage
}
