//! How far what keeps the light off is from what it shades.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use umbrage_render::{Material, Object, Scene};
use umbrage_shadow::LightKind;

use super::stage::{HERE, Place, ball, block, scene, square};
use crate::truth::{Seen, Source, Tracer};

const EYE: DVec3 = DVec3::new(1.1, 9.7, 0.4);

/// Every pixel's gap and what it sees; there must be a gap where the shadow term is 0 and nowhere else.
fn gaps(scene: &Scene, light: usize) -> Vec<(Seen, Option<f64>)> {
    let tracer = Tracer::new(scene).expect("a sound scene");
    let sight = tracer.look(96, 96, &|| ()).expect("a size");
    let terms = tracer
        .shadow(&sight, light, Source::Sharp, &|| ())
        .expect("a light");
    let gaps = tracer.gaps(&sight, light, &|| ()).expect("a light");
    for (term, gap) in terms.iter().zip(&gaps) {
        assert_eq!(*term == Some(0.0), gap.is_some());
        assert!(gap.is_none_or(|gap| gap > 0.0));
    }
    let seen = sight.seen().iter().zip(gaps);
    seen.filter_map(|(seen, gap)| Some(((*seen)?, gap)))
        .collect()
}

fn from_above(place: Place, objects: Vec<Object>, light: LightKind) -> Scene {
    let camera = place.camera(EYE, DVec3::new(1.1, 0.0, 0.4), DVec3::NEG_Z);
    scene(objects, light, camera)
}

/// Under a ball, a ray meets the sphere at −o·d − √((o·d)² − |o|² + r²), o from its centre; the mesh
/// lies inside the sphere, by r (1 − cos²(π / 512)) at the most across, and more along the ray.
#[test]
fn under_a_ball_the_gap_ends_at_its_near_side() {
    let (radius, centre) = (1.0, DVec3::new(0.3, 2.1, -0.2));
    let direction = DVec3::new(0.6, -1.0, 0.35).normalize();
    for scale in [1e-3, 1.0, 1e4] {
        let origin = DVec3::new(1e4, 0.0, 3.0) * scale;
        let place = Place { origin, scale };
        let objects = vec![
            place.object("floor", square(20.0), DVec3::ZERO),
            place.object("ball", ball(radius as f32, 512), centre),
        ];
        let scene = from_above(place, objects, LightKind::Directional { direction });
        let mut dark = 0;
        for (seen, gap) in gaps(&scene, 0).into_iter().filter(|(s, _)| s.object == 0) {
            let offset = EYE + seen.position / scale - centre;
            let along = offset.dot(-direction);
            let room = along * along - offset.length_squared() + radius * radius;
            // Where the ray grazes the sphere, the mesh beneath it is farther along than it is deep.
            if room < 0.1 {
                continue;
            }
            let gap = gap.expect("in the shadow") / scale;
            let expected = -along - room.sqrt();
            assert!((gap - expected).abs() < 3e-4, "{gap} for {expected}");
            dark += 1;
        }
        assert!(dark > 100, "{dark}");
    }
}

/// Of a lamp and a block on the floor, the gap is the way to the block's nearest face, in metres.
#[test]
fn behind_a_block_the_gap_ends_at_its_back() {
    let half = DVec3::new(0.5, 0.75, 0.375);
    let bulb = DVec3::new(-1.3, 4.0, 1.1);
    let objects = vec![
        HERE.object("floor", square(10.0), DVec3::ZERO),
        HERE.object("box", block(half.as_vec3()), DVec3::new(0.0, half.y, 0.0)),
    ];
    let light = LightKind::Point {
        position: bulb,
        range: 40.0,
    };
    let (low, high) = (
        DVec3::new(-half.x, 0.0, -half.z),
        DVec3::new(half.x, 2.0 * half.y, half.z),
    );
    let mut dark = 0;
    for (seen, gap) in gaps(&from_above(HERE, objects, light), 0) {
        let point = EYE + seen.position;
        let way = bulb - point;
        let (a, b) = ((low - point) / way, (high - point) / way);
        let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
        // On the floor, and not where rounding decides.
        if seen.object != 0 || (leave - enter).abs() < 1e-6 || enter.abs() < 1e-6 {
            continue;
        }
        let expected = (enter < leave).then(|| enter * way.length());
        assert_eq!(gap.is_some(), expected.is_some(), "{point}");
        if let (Some(gap), Some(expected)) = (gap, expected) {
            assert!((gap - expected).abs() < 1e-9, "{gap} for {expected}");
            dark += 1;
        }
    }
    assert!(dark > 100, "{dark}");
}

/// An object that casts no shadow, or has a hole there, is in no one's way; what stands behind it is.
#[test]
fn a_gap_leads_through_what_does_not_cast() {
    let light = LightKind::Directional {
        direction: DVec3::NEG_Y,
    };
    let mut ghost = HERE.object("ghost", square(2.0), DVec3::new(0.0, 0.5, 0.0));
    let mut glass = HERE.object("glass", square(2.0), DVec3::new(0.0, 1.0, 0.0));
    let lid = HERE.object("lid", block(Vec3::splat(0.5)), DVec3::new(0.0, 2.5, 0.0));
    ghost.material = Arc::new(Material {
        casts: false,
        ..Material::plain("lambert")
    });
    let mut clear = Material::plain("lambert");
    clear.alpha_cutoff = Some(0.5);
    clear.base_color.w = 0.25;
    glass.material = Arc::new(clear);
    let floor = HERE.object("floor", square(10.0), DVec3::ZERO);
    let scene = from_above(HERE, vec![floor, ghost, glass, lid], light);
    let below = gaps(&scene, 0);
    let under = |object: u32| below.iter().filter(move |(seen, _)| seen.object == object);
    for (object, height) in [(0, 2.0), (1, 1.5)] {
        let gaps: Vec<_> = under(object).filter_map(|(_, gap)| *gap).collect();
        assert!(gaps.iter().all(|gap| (gap - height).abs() < 1e-9));
    }
    // The glass is not even seen.
    assert_eq!(under(2).count(), 0);
    assert!(below.iter().any(|(_, gap)| gap.is_some()));
}
