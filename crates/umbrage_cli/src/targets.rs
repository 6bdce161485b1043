//! Targets by their names in manifests and arguments.

use std::path::Path;

use anyhow::{Context, Result};
use umbrage::{compose::Target, render::Gpu};

/// The target called `name`, or in the file of this name where it ends in `.ron`. Only `this`, which is what this machine
/// offers, asks for an adapter.
pub(crate) fn target(name: &str) -> Result<Target> {
    let path = Path::new(name);
    if path.extension().is_some_and(|end| end == "ron") {
        return Ok(Target::load(path)?);
    }
    match name {
        "this" => Gpu::target().context(
            "the target `this` is what this machine's adapter offers; the others need none",
        ),
        _ => Ok(Target::named(name)?),
    }
}
