//! Wrong samples, each made wrong in a known way.

use glam::DVec3;
use proptest::prelude::*;

use super::{Made, sun_plan};
use crate::figures::Figures;

const SIZE: u32 = 100;

/// A floor whose left half is in a shadow from 5 m above, under a map with texels of 1/8 m; a pixel is
/// 2 · 10 · tan 30° / 100 = 0.115 m.
fn half_dark() -> Made {
    let mut made = Made::new(SIZE, SIZE);
    let direction = DVec3::NEG_Y;
    made.plan = Some(sun_plan(&made.scene, direction, 16.0, 256));
    for pixel in 0..made.truth.len() {
        if pixel % 100 < 50 {
            made.truth[pixel] = Some(0.0);
            made.rendered[pixel] = 0.0;
            made.gaps[pixel] = Some(5.0);
        }
    }
    made
}

fn at(x: usize, y: usize) -> usize {
    y * SIZE as usize + x
}

/// Shares as numbers of samples: acne, peter-panning, leak, beyond range, edge.
fn counts(figures: &Figures) -> [f64; 5] {
    let Figures {
        acne,
        peter_panning,
        leak,
        beyond_range,
        edge,
        ..
    } = *figures;
    [acne, peter_panning, leak, beyond_range, edge]
        .map(|share| (share * figures.compared as f64).round())
}

#[test]
fn what_is_right_has_no_cause() {
    assert_eq!(counts(&half_dark().figures()), [0.0; 5]);
}

#[test]
fn far_from_an_edge_false_shadow_is_acne_and_false_light_a_leak() {
    let mut made = half_dark();
    made.rendered[at(80, 50)] = 0.0;
    assert_eq!(counts(&made.figures()), [1.0, 0.0, 0.0, 0.0, 0.0]);
    made.rendered[at(20, 50)] = 1.0;
    assert_eq!(counts(&made.figures()), [1.0, 0.0, 1.0, 0.0, 0.0]);
}

/// The filter reaches 1.5 texels; with one more of 0.125 m, 2.5 · 0.125 / 0.115 = 2.7 pixels, and 1.
#[test]
fn within_the_filters_reach_the_edge_is_the_cause() {
    for (x, is_edge) in [(46, true), (45, false), (53, true), (54, false)] {
        let mut made = half_dark();
        let pixel = at(x, 50);
        made.rendered[pixel] = 1.0 - made.rendered[pixel];
        // The edge lies at 50: between the centres at 49.5 and 50.5.
        let [acne, _, leak, _, edge] = counts(&made.figures());
        assert_eq!(edge == 1.0, is_edge, "column {x}");
        assert_eq!(acne + leak == 1.0, !is_edge, "column {x}");
        // Four times the texels: the reach is 0.7 pixels and 1.
        made.plan = Some(sun_plan(&made.scene, DVec3::NEG_Y, 16.0, 1024));
        assert_eq!(counts(&made.figures())[4], 0.0, "column {x}");
    }
}

/// Without a plan nothing is known of a filter: a pixel either way is the picture's own.
#[test]
fn without_a_plan_an_edge_reaches_a_pixel() {
    let mut made = half_dark();
    made.plan = None;
    for (x, y, cause) in [(49, 10, 4), (48, 30, 2), (50, 50, 4), (52, 70, 0)] {
        let before = counts(&made.figures());
        let pixel = at(x, y);
        made.rendered[pixel] = 1.0 - made.rendered[pixel];
        let after = counts(&made.figures());
        let grown: Vec<_> = (0..5).filter(|i| after[*i] > before[*i]).collect();
        assert_eq!(grown, [cause], "column {x}");
    }
}

