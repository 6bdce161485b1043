//! Configurations: a method with what is chosen for it.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;
use umbrage_compose::{Library, RonFile};
use umbrage_render::{Path, RenderOptions, Shadow};
use umbrage_shadow::Registry;

use crate::StudyError;

/// A method with what is chosen for it: an entry of a file of configurations, or a variant in a table of
/// [`Limits`](crate::cases::Limits).
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(from = "Entry")]
pub struct Config {
    /// Its name in reports; a method's configurations along one path have different names, and so have all
    /// variants of a table.
    pub name: String,
    /// How all lights' shadows are found.
    pub shadow: Shadow,
    /// How the shadow term comes to the surface.
    pub path: Path,
}

/// A configuration as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Config")]
struct Entry {
    name: String,
    method: String,
    #[serde(default)]
    axes: BTreeMap<String, String>,
    #[serde(default)]
    settings: BTreeMap<String, f64>,
    #[serde(default)]
    path: Path,
}

impl From<Entry> for Config {
    fn from(entry: Entry) -> Self {
        Self {
            name: entry.name,
            shadow: Shadow {
                method: entry.method,
                axes: entry.axes,
                settings: entry.settings,
            },
            path: entry.path,
        }
    }
}

/// The configurations that show what the project's own methods can do.
const STANDARD: &str = include_str!("../configs.ron");

impl Config {
    /// Reads a list of configurations, and checks each against what there is.
    ///
    /// # Errors
    /// Text that is no such list, or an empty one; a method, an axis, a value or a setting that does not
    /// exist; two configurations of one method, name and path. With the place in the file.
    pub fn read(
        file: &RonFile,
        registry: &Registry,
        library: &Library,
    ) -> Result<Vec<Self>, StudyError> {
        let configs: Vec<Self> = file.parse()?;
        if configs.is_empty() {
            let fault = file.fault("there is no configuration", file.all(), &[]);
            let note = "list one, such as (name: \"default\", method: \"basic\")";
            return Err(umbrage_compose::Error::from(fault.note(note)).into());
        }
        let mut seen = BTreeSet::new();
        for config in &configs {
            let own = config.check(registry, library);
            let checked = own.and_then(|()| {
                match seen.insert((&config.shadow.method, &config.name, config.path)) {
                    true => Ok(()),
                    false => Err(format!(
                        "method `{}` has two configurations called `{}`",
                        config.shadow.method, config.name
                    )),
                }
            });
            if let Err(problem) = checked {
                let fault = file.fault(problem, file.all(), &[&config.name]);
                return Err(umbrage_compose::Error::from(fault).into());
            }
        }
        Ok(configs)
    }

    /// Configurations of `methods` worth comparing: the project's own choice for its own methods; for any other its
    /// defaults, and each of its axes' values by itself.
    ///
    /// # Errors
    /// A method that is not registered.
    pub fn standard(
        methods: &[String],
        registry: &Registry,
        library: &Library,
    ) -> Result<Vec<Self>, StudyError> {
        let known: Vec<Self> = RonFile::new("configs.ron", STANDARD).parse()?;
        let varied = |method: &str| Self::varied(method, registry, library);
        Self::of_each(methods, registry, &known, varied)
    }

    /// The configurations of `known` for each of `methods`; what `otherwise` has of a method with none.
    pub(crate) fn of_each(
        methods: &[String],
        registry: &Registry,
        known: &[Self],
        otherwise: impl Fn(&str) -> Result<Vec<Self>, StudyError>,
    ) -> Result<Vec<Self>, StudyError> {
        let mut configs = Vec::new();
        for name in methods {
            registry.methods.get(name)?;
            let own = known.iter().filter(|config| config.shadow.method == *name);
            let before = configs.len();
            configs.extend(own.cloned());
            if configs.len() == before {
                configs.extend(otherwise(name)?);
            }
        }
        Ok(configs)
    }

    /// The method's defaults, called `name`.
    pub(crate) fn plain(method: &str, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            shadow: Shadow::new(method),
            path: Path::default(),
        }
    }

    /// The method's defaults, and each value of its axes, and of those of its default parts, by itself.
    fn varied(
        method: &str,
        registry: &Registry,
        library: &Library,
    ) -> Result<Vec<Self>, StudyError> {
        let plain = Self::plain(method, "default");
        let choice = plain.shadow.choice(registry, library)?;
        let mut configs = vec![plain];
        for name in choice.axes() {
            let Some(axis) = library.axes().get(name) else {
                continue;
            };
            for value in axis
                .values()
                .filter(|v| Some(*v) != axis.default.as_deref())
            {
                let mut varied = Self::plain(method, &format!("{name} {value}"));
                varied.shadow = varied.shadow.with(name, value);
                configs.push(varied);
            }
        }
        Ok(configs)
    }

    /// The method's name and the configuration's, for a person.
    pub(crate) fn label(&self) -> String {
        format!("{} ({})", self.shadow.method, self.name)
    }

    /// Options for a renderer.
    pub(crate) fn options(&self, (width, height): (u32, u32)) -> RenderOptions {
        RenderOptions {
            width,
            height,
            shadow: self.shadow.clone(),
            path: self.path,
            // Cost of a method where all that casts moves.
            fresh: true,
            ..RenderOptions::default()
        }
    }

    pub(crate) fn check(&self, registry: &Registry, library: &Library) -> Result<(), String> {
        let checked = self.shadow.check(registry, library);
        checked.map_err(|error| error.to_string()).map(drop)
    }
}
