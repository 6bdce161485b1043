//! `umbrage link`: one module with all that it reaches, as WGSL.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use anyhow::{Context, Result};
use umbrage::compose::{Target, link_file};

use crate::{args::LinkArgs, output::print};

pub(crate) fn link(args: &LinkArgs) -> Result<ExitCode> {
    let package = args.package.clone().or_else(|| package_of(&args.file));
    let permutation = link_file(
        &args.file,
        package.as_deref(),
        &args.features,
        &args.bindings,
        Target::default(),
    )
    .with_context(|| format!("{} cannot be linked", args.file.display()))?;
    for warning in &permutation.warnings {
        eprintln!("warning: {warning}");
    }
    print(&permutation.wgsl()?)?;
    Ok(ExitCode::SUCCESS)
}

/// The folder of the package that `file` lies in: the nearest above it with a `wesl.toml`.
fn package_of(file: &Path) -> Option<PathBuf> {
    let file = std::path::absolute(file).ok()?;
    let folder = file
        .ancestors()
        .skip(1)
        .find(|folder| folder.join("wesl.toml").is_file())?;
    // Faults name files as they were given, where that can be: relative to where we are.
    let here = std::env::current_dir().ok()?;
    Some(folder.strip_prefix(&here).unwrap_or(folder).to_owned())
}
