//! The space of permutations: all that legal keys make, found without listing keys.
//!
//! A *part* of the space is a set of open values for each axis, with marks (features, bindings, capabilities) of which
//! each must come from some choice. The walk begins with everything open and reads modules as projection does. Where
//! reading looks up a feature or a binding on which open values differ, the part is split by the answer, and each
//! side goes on alone. So each part that is read to its end is one permutation, and stands for all legal keys in it.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap, HashSet},
    sync::Arc,
};

use crate::{
    Error, Fault, Key, Library,
    axes::{Counting, EffectNumbers},
    features::FeatureSet,
    library::Request,
    project::Dependencies,
};

/// A distinct permutation of the space.
#[derive(Clone, Debug)]
pub struct Variant<'a> {
    /// Its key: of all keys that make it, the one with defaults wherever they are legal.
    pub key: Key,
    /// The fault that keeps its modules from being read, where there is one.
    pub fault: Option<Error>,
    table: &'a Table,
    part: Part,
}

impl Variant<'_> {
    /// Number of the legal keys that make it, at most `u128::MAX`.
    pub fn keys(&self) -> u128 {
        self.table.count(&self.part)
    }

    /// For each axis by name, the values that occur in its keys. Not every combination of them is legal.
    pub fn values(&self) -> BTreeMap<Arc<str>, Vec<Arc<str>>> {
        self.table.values(&self.part)
    }
}

/// Axes and values of a library, by numbers, as the walk needs them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    axes: Vec<Choices>,
    /// A binding's, root's or count's mark. Features and capabilities have their marks below these.
    claims: HashMap<Claim, usize>,
    countings: Vec<Counting>,
    capabilities: usize,
}

#[derive(Clone, Debug)]
struct Choices {
    name: Arc<str>,
    has_default: bool,
    /// The default first, the others sorted.
    values: Vec<Value>,
}

#[derive(Clone, Debug)]
struct Value {
    name: Arc<str>,
    gives: FeatureSet,
    needs: FeatureSet,
}

/// A claim that values of several axes may contradict each other in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Claim {
    Root(usize),
    Bound(usize, usize),
    Counting(usize),
}

/// A part of the space.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Open values of each axis.
    open: Vec<FeatureSet>,
    /// Marks that some choice must give.
    required: FeatureSet,
}

/// A question that reading asks, and on which open values may differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Question {
    Root,
    Feature(usize),
    Binding(usize),
    Counting(usize),
}

impl Table {
    pub(crate) fn new(library: &Library) -> Self {
        let mut table = Self {
            capabilities: library.axes().capabilities().count(),
            ..Self::default()
        };
        let features = library.features().iter().count();
        let first = table.capabilities + features;
        for axis in library.axes().iter() {
            let mut values: Vec<_> = axis.values.iter().collect();
            values.sort_by_key(|(name, _)| axis.default.as_deref() != Some(&***name));
            let values = values.into_iter().map(|(name, effect)| {
                let numbers = &effect.numbers;
                let mut gives = numbers.provided.clone();
                for (_, feature) in library.features().iter() {
                    if numbers.features.contains(feature) {
                        gives.insert(table.capabilities + feature);
                    }
                }
                for claim in table.claims_of(numbers) {
                    let next = first + table.claims.len();
                    gives.insert(*table.claims.entry(claim).or_insert(next));
                }
                Value {
                    name: name.clone(),
                    gives,
                    needs: numbers.needed.clone(),
                }
            });
            let values = values.collect();
            table.axes.push(Choices {
                name: library.axes().name(&axis.name),
                has_default: axis.default.is_some(),
                values,
            });
        }
        table
    }

    fn claims_of(&mut self, numbers: &EffectNumbers) -> Vec<Claim> {
        let bound = numbers.bind.iter();
        let mut claims: Vec<_> = bound.map(|&(i, to)| Claim::Bound(i, to)).collect();
        claims.extend(numbers.root.map(Claim::Root));
        if let Some(counting) = &numbers.counting {
            let known = self.countings.iter().position(|known| known == counting);
            claims.push(Claim::Counting(known.unwrap_or_else(|| {
                self.countings.push(counting.clone());
                self.countings.len() - 1
            })));
        }
        claims
    }

    /// All of the space.
    pub(crate) fn whole(&self) -> Part {
        let all = |axis: &Choices| {
            let mut open = FeatureSet::default();
            (0..axis.values.len()).for_each(|value| open.insert(value));
            open
        };
        Part {
            open: self.axes.iter().map(all).collect(),
            required: FeatureSet::default(),
        }
    }

