//! Shaders of several keys: a pass over several lights calls each light's shader in turn.
//!
//! A root names one interface (`each` in the axes), and a shader of several keys has an *instance* of it for each key:
//! the modules that the key binds, with bindings, features and resources of their own. The root's own side, which is all
//! that it reaches without that interface, is there once, and has to be the same for all keys. So are modules
//! without variables that are the same in every instance, such as those of mere arithmetic.
//!
//! Modules of an instance have numbers of their own while a shader is linked: `instance * modules + module`. Those of
//! the first one, and what is shared, have the library's. So nothing else knows of instances.

use std::sync::Arc;

use crate::{
    Axes, Cause, Fault, Key, Library, bits::Bits, composer::Entry, library::Request,
    project::Dependencies, unit::Unit,
};

/// The instances of a shader of several keys.
#[derive(Debug)]
pub(crate) struct Several {
    /// The interface whose implementations are called in turn.
    pub(crate) each: usize,
    /// Requests of the instances.
    pub(crate) requests: Vec<Request>,
    /// Modules that are there once.
    shared: Bits,
    /// Modules of the library.
    modules: usize,
}

/// A key, and what it leads to: all of it, and the root's own side.
pub(crate) struct Part {
    pub(crate) key: Key,
    pub(crate) request: Request,
    pub(crate) all: Dependencies,
    pub(crate) side: Dependencies,
}

impl Several {
    /// The instances of `parts`, of which there are two at the least. `unit` gives a module that was read, parsed.
    pub(crate) fn new(
        library: &Library,
        parts: &[Part],
        unit: impl Fn(usize, &Entry) -> Result<Arc<Unit>, Fault>,
    ) -> Result<Self, Fault> {
        let first = &parts[0];
        let Some(each) = first.request.each else {
            let message = format!(
                "the pass of the key {} calls no interface in turn",
                first.key
            );
            return Err(Fault::new(Cause::Key, message).note(
                "choose a pass whose value has `each` in axes.ron, or make a shader of each key",
            ));
        };
        for part in &parts[1..] {
            check_side(library, first, part)?;
        }
        Ok(Self {
            each,
            shared: shared(parts, unit)?,
            requests: parts.iter().map(|part| part.request.clone()).collect(),
            modules: library.sources().len(),
        })
    }

    /// The instance that a module belongs to; of what is shared, the first.
    pub(crate) fn instance(&self, number: usize) -> usize {
        number / self.modules
    }

    /// A module's number in the library.
    pub(crate) fn module(&self, number: usize) -> usize {
        number % self.modules
    }

    /// The number of the library's `module` in an instance.
    pub(crate) fn number(&self, instance: usize, module: usize) -> usize {
        match self.shared.contains(module) {
            true => module,
            false => instance * self.modules + module,
        }
    }

    /// Whether a module's calls through [`Self::each`] lead to every instance.
    pub(crate) fn calls_each(&self, number: usize) -> bool {
        self.shared.contains(number)
    }
}

/// Checks that the root's own side is the same for two keys.
fn check_side(library: &Library, first: &Part, other: &Part) -> Result<(), Fault> {
    let [a, b] = [first, other].map(|part| &part.side);
    let differs = |&(module, ref entry): &(usize, Arc<Entry>)| {
        let mut known = b.entries.iter();
        !known.any(|(same, known)| *same == module && known.is_same(entry))
    };
    let differing = a.entries.iter().find(|entry| differs(entry));
    let same_root = first.request.root == other.request.root;
    if same_root && differing.is_none() && a.modules == b.modules {
        return Ok(());
    }
    let what = match differing.filter(|_| same_root) {
        Some((module, _)) => format!("`{}` is there once", library.source(*module).path),
        None => "the pass is there once".to_owned(),
    };
    let choices = differing_choices(library.axes(), first, other);
    let message = format!("{what} in a shader of several keys, but they ask for it in two ways");
    let fault = Fault::new(Cause::Key, message);
    Err(match choices.is_empty() {
        true => fault,
        false => fault.note(format!(
            "give the keys {} and {} one value of {}, or make a shader of each",
            first.key,
            other.key,
            choices.join(" and of ")
        )),
    })
}

/// Axes on which two keys differ in a way that the root's own side looks at.
fn differing_choices(axes: &Axes, first: &Part, other: &Part) -> Vec<String> {
    let mut found = Vec::new();
    for ((axis, a), (_, b)) in axes.effects(&first.key).zip(axes.effects(&other.key)) {
        let (a, b) = (&a.numbers, &b.numbers);
        let mut features = a.features.clone();
        features.remove_all(&b.features);
        let mut others = b.features.clone();
        others.remove_all(&a.features);
        features.union(&others);
        let reads = [first, other].iter().any(|part| {
            let side = &part.side;
            let bound = a.bind.iter().chain(&b.bind);
            let mut bound = bound.map(|(interface, _)| interface);
            side.consulted.asked.meets(&features)
                || (a.bind != b.bind && bound.any(|interface| side.interfaces.contains(interface)))
        });
        if reads || a.root != b.root {
            found.push(format!("`{}`", axis.name));
        }
    }
    found
}

/// Modules that are there once: the root's own side, and those without variables that are the same in every instance, as
/// is all that they lead to.
fn shared(
    parts: &[Part],
    unit: impl Fn(usize, &Entry) -> Result<Arc<Unit>, Fault>,
) -> Result<Bits, Fault> {
    let (first, others) = (&parts[0], &parts[1..]);
    let mut shared = first.side.modules.clone();
    let mut alike = Vec::new();
    for (module, entry) in &first.all.entries {
        let same = others.iter().all(|part| {
            let mut entries = part.all.entries.iter();
            entries.any(|(known, other)| known == module && other.is_same(entry))
        });
        if same && !shared.contains(*module) && unit(*module, entry)?.own_globals.is_empty() {
            alike.push((*module, entry));
        }
    }
    loop {
        let mut candidates = shared.clone();
        candidates.extend(alike.iter().map(|(module, _)| *module));
        let before = alike.len();
        alike.retain(|(_, entry)| {
            let Ok(prepared) = &entry.prepared else {
                return false;
            };
            let mut leads_to = prepared.modules.iter();
            let mut interfaces = prepared.interfaces.iter();
            leads_to.all(|module| candidates.contains(*module))
                && interfaces.all(|interface| {
                    let bound = |part: &Part| part.request.bindings.get(interface).copied();
                    let own = bound(first);
                    own.is_none_or(|module| candidates.contains(module))
                        && others.iter().all(|part| bound(part) == own)
                })
        });
        if alike.len() == before {
            shared.extend(alike.iter().map(|(module, _)| *module));
            return Ok(shared);
        }
    }
}
