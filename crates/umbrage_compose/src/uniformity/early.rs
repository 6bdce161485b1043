//! The common case, decided without a graph: every operation that demands uniform control flow stands where its
//! function has not branched yet, and so does every call of a function with such operations. Control flow there is that
//! of the entry point's start.

use naga::{Block, Function, Module, Statement};

use super::{Demand, blocks};

/// Demands of a function on its control flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Demands {
    None,
    /// All of them stand where nothing has branched.
    Early,
    /// Only the graph decides.
    Open,
}

/// Whether all demands of the module stand where nothing has branched. Where not, they may be met all the same.
pub(super) fn all_early(module: &Module) -> bool {
    // Callees come before their callers.
    let mut known = Vec::with_capacity(module.functions.len());
    for (_, function) in module.functions.iter() {
        let demands = demands(function, &known);
        if demands == Demands::Open {
            return false;
        }
        known.push(demands);
    }
    let mut entries = module.entry_points.iter();
    entries.all(|entry| demands(&entry.function, &known) != Demands::Open)
}

fn demands(function: &Function, known: &[Demands]) -> Demands {
    let mut walk = Walk {
        function,
        known,
        found: Demands::None,
        returned: false,
    };
    walk.block(&function.body, false);
    walk.found
}

struct Walk<'a> {
    function: &'a Function,
    known: &'a [Demands],
    found: Demands,
    /// Whether some invocations may have returned already.
    returned: bool,
}

impl Walk<'_> {
    /// Walks `block`, which is entered by some invocations alone where control flow has `branched`.
    fn block(&mut self, block: &Block, branched: bool) {
        for statement in block.iter() {
            match statement {
                Statement::Emit(range) => {
                    let expressions = &self.function.expressions;
                    let mut emitted = range.clone();
                    if emitted.any(|e| Demand::of_expression(&expressions[e]).is_some()) {
                        self.demand(branched);
                    }
                }
                Statement::ControlBarrier(_) => self.demand(branched),
                Statement::Call { function, .. } => match self.known.get(function.index()) {
                    Some(Demands::None) => {}
                    Some(Demands::Early) => self.demand(branched),
                    _ => self.demand(true),
                },
                Statement::Return { .. } => self.returned = true,
                Statement::Block(inner) => self.block(inner, branched),
                _ => {
                    // It may demand something of its operands as well.
                    if Demand::of_statement(statement).is_some() {
                        self.demand(true);
                    }
                    for inner in blocks(statement) {
                        self.block(inner, true);
                    }
                }
            }
        }
    }

    fn demand(&mut self, branched: bool) {
        let open = branched || self.returned || self.found == Demands::Open;
        self.found = if open { Demands::Open } else { Demands::Early };
    }
}
