//! What is reachable, and what of it has any effect.
//!
//! A pass notes things for shadow methods in private variables. Where no method reads one, writing
//! it has no effect, nor has a call that does nothing but write it: both are left out, and what
//! only they led to is never copied.

use naga::{Function, Handle};
use rustc_hash::FxHashSet;

use crate::{
    Cause, Fault,
    link::{Roots, Targets},
    names::Item,
    unit::Facts,
};

/// Calls nested deeper than this are refused: linking, validating and writing a shader recurse.
pub(crate) const DEEPEST_CALLS: usize = 256;

/// A function of a module's unit.
pub(crate) type FunctionId = (usize, Handle<Function>);

/// What is reachable.
#[derive(Debug, Default)]
pub(crate) struct Reach {
    /// The private variables that something reads.
    pub(crate) reads: FxHashSet<Item>,
    /// The functions that have no effect but their result.
    pub(crate) idle: FxHashSet<FunctionId>,
}

pub(crate) fn reach(targets: &mut Targets<'_>, root: usize, roots: Roots) -> Result<Reach, Fault> {
    let mut reach = Reach::default();
    if roots == Roots::Declarations {
        // Everything that is declared is kept: nothing counts as unread.
        return keep_all(targets, root);
    }
    // Reads only become more: what one round finds may keep alive what the next goes through.
    loop {
        let mut walk = Walk {
            targets,
            reads: &reach.reads,
            idle: FxHashSet::default(),
            seen: FxHashSet::default(),
            found: FxHashSet::default(),
        };
        let unit = walk.targets.unit(root)?;
        for facts in &unit.entry_facts {
            walk.visit(root, facts, 0)?;
        }
        let (found, idle) = (walk.found, walk.idle);
        let settled = found == reach.reads;
        reach = Reach { reads: found, idle };
        if settled {
            return Ok(reach);
        }
    }
}

fn keep_all(targets: &mut Targets<'_>, root: usize) -> Result<Reach, Fault> {
    let mut reach = Reach::default();
    let mut seen = FxHashSet::default();
    let mut modules = vec![root];
    while let Some(module) = modules.pop() {
        if !seen.insert(module) {
            continue;
        }
        let unit = targets.unit(module)?;
        reach.reads.extend(unit.globals.values().cloned());
        for handle in unit.functions.keys() {
            if unit.functions[handle].module != module {
                // A stand-in that nothing calls may be of an interface that nothing is bound to.
                let called = unit.facts.iter().chain(&unit.entry_facts);
                if called
                    .flat_map(|facts| &facts.calls)
                    .any(|(callee, _)| callee == handle)
                {
                    modules.push(targets.target((module, *handle))?.0);
                }
            }
        }
    }
    Ok(reach)
}

struct Walk<'a, 'b> {
    targets: &'a mut Targets<'b>,
    reads: &'a FxHashSet<Item>,
    idle: FxHashSet<FunctionId>,
    seen: FxHashSet<FunctionId>,
    found: FxHashSet<Item>,
}

impl Walk<'_, '_> {
    fn visit(&mut self, module: usize, facts: &Facts, depth: usize) -> Result<(), Fault> {
        if depth > DEEPEST_CALLS {
            let message = format!("calls nest more than {DEEPEST_CALLS} deep");
            return Err(Fault::new(Cause::Recursion, message)
                .at(self.targets.library.source(module).place(0..0))
                .note("let functions of this module call fewer of each other"));
        }
        let unit = self.targets.unit(module)?;
        self.found.extend(
            facts
                .reads
                .iter()
                .map(|global| unit.globals[global].clone()),
        );
        for &(callee, unused) in &facts.calls {
            let target = self.targets.target((module, callee))?;
            // A call whose result is used is kept whatever else it does.
            let idle = unused && self.is_idle(target, &mut Vec::new())?;
            if !idle && self.seen.insert(target) {
                let unit = self.targets.unit(target.0)?;
                self.visit(target.0, &unit.facts[target.1.index()], depth + 1)?;
            }
        }
        Ok(())
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
        let unit = self.targets.unit(id.0)?;
        let facts = &unit.facts[id.1.index()];
        if facts.acts
            || facts
                .writes
                .iter()
                .any(|global| self.reads.contains(&unit.globals[global]))
        {
            return Ok(false);
        }
        above.push(id);
        for &(callee, _) in &facts.calls {
            let target = self.targets.target((id.0, callee))?;
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
