//! Results of a rendering.

use std::{io::Cursor, path::Path, sync::Arc};

use umbrage_compose::{Key, Permutation, ProjectedKey, Purpose, Source};
use umbrage_shadow::ShadowPlan;

use crate::{RenderError, scene::encode_srgb};

/// A rendered picture, and how it came about.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The pixels.
    pub picture: Picture,
    /// The adapter that rendered it.
    pub adapter: String,
    /// How it came about.
    pub report: Report,
}

/// Pixels, by rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Picture {
    /// Linear RGB.
    Shaded(Vec<[f32; 3]>),
    /// For each light its shadow term: 1 lit, 0 in shadow; 1 where there is nothing to see.
    ShadowTerm(Vec<Vec<f32>>),
    /// The object, by its place in [`Scene::objects`](crate::Scene::objects), and the triangle, by its
    /// place in the object's mesh; none where there is nothing to see.
    Triangles(Vec<Option<(u32, u32)>>),
    /// For each light how many texture fetches its shadow term takes, 0 where there is nothing to see; or its shafts
    /// take, 0 where the light does not reach the air that is seen.
    Fetches(Vec<Vec<f32>>),
    /// For each light how its shadow term was found.
    Decisions(Vec<Vec<Decision>>),
    /// The shadow map that is read, of several.
    Splits {
        /// Linear RGB.
        colors: Vec<[f32; 3]>,
        /// For each light the number of the caster pass that fills what is read at the pixel's depth; none where
        /// there is nothing to see, no shadow any more, or one map for all depths.
        splits: Vec<Vec<Option<u32>>>,
    },
}

/// How a pixel's shadow term was found: what the filter that sampled last noted of it, in the shader library's
/// `common/decision.wesl`.
#[derive(serde::Serialize, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[serde(rename_all = "snake_case")]
pub enum Decision {
    /// No map was sampled, or by a method that notes nothing: there is nothing to see, or what is seen lies beside
    /// all maps.
    #[default]
    Unsampled,
    /// By filtering all of the receiver's footprint.
    Filtered,
    /// Lit, as no depth around is greater.
    LitByDepth,
    /// Lit, as it lies before a plane that no depth around is before.
    LitByPlane,
    /// In shadow, as all depths around are greater.
    ShadowedByDepth,
    /// In shadow, as it lies behind a plane that all depths around are before.
    ShadowedByPlane,
}

impl Decision {
    /// All, by the shader's numbers.
    pub const ALL: [Self; 6] = [
        Self::Unsampled,
        Self::Filtered,
        Self::LitByDepth,
        Self::LitByPlane,
        Self::ShadowedByDepth,
        Self::ShadowedByPlane,
    ];

    /// Whether `permutation`, of the pass `decision`, can find a term without filtering: whether anything in it notes
    /// how. If not, its decisions are [`Unsampled`](Self::Unsampled) and [`Filtered`](Self::Filtered) alone.
    #[must_use]
    pub fn spares_filter(permutation: &Permutation) -> bool {
        let functions = permutation.module.functions.iter();
        let mut names = functions.filter_map(|(_, function)| function.name.as_deref());
        names.any(|name| name == "note_decision")
    }

    /// The decision with the shader's `number`.
    pub(crate) fn of(number: f32) -> Self {
        let known = Self::ALL.get(number as usize);
        known.copied().unwrap_or_default()
    }

    /// Its false colour, sRGB: black, red, light and dark yellow for light, light and dark blue for shadow.
    #[must_use]
    pub fn color(self) -> [u8; 3] {
        match self {
            Self::Unsampled => [0, 0, 0],
            Self::Filtered => [220, 50, 47],
            Self::LitByDepth => [255, 250, 205],
            Self::LitByPlane => [240, 190, 40],
            Self::ShadowedByDepth => [125, 200, 235],
            Self::ShadowedByPlane => [30, 90, 160],
        }
    }
}

