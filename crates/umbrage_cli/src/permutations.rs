//! A manifest's keys, gathered by the permutation that they share: the one enumeration of `list`,
//! `check` and `prebuild`.

use std::collections::BTreeMap;

use rayon::prelude::*;
use umbrage::compose::{Composer, Error, Key, Library};

/// Keys by permutation.
pub(crate) struct Permutations {
    /// The projected key of each permutation, with the keys that share it.
    pub(crate) keys: BTreeMap<Key, Vec<Key>>,
    /// Keys whose modules are too faulty to say what they depend on.
    pub(crate) faulty: Vec<(Key, Error)>,
}

impl Permutations {
    /// Gathers `keys`.
    pub(crate) fn of(composer: &Composer, keys: &[Key]) -> Self {
        let projected: Vec<_> = keys.par_iter().map(|key| composer.project(key)).collect();
        let mut permutations = Self {
            keys: BTreeMap::new(),
            faulty: Vec::new(),
        };
        for (key, projected) in keys.iter().zip(projected) {
            match projected {
                Ok(projected) => {
                    permutations
                        .keys
                        .entry(projected)
                        .or_default()
                        .push(key.clone());
                }
                Err(error) => permutations.faulty.push((key.clone(), error)),
            }
        }
        permutations
    }

    /// The keys by permutation, or the first fault that hides them.
    pub(crate) fn all(self) -> Result<BTreeMap<Key, Vec<Key>>, Error> {
        match self.faulty.into_iter().next() {
            Some((_, error)) => Err(error),
            None => Ok(self.keys),
        }
    }
}

/// The value of every axis in `key`, defaults included.
pub(crate) fn values(library: &Library, key: &Key) -> BTreeMap<String, String> {
    let axes = library.axes();
    axes.iter()
        .filter_map(|axis| Some((axis.name.clone(), axes.value(key, &axis.name)?.to_owned())))
        .collect()
}
