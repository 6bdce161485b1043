//! Verdicts by parts, so that no part is checked twice.
//!
//! Whether a permutation is valid depends on its functions, and on each function only so far as its callers see it: by
//! its [`Summary`]. So a function is checked once in each *context*: its text, and the summaries of what it calls.
//! A permutation of which every function stands in a context that was found valid before is valid: it is linked
//! without being validated, and where only its verdict is asked for, it is not linked either. Any other is validated
//! as a whole, and where it proves valid, all its contexts are known from then on. So each fault is found by
//! validating the permutation that has it, and is told as ever.
//!
//! Two things concern a permutation as a whole, and are kept beside the contexts ([`Known`]): how its entry points go
//! together, and implementations that share state.

use std::{
    collections::BTreeSet,
    sync::{Arc, OnceLock, PoisonError, RwLock},
};

use naga::{Expression, Function, Handle, Module, ShaderStage, TypeInner, valid::GlobalUse};
use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::{SmallVec, smallvec};

use crate::{
    Fault, Library, Permutation,
    diagnostics::Places,
    fetches::callees,
    link::{Origins, Targets, with_room},
    names::{Item, ItemNumber},
    permutation::Uses,
    reach::{DEEPEST_CALLS, FunctionId, Program as _, Reach},
    uniformity::{self, Shape},
    unit::Facts,
};

/// Parts of a library's permutations that were found valid for a target.
#[derive(Debug)]
pub(crate) struct Verdicts {
    known: RwLock<Known>,
    /// By module.
    roles: Vec<OnceLock<Vec<Role>>>,
}

/// An interface of which a module declares every function, and the numbers of the functions' names.
type Role = (usize, FxHashSet<u32>);

/// All that was found valid.
#[derive(Debug, Default)]
struct Known {
    /// Functions in contexts, each with its own number and its summary's.
    contexts: FxHashMap<Context, (u32, u32)>,
    summaries: FxHashMap<Arc<Summary>, u32>,
    /// The summaries by their numbers.
    by_number: Vec<Arc<Summary>>,
    /// Entry points of a shader together.
    wholes: FxHashSet<Context>,
}

/// A function or an entry point in a context, in numbers: its unit (by address) and place there, what of it is left
/// out, and the summaries of what it calls. Of a shader: its entry points' summaries.
type Context = SmallVec<[u64; 12]>;

/// Mark of an entry point's place in its unit.
pub(crate) const ENTRY_POINT: u64 = 1 << 32;

/// A valid function as its callers see it.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Summary {
    /// Variables that it uses, directly or not, and how.
    uses: Vec<(ItemNumber, u8)>,
    /// Overrides that it depends on, directly or not.
    overrides: Vec<ItemNumber>,
    /// Stages that may call it.
    stages: u32,
    may_kill: bool,
    dual_source_blending: bool,
    immediates: String,
    uniformity: uniformity::Shape,
    /// The function's very context, where pointers, textures or samplers that it takes let more through.
    exact: Option<Context>,
}

impl Verdicts {
    pub(crate) fn new(library: &Library) -> Self {
        Self {
            known: RwLock::default(),
            roles: library.sources().iter().map(|_| OnceLock::new()).collect(),
        }
    }

    /// Where every part of a permutation is known to be valid: the variables that its entry points use.
    pub(crate) fn known(&self, targets: &Targets<'_>, reach: &Reach) -> Option<Uses> {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let mut trace = Trace::new(self, targets, reach).ok()?;
        let mut look = |_: Which, context: &Context| known.contexts.get(context).copied();
        let whole = trace.whole(&mut look).ok()?;
        let whole = trace.with_kinds(whole, &known.by_number).ok()?;
        if !known.wholes.contains(&whole.context) {
            return None;
        }
        let summaries = whole.summaries.iter();
        let uses = summaries.map(|number| {
            let uses = known.by_number[*number as usize].uses.iter();
            uses.map(|(variable, _)| *variable).collect()
        });
        Some(uses.collect())
    }

    /// Adds all parts of a permutation that was found valid.
    pub(crate) fn learn(
        &self,
        targets: &Targets<'_>,
        reach: &Reach,
        (permutation, origins): (&Permutation, &Origins),
    ) {
        // A warning is the permutation's own, as a fault is.
        if permutation.warnings.is_empty()
            && let Ok(mut trace) = Trace::new(self, targets, reach)
        {
            let mut known = self.known.write().unwrap_or_else(PoisonError::into_inner);
            trace.learn(&mut known, permutation, origins);
        }
    }

