//! Scenes of other families under a camera of parallel rays, whose pixels are as large at all depths: `orthographic`.

use umbrage_render::Camera;
use umbrage_shadow::{Field, look_along};

use super::{
    Case,
    depth::fence,
    direction::low_things,
    motion::{garden, moving},
    stage::vec,
};

pub(super) fn cases() -> Vec<Case> {
    vec![seams(), grazing(), motion()]
}

/// A camera at `eye` that looks at `target`; the picture is `height` metres high.
fn camera(eye: glam::DVec3, target: glam::DVec3, height: f64) -> Camera {
    Camera {
        position: eye,
        rotation: look_along(target - eye).unwrap_or_default(),
        field: Field::Orthographic { height },
        near: -100.0,
        far: 200.0,
    }
}

/// The fence and the wall, seen so flat that 8 m of picture show 42 m of them: from behind the camera's position to
/// equally far before it.
fn seams() -> Case {
    let mut stage = fence(camera(vec(0.4, 2.0, -30.0), vec(-0.1, 0.0, -40.0), 8.0));
    stage.sun(vec(0.9, -0.36, -0.25));
    stage.case(
        "orthographic-seams",
        "parallel rays: straight shadow edges across every border that splits the view, on both sides of the camera",
    )
}

/// The scene of `grazing-85`, in a picture as high as the perspective one is at its target.
fn grazing() -> Case {
    let angle: f64 = 85.0;
    let view = camera(vec(0.4, 2.6, 5.2), vec(0.2, 0.0, -0.4), 5.2);
    low_things(view, angle.to_radians()).case(
        "orthographic-grazing",
        "parallel rays, and light at 85° to the ground's normal: a texel stretches 11.5 times",
    )
}

/// The scene of `motion`.
fn motion() -> Case {
    let mut stage = garden(camera(vec(1.4, 2.2, 4.4), vec(0.0, 0.4, -0.6), 4.6));
    stage.sun(vec(0.55, -0.8, 0.5));
    moving(stage.case(
        "orthographic-motion",
        "parallel rays: the camera slides, then turns, less than a texel a frame",
    ))
}
