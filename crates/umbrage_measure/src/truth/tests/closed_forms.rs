//! Shadows that can be written down.

use glam::{DVec3, Vec3};
use umbrage_shadow::LightKind;

use super::stage::{HERE, Place, ball, block, scene, square};
use crate::truth::{Sight, Source, Tracer};

const RADIUS: f64 = 1.0;
const CENTRE: DVec3 = DVec3::new(0.3, 2.1, -0.2);

fn traced(scene: &umbrage_render::Scene, width: u32, height: u32) -> (Sight, Vec<Option<f32>>) {
    let tracer = Tracer::new(scene).expect("a sound scene");
    let sight = tracer.look(width, height, &|| ()).expect("a size");
    let terms = tracer
        .shadow(&sight, 0, Source::Sharp, &|| ())
        .expect("a light");
    (sight, terms)
}

/// A ball above a floor under a sun, seen from above: each pixel of the floor that is farther than a
/// pixel from the ellipse's edge, and each facet of the ball, is as it must be.
fn sun_over_a_ball(place: Place) -> Vec<Option<f32>> {
    let direction = DVec3::new(0.6, -1.0, 0.35).normalize();
    let objects = vec![
        place.object("floor", square(20.0), DVec3::ZERO),
        place.object("ball", ball(RADIUS as f32, 512), CENTRE),
    ];
    let eye = DVec3::new(1.1, 9.7, 0.4);
    let camera = place.camera(eye, DVec3::new(1.1, 0.0, 0.4), DVec3::NEG_Z);
    let scene = scene(objects, LightKind::Directional { direction }, camera);
    let size = 128;
    let (sight, terms) = traced(&scene, size, size);
    let pixel = 2.0 * eye.y * 30_f64.to_radians().tan() / f64::from(size);
    let mut counts = [0; 3];
    for (seen, term) in sight.seen().iter().zip(&terms) {
        let seen = seen.expect("the floor is everywhere");
        let point = eye + seen.position / place.scale;
        let lit = if seen.object == 0 {
            assert!(point.y.abs() < 1e-9, "{point}");
            let offset = point - CENTRE;
            let aside = offset.reject_from_normalized(direction).length();
            if (aside - RADIUS).abs() <= pixel {
                counts[2] += 1;
                continue;
            }
            aside > RADIUS
        } else {
            // The ball is convex: a facet is lit where it faces the light.
            let mesh = &scene.objects[1].mesh;
            let first = 3 * seen.triangle as usize;
            let [a, b, c] =
                [0, 1, 2].map(|i| mesh.positions[mesh.indices[first + i] as usize].as_dvec3());
            (b - a).cross(c - a).dot(direction) < 0.0
        };
        assert_eq!(
            *term,
            Some(f32::from(u8::from(lit))),
            "{point} of {}",
            seen.object
        );
        counts[usize::from(lit)] += 1;
    }
    let [dark, lit, edge] = counts;
    assert!(dark > 300 && lit > 10_000 && edge < 400, "{counts:?}");
    terms
}

#[test]
fn a_ball_in_the_sun_throws_an_ellipse() {
    sun_over_a_ball(HERE);
}

#[test]
fn far_away_is_as_here() {
    let here = sun_over_a_ball(HERE);
    for far in [1e5, 1e6] {
        let origin = DVec3::new(far, -0.5 * far, far);
        let place = Place { origin, scale: 1.0 };
        assert_eq!(sun_over_a_ball(place), here, "{far} m out");
    }
}

#[test]
fn tiny_and_huge_are_as_here() {
    let here = sun_over_a_ball(HERE);
    for scale in [1e-3, 1e4] {
        let origin = DVec3::ZERO;
        let place = Place { origin, scale };
        assert_eq!(sun_over_a_ball(place), here, "scale {scale}");
    }
}

const HALF: DVec3 = DVec3::new(0.5, 0.75, 0.4);
const BULB: DVec3 = DVec3::new(-1.3, 4.0, 1.1);

/// Whether the way from a point on the floor to the lamp leads through the box that stands on it.
fn behind_the_box(point: DVec3) -> bool {
    let way = BULB - point;
    let (low, high) = (
        DVec3::new(-HALF.x, 0.0, -HALF.z),
        DVec3::new(HALF.x, 2.0 * HALF.y, HALF.z),
    );
    let (a, b) = ((low - point) / way, (high - point) / way);
    a.min(b).max_element() < b.max_element().min(a.max(b).min_element())
}

/// A box on a floor under a lamp: every pixel of the floor that is a micrometre from the edge, and
/// every pixel of the box, which is convex. Gives how many are dark, and how many not reached.
fn lamp_over_a_box(light: LightKind, reached: impl Fn(DVec3) -> bool) -> (usize, usize) {
    let objects = vec![
        HERE.object("floor", square(10.0), DVec3::ZERO),
        HERE.object("box", block(HALF.as_vec3()), DVec3::new(0.0, HALF.y, 0.0)),
    ];
    let eye = DVec3::new(3.2, 3.4, 2.9);
    let camera = HERE.camera(eye, DVec3::new(0.3, 0.3, 0.0), DVec3::Y);
    let (sight, terms) = traced(&scene(objects, light, camera), 160, 120);
    let (mut dark, mut unreached) = (0, 0);
    for (seen, term) in sight.seen().iter().zip(&terms) {
        let Some(seen) = seen else {
            assert_eq!(*term, None);
            continue;
        };
        let point = eye + seen.position;
        if !reached(point) {
            assert_eq!(*term, None, "{point}");
            unreached += 1;
            continue;
        }
        let lit = if seen.object == 0 {
            let near = [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z];
            let shadow = behind_the_box(point);
            if near
                .iter()
                .any(|n| behind_the_box(point + 1e-6 * n) != shadow)
            {
                continue;
            }
            !shadow
        } else {
            let [right, _, front] = [0, 1, 2].map(|i| {
                let local = (point - DVec3::new(0.0, HALF.y, 0.0)) / HALF;
                local[i] > 1.0 - 1e-9
            });
            // Of the sides that the camera sees, the lamp faces the top and the front.
            front || !right
        };
        assert_eq!(
            *term,
            Some(f32::from(u8::from(lit))),
            "{point} of {}",
            seen.object
        );
        dark += usize::from(!lit);
    }
    (dark, unreached)
}

