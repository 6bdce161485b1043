//! The `umbrage` command, which knows the filter `vsm` as well.

use std::process::ExitCode;

fn main() -> ExitCode {
    umbrage_cli::main(|known| {
        known.packages.push(umbrage_example_vsm::package()?);
        known.registry.filters.add(umbrage_example_vsm::Vsm)?;
        Ok(())
    })
}