/// How a picture came about.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// The distinct permutations that it needed, in the order in which they were first needed.
    pub permutations: Vec<PermutationUse>,
    /// Warnings for a person, such as of a damaged cache entry that was dropped.
    pub warnings: Vec<String>,
    /// Render passes.
    pub passes: u32,
    /// Draw calls.
    pub draws: u32,
    /// Render passes that draw casters into shadow maps.
    pub caster_passes: u32,
    /// Passes that compute something from shadow maps, full-screen ones and compute shaders.
    pub derived_passes: u32,
    /// How many passes of plans were not run, as what they would fill stands there from a picture before.
    pub kept_passes: u32,
    /// Passes that draw casters into those parts of shadow maps that moved casters changed.
    pub repaired_passes: u32,
    /// Draw calls that are in caster passes.
    pub caster_draws: u32,
    /// Triangles that they draw.
    pub caster_triangles: u64,
    /// Vertices of what they draw, each once for each pass that draws it.
    pub caster_vertices: u64,
    /// Draw calls whose pipelines are not made yet, where the picture does [not wait](crate::RenderOptions::meanwhile).
    pub waiting: u32,
    /// How far shadow terms may be off for the sake of what [stands in](crate::StandIn), as it says; 0 where nothing does.
    pub stand_in_error: f64,
    /// Texels in the textures of shadow methods.
    pub texels: u64,
    /// Bytes of these textures, by their formats; what a driver adds is not known.
    pub shadow_bytes: u64,
    /// Bytes of what the [mask path](crate::Path::Mask) keeps beside the picture, by its formats: 20 a pixel,
    /// 16 for the planes that are seen and 4 for the mask, which all lights share; 4 more for the pixels'
    /// regions where a mask is filled [by split](crate::Path::MaskBySplit); 0 where no light has a mask, but for the
    /// planes where a method asks for the depths that are seen.
    pub mask_bytes: u64,
    /// Texture fetches that the shadow methods promise to make at the most for a pixel, over all lights
    /// that reach something.
    pub fetches_per_pixel: u32,
    /// Plan of each light's method, by the lights' places in the scene; none where it has no
    /// method, or reaches nothing that is seen.
    pub plans: Vec<Option<Arc<ShadowPlan>>>,
    /// The passes' times, in the order in which they ran: taken by the device's clock, where
    /// [`timed`](crate::RenderOptions::timed) asks for them and [the device has
    /// one](crate::Gpu::has_timestamps), else empty.
    pub times: Vec<PassTime>,
    /// Wall-clock time from submitting the passes to their end, uploads of what is new among them, over
    /// all submissions (a shadow term's or a fetch count's are one a light); milliseconds. The figure
    /// to go by where passes cannot be timed.
    pub gpu_milliseconds: f64,
    /// Wall-clock time from the scene to the pixels in memory; milliseconds.
    pub milliseconds: f64,
}

/// How long a pass took.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// Kind of pass: `casters`, or the value of the axis `pass` that it has, such as `illumination`; of the passes
    /// that fill a mask by regions, with the region's number: `mask 0`.
    pub pass: String,
    /// The light for which it drew, where it did so for one.
    pub light: Option<String>,
    /// Use of its results.
    pub purpose: Purpose,
    /// Between the pass's beginning and its end, or between the end of a compute pass and that of the compute pass that
    /// follows it; milliseconds of the device's clock.
    pub milliseconds: f64,
}

/// A permutation that a picture needed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PermutationUse {
    /// Its projected key.
    pub key: ProjectedKey,
    /// The same of the further lights that it is for.
    pub others: Vec<ProjectedKey>,
    /// Use of its pass's results.
    pub purpose: Purpose,
    /// Whether it was linked for this picture, or came from a cache.
    pub source: Source,
    /// The object that first needed it.
    pub object: String,
    /// The light that first needed it, where one did.
    pub light: Option<String>,
}

impl PermutationUse {
    /// Its keys: of a shader of several lights, one for each.
    pub fn keys(&self) -> Vec<Key> {
        let keys = std::iter::once(&self.key).chain(&self.others);
        keys.cloned().map(Key::from).collect()
    }
}

impl Report {
    /// How many permutations were linked for this picture.
    pub fn composed(&self) -> usize {
        self.permutations
            .iter()
            .filter(|used| used.source == Source::Linked)
            .count()
    }

    /// How many permutations came from a cache.
    pub fn cached(&self) -> usize {
        self.permutations.len() - self.composed()
    }
}

impl Rendered {
    /// The picture in 8 bits, as [`save_png`](Self::save_png) writes it: see [`Picture::to_image`].
    pub fn to_image(&self) -> image::DynamicImage {
        self.picture.to_image(self.width, self.height)
    }

    /// Writes the picture as PNG. The file appears whole or not at all.
    ///
    /// # Errors
    /// A folder that is missing or cannot be written to.
    pub fn save_png(&self, path: impl AsRef<Path>) -> Result<(), RenderError> {
        self.picture.save_png(self.width, self.height, path)
    }
}

