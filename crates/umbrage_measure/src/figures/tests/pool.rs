//! Samples that are counted, and samples that are not.

use super::{Made, same, sun_plan};
use crate::figures::{FigureError, Figures, Sample, figures};

#[test]
fn samples_that_the_rasteriser_saw_otherwise_are_left_out() {
    let mut made = Made::new(10, 10);
    made.truth[3] = None;
    made.rendered = vec![0.0; 100];
    let mut raster = same(&made.sight);
    raster[5] = None;
    raster[6] = Some((0, 77));
    raster[7] = Some((9, 0));
    // Where the light does not reach, nothing is left out.
    raster[3] = None;
    let figures = made.figures_of(&raster);
    assert_eq!((figures.compared, figures.left_out), (96, 3));
    assert_eq!(
        (figures.false_shadow, figures.rmse, figures.p99),
        (1.0, 1.0, 1.0)
    );
}

#[test]
fn errors_are_taken_as_they_are() {
    let mut made = Made::new(10, 10);
    for (pixel, term) in [(0, 0.0), (1, 0.5), (2, 0.75)] {
        made.rendered[pixel] = term;
    }
    let figures = made.figures();
    // (1 + 1/4 + 1/16) / 100; and of 100, 99 do not exceed the second largest.
    assert!(
        (figures.rmse - 0.013_125_f64.sqrt()).abs() < 1e-12,
        "{figures:?}"
    );
    assert_eq!(figures.p99, 0.5);
    // Exactly ½ is on neither side.
    assert_eq!((figures.false_shadow, figures.false_lit), (0.01, 0.0));
    assert_eq!(figures.bad_pixels, 0);
}

#[test]
fn what_is_no_number_spoils_nothing_but_itself() {
    let mut made = Made::new(10, 10);
    for (pixel, term) in [(0, f32::NAN), (1, f32::INFINITY), (2, -0.01), (3, 1.5)] {
        made.rendered[pixel] = term;
    }
    // Counted where nothing is compared, too.
    made.truth[4] = None;
    made.rendered[4] = f32::NAN;
    let figures = made.figures();
    assert_eq!(figures.bad_pixels, 5);
    assert_eq!(figures.compared, 99);
    // The first is off by 1, the third by 1 as it is clamped, the others by nothing.
    assert!(
        (figures.rmse - (2.0 / 99.0_f64).sqrt()).abs() < 1e-12,
        "{figures:?}"
    );
    assert_eq!((figures.false_shadow, figures.false_lit), (1.0 / 99.0, 0.0));
    assert!(figures.edge_max.is_some_and(f64::is_finite));
}

#[test]
fn nothing_to_compare_is_nothing_wrong() {
    let mut made = Made::new(4, 4);
    made.truth = vec![None; 16];
    assert_eq!(made.figures(), Figures::default());
    let none = figures(&made.scene, &made.sight, &same(&made.sight), &[]);
    assert_eq!(none, Ok(Figures::default()));
}

#[test]
fn lights_are_pooled() {
    let (lit, mut dark) = (Made::new(10, 10), Made::new(10, 10));
    dark.rendered = vec![0.0; 100];
    let plan = sun_plan(&lit.scene, glam::DVec3::NEG_Y, 16.0, 256);
    let sample = |made| {
        let Made {
            truth,
            rendered,
            gaps,
            scene,
            ..
        }: &Made = made;
        let (light, plan) = (&scene.lights[0].light, Some(&plan));
        Sample {
            light,
            truth,
            gaps,
            rendered,
            plan,
        }
    };
    let samples = [sample(&lit), sample(&dark), sample(&lit), sample(&lit)];
    let found = figures(&lit.scene, &lit.sight, &same(&lit.sight), &samples).expect("of one size");
    assert_eq!(
        (found.compared, found.false_shadow, found.acne),
        (400, 0.25, 0.25)
    );
    // A texel of 1/8 m, and 10 pixels on 2 · 10 · tan 30° m: all look the same from straight above, but
    // for the corner's slant.
    let alias = 0.125 / (2.0 * 30_f64.to_radians().tan());
    assert!(found.alias_over_1 == Some(0.0));
    assert!(
        found
            .alias_p95
            .is_some_and(|p95| (0.8 * alias..=1.001 * alias).contains(&p95))
    );
    assert!(
        found
            .alias_projection_p95
            .is_some_and(|p95| (0.7..=1.0).contains(&p95))
    );
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mut made = Made::new(64, 48);
    made.plan = Some(sun_plan(&made.scene, glam::DVec3::NEG_Y, 16.0, 64));
    for (pixel, term) in made.rendered.iter_mut().enumerate() {
        *term = (pixel * 37 % 101) as f32 / 100.0;
        made.truth[pixel] = Some(if pixel * 53 % 7 < 3 { 0.0 } else { 1.0 });
    }
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| made.figures())
    };
    assert_eq!(of(1), of(5));
}

#[test]
fn pictures_that_do_not_fit_are_refused() {
    let whole = Made::new(4, 3);
    let refused = |change: &dyn Fn(&mut Made)| {
        let mut made = Made::new(4, 3);
        change(&mut made);
        let sample = Sample {
            light: &made.scene.lights[0].light,
            truth: &made.truth,
            gaps: &made.gaps,
            rendered: &made.rendered,
            plan: None,
        };
        let error = figures(&made.scene, &whole.sight, &same(&made.sight), &[sample]);
        error.expect_err("refused").to_string()
    };
    let tail = "pixels, but must have 12; take all pictures at one size";
    let said = refused(&|made| made.truth.truncate(11));
    assert_eq!(said, format!("the truth of light 0 has 11 {tail}"));
    let said = refused(&|made| made.gaps.clear());
    assert_eq!(said, format!("the picture of gaps of light 0 has 0 {tail}"));
    let said = refused(&|made| made.rendered.push(1.0));
    assert_eq!(said, format!("the rendered term of light 0 has 13 {tail}"));
    let said = refused(&|made| made.sight = Made::new(4, 4).sight);
    assert_eq!(said, format!("the rasteriser's picture has 16 {tail}"));
    let said = refused(&|made| made.scene.objects.clear());
    assert!(said.contains("object 0, which the scene lacks"), "{said}");
    let said = refused(&|made| made.scene.camera.near = -1.0);
    assert!(said.starts_with("the camera cannot be used: "), "{said}");
    assert!(matches!(
        figures(&whole.scene, &whole.sight, &[], &[]),
        Err(FigureError::Length { found: 0, .. })
    ));
}
