//! Projection: which of a key's choices a permutation depends on.
//!
//! From the root module through imports and bindings, every feature that is looked up and every
//! interface whose binding is needed is noted. Two keys that give the same answers are one
//! permutation, known before anything is linked.

use std::collections::{BTreeMap, BTreeSet};

use crate::{
    Fault, Key, Library, axes::EffectNumbers, features::Consulted, library::Request,
    prepare::Prepared,
};

/// What a request's permutation depends on.
#[derive(Debug, Default)]
pub(crate) struct Dependencies {
    /// The modules that are read, in the order of their numbers.
    pub(crate) modules: BTreeSet<usize>,
    /// The features that were looked up.
    pub(crate) consulted: Consulted,
    /// The interfaces whose binding is needed.
    pub(crate) interfaces: BTreeSet<usize>,
}

/// Gives prepared modules.
pub(crate) trait Modules {
    fn prepared(&self, module: usize) -> Result<std::sync::Arc<Prepared>, Fault>;
}

/// What the permutation that `request` asks for depends on.
pub(crate) fn dependencies(
    request: &Request,
    modules: &dyn Modules,
) -> Result<Dependencies, Fault> {
    let mut found = Dependencies::default();
    let mut waiting = vec![request.root];
    while let Some(module) = waiting.pop() {
        if !found.modules.insert(module) {
            continue;
        }
        let prepared = modules.prepared(module)?;
        found.consulted.union(&prepared.consulted);
        waiting.extend(&prepared.modules);
        for &interface in &prepared.interfaces {
            found.interfaces.insert(interface);
            waiting.extend(request.bindings.get(&interface));
        }
    }
    Ok(found)
}

/// `key` with every choice that makes no difference at its default, and every other at the first
/// value that makes the same one.
pub(crate) fn project(library: &Library, key: &Key, found: &Dependencies) -> Key {
    let mut projected = BTreeMap::new();
    for (axis, effect) in library.axes().effects(key) {
        let alike = |value: &&String| same(&axis.values[*value].numbers, &effect.numbers, found);
        let first = axis
            .default
            .iter()
            .find(alike)
            .or_else(|| axis.values.keys().find(alike));
        if let Some(value) = first.filter(|value| axis.default.as_ref() != Some(value)) {
            projected.insert(axis.name.clone(), value.clone());
        }
    }
    Key(projected)
}

/// Whether two values make no difference to a permutation that depends on what was `found`.
fn same(a: &EffectNumbers, b: &EffectNumbers, found: &Dependencies) -> bool {
    let needed = |(interface, _): &&(usize, usize)| found.interfaces.contains(interface);
    a.root == b.root
        && a.bind
            .iter()
            .filter(needed)
            .eq(b.bind.iter().filter(needed))
        && a.counting == b.counting
        && a.features.same_among(&b.features, &found.consulted.asked)
}