    /// Variables that some permutation uses, of those that were found valid.
    pub(crate) fn uses(&self) -> FxHashSet<ItemNumber> {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let uses = known.by_number.iter().flat_map(|summary| &summary.uses);
        uses.map(|(variable, _)| *variable).collect()
    }

    /// Functions and entry points of permutations that were found valid: each the address of its unit, and its effects
    /// among the unit's.
    pub(crate) fn parts(&self) -> FxHashSet<(u64, u64)> {
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let parts = known.contexts.keys();
        parts.map(|context| (context[0], context[1])).collect()
    }

    fn roles(&self, library: &Library, module: usize) -> &[Role] {
        self.roles[module].get_or_init(|| {
            let Ok(own) = library.syntax(module) else {
                return Vec::new();
            };
            let mut roles = Vec::new();
            for &interface in library.interfaces() {
                if let Ok(contract) = library.syntax(interface)
                    && contract.functions.is_subset(&own.functions)
                {
                    let names = contract.functions.iter();
                    roles.push((interface, names.map(|name| library.number(name)).collect()));
                }
            }
            roles
        })
    }
}

/// A function, or an entry point by its place.
#[derive(Clone, Copy)]
enum Which {
    Function(FunctionId),
    EntryPoint(usize),
}

/// A permutation's functions, followed without linking them.
struct Trace<'a> {
    verdicts: &'a Verdicts,
    targets: &'a Targets<'a>,
    reach: &'a Reach,
    /// A number for how fetches are counted.
    counting: u64,
    /// Functions whose fetches are counted, where fetches are counted.
    counted: FxHashSet<FunctionId>,
    /// Contexts so far, and summaries, by function.
    found: FxHashMap<FunctionId, (u32, u32)>,
    under_way: usize,
}

/// Part of a permutation is not known, or cannot be followed: linking tells why.
struct Unknown;

impl From<Fault> for Unknown {
    fn from(_: Fault) -> Self {
        Self
    }
}

/// A permutation's entry points together, and the numbers of their summaries.
struct Whole {
    context: Context,
    summaries: Vec<u32>,
}

impl<'a> Trace<'a> {
    /// Fails where linking would.
    fn new(
        verdicts: &'a Verdicts,
        targets: &'a Targets<'a>,
        reach: &'a Reach,
    ) -> Result<Self, Unknown> {
        let counting = &targets.request.counting;
        let mut trace = Self {
            verdicts,
            targets,
            reach,
            counting: targets.library.table().counting(counting),
            counted: FxHashSet::default(),
            found: with_room(),
            under_way: 0,
        };
        if !counting.is_empty() {
            trace.count()?;
        }
        Ok(trace)
    }

    /// Finds the functions whose fetches are counted, as [`fetches::check`] does.
    fn count(&mut self) -> Result<(), Unknown> {
        let request = self.targets.request;
        let root = self.targets.unit(request.root)?;
        let entries = root.module.entry_points.iter().zip(&root.entry_facts);
        let fragments = entries.filter(|(entry, _)| entry.stage == ShaderStage::Fragment);
        let calls = fragments.flat_map(|(_, facts)| &facts.calls);
        let mut waiting: Vec<_> = calls.map(|(callee, _)| (request.root, *callee)).collect();
        while let Some(called) = waiting.pop() {
            let target = self.targets.target(called)?;
            let mut counting = request.counting.iter();
            if counting.all(|counting| counting.except.contains(&target.0))
                || !self.counted.insert(target)
            {
                continue;
            }
            let unit = self.targets.unit(target.0)?;
            let calls = unit.facts[target.1.index()].calls.iter();
            waiting.extend(calls.map(|(callee, _)| (target.0, *callee)));
        }
        Ok(())
    }

