//! Permutations are drawn, and their shadow terms compared with an oracle that shares nothing with the GPU: a cover of the
//! whole space, and all that the demo, `compare` and `stress` need.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{collections::BTreeMap, sync::Arc};

use rayon::prelude::*;
use umbrage::{
    compose::{Composer, Key, Library, Purpose, Target},
    render::{Decision, Gpu, Path as Way, Picture, RenderOptions, Rendered, Renderer, What},
};
use umbrage_tests::{
    Oracle, Pixel, Stage, colored_package, covering, of_each_depth, registry, stage, used,
};

const SIZE: u32 = 40;
/// Steps along a ray through the air.
const STEPS: u32 = 16;
/// Texels along a shadow map: coarse, so that filters are as wide as shadows.
const RESOLUTION: u32 = 96;

/// The axes of shadow methods, which an unshadowed picture has none of; but for the bias, as the air is sampled without a
/// plane whatever is chosen of it.
const SHADOW_AXES: [&str; 8] = [
    "block",
    "depth",
    "filter",
    "lookup",
    "method",
    "pcf",
    "taper",
    "transition",
];

/// With a method of the tests' own, which no manifest knows.
fn library() -> Library {
    let ours = umbrage::shader_package().expect("the shader library is sound");
    let colored = colored_package().expect("the test's own is sound");
    Library::new([ours, colored]).expect("they fit together")
}

struct Studio {
    renderer: Renderer,
    composer: Arc<Composer>,
    unshadowed: BTreeMap<String, Vec<[f32; 3]>>,
    terms: BTreeMap<String, Vec<Pixel>>,
}

impl Studio {
    fn new() -> Self {
        let gpu = Arc::new(Gpu::new().unwrap_or_else(|error| panic!("{error}")));
        let composer = Arc::new(Composer::new(library(), Target::webgpu()));
        let registry = registry();
        let renderer = Renderer::new(gpu, composer.clone(), registry);
        Self {
            renderer,
            composer,
            unshadowed: BTreeMap::new(),
            terms: BTreeMap::new(),
        }
    }

    fn render(&mut self, stage: &Stage, what: What, path: Way) -> Rendered {
        let options = RenderOptions {
            width: SIZE,
            height: SIZE,
            what,
            path,
            shaft_steps: STEPS,
            ..RenderOptions::default()
        };
        self.renderer
            .render(&stage.scene, &options)
            .unwrap_or_else(|error| panic!("{error}"))
    }

    /// Draws `key`'s permutation, and says what is wrong with it.
    fn check(&mut self, key: &Key) -> Option<String> {
        let axes = self.composer.library().axes().clone();
        let value = |axis: &str| axes.value(key, axis).unwrap_or("");
        let drawn = self.staged(key);
        let what = match value("pass") {
            "illumination" | "base" | "haze" | "shafts" => What::Shaded,
            "decision" => What::Decisions,
            "shaft_fetches" => What::ShaftFetches,
            "fetch_count" => What::Fetches,
            "triangle" => What::Triangles,
            _ => What::ShadowTerm,
        };
        let path = match (value("pass"), value("method")) {
            ("region", _) => Way::MaskBySplit,
            ("linear_depth" | "mask", _) | (_, "mask") => Way::Mask,
            _ => Way::Forward,
        };
        let rendered = self.render(&drawn, what, path);
        let projected = self.composer.project(key).expect("it was projected before");
        if !rendered
            .report
            .permutations
            .iter()
            .any(|used| used.key == projected)
        {
            return Some(format!("{key} was not drawn"));
        }
        let between =
            |[least, most]: [u32; 2], count: f32| (least as f32..=most as f32).contains(&count);
        let wrong = match (&rendered.picture, value("pass")) {
            // Its depths are held to a picture's own where they are read: `seen.rs` of the renderer.
            (_, "depth_range") => None,
            (Picture::ShadowTerm(terms), pass) => {
                let rounding = match pass {
                    "caster_depth" => DEPTH_ROUNDING,
                    _ => ROUNDING,
                };
                compare(&self.expected(key, &drawn), rounding, |pixel| {
                    Some(f64::from(terms[0][pixel]))
                })
            }
            (Picture::Fetches(counts), "shaft_fetches") => {
                // Nowhere is nothing fetched.
                compare_all(
                    &drawn,
                    &counts[0],
                    [u32::MAX; 2],
                    between,
                    |oracle, x, y| {
                        let sure = oracle.air_fetches(x, y, SIZE, STEPS);
                        sure.map_err(|_| Pixel::Edge)
                    },
                )
            }
            (Picture::Fetches(counts), _) => {
                let promised = rendered.report.fetches_per_pixel;
                compare_all(&drawn, &counts[0], [0; 2], between, |oracle, x, y| {
                    oracle.fetches(x, y, SIZE, SIZE)
                })
                .or_else(|| exceeds(&counts[0], promised))
            }
            (Picture::Triangles(seen), _) => {
                let same = |expected, found| expected == found;
                compare_all(&drawn, seen, None, same, |oracle, x, y| {
                    let (object, triangle) = oracle.triangle(x, y, SIZE, SIZE)?;
                    Ok(Some((object as u32, triangle as u32)))
                })
            }
            (Picture::Decisions(decisions), _) => {
                let decides = self.composer.compose(key).expect("it was drawn");
                let decides = Decision::spares_filter(&decides.permutation);
                misjudged(&self.expected(key, &drawn), &decisions[0], decides)
            }
            (Picture::Shaded(colors), "haze") => {
                compare(&self.expected(key, &drawn), ROUNDING, |pixel| {
                    // The background is black.
                    Some(f64::from(colors[pixel][0] / 0.8)).filter(|share| *share > 0.0)
                })
            }
            // The base pass knows no light: that it is drawn, and valid, is all.
            (_, "base") | (Picture::Splits { .. }, _) => None,
            (Picture::Shaded(colors), _) => {
                let unshadowed = self.unshadowed(key);
                compare(&self.expected(key, &drawn), ROUNDING, |pixel| {
                    let brightest =
                        |color: [f32; 3]| f64::from(color[0].max(color[1]).max(color[2]));
                    let lit = brightest(unshadowed[pixel]);
                    // Where the light hardly arrives, the term cannot be told from the colour.
                    (lit > 0.01).then(|| brightest(colors[pixel]) / lit)
                })
            }
        };
        wrong.map(|wrong| format!("{key}: {wrong}"))
    }

