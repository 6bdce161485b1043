//! What bounds before a filter save: time, construction included, and fetches; and whether they change a pixel.

use std::{collections::BTreeMap, error::Error, path::Path};

use serde::Serialize;
use umbrage_render::{Decision, PassTime, Picture, RenderOptions, Rendered, Renderer, Scene, What};

/// Each with the scene's own method: splits in the first, one map in the others.
const SCENES: [&str; 4] = ["avenue", "bunny_sun", "leaves", "suzanne_spot"];

const SIZE: (u32, u32) = (1280, 720);

pub(crate) const ROUNDS: usize = 9;

/// Filters and their widths, each width's plain one first.
const CONFIGS: [(&str, &str); 7] = [
    ("pcf", "15"),
    ("hpsm", "15"),
    ("hpsm_naive", "15"),
    ("min_max", "15"),
    ("min_max_tree", "15"),
    ("pcf", "7"),
    ("hpsm", "7"),
];

/// Texels along a block: half as long to build as with 4, and up to 4 in 100 receivers more that stay open.
const BLOCK: &str = "8";

#[derive(Serialize)]
pub(crate) struct Report {
    /// The time of all scenes' shadow terms and of what is built for them, over that of the whole filter.
    hpsm15_over_pcf15: f64,
    hpsm7_over_pcf7: f64,
    /// Pixels in which some bounded filter gives another term than the whole one.
    hpsm_disagreements: usize,
    bounds: BTreeMap<&'static str, BTreeMap<String, Figures>>,
}

#[derive(Clone, Copy, Default, Serialize)]
struct Figures {
    /// Medians: what is built from the maps, and the pass of the shadow term.
    build_ms: f64,
    term_ms: f64,
    /// Both over those of the whole filter in the same round: the median.
    over_pcf: f64,
    /// Of the receivers that ask a map, the mean and shares.
    fetches: f64,
    lit_by_depth: f64,
    lit_by_plane: f64,
    shadowed_by_depth: f64,
    shadowed_by_plane: f64,
    disagreements: usize,
}

pub(crate) fn measure(renderer: &mut Renderer, scenes: &Path) -> Result<Report, Box<dyn Error>> {
    let mut bounds = BTreeMap::new();
    let mut sums = [[0.0; 2]; 2];
    for name in SCENES {
        let scene = Scene::load(scenes.join(name).with_extension("ron"))?;
        let mut figures = [Figures::default(); CONFIGS.len()];
        for (figures, config) in figures.iter_mut().zip(CONFIGS) {
            *figures = count(renderer, &scene, config)?;
        }
        let mut times = vec![[(0.0, 0.0); CONFIGS.len()]; ROUNDS];
        for round in &mut times {
            for (time, config) in round.iter_mut().zip(CONFIGS) {
                // The first one makes the maps, in the place of another's: not counted.
                draw(renderer, &scene, config, What::ShadowTerm)?;
                *time = split(&draw(renderer, &scene, config, What::ShadowTerm)?);
            }
        }
        for (i, (_, width)) in CONFIGS.into_iter().enumerate() {
            let plain = CONFIGS.iter().position(|config| *config == ("pcf", width));
            let plain = plain.ok_or("no plain filter of this width")?;
            figures[i].build_ms = median(times.iter().map(|round| round[i].0));
            figures[i].term_ms = median(times.iter().map(|round| round[i].1));
            let whole = |(build, term): (f64, f64)| build + term;
            let ratios = times
                .iter()
                .map(|round| whole(round[i]) / whole(round[plain]));
            figures[i].over_pcf = median(ratios);
        }
        for (sum, [plain, own]) in sums.iter_mut().zip([[0, 1], [5, 6]]) {
            for (sum, i) in sum.iter_mut().zip([plain, own]) {
                *sum += figures[i].build_ms + figures[i].term_ms;
            }
        }
        let named = CONFIGS.iter().zip(figures);
        let named = named.map(|((filter, width), figures)| (format!("{filter} {width}"), figures));
        bounds.insert(name, named.collect());
    }
    let ratio = |[plain, own]: [f64; 2]| own / plain;
    Ok(Report {
        hpsm15_over_pcf15: ratio(sums[0]),
        hpsm7_over_pcf7: ratio(sums[1]),
        hpsm_disagreements: (bounds.values().flat_map(BTreeMap::values))
            .map(|figures: &Figures| figures.disagreements)
            .sum(),
        bounds,
    })
}

