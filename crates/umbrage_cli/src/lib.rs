//! The `umbrage` command, as a library: a crate of anybody's own gets it with its own parts of shadows.
//!
//! ```no_run
//! use std::process::ExitCode;
//!
//! # struct Soft;
//! # impl umbrage::shadow::Part for Soft {
//! #     fn name(&self) -> &str { "soft" }
//! # }
//! # impl umbrage::shadow::Filter for Soft {
//! #     fn reach(&self, _: &umbrage::shadow::Frame<'_>, _: usize) -> Result<f64, umbrage::shadow::PlanError> { Ok(1.0) }
//! #     fn fetches(&self, _: &umbrage::shadow::Frame<'_>, _: usize) -> Result<u32, umbrage::shadow::PlanError> { Ok(1) }
//! # }
//! fn main() -> ExitCode {
//!     umbrage_cli::main(|own| {
//!         own.packages.push(umbrage::compose::Package::load("soft", "shaders".as_ref())?);
//!         own.registry.filters.add(Soft)?;
//!         Ok(())
//!     })
//! }
//! ```
//!
//! Results go to standard output, and with `--json` or `--format` nothing else does; all that is said to a person goes
//! to standard error. Exit status: 0 done, 1 the checked input is faulty, 2 unusable arguments or input, 130
//! interrupted.

mod adapter;
mod args;
mod cause;
mod check;
mod compare;
mod cost;
mod cover;
mod explain;
mod folder;
mod interrupt;
mod known;
mod link;
mod list;
mod output;
mod passing;
mod prebuild;
mod quiet;
mod render;
mod report;
mod stress;
mod targets;
mod truth;

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;

use args::{Arguments, Command};

pub use known::Known;

/// Runs the command that the process's arguments ask for, with what `extend` adds to what it knows.
pub fn main(extend: impl FnOnce(&mut Known) -> Result<()>) -> ExitCode {
    // This comes first, as it may restart the process.
    quiet::mesa();
    // Serves the process that `compare` and `cost` start: no arguments, and nothing on standard output.
    umbrage_isa::serve_if_asked();
    let known = || {
        let mut known = Known::own()?;
        extend(&mut known)?;
        Ok(known)
    };
    let done = interrupt::install().and_then(|()| run(known));
    done.unwrap_or_else(|error| {
        eprintln!("error: {}", output::told(&error));
        // An interrupt is no fault of the input.
        ExitCode::from(if interrupt::asked() {
            interrupt::STATUS
        } else {
            2
        })
    })
}

fn run(known: impl FnOnce() -> Result<Known>) -> Result<ExitCode> {
    // Arguments come first: `--help` needs no shaders.
    let command = Arguments::parse().command;
    let known = known()?;
    match command {
        Command::Render(args) => render::render(&args, known),
        Command::Truth(args) => truth::truth(&args),
        Command::Compare(args) => compare::compare(&args, known),
        Command::Stress(args) => stress::stress(&args, known),
        Command::Check(args) => check::check(&args, &known),
        Command::List(args) => list::list(&args, &known),
        Command::Explain(args) => explain::explain(&args, &known),
        Command::Prebuild(args) => prebuild::prebuild(&args, &known),
        Command::Merge(args) => prebuild::merge(&args),
        Command::Cover(args) => cover::cover(&args),
        Command::Cost(args) => cost::cost(&args, &known),
        Command::Link(args) => link::link(&args, &known),
        Command::Adapter => adapter::adapter(),
    }
}
