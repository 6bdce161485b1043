//! Measures methods: scenes against configurations, and hard cases against limits.

mod compare;
mod decisions;
mod drawn;
mod lab;
mod motion;
mod stress;
#[cfg(test)]
mod tests;
mod timing;

pub use crate::{config::Config, error::StudyError};

pub use self::{
    compare::{CompareOptions, Comparison, compare},
    lab::Lab,
    stress::{CaseResult, Stressed, stress},
};

/// How far a long work has come, for a progress bar.
pub trait Progress: Sync {
    /// Announces what is done next, in so many steps.
    fn begin(&self, what: &str, steps: usize);
    /// A step is done; called from any thread.
    fn step(&self);
}

/// Shows nothing.
impl Progress for () {
    fn begin(&self, _: &str, _: usize) {}
    fn step(&self) {}
}
