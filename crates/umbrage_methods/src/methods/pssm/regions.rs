//! Where a split's own permutation does what that of all splits does.

use std::collections::BTreeMap;

use umbrage_shadow::{PlanError, Region};

use super::fit::{Job, Splits, Transition};
use crate::filters::Width;

/// A region for each split. Of one that passes into the next, the band is a region beside: there both maps are
/// read, and only the light's own permutation does.
pub(super) fn of(job: &Job<'_>, splits: &Splits) -> Result<Vec<Region>, PlanError> {
    let tapers = job.frame.axis("taper") == "on";
    let width = tapers.then(|| Width::of(job.frame)).transpose()?;
    let mut regions = Vec::new();
    for (number, split) in splits.splits.iter().enumerate() {
        let [start, end] = split.depths;
        let passes = job.transition != Transition::Hard && splits.has_next(split);
        let band = if passes {
            end - job.band_length(split)
        } else {
            end
        };
        let axes = own_axes(job, width, number);
        // A band may be as long as its split. Nothing is seen behind the view.
        if band > start.max(0.0) {
            regions.push(Region { end: band, axes });
        }
        if passes {
            let axes = BTreeMap::new();
            regions.push(Region { end, axes });
        }
    }
    Ok(regions)
}

/// Axes of a split's pixels where no other split's map is read: one width of filter, and no band.
fn own_axes(job: &Job<'_>, tapering: Option<Width>, split: usize) -> BTreeMap<String, String> {
    let mut axes = BTreeMap::new();
    if job.transition != Transition::Hard {
        axes.insert("transition".to_owned(), "hard".to_owned());
    }
    if let Some(width) = tapering {
        axes.insert("taper".to_owned(), "off".to_owned());
        axes.insert("pcf".to_owned(), width.in_map(split).to_string());
    }
    axes
}
