//! The scenes look as their pictures do, and need no permutation that the demo's manifest lacks.
//!
//! `UMBRAGE_BLESS=1 cargo test -p umbrage_examples` writes the pictures anew.

use std::{
    collections::BTreeSet,
    fmt, fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use image::RgbImage;
use umbrage::{
    compose::{Composer, Manifest, Target},
    methods::registry,
    render::{Gpu, RenderOptions, Rendered, Renderer, Scene, What},
    shader_library,
};

const SIZE: (u32, u32) = (480, 320);

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
struct Difference {
    /// The share of pixels that differ by more than [`TOLERANCE`].
    share: f64,
    /// The mean over all channels, of 255.
    mean: f64,
}

impl Difference {
    fn of(a: &RgbImage, b: &RgbImage) -> Self {
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

    fn is_small(&self) -> bool {
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

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// The names of the files in a folder that end in `extension`, without it.
fn names(folder: &Path, extension: &str) -> BTreeSet<String> {
    let paths = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path());
    paths
        .filter(|path| path.extension().is_some_and(|found| found == extension))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect()
}

fn scenes() -> BTreeSet<String> {
    let scenes = names(&folder("scenes"), "ron");
    assert!(!scenes.is_empty(), "no scenes");
    scenes
}

/// What is compared: for each scene its own picture, and a map's splits where there is most to see of them.
fn pictures() -> Vec<(String, String, What)> {
    let scenes = scenes().into_iter();
    let shaded = scenes.map(|name| (name.clone(), name, What::Shaded));
    let splits = (
        "avenue_splits".to_owned(),
        "avenue".to_owned(),
        What::Splits,
    );
    shaded.chain([splits]).collect()
}

fn renderer() -> Renderer {
    let composer = Composer::new(shader_library().expect("a library"), Target::webgpu());
    let gpu = Gpu::new().expect("an adapter");
    Renderer::new(
        Arc::new(gpu),
        Arc::new(composer),
        registry().expect("a registry"),
    )
}

fn render(
    renderer: &mut Renderer,
    scene: &str,
    (width, height): (u32, u32),
    what: What,
    method: Option<&str>,
) -> Rendered {
    let scene = Scene::load(folder("scenes").join(format!("{scene}.ron"))).expect("a scene");
    let options = RenderOptions {
        width,
        height,
        what,
        method: method.map(str::to_owned),
        ..RenderOptions::default()
    };
    renderer.render(&scene, &options).expect("a picture")
}

#[test]
fn scenes_look_as_their_pictures_do() {
    let bless = std::env::var_os("UMBRAGE_BLESS").is_some_and(|value| value == "1");
    let mut renderer = renderer();
    let mut wrong = Vec::new();
    for (name, scene, what) in pictures() {
        let rendered = render(&mut renderer, &scene, SIZE, what, None);
        let reference = folder("pictures").join(format!("{name}.png"));
        if bless {
            rendered.save_png(&reference).expect("written");
            continue;
        }
        let found = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
        rendered.save_png(&found).expect("written");
        let wanted = match image::open(&reference) {
            Ok(picture) => picture.into_rgb8(),
            Err(error) => {
                wrong.push(format!("{name}: no picture to compare with: {error}"));
                continue;
            }
        };
        let picture = rendered.to_image().into_rgb8();
        if picture.dimensions() != wanted.dimensions() {
            let (was, is) = (wanted.dimensions(), picture.dimensions());
            wrong.push(format!("{name}: the picture's size is {was:?}, not {is:?}"));
            continue;
        }
        let difference = Difference::of(&picture, &wanted);
        eprintln!("{name}: {difference}");
        if !difference.is_small() {
            wrong.push(format!(
                "{name}: {difference}; compare {} with {}",
                found.display(),
                reference.display()
            ));
        }
    }
    assert!(
        wrong.is_empty(),
        "{}\nWhere the new pictures are right, write them with `UMBRAGE_BLESS=1 cargo test -p umbrage_examples`",
        wrong.join("\n")
    );
}

#[test]
fn every_picture_is_a_scenes() {
    // The other direction, a scene without a picture, fails where they are compared.
    let known: BTreeSet<_> = pictures().into_iter().map(|(name, ..)| name).collect();
    for picture in names(&folder("pictures"), "png") {
        assert!(
            known.contains(&picture),
            "pictures/{picture}.png has no scene: remove it"
        );
    }
}

#[test]
fn scenes_need_no_permutation_that_the_manifest_lacks() {
    let manifest = Manifest::load(&folder("../permutations/demo.ron")).expect("a manifest");
    let composer = Composer::new(manifest.library().clone(), Target::webgpu());
    let variants = composer.select(manifest.selection());
    let checked: BTreeSet<_> = variants.map(|variant| variant.key()).collect();
    let mut renderer = renderer();
    for name in scenes() {
        for what in [What::Shaded, What::ShadowTerm, What::Splits] {
            let report = render(&mut renderer, &name, (96, 64), what, None).report;
            assert!(!report.permutations.is_empty(), "{name}");
            for used in report.permutations {
                assert!(
                    checked.contains(&used.key),
                    "{name} needs {} for {}, which no key of permutations/demo.ron gives: add it there",
                    used.key,
                    used.object
                );
            }
        }
    }
}

#[test]
fn a_picture_without_shadows_is_told_from_one_with_them() {
    let mut renderer = renderer();
    for name in scenes() {
        let [with, without] = [None, Some("none")].map(|method| {
            let rendered = render(&mut renderer, &name, SIZE, What::Shaded, method);
            rendered.to_image().into_rgb8()
        });
        let difference = Difference::of(&with, &without);
        assert!(!difference.is_small(), "{name}: {difference}");
    }
}

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
