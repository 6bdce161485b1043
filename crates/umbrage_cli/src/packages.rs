//! Packages and their keys in arguments.

use std::path::PathBuf;

use anyhow::{Context, Result};
use umbrage::compose::{Library, Manifest, Package, Selection};

use crate::args::KeyArgs;

/// Selection of `args`: their keys, or without any the whole space of their packages.
pub(crate) fn selected(args: &KeyArgs) -> Result<Manifest> {
    let library = library(&args.packages)?;
    let keys = args.keys.iter().map(|text| Ok(library.parse_key(text)?));
    let keys = keys.collect::<Result<Vec<_>>>()?;
    let selection = match keys.as_slice() {
        [] => Selection::all(),
        keys => Selection::of(&library, keys),
    };
    Ok(Manifest::of(library, selection))
}

/// The library of the packages in `folders`, each called like its folder; without any, our own.
pub(crate) fn library(folders: &[PathBuf]) -> Result<Library> {
    if folders.is_empty() {
        return Ok(umbrage::shader_library()?);
    }
    let packages = folders.iter().map(|folder| {
        // A folder such as `.` has its name only once links are followed.
        let whole = folder
            .canonicalize()
            .with_context(|| format!("the package {} cannot be read", folder.display()))?;
        let name = whole.file_name().unwrap_or_default().to_string_lossy();
        Ok(Package::load(&name, folder)?)
    });
    let packages = packages.collect::<Result<Vec<_>>>()?;
    Ok(Library::new(packages)?)
}