    fn open<'a>(&'a self, part: &'a Part, axis: usize) -> impl Iterator<Item = (usize, &'a Value)> {
        let values = self.axes[axis].values.iter().enumerate();
        values.filter(move |(number, _)| part.open[axis].contains(*number))
    }

    /// Marks that every key of `part` has, and marks that some may have.
    pub(crate) fn marks(&self, part: &Part) -> (FeatureSet, FeatureSet) {
        let (mut certain, mut possible) = (part.required.clone(), FeatureSet::default());
        for axis in 0..self.axes.len() {
            let mut common: Option<FeatureSet> = None;
            for (_, value) in self.open(part, axis) {
                possible.union(&value.gives);
                match &mut common {
                    Some(common) => common.intersect(&value.gives),
                    None => common = Some(value.gives.clone()),
                }
            }
            certain.union(&common.unwrap_or_default());
        }
        (certain, possible)
    }

    /// The features among `marks`.
    pub(crate) fn features(&self, marks: &FeatureSet, count: usize) -> FeatureSet {
        let mut features = FeatureSet::default();
        for feature in (0..count).filter(|feature| marks.contains(self.capabilities + feature)) {
            features.insert(feature);
        }
        features
    }

    /// `part` by the answers to `question`, each with what it answers; parts without a legal key are left out.
    pub(crate) fn split(&self, part: &Part, question: Question) -> Vec<(Option<usize>, Part)> {
        let mut parts = Vec::new();
        let mut claims: Vec<(usize, usize)> = Vec::new();
        match question {
            Question::Feature(feature) => claims.push((feature, self.capabilities + feature)),
            Question::Counting(_) | Question::Root | Question::Binding(_) => {
                for (claim, &mark) in &self.claims {
                    match (*claim, question) {
                        (Claim::Root(to), Question::Root) => claims.push((to, mark)),
                        (Claim::Bound(i, to), Question::Binding(asked)) if i == asked => {
                            claims.push((to, mark));
                        }
                        (Claim::Counting(k), Question::Counting(asked)) if k == asked => {
                            claims.push((k, mark));
                        }
                        _ => {}
                    }
                }
                claims.sort_unstable();
            }
        }
        let mut all = FeatureSet::default();
        claims.iter().for_each(|(_, mark)| all.insert(*mark));
        let answers = claims
            .iter()
            .map(|&(answer, mark)| (Some(answer), Some(mark)));
        for (answer, mark) in answers.chain([(None, None)]) {
            let mut side = part.clone();
            for axis in 0..self.axes.len() {
                let mut open = FeatureSet::default();
                for (number, value) in self.open(part, axis) {
                    let other = claims
                        .iter()
                        .any(|(_, known)| Some(*known) != mark && value.gives.contains(*known));
                    if !other {
                        open.insert(number);
                    }
                }
                side.open[axis] = open;
            }
            if let Some(mark) = mark {
                side.required.insert(mark);
            }
            if self.first(&side).is_some() {
                parts.push((answer, side));
            }
        }
        parts
    }

    /// The first legal choice of `part`: of each axis in turn the first open value that lets the others be chosen.
    pub(crate) fn first(&self, part: &Part) -> Option<Vec<usize>> {
        let mut search = Search::new(self, part);
        let mut chosen = Vec::new();
        let needed = part.required.clone();
        search
            .choose(FeatureSet::default(), needed, &mut chosen)
            .then_some(chosen)
    }

    /// Number of legal keys in `part`.
    pub(crate) fn count(&self, part: &Part) -> u128 {
        let mut search = Search::new(self, part);
        search.count(0, FeatureSet::default(), part.required.clone())
    }

    /// The key of a choice.
    pub(crate) fn key(&self, chosen: &[usize]) -> Key {
        let choices = self.axes.iter().zip(chosen).filter(|(axis, value)| {
            // The default is the first value, and no part of a key.
            **value > 0 || !axis.has_default
        });
        Key::new(choices.map(|(axis, value)| (axis.name.clone(), axis.values[*value].name.clone())))
    }

    /// The part whose keys give `request`'s answers to all that was `found` to be asked.
    pub(crate) fn same(&self, request: &Request, found: &Dependencies, features: usize) -> Part {
        let mut part = self.whole();
        let mut wanted = FeatureSet::default();
        let mut settled = FeatureSet::default();
        for (claim, &mark) in &self.claims {
            let (asked, holds) = match *claim {
                Claim::Root(root) => (true, root == request.root),
                Claim::Bound(i, to) => (
                    found.interfaces.contains(&i),
                    request.bindings.get(&i) == Some(&to),
                ),
                Claim::Counting(k) => (true, request.counting.contains(&self.countings[k])),
            };
            if asked {
                settled.insert(mark);
            }
            if asked && holds {
                wanted.insert(mark);
            }
        }
        for feature in (0..features).filter(|feature| found.consulted.asked.contains(*feature)) {
            settled.insert(self.capabilities + feature);
            if found.consulted.found.contains(feature) {
                wanted.insert(self.capabilities + feature);
            }
        }
        for axis in 0..self.axes.len() {
            let mut open = FeatureSet::default();
            for (number, value) in self.axes[axis].values.iter().enumerate() {
                let mut given = value.gives.clone();
                given.intersect(&settled);
                if wanted.has_all(&given) {
                    open.insert(number);
                }
            }
            part.open[axis] = open;
        }
        part.required = wanted;
        part
    }

    /// Names of the values of `part` that occur in legal keys, by axis.
    pub(crate) fn values(&self, part: &Part) -> BTreeMap<Arc<str>, Vec<Arc<str>>> {
        let axes = self.axes.iter().enumerate().map(|(axis, choices)| {
            let occurs = |number: usize| {
                let mut one = part.clone();
                one.open[axis] = FeatureSet::default();
                one.open[axis].insert(number);
                self.first(&one).is_some()
            };
            let open = self.open(part, axis).filter(|(number, _)| occurs(*number));
            (
                choices.name.clone(),
                open.map(|(_, value)| value.name.clone()).collect(),
            )
        });
        axes.collect()
    }
}

