//! The space of permutations: all that legal keys make, found without listing keys.
//!
//! The walk begins with all legal keys in one part, and reads modules from the root on as projection does. Where
//! reading asks for a feature or a binding on which the keys of the part differ, the part is split by the answers, and
//! each side goes on alone. So a part that is read to its end is one permutation, and stands for all legal keys in it.
//! The work follows the number of permutations, whatever the number of keys.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use crate::{
    Cause, Composer, Error, Fault, Key, Library, ProjectedKey,
    bits::Bits,
    composer::Entry,
    library::Request,
    parts::{Chosen, Part, Question, Table},
};

/// A set of legal keys: all, or those that a [manifest](crate::Manifest) selects.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Parts that share no key; none where all keys are meant.
    pub(crate) parts: Option<Vec<Part>>,
}

impl Selection {
    /// All legal keys.
    pub fn all() -> Self {
        Self::default()
    }

    /// Whether all legal keys are meant.
    pub fn is_all(&self) -> bool {
        self.parts.is_none()
    }

    /// `keys` of `library` and no others.
    pub fn of<'a>(library: &Library, keys: impl IntoIterator<Item = &'a Key>) -> Self {
        let keys: BTreeSet<_> = keys.into_iter().collect();
        let only = |key| library.table().only(library.axes(), key);
        Self {
            parts: Some(keys.into_iter().map(only).collect()),
        }
    }

    /// A hash of the keys, by which selections of one library are told apart.
    pub fn hash(&self) -> String {
        match &self.parts {
            None => "all".to_owned(),
            Some(parts) => blake3::hash(format!("{parts:?}").as_bytes()).to_hex()[..32].to_owned(),
        }
    }

    /// Whether some key has `value`.
    pub fn has(&self, library: &Library, value: ValueId) -> bool {
        let table = library.table();
        let whole = [table.whole()];
        let mut parts = self.parts.as_deref().unwrap_or(&whole).iter();
        parts.any(|part| table.first(&table.with(part, value.0)).is_some())
    }

    /// Number of the keys, at most `u128::MAX`.
    pub fn count(&self, library: &Library) -> u128 {
        let table = library.table();
        let whole = [table.whole()];
        let parts = self.parts.as_deref().unwrap_or(&whole).iter();
        parts
            .map(|part| table.count(part))
            .fold(0, u128::saturating_add)
    }
}

/// A value of an axis of a library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ValueId(pub(crate) usize);

/// A distinct permutation of the space.
#[derive(Clone, Debug)]
pub struct Variant<'a> {
    library: &'a Library,
    pub(crate) part: Part,
    /// Its keys that are selected, in parts.
    selected: Selection,
    pub(crate) chosen: Chosen,
    /// Modules that were read.
    modules: Bits,
    entries: Entries,
    fault: Option<Fault>,
}

/// The modules that a walk has read, the last first. Walks that part share what they read before.
type Entries = Option<Arc<ReadModule>>;

/// A module, as it was read.
#[derive(Debug)]
pub(crate) struct ReadModule {
    module: usize,
    entry: Arc<Entry>,
    before: Entries,
}

impl<'a> Variant<'a> {
    /// Its key: of all legal keys that make it, the one with defaults as far as possible. It is the
    /// [projection](Composer::project) of each of them.
    pub fn key(&self) -> ProjectedKey {
        ProjectedKey::of(self.table().key(&self.chosen))
    }

    /// The fault that keeps its modules from being read, where there is one.
    pub fn fault(&self) -> Option<Error> {
        let fault = self.fault.clone()?;
        Some(fault.key(&self.key()).into())
    }

    /// Demands of its keys on the linker.
    pub(crate) fn request(&self) -> Request {
        self.table().request(&self.chosen)
    }

    /// Paths of the modules that it is made of.
    pub fn modules(&self) -> impl Iterator<Item = &'a str> + '_ {
        let sources = self.library.sources();
        self.modules
            .iter()
            .map(|module| sources[module].path.as_str())
    }

    pub(crate) fn module_numbers(&self) -> &Bits {
        &self.modules
    }

