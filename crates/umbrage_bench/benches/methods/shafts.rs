//! Savings of bounds before the filter in a march through the air: time, construction included, and fetches.

use std::{error::Error, path::Path};

use serde::Serialize;
use umbrage_render::{Picture, Rendered, Renderer, What};

use crate::timing::{ROUNDS, SIZE, Times, load, median, options, split};

/// The plain filter first.
const FILTERS: [&str; 2] = ["pcf", "hpsm"];

#[derive(Serialize)]
pub(crate) struct Report {
    /// Time of the shafts and of what is built for them, with bounds over without: the median of rounds.
    shafts_hpsm_over_plain: f64,
    /// The same without what is built.
    shafts_hpsm_over_plain_march: f64,
    /// Fetches a pixel of the march, without and with bounds.
    shafts_fetches: [f64; 2],
    /// Pixels that differ.
    shafts_disagreements: usize,
}

pub(crate) fn measure(renderer: &mut Renderer, scenes: &Path) -> Result<Report, Box<dyn Error>> {
    let scene = load(scenes, "shafts")?;
    let mut draw = |filter: &str, what| -> Result<Rendered, Box<dyn Error>> {
        let options = options(SIZE, &[("filter", filter)], what);
        Ok(renderer.render(&scene, &options)?)
    };
    let mut fetches = [0.0; 2];
    let mut shaded = Vec::new();
    for (mean, filter) in fetches.iter_mut().zip(FILTERS) {
        let Picture::Fetches(counts) = draw(filter, What::ShaftFetches)?.picture else {
            return Err("fetches were asked for".into());
        };
        let pixels = counts.concat();
        *mean = pixels.iter().copied().map(f64::from).sum::<f64>() / pixels.len().max(1) as f64;
        let Picture::Shaded(pixels) = draw(filter, What::Shaded)?.picture else {
            return Err("a shaded picture was asked for".into());
        };
        shaded.push(pixels);
    }
    let (mut whole, mut march) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let mut round = [Times::default(); 2];
        for (times, filter) in round.iter_mut().zip(FILTERS) {
            // The first one makes the maps, in the place of another's: not counted.
            draw(filter, What::Shaded)?;
            *times = split(&draw(filter, What::Shaded)?, "shafts");
        }
        let [plain, own] = round;
        whole.push(own.whole() / plain.whole());
        march.push(own.filtered / plain.filtered);
    }
    let pairs = shaded[0].iter().zip(&shaded[1]);
    Ok(Report {
        shafts_hpsm_over_plain: median(whole.into_iter()),
        shafts_hpsm_over_plain_march: median(march.into_iter()),
        shafts_fetches: fetches,
        shafts_disagreements: pairs.filter(|(plain, own)| plain != own).count(),
    })
}

impl Report {
    pub(crate) fn print(&self) {
        let [plain, own] = self.shafts_fetches;
        println!(
            "shafts, hpsm over plain:       {:.3} ({:.3} without what is built), {own:.1} of {plain:.1} fetches, {} pixels differ",
            self.shafts_hpsm_over_plain,
            self.shafts_hpsm_over_plain_march,
            self.shafts_disagreements,
        );
    }
}