    /// Adds all parts of a permutation that was found valid.
    fn learn(&mut self, known: &mut Known, permutation: &Permutation, origins: &Origins) {
        let module = &permutation.module;
        let Ok(info) = permutation.info() else {
            return;
        };
        let functions = module.functions.iter().zip(&origins.functions);
        let handles: FxHashMap<_, _> = functions.map(|((handle, _), id)| (*id, handle)).collect();
        let library = self.targets.library;
        let places = Places {
            library,
            filters: &origins.filters,
        };
        let Ok(shapes) = uniformity::shapes(module, &places) else {
            return;
        };
        let Known {
            contexts,
            summaries,
            by_number,
            wholes,
        } = known;
        let number = |item: &Item| item.number(library);
        let variables: Vec<_> = origins.owners.iter().map(number).collect();
        let mut learn = |which: Which, context: &Context| {
            if let Some(found) = contexts.get(context) {
                return Some(*found);
            }
            let (function, info, uniformity) = match which {
                Which::Function(id) => {
                    let handle = *handles.get(&id)?;
                    let shape = shapes[handle.index()].clone();
                    (&module.functions[handle], &info[handle], shape)
                }
                Which::EntryPoint(index) => {
                    let function = &module.entry_points[index].function;
                    (function, info.get_entry_point(index), Shape::default())
                }
            };
            let takes_places = function.arguments.iter().any(|argument| {
                let ty = &module.types[argument.ty].inner;
                ty.pointer_space().is_some()
                    || !matches!(
                        ty,
                        TypeInner::Scalar(_)
                            | TypeInner::Vector { .. }
                            | TypeInner::Matrix { .. }
                            | TypeInner::Array { .. }
                            | TypeInner::Struct { .. }
                    )
            });
            let mut used: Vec<_> = (module.global_variables.iter())
                .zip(&variables)
                .filter(|((handle, _), _)| info[*handle] != GlobalUse::empty())
                .map(|((handle, _), item)| (*item, info[handle].bits()))
                .collect();
            used.sort_unstable();
            let summary = Summary {
                uses: used,
                overrides: overrides(module, function, origins, &number),
                stages: info.available_stages.bits().into(),
                may_kill: info.may_kill,
                dual_source_blending: info.dual_source_blending,
                immediates: format!("{:?}", info.immediate_slots_used),
                uniformity,
                exact: takes_places.then(|| context.clone()),
            };
            let summary = Arc::new(summary);
            let number = *summaries.entry(summary.clone()).or_insert_with(|| {
                by_number.push(summary);
                by_number.len() as u32 - 1
            });
            let found = (contexts.len() as u32, number);
            contexts.insert(context.clone(), found);
            Some(found)
        };
        let whole = self.whole(&mut learn);
        if let Ok(whole) = whole.and_then(|whole| self.with_kinds(whole, by_number)) {
            wholes.insert(whole.context);
        }
    }

    /// The permutation's entry points together, from each function's context, for which `settle` gives the numbers of
    /// the context and its summary.
    fn whole(&mut self, settle: Settle<'_>) -> Result<Whole, Unknown> {
        let root = self.targets.request.root;
        let unit = self.targets.unit(root)?;
        let mut summaries = Vec::with_capacity(unit.entry_facts.len());
        for (index, facts) in unit.entry_facts.iter().enumerate() {
            let (_, summary) = self.part(Which::EntryPoint(index), root, facts, settle)?;
            summaries.push(summary);
        }
        let mut context: Context = smallvec![Arc::as_ptr(unit) as u64, self.counting];
        context.extend(summaries.iter().map(|summary| u64::from(*summary)));
        if self.may_share_state() {
            let mut contexts: Vec<_> = self.found.values().map(|(c, _)| u64::from(*c)).collect();
            contexts.sort_unstable();
            context.extend(contexts);
        }
        Ok(Whole { context, summaries })
    }

    /// `whole` with what each variable is that it uses, as far as limits count it: they do so over all of a stage.
    fn with_kinds(&self, mut whole: Whole, by_number: &[Arc<Summary>]) -> Result<Whole, Unknown> {
        for number in &whole.summaries {
            for ((module, name), _) in &by_number[*number as usize].uses {
                let unit = self.targets.look(*module as usize)?;
                let kind = unit.kind(self.targets.library, *name).ok_or(Unknown)?;
                whole.context.push(kind.into());
            }
        }
        Ok(whole)
    }

    fn function(&mut self, id: FunctionId, settle: Settle<'_>) -> Result<u32, Unknown> {
        if let Some((_, summary)) = self.found.get(&id) {
            return Ok(*summary);
        }
        // A circle is a fault, which linking tells.
        if self.under_way > DEEPEST_CALLS {
            return Err(Unknown);
        }
        self.under_way += 1;
        let unit = self.targets.unit(id.0)?;
        let facts = &unit.facts[id.1.index()];
        let found = self.part(Which::Function(id), id.0, facts, settle)?;
        self.under_way -= 1;
        self.found.insert(id, found);
        Ok(found.1)
    }

