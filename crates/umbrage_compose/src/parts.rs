//! Parts of the space of keys: which legal keys lie in a part, and how questions of the linking split it.
//!
//! All is said in numbers. Values of all axes have one numbering, *marks* another: a mark is a thing that values give, one
//! for each capability, each feature, and each claim (a root, a binding, a count of fetches). A [`Part`] is a set of open
//! values and a set of marks that some chosen value must give, so a need of a value and an answer to a question ("this
//! feature is on") are the same thing.

use std::{ops::Range, sync::Arc};

use rustc_hash::{FxHashMap, FxHashSet};

use crate::{
    Axes, Key, Library,
    axes::{Counting, EffectNumbers},
    bits::Bits,
    library::Request,
    project::Dependencies,
};

/// Axes and values of a library.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    axes: Vec<Choices>,
    values: Vec<Value>,
    /// Claims, each with its mark.
    claims: FxHashMap<Claim, usize>,
    /// Answers to each question on which values differ, ascending, each with its mark.
    answers: FxHashMap<Question, Vec<(usize, usize)>>,
    /// Values that give each mark.
    givers: Vec<Bits>,
    /// For each mark that values of one axis alone give, the other values of that axis.
    excluded: Vec<Bits>,
    countings: Vec<Counting>,
    /// Marks below this are capabilities, and those from there on are features.
    first_feature: usize,
    /// Marks from here on are claims.
    first_claim: usize,
}

#[derive(Clone, Debug)]
struct Choices {
    name: Arc<str>,
    has_default: bool,
    /// The default comes first; the others are sorted.
    values: Range<usize>,
}

#[derive(Clone, Debug)]
struct Value {
    name: Arc<str>,
    gives: Bits,
    needs: Bits,
    /// Its demands on the linker.
    numbers: EffectNumbers,
}

/// Asks for one of several modules, or for a count of fetches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Claim {
    Root(usize),
    Bound(usize, usize),
    Counting(usize),
}

/// A set of legal keys.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// Values that its keys may have.
    pub(crate) open: Bits,
    /// Marks that each of its keys has from some value.
    required: Bits,
}

/// A question that the linking asks about a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Question {
    Root,
    Feature(usize),
    Binding(usize),
    Counting(usize),
}

/// A legal key's value of each axis, by number, in the order of the axes.
pub(crate) type Chosen = Vec<usize>;

impl Part {
    /// The keys of both.
    pub(crate) fn and(&self, other: &Self) -> Self {
        let mut both = self.clone();
        both.open.intersect(&other.open);
        both.required.union(&other.required);
        both
    }
}

impl Table {
    pub(crate) fn new(library: &Library) -> Self {
        let first_feature = library.axes().capabilities().count();
        let mut table = Self {
            first_feature,
            first_claim: first_feature + library.features().iter().count(),
            ..Self::default()
        };
        for axis in library.axes().iter() {
            let mut values: Vec<_> = axis.values.iter().collect();
            values.sort_by_key(|(name, _)| axis.default.as_deref() != Some(&***name));
            let first = table.values.len();
            for (name, effect) in values {
                let gives = table.gives(&effect.numbers);
                table.values.push(Value {
                    name: name.clone(),
                    gives,
                    needs: effect.numbers.needed.clone(),
                    numbers: effect.numbers.clone(),
                });
            }
            table.axes.push(Choices {
                name: library.axes().name(&axis.name),
                has_default: axis.default.is_some(),
                values: first..table.values.len(),
            });
        }
        let marks = table.first_claim + table.claims.len();
        let givers = (0..marks).map(|mark| {
            let values = table.values.iter().enumerate();
            let values = values.filter(|(_, value)| value.gives.contains(mark));
            values.map(|(number, _)| number).collect()
        });
        table.givers = givers.collect();
        let excluded = table.givers.iter().map(|givers| {
            let is_giving = |axis: &&Choices| axis.values.clone().any(|v| givers.contains(v));
            let mut giving = table.axes.iter().filter(is_giving);
            match (giving.next(), giving.next()) {
                (Some(axis), None) => axis
                    .values
                    .clone()
                    .filter(|v| !givers.contains(*v))
                    .collect(),
                _ => Bits::default(),
            }
        });
        table.excluded = excluded.collect();
        for (&claim, &mark) in &table.claims {
            let (question, answer) = match claim {
                Claim::Root(to) => (Question::Root, to),
                Claim::Bound(interface, to) => (Question::Binding(interface), to),
                Claim::Counting(counting) => (Question::Counting(counting), counting),
            };
            let answers = table.answers.entry(question).or_default();
            answers.push((answer, mark));
            answers.sort_unstable();
        }
        table
    }

