//! Figures by their names, as a table of limits has them.

use std::{fmt, sync::LazyLock};

use serde::{Deserialize, Deserializer, de::Error as _};
use serde_json::Value;
use umbrage_hints::did_you_mean;

use crate::figures::Figures;

/// The figure beside those of [`Figures`]: the share of samples that are lit here and in shadow in the
/// picture of the case that this one must look the same as, or the reverse.
pub const DIFFERS: &str = "differs";

/// Figures that no variant may be excepted from.
const NEVER_EXCEPTED: [&str; 2] = ["bad_pixels", "compared"];

/// The name of a figure that there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Figure(pub(super) &'static str);

/// A figure that a variant may be excepted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Excepted(pub(super) Figure);

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl fmt::Display for Excepted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<'de> Deserialize<'de> for Figure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        known(
            "figure",
            &String::deserialize(deserializer)?,
            figure_names(),
        )
        .map(Self)
    }
}

impl<'de> Deserialize<'de> for Excepted {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let figure = Figure::deserialize(deserializer)?;
        if NEVER_EXCEPTED.contains(&figure.0) {
            let message = format!(
                "no method is excepted from the limit of `{}`; mend the method",
                figure.0
            );
            return Err(D::Error::custom(message));
        }
        Ok(Self(figure))
    }
}

/// The figures' numbers by their names.
pub(super) struct Values {
    figures: Value,
    differs: Option<f64>,
}

impl Values {
    pub(super) fn new(figures: &Figures, differs: Option<f64>) -> Self {
        Self {
            figures: as_json(figures),
            differs,
        }
    }

    /// None for what is missing, not a number or infinite.
    pub(super) fn get(&self, name: &str) -> Option<f64> {
        if name == DIFFERS {
            return self.differs.filter(|differs| differs.is_finite());
        }
        self.figures.get(name).and_then(Value::as_f64)
    }
}

fn as_json(figures: &Figures) -> Value {
    // Plain numbers have no way to fail; without any, every limit would be missed.
    serde_json::to_value(figures).unwrap_or_default()
}

/// The names of all figures, by the alphabet, and whether a picture may have none.
static FIGURES: LazyLock<Vec<(&'static str, bool)>> = LazyLock::new(|| {
    let figures = as_json(&Figures::default());
    let figures = figures.as_object().into_iter().flatten();
    // Made once, and so few that they are kept for good.
    let named = figures.map(|(name, value)| (&*name.clone().leak(), value.is_null()));
    named.chain([(DIFFERS, true)]).collect()
});

/// The names of all figures.
fn figure_names() -> &'static [&'static str] {
    static NAMES: LazyLock<Vec<&'static str>> =
        LazyLock::new(|| FIGURES.iter().map(|(name, _)| *name).collect());
    &NAMES
}

/// Whether a picture may lack the figure.
pub(super) fn is_optional(name: &str) -> bool {
    FIGURES
        .iter()
        .any(|(known, optional)| *known == name && *optional)
}

/// The name as `known` has it.
pub(super) fn known<E: serde::de::Error>(
    what: &str,
    name: &str,
    known: &[&'static str],
) -> Result<&'static str, E> {
    let found = known.iter().find(|known| **known == name).copied();
    found.ok_or_else(|| E::custom(unknown(what, name, known.iter().copied())))
}

/// Message that there is no such name, and which was meant or may be.
pub(super) fn unknown<'a>(
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> String {
    let hint = match did_you_mean(name, known.clone()) {
        Some(question) => format!("; {question}"),
        None => format!(" (known: {})", known.collect::<Vec<_>>().join(", ")),
    };
    format!("there is no {what} `{name}`{hint}")
}
