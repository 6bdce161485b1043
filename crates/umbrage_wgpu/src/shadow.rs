//! How a light's shadow is found, as scenes, configurations and options choose it.

use std::{collections::BTreeMap, sync::Arc};

use umbrage_compose::Library;
use umbrage_hints::ending;
use umbrage_shadow::{
    Aabb, Answers, Casters, Choice, Frame, Light, Registry, RegistryError, Settings, SettingsError,
    ShadowMethod, View,
};

/// A shadow method and what is chosen for it, the depth source and the filter among its axes; [checked](Self::check) when
/// rendered, as scenes do not know which parts there are.
#[derive(Clone, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shadow {
    /// The method's name.
    pub method: String,
    /// Values of the shader library's axes that belong to the method, its depth source or its filter; the rest have their
    /// defaults.
    #[serde(default)]
    pub axes: BTreeMap<String, String>,
    /// Values of these parts' settings; the rest have their defaults.
    #[serde(default)]
    pub settings: BTreeMap<String, f64>,
}

/// A [`Shadow`] of which all is known.
#[derive(Clone)]
pub struct CheckedShadow {
    /// The parts.
    pub choice: Choice,
    /// A value for each of the parts' axes.
    pub axes: BTreeMap<String, String>,
    /// A value for each of the parts' settings.
    pub settings: Settings,
}

impl CheckedShadow {
    /// The method.
    pub fn method(&self) -> &dyn ShadowMethod {
        &*self.choice.method
    }

    /// Values of axes of the shader library for shaders that read this shadow of `light`.
    pub fn choices(&self, light: &Light) -> impl Iterator<Item = (&str, &str)> {
        let axes = self.axes.iter().map(|(a, v)| (a.as_str(), v.as_str()));
        let own = [
            ("light", light.kind.name()),
            ("method", self.method().name()),
        ];
        axes.chain(own)
    }

    /// Whether it is the same parts, not only of the same names, with the same values.
    pub(crate) fn is(&self, other: &Self) -> bool {
        fn same<P: ?Sized>(a: &Option<Arc<P>>, b: &Option<Arc<P>>) -> bool {
            match (a, b) {
                (Some(a), Some(b)) => Arc::ptr_eq(a, b),
                (a, b) => a.is_none() && b.is_none(),
            }
        }
        let (own, others) = (&self.choice, &other.choice);
        Arc::ptr_eq(&own.method, &others.method)
            && same(&own.depth, &others.depth)
            && same(&own.filter, &others.filter)
            && self.axes == other.axes
            && self.settings == other.settings
    }

    /// The frame that the parts plan for, without a camera's depth and answers.
    pub fn frame<'f>(
        &'f self,
        view: &'f View,
        light: &'f Light,
        casters: &'f [Aabb],
        receivers: &'f [Aabb],
    ) -> Frame<'f> {
        Frame {
            view,
            light,
            casters: Casters {
                casters,
                receivers,
                air: None,
            },
            settings: &self.settings,
            axes: &self.axes,
            depth: self.choice.depth.as_deref(),
            filter: self.choice.filter.as_deref(),
            camera_depth: None,
            answers: Answers::none(),
        }
    }
}

/// A part, an axis, a value or a setting that there is not, or parts that do not go together.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowError {
    /// No such part, or parts that do not go together.
    #[error(transparent)]
    Part(#[from] RegistryError),
    /// The method has no such axis.
    #[error("method `{method}` has no axis `{axis}` (known: {known}){hint}")]
    Axis {
        /// The method.
        method: String,
        /// The axis.
        axis: String,
        /// The method's axes.
        known: String,
        /// The question for a name that may have been meant.
        hint: String,
    },
    /// The axis has no such value.
    #[error("axis `{axis}` has no value `{value}` (known: {known}){hint}")]
    Value {
        /// The axis.
        axis: String,
        /// The value.
        value: String,
        /// The axis's values.
        known: String,
        /// The question for a name that may have been meant.
        hint: String,
    },
    /// Settings that the method refuses.
    #[error("method `{method}`: {source}")]
    Settings {
        /// The method.
        method: String,
        /// Why.
        source: SettingsError,
    },
}

impl Shadow {
    /// The method of lights that cast no shadows.
    pub const NONE: &str = "none";

    /// A method, and defaults for all else.
    pub fn new(method: &str) -> Self {
        Self {
            method: method.to_owned(),
            ..Self::default()
        }
    }

    /// The same with another value of an axis.
    pub fn with(mut self, axis: &str, value: &str) -> Self {
        self.axes.insert(axis.to_owned(), value.to_owned());
        self
    }

    /// The same with another value of a setting.
    pub fn with_setting(mut self, name: &str, value: f64) -> Self {
        self.settings.insert(name.to_owned(), value);
        self
    }

