//! Runs commands, and says which failed in words that can be pasted into a shell.

use std::{
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    time::{Duration, Instant},
};

use anyhow::{Context, Error, Result, anyhow, bail};
use indicatif::{ProgressBar, ProgressStyle};

/// The workspace's root: all commands run here.
pub(crate) fn root() -> PathBuf {
    let crate_dir = Path::new(env!("CARGO_MANIFEST_DIR"));
    crate_dir.ancestors().nth(2).unwrap_or(crate_dir).to_owned()
}

/// The cargo that runs this chore, with `args`.
pub(crate) fn cargo(args: &[&str]) -> Command {
    // Cargo sets `CARGO` for what it runs; started by hand, the one on the path will do.
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(args);
    command
}

/// The umbrage command, built where it is out of date.
///
/// `--bin` without `--package` selects the features of all default members, as the tests' build does,
/// so that the dependencies are built once.
pub(crate) fn umbrage(args: &[&str]) -> Command {
    let mut command = cargo(&["run", "--quiet", "--bin", "umbrage", "--"]);
    command.args(args);
    command
}

/// Numbered steps of a chore.
pub(crate) struct Steps {
    total: usize,
    done: usize,
    started: Instant,
}

impl Steps {
    pub(crate) fn new(total: usize) -> Self {
        Self {
            total,
            done: 0,
            started: Instant::now(),
        }
    }

    /// Says that the next step begins.
    pub(crate) fn begin(&mut self, what: &str) {
        self.done += 1;
        let elapsed = self.started.elapsed().as_secs();
        eprintln!("[{}/{}] {what} ({elapsed} s so far)", self.done, self.total);
    }

    /// Runs `command` as the next step; what it prints, its own progress included, is seen at once.
    pub(crate) fn run(&mut self, what: &str, command: &mut Command) -> Result<()> {
        self.begin(&format!("{what}: {}", shell_line(command)));
        visibly(command)
    }
}

/// Runs `command`, which prints for itself.
pub(crate) fn visibly(command: &mut Command) -> Result<()> {
    let line = shell_line(command);
    let status = at_home(command)
        .status()
        .with_context(|| format!("`{line}` could not be started"))?;
    if !status.success() {
        bail!(
            "`{line}` failed ({status}); its own words are above. Run it again by itself in {}",
            root().display()
        );
    }
    Ok(())
}

/// Runs `command` behind a spinner; its words are shown only where it fails.
pub(crate) fn behind_spinner(what: &str, command: &mut Command) -> Result<Output> {
    spinning(what, || captured(command))
}

/// Runs `command` behind a spinner and keeps what it prints, whether or not it fails.
pub(crate) fn output_behind_spinner(what: &str, command: &mut Command) -> Result<Output> {
    spinning(what, || output(command))
}

/// Runs `command` and keeps what it prints; its words are in the error where it fails.
pub(crate) fn captured(command: &mut Command) -> Result<Output> {
    let output = output(command)?;
    if !output.status.success() {
        return Err(failure(command, &output));
    }
    Ok(output)
}

/// Says that `command` failed, and what it said.
pub(crate) fn failure(command: &Command, output: &Output) -> Error {
    anyhow!(
        "`{}` failed ({}):\n{}{}",
        shell_line(command),
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr).trim_end(),
    )
}

fn output(command: &mut Command) -> Result<Output> {
    let line = shell_line(command);
    at_home(command)
        .output()
        .with_context(|| format!("`{line}` could not be started"))
}

/// `command` in the workspace's root, with no one to answer its questions.
fn at_home(command: &mut Command) -> &mut Command {
    command.current_dir(root()).stdin(Stdio::null())
}

/// Shows that `work` is going on, and for how long it has been.
fn spinning<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let spinner = ProgressBar::new_spinner().with_message(what.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
        spinner.set_style(style);
    }
    spinner.enable_steady_tick(Duration::from_millis(100));
    let result = work();
    spinner.finish_and_clear();
    result
}

/// `command` as one would type it.
pub(crate) fn shell_line(command: &Command) -> String {
    let mut line = String::new();
    for (name, value) in command.get_envs() {
        if let Some(value) = value {
            line += &format!(
                "{}={} ",
                name.to_string_lossy(),
                quoted(&value.to_string_lossy())
            );
        }
    }
    let program = Path::new(command.get_program());
    // The toolchain's own path to cargo helps no one.
    line += &program
        .file_name()
        .unwrap_or(program.as_os_str())
        .to_string_lossy();
    for arg in command.get_args() {
        line.push(' ');
        line += &quoted(&arg.to_string_lossy());
    }
    line
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=+./:,@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_line_can_be_pasted() {
        let mut command = Command::new("/somewhere/bin/cargo");
        command
            .args(["doc", "--no-deps", "it's"])
            .env("RUSTDOCFLAGS", "-D warnings");
        assert_eq!(
            shell_line(&command),
            r"RUSTDOCFLAGS='-D warnings' cargo doc --no-deps 'it'\''s'"
        );
    }

    #[test]
    fn a_failure_names_the_command_and_its_words() {
        let mut command = Command::new("sh");
        command.args(["-c", "echo because >&2; exit 3"]);
        let error = behind_spinner("failing", &mut command)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("sh -c 'echo because >&2; exit 3'"),
            "{error}"
        );
        assert!(error.contains("because"), "{error}");
        assert!(error.contains('3'), "{error}");
    }

    #[test]
    fn the_root_is_the_workspace() {
        assert!(root().join("shader_lib/wesl.toml").is_file());
    }
}