    fn part(
        &mut self,
        which: Which,
        module: usize,
        facts: &Facts,
        settle: Settle<'_>,
    ) -> Result<(u32, u32), Unknown> {
        let home = self.targets.unit(module)?;
        let unit = Arc::as_ptr(home) as u64;
        let (place, counted) = match which {
            Which::Function(id) => (id.1.index() as u64, self.counted.contains(&id)),
            Which::EntryPoint(index) => (ENTRY_POINT | index as u64, false),
        };
        let mut context: Context = smallvec![unit, place, self.counting << 1 | u64::from(counted)];
        // Stand-ins for other modules' variables and overrides do not tell their initializers and attributes.
        let mut named: BTreeSet<_> = facts.names.union(&home.overriding).copied().collect();
        let mut seen = BTreeSet::from([module]);
        while let Some(other) = named.pop_first() {
            if seen.insert(other) {
                let other = self.targets.look(other)?;
                context.push(Arc::as_ptr(other) as u64);
                named.extend(&other.overriding);
            }
        }
        for chunk in facts.writes.iter().collect::<SmallVec<[_; 8]>>().chunks(64) {
            let dead = chunk.iter().enumerate();
            let dead = dead.filter(|(_, variable)| !self.reach.reads.contains(*variable));
            context.push(dead.map(|(bit, _)| 1 << bit).sum());
        }
        for &(callee, unused) in &facts.calls {
            let target = self.targets.target((module, callee))?;
            let called = home.called[callee.index()].0 as usize;
            if called != module {
                // An implementation's contract is told of with it.
                context.push(match called == target.0 {
                    true => 0,
                    false => Arc::as_ptr(self.targets.unit(called)?) as u64,
                });
            }
            context.push(match unused && self.reach.idle.contains(&target) {
                true => u64::MAX,
                false => self.function(target, settle)?.into(),
            });
        }
        settle(which, &context).ok_or(Unknown)
    }

    /// Whether two functions that implement one interface, or two names for one function, may share state: whether
    /// they do depends on all functions of the permutation.
    fn may_share_state(&self) -> bool {
        let mut implementations: FxHashMap<usize, usize> = FxHashMap::default();
        for (module, function) in self.found.keys() {
            let roles = self.verdicts.roles(self.targets.library, *module);
            if roles.is_empty() {
                continue;
            }
            let Ok(unit) = self.targets.unit(*module) else {
                return true;
            };
            let (_, name) = unit.called[function.index()];
            let roles = roles.iter().filter(|(_, names)| names.contains(&name));
            for (interface, _) in roles {
                if *implementations.entry(*interface).or_insert(*module) != *module {
                    return true;
                }
            }
        }
        let mut callers: FxHashMap<(usize, FunctionId), Handle<Function>> = FxHashMap::default();
        let calls = self.targets.known.borrow();
        let mut names = calls.iter().map(|((caller, name), target)| {
            *callers.entry((*caller, *target)).or_insert(*name) != *name
        });
        names.any(|other| other)
    }
}

/// Gives the numbers of a context and its summary, where it is known.
type Settle<'a> = &'a mut dyn FnMut(Which, &Context) -> Option<(u32, u32)>;

/// Overrides that `function` depends on, directly or not.
fn overrides(
    module: &Module,
    function: &Function,
    origins: &Origins,
    number: &dyn Fn(&Item) -> ItemNumber,
) -> Vec<ItemNumber> {
    if module.overrides.is_empty() {
        return Vec::new();
    }
    let mut waiting = vec![function];
    let mut seen = FxHashSet::default();
    let mut found = BTreeSet::new();
    while let Some(function) = waiting.pop() {
        for (_, expression) in function.expressions.iter() {
            if let Expression::Override(handle) = expression {
                found.extend(origins.overrides.get(handle).map(number));
            }
        }
        let callees = callees(function).into_iter();
        let new = callees.filter(|callee| seen.insert(*callee));
        waiting.extend(new.map(|callee| &module.functions[callee]));
    }
    found.into_iter().collect()
}
