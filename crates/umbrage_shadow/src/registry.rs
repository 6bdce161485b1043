//! The parts that a renderer knows.

use std::{collections::BTreeMap, fmt, sync::Arc};

use umbrage_hints::ending;

use crate::{DepthSource, Filter, Part, Setting, ShadowMethod};

/// The parts that make shadows, each kind by its names: where parts and the renderer meet, neither seeing the other.
///
/// ```
/// # use umbrage_shadow::*;
/// struct Nothing;
///
/// impl Part for Nothing {
///     fn name(&self) -> &str {
///         "nothing"
///     }
/// }
///
/// impl Filter for Nothing {
///     fn reach(&self, _: &Frame<'_>, _: usize) -> Result<f64, PlanError> {
///         Ok(0.0)
///     }
///     fn fetches(&self, _: &Frame<'_>, _: usize) -> Result<u32, PlanError> {
///         Ok(0)
///     }
/// }
///
/// let mut registry = Registry::new();
/// registry.filters.add(Nothing)?;
/// assert_eq!(registry.filters.get("nothing")?.name(), "nothing");
/// # Ok::<(), RegistryError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Registry {
    /// Shadow methods.
    pub methods: Parts<dyn ShadowMethod>,
    /// Depth sources.
    pub depths: Parts<dyn DepthSource>,
    /// Filters.
    pub filters: Parts<dyn Filter>,
}

/// Parts of one kind by their names.
pub struct Parts<P: ?Sized> {
    /// In words.
    kind: &'static str,
    by_name: BTreeMap<String, Arc<P>>,
}

/// The parts that were chosen for one light's shadow.
#[derive(Clone)]
pub struct Choice {
    /// The method.
    pub method: Arc<dyn ShadowMethod>,
    /// The source of its maps' depths, where it lets that be chosen.
    pub depth: Option<Arc<dyn DepthSource>>,
    /// The filter of its maps, where it lets that be chosen.
    pub filter: Option<Arc<dyn Filter>>,
}

/// Why a registry refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RegistryError {
    /// Two parts of one kind have one name.
    #[error("a {kind} `{name}` is already registered")]
    Taken {
        /// The kind of part.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// No part of this kind has this name.
    #[error("no {kind} `{name}` (known: {known}){hint}")]
    Unknown {
        /// The kind of part.
        kind: &'static str,
        /// As asked for.
        name: String,
        /// All names.
        known: String,
        /// The end of the message: which name may be meant.
        hint: String,
    },
    /// Two parts that go together have different settings of one name.
    #[error(
        "`{first}` and `{second}` have different settings called `{name}`: one of them must have another name"
    )]
    Setting {
        /// The setting.
        name: &'static str,
        /// A part.
        first: String,
        /// The other.
        second: String,
    },
}

impl Registry {
    /// A registry without parts.
    pub fn new() -> Self {
        Self {
            methods: Parts::new("shadow method"),
            depths: Parts::new("depth source"),
            filters: Parts::new("filter"),
        }
    }

    /// The method of this name, and the depth source and filter that `value` gives for the axes `depth` and `filter`, as far
    /// as the method has them.
    ///
    /// # Errors
    /// A part that is not registered; parts with different settings of one name.
    pub fn choose<'v>(
        &self,
        method: &str,
        value: impl Fn(&str) -> Option<&'v str>,
    ) -> Result<Choice, RegistryError> {
        let method = self.methods.shared(method)?;
        let of = |axis| {
            let has = method.axes().contains(&axis);
            has.then(|| value(axis).unwrap_or(""))
        };
        let depth = of(Choice::DEPTH).map(|name| self.depths.shared(name));
        let filter = of(Choice::FILTER).map(|name| self.filters.shared(name));
        let choice = Choice {
            method,
            depth: depth.transpose()?,
            filter: filter.transpose()?,
        };
        choice.check()?;
        Ok(choice)
    }
}