impl Picture {
    /// The picture of the given size in 8 bits: a shaded one in RGB, clamped to 0..1 without exposure
    /// or tone mapping and encoded as sRGB; a shadow term as grey, the product over the lights, not
    /// encoded: code 255 is lit; triangles each in a colour of its own, black where there is none;
    /// fetches as grey, the sum over the lights, code 255 for the most in the picture; decisions in false colours, the
    /// mean over the lights: black where no map was sampled, red where it was filtered, yellow where the term was light
    /// at once and blue where it was shadow, the darker ones by planes; splits as a shaded picture that each has a hue
    /// of its own in, by the first light that has some.
    pub fn to_image(&self, width: u32, height: u32) -> image::DynamicImage {
        let index = |x: u32, y: u32| y as usize * width as usize + x as usize;
        match self {
            Self::Shaded(pixels) => image::RgbImage::from_fn(width, height, |x, y| {
                let pixel = pixels.get(index(x, y)).copied().unwrap_or_default();
                image::Rgb(pixel.map(encode_srgb))
            })
            .into(),
            Self::Splits { colors, splits } => image::RgbImage::from_fn(width, height, |x, y| {
                let pixel = index(x, y);
                let [r, g, b] = colors.get(pixel).copied().unwrap_or_default();
                let mut of_lights = splits.iter().map(|light| light.get(pixel).copied());
                let split = of_lights.find_map(Option::flatten);
                let hue = split.map_or([1.0; 3], |split| HUES[split as usize % HUES.len()]);
                image::Rgb([r * hue[0], g * hue[1], b * hue[2]].map(encode_srgb))
            })
            .into(),
            Self::ShadowTerm(lights) => image::GrayImage::from_fn(width, height, |x, y| {
                let terms = lights.iter().filter_map(|light| light.get(index(x, y)));
                let product: f32 = terms.product();
                image::Luma([(product.clamp(0.0, 1.0) * 255.0).round() as u8])
            })
            .into(),
            Self::Triangles(pixels) => image::RgbImage::from_fn(width, height, |x, y| {
                let seen = pixels.get(index(x, y)).copied().flatten();
                image::Rgb(seen.map(triangle_color).unwrap_or_default())
            })
            .into(),
            Self::Fetches(lights) => {
                let sum = |pixel: usize| -> f32 {
                    lights.iter().filter_map(|light| light.get(pixel)).sum()
                };
                let pixels = lights.iter().map(Vec::len).max().unwrap_or_default();
                let most = (0..pixels).map(sum).fold(1.0, f32::max);
                image::GrayImage::from_fn(width, height, |x, y| {
                    image::Luma([(sum(index(x, y)) / most * 255.0).round() as u8])
                })
                .into()
            }
            Self::Decisions(lights) => image::RgbImage::from_fn(width, height, |x, y| {
                let decisions = lights.iter().filter_map(|light| light.get(index(x, y)));
                let colors = decisions.map(|decision| decision.color().map(u32::from));
                let sum = colors.fold([0; 3], |[r, g, b], [s, t, u]| [r + s, g + t, b + u]);
                image::Rgb(sum.map(|sum| (sum / lights.len().max(1) as u32) as u8))
            })
            .into(),
        }
    }

    /// Writes the picture of the given size as PNG. The file appears whole or not at all.
    ///
    /// # Errors
    /// A folder that is missing or cannot be written to.
    pub fn save_png(
        &self,
        width: u32,
        height: u32,
        path: impl AsRef<Path>,
    ) -> Result<(), RenderError> {
        let path = path.as_ref();
        let unwritable = |source| RenderError::Unwritable {
            path: path.to_owned(),
            source,
        };
        let mut bytes = Vec::new();
        self.to_image(width, height)
            .write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Png)
            .map_err(|error| unwritable(std::io::Error::other(error)))?;
        umbrage_compose::write_whole(path, &bytes).map_err(unwritable)
    }
}

/// Colours that tell splits apart: for each of the most of them another, neighbours far from each other.
const HUES: [[f32; 3]; 8] = [
    [1.0, 0.3, 0.3],
    [0.3, 1.0, 0.3],
    [0.35, 0.5, 1.0],
    [1.0, 0.9, 0.25],
    [1.0, 0.35, 1.0],
    [0.25, 1.0, 1.0],
    [1.0, 0.55, 0.2],
    [0.6, 0.4, 1.0],
];