    /// Marks of a value; claims that are new get the next numbers.
    fn gives(&mut self, numbers: &EffectNumbers) -> Bits {
        let mut gives = numbers.provided.clone();
        for feature in numbers.features.iter() {
            gives.insert(self.first_feature + feature);
        }
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
        for claim in claims {
            let next = self.first_claim + self.claims.len();
            gives.insert(*self.claims.entry(claim).or_insert(next));
        }
        gives
    }

    /// All of the space.
    pub(crate) fn whole(&self) -> Part {
        Part {
            open: (0..self.values.len()).collect(),
            required: Bits::default(),
        }
    }

    /// The questions that concern a key before any module is read.
    pub(crate) fn first_questions(&self) -> Vec<Question> {
        let countings = (0..self.countings.len()).map(Question::Counting);
        std::iter::once(Question::Root).chain(countings).collect()
    }

    /// Open values of an axis.
    fn open<'a>(&'a self, part: &'a Part, axis: usize) -> impl Iterator<Item = usize> + 'a {
        let values = self.axes[axis].values.clone();
        values.filter(|value| part.open.contains(*value))
    }

    /// Features that each key of `part` has, and features that some key may have.
    pub(crate) fn features(&self, part: &Part) -> (Bits, Bits) {
        let (mut certain, mut possible) = (part.required.clone(), Bits::default());
        for axis in 0..self.axes.len() {
            let mut open = self.open(part, axis);
            let Some(first) = open.next() else { continue };
            let mut common = self.values[first].gives.clone();
            possible.union(&common);
            for value in open {
                possible.union(&self.values[value].gives);
                common.intersect(&self.values[value].gives);
            }
            certain.union(&common);
        }
        let features = |marks: Bits| {
            let marks = marks.iter();
            let features =
                marks.filter(|mark| (self.first_feature..self.first_claim).contains(mark));
            features.map(|mark| mark - self.first_feature).collect()
        };
        (features(certain), features(possible))
    }

    /// `part`, whose first key is `first`, by the answers to `question`: each answer (none: nothing claims it), the
    /// keys that give it, and the first of them. No legal key gives two answers, which [`Self::contradiction`] sees to.
    pub(crate) fn split(
        &self,
        (part, first): (&Part, &Chosen),
        question: Question,
    ) -> Vec<(Option<usize>, Part, Chosen)> {
        let feature;
        let answers: &[(usize, usize)] = match question {
            Question::Feature(number) => {
                feature = [(number, self.first_feature + number)];
                &feature
            }
            _ => self.answers.get(&question).map_or(&[], Vec::as_slice),
        };
        let mut claimants = Bits::default();
        for (_, mark) in answers {
            claimants.union(&self.givers[*mark]);
        }
        let mut sides = Vec::new();
        let some = answers.iter().map(|&(answer, mark)| Some((answer, mark)));
        for answer in std::iter::once(None).chain(some) {
            let mut side = part.clone();
            let mut others = claimants.clone();
            if let Some((_, mark)) = answer {
                if !side.open.meets(&self.givers[mark]) {
                    continue;
                }
                others.remove_all(&self.givers[mark]);
                others.union(&self.excluded[mark]);
                side.required.insert(mark);
            }
            side.open.remove_all(&others);
            let has_first = first.iter().all(|value| side.open.contains(*value))
                && answer.is_none_or(|(_, mark)| {
                    first.iter().any(|value| self.givers[mark].contains(*value))
                });
            let chosen = match has_first {
                true => Some(first.clone()),
                false => self.first(&side),
            };
            if let Some(chosen) = chosen {
                sides.push((answer.map(|(answer, _)| answer), side, chosen));
            }
        }
        sides
    }