/// A search for legal choices in a part.
struct Search<'a> {
    table: &'a Table,
    part: &'a Part,
    /// Marks that some value of the axes from each on may give.
    later: Vec<FeatureSet>,
    /// Marks that some open value needs, or that are required.
    relevant: FeatureSet,
    /// States without a legal choice.
    dead: HashSet<State>,
    counts: HashMap<State, u128>,
}

/// The next axis, and the relevant marks that are given and that are lacking so far.
type State = (usize, FeatureSet, FeatureSet);

impl<'a> Search<'a> {
    fn new(table: &'a Table, part: &'a Part) -> Self {
        let axes = table.axes.len();
        let mut later = vec![FeatureSet::default(); axes + 1];
        let mut relevant = part.required.clone();
        for axis in (0..axes).rev() {
            later[axis] = later[axis + 1].clone();
            for (_, value) in table.open(part, axis) {
                later[axis].union(&value.gives);
                relevant.union(&value.needs);
            }
        }
        Self {
            table,
            part,
            later,
            relevant,
            dead: HashSet::new(),
            counts: HashMap::new(),
        }
    }

    /// What is given and lacking once `value` is chosen as well; none where later axes cannot give what lacks.
    fn with(
        &self,
        axis: usize,
        value: &Value,
        given: &FeatureSet,
        lacking: &FeatureSet,
    ) -> Option<(FeatureSet, FeatureSet)> {
        let mut given = given.clone();
        let mut own = value.gives.clone();
        own.intersect(&self.relevant);
        given.union(&own);
        let mut lacking = lacking.clone();
        lacking.union(&value.needs);
        lacking.remove_all(&given);
        self.later[axis + 1]
            .has_all(&lacking)
            .then_some((given, lacking))
    }

    fn choose(&mut self, given: FeatureSet, lacking: FeatureSet, chosen: &mut Vec<usize>) -> bool {
        let axis = chosen.len();
        if axis == self.table.axes.len() {
            return true;
        }
        let state = (axis, given, lacking);
        if self.dead.contains(&state) {
            return false;
        }
        let (table, part) = (self.table, self.part);
        for (number, value) in table.open(part, axis) {
            if let Some((given, lacking)) = self.with(axis, value, &state.1, &state.2) {
                chosen.push(number);
                if self.choose(given, lacking, chosen) {
                    return true;
                }
                chosen.pop();
            }
        }
        self.dead.insert(state);
        false
    }

    fn count(&mut self, axis: usize, given: FeatureSet, lacking: FeatureSet) -> u128 {
        if axis == self.table.axes.len() {
            return 1;
        }
        let state = (axis, given, lacking);
        if let Some(count) = self.counts.get(&state) {
            return *count;
        }
        let (table, part) = (self.table, self.part);
        let mut count = 0u128;
        for (_, value) in table.open(part, axis) {
            if let Some((given, lacking)) = self.with(axis, value, &state.1, &state.2) {
                count = count.saturating_add(self.count(axis + 1, given, lacking));
            }
        }
        self.counts.insert(state, count);
        count
    }
}

