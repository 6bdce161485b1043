//! `benches.ron`: the figures of all benchmarks and the counts of instructions as they are expected, and how far they may
//! be off.

use std::{collections::BTreeMap, fs, path::Path};

use anyhow::{Context, Result, bail};
use serde::Deserialize;
use serde_json::Value;

use crate::run::root;

/// The file, from the workspace's root.
pub(crate) const FILE: &str = "crates/umbrage_bench/benches.ron";

/// Contents of the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Benches {
    /// By benchmark, then by the place of a number in its report: names of members and places in lists, joined by dots.
    /// Of a spread it is the median.
    figures: BTreeMap<String, BTreeMap<String, Figure>>,
    pub(crate) instructions: Instructions,
}

/// Counts of instructions, of which none may grow by more than [`GROWTH`].
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Instructions {
    /// The first words of `rustc --version`: another compiler's counts are others.
    pub(crate) compiler: String,
    /// By path.
    counts: BTreeMap<String, u64>,
}

/// How much more than is expected a path may take.
const GROWTH: f64 = 0.05;

/// A figure's value as expected, and the most or the least that is allowed.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Figure {
    is: f64,
    at_most: Option<f64>,
    at_least: Option<f64>,
}

/// Outcome of comparing a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    Within,
    Beyond,
    /// As far from what is expected as it may be, but to the good side.
    Better,
}

impl Benches {
    pub(crate) fn load() -> Result<Self> {
        Self::read(&root().join(FILE))
    }

    fn read(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path)
            .with_context(|| format!("{} could not be read", path.display()))?;
        let options = ron::Options::default()
            .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let benches: Self = options
            .from_str(&text)
            .with_context(|| format!("{} is no list of figures", path.display()))?;
        for (benchmark, figures) in &benches.figures {
            for (name, figure) in figures {
                let Figure {
                    is,
                    at_most,
                    at_least,
                } = *figure;
                let allows = match (at_most, at_least) {
                    (Some(most), None) => is <= most,
                    (None, Some(least)) => is >= least,
                    _ => false,
                };
                if !allows {
                    bail!(
                        "{}: `{name}` of `{benchmark}` must have either `at_most` or `at_least`, within which it `is`",
                        path.display()
                    );
                }
            }
        }
        Ok(benches)
    }

    /// Prints how the figures of a `benchmark` in its `report` compare, and returns how many are beyond what is allowed.
    pub(crate) fn tell(&self, benchmark: &str, report: &Value) -> usize {
        let mut beyond = 0;
        for (name, figure) in self.figures.get(benchmark).into_iter().flatten() {
            let Some(found) = number(report, name) else {
                eprintln!("    {name}: BEYOND: there is no such number in the report");
                beyond += 1;
                continue;
            };
            let word = match figure.judge(found) {
                Verdict::Within => "",
                Verdict::Better => "; better by so much that its line may be made stricter",
                Verdict::Beyond => {
                    beyond += 1;
                    ": BEYOND"
                }
            };
            eprintln!("    {name}: {found:.4} ({figure}){word}");
        }
        beyond
    }
}

impl Instructions {
    /// Prints each of the `counts`, and returns the lines of the file that do not fit them any more, as they would.
    pub(crate) fn tell(&self, counts: &BTreeMap<String, u64>) -> Vec<String> {
        let mut misfits = Vec::new();
        for (path, found) in counts {
            let known = self.counts.get(path).map(|known| *known as f64);
            let fits = known.is_some_and(|known| *found as f64 <= known * (1.0 + GROWTH));
            let beyond = if fits { "" } else { ": BEYOND" };
            let change = known.map_or("no line of its own".to_owned(), |known| {
                format!("{:+.1} %", 100.0 * (*found as f64 / known - 1.0))
            });
            eprintln!("    {path}: {found} ({change}){beyond}");
            if !fits {
                misfits.push(format!("\"{path}\": {found},"));
            }
        }
        for path in self.counts.keys() {
            if !counts.contains_key(path) {
                eprintln!("    {path}: BEYOND: nothing is called so any more");
                misfits.push(format!("// no \"{path}\""));
            }
        }
        misfits
    }
}

