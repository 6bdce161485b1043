//! `cargo xtask bench`: runs the benchmarks, and holds their figures against `benches.ron`.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{
    benches::{Benches, FILE},
    run::{Steps, captured, cargo, root, visibly},
    setup::set_up_command,
};

/// Benchmarks, each a file in `crates/umbrage_bench/benches`.
const BENCHMARKS: [&str; 4] = ["compose", "frame", "methods", "truth"];
/// Where they write what they found.
const REPORTS: &str = "target/umbrage";
/// The variable by which they learn that.
const REPORTS_VARIABLE: &str = "UMBRAGE_BENCH_REPORTS";
/// Turns that two states of the benchmark `frame` take.
const TURNS: usize = 5;

/// Choices for `cargo xtask bench`.
#[derive(clap::Args)]
pub(crate) struct Choices {
    /// Benchmarks to run; all of them where none is named.
    #[arg(value_parser = BENCHMARKS)]
    names: Vec<String>,
    /// A folder of benchmarks that were built already, to run in place of this state's: such as another worktree's
    /// `target/release/deps`.
    #[arg(long, value_name = "DIR")]
    binaries: Option<PathBuf>,
    /// The benchmark `frame` as it was built at another commit: nothing else is run, but both in turn, for what shadows
    /// add and what the CPU computes over what they took there.
    #[arg(long, value_name = "FILE", conflicts_with = "names")]
    before: Option<PathBuf>,
}

pub(crate) fn bench(choices: &Choices) -> Result<()> {
    // The places that are named are the caller's, and all is run in the workspace's root.
    let absolute = |path: &PathBuf| {
        let found = path.canonicalize();
        found.with_context(|| format!("there is no {}", path.display()))
    };
    let binaries = choices.binaries.as_ref().map(absolute).transpose()?;
    let binaries = binaries.as_deref();
    let before = choices.before.as_ref().map(absolute).transpose()?;
    if let Some(before) = before {
        return in_turn(binaries, &before);
    }
    let benches = Benches::load()?;
    let names: Vec<_> = match choices.names.as_slice() {
        [] => BENCHMARKS.into(),
        names => names.iter().map(String::as_str).collect(),
    };
    let mut steps = Steps::new(names.len() + 1);
    if binaries.is_none() {
        steps.begin("set-up");
        set_up_command()?;
    } else {
        steps.begin("no set-up: the benchmarks are built");
    }
    let mut beyond = 0;
    for name in names {
        let mut command = command(binaries, name, &[])?;
        steps.run(name, &mut command)?;
        let file = root().join(REPORTS).join(format!("{name}.json"));
        let text = fs::read_to_string(&file)
            .with_context(|| format!("`{name}` has not written {}", file.display()))?;
        let report: Value = serde_json::from_str(&text)
            .with_context(|| format!("{} is damaged", file.display()))?;
        beyond += benches.tell(name, &report);
    }
    if beyond > 0 {
        bail!(
            "{beyond} figures are beyond what {FILE} allows; find what made them so. Where it is meant, change their lines in \
             the commit that does it, and say why there"
        );
    }
    eprintln!("all figures are within what {FILE} allows");
    Ok(())
}

/// The command that runs the benchmark `name`, from `binaries` where they are given.
fn command(binaries: Option<&Path>, name: &str, args: &[&str]) -> Result<Command> {
    let mut command = match binaries {
        Some(folder) => Command::new(built(folder, name)?),
        None => {
            let mut cargo = cargo(&["bench", "--package", "umbrage_bench", "--bench", name]);
            cargo.arg("--");
            cargo
        }
    };
    command
        .args(args)
        .env(REPORTS_VARIABLE, root().join(REPORTS));
    Ok(command)
}

/// The newest program in `folder` that is called `name`, or `name-` and a hash as cargo does.
fn built(folder: &Path, name: &str) -> Result<PathBuf> {
    let entries = fs::read_dir(folder)
        .with_context(|| format!("the folder {} could not be read", folder.display()))?;
    let mut newest = None;
    for entry in entries {
        let path = entry?.path();
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let file = file.strip_suffix(".exe").unwrap_or(&file);
        let is_hash = |rest: &str| {
            let hash = rest.strip_prefix('-').unwrap_or("no hash");
            rest.is_empty() || hash.chars().all(|c| c.is_ascii_hexdigit())
        };
        if path.is_file() && file.strip_prefix(name).is_some_and(is_hash) {
            newest = newest.max(Some((path.metadata()?.modified()?, path)));
        }
    }
    let Some((_, newest)) = newest else {
        bail!(
            "no benchmark `{name}` in {}; build it with `cargo bench --package umbrage_bench --no-run`, whose folder is \
             target/release/deps",
            folder.display()
        );
    };
    Ok(newest)
}

