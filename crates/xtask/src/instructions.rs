//! Counted instructions, held against `benches.ron`: what would make the composer or a frame slower is told before anybody
//! times it.

use std::{collections::BTreeMap, process::Command};

use anyhow::{Context, Result, bail};

use crate::{
    benches::{Benches, FILE},
    run::{captured, cargo, failure, output_behind_spinner},
};

/// Counts, and fails where a path takes more than its line allows.
pub(crate) fn check() -> Result<()> {
    let expected = Benches::load()?.instructions;
    let compiler = compiler()?;
    if compiler != expected.compiler {
        eprintln!(
            "not counted: {FILE} has the counts of {}, and this is {compiler}; to move it on, write its name and all counts \
             there, as `cargo run --example instructions` prints them",
            expected.compiler
        );
        return Ok(());
    }
    let mut count = cargo(&["run", "--quiet", "--example", "instructions"]);
    let output = output_behind_spinner("counting", &mut count)?;
    if !output.status.success() {
        return Err(failure(&count, &output));
    }
    let counts: BTreeMap<String, u64> = serde_json::from_slice(&output.stdout)
        .context("the example `instructions` printed no counts")?;
    let misfits = expected.tell(&counts);
    if !misfits.is_empty() {
        bail!(
            "paths take over 5 % more instructions than {FILE} says, or are not as it names them; find what made them so. \
             Where it is meant, change their lines in the same commit, to\n    {}",
            misfits.join("\n    ")
        );
    }
    Ok(())
}

/// Name and version of the compiler, as `rustc --version` begins.
fn compiler() -> Result<String> {
    // Cargo sets `RUSTC` only for build scripts.
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let said = captured(Command::new(rustc).arg("--version"))?.stdout;
    let said = String::from_utf8_lossy(&said);
    Ok(said
        .split_whitespace()
        .take(2)
        .collect::<Vec<_>>()
        .join(" "))
}
