//! The `umbrage` command.
//!
//! Results go to standard output, and with `--json` nothing else does; all that is said to a person goes
//! to standard error. Exit status: 0 done, 1 the checked input is faulty, 2 unusable arguments or input, 130
//! interrupted.

mod adapter;
mod args;
mod cause;
mod check;
mod compare;
mod cost;
mod explain;
mod folder;
mod interrupt;
mod link;
mod list;
mod output;
mod packages;
mod passing;
mod prebuild;
mod quiet;
mod render;
mod report;
mod stress;
mod targets;
mod truth;

use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Command};

fn main() -> ExitCode {
    // This comes first, as it may restart the process.
    quiet::mesa();
    // What `compare` and `cost` start for themselves: no arguments, and nothing on standard output.
    umbrage_isa::serve_if_asked();
    let done = interrupt::install().and_then(|()| run());
    done.unwrap_or_else(|error| {
        eprintln!("error: {}", output::told(&error));
        // What an interrupt broke off is no fault of the input.
        ExitCode::from(if interrupt::asked() {
            interrupt::STATUS
        } else {
            2
        })
    })
}

fn run() -> anyhow::Result<ExitCode> {
    match Arguments::parse().command {
        Command::Render(args) => render::render(&args),
        Command::Truth(args) => truth::truth(&args),
        Command::Compare(args) => compare::compare(&args),
        Command::Stress(args) => stress::stress(&args),
        Command::Check(args) => check::check(&args),
        Command::List(args) => list::list(&args),
        Command::Explain(args) => explain::explain(&args),
        Command::Prebuild(args) => prebuild::prebuild(&args),
        Command::Cost(args) => cost::cost(&args),
        Command::Link(args) => link::link(&args),
        Command::Adapter => adapter::adapter(),
    }
}
