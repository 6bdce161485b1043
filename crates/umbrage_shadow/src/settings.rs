//! A method's numbers that a scene may set.

use std::collections::BTreeMap;

/// A number that a method lets a scene choose.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Its name in scene files, snake_case.
    pub name: &'static str,
    /// What it is, and its unit.
    pub doc: &'static str,
    /// The least value allowed.
    pub min: f64,
    /// The greatest value allowed.
    pub max: f64,
    /// The value where a scene says nothing.
    pub default: f64,
    /// Whether only whole numbers will do.
    pub whole: bool,
}

/// The values of a method's settings: one for each, checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings(BTreeMap<&'static str, f64>);

/// Why settings were refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// No such setting.
    #[error("no setting `{name}` (known: {known}){}", .nearest.as_ref().map(|n| format!("; did you mean `{n}`?")).unwrap_or_default())]
    Unknown {
        /// As written.
        name: String,
        /// All names.
        known: String,
        /// The nearest name.
        nearest: Option<String>,
    },
    /// Out of range, or not whole.
    #[error("`{name}` is {value}, but must be {what} from {min} to {max}")]
    Value {
        /// The setting.
        name: &'static str,
        /// As written.
        value: f64,
        /// A number, or a whole number.
        what: &'static str,
        /// The least value.
        min: f64,
        /// The greatest value.
        max: f64,
    },
}

impl Settings {
    /// Checks `chosen` against `known`; what is not chosen has its default.
    ///
    /// # Errors
    /// An unknown name, a value out of range, or a fraction where a whole number is asked for.
    pub fn check<'a>(
        known: &[Setting],
        chosen: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Result<Self, SettingsError> {
        let mut values: BTreeMap<_, _> = known.iter().map(|s| (s.name, s.default)).collect();
        for (name, value) in chosen {
            let Some(setting) = known.iter().find(|s| s.name == name) else {
                let names: Vec<_> = known.iter().map(|s| s.name).collect();
                let nearest = names
                    .iter()
                    .map(|known| (strsim::jaro_winkler(name, known), known))
                    .filter(|(score, _)| *score > 0.8)
                    .max_by(|a, b| a.0.total_cmp(&b.0))
                    .map(|(_, known)| (*known).to_owned());
                return Err(SettingsError::Unknown {
                    name: name.to_owned(),
                    known: names.join(", "),
                    nearest,
                });
            };
            let whole = !setting.whole || value.fract() == 0.0;
            if !(value >= setting.min && value <= setting.max && whole) {
                return Err(SettingsError::Value {
                    name: setting.name,
                    value,
                    what: if setting.whole { "a whole number" } else { "a number" },
                    min: setting.min,
                    max: setting.max,
                });
            }
            values.insert(setting.name, value);
        }
        Ok(Self(values))
    }

    /// The value of `name`; NaN where the method has no such setting.
    pub fn get(&self, name: &str) -> f64 {
        self.0.get(name).copied().unwrap_or(f64::NAN)
    }
}
