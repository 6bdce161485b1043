//! Configurations: a method with what is chosen for it.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;
use umbrage_compose::{Library, RonFile};
use umbrage_render::{Path, RenderOptions, Shadow};
use umbrage_shadow::Registry;

use super::StudyError;
use crate::cases::Limits;

/// A method with what is chosen for it: an entry of a file of configurations, or a variant in a table of
/// [`Limits`].
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// What reports call it; a method's configurations along one path have different names, and so have all
    /// variants of a table.
    pub name: String,
    /// The shadow method of all lights.
    pub method: String,
    /// Values of the method's axes; the rest have their defaults.
    #[serde(default)]
    pub axes: BTreeMap<String, String>,
    /// Values of the method's settings; the rest have their defaults.
    #[serde(default)]
    pub settings: BTreeMap<String, f64>,
    /// How the shadow term comes to the surface: `forward`, by way of a `mask`, or of one filled split by split,
    /// `mask_by_split`.
    #[serde(default)]
    pub path: Path,
}

/// The configurations that show what the project's own methods can do.
const STANDARD: &str = include_str!("../../configs.ron");

impl Config {
    /// Reads a list of configurations, and checks each against what there is.
    ///
    /// # Errors
    /// What is no such list, or an empty one; a method, an axis, a value or a setting that does not
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
            let checked =
                own.and_then(
                    |()| match seen.insert((&config.method, &config.name, config.path)) {
                        true => Ok(()),
                        false => Err(format!(
                            "method `{}` has two configurations called `{}`",
                            config.method, config.name
                        )),
                    },
                );
            if let Err(problem) = checked {
                let fault = file.fault(problem, file.all(), &[&config.name]);
                return Err(umbrage_compose::Error::from(fault).into());
            }
        }
        Ok(configs)
    }

    /// What is worth comparing of `methods`: the project's own choice for its own methods; for any other its
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

    /// What `methods` are held against the hard cases as: the variants that `limits` lists of each; a method of
    /// which it lists none with its defaults, by its own name.
    ///
    /// # Errors
    /// A method that is not registered; a variant with an axis, a value or a setting that its method does not
    /// have, with the place in the table; a method without a variant that is called as another's is.
    pub fn variants(
        limits: &Limits,
        methods: &[String],
        registry: &Registry,
        library: &Library,
    ) -> Result<Vec<Self>, StudyError> {
        let plain = |method: &str| Ok(vec![Self::plain(method, method)]);
        let variants = Self::of_each(methods, registry, limits.variants(), plain)?;
        for variant in &variants {
            let listed = limits.variants().iter().find(|v| v.name == variant.name);
            let checked = match listed.filter(|listed| listed.method != variant.method) {
                Some(listed) => Err(format!(
                    "a variant of `{}` is called as the method `{}`; rename it, or list a variant of that method",
                    listed.method, variant.name
                )),
                None => variant.check(registry, library),
            };
            checked.map_err(|problem| {
                umbrage_compose::Error::from(limits.fault(&variant.name, problem))
            })?;
        }
        Ok(variants)
    }

    /// Those of `known` that are of each of `methods`; what `otherwise` has of a method with none.
    fn of_each(
        methods: &[String],
        registry: &Registry,
        known: &[Self],
        otherwise: impl Fn(&str) -> Result<Vec<Self>, StudyError>,
    ) -> Result<Vec<Self>, StudyError> {
        let mut configs = Vec::new();
        for name in methods {
            registry.methods.get(name)?;
            let own = known.iter().filter(|config| config.method == *name);
            let before = configs.len();
            configs.extend(own.cloned());
            if configs.len() == before {
                configs.extend(otherwise(name)?);
            }
        }
        Ok(configs)
    }

    /// The method's defaults, called `name`.
    fn plain(method: &str, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            method: method.to_owned(),
            ..Self::default()
        }
    }

    /// The method's defaults, and each value of its axes, and of those of its default parts, by itself.
    fn varied(
        method: &str,
        registry: &Registry,
        library: &Library,
    ) -> Result<Vec<Self>, StudyError> {
        let plain = Self::plain(method, "default");
        let choice = plain.shadow().choice(registry, library)?;
        let mut configs = vec![plain];
        for name in choice.axes() {
            let Some(axis) = library.axes().get(name) else {
                continue;
            };
            for value in axis
                .values()
                .filter(|v| Some(*v) != axis.default.as_deref())
            {
                configs.push(Self {
                    axes: BTreeMap::from([(name.to_owned(), value.to_owned())]),
                    ..Self::plain(method, &format!("{name} {value}"))
                });
            }
        }
        Ok(configs)
    }

    /// The method's name and the configuration's, for a person.
    pub(super) fn label(&self) -> String {
        format!("{} ({})", self.method, self.name)
    }

    /// What a renderer is to be told.
    pub(crate) fn options(&self, (width, height): (u32, u32)) -> RenderOptions {
        RenderOptions {
            width,
            height,
            method: Some(self.method.clone()),
            axes: self.axes.clone(),
            settings: self.settings.clone(),
            path: self.path,
            // What a method costs where all that casts moves.
            fresh: true,
            ..RenderOptions::default()
        }
    }

    /// How it has each light's shadow found.
    pub fn shadow(&self) -> Shadow {
        Shadow {
            method: self.method.clone(),
            axes: self.axes.clone(),
            settings: self.settings.clone(),
        }
    }

    fn check(&self, registry: &Registry, library: &Library) -> Result<(), String> {
        let checked = self.shadow().check(registry, library);
        checked.map_err(|error| error.to_string()).map(drop)
    }
}
