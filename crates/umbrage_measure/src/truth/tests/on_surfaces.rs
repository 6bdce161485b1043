//! Lamps that lie on what casts, or next to it.

use glam::{DAffine3, DQuat, DVec3};
use umbrage_render::{Mesh, Object, Scene};
use umbrage_shadow::LightKind;

use super::stage::{HERE, Place, ball, block, scene, square};
use crate::truth::{Sight, Source, Tracer};

/// Here, far out, tiny and huge.
const PLACES: [Place; 5] = [
    HERE,
    Place {
        origin: DVec3::new(1e6, -7e5, 3e5),
        scale: 1.0,
    },
    Place {
        origin: DVec3::new(0.1, 0.7, -0.3),
        scale: 1e-3,
    },
    Place {
        origin: DVec3::new(0.1, 0.7, -0.3),
        scale: 1e4,
    },
    Place {
        origin: DVec3::new(1e6, -7e5, 3e5),
        scale: 1e4,
    },
];

const SIZE: (u32, u32) = (64, 48);

fn lamp(place: Place, at: DVec3) -> LightKind {
    LightKind::Point {
        position: place.at(at),
        range: 1000.0 * place.scale,
    }
}

/// An object that is turned before it is put somewhere.
fn turned(place: Place, name: &str, mesh: Mesh, turn: DQuat, at: DVec3) -> Object {
    let mut object = place.object(name, mesh, at);
    object.transform = DAffine3::from_scale_rotation_translation(
        DVec3::splat(place.scale),
        turn,
        object.transform.translation,
    );
    object.bounds = object.mesh.bounds(&object.transform);
    object
}

/// The object, the point (in the scene's own coordinates) and the shadow term, of `source`, that each pixel sees.
fn terms_of(place: Place, scene: &Scene, source: Source) -> Vec<(usize, DVec3, Option<f32>)> {
    let tracer = Tracer::new(scene).expect("a sound scene");
    let sight = tracer.look(SIZE.0, SIZE.1, &|| ()).expect("a size");
    let terms = tracer.shadow(&sight, 0, source, &|| ()).expect("a light");
    if source == Source::Sharp {
        gaps_agree(&tracer, &sight, &terms);
    }
    let seen = sight.seen().iter().zip(terms);
    let eye = (scene.camera.position - place.origin) / place.scale;
    seen.filter_map(|(seen, term)| {
        let seen = (*seen)?;
        let point = eye + seen.position / place.scale;
        Some((seen.object as usize, point, term))
    })
    .collect()
}

fn gaps_agree(tracer: &Tracer, sight: &Sight, terms: &[Option<f32>]) {
    let gaps = tracer.gaps(sight, 0, &|| ()).expect("a light");
    for (gap, term) in gaps.iter().zip(terms) {
        assert_eq!(gap.is_some(), *term == Some(0.0), "{gap:?} {term:?}");
    }
}

/// A floor under a ceiling that is turned about (0, `height`, 0), seen from between the two; object 0 is the floor.
fn under_a_ceiling(place: Place, height: f64, turn: DQuat, light: LightKind) -> Scene {
    let camera = place.camera(DVec3::new(2.5, 1.5, 2.5), DVec3::ZERO, DVec3::Y);
    let middle = DVec3::Y * height;
    let objects = vec![
        place.object("floor", square(8.0), DVec3::ZERO),
        turned(place, "ceiling", square(9.0), turn, middle),
    ];
    scene(objects, light, camera)
}

fn turns() -> [DQuat; 4] {
    [
        DQuat::IDENTITY,
        DQuat::from_rotation_x(std::f64::consts::PI),
        DQuat::from_rotation_z(0.3),
        DQuat::from_rotation_x(-0.21) * DQuat::from_rotation_y(0.77),
    ]
}

