//! Feature flags, and what was asked of them.

use std::{
    cell::RefCell,
    collections::{BTreeSet, HashMap},
};

use umbrage_hints::did_you_mean;

use crate::{Cause, Fault, bits::Bits};

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
    pub(crate) fn set(&self, names: &[String]) -> Bits {
        let mut set = Bits::default();
        for number in names.iter().filter_map(|name| self.number(name)) {
            set.insert(number);
        }
        set
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, usize)> {
        self.0.iter().map(|(name, number)| (name.as_str(), *number))
    }
}

/// The features that were asked for, and which of them were found enabled: two sets of features that
/// agree on these give the same answers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Consulted {
    pub(crate) asked: Bits,
    pub(crate) found: Bits,
}

impl Consulted {
    pub(crate) fn union(&mut self, other: &Self) {
        self.asked.union(&other.asked);
        self.found.union(&other.found);
    }
}

/// The enabled features among the known ones.
#[derive(Clone, Copy)]
pub(crate) struct Features<'a> {
    pub(crate) names: &'a FeatureNames,
    pub(crate) enabled: &'a Bits,
    /// Features that were asked for, in the order of the first questions. The next question depends on the answers before
    /// it alone.
    pub(crate) asked: &'a RefCell<Vec<usize>>,
}

impl Features<'_> {
    /// Counts `features` as asked for, in this order.
    pub(crate) fn ask(&self, features: &[usize]) {
        let mut asked = self.asked.borrow_mut();
        for feature in features {
            if !asked.contains(feature) {
                asked.push(*feature);
            }
        }
    }

    /// Whether the feature `name` is enabled.
    pub(crate) fn get(&self, name: &str, consulted: &mut Consulted) -> Result<bool, Fault> {
        let Some(number) = self.names.number(name) else {
            let fault = Fault::new(Cause::Syntax, format!("no axis sets the feature `{name}`"));
            return Err(
                match did_you_mean(name, self.names.iter().map(|(name, _)| name)) {
                    Some(hint) => fault.note(hint),
                    None => {
                        fault.note("declare it in the package's axes.ron, among an axis's values")
                    }
                },
            );
        };
        self.ask(&[number]);
        let enabled = self.enabled.contains(number);
        consulted.asked.insert(number);
        if enabled {
            consulted.found.insert(number);
        }
        Ok(enabled)
    }
}
