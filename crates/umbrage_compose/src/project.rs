//! Projection: which of a key's choices a permutation depends on.
//!
//! From the root module through imports and bindings, every feature that is looked up and every
//! interface whose binding is needed is noted. Two keys that give the same answers are one
//! permutation, known before anything is linked.

use std::collections::{BTreeMap, BTreeSet};

use crate::{
    Fault, Key, Library, axes::Effect, features::Consulted, library::Request, prepare::Prepared,
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
    library: &Library,
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
        for item in &prepared.wanted {
            waiting.push(item.module);
            let interface = library.source(item.module).is_interface();
            if interface && is_function(library, item.module, &item.name)? {
                found.interfaces.insert(item.module);
                waiting.extend(request.bindings.get(&item.module));
            }
        }
        // What stands in for others' declarations may come from further modules.
        waiting.extend(prepared.stubs.items.values().map(|item| item.module));
    }
    Ok(found)
}

fn is_function(library: &Library, module: usize, name: &str) -> Result<bool, Fault> {
    use wgsl_parse::syntax::GlobalDeclaration;
    let declarations = &library.syntax(module)?.tree.global_declarations;
    Ok(declarations.iter().any(|node| match node.node() {
        GlobalDeclaration::Function(function) => *function.ident.name() == name,
        _ => false,
    }))
}

/// `key` with every choice that makes no difference at its default, and every other at the first
/// value that makes the same one.
pub(crate) fn project(library: &Library, key: &Key, found: &Dependencies) -> Key {
    let mut projected = BTreeMap::new();
    for (axis, effect) in library.axes().effects(key) {
        let matters = relevant(library, effect, found);
        let alike = |value: &&String| relevant(library, &axis.values[*value], found) == matters;
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

/// What of a value's effect a permutation depends on.
#[derive(PartialEq)]
struct Relevant<'a> {
    root: Option<&'a str>,
    bind: Vec<(usize, Option<usize>)>,
    features: BTreeSet<&'a str>,
}

fn relevant<'a>(library: &Library, effect: &'a Effect, found: &Dependencies) -> Relevant<'a> {
    let bind = effect
        .bind
        .iter()
        .filter_map(|(interface, implementation)| {
            let interface = library.module(interface)?;
            let needed = found.interfaces.contains(&interface);
            needed.then(|| (interface, library.module(implementation)))
        });
    let features = effect
        .features
        .iter()
        .map(String::as_str)
        .filter(|feature| {
            let number = library.features().number(feature);
            number.is_some_and(|number| found.consulted.asked.contains(number))
        });
    Relevant {
        root: effect.root.as_deref(),
        bind: bind.collect(),
        features: features.collect(),
    }
}
