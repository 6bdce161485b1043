//! The pictures of a row, as the page embeds them.

#[cfg(doc)]
use {super::difference, umbrage_render::Decision};

use image::{
    DynamicImage, GrayImage, ImageEncoder, RgbImage,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};

use super::{
    ReportError,
    difference::{byte, check_size},
};

/// Pictures of one row's shadows, kept as PNG, a small part of their size in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pictures {
    /// Pixels across and down.
    pub(super) size: (u32, u32),
    pub(super) rendered: Vec<u8>,
    pub(super) truth: Vec<u8>,
    pub(super) difference: Vec<u8>,
    pub(super) shaded: Option<Vec<u8>>,
    pub(super) decisions: Option<Vec<u8>>,
}

impl Pictures {
    /// The rendered term and the true one, one value a pixel, by rows from the top left, and their [`difference`]; and the
    /// shaded scene, where there is such a picture. White is lit, black is in shadow; the truth is none where nothing is seen or no
    /// light arrives.
    ///
    /// # Errors
    /// [`ReportError::Size`] where there is not one value a pixel of the difference, or no pixel, or the shaded picture has
    /// another size.
    pub fn new(
        truth: &[Option<f32>],
        rendered: &[f32],
        difference: RgbImage,
        shaded: Option<&RgbImage>,
    ) -> Result<Self, ReportError> {
        let (width, height) = difference.dimensions();
        check_size(width, height, "true shadow terms", truth.len())?;
        check_size(width, height, "rendered shadow terms", rendered.len())?;
        if let Some(shaded) = shaded {
            check_picture(
                (width, height),
                shaded,
                ["shaded pixels", "shaded pixels in rows of another length"],
            )?;
        }
        // Nothing that is seen can be in shadow there: the renderer has it lit too.
        let truth = truth.iter().map(|term| term.unwrap_or(1.0));
        Ok(Self {
            size: (width, height),
            rendered: png(&gray(rendered.iter().copied(), width, height).into())?,
            truth: png(&gray(truth, width, height).into())?,
            difference: png(&difference.into())?,
            shaded: shaded
                .map(|shaded| png(&shaded.clone().into()))
                .transpose()?,
            decisions: None,
        })
    }

    /// With how each pixel's term was found, in the colours of [`Decision::color`].
    ///
    /// # Errors
    /// [`ReportError::Size`] where it has another size.
    pub fn with_decisions(self, decisions: &RgbImage) -> Result<Self, ReportError> {
        check_picture(
            self.size,
            decisions,
            ["decisions", "decisions in rows of another length"],
        )?;
        let decisions = Some(png(&decisions.clone().into())?);
        Ok(Self { decisions, ..self })
    }
}

impl Pictures {
    /// The pictures as PNG files, each with its name: `method`, `truth`, `difference` and, where there are
    /// such, `shaded` and `decisions`.
    pub fn files(&self) -> impl Iterator<Item = (&'static str, &[u8])> {
        let terms = [
            ("method", &self.rendered),
            ("truth", &self.truth),
            ("difference", &self.difference),
        ];
        let shaded = self.shaded.iter().map(|png| ("shaded", png));
        let decisions = self.decisions.iter().map(|png| ("decisions", png));
        terms
            .into_iter()
            .chain(shaded)
            .chain(decisions)
            .map(|(name, png)| (name, png.as_slice()))
    }
}

/// Checks that `picture` has this size; `what` its pixels are, and what as many are in rows of another length.
fn check_picture(
    (width, height): (u32, u32),
    picture: &RgbImage,
    [what, turned]: [&'static str; 2],
) -> Result<(), ReportError> {
    if picture.dimensions() == (width, height) {
        return Ok(());
    }
    let found = picture.pixels().len();
    check_size(width, height, what, found)?;
    Err(ReportError::Size {
        width,
        height,
        what: turned,
        found,
    })
}

/// The terms as grey; what is no number is black.
fn gray(terms: impl Iterator<Item = f32>, width: u32, height: u32) -> GrayImage {
    let mut picture = GrayImage::new(width, height);
    for (pixel, term) in picture.pixels_mut().zip(terms) {
        pixel.0 = [byte(term * 255.0)];
    }
    picture
}

fn png(picture: &DynamicImage) -> Result<Vec<u8>, ReportError> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(
            picture.as_bytes(),
            picture.width(),
            picture.height(),
            picture.color().into(),
        )?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pictures_are_the_terms() {
        let pictures = Pictures::new(
            &[Some(0.0), None, Some(1.0), Some(0.5)],
            &[0.25, 1.0, f32::NAN, 2.0],
            RgbImage::new(2, 2),
            Some(&RgbImage::from_pixel(2, 2, image::Rgb([1, 2, 3]))),
        )
        .expect("pictures");
        let decoded = |bytes: &[u8]| image::load_from_memory(bytes).expect("a PNG");
        assert_eq!(
            decoded(&pictures.rendered).into_luma8().as_raw(),
            &[64, 255, 0, 255]
        );
        assert_eq!(
            decoded(&pictures.truth).into_luma8().as_raw(),
            &[0, 255, 255, 128]
        );
        assert_eq!(
            decoded(&pictures.difference).into_rgb8().dimensions(),
            (2, 2)
        );
        let shaded = pictures.shaded.expect("shaded");
        assert_eq!(decoded(&shaded).into_rgb8().get_pixel(1, 1).0, [1, 2, 3]);
    }

    #[test]
    fn a_picture_of_another_size_is_refused() {
        for size in [(1, 1), (4, 1)] {
            let shaded = RgbImage::new(size.0, size.1);
            let pictures =
                |shaded| Pictures::new(&[None; 4], &[0.0; 4], RgbImage::new(2, 2), shaded);
            let error = pictures(Some(&shaded)).expect_err("refused");
            assert!(error.to_string().contains("shaded"), "{error}");
            let plain = pictures(None).expect("pictures");
            let error = plain.with_decisions(&shaded).expect_err("refused");
            assert!(error.to_string().contains("decisions"), "{error}");
        }
    }
}