#[test]
fn a_lamp_in_a_ceiling_shines_on_the_floor() {
    for place in PLACES {
        for (turn, height) in turns()
            .into_iter()
            .flat_map(|turn| [3.0, 2.9, 3.1].map(|height| (turn, height)))
        {
            for on in [DVec3::ZERO, DVec3::new(0.3, 0.0, -0.7)] {
                let at = DVec3::Y * height + turn * on;
                let light = lamp(place, at);
                let seen = terms_of(
                    place,
                    &under_a_ceiling(place, height, turn, light),
                    Source::Sharp,
                );
                assert!(seen.len() > 2000);
                for (object, point, term) in seen {
                    // The ceiling, which the lamp lies on, is neither lit nor in shadow.
                    let expected = (object == 0).then_some(1.0);
                    assert_eq!(term, expected, "{point} of {object}, {at}");
                }
            }
        }
    }
}

/// From above as well: it is not the lamp that has a side.
#[test]
fn a_lamp_in_a_sheet_shines_to_both_sides() {
    for place in PLACES {
        let at = DVec3::new(0.2, 2.9, 0.1);
        let objects = vec![
            place.object("roof", square(8.0), DVec3::Y * 6.0),
            place.object("sheet", square(3.0), DVec3::Y * 2.9),
        ];
        let camera = place.camera(DVec3::new(1.0, 4.0, 2.0), DVec3::Y * 6.0, DVec3::Z);
        let seen = terms_of(
            place,
            &scene(objects, lamp(place, at), camera),
            Source::Sharp,
        );
        let roof: Vec<_> = seen.iter().filter(|(object, ..)| *object == 0).collect();
        assert!(roof.len() > 2000 && roof.iter().all(|(.., term)| *term == Some(1.0)));
    }
}

/// A lamp one step of f64 beside the ceiling counts as on it; a lamp a trillionth of the scene's coordinates beside it
/// is on one side. Neither gives noise.
#[test]
fn a_hair_decides_or_does_not() {
    for place in PLACES {
        let floor = |height: f64| {
            let position = place.at(DVec3::new(0.3, 0.0, -0.7)).with_y(height);
            let light = LightKind::Point {
                position,
                range: 1000.0 * place.scale,
            };
            let scene = under_a_ceiling(place, 3.0, DQuat::IDENTITY, light);
            let seen = terms_of(place, &scene, Source::Sharp);
            let floor = seen.into_iter().filter(|(object, ..)| *object == 0);
            let terms: Vec<_> = floor.map(|(.., term)| term).collect();
            assert!(terms.len() > 2000);
            assert!(terms.iter().all(|term| *term == terms[0]), "noise");
            terms[0]
        };
        let on = place.at(3.0 * DVec3::Y).y;
        let hair = 1e-12 * place.origin.length().max(3.0 * place.scale);
        assert_eq!(floor(on), Some(1.0));
        assert_eq!(floor(on.next_down()), Some(1.0));
        assert_eq!(floor(on.next_up()), Some(1.0));
        assert_eq!(floor(on - hair), Some(1.0), "{hair}");
        assert_eq!(floor(on + hair), Some(0.0), "{hair}");
    }
}

