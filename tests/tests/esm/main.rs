//! Known traits of exponential shadow maps, on a device and against closed forms: they are percentage-closer filtering
//! where all occluders lie in front of the receiver, they leak at contacts, and two kinds of scenes break them.
//!
//! The scenes are level sheets, seen from below, under a light from straight above: a sheet's height is its distance.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

mod slopes;
mod studio;

use glam::DVec2;

use crate::studio::{Choice, FILTERS, Sheet, Studio, rounding, sheet};

/// Deep in the shadow of a sheet g of the range above it, a receiver has exp(−k (g − b)) of the light, for every width:
/// 1 % of it where the gap is 4.6 / k.
#[test]
fn contacts_leak_as_far_as_the_formula_says() {
    let mut studio = Studio::new();
    let top = 20.0;
    for filter in FILTERS {
        let exponent = if filter == "esm_half" { 18.0 } else { 90.0 };
        for gap in [0.02, 0.1, 0.5, 1.02, 2.0, 5.1] {
            // A small sheet far above the view's edge sets the range.
            let roof = Sheet {
                min: DVec2::splat(4.7),
                max: DVec2::splat(4.9),
                height: top,
            };
            let sheets = [sheet(5.0, 0.0), sheet(2.0, gap), roof];
            let choice = Choice {
                filter,
                width: 15,
                exponent,
            };
            let drawn = studio.draw(&sheets, -9.0, &choice);
            let (range, _) = drawn.range();
            assert!((range - top).abs() < 0.1, "{range}");
            let far = gap / range - drawn.bias();
            let expected = (-exponent * far).exp().min(1.0);
            let bound = rounding(filter, exponent);
            for (place, term) in drawn.at(|at| at.abs().max_element() < 1.5) {
                let off = (term / expected - 1.0).abs();
                assert!(
                    off <= bound,
                    "{filter}, {gap} m, {place}: {term}, not {expected}"
                );
            }
            let dark = far > 4.605_17 / exponent;
            assert_eq!(expected < 0.01, dark, "4.6 / k is where 1 % is left");
            for (place, term) in drawn.at(|at| (2.5..4.0).contains(&at.abs().max_element())) {
                assert!(
                    term >= 1.0 - bound,
                    "{filter}, {place}: {term} in the light"
                );
            }
        }
    }
}

/// A lattice of strips, all of them in front of the floor.
fn strips() -> Vec<Sheet> {
    let mut sheets = vec![sheet(5.0, 0.0)];
    for number in 0..7 {
        let x = -3.9 + 1.1 * f64::from(number);
        sheets.push(Sheet {
            min: DVec2::new(x, -4.0),
            max: DVec2::new(x + 0.2 + 0.05 * f64::from(number), 4.0),
            height: 3.0 + 0.5 * f64::from(number),
        });
    }
    for number in 0..5 {
        let z = -3.0 + 1.4 * f64::from(number);
        sheets.push(Sheet {
            min: DVec2::new(-4.0, z),
            max: DVec2::new(4.0, z + 0.15 + 0.1 * f64::from(number)),
            height: 2.5 + 0.3 * f64::from(number),
        });
    }
    sheets
}

/// Salvi's claim. Of a window of which the share L is lit, percentage-closer filtering gives L, and an exponential map L exp(k b) and what
/// leaks through the rest, (1 − L) exp(−k (g − b)) for the nearest gap g, no more than 1 of both: so the two differ by
/// exp(k b) − 1 or by exp(−k (g − b)) at the most, and never to the dark side.
#[test]
fn it_is_percentage_closer_filtering_where_all_occluders_are_in_front() {
    let mut studio = Studio::new();
    let sheets = strips();
    for width in (3..=15).step_by(2) {
        let choice = |filter, exponent| Choice {
            filter,
            width,
            exponent,
        };
        let pcf = studio.draw(&sheets, -9.0, &choice("pcf", 0.0));
        let partly = pcf.terms.iter().filter(|term| (0.1..0.9).contains(*term));
        assert!(
            partly.count() > 300 * width as usize / 3,
            "edges of some width"
        );
        for (filter, exponent) in [("esm", 150.0), ("esm_half", 19.0), ("esm_log", 2000.0)] {
            let esm = studio.draw(&sheets, -9.0, &choice(filter, exponent));
            let (range, _) = esm.range();
            let biased = (exponent * esm.bias()).exp_m1();
            let leak = (-exponent * (2.5 / range - esm.bias())).exp();
            // Weights of 8 bits, in two fetches on one side and one on the other.
            let bound = rounding(filter, exponent) + 1.5 / 256.0;
            let mut worst = 0.0_f64;
            for ((pcf, esm), place) in pcf.terms.iter().zip(&esm.terms).zip(&esm.places) {
                let above = esm - pcf;
                worst = worst.max(above.abs());
                let most = (biased * pcf + leak * (1.0 - pcf)).min(1.0 - pcf);
                assert!(
                    (-bound..=most + bound).contains(&above),
                    "{filter} {width}, {place}: {esm}, but {pcf} by comparison; {leak}, {biased}"
                );
            }
            println!(
                "{filter} of {width}: {worst:.4} off, of {:.4}",
                leak.max(biased) + bound
            );
        }
    }
}

