//! Depth sources: which depths shadow maps hold.

pub mod midpoint;
pub mod nearest;