/// A box on a floor with a lamp on it, given as decimal numbers, which f32 corners only come near to. A point of the
/// floor is in shadow where the way from the lamp to it leads into the box.
#[test]
fn a_lamp_on_a_box_shines_past_it() {
    let half = DVec3::new(0.5, 0.75, 0.4);
    let (top, shift) = (1.5, DVec3::new(0.1, 0.0, -0.3));
    // On a side, on a lower edge of the front, on an upper one, on corners, and inside.
    for on in [
        DVec3::new(half.x, 0.7, 0.1),
        DVec3::new(half.x, 0.7, half.z),
        DVec3::new(0.1, top, half.z),
        DVec3::new(half.x, top, half.z),
        DVec3::new(-half.x, top, half.z),
        DVec3::new(0.1, top, 0.1),
        DVec3::new(0.1, 0.7, -0.1),
    ] {
        for place in PLACES {
            let light = lamp(place, on + shift);
            let middle = DVec3::Y * half.y + shift;
            let objects = vec![
                place.object("floor", square(10.0), DVec3::ZERO),
                place.object("box", block(half.as_vec3()), middle),
            ];
            let camera = place.camera(DVec3::new(3.2, 3.4, 2.9), DVec3::ZERO, DVec3::Y);
            let seen = terms_of(place, &scene(objects, light, camera), Source::Sharp);
            let mut floor = 0;
            for (object, point, term) in seen {
                let way = point - shift - on;
                // Into the box from where the lamp lies, along each axis.
                let enters = |axis: usize| {
                    let side = on[axis] - DVec3::new(0.0, half.y, 0.0)[axis];
                    side.abs() < half[axis] - 1e-9 || way[axis] * side < 0.0
                };
                let near = (0..3).any(|axis| way[axis].abs() < 1e-6);
                if object != 0 || near {
                    continue;
                }
                let dark = (0..3).all(enters);
                assert_eq!(term, Some(f32::from(u8::from(!dark))), "{on}: {point}");
                floor += 1;
            }
            assert!(floor > 1500, "{floor}");
        }
    }
}

/// A lamp on a vertex where many faces meet is as one on a box's corner; from inside of a ball, nothing is lit.
#[test]
fn a_lamp_on_a_ball_or_in_it() {
    for place in PLACES {
        let middle = DVec3::new(0.1, 1.3, 0.2);
        let mesh = ball(1.0, 64);
        // A corner of the mesh, as the transform gives it.
        let corner = mesh.positions[65 * 12 + 9].as_dvec3();
        for (on, inside) in [(corner, false), (0.5 * corner, true)] {
            let light = lamp(place, middle + on);
            let objects = vec![
                place.object("floor", square(10.0), DVec3::ZERO),
                place.object("ball", mesh.clone(), middle),
            ];
            let camera = place.camera(DVec3::new(0.5, 5.0, 4.5), DVec3::ZERO, DVec3::Y);
            let seen = terms_of(place, &scene(objects, light, camera), Source::Sharp);
            let mut counts = [0; 2];
            for (object, point, term) in seen {
                let rise = (point - middle - on).normalize().dot(on);
                // Facets turn by 5.6° from one to the next.
                if object != 0 || (!inside && rise.abs() < 0.1) {
                    continue;
                }
                let lit = !inside && rise > 0.0;
                assert_eq!(term, Some(f32::from(u8::from(lit))), "{point} {rise}");
                counts[usize::from(lit)] += 1;
            }
            assert!(counts[0] > 100 && (inside || counts[1] > 100), "{counts:?}");
        }
    }
}

/// A spot light whose apex lies in the ceiling, and one whose apex lies in the floor that it shines along.
#[test]
fn a_spot_lights_apex_on_a_surface() {
    for place in PLACES {
        for turn in turns() {
            let apex = DVec3::Y * 3.1 + turn * DVec3::new(0.3, 0.0, -0.7);
            let (direction, outer_angle) = (DVec3::new(0.1, -1.0, 0.2).normalize(), 0.6);
            let light = LightKind::Spot {
                position: place.at(apex),
                direction,
                inner_angle: 0.2,
                outer_angle,
                range: 1000.0 * place.scale,
            };
            let scene = under_a_ceiling(place, 3.1, turn, light);
            let (mut lit, mut beside) = (0, 0);
            for (object, point, term) in terms_of(place, &scene, Source::Sharp) {
                let angle = (point - apex).angle_between(direction);
                if object != 0 || (angle - outer_angle).abs() < 1e-6 {
                    continue;
                }
                let inside = angle < outer_angle;
                assert_eq!(term, inside.then_some(1.0), "{point}");
                lit += usize::from(inside);
                beside += usize::from(!inside);
            }
            assert!(lit > 100 && beside > 100, "{lit} {beside}");
        }
    }
}

