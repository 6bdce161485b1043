//! Set-up: cargo's tools, a C++ compiler, valgrind, and a wgpu adapter, from Mesa's software Vulkan where the machine
//! has none.

use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::run::{
    behind_spinner, cargo, failure, output_behind_spinner, root, shell_line, umbrage, visibly,
};

/// Something that a machine may lack, and the packages that have it.
struct Missing {
    /// Name of what is missing.
    what: &'static str,
    /// Name of what is installed instead of asking.
    name: &'static str,
    /// Debian's packages of it.
    packages: &'static [&'static str],
    /// Advice where there is no apt-get.
    by_hand: &'static str,
}

const ADAPTER: Missing = Missing {
    what: "Vulkan adapter",
    name: "Mesa's software Vulkan",
    packages: &["libvulkan1", "mesa-vulkan-drivers"],
    by_hand: "install a Vulkan driver (Mesa's lavapipe renders without a GPU) and its loader",
};

/// FLIP, which pictures are compared by, is its authors' C++.
const COMPILER: Missing = Missing {
    what: "C++ compiler",
    name: "g++",
    packages: &["g++"],
    by_hand: "install one, and name it in CXX if it is not `c++`",
};

/// Valgrind counts instructions. Where it cannot be had, they are not counted.
const VALGRIND: Missing = Missing {
    what: "valgrind",
    name: "valgrind",
    packages: &["valgrind"],
    by_hand: "install it",
};

/// Parts of cargo that `cargo xtask test` needs beyond building.
const TOOLS: [&str; 2] = ["fmt", "clippy"];

/// The test that passes where the command finds an adapter.
const ADAPTER_TEST: &str = "arguments::the_adapter_has_a_name";

/// Words of the command, which the test repeats, where the machine has no adapter. Nothing else that may go
/// wrong is helped by installing one. The command's test `no_adapter` holds it to these words.
const NO_ADAPTER: &str = "no Vulkan adapter was found";

/// Outcome of looking for an adapter, where the looking itself does not fail.
#[derive(Debug, PartialEq, Eq)]
enum Adapter {
    Found(String),
    /// There is none; in the command's words.
    None(String),
}

/// Builds the command and sees to it that the machine has an adapter.
pub(crate) fn set_up_command() -> Result<()> {
    ensure_compiler(has_compiler)?;
    visibly(&mut cargo(&["build", "--bin", "umbrage"]))?;
    ensure_adapter(|| look(&mut umbrage(&["adapter"])))
}

/// Builds the tests and sees to it that the machine has an adapter.
///
/// Tests ask their dependencies for features that the command alone does not: to build the command by
/// itself would build most dependencies twice. So a test that runs the command looks for the adapter.
pub(crate) fn set_up_tests() -> Result<()> {
    ensure_compiler(has_compiler)?;
    visibly(&mut cargo(&["test", "--no-run"]))?;
    ensure_adapter(|| {
        let args = ["test", "--quiet", "--test", "cli", "--", "--exact"];
        let mut test = cargo(&args);
        match look(test.arg(ADAPTER_TEST))? {
            Adapter::Found(said) if !said.contains("1 passed") => bail!(
                "there is no test {ADAPTER_TEST} any more; name its successor in xtask's setup.rs"
            ),
            Adapter::Found(_) => Ok(Adapter::Found("found".to_owned())),
            none => Ok(none),
        }
    })
}

