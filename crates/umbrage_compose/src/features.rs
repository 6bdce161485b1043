//! Feature flags, and what was asked of them.

use std::{
    cell::RefCell,
    collections::{BTreeSet, HashMap},
};

use crate::{Cause, Fault, error::nearest};

/// The features that a library knows, each with a number.
#[derive(Clone, Debug, Default)]
pub(crate) struct FeatureNames(HashMap<String, usize>);

impl FeatureNames {
    pub(crate) fn new<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let names: BTreeSet<_> = names.into_iter().collect();
        Self(
            names
                .into_iter()
                .enumerate()
                .map(|(index, name)| (name.to_owned(), index))
                .collect(),
        )
    }

    pub(crate) fn number(&self, name: &str) -> Option<usize> {
        self.0.get(name).copied()
    }

    /// The set of those of `names` that are known.
    pub(crate) fn set(&self, names: &[String]) -> FeatureSet {
        let mut set = FeatureSet::default();
        for number in names.iter().filter_map(|name| self.number(name)) {
            set.insert(number);
        }
        set
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, usize)> {
        self.0.iter().map(|(name, number)| (name.as_str(), *number))
    }
}

/// A set of features by their numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct FeatureSet(Vec<u64>);

impl FeatureSet {
    pub(crate) fn insert(&mut self, number: usize) {
        let word = number / 64;
        if self.0.len() <= word {
            self.0.resize(word + 1, 0);
        }
        self.0[word] |= 1 << (number % 64);
    }

    pub(crate) fn contains(&self, number: usize) -> bool {
        self.word(number / 64) >> (number % 64) & 1 == 1
    }

    /// Whether this set and `other` have the same members among those of `mask`.
    pub(crate) fn same_among(&self, other: &Self, mask: &Self) -> bool {
        let words = mask.0.iter().enumerate();
        words
            .into_iter()
            .all(|(i, mask)| (self.word(i) ^ other.word(i)) & mask == 0)
    }

    pub(crate) fn intersect(&mut self, other: &Self) {
        self.0.truncate(other.0.len());
        self.0
            .iter_mut()
            .zip(&other.0)
            .for_each(|(word, other)| *word &= other);
        self.trim();
    }

    pub(crate) fn remove_all(&mut self, other: &Self) {
        self.0
            .iter_mut()
            .zip(&other.0)
            .for_each(|(word, other)| *word &= !other);
        self.trim();
    }

    /// Drops empty words at the end, so that equal sets are equal values.
    fn trim(&mut self) {
        while self.0.last() == Some(&0) {
            self.0.pop();
        }
    }

    /// Whether all members of `other` are members of this set.
    pub(crate) fn has_all(&self, other: &Self) -> bool {
        let words = other.0.iter().enumerate();
        words.into_iter().all(|(i, word)| word & !self.word(i) == 0)
    }

    fn word(&self, index: usize) -> u64 {
        self.0.get(index).copied().unwrap_or(0)
    }

    pub(crate) fn union(&mut self, other: &Self) {
        if self.0.len() < other.0.len() {
            self.0.resize(other.0.len(), 0);
        }
        // No set ends in an empty word, so neither does a union.
        for (word, other) in self.0.iter_mut().zip(&other.0) {
            *word |= other;
        }
    }
}

/// The features that were asked for, and which of them were found enabled: two sets of features that
/// agree on these give the same answers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Consulted {
    pub(crate) asked: FeatureSet,
    pub(crate) found: FeatureSet,
}

impl Consulted {
    /// Whether `enabled` gives the same answers.
    pub(crate) fn agrees(&self, enabled: &FeatureSet) -> bool {
        let words = self.asked.0.len();
        (0..words)
            .all(|index| enabled.word(index) & self.asked.word(index) == self.found.word(index))
    }

    pub(crate) fn union(&mut self, other: &Self) {
        self.asked.union(&other.asked);
        self.found.union(&other.found);
    }
}

/// The enabled features among the known ones.
#[derive(Clone, Copy)]
pub(crate) struct Features<'a> {
    pub(crate) names: &'a FeatureNames,
    pub(crate) enabled: &'a FeatureSet,
    /// Features that were asked for, in the order of the first questions. Which question comes next depends on the
    /// answers before it alone.
    pub(crate) asked: &'a RefCell<Vec<usize>>,
}

impl Features<'_> {
    /// Whether the feature `name` is enabled.
    pub(crate) fn get(&self, name: &str, consulted: &mut Consulted) -> Result<bool, Fault> {
        let Some(number) = self.names.number(name) else {
            let fault = Fault::new(Cause::Syntax, format!("no axis sets the feature `{name}`"));
            return Err(
                match nearest(name, self.names.iter().map(|(name, _)| name)) {
                    Some(near) => fault.note(format!("did you mean `{near}`?")),
                    None => {
                        fault.note("declare it in the package's axes.ron, among an axis's values")
                    }
                },
            );
        };
        let mut asked = self.asked.borrow_mut();
        if !asked.contains(&number) {
            asked.push(number);
        }
        let enabled = self.enabled.contains(number);
        consulted.asked.insert(number);
        if enabled {
            consulted.found.insert(number);
        }
        Ok(enabled)
    }
}