impl Default for Registry {
    fn default() -> Self {
        Self::new()
    }
}

impl Choice {
    /// The axis of depth sources.
    pub const DEPTH: &'static str = "depth";

    /// The axis of filters.
    pub const FILTER: &'static str = "filter";

    /// The parts, the method first.
    pub fn parts(&self) -> impl Iterator<Item = &dyn Part> {
        let depth = self.depth.as_deref().map(|depth| depth as &dyn Part);
        let filter = self.filter.as_deref().map(|filter| filter as &dyn Part);
        [Some(&*self.method as &dyn Part), depth, filter]
            .into_iter()
            .flatten()
    }

    /// All axes of the parts, sorted.
    pub fn axes(&self) -> Vec<&str> {
        let mut axes: Vec<_> = self.parts().flat_map(Part::axes).copied().collect();
        axes.sort_unstable();
        axes.dedup();
        axes
    }

    /// All settings of the parts, the method's first.
    pub fn settings(&self) -> Vec<Setting> {
        let mut settings = Vec::<Setting>::new();
        for setting in self.parts().flat_map(Part::settings) {
            if !settings.contains(setting) {
                settings.push(setting.clone());
            }
        }
        settings
    }

    fn check(&self) -> Result<(), RegistryError> {
        let mut known = Vec::<(&dyn Part, &Setting)>::new();
        for part in self.parts() {
            for setting in part.settings() {
                let same = |(_, other): &&(_, &Setting)| other.name == setting.name;
                match known.iter().find(same) {
                    Some((first, other)) if *other != setting => {
                        return Err(RegistryError::Setting {
                            name: setting.name,
                            first: first.name().to_owned(),
                            second: part.name().to_owned(),
                        });
                    }
                    Some(_) => {}
                    None => known.push((part, setting)),
                }
            }
        }
        Ok(())
    }
}

impl<P: ?Sized + Part> Parts<P> {
    fn new(kind: &'static str) -> Self {
        Self {
            kind,
            by_name: BTreeMap::new(),
        }
    }

    fn insert(&mut self, part: Arc<P>) -> Result<(), RegistryError> {
        let name = part.name().to_owned();
        if self.by_name.contains_key(&name) {
            let kind = self.kind;
            return Err(RegistryError::Taken { kind, name });
        }
        self.by_name.insert(name, part);
        Ok(())
    }

    /// The part `name`.
    ///
    /// # Errors
    /// [`RegistryError::Unknown`].
    pub fn get(&self, name: &str) -> Result<&P, RegistryError> {
        self.entry(name).map(Arc::as_ref)
    }

    fn shared(&self, name: &str) -> Result<Arc<P>, RegistryError> {
        self.entry(name).cloned()
    }

    fn entry(&self, name: &str) -> Result<&Arc<P>, RegistryError> {
        let found = self.by_name.get(name);
        found.ok_or_else(|| RegistryError::Unknown {
            kind: self.kind,
            name: name.to_owned(),
            known: self.names().collect::<Vec<_>>().join(", "),
            hint: ending(name, self.names()),
        })
    }

    /// The parts' names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().map(String::as_str)
    }

    /// The parts, sorted by name.
    pub fn iter(&self) -> impl Iterator<Item = &P> {
        self.by_name.values().map(Arc::as_ref)
    }
}

macro_rules! add {
    ($($kind:ident),*) => {$(
        impl Parts<dyn $kind> {
            /// Adds `part` under its own name.
            ///
            /// # Errors
            /// [`RegistryError::Taken`]; what was there stays.
            pub fn add(&mut self, part: impl $kind + 'static) -> Result<(), RegistryError> {
                self.insert(Arc::new(part))
            }
        }
    )*};
}

add!(ShadowMethod, DepthSource, Filter);

impl<P: ?Sized> Clone for Parts<P> {
    fn clone(&self) -> Self {
        Self {
            kind: self.kind,
            by_name: self.by_name.clone(),
        }
    }
}

