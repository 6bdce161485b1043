//! Projection: which of a key's choices a permutation depends on.
//!
//! From the root module through imports and bindings, every feature that is looked up and every
//! interface whose binding is needed is noted. Two keys that give the same answers are one
//! permutation, known before anything is linked.

use std::{collections::BTreeSet, sync::Arc};

use crate::{
    Fault, Library, ProjectedKey, bits::Bits, composer::Entry, features::Consulted,
    library::Request, prepare::Prepared,
};

/// Dependencies of a request's permutation.
#[derive(Debug, Default)]
pub(crate) struct Dependencies {
    /// The modules that are read, in the order of their numbers.
    pub(crate) modules: Bits,
    /// The same, as they were read.
    pub(crate) entries: Vec<(usize, Arc<Entry>)>,
    /// The features that were looked up.
    pub(crate) consulted: Consulted,
    /// The interfaces whose binding is needed.
    pub(crate) interfaces: BTreeSet<usize>,
}

/// Reads modules.
pub(crate) trait Modules {
    fn read(&self, module: usize) -> Arc<Entry>;

    fn prepared(&self, module: usize) -> Result<Arc<Prepared>, Fault> {
        self.read(module).prepared.clone()
    }
}

/// Dependencies of the permutation that `request` asks for, as far as they are found without following calls through
/// the interface `but`; with a fault, those found up to it.
pub(crate) fn dependencies(
    request: &Request,
    but: Option<usize>,
    modules: &dyn Modules,
) -> (Dependencies, Result<(), Fault>) {
    let mut found = Dependencies::default();
    let mut waiting = vec![request.root];
    while let Some(module) = waiting.pop() {
        if found.modules.contains(module) {
            continue;
        }
        found.modules.insert(module);
        let entry = modules.read(module);
        let prepared = match &entry.prepared {
            Ok(prepared) => prepared,
            Err(fault) => return (found, Err(fault.clone())),
        };
        found.consulted.union(&prepared.consulted);
        waiting.extend(&prepared.modules);
        let interfaces = prepared.interfaces.iter();
        for &interface in interfaces.filter(|interface| Some(**interface) != but) {
            found.interfaces.insert(interface);
            waiting.extend(request.bindings.get(&interface));
        }
        found.entries.push((module, entry));
    }
    (found, Ok(()))
}

/// The key that names the permutation of `request`, which depends on what was `found`: of all legal keys that give the
/// same answers, the one with defaults as far as they are legal. None where `request` is of no legal key.
pub(crate) fn project(
    library: &Library,
    request: &Request,
    found: &Dependencies,
) -> Option<ProjectedKey> {
    let table = library.table();
    let part = table.same(request, found);
    Some(ProjectedKey::of(table.key(&table.first(&part)?)))
}