    fn staged(&self, key: &Key) -> Stage {
        let library = self.composer.library();
        // A key that draws no light of its own is drawn under a shadow method's, casters and all.
        let method = library.axes().value(key, "method").unwrap_or("none");
        let pass = library.axes().value(key, "pass").unwrap_or("");
        let caster_of = match pass {
            "caster" | "linear_depth" if method == "none" => Some("basic"),
            // Whatever method a mask is of, its readers are the same.
            _ if method == "mask" => Some("basic"),
            "caster_depth" => Some("colored"),
            "caster_faces" => Some("basic"),
            // They have what they work from for the sake of splits.
            "depth_range" | "region" => Some("pssm"),
            _ => match library.axes().pass(key).map(|pass| pass.purpose) {
                // Only splits can have filters of several widths.
                Some(Purpose::Maps) if library.axes().value(key, "taper") == Some("on") => {
                    Some("pssm")
                }
                Some(Purpose::Maps) => Some("basic"),
                _ => None,
            },
        };
        let key = match caster_of {
            Some(method) => {
                let choices = key.choices().filter(|(axis, _)| *axis != "method");
                let depths = match pass {
                    "caster_faces" => Some(("depth", "midpoint")),
                    "depth_range" => Some(("range", "depths")),
                    _ => None,
                };
                let key = library.key(choices.chain([("method", method)]).chain(depths));
                key.expect("a caster under a method")
            }
            None => key.clone(),
        };
        let resolution = match pass {
            // Finer, so that something is decided within the widest filter's reach.
            "decision" => 4 * RESOLUTION,
            _ => RESOLUTION,
        };
        stage(library, &key, resolution)
    }

    /// The pixels as the oracle sees them, the same for all keys that differ in what it does not know.
    fn expected(&mut self, key: &Key, drawn: &Stage) -> Vec<Pixel> {
        let axes = self.composer.library().axes();
        let known = [
            "block",
            "camera",
            "light",
            "method",
            "pcf",
            "receiver_bias",
            "depth",
            "filter",
            "lookup",
            "taper",
            "transition",
            "alpha_test",
            "base_color_texture",
            "vertex_color",
            "cookie",
        ];
        let name: Vec<_> = known
            .iter()
            .map(|axis| axes.value(key, axis).unwrap_or(""))
            .collect();
        let pass = axes.value(key, "pass").unwrap_or("");
        let methods_own = [
            "caster",
            "caster_depth",
            "caster_faces",
            "decision",
            "haze",
            "linear_depth",
            "region",
            "shafts",
        ]
        .contains(&pass);
        let name = format!("{name:?} {}", if methods_own { pass } else { "" });
        if let Some(done) = self.terms.get(&name) {
            return done.clone();
        }
        let registry = registry();
        let oracle =
            Oracle::new(drawn, &registry, SIZE, SIZE).expect("the oracle knows the method");
        let pixel = |x, y| match pass {
            "caster_depth" => oracle.stored(x, y, SIZE, SIZE),
            "haze" => oracle.haze(x, y, SIZE),
            "shafts" => oracle.shafts(x, y, SIZE, STEPS),
            _ => oracle.pixel(x, y, SIZE, SIZE),
        };
        let pixels: Vec<_> = (0..SIZE * SIZE)
            .map(|i| pixel(i % SIZE, i / SIZE))
            .collect();
        self.terms.insert(name, pixels.clone());
        pixels
    }

