//! How different two pictures look.

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8};
use umbrage_render::Picture;

use super::FigureError;
use crate::truth::MOST_PIXELS;

/// The mean FLIP of a shaded picture against the true one, linear RGB by rows from the top; 0 alike to
/// 1 (Andersson et al. 2020, "FLIP: A difference evaluator for alternating images").
///
/// It is FLIP for displays of low dynamic range, at 67 pixels a degree: a 4K display 0.7 m wide, seen from
/// 0.7 m. Both pictures are clamped to 0..1 and encoded as sRGB in 8 bits, as
/// [`Picture::to_image`] writes them, without exposure or tone mapping; a pixel that is not finite
/// is taken as black, as it is counted elsewhere.
///
/// # Errors
/// A picture of no pixels, more than [`MOST_PIXELS`], or of another size than it says.
pub fn flip(
    width: u32,
    height: u32,
    truth: &[[f32; 3]],
    rendered: &[[f32; 3]],
) -> Result<f64, FigureError> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 || pixels > MOST_PIXELS as u64 {
        let most = MOST_PIXELS;
        return Err(FigureError::Size {
            width,
            height,
            most,
        });
    }
    let pixels = pixels as usize;
    FigureError::check(|| "the true picture".to_owned(), truth.len(), pixels)?;
    FigureError::check(|| "the rendered picture".to_owned(), rendered.len(), pixels)?;
    let [truth, rendered] = [truth, rendered].map(|picture| encode(width, height, picture));
    let map = nv_flip::flip(truth, rendered, DEFAULT_PIXELS_PER_DEGREE).to_vec();
    let sum: f64 = map.iter().map(|error| f64::from(*error)).sum();
    Ok(sum / pixels as f64)
}

fn encode(width: u32, height: u32, picture: &[[f32; 3]]) -> FlipImageRgb8 {
    let or_black = |pixel: &[f32; 3]| {
        let finite = pixel.iter().all(|value| value.is_finite());
        if finite { *pixel } else { [0.0; 3] }
    };
    let picture = Picture::Shaded(picture.iter().map(or_black).collect());
    let bytes = picture.to_image(width, height).into_rgb8();
    FlipImageRgb8::with_data(width, height, bytes.as_raw())
}
