//! Too little or too much: `empty`.

use glam::{DVec3, Vec2, Vec3};
use umbrage_render::Mesh;

use super::{
    Case, shapes,
    stage::{BLUE, BRICK, GREEN, OCHRE, STONE, Stage, at, camera, scattered, turned, vec},
};

/// The cases without any shadow to see.
#[cfg(test)]
pub(super) const UNSHADOWED: [&str; 1] = ["empty-casters"];

pub(super) fn cases() -> Vec<Case> {
    vec![
        casters(),
        split(),
        giant(),
        one_texel(),
        degenerate(),
        inside(),
        head(),
    ]
}

/// A ball, a box and a cone on the ground.
fn trio(eye: DVec3) -> Stage {
    let mut stage = Stage::new(camera(eye, vec(0.0, 0.4, 0.0), 46.0));
    stage
        .ground(12.0, 12.0)
        .ball(0.6, OCHRE, vec(-1.2, 0.6, 0.3))
        .block("box", vec(0.9, 1.1, 0.9), BRICK, vec(0.3, 0.0, -0.6))
        .put("cone", shapes::cone(0.5, 1.0), BLUE, at(1.5, 0.0, 0.5));
    stage
}

fn casters() -> Case {
    let mut stage = trio(vec(1.4, 2.6, 4.8));
    stage
        .without_casters()
        .sun(vec(0.6, -1.0, -0.4))
        .spot(vec(-2.0, 4.0, 2.0), DVec3::ZERO, 40.0, 20.0)
        .point(vec(1.0, 2.5, 1.0), 2.5, 20.0);
    stage.case(
        "empty-casters",
        "nothing casts: maps without a caster, in which all is lit",
    )
}

/// Casters between 30 and 60 m alone: the splits before and behind are empty.
fn split() -> Case {
    let mut view = camera(vec(0.0, 9.0, 0.0), vec(0.0, 3.0, -40.0), 50.0);
    (view.near, view.far) = (0.5, 500.0);
    let mut stage = Stage::new(view);
    stage.ground(1000.0, 1000.0).without_casters();
    for (index, share) in scattered(14).enumerate() {
        let foot = vec(44.0 * share.x - 24.0, 0.0, -31.0 - 26.0 * share.y);
        let size = 6.0 + 0.25 * index as f32;
        stage.put(
            "tree",
            shapes::tree(size),
            GREEN,
            at(foot.x, foot.y, foot.z),
        );
    }
    stage.sun(vec(0.62, -0.6, 0.2));
    stage.case(
        "empty-split",
        "casters between 30 and 60 m alone, of a view from 0.5 to 500 m: other splits hold none",
    )
}

/// A sheet of 40 km, whose edge's shadow crosses the view.
fn giant() -> Case {
    let mut stage = trio(vec(1.4, 2.6, 4.8));
    let sun = vec(0.35, -1.0, -0.3);
    let sheet = Mesh::plane(Vec2::splat(4e4), Vec2::ONE);
    // Its edge stands where the light meets the ground a little left of the middle.
    let shift = 60.0 * vec(sun.x, 0.0, sun.z);
    let place = vec(-0.4, 60.0, 0.0) - shift + vec(-2e4, 0.0, 0.0);
    stage
        .put("sheet", sheet, STONE, turned(place, 0.0, 0.0))
        .sun(sun);
    stage.case(
        "empty-giant",
        "a caster larger than everything: a sheet of 40 km over half of the view",
    )
}

fn one_texel() -> Case {
    let mut stage = trio(vec(1.4, 2.6, 4.8));
    stage
        .sun(vec(0.6, -1.0, -0.4))
        .point(vec(-0.2, 2.6, 1.4), 2.6, 20.0);
    let case = stage.case(
        "empty-1x1",
        "maps of a single texel: no edge can be right, but no pixel may be bad",
    );
    case.with_setting("resolution", 1.0)
}

/// Among good triangles, ones without area: a corner twice, all corners one, three corners on a line.
fn degenerate() -> Case {
    let mut stage = trio(vec(1.4, 2.6, 4.8));
    let (a, b, c) = (
        Vec3::ZERO,
        Vec3::new(0.9, 0.3, 0.0),
        Vec3::new(0.1, 1.2, 0.2),
    );
    let middle = 0.5 * (a + b);
    let mesh = shapes::flat([[a, b, c], [a, a, b], [c, c, c], [a, middle, b], [a, b, a]]);
    for index in 0..5 {
        let place = turned(
            vec(f64::from(index) * 0.8 - 2.0, 0.5, 1.4),
            40.0 * f64::from(index),
            0.0,
        );
        stage.put("shard", mesh.clone(), GREEN, place);
    }
    stage
        .sun(vec(0.6, -1.0, -0.4))
        .point(vec(0.9, 2.6, 3.2), 3.0, 20.0);
    stage.case(
        "empty-degenerate",
        "triangles without area among good ones: no plane, no normal",
    )
}

/// A closed room with the viewer and a lamp in it, under a sun that cannot get in.
fn inside() -> Case {
    let mut stage = Stage::new(camera(vec(1.2, 1.6, 2.2), vec(-0.3, 0.7, -0.8), 62.0));
    stage
        .block("room", vec(6.0, 3.0, 6.0), STONE, DVec3::ZERO)
        .block(
            "room's outside",
            vec(6.4, 3.3, 6.4),
            STONE,
            vec(0.0, -0.15, 0.0),
        )
        .ball(0.5, OCHRE, vec(-0.7, 0.5, -0.6))
        .block("box", vec(0.8, 0.9, 0.8), BRICK, vec(0.9, 0.0, -1.2))
        .sun(vec(0.6, -1.0, -0.4))
        .point(vec(-0.1, 2.4, 0.6), 2.0, 12.0);
    stage.case(
        "empty-inside",
        "the viewer and a lamp inside a closed caster: the sun shades all of it",
    )
}

/// The viewer's own head: nearer than anything that is seen, and casting.
fn head() -> Case {
    let eye = vec(0.0, 1.7, 0.0);
    let mut view = camera(eye, vec(0.1, 0.0, -2.4), 56.0);
    view.near = 0.3;
    let mut stage = Stage::new(view);
    stage
        .ground(20.0, 20.0)
        .ball(0.16, OCHRE, eye)
        .block("body", vec(0.5, 1.35, 0.25), BLUE, vec(0.0, 0.0, 0.12))
        .put("cone", shapes::cone(0.3, 0.7), BRICK, at(1.1, 0.0, -2.2))
        .sun(vec(-0.1, -0.7, -0.95));
    stage.case(
        "empty-head",
        "the camera inside a closed caster that it does not see: the shadow of the viewer's own head",
    )
}