    /// The same picture without any shadow.
    fn unshadowed(&mut self, key: &Key) -> Vec<[f32; 3]> {
        let library = self.composer.library().clone();
        let choices = key
            .choices()
            .filter(|(axis, _)| !SHADOW_AXES.contains(axis));
        let plain = library
            .key(choices.chain([("method", "none")]))
            .expect("a key without a method");
        if let Some(done) = self.unshadowed.get(&plain.to_string()) {
            return done.clone();
        }
        let rendered = self.render(
            &stage(&library, &plain, RESOLUTION),
            What::Shaded,
            Way::Forward,
        );
        let Picture::Shaded(colors) = rendered.picture else {
            unreachable!("a shaded picture was asked for")
        };
        self.unshadowed.insert(plain.to_string(), colors.clone());
        colors
    }
}

/// Bilinear weights have 8 bits on many devices, and colours 11.
const ROUNDING: f64 = 0.005;

/// Depth is all floats: a device interpolates a few units in the last of 1 off.
const DEPTH_ROUNDING: f64 = 1e-5;

/// How the rendered terms differ from the expected ones, where they do by more than rounding.
fn compare(
    expected: &[Pixel],
    rounding: f64,
    rendered: impl Fn(usize) -> Option<f64>,
) -> Option<String> {
    let (mut compared, mut wrong, mut worst, mut vague) = (0u32, 0u32, 0.0f64, 0u32);
    for (pixel, expected) in expected.iter().enumerate() {
        let (&Pixel::Term(dark, lit), Some(term)) = (expected, rendered(pixel)) else {
            continue;
        };
        let off = (dark - term).max(term - lit);
        compared += 1;
        worst = worst.max(off);
        vague += u32::from(lit - dark > 0.2);
        // NaN is wrong, too.
        wrong += u32::from(off.is_nan() || off > rounding);
    }
    // An oracle that allows anything would agree with anything.
    let sharp = compared > SIZE * SIZE / 2 && vague < compared / 25;
    (!sharp || wrong > 0).then(|| {
        format!("{wrong} of {compared} pixels differ, by {worst:.3} at the most; {vague} are vague")
    })
}