/// Figures of `frame -- --times`; milliseconds.
#[derive(Clone, Copy, Deserialize)]
struct Times {
    added: f64,
    own_cpu_6400: f64,
    /// In a loop that reads nothing back; none of states in which every frame is read back.
    steady_cpu_6400: Option<f64>,
}

/// Ratios of two states, turn by turn, in ascending order.
#[derive(Serialize)]
struct OverBefore {
    added_over_before: Vec<f64>,
    /// Both with the picture read back.
    cpu_6400_over_before: Vec<f64>,
    /// Both in their steady loop, which may be one that reads back.
    steady_cpu_6400_over_before: Vec<f64>,
}

impl Times {
    fn steady(&self) -> f64 {
        self.steady_cpu_6400.unwrap_or(self.own_cpu_6400)
    }
}

/// Runs this state's benchmark `frame` and another one's in turn.
fn in_turn(binaries: Option<&Path>, before: &Path) -> Result<()> {
    let mut steps = Steps::new(2 * TURNS + 1);
    if binaries.is_none() {
        let mut build = cargo(&["bench", "--package", "umbrage_bench", "--no-run"]);
        steps.begin("set-up");
        visibly(build.args(["--bench", "frame"]))?;
    } else {
        steps.begin("no set-up: the benchmark is built");
    }
    let mut time = |command: &mut Command| -> Result<Times> {
        steps.begin(&crate::run::shell_line(command));
        let said = captured(command)?.stdout;
        let said = String::from_utf8_lossy(&said);
        let last = said.lines().last().unwrap_or_default();
        serde_json::from_str(last).with_context(|| format!("no times of a frame: `{last}`"))
    };
    let mut turns = Vec::new();
    for _ in 0..TURNS {
        let now = time(&mut command(binaries, "frame", &["--times"])?)?;
        let then = time(Command::new(before).arg("--times"))?;
        turns.push((now, then));
    }
    let ratios = |figure: fn(&Times) -> f64| {
        let ratios = turns.iter().map(|(now, then)| figure(now) / figure(then));
        let mut ratios: Vec<_> = ratios.collect();
        ratios.sort_by(f64::total_cmp);
        ratios
    };
    let found = OverBefore {
        added_over_before: ratios(|times| times.added),
        cpu_6400_over_before: ratios(|times| times.own_cpu_6400),
        steady_cpu_6400_over_before: ratios(Times::steady),
    };
    for (name, ratios) in [
        ("added_over_before", &found.added_over_before),
        ("cpu_6400_over_before", &found.cpu_6400_over_before),
        (
            "steady_cpu_6400_over_before",
            &found.steady_cpu_6400_over_before,
        ),
    ] {
        let [min, median, max] = [0, TURNS / 2, TURNS - 1].map(|at| ratios[at]);
        eprintln!("{name}: {median:.3} ({min:.3} to {max:.3})");
    }
    let file = root().join(REPORTS).join("frame_before.json");
    fs::write(&file, serde_json::to_string_pretty(&found)? + "\n")
        .with_context(|| format!("{} could not be written", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_benchmark_is_named() {
        let folder = root().join("crates/umbrage_bench/benches");
        let files = fs::read_dir(folder).expect("the benchmarks");
        let files = files.map(|entry| entry.expect("an entry").path());
        let files = files.filter(|path| path.is_file());
        let mut names: Vec<_> = files
            .map(|path| path.file_stem().expect("a name").to_os_string())
            .collect();
        names.sort();
        assert_eq!(names, BENCHMARKS);
    }

    #[test]
    fn a_built_benchmark_is_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let said = built(folder.path(), "frame")
            .expect_err("empty")
            .to_string();
        assert!(said.contains("no benchmark `frame`") && said.contains("--no-run"));
        for other in [
            "frame-0a1b.d",
            "frames-0a1b",
            "frame_before",
            "libframe-0a1b",
        ] {
            fs::write(folder.path().join(other), "").expect("written");
        }
        assert!(built(folder.path(), "frame").is_err());
        let ours = folder.path().join("frame-0a1b");
        fs::write(&ours, "").expect("written");
        assert_eq!(built(folder.path(), "frame").expect("there"), ours);
    }
}
