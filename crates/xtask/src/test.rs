//! `cargo xtask test`: what continuous integration runs.

use anyhow::Result;

use crate::{
    run::{Steps, cargo},
    setup::{set_up_tests, set_up_tools},
};

pub(crate) fn test() -> Result<()> {
    let mut steps = Steps::new(6);
    // What takes a second comes before what takes minutes.
    steps.begin("cargo's tools");
    set_up_tools()?;
    steps.run("formatting", &mut cargo(&["fmt", "--all", "--check"]))?;
    steps.begin("set-up");
    set_up_tests()?;
    // The whole workspace: the benchmarks are no default member, and are only checked here.
    let mut clippy = cargo(&["clippy", "--workspace", "--all-targets"]);
    steps.run("lints", clippy.args(["--", "-D", "warnings"]))?;
    steps.run(
        "tests, doc tests included",
        &mut cargo(&["test", "--no-fail-fast"]),
    )?;
    let mut doc = cargo(&["doc", "--no-deps"]);
    steps.run("documentation", doc.env("RUSTDOCFLAGS", "-D warnings"))?;
    eprintln!("all checks passed");
    Ok(())
}