    /// Its modules by number, as they were read.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, &Entry)> {
        let all = std::iter::successors(self.entries.as_deref(), |read| read.before.as_deref());
        all.map(|read| (read.module, &*read.entry))
    }

    /// Number of the selected keys that make it, at most `u128::MAX`.
    pub fn count(&self) -> u128 {
        let counts = self.parts().iter().map(|part| self.table().count(part));
        counts.fold(0, u128::saturating_add)
    }

    /// The selected keys that make it, sorted. They may be very many: see [`Self::count`].
    pub fn keys(&self) -> Vec<Key> {
        let mut keys: Vec<_> = self
            .parts()
            .iter()
            .flat_map(|part| self.table().list(part))
            .collect();
        keys.sort();
        keys
    }

    /// The axes by name, each with the values that occur in its selected keys. Not every combination of them need be
    /// legal.
    pub fn values(&self) -> BTreeMap<Arc<str>, BTreeSet<Arc<str>>> {
        let mut all: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
        for (axis, values) in self
            .parts()
            .iter()
            .flat_map(|part| self.table().values(part))
        {
            all.entry(axis).or_default().extend(values);
        }
        all
    }

    /// Whether some of its selected keys may have `value`.
    pub fn may_have(&self, value: ValueId) -> bool {
        self.parts().iter().any(|part| part.open.contains(value.0))
    }

    /// The axes whose values matter to it: another value of one may make another permutation.
    pub fn mattering(&self) -> impl Iterator<Item = &Arc<str>> {
        self.table().mattering_names(&self.part)
    }

    /// For each axis that matters, a number that it shares with the permutations that have another value there and are
    /// else the same.
    pub fn siblings(&self) -> impl Iterator<Item = (&Arc<str>, u64)> {
        let mix = |value: &usize| {
            let mixed = (*value as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            (mixed ^ mixed >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9)
        };
        let all = self.chosen.iter().map(mix).fold(0, u64::wrapping_add);
        let choices = self.table().mattering_choices(&self.part, &self.chosen);
        // Mixed once more, so that every bit depends on every choice.
        let others = choices.map(move |value| {
            let others = all.wrapping_sub(mix(&value));
            (others ^ others >> 32)
                .wrapping_mul(0x94D0_49BB_1331_11EB)
                .rotate_left(32)
        });
        self.mattering().zip(others)
    }

    pub(crate) fn table(&self) -> &'a Table {
        self.library.table()
    }

    fn parts(&self) -> &[Part] {
        let whole = std::slice::from_ref(&self.part);
        self.selected.parts.as_deref().unwrap_or(whole)
    }
}

/// A module, read while some features are undecided.
pub(crate) enum Read {
    Module(Arc<Entry>),
    /// Reading depends on this feature, which is not decided.
    Undecided(usize),
    Fault(Fault),
}

/// Features that are enabled, and features that may be.
#[derive(Clone, Debug, Default)]
pub(crate) struct Known {
    pub(crate) certain: Bits,
    pub(crate) possible: Bits,
}

impl Known {
    fn of(table: &Table, part: &Part) -> Self {
        let (certain, possible) = table.features(part);
        Self { certain, possible }
    }

    /// Whether `feature` is enabled, where that is decided.
    pub(crate) fn decided(&self, feature: usize) -> Option<bool> {
        let (certain, possible) = (&self.certain, &self.possible);
        (certain.contains(feature) || !possible.contains(feature))
            .then(|| certain.contains(feature))
    }
}

/// The distinct permutations of a space, or of a part of it, each once, always in the same order.
#[derive(Clone, Debug)]
pub struct Variants<'a> {
    composer: &'a Composer,
    /// The walks still to go; the last is the next.
    walks: Vec<Walk>,
}

impl<'a> Variants<'a> {
    pub(crate) fn new(composer: &'a Composer, selection: &Selection) -> Self {
        let table = composer.library().table();
        let whole = table.whole();
        let chosen = table.first(&whole);
        let walks = chosen.map(|chosen| Walk::new(table, whole, selection.clone(), chosen));
        Self {
            composer,
            walks: walks.into_iter().collect(),
        }
    }

    /// The same permutations in the same order, in consecutive parts that different threads can walk: about `count`
    /// of them, of different sizes.
    pub fn split(mut self, count: usize) -> Vec<Self> {
        // Each round goes one step on in every walk.
        let mut ended = 0;
        while ended < self.walks.len() && self.walks.len() < count {
            ended = 0;
            let mut walks = Vec::new();
            for walk in self.walks {
                match Self::step(self.composer, walk) {
                    Step::Split(sides) => walks.extend(sides),
                    Step::End(walk) => {
                        ended += 1;
                        walks.push(*walk);
                    }
                }
            }
            self.walks = walks;
        }
        let walks = self.walks.into_iter().rev();
        let parts = walks.map(|walk| Self {
            composer: self.composer,
            walks: vec![walk],
        });
        parts.collect()
    }

