//! Where a rendered shadow term is wrong, as a picture.

use image::{Rgb, RgbImage};

use super::ReportError;

/// The colour of what is lit but should not be: orange. With [`FALSE_SHADOW`] it is told apart by people
/// of any colour vision (Okabe and Ito 2008: "Color Universal Design").
pub const FALSE_LIT: [u8; 3] = [255, 159, 28];

/// The colour of what is in shadow but should not be: blue.
pub const FALSE_SHADOW: [u8; 3] = [72, 170, 255];

/// The colour of what was not compared, as the rasteriser saw another triangle than the ray: violet.
pub const LEFT_OUT: [u8; 3] = [104, 64, 128];

/// The colour of a bad pixel: a term that is no number or outside 0..1.
pub const NO_NUMBER: [u8; 3] = [255, 0, 90];

/// Where nothing is seen, or no light reaches the eye.
const NOTHING: [u8; 3] = [16, 16, 18];

/// The grey of a true shadow and of true light, dim enough for the colours to stand out.
const DIM: (f32, f32) = (38.0, 112.0);

/// The error of `rendered` in two colours over a dim picture of `truth`: [`FALSE_LIT`] and
/// [`FALSE_SHADOW`]. An error of 1 has the full colour, and a smaller one the share √error of it, so that
/// a soft shadow's small errors are seen too. A pixel not `compared` that has a truth is [`LEFT_OUT`], and
/// a bad pixel is [`NO_NUMBER`].
///
/// All three have one value a pixel, by rows, from the top left; shadow terms are 0 in shadow to 1 lit,
/// and the truth is none where nothing is seen or no light arrives.
///
/// # Errors
/// [`ReportError::Size`] where there is not one value a pixel, or no pixel.
pub fn difference(
    truth: &[Option<f32>],
    rendered: &[f32],
    compared: &[bool],
    width: u32,
    height: u32,
) -> Result<RgbImage, ReportError> {
    for (what, found) in [
        ("true shadow terms", truth.len()),
        ("rendered shadow terms", rendered.len()),
        ("marks of what is compared", compared.len()),
    ] {
        check_size(width, height, what, found)?;
    }
    let mut picture = RgbImage::new(width, height);
    let terms = truth.iter().zip(rendered).zip(compared);
    for (pixel, ((truth, rendered), compared)) in picture.pixels_mut().zip(terms) {
        *pixel = Rgb(colour(*truth, *rendered, *compared));
    }
    Ok(picture)
}

/// [`ReportError::Size`] unless `found` is the number of pixels, and not 0.
pub(super) fn check_size(
    width: u32,
    height: u32,
    what: &'static str,
    found: usize,
) -> Result<(), ReportError> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 || u64::try_from(found) != Ok(pixels) {
        return Err(ReportError::Size {
            width,
            height,
            what,
            found,
        });
    }
    Ok(())
}

fn colour(truth: Option<f32>, rendered: f32, compared: bool) -> [u8; 3] {
    let Some(truth) = truth else { return NOTHING };
    if !compared {
        return LEFT_OUT;
    }
    if !(0.0..=1.0).contains(&rendered) {
        return NO_NUMBER;
    }
    let base = DIM.0 + (DIM.1 - DIM.0) * truth.clamp(0.0, 1.0);
    let error = rendered - truth;
    let full = if error > 0.0 { FALSE_LIT } else { FALSE_SHADOW };
    let strength = error.abs().min(1.0).sqrt();
    full.map(|full| byte(base + (f32::from(full) - base) * strength))
}

pub(super) fn byte(value: f32) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_error_has_its_colour() {
        let lit = [112, 112, 112];
        let dark = [38, 38, 38];
        for (truth, rendered, compared, expected) in [
            (Some(1.0), 1.0, true, lit),
            (Some(0.0), 0.0, true, dark),
            (Some(0.0), 1.0, true, FALSE_LIT),
            (Some(1.0), 0.0, true, FALSE_SHADOW),
            (Some(1.0), 0.0, false, LEFT_OUT),
            (None, 0.0, false, NOTHING),
            (None, f32::NAN, true, NOTHING),
            (Some(1.0), f32::NAN, true, NO_NUMBER),
            (Some(1.0), f32::INFINITY, true, NO_NUMBER),
            (Some(1.0), 1.001, true, NO_NUMBER),
            (Some(0.0), -0.001, true, NO_NUMBER),
        ] {
            let picture = difference(&[truth], &[rendered], &[compared], 1, 1).expect("a picture");
            assert_eq!(
                picture.get_pixel(0, 0).0,
                expected,
                "{truth:?} {rendered} {compared}"
            );
        }
    }

    #[test]
    fn a_greater_error_is_nearer_to_its_colour() {
        let orange = |error: f32| i32::from(colour(Some(0.0), error, true)[0]);
        let blue = |error: f32| i32::from(colour(Some(1.0), 1.0 - error, true)[0]);
        let mut last = (orange(0.0), blue(0.0));
        for error in [0.01, 0.1, 0.25, 0.5, 0.75, 1.0] {
            let next = (orange(error), blue(error));
            assert!(next.0 > last.0 && next.1 < last.1, "{error}: {next:?}");
            last = next;
        }
        // √0.25 is half-way.
        assert_eq!(colour(Some(0.0), 0.25, true)[0], byte((38.0 + 255.0) / 2.0));
    }

    #[test]
    fn rows_run_from_the_top_left() {
        let terms = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        let picture = difference(&[Some(0.0); 6], &terms, &[true; 6], 3, 2).expect("a picture");
        assert_eq!(picture.get_pixel(1, 0).0, FALSE_LIT);
        assert_eq!(picture.get_pixel(0, 1).0, [38; 3]);
    }

    #[test]
    fn too_little_or_nothing_is_refused() {
        let refused = |truth: usize, rendered: usize, compared: usize, width, height| {
            difference(
                &vec![None; truth],
                &vec![0.0; rendered],
                &vec![true; compared],
                width,
                height,
            )
            .expect_err("refused")
            .to_string()
        };
        assert!(refused(3, 4, 4, 2, 2).contains("3 true shadow terms"));
        assert!(refused(4, 5, 4, 2, 2).contains("5 rendered shadow terms"));
        assert!(refused(4, 4, 3, 2, 2).contains("3 marks"));
        assert!(refused(0, 0, 0, 0, 2).contains("0 × 2"));
        assert!(refused(0, 0, 0, u32::MAX, u32::MAX).contains("4294967295"));
    }
}
