//! FLIP at its ends.

use crate::figures::{FigureError, flip};

const SIZE: u32 = 64;

fn picture(color: impl Fn(u32, u32) -> [f32; 3]) -> Vec<[f32; 3]> {
    (0..SIZE * SIZE)
        .map(|i| color(i % SIZE, i / SIZE))
        .collect()
}

fn of(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    flip(SIZE, SIZE, a, b).expect("of one size")
}

/// A square of light in the dark.
fn square(left: u32, top: u32) -> Vec<[f32; 3]> {
    picture(|x, y| {
        let inside = (left..left + 8).contains(&x) && (top..top + 8).contains(&y);
        [if inside { 0.8 } else { 0.1 }; 3]
    })
}

#[test]
fn what_is_alike_differs_by_nothing_and_black_from_white_by_nearly_all() {
    let (black, white) = (picture(|_, _| [0.0; 3]), picture(|_, _| [1.0; 3]));
    let colors = picture(|x, y| [x as f32 / 64.0, y as f32 / 64.0, 0.3]);
    assert_eq!(of(&colors, &colors), 0.0);
    let most = of(&black, &white);
    assert!((0.95..=1.0).contains(&most), "{most}");
    // As displays have it: more than white is white, less than black is black.
    assert_eq!(of(&white, &picture(|_, _| [7.0; 3])), 0.0);
    assert_eq!(of(&black, &picture(|_, _| [-7.0; 3])), 0.0);
}

#[test]
fn it_matters_neither_which_is_which_nor_where() {
    let dark = picture(|_, _| [0.1; 3]);
    let one = of(&dark, &square(20, 20));
    assert!(one > 0.005, "{one}");
    assert!((one - of(&square(20, 20), &dark)).abs() < 1e-6);
    // Far enough from the borders.
    assert!((one - of(&dark, &square(32, 24))).abs() < 1e-6);
    // A greater difference is more of one.
    let faint: Vec<_> = square(20, 20)
        .iter()
        .map(|c| c.map(|v| 0.5 * v + 0.05))
        .collect();
    assert!(of(&dark, &faint) < 0.9 * one);
}

/// The colours are encoded: the same linear step is seen in the dark and hardly in the light.
#[test]
fn steps_count_as_they_are_seen() {
    let step = |from: f32| {
        of(
            &picture(|_, _| [from; 3]),
            &picture(|_, _| [from + 0.05; 3]),
        )
    };
    assert!(step(0.0) > 3.0 * step(0.9), "{} {}", step(0.0), step(0.9));
}

#[test]
fn what_is_not_finite_is_black() {
    let black = picture(|_, _| [0.0; 3]);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let torn = picture(|x, _| if x == 7 { [0.5, bad, 0.5] } else { [0.0; 3] });
        assert_eq!(of(&black, &torn), 0.0);
        assert_eq!(of(&torn, &black), 0.0);
    }
}

#[test]
fn sizes_that_do_not_fit_are_refused() {
    let black = picture(|_, _| [0.0; 3]);
    let error = flip(SIZE, 3, &black, &black).expect_err("too short");
    assert_eq!(
        error.to_string(),
        "the true picture has 4096 pixels, but must have 192; take all pictures at one size"
    );
    let error = flip(0, 3, &[], &[]).expect_err("empty");
    assert!(matches!(error, FigureError::Size { .. }), "{error}");
    assert!(flip(u32::MAX, u32::MAX, &[], &[]).is_err());
}
