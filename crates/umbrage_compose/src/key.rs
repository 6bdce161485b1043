//! Keys: a value for each axis, in one spelling.

use std::{collections::BTreeMap, fmt};

use serde::{Deserialize, Serialize};

/// A value for each axis that is not at its default, sorted by axis. Made by
/// [`Library::key`](crate::Library::key), which knows the axes.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Key(pub(crate) BTreeMap<String, String>);

impl Key {
    /// The value of `axis`, where it is not the default.
    pub fn get(&self, axis: &str) -> Option<&str> {
        self.0.get(axis).map(String::as_str)
    }

    /// The axes that are not at their default, with their values.
    pub fn choices(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0
            .iter()
            .map(|(axis, value)| (axis.as_str(), value.as_str()))
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (axis, value)) in self.choices().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            write!(f, "{comma}{axis}={value}")?;
        }
        Ok(())
    }
}