    /// Values of two axes that ask for different roots, or bind one interface to different modules, and that some
    /// legal key has: the question that they answer differently, and the values.
    pub(crate) fn contradiction(&self) -> Option<(Question, [usize; 2])> {
        let mut questions: Vec<_> = self.answers.iter().collect();
        questions.sort_unstable_by_key(|(_, answers)| answers[0]);
        for (&question, answers) in questions {
            if matches!(question, Question::Counting(_)) {
                continue;
            }
            for (index, (_, a)) in answers.iter().enumerate() {
                for (_, b) in &answers[index + 1..] {
                    for a in self.givers[*a].iter() {
                        for b in self.givers[*b].iter() {
                            if self.name(a).0 != self.name(b).0 && self.go_together(a, b) {
                                return Some((question, [a, b]));
                            }
                        }
                    }
                }
            }
        }
        None
    }

    /// The keys of `part` that have `value`.
    pub(crate) fn with(&self, part: &Part, value: usize) -> Part {
        let mut with = part.clone();
        for axis in self.axes.iter().filter(|axis| axis.values.contains(&value)) {
            with.open.remove_all(&axis.values.clone().collect());
        }
        if part.open.contains(value) {
            with.open.insert(value);
        }
        with
    }

    /// Whether a legal key has both values, which are of different axes.
    fn go_together(&self, a: usize, b: usize) -> bool {
        let both = self.with(&self.with(&self.whole(), a), b);
        self.first(&both).is_some()
    }

    /// The first legal key of `part`: of each axis in turn the first open value that lets the others be chosen.
    pub(crate) fn first(&self, part: &Part) -> Option<Chosen> {
        let mut search = Search::new(self, part);
        let mut chosen = Vec::with_capacity(self.axes.len());
        let lacking = part.required.clone();
        let found = search.choose(Bits::default(), lacking, &mut chosen);
        found.then_some(chosen)
    }

    /// Number of a value.
    pub(crate) fn number(&self, axis: &str, value: &str) -> Option<usize> {
        let axis = self.axes.iter().find(|known| *known.name == *axis)?;
        let mut values = axis.values.clone();
        values.find(|number| *self.values[*number].name == *value)
    }

    /// `part` with fewer values of one axis: those that `values` names.
    pub(crate) fn narrow(&self, part: &mut Part, axis: &str, values: &Bits) {
        let axes = self.axes.iter().filter(|known| *known.name == *axis);
        for axis in axes {
            let closed = axis.values.clone().filter(|value| !values.contains(*value));
            part.open.remove_all(&closed.collect());
        }
    }

    /// All values of the axes that `is_fixed` at their defaults.
    pub(crate) fn at_defaults(&self, part: &mut Part, is_fixed: impl Fn(&str) -> bool) {
        for axis in self.axes.iter().filter(|axis| is_fixed(&axis.name)) {
            part.open.remove_all(&axis.values.clone().skip(1).collect());
        }
    }

    /// `key` alone.
    pub(crate) fn only(&self, axes: &Axes, key: &Key) -> Part {
        let values = self.axes.iter().filter_map(|axis| {
            let value = axes.value(key, &axis.name)?;
            self.number(&axis.name, value)
        });
        Part {
            open: values.collect(),
            required: Bits::default(),
        }
    }

    /// The keys of `part` that are not of `other`, which requires no marks, in parts that share no key.
    pub(crate) fn subtract(&self, part: &Part, other: &Part) -> Vec<Part> {
        let mut rest = part.clone();
        let mut pieces = Vec::new();
        for axis in &self.axes {
            let values: Bits = axis.values.clone().collect();
            let mut outside = values.clone();
            outside.remove_all(&other.open);
            if rest.open.meets(&outside) {
                let mut piece = rest.clone();
                let mut inside = values;
                inside.remove_all(&outside);
                piece.open.remove_all(&inside);
                if self.first(&piece).is_some() {
                    pieces.push(piece);
                }
                rest.open.remove_all(&outside);
            }
        }
        pieces
    }

