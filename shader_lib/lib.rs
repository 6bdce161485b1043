//! Umbrage's WESL package, embedded: an engine that ships it needs no files.
//!
//! The modules are beside this file. An author who changes them loads the folder instead, with
//! [`Package::load`].

use include_dir::{Dir, include_dir};
use umbrage_compose::{Error, Package};

static FOLDER: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR");

/// The package `umbrage`.
///
/// # Errors
/// Where a module or `axes.ron` is faulty; the project's tests keep it from happening.
pub fn package() -> Result<Package, Error> {
    Package::from_sources("umbrage", "shader_lib", sources())
}

/// The modules and the axes: paths below the package's folder, and texts.
fn sources() -> Vec<(String, String)> {
    let mut folders = vec![&FOLDER];
    let mut sources = Vec::new();
    while let Some(folder) = folders.pop() {
        folders.extend(folder.dirs());
        for file in folder.files() {
            let path = file.path();
            let wanted = path
                .extension()
                .is_some_and(|extension| extension == "wesl")
                || path.as_os_str() == "axes.ron";
            if let (true, Some(text), Some(path)) = (wanted, file.contents_utf8(), path.to_str()) {
                sources.push((path.replace('\\', "/"), text.to_owned()));
            }
        }
    }
    sources.sort();
    sources
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_modules_are_embedded() {
        let paths: Vec<_> = sources().into_iter().map(|(path, _)| path).collect();
        assert!(paths.contains(&"axes.ron".to_owned()));
        assert!(paths.contains(&"interface/shadow.wesl".to_owned()));
        assert!(
            !paths
                .iter()
                .any(|path| path.ends_with(".rs") || path.ends_with(".toml"))
        );
    }

    #[test]
    fn the_package_loads() {
        package().unwrap();
    }
}