/// Runs `probe`, which succeeds where there is an adapter.
fn look(probe: &mut Command) -> Result<Adapter> {
    let output = output_behind_spinner("looking for an adapter", probe)?;
    let (out, err) = (
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
    if output.status.success() {
        return Ok(Adapter::Found(out.trim().to_owned()));
    }
    // Without an exit status of its own it crashed, whatever it said before.
    let none = [&err, &out]
        .into_iter()
        .flat_map(|text| text.lines())
        .find(|line| output.status.code().is_some() && line.contains(NO_ADAPTER));
    match none {
        Some(line) => Ok(Adapter::None(line.trim().to_owned())),
        None => Err(failure(probe, &output)).context("whether there is an adapter cannot be told"),
    }
}

/// Installs Mesa's software Vulkan where `look` finds no adapter.
fn ensure_adapter(look: impl Fn() -> Result<Adapter>) -> Result<()> {
    match look()? {
        Adapter::Found(adapter) => {
            eprintln!("adapter: {adapter}");
            return Ok(());
        }
        Adapter::None(reason) => eprintln!("{reason}"),
    }
    ADAPTER.install()?;
    match look()? {
        Adapter::Found(adapter) => eprintln!("adapter: {adapter}"),
        Adapter::None(reason) => {
            bail!("Mesa's software Vulkan was installed, but there is still no adapter: {reason}")
        }
    }
    Ok(())
}

/// Installs a C++ compiler where there is none.
fn ensure_compiler(there: impl Fn() -> bool) -> Result<()> {
    if there() {
        return Ok(());
    }
    COMPILER.install()?;
    if !there() {
        bail!(
            "g++ was installed, but `{}` still does not run; name a C++ compiler in CXX",
            compiler()
        );
    }
    Ok(())
}

/// Installs valgrind where that needs nobody, and returns whether it is there; if not, prints what to do.
pub(crate) fn set_up_valgrind() -> bool {
    let there = || runs("valgrind", &["--version"]);
    if !there()
        && let Err(reason) = VALGRIND.install()
    {
        eprintln!("instructions are not counted: {reason:#}");
    }
    there()
}

/// Command by which a build compiles C++.
fn compiler() -> String {
    let named = std::env::var("CXX").unwrap_or_default();
    // Flags may follow it.
    named.split_whitespace().next().unwrap_or("c++").to_owned()
}

/// Whether it runs. On Windows it is not on the path, but comes with the linker that cargo needs.
fn has_compiler() -> bool {
    cfg!(windows) || runs(&compiler(), &["--version"])
}

impl Missing {
    /// Installs it by apt-get, or says why not and what to do.
    fn install(&self) -> Result<()> {
        let Self { what, name, .. } = self;
        let commands = self.commands();
        let lines: Vec<_> = commands.iter().map(shell_line).collect();
        let script = lines.join(" && ");
        if !has_apt() {
            bail!(
                "this machine has no {what}, and no apt-get to install one with; {}, and run this again",
                self.by_hand
            );
        }
        if !is_root() {
            bail!(
                "this machine has no {what}, and only root can install {name}; run\n    \
                 sudo sh -c '{script}'\nand then this again"
            );
        }
        eprintln!("no {what} found; installing {name}: {script}");
        for mut command in commands {
            let line = shell_line(&command);
            behind_spinner(&line, &mut command)?;
        }
        Ok(())
    }

    fn commands(&self) -> [Command; 2] {
        let apt = |args: &[&str]| {
            let mut command = Command::new("apt-get");
            // Nothing may wait for an answer; another apt at work is waited for.
            command.args(["-o", "DPkg::Lock::Timeout=120"]).args(args);
            command.env("DEBIAN_FRONTEND", "noninteractive");
            command
        };
        let mut install = apt(&["install", "--yes", "--no-install-recommends"]);
        install.args(self.packages);
        [apt(&["update"]), install]
    }
}

/// Sees to it that cargo can format and lint: some installations of Rust come without.
pub(crate) fn set_up_tools() -> Result<()> {
    ensure_tools(
        || TOOLS.into_iter().all(has_tool),
        runs("rustup", &["--version"]).then_some(|| {
            let mut rustup = Command::new("rustup");
            visibly(rustup.args(["component", "add", "rustfmt", "clippy"]))
        }),
    )
}

fn ensure_tools(
    complete: impl Fn() -> bool,
    rustup: Option<impl FnOnce() -> Result<()>>,
) -> Result<()> {
    if complete() {
        return Ok(());
    }
    if let Some(add) = rustup {
        add()?;
    }
    if !complete() {
        bail!(
            "`cargo fmt` or `cargo clippy` does not run. Install both and run this again:\n    \
             rustup component add rustfmt clippy          (Rust from rustup)\n    \
             apt-get install --yes rustfmt rust-clippy    (Debian's Rust, as root)"
        );
    }
    Ok(())
}

fn has_tool(tool: &str) -> bool {
    let mut version = cargo(&[tool, "--version"]);
    succeeds(&mut version)
}

fn has_apt() -> bool {
    runs("apt-get", &["--version"])
}

fn runs(program: &str, args: &[&str]) -> bool {
    succeeds(Command::new(program).args(args))
}

fn succeeds(command: &mut Command) -> bool {
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .current_dir(root())
        .status()
        .is_ok_and(|status| status.success())
}

fn is_root() -> bool {
    let id = Command::new("id").arg("-u").stdin(Stdio::null()).output();
    id.is_ok_and(|id| id.stdout.trim_ascii() == b"0")
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    fn probe(script: &str) -> Result<Adapter> {
        look(Command::new("sh").args(["-c", script]))
    }

    #[test]
    fn an_adapter_is_found_or_not() {
        let found = probe("echo llvmpipe").expect("found");
        assert_eq!(found, Adapter::Found("llvmpipe".to_owned()));
        for script in [
            "echo 'error: no Vulkan adapter was found (vulkan: gone)' >&2; exit 2",
            // A failed test's words come on standard output.
            "echo failures:; echo 'error: no Vulkan adapter was found (vulkan: gone)'; exit 101",
        ] {
            let none = probe(script).expect("none");
            let reason = "error: no Vulkan adapter was found (vulkan: gone)";
            assert_eq!(none, Adapter::None(reason.to_owned()));
        }
    }

    #[test]
    fn what_fails_is_not_taken_for_no_adapter() {
        for (script, part) in [
            (
                "echo 'error[E0308]: mismatched types' >&2; exit 101",
                "E0308",
            ),
            ("kill -SEGV $$", "signal"),
            (
                "echo 'no Vulkan adapter was found'; kill -ABRT $$",
                "signal",
            ),
        ] {
            let said = format!("{:#}", probe(script).expect_err(script));
            assert!(said.contains("sh -c") && said.contains(part), "{said}");
            let error = ensure_adapter(|| probe(script)).expect_err("nothing is installed");
            assert!(format!("{error:#}").contains(part), "{error:#}");
        }
    }

    #[test]
    fn tools_come_from_rustup_or_are_asked_for() {
        let (there, added) = (Cell::new(true), Cell::new(0));
        let add = || {
            added.set(added.get() + 1);
            there.set(true);
            Ok(())
        };
        ensure_tools(|| there.get(), Some(add)).expect("nothing to do");
        assert_eq!(added.get(), 0);
        there.set(false);
        ensure_tools(|| there.get(), Some(add)).expect("added");
        assert_eq!(added.get(), 1);
        there.set(false);
        for rustup in [None, Some(|| Ok(()))] {
            let said = ensure_tools(|| there.get(), rustup).expect_err("missing");
            let said = said.to_string();
            assert!(
                said.contains("rustup component add rustfmt clippy"),
                "{said}"
            );
            assert!(
                said.contains("apt-get install --yes rustfmt rust-clippy"),
                "{said}"
            );
        }
        assert!(!has_tool("no-such-tool"));
    }

    #[test]
    fn a_compiler_that_is_there_is_not_installed() {
        let asked = Cell::new(0);
        ensure_compiler(|| {
            asked.set(asked.get() + 1);
            true
        })
        .expect("nothing to do");
        assert_eq!(asked.get(), 1);
        // This was built with one.
        assert!(has_compiler());
    }

    #[test]
    fn the_commands_ask_nothing() {
        for (missing, packages) in [
            (ADAPTER, "libvulkan1 mesa-vulkan-drivers"),
            (COMPILER, "g++"),
            (VALGRIND, "valgrind"),
        ] {
            let lines = missing.commands().each_ref().map(shell_line);
            let apt = "DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=120";
            let install = format!("{apt} install --yes --no-install-recommends {packages}");
            assert_eq!(lines, [format!("{apt} update"), install]);
        }
    }
}