/// Where a window reaches past a receiver's edge to what lies behind it, the share that does is multiplied by exp(k g): a
/// table in full shadow is lit along its edge, half as far in as the filter is wide.
#[test]
fn a_receiver_that_is_not_the_farthest_is_lit_along_its_edge() {
    let mut studio = Studio::new();
    // The floor begins beside the table, which is seen past it and sets the range.
    let floor = Sheet {
        min: DVec2::new(1.6, -5.0),
        max: DVec2::new(5.0, 5.0),
        height: 0.0,
    };
    let sheets = [floor, sheet(1.0, 2.0), sheet(1.0, 4.0)];
    for filter in FILTERS {
        let choice = |filter| Choice {
            filter,
            width: 15,
            exponent: 19.0,
        };
        let esm = studio.draw_sheet(&sheets, (-4.0, 2.0), &choice(filter));
        let pcf = studio.draw_sheet(&sheets, (-4.0, 2.0), &choice("pcf"));
        let (_, texel) = esm.range();
        let half = 7.5 * texel;
        let inside = |from: f64, to: f64| {
            move |at: DVec2| at.y.abs() < 0.5 && (from..to).contains(&(1.0 - at.x.abs()))
        };
        let near = inside(0.0, half - 1.5 * texel);
        for ((place, esm), (_, pcf)) in esm.at(near).into_iter().zip(pcf.at(near)) {
            assert!(
                esm > 0.999 && pcf < 0.55,
                "{filter}, {place}: {esm}, {pcf} by comparison"
            );
        }
        let deep = inside(half + 1.5 * texel, 1.0);
        for ((place, esm), (_, pcf)) in esm.at(deep).into_iter().zip(pcf.at(deep)) {
            assert!(
                esm < 0.01 && pcf == 0.0,
                "{filter}, {place}: {esm}, {pcf} by comparison"
            );
        }
    }
}

/// Of two occluders above one another the map holds the upper one alone. Beside it the lower one leaks as its own gap
/// says; over the upper one's edge, which shades nothing, that leak fades by the filter's width.
#[test]
fn of_two_overlapping_occluders_the_lower_one_leaks() {
    let mut studio = Studio::new();
    let upper = Sheet {
        max: DVec2::new(0.0, 3.0),
        ..sheet(3.0, 3.0)
    };
    let sheets = [sheet(5.0, 0.0), sheet(3.0, 0.3), upper];
    for filter in FILTERS {
        let choice = |filter| Choice {
            filter,
            width: 15,
            exponent: 12.0,
        };
        let esm = studio.draw(&sheets, -9.0, &choice(filter));
        let pcf = studio.draw(&sheets, -9.0, &choice("pcf"));
        let (range, texel) = esm.range();
        let left = |gap: f64| (-12.0 * (gap / range - esm.bias())).exp();
        let (lower, upper) = (left(0.3), left(3.0));
        assert!(lower > 0.25 && upper < 1e-4, "{lower}, {upper}");
        let shaded = |at: DVec2| at.abs().max_element() < 2.0;
        for ((place, esm), (_, pcf)) in esm.at(shaded).into_iter().zip(pcf.at(shaded)) {
            assert_eq!(pcf, 0.0, "{place} is in full shadow");
            let share = (0.5 + place.x / (15.0 * texel)).clamp(0.0, 1.0);
            let expected = share * lower + (1.0 - share) * upper;
            // The edge is at a whole texel of the map.
            let bound = lower * (1.0 / 15.0 + rounding(filter, 12.0));
            assert!(
                (esm - expected).abs() < bound,
                "{filter}, {place}: {esm}, not {expected}"
            );
        }
    }
}