/// 1.5 + 2 texels of 0.125 m, under a light that shines straight down: 0.4375 m.
#[test]
fn false_light_under_near_casters_is_peter_panning() {
    for (gap, cause) in [(0.43, 1), (0.445, 2)] {
        let mut made = half_dark();
        made.rendered[at(20, 50)] = 1.0;
        made.gaps[at(20, 50)] = Some(gap);
        assert_eq!(counts(&made.figures())[cause], 1.0, "{gap}");
        // Near an edge too: a contact has an edge of its own.
        made.rendered[at(49, 50)] = 1.0;
        made.gaps[at(49, 50)] = Some(gap);
        assert_eq!(
            counts(&made.figures())[1],
            if cause == 1 { 2.0 } else { 0.0 }
        );
    }
}

/// At 60° a texel's reach is twice as long.
#[test]
fn the_contacts_reach_grows_with_the_slope() {
    for (gap, cause) in [(0.87, 1), (0.88, 2)] {
        let mut made = half_dark();
        let direction = DVec3::new(3_f64.sqrt(), -1.0, 0.0).normalize();
        made.scene.lights[0].light.kind = umbrage_shadow::LightKind::Directional { direction };
        made.plan = Some(sun_plan(&made.scene, direction, 16.0, 256));
        made.rendered[at(20, 50)] = 1.0;
        made.gaps[at(20, 50)] = Some(gap);
        assert_eq!(counts(&made.figures())[cause], 1.0, "{gap}");
    }
}

/// Light from below, and from along the floor: none of it reaches the eye, whatever is said of it.
#[test]
fn what_is_turned_away_from_the_light_is_seen_to_be_neither_lit_nor_dark() {
    for direction in [DVec3::Y, DVec3::new(1.0, 0.1, 0.0).normalize()] {
        let mut made = half_dark();
        made.scene.lights[0].light.kind = umbrage_shadow::LightKind::Directional { direction };
        made.rendered[at(20, 50)] = 1.0;
        made.rendered[at(80, 50)] = 0.0;
        made.gaps[at(20, 50)] = Some(0.01);
        let figures = made.figures();
        assert_eq!(counts(&figures), [0.0; 5]);
        assert_eq!((figures.compared, figures.back_facing), (10_000, 2e-4));
        let seen = [
            figures.false_lit,
            figures.false_shadow,
            figures.rmse,
            figures.p99,
            figures.in_shadow,
        ];
        assert_eq!(seen, [0.0; 5]);
        assert_eq!((figures.edge_max, figures.error_of_shadow), (None, None));
    }
}

/// Normals at the corners lean towards a light from below the plane, so that some of it reaches the eye, and errors
/// are seen; or away from one above, so that they are not.
#[test]
fn light_reaches_the_eye_by_the_normal_that_shades() {
    let wrong = |normal: glam::Vec3, direction: DVec3| {
        let mut made = half_dark();
        let object = &mut made.scene.objects[0];
        let mut mesh = (*object.mesh).clone();
        mesh.normals = vec![normal.normalize(); mesh.positions.len()];
        object.mesh = std::sync::Arc::new(mesh);
        made.scene.lights[0].light.kind = umbrage_shadow::LightKind::Directional { direction };
        made.rendered[at(20, 50)] = 1.0;
        let figures = made.figures();
        [figures.false_lit, figures.back_facing].map(|share| (share * 10_000.0).round())
    };
    let grazing = |y: f64| DVec3::new(1.0, y, 0.0).normalize();
    let leans = |x: f32| glam::Vec3::new(x, 1.0, 0.0);
    assert_eq!(wrong(leans(0.0), grazing(-0.1)), [1.0, 0.0]);
    assert_eq!(wrong(leans(0.5), grazing(-0.1)), [0.0, 1.0]);
    assert_eq!(wrong(leans(0.0), grazing(0.1)), [0.0, 1.0]);
    assert_eq!(wrong(leans(-0.5), grazing(0.1)), [1.0, 0.0]);
    // The other side of a leaf has the same normals, turned round.
    assert_eq!(wrong(-leans(0.5), grazing(-0.1)), [0.0, 1.0]);
    // A mesh that has none there is shaded flat.
    assert_eq!(wrong(glam::Vec3::ZERO, grazing(-0.1)), [1.0, 0.0]);
}

