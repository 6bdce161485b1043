//! Pictures that materials and lights read, with their mipmaps.

use std::{io::Cursor, path::Path, sync::LazyLock};

use super::SceneError;

/// A picture in 8-bit sRGB with linear opacity, and its mipmaps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// The picture, and each half as large as the one before, down to one texel.
    pub levels: Vec<Level>,
}

/// One size of an [`Image`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Level {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Red, green, blue (sRGB) and opacity, by rows from the top.
    pub rgba: Vec<[u8; 4]>,
}

impl Image {
    /// One white texel.
    pub fn white() -> Self {
        Self {
            levels: vec![Level {
                width: 1,
                height: 1,
                rgba: vec![[255; 4]],
            }],
        }
    }

    /// Decodes a PNG or JPEG file's `bytes`; `place` and `path` say in an error where they are from.
    pub(crate) fn decode(bytes: &[u8], path: &Path, place: &str) -> Result<Self, SceneError> {
        let decoded = image::ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(image::ImageError::from)
            .and_then(image::ImageReader::decode)
            .map_err(|error| {
                let problem = format!("the picture cannot be decoded: {error}");
                SceneError::invalid(path, place, problem, "give a PNG or JPEG file")
            })?
            .to_rgba8();
        let (width, height) = decoded.dimensions();
        let rgba = decoded.pixels().map(|pixel| pixel.0).collect();
        let mut levels = vec![Level {
            width,
            height,
            rgba,
        }];
        while let Some(next) = levels.last().and_then(Level::half) {
            levels.push(next);
        }
        Ok(Self { levels })
    }
}

impl Level {
    /// The level half as large: the mean of two by two texels, in linear light, colours weighted by
    /// their opacity so that what is cut away does not bleed into what is kept.
    fn half(&self) -> Option<Self> {
        if self.width <= 1 && self.height <= 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut rgba = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let texels = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| {
                    let column = (2 * x + i).min(self.width - 1) as usize;
                    let row = (2 * y + j).min(self.height - 1) as usize;
                    self.rgba[row * self.width as usize + column]
                });
                rgba.push(mean(texels));
            }
        }
        Some(Self {
            width,
            height,
            rgba,
        })
    }
}

fn mean(texels: [[u8; 4]; 4]) -> [u8; 4] {
    let opacity: u32 = texels.iter().map(|t| u32::from(t[3])).sum();
    let mut out = [0; 4];
    for (channel, value) in out.iter_mut().enumerate().take(3) {
        let sum: f32 = texels
            .iter()
            .map(|t| {
                let weight = if opacity > 0 { f32::from(t[3]) } else { 1.0 };
                weight * LINEAR[usize::from(t[channel])]
            })
            .sum();
        *value = encode_srgb(sum / if opacity > 0 { opacity as f32 } else { 4.0 });
    }
    out[3] = ((opacity + 2) / 4) as u8;
    out
}

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|code| {
        let code = code as f32 / 255.0;
        if code <= 0.04045 {
            code / 12.92
        } else {
            ((code + 0.055) / 1.055).powf(2.4)
        }
    })
});

/// The 8-bit sRGB code (IEC 61966-2-1) of a linear value; what lies outside 0..1 is clamped.
pub(crate) fn encode_srgb(linear: f32) -> u8 {
    let linear = if linear.is_nan() {
        0.0
    } else {
        linear.clamp(0.0, 1.0)
    };
    let code = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (code * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_codes_survive_the_way_to_linear_and_back() {
        for code in 0..=255_u8 {
            assert_eq!(encode_srgb(LINEAR[usize::from(code)]), code);
        }
        assert_eq!(encode_srgb(f32::NAN), 0);
        assert_eq!(encode_srgb(f32::INFINITY), 255);
    }

    #[test]
    fn mipmaps_end_at_one_texel_and_keep_opaque_colours() {
        let rgba = vec![
            [200, 40, 10, 255],
            [0, 0, 0, 0],
            [200, 40, 10, 255],
            [0, 0, 0, 0],
            [0; 4],
        ];
        let level = Level {
            width: 5,
            height: 1,
            rgba,
        };
        let half = level.half().expect("smaller");
        assert_eq!((half.width, half.height), (2, 1));
        assert_eq!(half.rgba[0], [200, 40, 10, 128]);
        assert!(half.half().expect("smaller").half().is_none());
    }
}
