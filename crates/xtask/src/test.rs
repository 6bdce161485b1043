//! `cargo xtask test`: what continuous integration runs.

use anyhow::Result;

use crate::{
    dawn::set_up_dawn,
    instructions,
    run::{Steps, cargo},
    setup::{set_up_tests, set_up_tools, set_up_valgrind},
};

pub(crate) fn test() -> Result<()> {
    let mut steps = Steps::new(7);
    // Checks of a second come before checks of minutes.
    steps.begin("cargo's tools");
    set_up_tools()?;
    steps.run("formatting", &mut cargo(&["fmt", "--all", "--check"]))?;
    steps.begin("set-up");
    let dawn = set_up_dawn()?;
    let valgrind = set_up_valgrind();
    set_up_tests()?;
    // The whole workspace: the benchmarks are no default member, and are only checked here.
    let mut clippy = cargo(&["clippy", "--workspace", "--all-targets"]);
    steps.run("lints", clippy.args(["--", "-D", "warnings"]))?;
    let mut tests = cargo(&["test", "--no-fail-fast"]);
    if dawn {
        // Without it, these tests would be skipped, and nobody would notice.
        tests.env("UMBRAGE_DAWN", "on");
    }
    steps.run("tests, doc tests included", &mut tests)?;
    steps.begin("counted instructions");
    if valgrind {
        instructions::check()?;
    } else {
        eprintln!("not counted: there is no valgrind");
    }
    let mut doc = cargo(&["doc", "--no-deps"]);
    steps.run("documentation", doc.env("RUSTDOCFLAGS", "-D warnings"))?;
    eprintln!("all checks passed");
    Ok(())
}