#[test]
fn errors_are_told_as_a_share_of_the_shadow_too() {
    let mut made = half_dark();
    made.rendered[at(20, 50)] = 1.0;
    made.rendered[at(80, 50)] = 0.0;
    let figures = made.figures();
    assert_eq!(figures.in_shadow, 0.5);
    assert_eq!(figures.false_lit_of_shadow, Some(1.0 / 5000.0));
    assert_eq!(figures.error_of_shadow, Some(2.0 / 5000.0));
}

#[test]
fn a_leak_in_one_piece_with_a_contact_is_its_band() {
    let mut made = half_dark();
    for x in 10..30 {
        made.rendered[at(x, 50)] = 1.0;
        // Beside it, but apart.
        made.rendered[at(x, 53)] = 1.0;
        made.gaps[at(x, 50)] = Some(0.1 * x as f64);
    }
    assert_eq!(counts(&made.figures()), [0.0, 0.0, 40.0, 0.0, 0.0]);
    made.gaps[at(10, 50)] = Some(0.01);
    assert_eq!(counts(&made.figures()), [0.0, 20.0, 20.0, 0.0, 0.0]);
}

#[test]
fn false_light_beyond_the_shadow_distance_is_beyond_range() {
    let mut made = half_dark();
    for (pixel, gap) in [(at(20, 50), 5.0), (at(20, 60), 0.1), (at(49, 20), 5.0)] {
        made.rendered[pixel] = 1.0;
        made.gaps[pixel] = Some(gap);
    }
    made.rendered[at(80, 50)] = 0.0;
    // The floor's view depth is 10 m, in every direction.
    for (end, expected) in [
        (10.1, [1.0, 1.0, 1.0, 0.0, 1.0]),
        (9.9, [1.0, 0.0, 0.0, 3.0, 0.0]),
    ] {
        if let Some(plan) = &mut made.plan {
            plan.shadow_distance = Some(end);
        }
        assert_eq!(counts(&made.figures()), expected, "{end}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever is wrong, each wrong sample has one cause.
    #[test]
    fn the_causes_add_up(
        truth in prop::collection::vec(0..4_usize, 144), rendered in prop::collection::vec(0..5_usize, 144),
        gaps in prop::collection::vec(0.0..2.0, 144), end in prop::option::of(5.0..20.0),
        with_plan in any::<bool>(), torn in prop::collection::vec(0..5_usize, 144),
    ) {
        let mut made = Made::new(12, 12);
        made.plan = with_plan.then(|| sun_plan(&made.scene, DVec3::NEG_Y, 16.0, 256));
        if let Some(plan) = &mut made.plan {
            plan.shadow_distance = end;
        }
        made.truth = truth.iter().map(|i| [Some(0.0), Some(1.0), Some(0.25), None][*i]).collect();
        made.rendered = rendered.iter().map(|i| [0.0, 1.0, 0.5, 0.75, f32::NAN][*i]).collect();
        made.gaps = gaps.iter().zip(&made.truth).map(|(g, t)| (*t == Some(0.0)).then_some(*g)).collect();
        let mut raster = super::same(&made.sight);
        for (raster, torn) in raster.iter_mut().zip(torn) {
            *raster = raster.filter(|_| torn > 0);
        }
        let figures = made.figures_of(&raster);
        let mut expected = [0_u64; 2];
        for (pixel, raster) in raster.iter().enumerate() {
            let (Some(truth), Some(_)) = (made.truth[pixel], raster) else { continue };
            expected[0] += u64::from(truth < 0.5 && made.rendered[pixel] > 0.5);
            expected[1] += u64::from(truth > 0.5 && made.rendered[pixel] < 0.5);
        }
        let all = figures.compared as f64;
        let [lit, dark] = [figures.false_lit, figures.false_shadow].map(|share| (share * all).round() as u64);
        prop_assert_eq!([lit, dark], expected);
        let sum: f64 = counts(&figures).iter().sum();
        prop_assert_eq!(sum as u64, lit + dark);
        prop_assert!(counts(&figures)[0] as u64 <= dark);
    }
}
