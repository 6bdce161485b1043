//! Ratios taken in one run: what is compared is timed in turns, so that a machine's moods fall on
//! all alike.

use std::{
    fs, io,
    path::PathBuf,
    time::{Duration, Instant},
};

use serde::Serialize;

/// A spread of times, in microseconds.
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
    /// The spread of `times`; zeros where there are none.
    pub fn of(times: &[Duration]) -> Self {
        let mut micros: Vec<_> = times.iter().map(|time| time.as_secs_f64() * 1e6).collect();
        micros.sort_by(f64::total_cmp);
        let at = |index: usize| micros.get(index).copied().unwrap_or(0.0);
        Self {
            min: at(0),
            median: at(micros.len() / 2),
            max: at(micros.len().saturating_sub(1)),
        }
    }
}

impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{:9.2} µs ({:.2} to {:.2})",
            self.median, self.min, self.max
        )
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

/// Writes `report` as `target/umbrage/NAME.json` of this workspace.
///
/// # Errors
/// Where the file cannot be written.
pub fn write_report(name: &str, report: &impl Serialize) -> io::Result<PathBuf> {
    let dir = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../target/umbrage");
    fs::create_dir_all(&dir)?;
    let path = dir.canonicalize()?.join(format!("{name}.json"));
    fs::write(&path, serde_json::to_string_pretty(report)? + "\n")?;
    Ok(path)
}
