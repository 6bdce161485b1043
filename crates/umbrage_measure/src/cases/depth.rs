//! Many orders of depth in one view: `depth-range`, `split-seams`.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use umbrage_render::{Camera, Mesh};

use super::{
    Case, shapes,
    stage::{BLUE, BRICK, GREEN, GROUND, OCHRE, STONE, Stage, at, camera, vec},
};

pub(super) fn cases() -> Vec<Case> {
    vec![range(), range_spot(), seams(), seams_fence()]
}

/// Groups that look alike at 1, 10, 100 and 900 m: a screen, and a post and a ball before it, all in
/// proportion to their distance. Light from behind casts post and ball onto the screen and the
/// screen onto the ground.
fn range() -> Case {
    let mut view = camera(vec(0.0, 0.45, 0.0), vec(0.0, 0.40, -1.0), 60.0);
    (view.near, view.far) = (0.1, 1000.0);
    let mut stage = Stage::new(view);
    let ground = Mesh::plane(Vec2::new(4000.0, 2400.0), Vec2::ONE);
    stage.put("ground", ground, GROUND, at(0.0, 0.0, -1100.0));
    for (distance, x) in [(1.0, -0.72), (10.0, -0.24), (100.0, 0.24), (900.0, 0.72)] {
        group(&mut stage, vec(x * distance, 0.0, -distance), distance);
    }
    stage.sun(vec(0.5, -0.42, -0.76));
    stage.case(
        "depth-range",
        "casters and receivers from 1 to 900 m in a view from 0.1 to 1000 m: a ratio of 1e4",
    )
}

/// A screen and what stands before it, with the post's foot at `foot`; `size` is 1 for metres.
fn group(stage: &mut Stage, foot: DVec3, size: f64) {
    let part = |x: f64, y: f64, z: f64| size * vec(x, y, z);
    stage
        .block(
            "screen",
            part(0.40, 0.42, 0.02),
            STONE,
            foot + part(0.06, 0.0, -0.09),
        )
        .block(
            "post",
            part(0.05, 0.34, 0.05),
            BRICK,
            foot + part(-0.07, 0.0, 0.0),
        )
        .ball(0.055 * size, OCHRE, foot + part(0.10, 0.20, -0.02));
}

/// A cage of bars 2 to 10 cm before a spot light that reaches 100 m: its shadow lies over everything, and
/// groups stand from 3 to 80 m.
fn range_spot() -> Case {
    let light = vec(0.0, 3.0, 0.0);
    let mut view = camera(vec(-2.6, 4.2, 4.0), vec(1.0, 1.4, -12.0), 55.0);
    view.far = 200.0;
    let mut stage = Stage::new(view);
    stage.ground(300.0, 300.0);
    for (distance, x) in [(3.5, -0.30), (12.0, 0.05), (35.0, -0.22), (80.0, 0.22)] {
        group(&mut stage, vec(x * distance, 0.0, -distance), distance);
    }
    for (index, distance) in [0.02, 0.03, 0.05, 0.1].into_iter().enumerate() {
        let across = (index as f64 - 1.5) * 0.42 * distance;
        let bar = Mesh::cuboid((distance * vec(0.06, 4.0, 0.06)).as_vec3());
        stage.put("bar", bar, BLUE, at(across, light.y, -distance));
    }
    stage.spot(light, vec(0.0, 1.0, -12.0), 50.0, 100.0);
    stage.case(
        "depth-range-spot",
        "casters from 2 cm and receivers to 90 m of a spot light that reaches 100 m: a ratio of 1e4",
    )
}

/// Nearest and farthest of `seams`, metres.
pub(super) const SEAMS: (f64, f64) = (1.0, 400.0);

/// A valley whose side rises so that every row of the picture sees another depth, evenly in its logarithm:
/// wherever a scheme splits the view, the border lies across a receiver. Trees in proportion to
/// their distance shade it, all the way.
fn seams() -> Case {
    let (near, far) = SEAMS;
    let mut view = camera(DVec3::ZERO, vec(0.0, 0.0, -1.0), 60.0);
    (view.near, view.far) = (near, far);
    let mut stage = Stage::new(view);
    let slope = |distance: f64| 0.95 * ((distance / near).ln() / (far / near).ln()) - 0.55;
    let floor = |distance: f64| slope(distance) * distance;
    let ratio: f64 = 1.02;
    let mut triangles = Vec::new();
    let corner =
        |side: f64, distance: f64| vec(3.0 * side * distance, floor(distance), -distance).as_vec3();
    let mut distance = 0.7 * near;
    while distance < 1.1 * far {
        let next = distance * ratio;
        let (a, b) = (corner(-1.0, distance), corner(1.0, distance));
        let (c, d) = (corner(1.0, next), corner(-1.0, next));
        triangles.extend([[a, b, c], [a, c, d]]);
        distance = next;
    }
    stage.put("valley", shapes::flat(triangles), GROUND, at(0.0, 0.0, 0.0));
    let tree = Arc::new(shapes::tree(1.0));
    let mut distance = 0.8 * near;
    let mut index = 0;
    while distance < 1.05 * far {
        let across = [-0.85, 0.3, -0.3, 0.75, 0.0][index % 5] * distance;
        let mut place = at(across, floor(distance), -distance);
        place.matrix3 *= 0.13 * distance;
        stage.put("tree", Arc::clone(&tree), GREEN, place);
        distance *= 1.08;
        index += 1;
    }
    stage.sun(vec(0.7, -0.42, -0.55));
    stage.case(
        "split-seams",
        "a receiver, and shadow edges on it, across every border that splits the view",
    )
}

/// A fence beside a wall along the whole view: straight shadow edges that any change of map would break.
fn seams_fence() -> Case {
    let mut view = camera(vec(-0.1, 1.6, 2.0), vec(0.15, 0.9, -4.0), 55.0);
    (view.near, view.far) = (0.5, 150.0);
    let mut stage = fence(view);
    stage.sun(vec(0.9, -0.36, -0.25));
    stage.case(
        "split-seams-fence",
        "straight shadow edges along the whole view, over ground and up a wall",
    )
}

pub(super) fn fence(view: Camera) -> Stage {
    let mut stage = Stage::new(view);
    stage.ground(300.0, 400.0).block(
        "wall",
        vec(0.3, 2.2, 130.0),
        [0.36, 0.33, 0.30],
        vec(1.45, 0.0, -64.0),
    );
    for height in [0.5, 1.1] {
        let rail = Mesh::cuboid(Vec3::new(0.05, 0.09, 130.0));
        stage.put("rail", rail, BRICK, at(-1.3, height, -64.0));
    }
    let picket = Arc::new(Mesh::cuboid(Vec3::new(0.04, 1.4, 0.14)));
    for index in 0..260 {
        let z = 1.0 - 0.5 * f64::from(index);
        stage.put("picket", Arc::clone(&picket), BRICK, at(-1.3, 0.7, z));
    }
    stage
}
