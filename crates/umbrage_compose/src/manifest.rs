//! Manifests: which keys are meant, of all that are legal.

use std::{
    collections::BTreeMap,
    fmt,
    path::{Path, PathBuf},
};

use serde::{
    Deserialize,
    de::{MapAccess, value::MapAccessDeserializer},
};

use crate::{
    Cause, Error, Fault, Library, Package, Selection, bits::Bits, file::SourceText,
    names::package_name, parts::Part, ron_text,
};

/// Which legal keys are meant, of which packages, for which target.
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
/// an axis or some; an axis that it leaves out stays at its default. Combinations that are not legal are left out.
/// One of `keys` may also be a key as text, `"light=spot,pass=caster"`, such as a report says was drawn; it must be
/// legal. `keys: All` means every legal key. `target` names what they are for, `webgpu` where it is left out, or a
/// [table](crate::Target::load)'s file, relative to the manifest.
#[derive(Debug)]
pub struct Manifest {
    library: Library,
    packages: BTreeMap<String, PathBuf>,
    selection: Selection,
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
        let keys = &source.text[ron_text::at(&source, "keys")];
        let (named, target, file) = match keys {
            "All" => {
                let file: WholeFile = ron_text::parse(&source)?;
                (file.packages, file.target, None)
            }
            _ => {
                let file: ManifestFile = ron_text::parse(&source)?;
                (file.packages.clone(), file.target.clone(), Some(file))
            }
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        for name in named.keys() {
            package_name(name).map_err(|fault| in_manifest(fault, &source, &["packages", name]))?;
        }
        let packages = named.iter().map(|(name, path)| {
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
        let selection = match &file {
            Some(file) => select(&library, &source, file)?,
            None => Selection::all(),
        };
        // The folders were read just now; where one is gone, its own name will do.
        let packages = named.iter().map(|(name, path)| {
            let path = folder.join(path);
            (name.clone(), path.canonicalize().unwrap_or(path))
        });
        let packages = packages.collect();
        // A table's file is named as the packages' folders are.
        let target = match target.ends_with(".ron") {
            true => folder.join(&target).display().to_string(),
            false => target,
        };
        Ok(Self {
            packages,
            library,
            selection,
            target,
        })
    }

    /// A manifest that selects these keys of a library, for the default target: of no packages' folders.
    pub fn of(library: Library, selection: Selection) -> Self {
        Self {
            packages: BTreeMap::new(),
            library,
            selection,
            target: default_target(),
        }
    }

    /// The folder of each package that the manifest names, with links followed.
    pub fn packages(&self) -> &BTreeMap<String, PathBuf> {
        &self.packages
    }

    /// The library of the packages.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// The keys that it selects.
    pub fn selection(&self) -> &Selection {
        &self.selection
    }

    /// The name of the target that the keys are for, or the path of its table, which ends in `.ron`.
    pub fn target(&self) -> &str {
        &self.target
    }
}

fn select(library: &Library, source: &SourceText, file: &ManifestFile) -> Result<Selection, Error> {
    let (axes, table) = (library.axes(), library.table());
    let mut rules = Vec::new();
    for rule in &file.exclude {
        let values = |values: &Vec<String>| Choice::Some(values.clone());
        let named = rule
            .when
            .iter()
            .map(|(axis, list)| (axis.clone(), values(list)));
        rules.push(product(library, source, "exclude", &named.collect())?);
    }
    let mut used = vec![false; rules.len()];
    let mut taken: Vec<Part> = Vec::new();
    let mut parts: Vec<Part> = Vec::new();
    for keys in &file.keys {
        let whole = match keys {
            KeysFile::Product(named) => {
                axes.check_complete(|axis| named.contains_key(axis))
                    .map_err(|fault| in_manifest(fault, source, &["keys"]))?;
                let mut whole = product(library, source, "keys", named)?;
                table.at_defaults(&mut whole, |axis| !named.contains_key(axis));
                whole
            }
            KeysFile::Key(text) => {
                let key = library.parse_key(text).map_err(|error| {
                    let faults = error.into_faults().into_iter();
                    Error::all(
                        faults
                            .map(|f| in_manifest(f, source, &["keys", text]))
                            .collect(),
                    )
                })?;
                table.only(axes, &key)
            }
        };
        for (rule, used) in rules.iter().zip(&mut used) {
            *used |= table.first(&whole.and(rule)).is_some();
        }
        let mut pieces = vec![whole.clone()];
        for other in rules.iter().chain(&taken) {
            let rest = pieces.iter().flat_map(|piece| table.subtract(piece, other));
            pieces = rest.collect();
        }
        parts.extend(pieces);
        taken.push(whole);
    }
    if let Some((rule, _)) = file.exclude.iter().zip(&used).find(|(_, used)| !**used) {
        let message = format!("a rule excludes nothing: {}", rule.reason);
        let fault = Fault::new(Cause::Manifest, message).note("remove it, or mend what it names");
        return Err(in_manifest(fault, source, &["exclude", &rule.reason]).into());
    }
    parts.retain(|part| table.first(part).is_some());
    if parts.is_empty() {
        let fault = Fault::new(Cause::Manifest, "the manifest yields no key")
            .note("add a product to `keys`, or exclude less");
        return Err(in_manifest(fault, source, &["keys"]).into());
    }
    Ok(Selection { parts: Some(parts) })
}

/// All keys with the values that `named`, under `list` in the manifest, gives some axes.
fn product(
    library: &Library,
    source: &SourceText,
    list: &str,
    named: &BTreeMap<String, Choice>,
) -> Result<Part, Fault> {
    let (axes, table) = (library.axes(), library.table());
    let mut part = table.whole();
    for (name, choice) in named {
        let axis = axes
            .check_axis(name)
            .map_err(|fault| in_manifest(fault, source, &[list, name]))?;
        let Choice::Some(values) = choice else {
            continue;
        };
        let mut numbers = Bits::default();
        for value in values {
            axes.check_value(axis, value)
                .map_err(|fault| in_manifest(fault, source, &[list, name, value]))?;
            numbers.extend(table.number(name, value));
        }
        table.narrow(&mut part, name, &numbers);
    }
    Ok(part)
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
    keys: Vec<KeysFile>,
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

/// Keys to select.
enum KeysFile {
    /// Values for some axes.
    Product(BTreeMap<String, Choice>),
    /// One key, as it is printed.
    Key(String),
}

impl<'de> Deserialize<'de> for KeysFile {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;

        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = KeysFile;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("values for some axes, or a key as text")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<KeysFile, A::Error> {
                ron_text::unique(MapAccessDeserializer::new(map)).map(KeysFile::Product)
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<KeysFile, E> {
                Ok(KeysFile::Key(text.to_owned()))
            }
        }

        deserializer.deserialize_any(Visitor)
    }
}

/// A manifest of all keys.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WholeFile {
    #[serde(deserialize_with = "ron_text::unique")]
    packages: BTreeMap<String, String>,
    #[serde(default = "default_target")]
    target: String,
    #[serde(rename = "keys")]
    _keys: AllKeys,
}

#[derive(Deserialize)]
enum AllKeys {
    All,
}

/// `All`, or a list.
enum Choice {
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
