//! Percentage-closer filtering (Reeves et al. 1987): the mean of comparisons about a place. Its shader half is
//! `filters/pcf.wesl`.
//!
//! Its width W in texels is the axis `pcf`. The mean of W × W bilinear comparisons a texel apart takes ((W + 1) / 2)²
//! fetches: see `common/pcf.wesl`.

use umbrage_shadow::{Filter, Frame, Part, PlanError};

use super::Width;

/// The filter `pcf`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pcf;

impl Part for Pcf {
    fn name(&self) -> &str {
        "pcf"
    }

    fn axes(&self) -> &[&str] {
        &[Width::AXIS]
    }
}

impl Filter for Pcf {
    fn reach(&self, frame: &Frame<'_>, number: usize) -> Result<f64, PlanError> {
        Ok(Width::of(frame)?.reach(number))
    }

    fn fetches(&self, frame: &Frame<'_>, number: usize) -> Result<u32, PlanError> {
        fetches(frame, number)
    }
}

/// The fetches of all comparisons about one place in map `number`.
pub(super) fn fetches(frame: &Frame<'_>, number: usize) -> Result<u32, PlanError> {
    let taps = Width::of(frame)?.in_map(number).div_ceil(2);
    Ok(taps.pow(2) * frame.depth()?.fetches())
}
