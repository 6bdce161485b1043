//! Checking many permutations, each part once.
//!
//! Whether a permutation is valid depends on its functions, and on each function only so far as its callers see it: by
//! its [`Summary`]. So a function is checked once in each *context*: its text, and the summaries of what it calls.
//! A permutation of which every function stands in a context that was found valid before is valid, and is not linked.
//! Any other is composed as always, and where it proves valid, all its contexts are known from then on. So each fault
//! is found by composing the permutation that has it, and is told as ever.
//!
//! Three things concern a permutation as a whole, and are kept beside the contexts ([`Known`]): how its entry points
//! go together, implementations that do not fit their interface, and implementations that share state.

use std::{
    cell::RefCell,
    collections::BTreeSet,
    sync::{Arc, OnceLock, PoisonError, RwLock},
};

use naga::{Expression, Function, Handle, Module, ShaderStage, TypeInner, valid::GlobalUse};
use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};
use smallvec::{SmallVec, smallvec};

use crate::{
    Cause, Composer, Error, Fault, Library, Permutation, Variant,
    bits::Bits,
    composer::Entry,
    diagnostics::Places,
    fetches::callees,
    library::Request,
    link::{Origins, Roots},
    names::{Item, ItemNumber},
    reach::{DEEPEST_CALLS, FunctionId, Program, Reach, reach},
    uniformity::{self, Shape},
    unit::{Facts, Unit},
};

/// Checks permutations of a composer's library, and remembers what it found valid.
#[derive(Debug)]
pub struct Checker<'a> {
    composer: &'a Composer,
    known: RwLock<Known>,
    roles: Vec<OnceLock<Vec<Role>>>,
    interfaces: Bits,
    /// Modules with assertions, which are checked wherever anything is taken from them.
    asserting: Bits,
}

/// An interface of which a module declares every function, and the numbers of the functions' names.
type Role = (usize, FxHashSet<u32>);

/// Outcome of checking a permutation.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The first fault, where there is one.
    pub fault: Option<Error>,
    /// Warnings about the permutation.
    pub warnings: Vec<String>,
    /// Whether it was composed, because some part of it was new or has a fault or a warning.
    pub composed: bool,
}

/// All that was found valid.
#[derive(Debug, Default)]
struct Known {
    /// Functions in contexts, each with its own number and its summary's.
    contexts: FxHashMap<Context, (u32, u32)>,
    summaries: FxHashMap<Summary, u32>,
    /// Entry points of a shader together.
    wholes: FxHashSet<Context>,
    /// Interfaces and implementations that fit them.
    pairs: FxHashSet<(usize, usize)>,
}

/// A function or an entry point in a context, in numbers: its unit (by address) and place there, what of it is left
/// out, and the summaries of what it calls. Of a shader: its entry points' summaries.
type Context = SmallVec<[u64; 12]>;

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

impl<'a> Checker<'a> {
    /// A checker of `composer`'s permutations.
    pub fn new(composer: &'a Composer) -> Self {
        let sources = composer.library().sources();
        let asserting = sources.iter().enumerate();
        let asserting = asserting.filter(|(_, source)| source.has_assertions());
        Self {
            composer,
            known: RwLock::default(),
            roles: sources.iter().map(|_| OnceLock::new()).collect(),
            interfaces: composer.library().interfaces().iter().copied().collect(),
            asserting: asserting.map(|(module, _)| module).collect(),
        }
    }

    /// Checks a permutation, as [`Composer::compose`] would, but without making it where all its parts are known.
    pub fn check(&self, variant: &Variant<'_>) -> Checked {
        if let Some(fault) = variant.fault() {
            return Checked {
                fault: Some(fault),
                warnings: Vec::new(),
                composed: false,
            };
        }
        let request = variant.request();
        let trace = || Trace::new(self, &request, variant);
        if let Ok(mut trace) = trace() {
            let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
            if trace.is_known(&known) {
                return Checked {
                    fault: None,
                    warnings: Vec::new(),
                    composed: false,
                };
            }
        }
        match (self.composer).make(&request, variant.module_numbers(), variant.key()) {
            Ok((permutation, origins)) => {
                // A warning is the permutation's own, as a fault is.
                if permutation.warnings.is_empty()
                    && let Ok(mut trace) = trace()
                {
                    let mut known = self.known.write().unwrap_or_else(PoisonError::into_inner);
                    trace.learn(&mut known, &permutation, &origins);
                }
                Checked {
                    fault: None,
                    warnings: permutation.warnings,
                    composed: true,
                }
            }
            Err(fault) => Checked {
                fault: Some(fault.key(&variant.key()).into()),
                warnings: Vec::new(),
                composed: true,
            },
        }
    }

