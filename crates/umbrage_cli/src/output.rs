//! Output of the command.

use std::{
    io::Write,
    path::Path,
    sync::{Mutex, PoisonError},
    time::Duration,
};

use anyhow::{Context, Result, bail};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use umbrage::compose::sweep_beside;
use umbrage_measure::study::Progress;

/// Prints a result. A standard output that nobody reads any more is an error, not a panic.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .context("standard output could not be written")
}

/// Message of an error with its causes, each told once, although some errors repeat their causes themselves.
pub(crate) fn told(error: &anyhow::Error) -> String {
    let mut told = String::new();
    for cause in error.chain() {
        let cause = cause.to_string();
        let cause = cause.trim_end();
        if told.is_empty() {
            told.push_str(cause);
        } else if !told.contains(cause) {
            told = format!("{}: {cause}", told.trim_end());
        }
    }
    told
}

/// Prints `value` as JSON.
pub(crate) fn print_json(value: &impl Serialize) -> Result<()> {
    let mut text = serde_json::to_string_pretty(value).context("the result is not JSON")?;
    text.push('\n');
    print(&text)
}

/// A progress bar on standard error; invisible where that is no terminal.
pub(crate) fn progress(what: &str, steps: usize) -> ProgressBar {
    let bar = ProgressBar::new(steps as u64).with_message(what.to_owned());
    match ProgressStyle::with_template("{msg} {bar:40} {pos}/{len} {elapsed}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// The bars of a long work, one after the other.
#[derive(Default)]
pub(crate) struct Bars(Mutex<Option<ProgressBar>>);

impl Bars {
    pub(crate) fn clear(&self) {
        self.show(None);
    }

    /// Shows `next` in the last bar's place.
    fn show(&self, next: Option<ProgressBar>) {
        // A bar that another thread broke off is a bar still.
        let mut bar = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = std::mem::replace(&mut *bar, next) {
            last.finish_and_clear();
        }
    }
}

impl Progress for Bars {
    fn begin(&self, what: &str, steps: usize) {
        self.show(Some(progress(what, steps)));
    }

    fn step(&self) {
        let bar = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bar) = &*bar {
            bar.inc(1);
        }
    }
}

/// A spinner on standard error for work of unknown length; invisible where that is no terminal.
pub(crate) fn waiting(what: &'static str) -> ProgressBar {
    let spinner = ProgressBar::new_spinner().with_message(what);
    spinner.enable_steady_tick(Duration::from_millis(100));
    spinner
}

/// Says at once, rather than after the work, where the picture cannot be written.
pub(crate) fn check_picture(out: &Path) -> Result<()> {
    check_file(out, "picture", "png")
}

/// The same of any file: `what` it is, and how its name must end.
pub(crate) fn check_file(out: &Path, what: &str, end: &str) -> Result<()> {
    let is_named = out
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case(end));
    if !is_named || out.is_dir() {
        bail!("--out {} names no {what}; end it in .{end}", out.display());
    }
    sweep_beside(out);
    let folder = match out.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    tempfile::tempfile_in(folder).with_context(|| {
        format!(
            "--out {} cannot be written; choose a folder that exists and may be written to",
            out.display()
        )
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("cannot load: {source}; try another")]
    struct Outer {
        source: Inner,
    }

    #[derive(Debug, thiserror::Error)]
    #[error("no such file")]
    struct Inner;

    #[test]
    fn each_cause_is_told_once() {
        let error = anyhow::Error::new(Outer { source: Inner }).context("a.ron is no scene");
        assert_eq!(
            told(&error),
            "a.ron is no scene: cannot load: no such file; try another"
        );
        let error = anyhow::Error::new(Inner).context("a.ron is no scene");
        assert_eq!(told(&error), "a.ron is no scene: no such file");
    }
}