impl Report {
    pub(crate) fn print(&self) {
        for (scene, configs) in &self.bounds {
            for (config, f) in configs {
                let decided =
                    f.lit_by_depth + f.lit_by_plane + f.shadowed_by_depth + f.shadowed_by_plane;
                println!(
                    "{scene:12} {config:15} {:6.2} ms built, {:7.2} ms shaded, {:.3} of pcf, {:5.2} fetches, {:5.2} % decided, {:5.2} % by planes",
                    f.build_ms,
                    f.term_ms,
                    f.over_pcf,
                    f.fetches,
                    100.0 * decided,
                    100.0 * (f.lit_by_plane + f.shadowed_by_plane),
                );
            }
        }
        println!(
            "hpsm over pcf, 15 wide:        {:.3}",
            self.hpsm15_over_pcf15
        );
        println!("hpsm over pcf, 7 wide:         {:.3}", self.hpsm7_over_pcf7);
        println!("disagreements, pixels:         {}", self.hpsm_disagreements);
    }
}

fn draw(
    renderer: &mut Renderer,
    scene: &Scene,
    (filter, width): (&str, &str),
    what: What,
) -> Result<Rendered, Box<dyn Error>> {
    let axes = [("filter", filter), ("pcf", width)];
    Ok(renderer.render(scene, &options(SIZE, &axes, what))?)
}

/// Timed, with these axes and the blocks of all that is bounded here.
pub(crate) fn options(
    (width, height): (u32, u32),
    axes: &[(&str, &str)],
    what: What,
) -> RenderOptions {
    let axes = axes.iter().chain(&[("block", BLOCK)]);
    RenderOptions {
        width,
        height,
        what,
        axes: axes
            .map(|(axis, value)| ((*axis).to_owned(), (*value).to_owned()))
            .collect(),
        timed: true,
        ..RenderOptions::default()
    }
}

/// What needs no clock.
fn count(
    renderer: &mut Renderer,
    scene: &Scene,
    config: (&str, &str),
) -> Result<Figures, Box<dyn Error>> {
    let Picture::Decisions(decisions) = draw(renderer, scene, config, What::Decisions)?.picture
    else {
        return Err("decisions were asked for".into());
    };
    let Picture::Fetches(fetches) = draw(renderer, scene, config, What::Fetches)?.picture else {
        return Err("fetches were asked for".into());
    };
    let terms = |rendered: Rendered| match rendered.picture {
        Picture::ShadowTerm(terms) => terms.concat(),
        _ => Vec::new(),
    };
    let own = terms(draw(renderer, scene, config, What::ShadowTerm)?);
    let whole = terms(draw(renderer, scene, ("pcf", config.1), What::ShadowTerm)?);
    let pairs = own.iter().zip(&whole);
    let decisions = decisions.concat();
    let number = |wanted| decisions.iter().filter(|found| **found == wanted).count() as f64;
    let asked = decisions.len() as f64 - number(Decision::Unasked);
    let share = |wanted| number(wanted) / asked.max(1.0);
    Ok(Figures {
        fetches: fetches.concat().iter().copied().map(f64::from).sum::<f64>() / asked.max(1.0),
        lit_by_depth: share(Decision::LitByDepth),
        lit_by_plane: share(Decision::LitByPlane),
        shadowed_by_depth: share(Decision::ShadowedByDepth),
        shadowed_by_plane: share(Decision::ShadowedByPlane),
        disagreements: pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count(),
        ..Figures::default()
    })
}

/// Milliseconds of what is built from the maps, and of the shadow term; of all that is submitted, where the device has no
/// timestamps.
fn split(rendered: &Rendered) -> (f64, f64) {
    let report = &rendered.report;
    if report.times.is_empty() {
        return (0.0, report.gpu_milliseconds);
    }
    let sum = |wanted: &dyn Fn(&PassTime) -> bool| {
        let passes = report.times.iter().filter(|time| wanted(time));
        // From 0: an empty sum would be −0.
        passes.fold(0.0, |sum, time| sum + time.milliseconds)
    };
    (
        sum(&|pass| pass.planned && pass.pass != "casters"),
        sum(&|pass| !pass.planned),
    )
}

pub(crate) fn median(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<_> = numbers.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}