impl<P: ?Sized> fmt::Debug for Parts<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.by_name.keys()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frame, Light, PlanError, ShadowPlan, Support};

    struct Named {
        name: &'static str,
        settings: Vec<Setting>,
    }

    impl Part for Named {
        fn name(&self) -> &str {
            self.name
        }
        fn settings(&self) -> &[Setting] {
            &self.settings
        }
        fn axes(&self) -> &[&str] {
            &["depth", "filter", "zeal"]
        }
    }

    impl ShadowMethod for Named {
        fn supports(&self, _: &Light) -> Support {
            Support::Yes
        }
        fn plan(&self, _: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
            Ok(ShadowPlan::default())
        }
    }

    impl DepthSource for Named {
        fn fill(
            &self,
            _: &Frame<'_>,
            _: &crate::Maps,
            _: &mut ShadowPlan,
        ) -> Result<(), PlanError> {
            Ok(())
        }
    }

    impl Filter for Named {
        fn reach(&self, _: &Frame<'_>, _: usize) -> Result<f64, PlanError> {
            Ok(0.5)
        }
        fn fetches(&self, _: &Frame<'_>, _: usize) -> Result<u32, PlanError> {
            Ok(1)
        }
    }

    fn named(name: &'static str, settings: &[(&'static str, f64)]) -> Named {
        let setting = |&(name, max): &(&'static str, f64)| Setting {
            name,
            doc: "a number",
            min: 0.0,
            max,
            default: 0.0,
            whole: false,
        };
        Named {
            name,
            settings: settings.iter().map(setting).collect(),
        }
    }

    #[test]
    fn names_are_unique_sorted_and_suggested() {
        let mut methods = Registry::new().methods;
        assert_eq!(methods.add(named("variance", &[])), Ok(()));
        assert_eq!(methods.add(named("basic", &[])), Ok(()));
        assert_eq!(
            methods.add(named("basic", &[])).map_err(|e| e.to_string()),
            Err("a shadow method `basic` is already registered".into())
        );
        let names: Vec<_> = methods.iter().map(|m| m.name()).collect();
        assert_eq!(names, ["basic", "variance"]);
        assert_eq!(methods.get("basic").map(|m| m.name()), Ok("basic"));
        assert_eq!(
            methods.get("basics").map(|_| ()).map_err(|e| e.to_string()),
            Err("no shadow method `basics` (known: basic, variance); did you mean `basic`?".into())
        );
    }

    #[test]
    fn what_is_chosen_has_all_axes_and_settings_of_its_parts() -> Result<(), RegistryError> {
        let mut registry = Registry::new();
        registry
            .methods
            .add(named("fit", &[("size", 9.0), ("bias", 1.0)]))?;
        registry.depths.add(named("near", &[("bias", 1.0)]))?;
        registry.filters.add(named("soft", &[("blur", 3.0)]))?;
        registry.filters.add(named("odd", &[("size", 8.0)]))?;
        let choose = |filter| {
            registry.choose("fit", |axis| match axis {
                "depth" => Some("near"),
                _ => filter,
            })
        };
        let choice = choose(Some("soft"))?;
        assert_eq!(choice.axes(), ["depth", "filter", "zeal"]);
        let settings: Vec<_> = choice.settings().iter().map(|s| s.name).collect();
        assert_eq!(settings, ["size", "bias", "blur"]);
        let refused = |filter| choose(filter).map(|_| ()).map_err(|e| e.to_string());
        assert_eq!(
            refused(Some("odd")),
            Err("`fit` and `odd` have different settings called `size`: one of them must have another name".into())
        );
        assert_eq!(
            refused(Some("sift")),
            Err("no filter `sift` (known: odd, soft); did you mean `soft`?".into())
        );
        assert!(refused(None).is_err());
        Ok(())
    }
}