#[test]
fn a_ball_of_light_that_touches_the_ceiling_is_whole() {
    let radius = 0.4;
    for place in PLACES {
        for turn in turns() {
            let below = turn * DVec3::NEG_Y;
            let below = below * -below.y.signum();
            let light = lamp(place, 3.0 * DVec3::Y + radius * below);
            let scene = under_a_ceiling(place, 3.0, turn, light);
            let source = Source::Round {
                size: radius * place.scale,
                strata: 4,
            };
            let seen = terms_of(place, &scene, source);
            let floor = seen.iter().filter(|(object, ..)| *object == 0);
            assert!(floor.clone().count() > 2000);
            for (_, point, term) in floor {
                assert_eq!(*term, Some(1.0), "{point}");
            }
        }
    }
}

/// A small ball of light whose middle lies in the ceiling: what of it hangs out is a half moon, (1 + cos γ) / 2 of it
/// at the angle γ between the way down and the way to the floor's point.
#[test]
fn a_ball_of_light_in_the_ceiling_is_half_a_moon() {
    const STRATA: u32 = 16;
    let radius = 0.02;
    for place in PLACES {
        for turn in turns() {
            let middle = 3.0 * DVec3::Y + turn * DVec3::new(0.3, 0.0, -0.7);
            let down = turn * DVec3::NEG_Y;
            let down = down * -down.y.signum();
            let scene = under_a_ceiling(place, 3.0, turn, lamp(place, middle));
            let source = Source::Round {
                size: radius * place.scale,
                strata: STRATA,
            };
            let mut floor = 0;
            for (object, point, term) in terms_of(place, &scene, source) {
                if object != 0 {
                    continue;
                }
                let expected = 0.5 + 0.5 * (point - middle).normalize().dot(down);
                let term = f64::from(term.expect("the floor is lit"));
                // The edge runs through a part of each column and row; and the ball is not infinitely small.
                let margin = 2.0 / f64::from(STRATA) + 2.0 * radius;
                assert!((term - expected).abs() < margin, "{term} {expected}");
                floor += 1;
            }
            assert!(floor > 2000);
        }
    }
}

/// The air on both sides of a sheet that a lamp lies in is lit.
#[test]
fn the_air_about_a_lamp_in_a_sheet_is_lit() {
    let at = DVec3::new(0.2, 2.9, 0.1);
    for place in PLACES {
        let scene = under_a_ceiling(place, 2.9, DQuat::IDENTITY, lamp(place, at));
        let tracer = Tracer::new(&scene).expect("a sound scene");
        let eye = scene.camera.position;
        for offset in [
            DVec3::NEG_Y,
            DVec3::Y,
            DVec3::new(1.0, -0.01, 2.0),
            DVec3::new(0.5, 1e-3, -1.0),
        ] {
            let point = place.at(at + offset) - eye;
            assert_eq!(tracer.arrives(point, 0), Ok(true), "{offset}");
        }
    }
}

/// Surfaces that a lamp does not lie on shade as usual, even a micrometre away.
#[test]
fn what_is_next_to_a_lamp_shades() {
    let scene = |gap: f64| {
        let objects = vec![
            HERE.object("floor", square(8.0), DVec3::ZERO),
            HERE.object("plate", square(0.01), DVec3::Y * (3.0 - gap)),
        ];
        let camera = HERE.camera(DVec3::new(2.5, 1.5, 2.5), DVec3::ZERO, DVec3::Y);
        super::stage::scene(objects, lamp(HERE, 3.0 * DVec3::Y), camera)
    };
    for gap in [1e-3, 1e-6, 1e-9] {
        let seen = terms_of(HERE, &scene(gap), Source::Sharp);
        // The plate is 1 cm to each side of the lamp: it shades what lies within its reach.
        let reach = 0.01 * 3.0 / gap;
        for (object, point, term) in seen {
            let far = point.x.abs().max(point.z.abs());
            if object == 0 && (far - reach).abs() > 0.05 {
                assert_eq!(
                    term,
                    Some(f32::from(u8::from(far > reach))),
                    "{gap} {point}"
                );
            }
        }
    }
}
