//! Explanations: why a permutation is what it is.

use std::{collections::BTreeSet, fmt};

use crate::{
    Composer, Error, Fault, Key, Library, ProjectedKey,
    project::{Modules, project},
};

/// Parts of a key's permutation, and why each is there.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// The key that names the permutation.
    pub permutation: ProjectedKey,
    /// Number of legal keys that make it, at most `u128::MAX`.
    pub keys: u128,
    /// The modules that are read, in the order of reading, and why each is.
    pub modules: Vec<(String, Reason)>,
    /// The features that these modules ask for, sorted.
    pub features: Vec<Feature>,
}

/// Why a module is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// A choice names it as the root.
    Root(String),
    /// A module imports it, or takes something from it by its path.
    Imported(String),
    /// A choice binds it to an interface, which a module asks.
    Bound {
        /// The choice, as `axis=value`.
        choice: String,
        /// The interface.
        interface: String,
        /// The module that asks.
        asked_by: String,
    },
}

/// A feature that a permutation's modules ask for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Feature {
    /// Its name.
    pub name: String,
    /// The choices that set it, as `axis=value`; it is off where there are none.
    pub set_by: Vec<String>,
    /// The modules that ask for it.
    pub asked_by: Vec<String>,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Root(choice) => write!(f, "the root of {choice}"),
            Self::Imported(by) => write!(f, "imported by {by}"),
            Self::Bound {
                choice,
                interface,
                asked_by,
            } => write!(f, "bound to {interface} by {choice}, asked by {asked_by}"),
        }
    }
}

impl Composer {
    /// Explains the permutation of `key`.
    ///
    /// # Errors
    /// Faults in the modules that the key leads to, as far as that takes reading them.
    pub fn explain(&self, key: &Key) -> Result<Explanation, Error> {
        Ok(self.explained(key).map_err(|fault| fault.key(key))?)
    }

    fn explained(&self, key: &Key) -> Result<Explanation, Fault> {
        let library = self.library();
        let (request, found) = self.read(key)?;
        let part = library.table().same(&request, &found);
        let path = |module: usize| library.source(module).path.clone();
        let with = self.modules(&request.features);
        let mut modules = Vec::new();
        let mut asked: Vec<(usize, usize)> = Vec::new();
        let mut seen = BTreeSet::new();
        let root = choices(library, key, |numbers| numbers.root == Some(request.root));
        let mut waiting = vec![(request.root, Reason::Root(root.join(", ")))];
        while let Some((module, reason)) = waiting.pop() {
            if !seen.insert(module) {
                continue;
            }
            modules.push((path(module), reason));
            let prepared = with.prepared(module)?;
            let features = prepared.consulted.asked.iter();
            asked.extend(features.map(|feature| (feature, module)));
            let imported = prepared.modules.iter();
            waiting.extend(imported.map(|other| (*other, Reason::Imported(path(module)))));
            for &interface in &prepared.interfaces {
                let Some(&bound) = request.bindings.get(&interface) else {
                    continue;
                };
                let binds = choices(library, key, |numbers| {
                    numbers.bind.contains(&(interface, bound))
                });
                let reason = Reason::Bound {
                    choice: binds.join(", "),
                    interface: path(interface),
                    asked_by: path(module),
                };
                waiting.push((bound, reason));
            }
        }
        let mut features: Vec<_> = (library.features().iter())
            .filter(|(_, number)| found.consulted.asked.contains(*number))
            .map(|(name, number)| Feature {
                name: name.to_owned(),
                set_by: choices(library, key, |numbers| numbers.features.contains(number)),
                asked_by: (asked.iter())
                    .filter(|(feature, _)| *feature == number)
                    .map(|(_, module)| path(*module))
                    .collect(),
            })
            .collect();
        features.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(Explanation {
            permutation: project(library, &request, &found)
                .unwrap_or_else(|| ProjectedKey::of(key.clone())),
            keys: library.table().count(&part),
            modules,
            features,
        })
    }
}

/// Choices of `key`, defaults too, whose value does something, as `axis=value`.
fn choices(
    library: &Library,
    key: &Key,
    does: impl Fn(&crate::axes::EffectNumbers) -> bool,
) -> Vec<String> {
    let effects = library.axes().effects(key);
    let effects = effects.filter(|(_, effect)| does(&effect.numbers));
    effects
        .map(|(axis, _)| {
            let value = library.axes().value(key, &axis.name).unwrap_or("");
            format!("{}={value}", axis.name)
        })
        .collect()
}
