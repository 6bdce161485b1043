//! `umbrage link`: one module with all that it reaches, or a key's permutation, as WGSL.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
};

use anyhow::{Context, Result};
use umbrage::compose::{Composer, Permutation, Target, link_file};

use crate::{args::LinkArgs, known::Known, output::print};

pub(crate) fn link(args: &LinkArgs, known: &Known) -> Result<ExitCode> {
    let permutation = match (&args.file, &args.key) {
        (Some(file), _) => Arc::new(module(file, args)?),
        (None, key) => {
            let library = known.library(args.package.as_slice())?;
            let key = library.parse_key(key.as_deref().unwrap_or(""))?;
            Composer::new(library, Target::default())
                .compose(&key)?
                .permutation
        }
    };
    for warning in &permutation.warnings {
        eprintln!("warning: {warning}");
    }
    print(&permutation.wgsl()?)?;
    Ok(ExitCode::SUCCESS)
}

fn module(file: &Path, args: &LinkArgs) -> Result<Permutation> {
    let package = args.package.clone().or_else(|| package_of(file));
    link_file(
        file,
        package.as_deref(),
        &args.features,
        &args.bindings,
        Target::default(),
    )
    .with_context(|| format!("{} cannot be linked", file.display()))
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