impl Figure {
    fn judge(&self, found: f64) -> Verdict {
        // Comparisons are so that no number at all is beyond.
        let (allowed, better) = match (self.at_most, self.at_least) {
            (Some(most), _) => (found <= most, found * most < self.is * self.is),
            (_, Some(least)) => (found >= least, found * least > self.is * self.is),
            _ => (false, false),
        };
        match (allowed, better) {
            (false, _) => Verdict::Beyond,
            (true, true) => Verdict::Better,
            (true, false) => Verdict::Within,
        }
    }
}

impl std::fmt::Display for Figure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "expected {}", self.is)?;
        if let Some(most) = self.at_most {
            write!(f, ", at most {most}")?;
        }
        if let Some(least) = self.at_least {
            write!(f, ", at least {least}")?;
        }
        Ok(())
    }
}

/// The number at a place of `report`; of a spread, its median.
fn number(report: &Value, place: &str) -> Option<f64> {
    let found = place
        .split('.')
        .try_fold(report, |value, name| match value {
            Value::Array(list) => list.get(name.parse::<usize>().ok()?),
            other => other.get(name),
        })?;
    found.as_f64().or_else(|| found.get("median")?.as_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Benches> {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("benches.ron");
        fs::write(&file, text).expect("written");
        Benches::read(&file)
    }

    #[test]
    fn the_file_is_sound() {
        Benches::load().expect("the repository's own");
    }

    #[test]
    fn figures_beyond_are_counted() {
        let benches = read(
            r#"(instructions: (compiler: "", counts: {}), figures: {"frame": {
                "ratio": (is: 0.30, at_most: 0.36),
                "speed": (is: 20, at_least: 15),
                "spread": (is: 1, at_most: 1.1),
                "rows.1.ms": (is: 2, at_most: 3),
            }})"#,
        )
        .expect("sound");
        let report = |ratio: f64, speed: f64, spread: f64, ms: f64| {
            serde_json::json!({
                "ratio": ratio, "speed": speed, "spread": {"min": 0, "median": spread, "max": 9},
                "rows": [{}, {"ms": ms}],
            })
        };
        assert_eq!(benches.tell("frame", &report(0.35, 16.0, 1.05, 2.5)), 0);
        assert_eq!(benches.tell("frame", &report(0.37, 14.0, 1.2, 4.0)), 4);
        // Better, by however much, is allowed.
        assert_eq!(benches.tell("frame", &report(0.01, 99.0, 0.1, 0.1)), 0);
        assert_eq!(benches.tell("frame", &serde_json::json!({"rows": 1})), 4);
        assert_eq!(benches.tell("another", &serde_json::json!({})), 0);
    }

    #[test]
    fn better_by_as_much_as_is_allowed_is_told() {
        let figure = Figure {
            is: 0.3,
            at_most: Some(0.36),
            at_least: None,
        };
        let verdicts = [0.2, 0.29, 0.36, 0.361, f64::NAN].map(|found| figure.judge(found));
        let expected = [
            Verdict::Better,
            Verdict::Within,
            Verdict::Within,
            Verdict::Beyond,
            Verdict::Beyond,
        ];
        assert_eq!(verdicts, expected);
    }

    #[test]
    fn counts_that_grew_or_have_no_line_are_told_as_lines() {
        let counts = |counts: &[(&str, u64)]| {
            let counts = counts
                .iter()
                .map(|(path, count)| ((*path).to_owned(), *count));
            counts.collect::<BTreeMap<_, _>>()
        };
        let expected = Instructions {
            compiler: String::new(),
            counts: counts(&[("new", 1_000), ("known", 1_000)]),
        };
        let none: [&str; 0] = [];
        assert_eq!(
            expected.tell(&counts(&[("new", 1_050), ("known", 10)])),
            none
        );
        assert_eq!(
            expected.tell(&counts(&[("new", 1_051), ("other", 1)])),
            ["\"new\": 1051,", "\"other\": 1,", "// no \"known\""]
        );
    }

    #[test]
    fn a_file_with_a_fault_is_refused() {
        for (text, part) in [
            (
                r#"(instructions: (compiler: "", counts: {}), figures: {"frame": {"ratio": (is: 1)}})"#,
                "`ratio` of `frame` must have",
            ),
            (
                r#"(instructions: (compiler: "", counts: {}), figures: {"frame": {"ratio": (is: 1, at_most: 0.9)}})"#,
                "within which it `is`",
            ),
            ("(figures: {\n\"frame\": 1})", "2:"),
        ] {
            let said = read(text).err().expect(text);
            assert!(format!("{said:#}").contains(part), "{said:#}");
        }
    }
}
