//! Reports about the methods: figures of error beside figures of cost.
//!
//! A [`Report`] has a [`Row`] for each rendering of a scene. [`write()`] makes two files of it:
//!
//! - `report.json`, for programs: every row with every figure by its name.
//! - `report.html`, for people: one page that needs no network and no other file. For each scene it says
//!   which configuration to choose, plots error against time and against memory, and shows each
//!   configuration's shadows beside the true ones; a table has every figure.
//!
//! # What is recommended, and why
//! The **error** of a row is [`Row::error`]. Its **time** is a [`Ratio`] with an interval; two times whose intervals overlap
//! are not told apart, and nothing is ranked by them. A row is on the **Pareto front** where no other row of its
//! scene is for certain no worse and somewhere better, in error and time or in error and memory: whoever
//! chooses a row off the front gives something away for nothing. The page proposes, of the rows within twice the least
//! error, the fastest; of those that may be as fast, the one that errs least. Rows with bad pixels may be on the front, but are never
//! proposed.

mod difference;
mod error;
mod format;
mod names;
mod page;
mod pareto;
mod pictures;
mod plot;
mod ratio;
mod scale;
mod table;
mod verdict;
mod write;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use serde::Serialize;
use umbrage_render::{LeftOut, Path};

use crate::figures::Figures;

pub use difference::{FALSE_LIT, FALSE_SHADOW, LEFT_OUT, NO_NUMBER, difference};
pub use error::ReportError;
pub use pictures::Pictures;
pub use ratio::Ratio;
pub use umbrage_isa::Isa;
pub use write::{FILES, FORMAT, check_earlier, write};

/// All that is known about some scenes, drawn by some methods.
///
/// It has no date and no path of the machine's: the same figures are the same bytes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// The adapter that drew: its name and driver.
    pub adapter: String,
    /// The command that made the report, as it would be typed.
    pub command: String,
    /// Pixels across each picture.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Pairs of pictures that each configuration was timed by at the most.
    pub most_pairs: u32,
    /// The GPU family that `isa` is for, or why there is none.
    pub isa_source: String,
    /// The scenes, in the order in which they are shown.
    pub scenes: Vec<SceneInfo>,
    /// The renderings, in any order.
    pub rows: Vec<Row>,
    /// Configurations asked for that cannot be drawn.
    pub skipped: Vec<Skipped>,
}

/// Contents of a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SceneInfo {
    /// The scene's name, as its rows give it.
    pub name: String,
    /// How many lights shine in it.
    pub lights: usize,
    /// How many triangles all its objects have.
    pub triangles: usize,
    /// Features of its models' files that it does not show.
    pub left_out: Vec<LeftOut>,
}

/// A method that cannot draw a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// The scene's name.
    pub scene: String,
    /// The method's name.
    pub method: String,
    /// The configuration's name.
    pub config: String,
    /// Why it cannot, in the method's words.
    pub reason: String,
}

impl Report {
    /// Sets `pareto` of every row. [`write()`] does so too, with a copy of its own.
    pub fn mark_pareto(&mut self) {
        pareto::mark(&mut self.rows);
    }
}

/// One scene, drawn by one method in one configuration along one path.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// The scene's name.
    pub scene: String,
    /// The method's name.
    pub method: String,
    /// The configuration's name.
    pub config: String,
    /// How the shadow term reached the surface.
    pub path: Path,
    /// The errors.
    #[serde(flatten)]
    pub figures: Figures,
    /// Time of the passes that make shadow maps on the device, milliseconds; no numbers where it has no timestamps.
    pub casters_ms: Spread,
    /// Time of the shading on the device, milliseconds; no numbers where it has no timestamps.
    pub shading_ms: Spread,
    /// Time of the whole frame by the clock on the wall, milliseconds.
    pub frame_ms: Spread,
    /// Casters and shading (the frame, where there are no timestamps) over those of `basic` with one tap, drawn right before
    /// or after.
    pub time_ratio: Ratio,
    /// The times that it comes from, pair by pair, those of `basic` with one tap first; milliseconds.
    pub time_pairs: Vec<[f64; 2]>,
    /// Bytes in the method's textures, and in masks where the path has them.
    pub memory_bytes: u64,
    /// Texels in them.
    pub texels: u64,
    /// Texels that its passes fill in a picture in which all is drawn, in each of their targets.
    pub texels_written: u64,
    /// Triangles that passes of casters draw.
    pub triangles: u64,
    /// Vertices in these passes, each once a pass.
    pub vertices: u64,
    /// Passes that make shadow maps.
    pub passes: u32,
    /// Draw calls in them.
    pub draws: u32,
    /// Texture fetches of `calc_shadow` a pixel, counted on the device, mean over the compared pixels.
    pub fetches_per_pixel: f64,
    /// The share of the compared pixels that take so many fetches, by their number.
    pub fetch_shares: BTreeMap<u32, f64>,
    /// How often its filter is spared; none where its filter always runs, or no compared pixel samples a map.
    pub decided: Option<Decided>,
    /// Figures of a GPU's compiler for the costliest fragment shader; none where that compiler is missing.
    pub isa: Option<Isa>,
    /// Whether no other configuration of the scene is for certain no worse and somewhere better, in error
    /// and time or in error and memory.
    pub pareto: bool,
}

impl Row {
    /// The figure that methods are ranked by: the share of the compared samples that are wrongly lit or wrongly in shadow, 0
    /// to 1.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.figures.false_lit + self.figures.false_shadow
    }
}

/// How the receivers' shadow terms were found, as shares of those compared pixels that sample a map, pooled over the
/// lights, 0 to 1; they add up to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Decided {
    /// Lit at once, as no depth around is greater.
    pub lit_by_depth: f64,
    /// Lit at once, as they lie before a plane that no depth around is before.
    pub lit_by_plane: f64,
    /// In shadow at once, as all depths around are greater.
    pub shadowed_by_depth: f64,
    /// In shadow at once, as they lie behind a plane that all depths around are before.
    pub shadowed_by_plane: f64,
    /// Filtered, as that was left open.
    pub filtered: f64,
    /// Texture fetches fewer a compared pixel than of the same configuration without the choice that lets it decide;
    /// below 0 where bounds cost more than they spare; none where no such choice was made.
    pub fetches_saved: Option<f64>,
}

impl Decided {
    /// The share that was not filtered.
    #[must_use]
    pub fn at_once(&self) -> f64 {
        self.by_plane() + self.by_depth()
    }

    /// The share that planes decided.
    #[must_use]
    pub fn by_plane(&self) -> f64 {
        self.lit_by_plane + self.shadowed_by_plane
    }

    /// The share that the least and the greatest depth decided.
    #[must_use]
    pub fn by_depth(&self) -> f64 {
        self.lit_by_depth + self.shadowed_by_depth
    }
}

/// A median and how far the measurements spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// The least.
    pub min: f64,
    /// The median.
    pub median: f64,
    /// The greatest.
    pub max: f64,
}

impl Spread {
    /// The spread of `values`, in any order; of none, no numbers.
    pub fn of(values: &[f64]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |place: usize| sorted.get(place).copied().unwrap_or(f64::NAN);
        let last = sorted.len().saturating_sub(1);
        Self {
            min: at(0),
            // The middle of an even number is the mean of two.
            median: 0.5 * (at(last / 2) + at(last.div_ceil(2))),
            max: at(last),
        }
    }
}
