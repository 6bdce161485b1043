//! Manifests: which keys exist.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use serde::Deserialize;

use crate::{
    Axes, Cause, Error, Fault, Key, Library, Package,
    file::SourceText,
    names::package_name,
    product::{Product, Rule},
    ron_text,
};

/// Which keys exist, over which packages, for which target.
///
/// ```ron
/// (
///     packages: { "umbrage": "../shader_lib" },
///     keys: [
///         { "pass": ["caster"], "alpha_test": All },
///         { "pass": ["illumination"], "light": ["spot"], "method": ["basic"], "cookie": All },
///     ],
///     exclude: [
///         (when: { "alpha_test": ["on"], "cookie": ["on"] }, reason: "no leaf stands in a cookie's light"),
///     ],
/// )
/// ```
/// `packages` names folders relative to the manifest. Each of `keys` is a product of values, `All` of
/// an axis or some; an axis that it leaves out stays at its default.
#[derive(Debug)]
pub struct Manifest {
    library: Library,
    packages: BTreeMap<String, PathBuf>,
    keys: Vec<Key>,
    target: String,
}

impl Manifest {
    /// Reads the manifest at `path`, and the packages that it names.
    ///
    /// # Errors
    /// An unreadable or malformed file, an unknown field, axis or value, a rule that excludes
    /// nothing, and a manifest that yields no key.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let source = SourceText::read(path)?;
        let file: ManifestFile = ron_text::parse(&source, Cause::Manifest)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        for name in file.packages.keys() {
            package_name(name).map_err(|fault| in_manifest(fault, &source, &["packages", name]))?;
        }
        let packages = file.packages.iter().map(|(name, path)| {
            Package::load(name, &folder.join(path)).map_err(|error| {
                let at = ron_text::literal(&source, &["packages", name, path]);
                let mut faults = error.into_faults();
                if let Some(fault) = faults
                    .first_mut()
                    .filter(|fault| fault.locations.is_empty())
                {
                    *fault = fault.clone().at(at);
                }
                Error::all(faults)
            })
        });
        let library = Library::new(packages.collect::<Result<Vec<_>, _>>()?)?;
        let keys = enumerate(library.axes(), &source, &file)?;
        // The folders were read just now; where one is gone, its own name will do.
        let packages = file.packages.iter().map(|(name, path)| {
            let path = folder.join(path);
            (name.clone(), path.canonicalize().unwrap_or(path))
        });
        let packages = packages.collect();
        Ok(Self {
            packages,
            library,
            keys,
            target: file.target,
        })
    }

    /// The folder of each package that the manifest names, with links followed.
    pub fn packages(&self) -> &BTreeMap<String, PathBuf> {
        &self.packages
    }

    /// The library of the packages.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// The keys, sorted, each once.
    pub fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// The name of the target that the keys are for.
    pub fn target(&self) -> &str {
        &self.target
    }
}

fn enumerate(axes: &Axes, source: &SourceText, file: &ManifestFile) -> Result<Vec<Key>, Error> {
    for rule in &file.exclude {
        for (name, values) in &rule.when {
            let axis = axes
                .check_axis(name)
                .map_err(|fault| in_manifest(fault, source, &["exclude", name]))?;
            for value in values {
                axes.check_value(axis, value)
                    .map_err(|fault| in_manifest(fault, source, &["exclude", name, value]))?;
            }
        }
    }
    let own: Vec<_> = file
        .exclude
        .iter()
        .map(|rule| Rule {
            exclude: rule.when.clone(),
            reason: rule.reason.clone(),
        })
        .collect();
    let mut used = vec![false; own.len()];
    let mut keys = Vec::new();
    for product in &file.keys {
        let product = Product::new(axes, source, &product.0)?;
        let rules = product.rules(axes, &own);
        let legality = product.legality(axes);
        product.for_each(&mut |choice, key| {
            // All rules that fit are noted as used, so that none is called needless by mistake.
            let mut excluded = false;
            for (rule, used) in rules.iter().zip(&mut used) {
                let fits = rule.fits(choice);
                *used |= fits;
                excluded |= fits;
            }
            // A combination that lacks something that one of its values needs is left out, too.
            if !excluded && legality.allows(choice) {
                keys.push(Key::new(key.iter().cloned()));
            }
        });
    }
    // Each product is sorted by itself; sort all of them together.
    keys.sort();
    keys.dedup();
    let rules = own;
    if let Some((rule, _)) = rules.iter().zip(&used).find(|(_, used)| !**used) {
        let message = format!("a rule excludes nothing: {}", rule.reason);
        let fault = Fault::new(Cause::Manifest, message).note("remove it, or mend what it names");
        return Err(in_manifest(fault, source, &["exclude", &rule.reason]).into());
    }
    if keys.is_empty() {
        let fault = Fault::new(Cause::Manifest, "the manifest yields no key")
            .note("add a product to `keys`, or exclude less");
        return Err(in_manifest(fault, source, &["keys"]).into());
    }
    Ok(keys)
}

pub(crate) fn in_manifest(mut fault: Fault, source: &SourceText, path: &[&str]) -> Fault {
    fault.cause = Cause::Manifest;
    fault.at(ron_text::literal(source, path))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ManifestFile {
    #[serde(deserialize_with = "ron_text::unique")]
    packages: BTreeMap<String, String>,
    #[serde(default = "default_target")]
    target: String,
    keys: Vec<ProductFile>,
    #[serde(default)]
    exclude: Vec<ExcludeFile>,
}

fn default_target() -> String {
    "webgpu".to_owned()
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ExcludeFile {
    #[serde(deserialize_with = "ron_text::unique")]
    when: BTreeMap<String, Vec<String>>,
    reason: String,
}

/// Values for some axes.
#[derive(Deserialize)]
#[serde(transparent)]
struct ProductFile(#[serde(deserialize_with = "ron_text::unique")] BTreeMap<String, Choice>);

/// `All`, or a list.
pub(crate) enum Choice {
    All,
    Some(Vec<String>),
}

impl<'de> Deserialize<'de> for Choice {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error as _;
        let raw = Box::<ron::value::RawValue>::deserialize(deserializer)?;
        match raw.trim().get_ron() {
            "All" => Ok(Self::All),
            text => ron::from_str(text).map(Self::Some).map_err(|_| {
                D::Error::custom(format!(
                    "expected `All` or a list of strings, found `{text}`"
                ))
            }),
        }
    }
}
