//! Lamps so near to a wall that their light falls flat on nearly all of it: `wall-lamp`.

use glam::{DAffine3, DQuat, Vec2};
use umbrage_render::Mesh;

use super::{
    Case,
    stage::{BLUE, BRICK, GREEN, GROUND, OCHRE, STONE, Stage, at, camera, vec},
};

/// The case's name, the difficulty, and the lamp's metres from the wall.
pub(super) const WALL_LAMPS: [(&str, &str, f64); 3] = [
    (
        "wall-lamp",
        "a lamp 5 cm before a wall: from 0.95 m on its light falls at more than 87° to the normal",
        0.05,
    ),
    (
        "wall-lamp-near",
        "a lamp 2 cm before a wall: from 0.38 m on its light falls at more than 87° to the normal",
        0.02,
    ),
    (
        "wall-lamp-wash",
        "a spot light down along a wall, 6 cm before it: from 1.14 m on its light falls at more than 87° to the normal",
        0.06,
    ),
];

pub(super) fn cases() -> Vec<Case> {
    WALL_LAMPS
        .into_iter()
        .map(|(name, hard, gap)| {
            let mut stage = wall();
            if name == "wall-lamp-wash" {
                stage.spot(vec(0.2, 3.3, gap), vec(0.2, 0.4, 0.0), 50.0, 12.0);
            } else {
                stage.point(vec(-0.3, 1.9, gap), 1.0, 12.0);
            }
            // Texels are as small as the casters on the wall are thin, whatever the method's maps.
            stage.case(name, hard).with_setting("resolution", 2048.0)
        })
        .collect()
}

/// A wall with the fittings of a room on it, 1 to 20 cm thick, and a floor.
fn wall() -> Stage {
    let mut stage = Stage::new(camera(vec(0.5, 1.7, 4.4), vec(0.0, 1.65, 0.0), 44.0));
    let wall = Mesh::quad(Vec2::new(9.0, 3.6), Vec2::ONE);
    stage
        .put("wall", wall, STONE, at(0.0, 1.8, 0.0))
        .ground(9.0, 6.0);
    for (name, size, color, (x, y), turn) in [
        ("frame", vec(0.7, 0.5, 0.035), BRICK, (-1.7, 2.2), 0.0),
        ("frame", vec(0.4, 0.55, 0.03), BLUE, (0.75, 2.3), 8.0),
        ("clock", vec(0.3, 0.3, 0.05), GREEN, (1.9, 1.7), 45.0),
        ("shelf", vec(0.9, 0.03, 0.2), OCHRE, (0.9, 1.05), 0.0),
        ("switch", vec(0.08, 0.08, 0.012), GROUND, (-1.2, 1.2), 0.0),
        ("rail", vec(1.2, 0.06, 0.02), BRICK, (-2.1, 0.75), 0.0),
    ] {
        let turn = DQuat::from_rotation_z(f64::to_radians(turn));
        let place = DAffine3::from_rotation_translation(turn, vec(x, y, 0.5 * size.z));
        stage.put(name, Mesh::cuboid(size.as_vec3()), color, place);
    }
    stage.ball(0.12, BLUE, vec(1.1, 1.185, 0.11));
    stage
}
