//! Savings of bounds before a filter: time, construction included, and fetches; and whether they change a pixel.

use std::{collections::BTreeMap, error::Error, path::Path as FilePath};

use serde::Serialize;
use umbrage_render::{Decision, Path, Picture, Rendered, Renderer, Scene, What};

use crate::timing::{SCENES, Times, Way, draw, load, median, time};

/// Filters, their widths, and whether bounds are built in any case: the plain filter of each width first.
const CONFIGS: [(&str, &str, bool); 8] = [
    ("pcf", "15", false),
    ("hpsm", "15", false),
    ("hpsm_naive", "15", false),
    ("min_max", "15", false),
    ("min_max_tree", "15", false),
    ("pcf", "7", false),
    ("hpsm", "7", false),
    ("hpsm", "7", true),
];

#[derive(Serialize)]
pub(crate) struct Report {
    /// The time of all scenes' shadow terms and of what is built for them, over that of the whole filter. They are found
    /// in the masks' path: once for each pixel, of what is seen there.
    hpsm15_over_pcf15: f64,
    hpsm7_over_pcf7: f64,
    /// With bounds that the filter's own rule does not build, as they would not pay.
    hpsm7_bounded_over_pcf7: f64,
    /// The same where objects are drawn one after another, with what they hide and each triangle's rim.
    hpsm15_over_pcf15_forward: f64,
    hpsm7_over_pcf7_forward: f64,
    /// Pixels in which some bounded filter gives another term than the whole one.
    hpsm_disagreements: usize,
    bounds: BTreeMap<&'static str, BTreeMap<String, Figures>>,
}

#[derive(Clone, Copy, Default, Serialize)]
struct Figures {
    /// Medians: what is built from the maps, and the pass of the shadow term as a mask.
    build_ms: f64,
    term_ms: f64,
    /// Both over those of the whole filter in the same round: the median.
    over_pcf: f64,
    /// The same of objects drawn one after another.
    forward: Forward,
    /// Of the receivers that sample a map, the mean and shares.
    fetches: f64,
    lit_by_depth: f64,
    lit_by_plane: f64,
    shadowed_by_depth: f64,
    shadowed_by_plane: f64,
    disagreements: usize,
}

#[derive(Clone, Copy, Default, Serialize)]
struct Forward {
    term_ms: f64,
    over_pcf: f64,
}

/// The whole filter's place among the configurations, and the planes': of both widths, and built in any case.
const PAIRS: [[usize; 2]; 3] = [[0, 1], [5, 6], [5, 7]];