/// With the largest exponents that the formats hold, from one end of the range to the other: the nearest surface and the
/// farthest are lit, nothing is out of range or no number, and a shadow is as dark as the exponent says.
#[test]
fn the_largest_exponents_neither_overflow_nor_vanish() {
    let mut studio = Studio::new();
    let top = 6.0;
    // Seen from below: the floor beside the roof, then the roof past the floor.
    let floor = Sheet {
        min: DVec2::new(0.5, -2.0),
        max: DVec2::new(4.0, 2.0),
        height: 0.0,
    };
    let roof = Sheet {
        min: DVec2::new(-4.0, -2.0),
        max: DVec2::new(1.5, 2.0),
        height: top,
    };
    for (filter, exponent) in [("esm", 163.5), ("esm_half", 19.4), ("esm_log", 65536.0)] {
        for width in [1, 3, 15] {
            let choice = Choice {
                filter,
                width,
                exponent,
            };
            let bound = rounding(filter, exponent);
            let low = studio.draw_sheet(&[floor, roof], (-8.0, 0.0), &choice);
            assert!(low.terms.iter().all(|term| (0.0..=1.0).contains(term)));
            let (_, texel) = low.range();
            let margin = 9.0 * texel;
            for (place, term) in low.at(|at| at.x > 1.5 + margin && at.x < 3.8 && at.y.abs() < 1.8)
            {
                assert!(
                    term >= 1.0 - bound,
                    "{filter} {width}, {place}: {term} on the floor"
                );
            }
            let dark = (-exponent * (1.0 - 0.01_f64)).exp() + 1e-30;
            for (place, term) in low.at(|at| at.x > 0.6 && at.x < 1.5 - margin && at.y.abs() < 1.8)
            {
                assert!(
                    term <= dark,
                    "{filter} {width}, {place}: {term} below the roof"
                );
            }
            let high = studio.draw_sheet(&[floor, roof], (-8.0, top), &choice);
            for (place, term) in high.at(|at| at.x < 0.0 && at.x > -3.8 && at.y.abs() < 1.8) {
                assert!(
                    term >= 1.0 - bound,
                    "{filter} {width}, {place}: {term} on the roof"
                );
            }
        }
    }
}

/// By default a hundredth of the light is left 2 (W + 1) texels below an occluder, where the format holds the exponent.
#[test]
fn the_default_leak_is_two_filters_long() {
    let mut studio = Studio::new();
    for (filter, width) in [
        ("esm", 15),
        ("esm_log", 3),
        ("esm_half", 3),
        ("esm_log", 15),
    ] {
        let choice = Choice {
            filter,
            width,
            exponent: 0.0,
        };
        let drawn = studio.draw(&[sheet(5.0, 0.0), sheet(1.0, 2.0)], -9.0, &choice);
        let (range, texel) = drawn.range();
        let reach = 2.0 * f64::from(width + 1) * texel / range;
        let left = (-drawn.exponent() * reach).exp();
        if filter == "esm_half" {
            assert!(
                (19.3..19.42).contains(&drawn.exponent()),
                "{}",
                drawn.exponent()
            );
        } else {
            assert!((left - 0.01).abs() < 1e-4, "{filter} {width}: {left}");
        }
    }
}

/// Of a map narrower than its filter, windows are cut off at the edges: what they would read there counts as the edge's own texels,
/// as it does by comparison, and not as empty.
#[test]
fn windows_end_where_a_map_does() {
    let mut studio = Studio::new();
    let sheets = [sheet(5.0, 0.0), sheet(90.0, 3.0)];
    for resolution in [1.0, 2.0, 7.0, 11.0] {
        studio.resolution = resolution;
        for filter in ["pcf", "esm", "esm_half", "esm_log"] {
            let choice = Choice {
                filter,
                width: 15,
                exponent: if filter == "pcf" { 0.0 } else { 19.0 },
            };
            let drawn = studio.draw(&sheets, -9.0, &choice);
            for (place, term) in drawn.at(|at| at.abs().max_element() < 4.0) {
                assert!(
                    term < 0.01,
                    "{filter}, {resolution} texels, {place}: {term} in the middle of a shadow"
                );
            }
        }
    }
}
