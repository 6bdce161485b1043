//! A manifest's keys, gathered by the permutation that they share: the one enumeration of `list`,
//! `check` and `prebuild`.

use std::{collections::BTreeMap, sync::Arc};

use umbrage::compose::{Composer, Error, Key};

/// Keys by permutation.
pub(crate) struct Permutations {
    /// The projected key of each permutation, with the keys that share it.
    pub(crate) keys: BTreeMap<Key, Vec<Member>>,
    /// Keys whose modules are too faulty to say what they depend on.
    pub(crate) faulty: Vec<(Member, Error)>,
}

/// A key, and the axes whose choice matters to it.
pub(crate) struct Member {
    pub(crate) key: Key,
    pub(crate) matter: Arc<[Arc<str>]>,
}

impl Permutations {
    /// Gathers `keys`.
    pub(crate) fn of(composer: &Composer, keys: &[Key]) -> Self {
        let mut permutations = Self {
            keys: BTreeMap::new(),
            faulty: Vec::new(),
        };
        for (key, projected) in keys.iter().zip(composer.project_all(keys)) {
            let member = Member {
                key: key.clone(),
                matter: projected.matter,
            };
            match projected.projection {
                Ok(projection) => permutations
                    .keys
                    .entry(projection)
                    .or_default()
                    .push(member),
                Err(error) => permutations.faulty.push((member, error)),
            }
        }
        permutations
    }

    /// The keys by permutation, or the first fault that hides them.
    pub(crate) fn all(self) -> Result<BTreeMap<Key, Vec<Key>>, Error> {
        match self.faulty.into_iter().next() {
            Some((_, error)) => Err(error),
            None => Ok((self.keys.into_iter())
                .map(|(projection, members)| {
                    (
                        projection,
                        members.into_iter().map(|member| member.key).collect(),
                    )
                })
                .collect()),
        }
    }
}