pub(crate) fn measure(
    renderer: &mut Renderer,
    scenes: &FilePath,
) -> Result<Report, Box<dyn Error>> {
    let mut bounds = BTreeMap::new();
    // For each path and width the whole filter's time, and the planes'.
    let mut sums = [[[0.0; 2]; PAIRS.len()]; 2];
    for name in SCENES {
        let scene = load(scenes, name)?;
        let mut figures = [Figures::default(); CONFIGS.len()];
        for (figures, config) in figures.iter_mut().zip(CONFIGS) {
            *figures = count(renderer, &scene, config)?;
        }
        for (path, sums) in [Path::Mask, Path::Forward].into_iter().zip(&mut sums) {
            let ways = CONFIGS.map(|config| way(config, path));
            let rounds = time(renderer, &scene, ways)?;
            let mut wholes = [0.0; CONFIGS.len()];
            for (i, (_, width, _)) in CONFIGS.into_iter().enumerate() {
                let is_plain = |config: &(&str, &str, bool)| (config.0, config.1) == ("pcf", width);
                let plain = CONFIGS.iter().position(is_plain);
                let plain = plain.ok_or("no plain filter of this width")?;
                let of =
                    |figure: fn(Times) -> f64| median(rounds.iter().map(|round| figure(round[i])));
                let [build_ms, term_ms] = [of(|times| times.built), of(|times| times.filtered)];
                wholes[i] = build_ms + term_ms;
                let ratios = rounds
                    .iter()
                    .map(|round| round[i].whole() / round[plain].whole());
                let over_pcf = median(ratios);
                let figures = &mut figures[i];
                if path == Path::Forward {
                    figures.forward = Forward { term_ms, over_pcf };
                } else {
                    (figures.build_ms, figures.term_ms, figures.over_pcf) =
                        (build_ms, term_ms, over_pcf);
                }
            }
            for (sums, pair) in sums.iter_mut().zip(PAIRS) {
                for (sum, i) in sums.iter_mut().zip(pair) {
                    *sum += wholes[i];
                }
            }
        }
        let named = CONFIGS.iter().zip(figures);
        let named = named.map(|((filter, width, always), figures)| {
            let bounded = if *always { " bounded" } else { "" };
            (format!("{filter} {width}{bounded}"), figures)
        });
        bounds.insert(name, named.collect());
    }
    let ratio = |[plain, own]: [f64; 2]| own / plain;
    let [masks, forward] = sums;
    Ok(Report {
        hpsm15_over_pcf15: ratio(masks[0]),
        hpsm7_over_pcf7: ratio(masks[1]),
        hpsm7_bounded_over_pcf7: ratio(masks[2]),
        hpsm15_over_pcf15_forward: ratio(forward[0]),
        hpsm7_over_pcf7_forward: ratio(forward[1]),
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
                    "{scene:12} {config:15} {:6.2} ms built, {:7.2} ms shaded, {:.3} of pcf ({:.3} forward), {:5.2} fetches, {:5.2} % decided, {:5.2} % by planes",
                    f.build_ms,
                    f.term_ms,
                    f.over_pcf,
                    f.forward.over_pcf,
                    f.fetches,
                    100.0 * decided,
                    100.0 * (f.lit_by_plane + f.shadowed_by_plane),
                );
            }
        }
        println!(
            "hpsm over pcf, 15 wide:        {:.3} ({:.3} forward)",
            self.hpsm15_over_pcf15, self.hpsm15_over_pcf15_forward
        );
        println!(
            "hpsm over pcf, 7 wide:         {:.3} ({:.3} forward; {:.3} with bounds in any case)",
            self.hpsm7_over_pcf7, self.hpsm7_over_pcf7_forward, self.hpsm7_bounded_over_pcf7
        );
        println!("disagreements, pixels:         {}", self.hpsm_disagreements);
    }
}

fn way((filter, width, always_bounded): (&'static str, &'static str, bool), path: Path) -> Way {
    Way {
        method: None,
        axes: [("filter", filter), ("pcf", width)],
        always_bounded,
        path,
    }
}

/// Figures that need no clock.
fn count(
    renderer: &mut Renderer,
    scene: &Scene,
    (filter, width, always): (&'static str, &'static str, bool),
) -> Result<Figures, Box<dyn Error>> {
    let mut draw = |filter, what| {
        let config = (filter, width, always && filter != "pcf");
        draw(renderer, scene, way(config, Path::Forward), what)
    };
    let Picture::Decisions(decisions) = draw(filter, What::Decisions)?.picture else {
        return Err("decisions were asked for".into());
    };
    let Picture::Fetches(fetches) = draw(filter, What::Fetches)?.picture else {
        return Err("fetches were asked for".into());
    };
    let terms = |rendered: Rendered| match rendered.picture {
        Picture::ShadowTerm(terms) => terms.concat(),
        _ => Vec::new(),
    };
    let own = terms(draw(filter, What::ShadowTerm)?);
    let whole = terms(draw("pcf", What::ShadowTerm)?);
    let pairs = own.iter().zip(&whole);
    let decisions = decisions.concat();
    let number = |wanted| decisions.iter().filter(|found| **found == wanted).count() as f64;
    let sampled = decisions.len() as f64 - number(Decision::Unsampled);
    let share = |wanted| number(wanted) / sampled.max(1.0);
    Ok(Figures {
        fetches: fetches.concat().iter().copied().map(f64::from).sum::<f64>() / sampled.max(1.0),
        lit_by_depth: share(Decision::LitByDepth),
        lit_by_plane: share(Decision::LitByPlane),
        shadowed_by_depth: share(Decision::ShadowedByDepth),
        shadowed_by_plane: share(Decision::ShadowedByPlane),
        disagreements: pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count(),
        ..Figures::default()
    })
}