/// How what was rendered differs from what the oracle says of each pixel. Where nothing is seen it is
/// `nothing`.
fn compare_all<E: Copy + std::fmt::Debug + PartialEq, T: Copy + std::fmt::Debug>(
    drawn: &Stage,
    rendered: &[T],
    nothing: E,
    holds: impl Fn(E, T) -> bool,
    expected: impl Fn(&Oracle<'_>, u32, u32) -> Result<E, Pixel>,
) -> Option<String> {
    let registry = registry();
    let oracle = Oracle::new(drawn, &registry, SIZE, SIZE).expect("the oracle knows the method");
    let expected: Vec<_> = (0..SIZE * SIZE)
        .map(|pixel| expected(&oracle, pixel % SIZE, pixel / SIZE))
        .collect();
    // A thing that a ray passes by closely, a rasteriser may see.
    let beside_something = |pixel: u32| {
        let (x, y) = (pixel % SIZE, pixel / SIZE);
        let near = |at: u32| at.saturating_sub(1)..=(at + 1).min(SIZE - 1);
        near(y)
            .any(|y| near(x).any(|x| expected[(y * SIZE + x) as usize] != Err(Pixel::Background)))
    };
    let (mut compared, mut wrong) = (0, Vec::new());
    for (pixel, (expected, rendered)) in (0..).zip(expected.iter().zip(rendered)) {
        let expected = match expected {
            Ok(expected) => *expected,
            Err(Pixel::Background) if !beside_something(pixel) => nothing,
            Err(_) => continue,
        };
        compared += 1;
        if !holds(expected, *rendered) {
            wrong.push((pixel % SIZE, pixel / SIZE, expected, *rendered));
        }
    }
    (compared < SIZE * SIZE / 2 || !wrong.is_empty()).then(|| {
        let first = wrong.first();
        format!(
            "{} of {compared} pixels differ, first {first:?}",
            wrong.len()
        )
    })
}

/// How decisions differ from what is expected: what is decided at once is all light, or none; some pixels are, where
/// the shader `decides`.
fn misjudged(expected: &[Pixel], decisions: &[Decision], decides: bool) -> Option<String> {
    let (mut decided, mut wrong) = (0, 0);
    for (expected, decision) in expected.iter().zip(decisions) {
        let lit = match decision {
            Decision::LitByDepth | Decision::LitByPlane => true,
            Decision::ShadowedByDepth | Decision::ShadowedByPlane => false,
            Decision::Unsampled | Decision::Filtered => continue,
        };
        decided += 1;
        wrong += u32::from(match *expected {
            Pixel::Term(_, lightest) if lit => lightest < 1.0 - ROUNDING,
            Pixel::Term(darkest, _) => darkest > ROUNDING,
            Pixel::Background | Pixel::Edge => false,
        });
    }
    ((decided > 0) != decides || wrong > 0)
        .then(|| format!("{wrong} of {decided} decisions are wrong"))
}

/// Whether some count is more than its method promised.
fn exceeds(counts: &[f32], promised: u32) -> Option<String> {
    let most = counts.iter().copied().fold(0.0, f32::max);
    (most > promised as f32).then(|| format!("{most} fetches, but {promised} were promised"))
}

#[test]
fn permutations_are_drawn_as_the_oracle_says() {
    let ours = umbrage::shader_library().expect("the shader library is sound");
    let composer = Arc::new(Composer::new(ours, Target::webgpu()));
    let gpu = Arc::new(Gpu::new().unwrap_or_else(|error| panic!("{error}")));
    let mut keys = covering(&composer).unwrap_or_else(|error| panic!("{error}"));
    let used = used(&gpu, &composer).unwrap_or_else(|error| panic!("{error}"));
    for key in &used {
        // By itself, as by all keys that cannot differ from it.
        let known = composer.library().parse_key(&key.to_string());
        let projected = known.and_then(|known| composer.project(&known));
        assert_eq!(projected.as_ref().ok(), Some(key), "{projected:?}");
    }
    eprintln!("{} of a cover, {} used", keys.len(), used.len());
    keys.extend(used);
    let keys = of_each_depth(&composer, keys).unwrap_or_else(|error| panic!("{error}"));
    let keys: Vec<_> = keys.into_iter().collect();
    eprintln!("{} to draw", keys.len());
    // Keys that share an oracle's work are worth keeping together.
    let faults: Vec<_> = keys
        .par_chunks(keys.len().div_ceil(rayon::current_num_threads()))
        .flat_map_iter(|keys| {
            let mut studio = Studio::new();
            keys.iter()
                .filter_map(|key| studio.check(key))
                .collect::<Vec<_>>()
        })
        .collect();
    assert!(
        faults.is_empty(),
        "{} of {} permutations:\n{}",
        faults.len(),
        keys.len(),
        faults.join("\n")
    );
}

/// Choices that no permutation tells apart: formats, lights, and the widths of maps that are filtered before they are read.
#[test]
fn exponential_maps_are_read_as_the_oracle_says() {
    let mut keys = Vec::new();
    let library = library();
    for method in ["basic", "pssm"] {
        for (filter, light, pcf) in [
            ("esm", "directional", "3"),
            ("esm", "spot", "15"),
            ("esm_half", "directional", "15"),
            ("esm_half", "spot", "3"),
            ("esm_log", "directional", "15"),
            ("esm_log", "spot", "3"),
            ("esm_log", "spot", "1"),
        ] {
            let key = library.key([
                ("pass", "shadow_term"),
                ("method", method),
                ("filter", filter),
                ("light", light),
                ("pcf", pcf),
            ]);
            keys.push(key.unwrap_or_else(|error| panic!("{error}")));
        }
    }
    let tapered = library.key([
        ("pass", "shadow_term"),
        ("method", "pssm"),
        ("filter", "esm"),
        ("pcf", "5"),
        ("taper", "on"),
    ]);
    keys.push(tapered.unwrap_or_else(|error| panic!("{error}")));
    let mut studio = Studio::new();
    let faults: Vec<_> = keys.iter().filter_map(|key| studio.check(key)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
