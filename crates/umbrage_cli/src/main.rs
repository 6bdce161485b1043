//! The `umbrage` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    umbrage_cli::main(|_| Ok(()))
}
