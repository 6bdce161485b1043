//! Awkward geometry: `open-mesh`, `contact`, `steep-blocks`.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use umbrage_render::Mesh;

use super::{
    Case, shapes,
    stage::{BLUE, BRICK, GREEN, OCHRE, STONE, Stage, at, camera, scattered, turned, vec},
};

pub(super) fn cases() -> Vec<Case> {
    let mut cases = vec![open(), leaves(), mirrored(), contact(), contact_lamp()];
    let sun = |stage: &mut Stage, light| {
        stage.sun(light);
    };
    let lamp = |stage: &mut Stage, light| {
        stage.spot(-6.0 * light, DVec3::ZERO, 36.0, 14.0);
    };
    cases.extend(STEEP.map(|(name, width)| blocks(name, width, sun, 256.0)));
    cases.extend(STEEP_SPOT.map(|(name, width)| blocks(name, width, lamp, 128.0)));
    cases
}

fn open() -> Case {
    let mut stage = Stage::new(camera(vec(1.2, 3.0, 5.0), vec(0.1, 0.4, 0.0), 46.0));
    let sheet = |size: Vec2| Mesh::quad(size, Vec2::ONE);
    let wave = shapes::terrain(Vec2::new(1.6, 1.4), [32, 4], |at| 0.16 * (5.0 * at.x).sin());
    stage
        .ground(16.0, 16.0)
        .put(
            "bowl",
            shapes::bowl(0.7),
            OCHRE,
            turned(vec(-1.9, 0.75, 0.6), 30.0, 40.0),
        )
        .put("tube", shapes::tube(0.4, 1.1), BLUE, at(-0.3, 0.0, -0.4))
        .put(
            "sheet",
            sheet(Vec2::new(1.1, 1.3)),
            BRICK,
            turned(vec(1.3, 0.65, 0.4), 52.0, 0.0),
        )
        .put(
            "sheet",
            sheet(Vec2::new(0.9, 0.9)),
            STONE,
            turned(vec(2.3, 0.7, -0.9), -20.0, -60.0),
        )
        .put("wave", wave, GREEN, turned(vec(0.4, 1.3, -1.6), 15.0, 10.0))
        .sun(vec(0.6, -1.0, -0.45));
    stage.case(
        "open-mesh",
        "surfaces without thickness, seen and lit from both sides: no back face under a front one",
    )
}

fn leaves() -> Case {
    let mut stage = Stage::new(camera(vec(0.9, 2.0, 3.4), vec(0.0, 0.75, 0.0), 48.0));
    stage.ground(16.0, 16.0);
    let leaf = Arc::new(shapes::leaf(0.55, 0.2));
    for (plant, foot) in [(-0.9, 0.1), (0.55, -0.5), (0.9, 0.8)]
        .into_iter()
        .enumerate()
    {
        let foot = vec(foot.0, 0.0, foot.1);
        stage.block("stem", vec(0.03, 1.5, 0.03), BRICK, foot);
        for (index, share) in scattered(26).enumerate() {
            // A golden angle from leaf to leaf, each lower one wider.
            let turn = 137.507_764 * (index as f64 + 9.0 * plant as f64);
            let height = 0.3 + 1.15 * index as f64 / 26.0;
            let droop = DQuat::from_rotation_z((50.0 * share.x - 30.0).to_radians());
            let rotation = DQuat::from_rotation_y(turn.to_radians()) * droop;
            let size = DVec3::splat(1.25 - 0.5 * height);
            let place =
                DAffine3::from_scale_rotation_translation(size, rotation, foot + height * DVec3::Y);
            stage.put("leaf", Arc::clone(&leaf), GREEN, place);
        }
    }
    stage.sun(vec(-0.5, -1.0, -0.35));
    stage.case(
        "open-mesh-leaves",
        "leaves without thickness over leaves, at all angles to the light, some on edge",
    )
}

/// Shapes without a mirror plane on the right, and on the left the same meshes under mirroring transforms,
/// with a lamp between.
fn mirrored() -> Case {
    let mut stage = Stage::new(camera(vec(0.0, 2.7, 4.8), vec(0.0, 0.45, 0.0), 50.0));
    stage.ground(14.0, 14.0);
    let wedge = Arc::new(shapes::wedge(Vec3::new(0.9, 0.8, 1.2)));
    let bowl = Arc::new(shapes::bowl(0.5));
    let stairs = Arc::new(shapes::stairs(5, Vec3::new(0.7, 0.16, 0.22)));
    let mirror = DAffine3::from_scale(vec(-1.0, 1.0, 1.0));
    for (side, color) in [(DAffine3::IDENTITY, OCHRE), (mirror, BLUE)] {
        let mut put = |name: &str, mesh: &Arc<Mesh>, place: DAffine3| {
            stage.put(name, Arc::clone(mesh), color, side * place);
        };
        put("wedge", &wedge, turned(vec(1.3, 0.0, 0.9), 25.0, 0.0));
        put("bowl", &bowl, turned(vec(2.5, 0.6, 0.1), 40.0, 55.0));
        put("stairs", &stairs, turned(vec(1.5, 0.0, -0.7), -35.0, 0.0));
    }
    stage.point(vec(0.0, 2.0, 0.3), 2.2, 14.0);
    stage.case(
        "open-mesh-mirrored",
        "transforms that mirror: fronts wind the other way, and open meshes show their backs",
    )
}