    /// This put over a light's `own`: its method takes the place of the light's, and an empty one keeps it; its values of
    /// axes and settings take the place of the light's for the same method, as far as the parts then chosen have them. None
    /// where no shadow is cast.
    ///
    /// # Errors
    /// As [`Self::check`]: for the light's own choices by themselves as well, as these hold without this.
    pub fn over(
        &self,
        own: Option<&Self>,
        registry: &Registry,
        library: &Library,
    ) -> Result<Option<CheckedShadow>, ShadowError> {
        let mut all = match (self.method.as_str(), own) {
            ("", None) | (Self::NONE, _) => return Ok(None),
            ("", Some(own)) => own.clone(),
            // Choices for one method mean nothing to another.
            (method, own) => own
                .filter(|own| own.method == method)
                .map_or_else(|| Self::new(method), Self::clone),
        };
        if all.method == Self::NONE {
            return Ok(None);
        }
        all.check(registry, library)?;
        for axis in [Choice::DEPTH, Choice::FILTER] {
            if let Some(value) = self.axes.get(axis) {
                all.axes.insert(axis.to_owned(), value.clone());
            }
        }
        // A light's choices for one part may mean nothing to another.
        let choice = all.choice(registry, library)?;
        let (axes, settings) = (choice.axes(), choice.settings());
        let has_axis = |axis: &str| axes.contains(&axis);
        let has_setting = |name: &str| settings.iter().any(|setting| setting.name == name);
        all.axes.retain(|axis, _| has_axis(axis));
        all.settings.retain(|name, _| has_setting(name));
        let chosen = self.axes.iter().filter(|(axis, _)| has_axis(axis));
        all.axes.extend(chosen.map(|(a, v)| (a.clone(), v.clone())));
        let chosen = self.settings.iter().map(|(n, v)| (n.clone(), *v));
        all.settings.extend(chosen);
        all.check(registry, library).map(Some)
    }

    /// The parts that are chosen, with defaults for what is not.
    ///
    /// # Errors
    /// A part that is not registered; an axis that none of the parts has, a value that the axis has not in `library`;
    /// settings that the parts refuse.
    pub fn check(
        &self,
        registry: &Registry,
        library: &Library,
    ) -> Result<CheckedShadow, ShadowError> {
        let choice = self.choice(registry, library)?;
        let known = choice.axes();
        let has = |axis: &&String| known.contains(&axis.as_str());
        if let Some(axis) = self.axes.keys().find(|axis| !has(axis)) {
            return Err(ShadowError::Axis {
                method: self.method.clone(),
                axis: axis.clone(),
                known: known.join(", "),
                hint: ending(axis, known.iter().copied()),
            });
        }
        let mut axes = BTreeMap::new();
        for axis in known {
            let value = self.value(library, axis).unwrap_or("");
            check_value(library, axis, value)?;
            axes.insert(axis.to_owned(), value.to_owned());
        }
        let chosen = self.settings.iter().map(|(name, v)| (name.as_str(), *v));
        let settings = Settings::check(&choice.settings(), chosen).map_err(|source| {
            let method = self.method.clone();
            ShadowError::Settings { method, source }
        })?;
        Ok(CheckedShadow {
            choice,
            axes,
            settings,
        })
    }

    /// The parts that are chosen.
    ///
    /// # Errors
    /// A part that is not registered, or that `library` does not have; parts that do not go together.
    pub fn choice(&self, registry: &Registry, library: &Library) -> Result<Choice, ShadowError> {
        for axis in [Choice::DEPTH, Choice::FILTER] {
            if let Some(value) = self.axes.get(axis) {
                check_value(library, axis, value)?;
            }
        }
        Ok(registry.choose(&self.method, |axis| self.value(library, axis))?)
    }

    /// The value of an axis: what is chosen, or its default.
    fn value<'a>(&'a self, library: &'a Library, axis: &str) -> Option<&'a str> {
        let chosen = self.axes.get(axis).map(String::as_str);
        chosen.or_else(|| library.axes().get(axis)?.default.as_deref())
    }
}

/// Checks that `axis` has `value` in `library`.
///
/// # Errors
/// It has not.
pub fn check_value(library: &Library, axis: &str, value: &str) -> Result<(), ShadowError> {
    let found = library.axes().get(axis);
    let values: Vec<_> = found.iter().flat_map(|axis| axis.values()).collect();
    if values.contains(&value) {
        return Ok(());
    }
    Err(ShadowError::Value {
        axis: axis.to_owned(),
        value: value.to_owned(),
        known: values.join(", "),
        hint: ending(value, values.iter().copied()),
    })
}
