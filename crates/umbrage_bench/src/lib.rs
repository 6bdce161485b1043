//! Ratios taken in one run: what is compared is timed in turns, so that a machine's moods fall on
//! all alike.

pub mod field;

use std::{
    fs, io,
    path::PathBuf,
    time::{Duration, Instant},
};

use serde::Serialize;

/// A spread of measured numbers.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Spread {
    /// The least.
    pub min: f64,
    /// The middle one.
    pub median: f64,
    /// The greatest.
    pub max: f64,
}

impl Spread {
    /// The spread of `numbers`; zeros where there are none.
    pub fn of(numbers: impl IntoIterator<Item = f64>) -> Self {
        let mut numbers: Vec<_> = numbers.into_iter().collect();
        numbers.sort_by(f64::total_cmp);
        let at = |index: usize| numbers.get(index).copied().unwrap_or(0.0);
        Self {
            min: at(0),
            median: at(numbers.len() / 2),
            max: at(numbers.len().saturating_sub(1)),
        }
    }

    /// The spread of `times`, in microseconds.
    pub fn micros(times: &[Duration]) -> Self {
        Self::of(times.iter().map(|time| time.as_secs_f64() * 1e6))
    }
}

/// The median, and the least and the greatest beside it.
impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { min, median, max } = self;
        write!(f, "{median:9.3} ({min:.3} to {max:.3})")
    }
}

/// The time that `work` takes, with what it gives kept from being optimised away and dropped after.
pub fn time<T>(work: impl FnOnce() -> T) -> Duration {
    let start = Instant::now();
    let result = std::hint::black_box(work());
    let time = start.elapsed();
    drop(result);
    time
}

/// The folder for reports, where it is not `target/umbrage` of the workspace that this was built in: `cargo xtask bench`
/// sets it, since it also runs benchmarks that were built elsewhere.
const REPORTS: &str = "UMBRAGE_BENCH_REPORTS";

/// Writes `report` as `NAME.json`, into `target/umbrage` of this workspace or the folder that `UMBRAGE_BENCH_REPORTS` names.
///
/// # Errors
/// Where the file cannot be written.
pub fn write_report(name: &str, report: &impl Serialize) -> io::Result<PathBuf> {
    let own = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../target/umbrage");
    let dir = std::env::var_os(REPORTS).map_or_else(own, PathBuf::from);
    fs::create_dir_all(&dir)?;
    let path = dir.canonicalize()?.join(format!("{name}.json"));
    fs::write(&path, serde_json::to_string_pretty(report)? + "\n")?;
    Ok(path)
}
