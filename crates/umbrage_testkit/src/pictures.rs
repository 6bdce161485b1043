//! Pictures held against stored ones.

use std::{fmt, path::Path};

use image::RgbImage;

/// A pixel differs where a channel does by more than so many of 255. Rounding in another rasteriser's
/// blending and filtering stays below it; an edge that falls on the other side of a pixel does not.
const TOLERANCE: u8 = 8;

/// The largest share of pixels that may differ. Software and hardware rasterisers break ties at edges, of
/// triangles and of shadows, their own way; edges are a few pixels in a hundred, ties a few of those.
const MOST_DIFFERING: f64 = 0.01;

/// The largest mean difference over all channels, of 255: it bounds what [`TOLERANCE`] lets pass
/// everywhere, such as a light that is a little too bright.
const MOST_MEAN: f64 = 0.5;

/// How two pictures differ.
pub struct Difference {
    /// The share of pixels of which a channel differs by more than 8 of 255.
    pub share: f64,
    /// The mean over all channels, of 255.
    pub mean: f64,
}

impl Difference {
    /// The difference of two pictures of one size.
    pub fn of(a: &RgbImage, b: &RgbImage) -> Self {
        let (mut pixels, mut sum) = (0u64, 0u64);
        for (a, b) in a.pixels().zip(b.pixels()) {
            let channels = || a.0.iter().zip(b.0).map(|(a, b)| a.abs_diff(b));
            pixels += u64::from(channels().any(|difference| difference > TOLERANCE));
            sum += channels().map(u64::from).sum::<u64>();
        }
        let count = f64::from(a.width()) * f64::from(a.height());
        Self {
            share: pixels as f64 / count,
            mean: sum as f64 / (3.0 * count),
        }
    }

    /// Whether rasterisers may differ by so much.
    pub fn is_small(&self) -> bool {
        self.share < MOST_DIFFERING && self.mean < MOST_MEAN
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.3} % of the pixels differ by more than {TOLERANCE}/255 (allowed {} %), and the mean \
             difference is {:.3}/255 (allowed {MOST_MEAN}/255)",
            100.0 * self.share,
            100.0 * MOST_DIFFERING,
            self.mean
        )
    }
}

/// Holds a picture against the one stored at `reference`. With `UMBRAGE_BLESS=1` in the environment it is stored there
/// instead.
///
/// # Errors
/// The file and what is wrong: there is no such picture, it has another size, or differs by more than rasterisers do. What
/// was found lies beside it then, with `found` before its ending.
pub fn check(picture: &RgbImage, reference: &Path) -> Result<(), String> {
    let name = reference.display();
    let save = |path: &Path| {
        let saved = picture.save(path);
        saved.map_err(|error| format!("{}: cannot be written: {error}", path.display()))
    };
    if std::env::var_os("UMBRAGE_BLESS").is_some_and(|value| value == "1") {
        return save(reference);
    }
    let wanted = image::open(reference)
        .map_err(|error| format!("{name}: no picture to compare with: {error}"))?
        .into_rgb8();
    let advice = || -> Result<String, String> {
        let found = reference.with_extension("found.png");
        save(&found)?;
        Ok(format!(
            "compare it with {}; where that is right, write it with UMBRAGE_BLESS=1",
            found.display()
        ))
    };
    if picture.dimensions() != wanted.dimensions() {
        let (was, is) = (wanted.dimensions(), picture.dimensions());
        let advice = advice()?;
        return Err(format!("{name}: its size is {was:?}, not {is:?}; {advice}"));
    }
    let difference = Difference::of(picture, &wanted);
    match difference.is_small() {
        true => Ok(()),
        false => Err(format!("{name}: {difference}; {}", advice()?)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences() {
        let grey = RgbImage::from_pixel(100, 100, image::Rgb([100; 3]));
        assert!(Difference::of(&grey, &grey).is_small());
        // One pixel in a hundred is too many; half as many are edges.
        let with = |pixels: u32, value: u8| {
            let mut image = grey.clone();
            for index in 0..pixels {
                image.put_pixel(index % 100, index / 100, image::Rgb([100, value, 100]));
            }
            Difference::of(&grey, &image)
        };
        assert!(with(50, 200).is_small());
        assert!(!with(100, 110).is_small());
        // A little everywhere is too much, too.
        assert!(with(10_000, 101).is_small());
        let brighter = RgbImage::from_pixel(100, 100, image::Rgb([101; 3]));
        let difference = Difference::of(&grey, &brighter);
        assert_eq!((difference.share, difference.mean), (0.0, 1.0));
        assert!(!difference.is_small());
    }

    #[test]
    fn what_is_missing_or_other_is_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("grey.png");
        let grey = RgbImage::from_pixel(4, 4, image::Rgb([100; 3]));
        let said = |picture: &RgbImage| check(picture, &path).expect_err("refused");
        assert!(said(&grey).contains("no picture to compare with"));
        grey.save(&path).expect("written");
        assert_eq!(check(&grey, &path), Ok(()));
        assert!(said(&RgbImage::new(3, 4)).contains("its size is (4, 4), not (3, 4)"));
        assert!(said(&RgbImage::new(4, 4)).contains("100.000 % of the pixels"));
        assert!(folder.path().join("grey.found.png").exists());
    }
}