    /// All legal keys of `part`, sorted.
    pub(crate) fn list(&self, part: &Part) -> Vec<Key> {
        let search = Search::new(self, part);
        let mut keys = Vec::new();
        let lacking = part.required.clone();
        search.each(
            (0, Bits::default(), lacking),
            &mut Vec::new(),
            &mut |chosen| {
                keys.push(self.key(chosen));
            },
        );
        keys.sort();
        keys
    }

    /// Axes whose values matter to the keys of `part`: another value may lead out of it.
    fn mattering(&self, part: &Part) -> impl Iterator<Item = usize> {
        let matters = |axis: &usize| {
            let mut values = self.axes[*axis].values.clone();
            values.any(|value| {
                !part.open.contains(value) || self.values[value].gives.meets(&part.required)
            })
        };
        (0..self.axes.len()).filter(matters)
    }

    /// Names of the axes that matter to `part`.
    pub(crate) fn mattering_names(&self, part: &Part) -> impl Iterator<Item = &Arc<str>> {
        self.mattering(part).map(|axis| &self.axes[axis].name)
    }

    /// The values among `chosen` that are of axes which matter to `part`, ascending.
    pub(crate) fn mattering_choices(
        &self,
        part: &Part,
        chosen: &Chosen,
    ) -> impl Iterator<Item = usize> {
        self.mattering(part).map(|axis| chosen[axis])
    }

    /// Number of legal keys in `part`, at most `u128::MAX`.
    pub(crate) fn count(&self, part: &Part) -> u128 {
        let mut search = Search::new(self, part);
        search.count(0, Bits::default(), part.required.clone())
    }

    /// The key of a choice.
    pub(crate) fn key(&self, chosen: &[usize]) -> Key {
        let choices = self.axes.iter().zip(chosen);
        // The default is the first value, and no part of a key.
        let choices =
            choices.filter(|(axis, value)| **value > axis.values.start || !axis.has_default);
        Key::new(choices.map(|(axis, value)| (axis.name.clone(), self.values[*value].name.clone())))
    }

    /// Axis and name of a value.
    pub(crate) fn name(&self, value: usize) -> (&str, &str) {
        let axis = self.axes.iter().find(|axis| axis.values.contains(&value));
        (axis.map_or("", |axis| &axis.name), &self.values[value].name)
    }

    /// Demands of the values `chosen` on the linker; the root is 0 where none of them names one.
    pub(crate) fn request(&self, chosen: &[usize]) -> Request {
        let mut request = Request::default();
        for value in chosen {
            let numbers = &self.values[*value].numbers;
            request.root = numbers.root.unwrap_or(request.root);
            request.bindings.extend(numbers.bind.iter().copied());
            request.features.union(&numbers.features);
            request.counting.extend(numbers.counting.clone());
        }
        request
    }

    /// A number for how fetches are counted.
    pub(crate) fn counting(&self, counting: &[Counting]) -> u64 {
        let known = self.countings.iter().enumerate();
        let known = known.filter(|(_, known)| counting.contains(known));
        known.map(|(bit, _)| 1 << bit).sum()
    }

    /// The keys that give `request`'s answers to all that was `found` to be asked.
    pub(crate) fn same(&self, request: &Request, found: &Dependencies) -> Part {
        let (mut asked, mut given) = (Bits::default(), Bits::default());
        for (claim, &mark) in &self.claims {
            let (is_asked, holds) = match *claim {
                Claim::Root(root) => (true, root == request.root),
                Claim::Bound(interface, to) => (
                    found.interfaces.contains(&interface),
                    request.bindings.get(&interface) == Some(&to),
                ),
                Claim::Counting(k) => (true, request.counting.contains(&self.countings[k])),
            };
            if is_asked {
                asked.insert(mark);
                if holds {
                    given.insert(mark);
                }
            }
        }
        for feature in found.consulted.asked.iter() {
            asked.insert(self.first_feature + feature);
        }
        for feature in found.consulted.found.iter() {
            given.insert(self.first_feature + feature);
        }
        let open = self.values.iter().enumerate().filter(|(_, value)| {
            let mut answers = value.gives.clone();
            answers.intersect(&asked);
            given.has_all(&answers)
        });
        Part {
            open: open.map(|(number, _)| number).collect(),
            required: given,
        }
    }

