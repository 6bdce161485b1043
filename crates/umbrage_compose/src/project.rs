//! Projection: which of a key's choices a permutation depends on.
//!
//! From the root module through imports and bindings, every feature that is looked up and every
//! interface whose binding is needed is noted. Two keys that give the same answers are one
//! permutation, known before anything is linked.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    sync::Arc,
};

use crate::{
    Cause, Fault, Key, Library, axes::EffectNumbers, bits::Bits, features::Consulted,
    library::Request, prepare::Prepared,
};

/// What a request's permutation depends on.
#[derive(Debug, Default)]
pub(crate) struct Dependencies {
    /// The modules that are read, in the order of their numbers.
    pub(crate) modules: Bits,
    /// The features that were looked up.
    pub(crate) consulted: Consulted,
    /// The interfaces whose binding is needed.
    pub(crate) interfaces: BTreeSet<usize>,
}

/// Gives prepared modules.
pub(crate) trait Modules {
    fn prepared(&self, module: usize) -> Result<std::sync::Arc<Prepared>, Fault>;
}

/// Dependencies of the permutation that `request` asks for; with a fault, those found up to it.
pub(crate) fn dependencies(
    request: &Request,
    modules: &dyn Modules,
) -> (Dependencies, Result<(), Fault>) {
    let mut found = Dependencies::default();
    let mut waiting = vec![request.root];
    while let Some(module) = waiting.pop() {
        if found.modules.contains(module) {
            continue;
        }
        found.modules.insert(module);
        let prepared = match modules.prepared(module) {
            Ok(prepared) => prepared,
            Err(fault) => return (found, Err(fault)),
        };
        found.consulted.union(&prepared.consulted);
        waiting.extend(&prepared.modules);
        for &interface in &prepared.interfaces {
            found.interfaces.insert(interface);
            waiting.extend(request.bindings.get(&interface));
        }
    }
    (found, Ok(()))
}

/// The key that names the permutation of `request`, which depends on what was `found`: of all legal keys that give the
/// same answers, the one with defaults as far as they are legal. None where `request` is of no legal key.
pub(crate) fn project(library: &Library, request: &Request, found: &Dependencies) -> Option<Key> {
    let table = library.table();
    let part = table.same(request, found);
    Some(table.key(&table.first(&part)?))
}

/// Projections of keys, found by reading each set of modules only once: keys that have the same values on the axes
/// that matter share a projection.
pub(crate) struct Projections<'a> {
    library: &'a Library,
    /// Axes that bind the same interface as another axis, or that name a root as another does. Such axes may
    /// contradict each other whatever is read.
    contested: Vec<Arc<str>>,
    /// Sets of axes that matter, each with the answers for the values on these axes.
    known: Vec<(Arc<[Arc<str>]>, Answers<'a>)>,
    /// Number of keys that were read.
    pub(crate) read: usize,
}

/// Result of reading a key's modules: its projection, or the fault that prevents it.
pub(crate) type Answer = Result<Key, Fault>;

type Answers<'a> = HashMap<Vec<Option<&'a str>>, Answer>;

impl<'a> Projections<'a> {
    pub(crate) fn new(library: &'a Library) -> Self {
        let mut by_claim: BTreeMap<Option<usize>, BTreeSet<&str>> = BTreeMap::new();
        for axis in library.axes().iter() {
            for effect in axis.values.values() {
                let bound = effect
                    .numbers
                    .bind
                    .iter()
                    .map(|(interface, _)| Some(*interface));
                for claim in bound.chain(effect.numbers.root.map(|_| None)) {
                    by_claim.entry(claim).or_default().insert(&axis.name);
                }
            }
        }
        let contested: BTreeSet<_> = (by_claim.into_values())
            .filter(|axes| axes.len() > 1)
            .flatten()
            .collect();
        Self {
            library,
            contested: contested
                .into_iter()
                .map(|axis| library.axes().name(axis))
                .collect(),
            known: Vec::new(),
            read: 0,
        }
    }

