//! How a light's shadow is found, as scenes, configurations and options choose it.

use std::collections::BTreeMap;

use umbrage_compose::Library;
use umbrage_hints::ending;
use umbrage_shadow::{Registry, RegistryError, Settings, SettingsError, ShadowMethod};

/// A shadow method and what is chosen for it; [checked](Self::check) when rendered, as scenes do not know which methods
/// there are.
#[derive(Clone, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shadow {
    /// The method's name.
    pub method: String,
    /// Values of the shader library's axes that belong to the method; the rest have their defaults.
    #[serde(default)]
    pub axes: BTreeMap<String, String>,
    /// The method's numbers; the rest have their defaults.
    #[serde(default)]
    pub settings: BTreeMap<String, f64>,
}

/// A [`Shadow`] of which all is known.
pub struct CheckedShadow<'a> {
    /// The method.
    pub method: &'a dyn ShadowMethod,
    /// A value for each of the method's axes.
    pub axes: BTreeMap<String, String>,
    /// A value for each of the method's settings.
    pub settings: Settings,
}

/// A method, an axis, a value or a setting that there is not.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowError {
    /// No such method.
    #[error(transparent)]
    Method(#[from] RegistryError),
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

    /// The method that is chosen, with defaults for what is not.
    ///
    /// # Errors
    /// A method that is not registered; an axis that it has not, a value that the axis has not in `library`; settings that
    /// the method refuses.
    pub fn check<'a>(
        &self,
        registry: &'a Registry,
        library: &Library,
    ) -> Result<CheckedShadow<'a>, ShadowError> {
        let method = registry.get(&self.method)?;
        let has = |axis: &&String| method.axes().contains(&axis.as_str());
        if let Some(axis) = self.axes.keys().find(|axis| !has(axis)) {
            return Err(ShadowError::Axis {
                method: self.method.clone(),
                axis: axis.clone(),
                known: method.axes().join(", "),
                hint: ending(axis, method.axes().iter().copied()),
            });
        }
        let mut axes = BTreeMap::new();
        for &axis in method.axes() {
            let default = || library.axes().get(axis)?.default.clone();
            let value = self.axes.get(axis).cloned().or_else(default);
            let value = value.unwrap_or_default();
            check_value(library, axis, &value)?;
            axes.insert(axis.to_owned(), value);
        }
        let chosen = self.settings.iter().map(|(name, v)| (name.as_str(), *v));
        let settings = Settings::check(method.settings(), chosen).map_err(|source| {
            let method = self.method.clone();
            ShadowError::Settings { method, source }
        })?;
        Ok(CheckedShadow {
            method: method.as_ref(),
            axes,
            settings,
        })
    }
}

/// Checks that `axis` has `value` in `library`.
pub(crate) fn check_value(library: &Library, axis: &str, value: &str) -> Result<(), ShadowError> {
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
