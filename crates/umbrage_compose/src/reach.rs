//! Reach: functions and variables that a shader comes to, and which of them have any effect.
//!
//! A pass notes things for shadow methods in private variables. Where no method reads one, writing
//! it has no effect, nor has a call that does nothing but write it: both are left out, and what
//! only they led to is never copied.

use std::{collections::BTreeSet, sync::Arc};

use naga::{Function, Handle};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::{
    Cause, Fault, Library,
    names::ItemNumber,
    unit::{Facts, Unit},
};

/// Parts of the root module to start from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Roots {
    /// The root module's entry points.
    EntryPoints,
    /// All that the root module declares.
    Declarations,
}

/// Calls nested deeper than this are refused: linking, validating and writing a shader recurse.
pub(crate) const DEEPEST_CALLS: usize = 256;

/// A function of a module's unit.
pub(crate) type FunctionId = (usize, Handle<Function>);

/// Units of a permutation, and what calls in them lead to.
pub(crate) trait Program {
    fn library(&self) -> &Library;

    fn unit(&self, module: usize) -> Result<&Arc<Unit>, Fault>;

    /// A module's number in the library.
    fn module(&self, number: usize) -> usize {
        number
    }

    /// The function that `called`, a function or a stand-in in its module's unit, stands for.
    fn target(&self, called: FunctionId) -> Result<FunctionId, Fault>;

    /// Functions that are called in turn after that one.
    fn further(&self, called: FunctionId) -> Result<Vec<FunctionId>, Fault> {
        let _ = called;
        Ok(Vec::new())
    }
}

/// Reach of a shader's roots.
#[derive(Debug, Default)]
pub(crate) struct Reach {
    /// The private variables that something reads.
    pub(crate) reads: FxHashSet<ItemNumber>,
    /// The functions that have no effect but their result.
    pub(crate) idle: FxHashSet<FunctionId>,
    /// Parts left out, by module.
    pub(crate) left_out: FxHashMap<usize, LeftOut>,
}

/// Parts of a module without effect.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct LeftOut {
    /// Private variables that nothing reads: stores into them are left out.
    pub(crate) stores: BTreeSet<ItemNumber>,
    /// Functions whose calls are left out where the result is unused.
    pub(crate) calls: BTreeSet<Handle<Function>>,
}

pub(crate) fn reach(program: &impl Program, root: usize, roots: Roots) -> Result<Reach, Fault> {
    let mut reach = Reach::default();
    if roots == Roots::Declarations {
        // Everything that is declared is kept: nothing counts as unread.
        return keep_all(program, root);
    }
    // Reads only become more: what one round finds may keep alive what the next goes through.
    loop {
        let mut walk = Walk {
            program,
            reads: &reach.reads,
            asked: FxHashSet::default(),
            idle: FxHashSet::default(),
            seen: FxHashSet::default(),
            found: FxHashSet::default(),
            left_out: FxHashMap::default(),
        };
        let unit = walk.program.unit(root)?;
        for facts in &unit.entry_facts {
            walk.visit(root, facts, 0)?;
        }
        let (asked, found, idle, left_out) = (walk.asked, walk.found, walk.idle, walk.left_out);
        // Another round would go the same way.
        let mut asked = asked.iter();
        let settled =
            asked.all(|variable| found.contains(variable) == reach.reads.contains(variable));
        reach = Reach {
            reads: found,
            idle,
            left_out,
        };
        if settled {
            return Ok(reach);
        }
    }
}

fn keep_all(program: &impl Program, root: usize) -> Result<Reach, Fault> {
    let mut reach = Reach::default();
    let mut seen = FxHashSet::default();
    let mut modules = vec![root];
    while let Some(module) = modules.pop() {
        if !seen.insert(module) {
            continue;
        }
        let unit = program.unit(module)?;
        let library = program.library();
        let globals = unit.globals.iter();
        reach.reads.extend(globals.map(|item| item.number(library)));
        for (handle, _) in unit.module.functions.iter() {
            if unit.functions[handle.index()].module != module {
                // A stand-in that nothing calls may be of an interface that nothing is bound to.
                let called = unit.facts.iter().chain(&unit.entry_facts);
                if called
                    .flat_map(|facts| &facts.calls)
                    .any(|(callee, _)| *callee == handle)
                {
                    modules.push(program.target((module, handle))?.0);
                }
            }
        }
    }
    Ok(reach)
}

struct Walk<'a, P> {
    program: &'a P,
    reads: &'a FxHashSet<ItemNumber>,
    /// Variables of which it mattered whether something reads them.
    asked: FxHashSet<ItemNumber>,
    idle: FxHashSet<FunctionId>,
    seen: FxHashSet<FunctionId>,
    found: FxHashSet<ItemNumber>,
    left_out: FxHashMap<usize, LeftOut>,
}

impl<P: Program> Walk<'_, P> {
    fn visit(&mut self, module: usize, facts: &Facts, depth: usize) -> Result<(), Fault> {
        if depth > DEEPEST_CALLS {
            let message = format!("calls nest more than {DEEPEST_CALLS} deep");
            let module = self.program.module(module);
            return Err(Fault::new(Cause::Recursion, message)
                .at(self.program.library().source(module).place(0..0))
                .note("let functions of this module call fewer of each other"));
        }
        self.found.extend(&facts.reads);
        for variable in &facts.writes {
            if !self.is_read(variable) {
                let left_out = self.left_out.entry(module).or_default();
                left_out.stores.insert(*variable);
            }
        }
        for &(callee, unused) in &facts.calls {
            let target = self.program.target((module, callee))?;
            let further = self.program.further((module, callee))?;
            // A call whose result is used is kept whatever else it does; so are calls in turn.
            let idle = unused && further.is_empty() && self.is_idle(target, &mut Vec::new())?;
            if idle {
                let left_out = self.left_out.entry(module).or_default();
                left_out.calls.insert(callee);
            }
            for target in [target].into_iter().chain(further).filter(|_| !idle) {
                if self.seen.insert(target) {
                    let unit = self.program.unit(target.0)?;
                    self.visit(target.0, &unit.facts[target.1.index()], depth + 1)?;
                }
            }
        }
        Ok(())
    }

    fn is_read(&mut self, variable: &ItemNumber) -> bool {
        self.asked.insert(*variable);
        self.reads.contains(variable)
    }

    /// Whether the function has no effect but its result, if nothing reads but what is known.
    fn is_idle(&mut self, id: FunctionId, above: &mut Vec<FunctionId>) -> Result<bool, Fault> {
        if self.idle.contains(&id) {
            return Ok(true);
        }
        // A circle is an error, told where it is copied.
        if above.contains(&id) || above.len() > DEEPEST_CALLS {
            return Ok(false);
        }
        let unit = self.program.unit(id.0)?;
        let facts = &unit.facts[id.1.index()];
        if facts.acts || facts.writes.iter().any(|variable| self.is_read(variable)) {
            return Ok(false);
        }
        above.push(id);
        for &(callee, _) in &facts.calls {
            if !self.program.further((id.0, callee))?.is_empty() {
                above.pop();
                return Ok(false);
            }
            let target = self.program.target((id.0, callee))?;
            if !self.is_idle(target, above)? {
                above.pop();
                return Ok(false);
            }
        }
        above.pop();
        self.idle.insert(id);
        Ok(true)
    }
}