    fn roles(&self, module: usize) -> &[Role] {
        self.roles[module].get_or_init(|| {
            let library = self.composer.library();
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
    checker: &'a Checker<'a>,
    request: &'a Request,
    /// Modules as they were read.
    entries: Vec<Option<&'a Entry>>,
    targets: RefCell<FxHashMap<FunctionId, FunctionId>>,
    /// Units of interfaces, and of what is bound to them.
    pairs: RefCell<FxHashSet<(usize, usize)>>,
    reach: Reach,
    /// Functions whose fetches are counted, where fetches are counted.
    counted: FxHashSet<FunctionId>,
    /// Contexts so far, and summaries, by function.
    found: FxHashMap<FunctionId, (u32, u32)>,
    under_way: usize,
}

impl Program for Trace<'_> {
    fn library(&self) -> &Library {
        self.checker.composer.library()
    }

    fn unit(&self, module: usize) -> Result<&Arc<Unit>, Fault> {
        let entry = self.entries[module].ok_or_else(Self::doubt)?;
        self.checker.composer.unit(module, entry)
    }

    fn target(&self, called: FunctionId) -> Result<FunctionId, Fault> {
        let (home, name) = self.unit(called.0)?.called[called.1.index()];
        let mut home = home as usize;
        if home == called.0 {
            return Ok(called);
        }
        if let Some(target) = self.targets.borrow().get(&called) {
            return Ok(*target);
        }
        if self.checker.interfaces.contains(home) {
            let bound = self.request.bindings.get(&home);
            let bound = *bound.ok_or_else(Self::doubt)?;
            if bound != home {
                let units = [self.unit(home)?, self.unit(bound)?];
                let [interface, implementation] = units.map(|unit| Arc::as_ptr(unit) as usize);
                let mut pairs = self.pairs.borrow_mut();
                pairs.insert((interface, implementation));
            }
            home = bound;
        }
        let function = self.unit(home)?.by_number.get(&name);
        let target = (home, *function.ok_or_else(Self::doubt)?);
        self.targets.borrow_mut().insert(called, target);
        Ok(target)
    }
}

impl<'a> Trace<'a> {
    /// Follows the functions of `variant`, for which `request` asks. Fails where composing would, or may.
    fn new(
        checker: &'a Checker<'a>,
        request: &'a Request,
        variant: &'a Variant<'_>,
    ) -> Result<Self, Fault> {
        let mut trace = Self {
            checker,
            request,
            entries: vec![None; checker.roles.len()],
            targets: RefCell::new(with_room()),
            pairs: RefCell::default(),
            reach: Reach::default(),
            counted: FxHashSet::default(),
            found: with_room(),
            under_way: 0,
        };
        for (module, entry) in variant.entries() {
            trace.entries[module] = Some(entry);
        }
        let mut asserting = variant.module_numbers().clone();
        asserting.intersect(&checker.asserting);
        for module in asserting.iter() {
            trace.unit(module)?;
        }
        trace.reach = reach(&trace, request.root, Roots::EntryPoints)?;
        if !request.counting.is_empty() {
            trace.count()?;
        }
        Ok(trace)
    }

    /// Fault that is never told: composing tells of the true one.
    fn doubt() -> Fault {
        Fault::new(Cause::Validation, "to be composed")
    }

    /// Finds the functions whose fetches are counted, as [`fetches::check`] does.
    fn count(&mut self) -> Result<(), Fault> {
        let root = self.unit(self.request.root)?.clone();
        let entries = root.module.entry_points.iter().zip(&root.entry_facts);
        let fragments = entries.filter(|(entry, _)| entry.stage == ShaderStage::Fragment);
        let calls = fragments.flat_map(|(_, facts)| &facts.calls);
        let mut waiting: Vec<_> = calls
            .map(|(callee, _)| (self.request.root, *callee))
            .collect();
        while let Some(called) = waiting.pop() {
            let target = self.target(called)?;
            let mut counting = self.request.counting.iter();
            if counting.all(|counting| counting.except.contains(&target.0))
                || !self.counted.insert(target)
            {
                continue;
            }
            let unit = self.unit(target.0)?.clone();
            let calls = unit.facts[target.1.index()].calls.iter();
            waiting.extend(calls.map(|(callee, _)| (target.0, *callee)));
        }
        Ok(())
    }

    /// Whether every part is known to be valid.
    fn is_known(&mut self, known: &Known) -> bool {
        let mut look = |_: Which, context: &Context| known.contexts.get(context).copied();
        let whole = self.whole(&mut look);
        whole.is_ok_and(|whole| known.wholes.contains(&whole))
            && known.pairs.is_superset(&self.pairs.borrow())
    }

    /// Adds all parts of a permutation that was found valid.
    fn learn(&mut self, known: &mut Known, permutation: &Permutation, origins: &Origins) {
        let (module, info) = (&permutation.module, &permutation.info);
        let functions = origins.functions.iter();
        let handles: FxHashMap<_, _> = functions.map(|(handle, id)| (*id, *handle)).collect();
        let library = self.library().clone();
        let places = Places {
            library: &library,
            filters: &origins.filters,
        };
        let Ok(shapes) = uniformity::shapes(module, &places) else {
            return;
        };
        let Known {
            contexts,
            summaries,
            ..
        } = known;
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
            let number = |item: &Item| item.number(&library);
            let mut uses: Vec<_> = (module.global_variables.iter())
                .map(|(handle, _)| (handle, info[handle]))
                .filter(|(_, used)| *used != GlobalUse::empty())
                .filter_map(|(handle, used)| {
                    Some((number(origins.owners.get(&handle)?), used.bits()))
                })
                .collect();
            uses.sort_unstable();
            let summary = Summary {
                uses,
                overrides: overrides(module, function, origins, &number),
                stages: info.available_stages.bits().into(),
                may_kill: info.may_kill,
                dual_source_blending: info.dual_source_blending,
                immediates: format!("{:?}", info.immediate_slots_used),
                uniformity,
                exact: takes_places.then(|| context.clone()),
            };
            let next = summaries.len() as u32;
            let summary = *summaries.entry(summary).or_insert(next);
            let found = (contexts.len() as u32, summary);
            contexts.insert(context.clone(), found);
            Some(found)
        };
        if let Ok(whole) = self.whole(&mut learn) {
            known.wholes.insert(whole);
            known.pairs.extend(self.pairs.borrow().iter());
        }
    }

    /// The permutation's entry points together, from each function's context, for which `settle` gives the numbers of
    /// the context and its summary.
    fn whole(&mut self, settle: Settle<'_>) -> Result<Context, Fault> {
        let root = self.request.root;
        let unit = self.unit(root)?.clone();
        let mut whole: Context = smallvec![Arc::as_ptr(&unit) as u64, self.flags()];
        for index in 0..unit.entry_facts.len() {
            let which = Which::EntryPoint(index);
            let (_, summary) = self.part(which, root, &unit.entry_facts[index], settle)?;
            whole.push(summary.into());
        }
        if self.may_share_state() {
            let mut contexts: Vec<_> = self.found.values().map(|(c, _)| u64::from(*c)).collect();
            contexts.sort_unstable();
            whole.extend(contexts);
        }
        Ok(whole)
    }

    /// Part of each context that is about the whole permutation: whether anything is left out, so that all that is unused
    /// is, and how fetches are counted.
    fn flags(&self) -> u64 {
        let table = self.library().table();
        table.counting(&self.request.counting) << 1 | u64::from(self.reach.left_out)
    }

    fn function(&mut self, id: FunctionId, settle: Settle<'_>) -> Result<u32, Fault> {
        if let Some((_, summary)) = self.found.get(&id) {
            return Ok(*summary);
        }
        // A circle is a fault, which composing tells.
        if self.under_way > DEEPEST_CALLS {
            return Err(Self::doubt());
        }
        self.under_way += 1;
        let unit = self.unit(id.0)?.clone();
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
    ) -> Result<(u32, u32), Fault> {
        let unit = Arc::as_ptr(self.unit(module)?) as u64;
        let (place, counted) = match which {
            Which::Function(id) => (id.1.index() as u64, self.counted.contains(&id)),
            Which::EntryPoint(index) => (1 << 32 | index as u64, false),
        };
        let mut context: Context = smallvec![unit, place, self.flags() << 1 | u64::from(counted)];
        for chunk in facts.writes.iter().collect::<SmallVec<[_; 8]>>().chunks(64) {
            let dead = chunk.iter().enumerate();
            let dead = dead.filter(|(_, variable)| !self.reach.reads.contains(*variable));
            context.push(dead.map(|(bit, _)| 1 << bit).sum());
        }
        for &(callee, unused) in &facts.calls {
            let target = self.target((module, callee))?;
            context.push(match unused && self.reach.idle.contains(&target) {
                true => u64::MAX,
                false => self.function(target, settle)?.into(),
            });
        }
        settle(which, &context).ok_or_else(Self::doubt)
    }

    /// Whether two functions that implement one interface, or two names for one function, may share state: whether
    /// they do depends on all functions of the permutation.
    fn may_share_state(&self) -> bool {
        let mut implementations: FxHashMap<usize, usize> = FxHashMap::default();
        for (module, function) in self.found.keys() {
            let roles = self.checker.roles(*module);
            if roles.is_empty() {
                continue;
            }
            let Ok(unit) = self.unit(*module) else {
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
        let mut callers: FxHashMap<(usize, FunctionId), Handle<Function>> = with_room();
        let targets = self.targets.borrow();
        let calls = targets
            .iter()
            .filter(|(called, target)| called.0 != target.0);
        let mut names = calls.map(|((caller, name), target)| {
            *callers.entry((*caller, *target)).or_insert(*name) != *name
        });
        names.any(|other| other)
    }
}

/// A map with room for the functions of a large shader: growing it bit by bit takes as long as filling it.
fn with_room<K, V>() -> FxHashMap<K, V> {
    FxHashMap::with_capacity_and_hasher(256, FxBuildHasher)
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