/// A wall 2 cm thick on the ground, a ball that touches it, a cone on its tip, a board that leans.
fn touching() -> Stage {
    let mut stage = Stage::new(camera(vec(1.5, 1.5, 2.7), vec(0.0, 0.25, 0.0), 42.0));
    let board = Mesh::cuboid(Vec3::new(0.5, 0.9, 0.02));
    stage
        .ground(10.0, 10.0)
        .block("wall", vec(0.02, 0.8, 1.8), STONE, vec(-0.75, 0.0, -0.1))
        .ball(0.28, OCHRE, vec(0.1, 0.28, 0.45))
        .put("cone", shapes::cone(0.22, 0.55), BLUE, at(0.75, 0.0, -0.05))
        .put(
            "board",
            board,
            BRICK,
            turned(vec(0.25, 0.43, -0.75), 20.0, -15.0),
        );
    stage
}

fn contact() -> Case {
    let mut stage = touching();
    stage.sun(vec(0.75, -1.0, -0.35));
    stage.case(
        "contact",
        "a thin wall, a ball and a cone's tip on the ground: shadows that begin at the caster",
    )
}

fn contact_lamp() -> Case {
    let mut stage = touching();
    stage.point(vec(-1.5, 1.15, 0.5), 1.6, 10.0);
    stage.case(
        "contact-lamp",
        "the same under a lamp close by: texels grow with the distance, and so does what a bias hides",
    )
}

/// Names, and the filters' widths.
const STEEP: [(&str, &str); 4] = [
    ("steep-blocks-3", "3"),
    ("steep-blocks-5", "5"),
    ("steep-blocks-7", "7"),
    ("steep-blocks-15", "15"),
];
const STEEP_SPOT: [(&str, &str); 4] = [
    ("steep-blocks-spot-3", "3"),
    ("steep-blocks-spot-5", "5"),
    ("steep-blocks-spot-7", "7"),
    ("steep-blocks-spot-15", "15"),
];

/// Patches of two metres: a gentle and a steep plane, ground that is a plane but for millimetres, and ground
/// that is one but for a texel, stairs, fins a centimetre thick, and a ridge. `light` is to shine along a
/// direction; `texels` make up a map's side.
fn blocks(
    name: &'static str,
    width: &'static str,
    light: impl Fn(&mut Stage, DVec3),
    texels: f64,
) -> Case {
    let mut stage = Stage::new(camera(vec(0.4, 4.6, 7.0), vec(0.1, 0.2, 0.1), 42.0));
    let slab = Mesh::cuboid(Vec3::new(1.8, 0.1, 1.8));
    let slab = Arc::new(slab);
    let rough = |height: f32| {
        shapes::terrain(Vec2::splat(1.9), [24, 24], |at| {
            0.25 + height * (9.0 * at.x).sin() * (11.0 * at.y).cos()
        })
    };
    let ridge = shapes::terrain(Vec2::splat(1.9), [2, 1], |at| 0.9 - 0.95 * at.x.abs());
    stage
        .ground(16.0, 16.0)
        .put(
            "gentle",
            Arc::clone(&slab),
            OCHRE,
            turned(vec(-2.6, 0.35, -1.2), 0.0, 12.0),
        )
        .put("steep", slab, BLUE, turned(vec(-2.6, 0.7, 1.4), 40.0, 62.0))
        .put("rough", rough(0.006), STONE, at(0.0, 0.0, 1.4))
        .put("rougher", rough(0.06), OCHRE, at(-0.1, 0.0, 3.5))
        .put("ridge", ridge, GREEN, turned(vec(2.6, 0.0, 1.5), 25.0, 0.0))
        .put(
            "stairs",
            shapes::stairs(8, Vec3::new(1.8, 0.13, 0.2)),
            BRICK,
            turned(vec(-0.2, 0.0, -0.4), -20.0, 0.0),
        );
    for index in 0..8 {
        let x = 1.8 + 0.25 * f64::from(index);
        stage.block("fin", vec(0.01, 0.8, 1.6), STONE, vec(x, 0.0, -1.4));
    }
    stage.block("post", vec(0.05, 1.6, 0.05), BRICK, vec(-1.2, 0.0, 0.4));
    light(&mut stage, vec(0.7, -0.75, -0.45).normalize());
    let case = stage.case(
        name,
        "planes, nearly planes, steps and slivers under texels of 6 cm, filtered so many texels wide",
    );
    case.with_axis("pcf", width)
        .with_setting("resolution", texels)
}
