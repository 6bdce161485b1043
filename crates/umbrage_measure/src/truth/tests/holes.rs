//! Surfaces with holes.

use std::sync::Arc;

use glam::DVec3;
use umbrage_render::{Image, Level, Material, Texture, Wrap};
use umbrage_shadow::LightKind;

use super::stage::{HERE, scene, square};
use crate::truth::{Source, Tracer};

/// Metres across a field of the board.
const FIELD: f64 = 0.5;

/// Whether the board is there above a point; none near a field's edge.
fn board(point: DVec3) -> Option<bool> {
    let field = (point + 2.0) / FIELD;
    let edge = (field - field.round()).abs();
    let inside = point.x.abs().max(point.z.abs()) < 2.0;
    (edge.x.min(edge.z) > 1e-6).then(|| inside && (field.x.floor() + field.z.floor()) % 2.0 == 0.0)
}

#[test]
fn light_and_sight_go_through_the_holes_of_a_chequered_board() {
    let level = Level {
        width: 8,
        height: 8,
        rgba: (0..64)
            .map(|i| {
                [
                    255,
                    255,
                    255,
                    if (i % 8 + i / 8) % 2 == 0 { 255 } else { 0 },
                ]
            })
            .collect(),
    };
    let mut board_above = HERE.object("board", square(2.0), DVec3::new(0.0, 1.0, 0.0));
    board_above.material = Arc::new(Material {
        alpha_cutoff: Some(0.5),
        base_color_texture: Some(Texture {
            image: Arc::new(Image {
                levels: vec![level],
            }),
            wrap: [Wrap::Clamp; 2],
            smooth: false,
        }),
        ..Material::plain("lambert")
    });
    let floor = HERE.object("floor", square(10.0), DVec3::ZERO);
    let sun = LightKind::Directional {
        direction: DVec3::NEG_Y,
    };
    for (eye, above) in [
        (DVec3::new(0.2, 0.7, 2.9), false),
        (DVec3::new(0.3, 3.1, 1.7), true),
    ] {
        let camera = HERE.camera(eye, DVec3::new(0.0, 0.1, 0.0), DVec3::Y);
        let scene = scene(
            vec![floor.clone(), board_above.clone()],
            sun.clone(),
            camera,
        );
        let tracer = Tracer::new(&scene).expect("a sound scene");
        let sight = tracer.look(96, 72, &|| ()).expect("a size");
        let terms = tracer.shadow(&sight, 0, Source::Sharp, &|| ());
        let (mut dark, mut through) = (0, 0);
        for (seen, term) in sight.seen().iter().zip(terms.expect("a light")) {
            let Some(seen) = seen else { continue };
            let point = eye + seen.position;
            let Some(solid) = board(point) else { continue };
            if seen.object == 1 {
                assert!(solid && term == Some(1.0), "{point}");
                continue;
            }
            assert_eq!(term, Some(if solid { 0.0 } else { 1.0 }), "{point}");
            dark += usize::from(solid);
            let crossing = eye + seen.position * ((1.0 - eye.y) / (point.y - eye.y));
            if above && crossing.x.abs().max(crossing.z.abs()) < 2.0 {
                assert_ne!(board(crossing), Some(true), "{crossing}");
                through += 1;
            }
        }
        assert!(dark > 100 && (through > 100) == above, "{dark} {through}");
    }
}
