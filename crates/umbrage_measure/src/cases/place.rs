//! One scene, far out, tiny and huge: `far-away`, `tiny`, `huge`.

use glam::DVec3;

use super::{
    Case, shapes,
    stage::{BLUE, BRICK, OCHRE, STONE, Stage, at, camera, turned, vec},
};

/// The case that the others must look like.
const ORIGIN: &str = "far-away-origin";

pub(super) fn cases() -> Vec<Case> {
    let yard = yard();
    let twin = |case: Case| Case {
        same_as: Some(ORIGIN),
        ..case
    };
    // To all sides alike, so that no axis keeps its digits.
    let out = vec(1.0, -0.7, 0.9);
    vec![
        yard.case(ORIGIN, "nothing: the yard that the others must look like"),
        twin(yard.moved(1e5 * out).case(
            "far-away-1e5",
            "the yard 100 km out, where f32 positions are 7.8 mm apart",
        )),
        twin(yard.moved(1e6 * out).case(
            "far-away-1e6",
            "the yard 1000 km out, where f32 positions are 62.5 mm apart",
        )),
        twin(
            yard.scaled(1e-3)
                .case("tiny", "the yard at a thousandth of its size"),
        ),
        twin(
            yard.scaled(1e4)
                .case("huge", "the yard at ten thousand times its size"),
        ),
    ]
}

/// A corner of a yard under a sun, a spot light and a lamp.
fn yard() -> Stage {
    let mut view = camera(vec(3.4, 2.7, 4.8), vec(-0.2, 0.6, -0.4), 46.0);
    (view.near, view.far) = (0.1, 60.0);
    let mut stage = Stage::new(view);
    stage
        .ground(9.0, 9.0)
        .block("wall", vec(6.0, 1.6, 0.2), STONE, vec(-0.4, 0.0, -2.2))
        .ball(0.5, OCHRE, vec(0.5, 0.5, 0.4))
        .put("cone", shapes::cone(0.45, 1.0), BLUE, at(-0.9, 0.0, -0.7))
        .put(
            "ring",
            shapes::torus(0.42, 0.16),
            BRICK,
            turned(vec(-1.5, 0.5, 1.0), 25.0, 80.0),
        )
        .block("post", vec(0.12, 1.9, 0.12), BRICK, vec(1.7, 0.0, -1.0));
    stage
        .sun(vec(0.95, -1.0, 0.1))
        .spot(vec(3.0, 2.4, 0.4), DVec3::ZERO, 34.0, 12.0)
        .point(vec(-1.9, 1.3, -0.6), 1.6, 9.0);
    stage
}