/// A colour that neighbours hardly share and black is not: the last mixing of MurmurHash3 (Appleby
/// 2011).
fn triangle_color((object, triangle): (u32, u32)) -> [u8; 3] {
    let mut hash = triangle ^ object.rotate_left(16);
    for (shift, factor) in [(16, 0x85eb_ca6b), (13, 0xc2b2_ae35), (16, 1)] {
        hash = (hash ^ (hash >> shift)).wrapping_mul(factor);
    }
    let [r, g, b, _] = hash.to_le_bytes();
    [r, g, b].map(|code| 64 + code / 4 * 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rendered(picture: Picture) -> Rendered {
        let report = Report::default();
        Rendered {
            width: 2,
            height: 1,
            picture,
            adapter: String::new(),
            report,
        }
    }

    #[test]
    fn shaded_pictures_are_clamped_and_encoded() {
        let image = rendered(Picture::Shaded(vec![
            [0.0, 0.5, 2.0],
            [f32::NAN, -1.0, 1.0],
        ]));
        assert_eq!(
            image.to_image().into_rgb8().into_raw(),
            [0, 188, 255, 0, 0, 255]
        );
    }

    #[test]
    fn shadow_terms_are_multiplied() {
        let image = rendered(Picture::ShadowTerm(vec![vec![1.0, 0.5], vec![0.5, 0.5]]));
        assert_eq!(image.to_image().into_luma8().into_raw(), [128, 64]);
    }

    #[test]
    fn triangles_have_colours_of_their_own() {
        let color = |seen| {
            let image = rendered(Picture::Triangles(vec![seen, None])).to_image();
            let codes = image.into_rgb8().into_raw();
            assert_eq!(codes[3..], [0; 3], "nothing is black");
            [codes[0], codes[1], codes[2]]
        };
        let mut colors: Vec<_> = (0..8)
            .flat_map(|object| (0..8).map(move |triangle| Some((object, triangle))))
            .map(color)
            .collect();
        assert!(colors.iter().flatten().all(|code| *code >= 64));
        colors.sort_unstable();
        colors.dedup();
        assert_eq!(colors.len(), 64);
    }

    #[test]
    fn splits_are_tinted() {
        let codes = |splits| {
            let colors = vec![[1.0; 3]; 2];
            let image = rendered(Picture::Splits { colors, splits }).to_image();
            image.into_rgb8().into_raw()
        };
        let light = |first, second| vec![vec![first, second]];
        assert_eq!(codes(light(None, Some(0)))[..4], [255; 4]);
        let (a, b) = (
            codes(light(Some(0), Some(1))),
            codes(light(Some(1), Some(0))),
        );
        assert_eq!((&a[..3], &a[3..]), (&b[3..], &b[..3]));
        assert_ne!(a, b);
        // Of several lights, the first that has splits there.
        let of_both = vec![vec![None, Some(1)], vec![Some(0), Some(5)]];
        assert_eq!(codes(of_both), a);
    }

    #[test]
    fn fetches_are_added_up_and_scaled() {
        let image = rendered(Picture::Fetches(vec![vec![1.0, 0.0], vec![3.0, 1.0]]));
        assert_eq!(image.to_image().into_luma8().into_raw(), [255, 64]);
        let none = rendered(Picture::Fetches(vec![vec![0.0, 0.0]]));
        assert_eq!(none.to_image().into_luma8().into_raw(), [0, 0]);
    }

    #[test]
    fn decisions_have_colours_of_their_own() {
        let picture = Picture::Decisions(vec![
            vec![Decision::Filtered, Decision::Unsampled],
            vec![Decision::Filtered, Decision::LitByDepth],
        ]);
        let image = rendered(picture).to_image().into_rgb8();
        assert_eq!(image.into_raw(), [220, 50, 47, 127, 125, 102]);
        let mut colors = Decision::ALL.map(Decision::color).to_vec();
        colors.sort_unstable();
        colors.dedup();
        assert_eq!(colors.len(), Decision::ALL.len());
        // By the shader's numbers, and what is none of them.
        assert_eq!(
            [0.0, 1.0, 5.0, 9.0].map(Decision::of),
            [
                Decision::Unsampled,
                Decision::Filtered,
                Decision::ShadowedByPlane,
                Decision::Unsampled,
            ]
        );
    }

    #[test]
    fn pictures_are_written_whole_or_not_at_all() {
        let dir = tempfile::TempDir::new().expect("a folder");
        let image = rendered(Picture::Shaded(vec![[1.0; 3]; 2]));
        let path = dir.path().join("a.png");
        image.save_png(&path).expect("written");
        assert_eq!(
            image::open(&path)
                .expect("a picture")
                .into_rgb8()
                .into_raw(),
            [255; 6]
        );
        // A folder stands where the file should go.
        let error = image.save_png(dir.path()).expect_err("refused").to_string();
        assert!(error.contains("cannot write"), "{error}");
        assert!(image.save_png(dir.path().join("gone/a.png")).is_err());
        assert_eq!(std::fs::read_dir(dir.path()).expect("listed").count(), 1);
    }
}