    /// Answer for `key`, and the axes that matter to it. It is either known already or found by `read`, which
    /// returns the dependencies (none where the key itself is invalid) and whether reading succeeded.
    pub(crate) fn of(
        &mut self,
        key: &'a Key,
        read: impl FnOnce(&Key) -> (Option<Dependencies>, Result<(), Fault>),
    ) -> (Answer, Arc<[Arc<str>]>) {
        let axes = self.library.axes();
        let values = |matter: &[Arc<str>]| -> Vec<Option<&'a str>> {
            // Values borrow from the library, which outlives this map, as the keys do.
            let value = |axis: &Arc<str>| self.library.axes().value(key, axis);
            matter.iter().map(value).collect()
        };
        for (matter, answers) in &self.known {
            if let Some(answer) = answers.get(&values(matter)) {
                return (answer.clone(), matter.clone());
            }
        }
        self.read += 1;
        let (found, outcome) = read(key);
        let answer = outcome.and_then(|()| {
            let found = found
                .as_ref()
                .ok_or_else(|| Fault::new(Cause::Key, "not read"))?;
            let request = self.library.request(key)?;
            Ok(project(self.library, &request, found).unwrap_or_else(|| key.clone()))
        });
        let matter: Arc<[Arc<str>]> = (axes.effects(key))
            .filter(|(axis, effect)| match &found {
                Some(found) => (axis.values.values())
                    .any(|other| !same_as_far(&other.numbers, &effect.numbers, found, answer.is_err())),
                // Another value on any axis may mend an invalid key.
                None => true,
            } || self.contested.iter().any(|contested| **contested == *axis.name))
            .map(|(axis, _)| axes.name(&axis.name))
            .collect();
        let at = self.known.iter().position(|(known, _)| *known == matter);
        let at = at.unwrap_or_else(|| {
            self.known.push((matter.clone(), Answers::default()));
            self.known.len() - 1
        });
        let values = values(&matter);
        self.known[at].1.insert(values, answer.clone());
        (answer, matter)
    }
}

/// Whether two values make no difference to a permutation with the dependencies `found`. Where reading was
/// `cut_short`, any feature may make one.
fn same_as_far(
    a: &EffectNumbers,
    b: &EffectNumbers,
    found: &Dependencies,
    cut_short: bool,
) -> bool {
    same(a, b, found) && (!cut_short || a.features == b.features)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Composer, Package, Target};

    /// A library with `unread` axes that no module reads, and one axis that a module reads.
    fn library(unread: usize) -> Library {
        let axes: String = (0..unread)
            .map(|n| {
                format!(
                    r#""a{n:02}": (default: "off", values: {{ "off": (), "on": (features: ["F{n}"]) }}),"#
                )
            })
            .collect();
        let axes = format!(
            r#"(axes: {{ {axes}
                "fog": (default: "off", values: {{ "off": (), "on": (features: ["FOG"]) }}),
                "pass": (values: {{ "main": (root: "package::main"), "bad": (root: "package::bad") }}),
            }})"#
        );
        let files = [
            ("axes.ron", axes.as_str()),
            (
                "main.wesl",
                "@if(FOG) const A = 1.0;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(1.0); }",
            ),
            ("bad.wesl", "fn f( {"),
        ];
        let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
        Library::new([Package::from_sources("demo", "demo", files).unwrap()]).unwrap()
    }

    /// Every key of `library`.
    fn keys(library: &Library, unread: usize) -> Vec<Key> {
        let mut keys = Vec::new();
        for bits in 0..1usize << (unread + 2) {
            let value = |bit: usize| if bits >> bit & 1 == 1 { "on" } else { "off" };
            let names: Vec<_> = (0..unread).map(|n| format!("a{n:02}")).collect();
            let mut choices: Vec<_> = (names.iter().enumerate())
                .map(|(n, name)| (name.as_str(), value(n)))
                .collect();
            choices.push(("fog", value(unread)));
            choices.push(("pass", ["main", "bad"][bits >> (unread + 1)]));
            keys.push(library.key(choices).unwrap());
        }
        keys
    }

    #[test]
    fn what_is_read_does_not_grow_with_the_keys() {
        for unread in [2, 4, 8] {
            let library = library(unread);
            let keys = keys(&library, unread);
            let composer = Composer::new(library.clone(), Target::webgpu());
            let mut projections = Projections::new(&library);
            for key in &keys {
                let (answer, matter) = projections.of(key, |key| composer.found(key));
                let one_by_one = composer.project(key);
                assert_eq!(answer.as_ref().ok(), one_by_one.as_ref().ok(), "{key}");
                let expected: &[&str] = match &answer {
                    Ok(_) => &["fog", "pass"],
                    // Any feature may have led to a fault.
                    Err(_) => &[],
                };
                let matter: Vec<_> = matter.iter().map(|axis| &**axis).collect();
                assert!(
                    expected.is_empty() || matter == expected,
                    "{key}: {matter:?}"
                );
            }
            let sound = 2;
            let faulty = 1 << (unread + 1);
            assert!(
                projections.read <= sound + faulty,
                "{} of {}",
                projections.read,
                keys.len()
            );
            let sound: Vec<_> = keys
                .into_iter()
                .filter(|key| key.get("pass") == Some("main"))
                .collect();
            let mut projections = Projections::new(&library);
            for key in &sound {
                assert!(projections.of(key, |key| composer.found(key)).0.is_ok());
            }
            assert_eq!(projections.read, 2, "of {} keys", sound.len());
        }
    }
}
