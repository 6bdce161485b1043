//! Time of shading with exponential maps beside comparisons of the same width.

use std::{collections::BTreeMap, error::Error, path::Path as FilePath};

use serde::Serialize;
use umbrage_render::{Path, Renderer};

use crate::timing::{SCENES, Times, Way, load, median, time};

/// No shadows first, then comparisons.
const FILTERS: [Option<&str>; 5] = [
    None,
    Some("pcf"),
    Some("esm"),
    Some("esm_half"),
    Some("esm_log"),
];

#[derive(Serialize)]
pub(crate) struct Report {
    /// Time that shadows by an exponential map 15 texels wide add to the shadow terms' pass, over the time that shadows by
    /// 15 × 15 comparisons add to it: the sum of all scenes.
    esm15_over_pcf15: f64,
    /// The same with the time that the pass takes without shadows: surfaces, which both have.
    esm15_over_pcf15_with_surfaces: f64,
    /// That, and the passes that make the maps, and draw their casters: all that is submitted, by the clock on the wall.
    esm15_over_pcf15_with_maps: f64,
    /// The first figure for each value of `filter` that reads exponential maps.
    esm15_variants_over_pcf15: BTreeMap<&'static str, f64>,
    exponential: BTreeMap<&'static str, BTreeMap<&'static str, Figures>>,
}

/// Medians, milliseconds.
#[derive(Clone, Copy, Serialize)]
struct Figures {
    term_ms: f64,
    frame_ms: f64,
}

pub(crate) fn measure(
    renderer: &mut Renderer,
    scenes: &FilePath,
) -> Result<Report, Box<dyn Error>> {
    let ways = FILTERS.map(|filter| Way {
        method: filter.is_none().then_some("none"),
        axes: [("filter", filter.unwrap_or("pcf")), ("pcf", "15")],
        always_bounded: false,
        path: Path::Forward,
    });
    let mut sums = [Times::default(); FILTERS.len()];
    let mut exponential = BTreeMap::new();
    for name in SCENES {
        let rounds = time(renderer, &load(scenes, name)?, ways)?;
        let mut named = BTreeMap::new();
        for (i, filter) in FILTERS.into_iter().enumerate() {
            let of = |figure: fn(Times) -> f64| median(rounds.iter().map(|round| figure(round[i])));
            let [term_ms, frame_ms] = [of(|times| times.filtered), of(|times| times.frame)];
            sums[i].filtered += term_ms;
            sums[i].frame += frame_ms;
            named.insert(filter.unwrap_or("none"), Figures { term_ms, frame_ms });
        }
        exponential.insert(name, named);
    }
    let [bare, pcf, esm, ..] = sums;
    let added = |times: Times| times.filtered - bare.filtered;
    let variants = FILTERS.into_iter().zip(sums).skip(2);
    Ok(Report {
        esm15_over_pcf15: added(esm) / added(pcf),
        esm15_over_pcf15_with_surfaces: esm.filtered / pcf.filtered,
        esm15_over_pcf15_with_maps: esm.frame / pcf.frame,
        esm15_variants_over_pcf15: variants
            .filter_map(|(filter, times)| Some((filter?, added(times) / added(pcf))))
            .collect(),
        exponential,
    })
}

impl Report {
    pub(crate) fn print(&self) {
        for (scene, filters) in &self.exponential {
            for (filter, figures) in filters {
                println!(
                    "{scene:12} {filter:15} {:7.2} ms shaded, {:7.2} ms in all",
                    figures.term_ms, figures.frame_ms
                );
            }
        }
        println!(
            "esm over pcf, 15 wide:         {:.3} ({:.3} with surfaces, {:.3} with the maps too)",
            self.esm15_over_pcf15,
            self.esm15_over_pcf15_with_surfaces,
            self.esm15_over_pcf15_with_maps,
        );
        for (filter, ratio) in &self.esm15_variants_over_pcf15 {
            println!("{filter:10} over pcf, 15 wide:  {ratio:.3}");
        }
    }
}
