//! Keys: a value for each axis, in one spelling.

use std::{fmt, ops::Deref, sync::Arc};

use serde::{Serialize, Serializer};

/// A value for each axis that is not at its default, sorted by axis. Made by
/// [`Library::key`](crate::Library::key), which knows the axes. Cheap to clone.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(Arc<[Choice]>);

/// An axis and its value. Keys of one library share the texts.
pub(crate) type Choice = (Arc<str>, Arc<str>);

impl Key {
    /// The key of `choices`, sorted by axis, each axis once.
    pub(crate) fn new(choices: impl IntoIterator<Item = Choice>) -> Self {
        Self(choices.into_iter().collect())
    }

    /// The value of `axis`, where it is not the default.
    pub fn get(&self, axis: &str) -> Option<&str> {
        let found = self.0.binary_search_by(|(known, _)| (**known).cmp(axis));
        found.ok().map(|index| &*self.0[index].1)
    }

    /// The axes that are not at their default, with their values.
    pub fn choices(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(axis, value)| (&**axis, &**value))
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

impl Serialize for Key {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.choices())
    }
}

/// The key that names a permutation: of all keys that make it, the one with defaults as far as they are legal. Made by
/// [`Composer::project`](crate::Composer::project). It is a key like others, and makes the permutation that it names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct ProjectedKey(Key);

impl ProjectedKey {
    /// Calls `key` its own projection.
    pub(crate) fn of(key: Key) -> Self {
        Self(key)
    }
}

impl Deref for ProjectedKey {
    type Target = Key;

    fn deref(&self) -> &Key {
        &self.0
    }
}

impl fmt::Display for ProjectedKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl From<ProjectedKey> for Key {
    fn from(projected: ProjectedKey) -> Self {
        projected.0
    }
}
