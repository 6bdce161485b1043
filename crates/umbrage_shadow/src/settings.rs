//! A method's numbers that a scene may set.

use std::collections::BTreeMap;

use umbrage_hints::ending;

use crate::plain_number;

/// A number that a method lets a scene choose.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Its name in scene files, snake_case.
    pub name: &'static str,
    /// Its meaning and unit.
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
    #[error("no setting `{name}` (known: {known}){hint}")]
    Unknown {
        /// As written.
        name: String,
        /// All names.
        known: String,
        /// The end of the message: which name may be meant.
        hint: String,
    },
    /// Out of range, or not whole.
    #[error(
        "`{name}` is {}, but must be {what} from {} to {}",
        plain_number(*.value),
        plain_number(*.min),
        plain_number(*.max)
    )]
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
                return Err(SettingsError::Unknown {
                    name: name.to_owned(),
                    known: names.join(", "),
                    hint: ending(name, names),
                });
            };
            let whole = !setting.whole || value.fract() == 0.0;
            if !(value >= setting.min && value <= setting.max && whole) {
                return Err(SettingsError::Value {
                    name: setting.name,
                    value,
                    what: if setting.whole {
                        "a whole number"
                    } else {
                        "a number"
                    },
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

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: [Setting; 1] = [Setting {
        name: "resolution",
        doc: "texels",
        min: 1.0,
        max: 64.0,
        default: 8.0,
        whole: true,
    }];

    fn check(name: &str, value: f64) -> Result<f64, String> {
        let settings = Settings::check(&KNOWN, [(name, value)]).map_err(|e| e.to_string())?;
        Ok(settings.get("resolution"))
    }

    #[test]
    fn what_is_chosen_is_checked() {
        assert_eq!(
            Settings::check(&KNOWN, []).map(|s| s.get("resolution")),
            Ok(8.0)
        );
        assert_eq!(check("resolution", 64.0), Ok(64.0));
        let range = "must be a whole number from 1 to 64";
        for value in [0.0, 65.0, 2.5, f64::NAN] {
            assert_eq!(
                check("resolution", value),
                Err(format!("`resolution` is {value}, but {range}"))
            );
        }
        assert_eq!(
            check("resolutoin", 4.0),
            Err("no setting `resolutoin` (known: resolution); did you mean `resolution`?".into())
        );
    }
}
