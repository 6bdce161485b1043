//! A camera that moves less than a texel a frame: `motion`.

use std::sync::Arc;

use glam::{DQuat, DVec3, Vec3};
use umbrage_render::{Camera, Mesh};

use super::{
    Case, shapes,
    stage::{BRICK, GREEN, OCHRE, Stage, at, camera, vec},
};

/// Frames of each of the two motions.
const HALF: usize = 32;
/// From frame to frame; no axis of the world's or of the camera's, so that all phases are met. Metres.
const STEP: DVec3 = DVec3::new(0.0021, 0.0007, -0.0013);
/// From frame to frame, about the vertical; radians.
const TURN: f64 = 2e-4;

pub(super) fn cases() -> Vec<Case> {
    vec![sun(), lamps()]
}

pub(super) fn garden(view: Camera) -> Stage {
    let mut stage = Stage::new(view);
    stage
        .ground(16.0, 16.0)
        .put("tree", shapes::tree(2.0), GREEN, at(1.5, 0.0, -1.6))
        .ball(0.45, OCHRE, vec(0.9, 0.45, 0.6));
    let picket = Arc::new(Mesh::cuboid(Vec3::new(0.09, 0.9, 0.03)));
    for index in 0..16 {
        let place = at(-2.6 + 0.2 * f64::from(index), 0.45, -0.7);
        stage.put("picket", Arc::clone(&picket), BRICK, place);
    }
    stage
}

fn view() -> Camera {
    Camera {
        far: 60.0,
        ..camera(vec(1.4, 2.2, 4.4), vec(0.0, 0.4, -0.6), 50.0)
    }
}

fn sun() -> Case {
    let mut stage = garden(view());
    stage.sun(vec(0.55, -0.8, 0.5));
    moving(stage.case(
        "motion",
        "the camera slides, then turns, less than a texel a frame: edges of a map that follows shimmer",
    ))
}

fn lamps() -> Case {
    let mut stage = garden(view());
    stage
        .spot(vec(-2.6, 3.2, -3.4), vec(-0.6, 0.0, 0.4), 36.0, 16.0)
        .point(vec(2.6, 1.8, -2.8), 3.0, 16.0);
    let case = stage.case(
        "motion-lamps",
        "the same under a spot light, whose map may follow the view, and a lamp, whose map may not",
    );
    // Texels of 6 to 8 mm at the target and 3 m from the lamp, as the sun has; and 64 times six sides are a quarter
    // of the work.
    moving(case.with_setting("resolution", 1024.0))
}

pub(super) fn moving(case: Case) -> Case {
    let start = case.scene.camera;
    let slid = |frame: usize| Camera {
        position: start.position + frame as f64 * STEP,
        ..start
    };
    let last = slid(HALF - 1);
    let turned = |frame: usize| Camera {
        rotation: DQuat::from_rotation_y((frame + 1) as f64 * TURN) * last.rotation,
        ..last
    };
    Case {
        frames: (0..HALF).map(slid).chain((0..HALF).map(turned)).collect(),
        size: (128, 72),
        ..case
    }
}