/// Reads modules under a part of the space.
pub(crate) trait Reader {
    /// The module under the answers so far: what it takes, or the first feature on which it depends and that is
    /// not decided.
    fn read(&self, module: usize, known: &Known) -> Read;
}

/// Features that are enabled, and features that may be.
#[derive(Clone, Debug, Default)]
pub(crate) struct Known {
    pub(crate) certain: FeatureSet,
    pub(crate) possible: FeatureSet,
}

impl Known {
    /// Whether `feature` is enabled, where that is decided.
    pub(crate) fn decided(&self, feature: usize) -> Option<bool> {
        match (
            self.certain.contains(feature),
            self.possible.contains(feature),
        ) {
            (true, _) => Some(true),
            (_, false) => Some(false),
            (false, true) => None,
        }
    }
}

/// Result of reading a module.
pub(crate) enum Read {
    Module(Arc<crate::prepare::Prepared>),
    Undecided(usize),
    Fault(Fault),
}

/// A walk through the space, or a part of it.
#[derive(Clone)]
struct Walk {
    part: Part,
    known: Known,
    seen: BTreeSet<usize>,
    waiting: Vec<usize>,
    /// Interfaces to be bound.
    interfaces: Vec<usize>,
    bound: BTreeSet<usize>,
    /// Which of the first questions comes next: the root, and each count.
    asked: usize,
}

/// Calls `visit` with each permutation of `part`, always in the same order.
pub(crate) fn walk<'a>(
    library: &'a Library,
    part: Part,
    reader: &dyn Reader,
    visit: &mut dyn FnMut(Variant<'a>),
) {
    let table = library.table();
    let features = library.features().iter().count();
    let mut stack = Vec::new();
    if table.first(&part).is_some() {
        stack.push(Walk::new(table, part, features));
    }
    while let Some(mut walk) = stack.pop() {
        match walk.go_on(table, reader) {
            Step::Split(question) => {
                let sides = table.split(&walk.part, question);
                // Last in, first out.
                for (answer, part) in sides.into_iter().rev() {
                    let mut side = Walk {
                        part,
                        ..walk.clone()
                    };
                    side.learn(table, features);
                    match question {
                        Question::Root => side.waiting.extend(answer),
                        Question::Binding(interface) => {
                            side.bound.insert(interface);
                            side.waiting.extend(answer);
                        }
                        Question::Feature(_) | Question::Counting(_) => {}
                    }
                    stack.push(side);
                }
            }
            Step::End(fault) => {
                let Some(chosen) = table.first(&walk.part) else {
                    continue;
                };
                let key = table.key(&chosen);
                visit(Variant {
                    fault: fault.map(|fault| fault.key(&key).into()),
                    key,
                    table,
                    part: walk.part,
                });
            }
        }
    }
}

enum Step {
    Split(Question),
    End(Option<Fault>),
}

impl Walk {
    fn new(table: &Table, part: Part, features: usize) -> Self {
        let mut walk = Self {
            part,
            known: Known::default(),
            seen: BTreeSet::new(),
            waiting: Vec::new(),
            interfaces: Vec::new(),
            bound: BTreeSet::new(),
            asked: 0,
        };
        walk.learn(table, features);
        walk
    }

    fn learn(&mut self, table: &Table, features: usize) {
        let (certain, possible) = table.marks(&self.part);
        self.known = Known {
            certain: table.features(&certain, features),
            possible: table.features(&possible, features),
        };
    }

    /// Reads on, to the next question or to the end.
    fn go_on(&mut self, table: &Table, reader: &dyn Reader) -> Step {
        if self.asked <= table.countings.len() {
            self.asked += 1;
            return Step::Split(match self.asked {
                1 => Question::Root,
                next => Question::Counting(next - 2),
            });
        }
        loop {
            if let Some(interface) = self.interfaces.pop() {
                if !self.bound.contains(&interface) {
                    return Step::Split(Question::Binding(interface));
                }
                continue;
            }
            let Some(&module) = self.waiting.last() else {
                return Step::End(None);
            };
            if self.seen.contains(&module) {
                self.waiting.pop();
                continue;
            }
            match reader.read(module, &self.known) {
                Read::Undecided(feature) => return Step::Split(Question::Feature(feature)),
                Read::Fault(fault) => return Step::End(Some(fault)),
                Read::Module(prepared) => {
                    self.waiting.pop();
                    self.seen.insert(module);
                    self.waiting.extend(&prepared.modules);
                    self.interfaces.extend(&prepared.interfaces);
                }
            }
        }
    }
}
