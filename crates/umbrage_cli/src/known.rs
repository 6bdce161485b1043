//! Parts and packages that the command knows.

use std::path::PathBuf;

use anyhow::{Context, Result};
use umbrage::{
    compose::{Library, Manifest, Package, Selection},
    shadow::Registry,
};

use crate::args::KeyArgs;

/// Parts and packages that the command knows: our own, and those of whoever extends it.
pub struct Known {
    /// Shader packages; ours is the first.
    pub packages: Vec<Package>,
    /// Parts of shadows.
    pub registry: Registry,
}

impl Known {
    pub(crate) fn own() -> Result<Self> {
        Ok(Self {
            packages: vec![umbrage::shader_package()?],
            registry: umbrage::methods::registry()?,
        })
    }

    /// The library of the packages in `folders`, each called like its folder; without any, of all that are known.
    pub(crate) fn library(&self, folders: &[PathBuf]) -> Result<Library> {
        if folders.is_empty() {
            return Ok(Library::new(self.packages.iter().cloned())?);
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

    /// Selection of `args`: their keys, or without any the whole space of their packages.
    pub(crate) fn selected(&self, args: &KeyArgs) -> Result<Manifest> {
        let library = self.library(&args.packages)?;
        let keys = args.keys.iter().map(|text| Ok(library.parse_key(text)?));
        let keys = keys.collect::<Result<Vec<_>>>()?;
        let selection = match keys.as_slice() {
            [] => Selection::all(),
            keys => Selection::of(&library, keys),
        };
        Ok(Manifest::of(library, selection))
    }
}
