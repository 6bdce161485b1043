//! `cargo xtask test`: what continuous integration runs.

use anyhow::Result;

use crate::{
    run::{Steps, cargo},
    setup::set_up_tests,
};

pub(crate) fn test() -> Result<()> {
    let mut steps = Steps::new(5);
    steps.begin("set-up");
    set_up_tests()?;
    steps.run("formatting", &mut cargo(&["fmt", "--all", "--check"]))?;
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
