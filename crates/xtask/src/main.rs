//! The project's chores. `cargo xtask demo` and `cargo xtask test` each do their own set-up: a Debian
//! machine with Rust and nothing else is enough.
//!
//! This crate knows nothing of wgpu, so that it builds in seconds; whether the machine can render it
//! learns from `umbrage adapter`.

mod bench;
mod benches;
mod dawn;
mod demo;
mod instructions;
mod run;
mod setup;
mod test;

use std::process::ExitCode;

use clap::Parser;

/// Umbrage's chores.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
enum Chore {
    /// Sets the machine up, validates the demo's permutations and renders its scenes.
    Demo,
    /// Sets the machine up and runs all checks: what continuous integration runs.
    Test,
    /// Runs the benchmarks and holds their figures against `crates/umbrage_bench/benches.ron`.
    Bench(bench::Choices),
}

fn main() -> ExitCode {
    let done = match Chore::parse() {
        Chore::Demo => demo::demo(),
        Chore::Test => test::test(),
        Chore::Bench(choices) => bench::bench(&choices),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