    /// Goes on with `walk` to its next question or its end. Sides are sorted so that the first to go is the last.
    fn step(composer: &Composer, mut walk: Walk) -> Step {
        let table = composer.library().table();
        let Some(question) = walk.go_on(composer) else {
            return Step::End(Box::new(walk));
        };
        let sides = table.split((&walk.part, &walk.chosen), question);
        let sides = sides
            .into_iter()
            .rev()
            .filter_map(|(answer, part, chosen)| {
                let mut selected = walk.selected.clone();
                if let Some(parts) = &mut selected.parts {
                    for selected in parts.iter_mut() {
                        *selected = selected.and(&part);
                    }
                    parts.retain(|selected| table.first(selected).is_some());
                    if parts.is_empty() {
                        return None;
                    }
                }
                let mut side = Walk {
                    known: Known::of(table, &part),
                    part,
                    selected,
                    chosen,
                    progress: walk.progress.clone(),
                };
                side.progress.take(question, answer);
                Some(side)
            });
        Step::Split(sides.collect())
    }
}

impl<'a> Iterator for Variants<'a> {
    type Item = Variant<'a>;

    fn next(&mut self) -> Option<Variant<'a>> {
        while let Some(walk) = self.walks.pop() {
            match Self::step(self.composer, walk) {
                Step::Split(sides) => self.walks.extend(sides),
                Step::End(walk) => {
                    return Some(Variant {
                        library: self.composer.library(),
                        part: walk.part,
                        selected: walk.selected,
                        chosen: walk.chosen,
                        modules: walk.progress.seen,
                        entries: walk.progress.entries,
                        fault: walk.progress.fault,
                    });
                }
            }
        }
        None
    }
}

enum Step {
    Split(Vec<Walk>),
    End(Box<Walk>),
}

/// A part of the space, and how far its keys' modules were read.
#[derive(Clone, Debug)]
struct Walk {
    part: Part,
    selected: Selection,
    /// The part's first key.
    chosen: Chosen,
    known: Known,
    progress: Progress,
}

/// How far the modules of a part's keys were read.
#[derive(Clone, Debug)]
struct Progress {
    /// Modules that were read.
    seen: Bits,
    entries: Entries,
    /// Modules to be read.
    waiting: Vec<usize>,
    /// Questions to be asked before the next module is read.
    questions: Vec<Question>,
    /// Interfaces that were asked for, with what is bound to them.
    bound: BTreeMap<usize, Option<usize>>,
    fault: Option<Fault>,
}

impl Walk {
    fn new(table: &Table, part: Part, selected: Selection, chosen: Chosen) -> Self {
        let mut questions = table.first_questions();
        questions.reverse();
        Self {
            known: Known::of(table, &part),
            part,
            selected,
            chosen,
            progress: Progress {
                seen: Bits::default(),
                entries: None,
                waiting: Vec::new(),
                questions,
                bound: BTreeMap::new(),
                fault: None,
            },
        }
    }

    /// Reads on to the next question; none where all is read.
    fn go_on(&mut self, composer: &Composer) -> Option<Question> {
        self.progress.go_on(composer, &self.known)
    }
}

impl Progress {
    /// Takes the answer that all keys of the part give.
    fn take(&mut self, question: Question, answer: Option<usize>) {
        match (question, answer) {
            (Question::Root, None) => {
                let message = "the key names no module to start from";
                self.fault = Some(
                    Fault::new(Cause::Key, message)
                        .note("give some axis's value a `root` in axes.ron"),
                );
            }
            (Question::Root, answer) => self.waiting.extend(answer),
            (Question::Binding(interface), answer) => {
                self.bound.insert(interface, answer);
                self.waiting.extend(answer);
            }
            (Question::Feature(_) | Question::Counting(_), _) => {}
        }
    }

    fn go_on(&mut self, composer: &Composer, known: &Known) -> Option<Question> {
        loop {
            if self.fault.is_some() {
                return None;
            }
            if let Some(question) = self.questions.pop() {
                match question {
                    Question::Binding(interface) if self.bound.contains_key(&interface) => {
                        self.waiting.extend(self.bound[&interface]);
                        continue;
                    }
                    _ => return Some(question),
                }
            }
            let &module = self.waiting.last()?;
            if self.seen.contains(module) {
                self.waiting.pop();
                continue;
            }
            match composer.read_undecided(module, known) {
                Read::Undecided(feature) => return Some(Question::Feature(feature)),
                Read::Fault(fault) => self.fault = Some(fault),
                Read::Module(entry) => {
                    self.waiting.pop();
                    self.seen.insert(module);
                    let Ok(prepared) = &entry.prepared else {
                        continue;
                    };
                    self.waiting.extend(&prepared.modules);
                    // Asked in ascending order, as `project::dependencies` does: the first fault is the same.
                    let interfaces = prepared.interfaces.iter().rev();
                    self.questions
                        .extend(interfaces.map(|i| Question::Binding(*i)));
                    let before = self.entries.take();
                    self.entries = Some(Arc::new(ReadModule {
                        module,
                        entry,
                        before,
                    }));
                }
            }
        }
    }
}