#[test]
fn a_box_on_a_floor_under_a_bulb() {
    let range = 6.0;
    let light = LightKind::Point {
        position: BULB,
        range,
    };
    let (dark, unreached) = lamp_over_a_box(light, |point| point.distance(BULB) < range);
    assert!(dark > 500 && unreached > 500, "{dark} {unreached}");
}

#[test]
fn a_box_on_a_floor_under_a_spot_light() {
    let direction = (DVec3::new(0.1, 0.2, 0.0) - BULB).normalize();
    let (outer_angle, range) = (0.35, 20.0);
    let light = LightKind::Spot {
        position: BULB,
        direction,
        inner_angle: 0.2,
        outer_angle,
        range,
    };
    let reached = |point: DVec3| (point - BULB).angle_between(direction) < outer_angle;
    let (dark, unreached) = lamp_over_a_box(light, reached);
    assert!(dark > 500 && unreached > 500, "{dark} {unreached}");
}

#[test]
fn triangles_that_share_an_edge_do_not_shade_each_other() {
    // The square's diagonal runs through the centres of the picture's diagonal.
    for place in [1e-3, 1.0, 1e4].map(|scale| Place {
        origin: DVec3::new(0.1, 0.7, -0.3),
        scale,
    }) {
        for towards in [DVec3::new(0.7, -0.1, 0.7), DVec3::new(3.0, -0.01, -1.0)] {
            let direction = towards.normalize();
            let camera = place.camera(DVec3::new(0.0, 3.3, 0.0), DVec3::ZERO, DVec3::NEG_Z);
            let floor = place.object("floor", square(4.0), DVec3::ZERO);
            let (_, terms) = traced(
                &scene(vec![floor], LightKind::Directional { direction }, camera),
                64,
                64,
            );
            assert_eq!(terms, [Some(1.0); 64 * 64]);
        }
    }
}

#[test]
fn what_does_not_cast_is_seen_and_throws_no_shadow() {
    let block = HERE.object("box", block(Vec3::ONE), DVec3::new(0.0, 2.0, 0.0));
    let floor = HERE.object("floor", square(10.0), DVec3::ZERO);
    let camera = HERE.camera(DVec3::new(0.0, 6.0, 6.0), DVec3::ZERO, DVec3::Y);
    let direction = DVec3::new(1.0, -1.0, 0.5).normalize();
    let mut scene = scene(
        vec![floor, block],
        LightKind::Directional { direction },
        camera,
    );
    let dark = |scene: &_| {
        let (sight, terms) = traced(scene, 40, 30);
        assert!(sight.seen().iter().flatten().any(|seen| seen.object == 1));
        let floor = sight.seen().iter().zip(terms);
        floor
            .filter(|(seen, term)| seen.is_some_and(|s| s.object == 0) && *term == Some(0.0))
            .count()
    };
    assert!(dark(&scene) > 20);
    let mut material = (*scene.objects[1].material).clone();
    material.casts = false;
    scene.objects[1].material = material.into();
    assert_eq!(dark(&scene), 0);
}

/// A sun that shines along the walls of a box: the floor has the box's shadow, its back is dark, its top lit;
/// the walls that it runs along are neither, however they are turned in the world.
#[test]
fn what_the_light_runs_along_is_neither_lit_nor_in_shadow() {
    let direction = DVec3::new(0.0, -1.0, -1.0).normalize();
    let objects = vec![
        HERE.object("floor", square(9.0), DVec3::ZERO),
        HERE.object("box", block(Vec3::new(0.5, 1.0, 0.5)), DVec3::Y),
    ];
    let camera = HERE.camera(DVec3::new(3.0, 4.0, 3.5), DVec3::Y, DVec3::Y);
    let scene = scene(objects, LightKind::Directional { direction }, camera);
    let (sight, terms) = traced(&scene, 128, 128);
    let (mut along, mut others) = (0, 0);
    for (seen, term) in sight.seen().iter().zip(&terms) {
        let Some(seen) = seen else { continue };
        let point = seen.position + scene.camera.position;
        // The walls at x = ±½, away from their edges.
        let wall = seen.object == 1 && (point.x.abs() - 0.5).abs() < 1e-9;
        if wall && (point.z.abs() < 0.49) && point.y < 1.99 {
            assert_eq!(*term, None, "{point}");
            along += 1;
        } else if seen.object == 1 && (point.y - 2.0).abs() < 1e-9 {
            assert_eq!(*term, Some(1.0), "{point}");
            others += 1;
        } else if seen.object == 0 {
            assert!(term.is_some(), "{point}");
        }
    }
    assert!(along > 200 && others > 100, "{along} {others}");
}
