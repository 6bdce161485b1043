//! A filter's width.

use umbrage_shadow::{Frame, PlanError};

/// The width of a frame's filter, texels: the axis `pcf` and, where the method has it, the axis `taper`, with which the
/// filter is two texels narrower from map to map. Shaders have it from `package::common::pcf`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Width {
    /// The width in the first map.
    pub widest: u32,
    /// Whether it is narrower from map to map.
    pub tapers: bool,
}

impl Width {
    /// The axis that widths are chosen by.
    pub const AXIS: &str = "pcf";

    /// The width of the widest filter there is.
    pub const MOST: u32 = 15;

    /// The width that a frame chooses.
    ///
    /// # Errors
    /// A width that is not odd, or not from 1 to 15.
    pub fn of(frame: &Frame<'_>) -> Result<Self, PlanError> {
        let pcf = frame.axis(Self::AXIS);
        let widest = pcf.parse().unwrap_or(0);
        PlanError::check(
            widest % 2 == 1 && widest <= Self::MOST,
            "the axis `pcf`",
            pcf,
            "odd, 1 to 15",
        )?;
        let tapers = frame.axis("taper") == "on";
        Ok(Self { widest, tapers })
    }

    /// The width in map `number`: one texel at the least.
    pub fn in_map(self, number: usize) -> u32 {
        let narrower = if self.tapers { 2 * number as u32 } else { 0 };
        self.widest.saturating_sub(narrower).max(1)
    }

    /// How far from its middle the filter reads in map `number`, texels: half its width, and half a texel of a fetch's
    /// own blending.
    pub fn reach(self, number: usize) -> f64 {
        0.5 * f64::from(self.in_map(number)) + 0.5
    }
}