    /// Names of the values that occur in legal keys of `part`, by axis.
    pub(crate) fn values(&self, part: &Part) -> Vec<(Arc<str>, Vec<Arc<str>>)> {
        let axes = self.axes.iter().enumerate().map(|(axis, choices)| {
            let occurs = |value: &usize| self.first(&self.with(part, *value)).is_some();
            let open = self.open(part, axis).filter(occurs);
            let names = open.map(|value| self.values[value].name.clone());
            (choices.name.clone(), names.collect())
        });
        axes.collect()
    }
}

/// A search for legal keys in a part.
struct Search<'a> {
    table: &'a Table,
    part: &'a Part,
    /// Marks that some open value of the axes from each on gives.
    later: Vec<Bits>,
    /// Marks that some open value needs, or that are required.
    relevant: Bits,
    /// States from which no legal key is reached.
    dead: FxHashSet<State>,
    counts: FxHashMap<State, u128>,
}

/// The next axis, and the relevant marks that are given and that are lacking so far.
type State = (usize, Bits, Bits);

impl<'a> Search<'a> {
    fn new(table: &'a Table, part: &'a Part) -> Self {
        let axes = table.axes.len();
        let mut later = vec![Bits::default(); axes + 1];
        let mut relevant = part.required.clone();
        for axis in (0..axes).rev() {
            later[axis] = later[axis + 1].clone();
            for value in table.open(part, axis) {
                later[axis].union(&table.values[value].gives);
                relevant.union(&table.values[value].needs);
            }
        }
        Self {
            table,
            part,
            later,
            relevant,
            dead: FxHashSet::default(),
            counts: FxHashMap::default(),
        }
    }

    /// Marks given and lacking once `value` is chosen as well; none where later axes cannot give what lacks.
    fn with(&self, axis: usize, value: usize, state: &State) -> Option<(Bits, Bits)> {
        let value = &self.table.values[value];
        let mut given = value.gives.clone();
        given.intersect(&self.relevant);
        given.union(&state.1);
        let mut lacking = state.2.clone();
        lacking.union(&value.needs);
        lacking.remove_all(&given);
        let reachable = self.later[axis + 1].has_all(&lacking);
        reachable.then_some((given, lacking))
    }

    fn choose(&mut self, given: Bits, lacking: Bits, chosen: &mut Chosen) -> bool {
        let axis = chosen.len();
        if axis == self.table.axes.len() {
            return true;
        }
        let state = (axis, given, lacking);
        if self.dead.contains(&state) {
            return false;
        }
        let (table, part) = (self.table, self.part);
        for value in table.open(part, axis) {
            if let Some((given, lacking)) = self.with(axis, value, &state) {
                chosen.push(value);
                if self.choose(given, lacking, chosen) {
                    return true;
                }
                chosen.pop();
            }
        }
        self.dead.insert(state);
        false
    }

    /// Calls `visit` with each legal key.
    fn each(&self, state: State, chosen: &mut Chosen, visit: &mut dyn FnMut(&Chosen)) {
        let axis = state.0;
        if axis == self.table.axes.len() {
            return visit(chosen);
        }
        for value in self.table.open(self.part, axis) {
            if let Some((given, lacking)) = self.with(axis, value, &state) {
                chosen.push(value);
                self.each((axis + 1, given, lacking), chosen, visit);
                chosen.pop();
            }
        }
    }

    fn count(&mut self, axis: usize, given: Bits, lacking: Bits) -> u128 {
        if axis == self.table.axes.len() {
            return 1;
        }
        let state = (axis, given, lacking);
        if let Some(count) = self.counts.get(&state) {
            return *count;
        }
        let (table, part) = (self.table, self.part);
        let mut count = 0u128;
        for value in table.open(part, axis) {
            if let Some((given, lacking)) = self.with(axis, value, &state) {
                count = count.saturating_add(self.count(axis + 1, given, lacking));
            }
        }
        self.counts.insert(state, count);
        count
    }
}
