//! Walk through a function's body that builds its graph.

mod values;

use naga::{
    AddressSpace, Block, CollectiveOperation, EntryPoint, Expression, Function, GatherMode, Handle,
    Span, Statement, SwitchCase, diagnostic_filter::Severity,
};
use rustc_hash::FxHashMap;

pub(crate) use values::for_each_operand;
use values::{differs, space};

use super::{
    Cause, CauseKind, Check, Demand, Part, Requirement, Scope, What, blocks,
    graph::{DIFFERS, DIFFERS_IN_WORKGROUP, Graph, Node, START, UNIFORM},
    uniform_operand,
};

/// Ways in which execution may leave a statement: <https://www.w3.org/TR/WGSL/#behaviors>.
type Behaviors = u8;
const NEXT: Behaviors = 1;
const BREAK: Behaviors = 2;
const CONTINUE: Behaviors = 4;
const RETURN: Behaviors = 8;

/// Index of a variable of the function, or of a parameter that points to a caller's variable.
type Variable = usize;

pub(super) struct Walk<'a> {
    check: &'a Check<'a>,
    function: &'a Function,
    entry: Option<&'a EntryPoint>,
    pub(super) graph: Graph,
    pub(super) requirements: Vec<Requirement>,
    pub(super) result: Node,
    /// Contents after the call, for each parameter that points to a function's variable.
    pub(super) after: Vec<Option<Node>>,
    /// Inputs of an entry point, whose values no caller chooses.
    inputs: Vec<Node>,
    /// Values by the expressions' indices.
    values: Vec<Node>,
    /// Value of each variable at the current statement.
    held: Vec<Node>,
    /// Values of variables before each assignment, oldest first.
    log: Vec<(Variable, Node)>,
    /// Loops and switches around the current statement, outermost first.
    around: Vec<Around>,
    /// Variables assigned in each loop and switch, by the address of its first block.
    set_within: FxHashMap<*const Block, Vec<Variable>>,
    /// Scratch space: whether each variable was seen.
    seen: Vec<bool>,
}

/// A loop or a switch around the current statement.
struct Around {
    is_loop: bool,
    /// Variables assigned within, each with its value after the loop or switch.
    exits: Vec<(Variable, Node)>,
    /// The same variables, each with its value at the start of a loop's `continuing` block.
    continues: Vec<(Variable, Node)>,
}

/// Root of a pointer: the variable or memory that it leads into.
#[derive(Clone, Copy)]
enum Root {
    Variable(Variable),
    /// Read-only memory, with the same contents for all invocations.
    Constant,
    /// Memory that invocations share, or that outlives the function's call.
    Outside,
}

impl<'a> Walk<'a> {
    pub(super) fn new(
        check: &'a Check<'a>,
        function: &'a Function,
        entry: Option<&'a EntryPoint>,
    ) -> Self {
        let mut graph = Graph::new(function.arguments.len());
        let arguments = function.arguments.iter().enumerate();
        let inputs = match entry {
            Some(entry) => arguments
                .map(|(index, argument)| {
                    match differs(check, entry.stage, argument.binding.as_ref(), argument.ty) {
                        UNIFORM => UNIFORM,
                        differs => graph.node_on(What::Input(index as u32), [differs]),
                    }
                })
                .collect(),
            None => Vec::new(),
        };
        let result = graph.node(What::Other);
        let locals = function.local_variables.len();
        let held = std::iter::repeat_n(UNIFORM, locals)
            .chain((0..function.arguments.len()).map(Graph::contents_of))
            .collect::<Vec<_>>();
        let after = function
            .arguments
            .iter()
            .map(|argument| {
                (space(&check.module.types[argument.ty].inner) == Some(AddressSpace::Function))
                    .then(|| graph.node(What::Other))
            })
            .collect();
        Self {
            check,
            function,
            entry,
            graph,
            requirements: Vec::new(),
            result,
            after,
            inputs,
            values: vec![UNIFORM; function.expressions.len()],
            seen: vec![false; held.len()],
            held,
            log: Vec::new(),
            around: Vec::new(),
            set_within: FxHashMap::default(),
        }
    }

    pub(super) fn run(mut self) -> Self {
        for (handle, expression) in self.function.expressions.iter() {
            if let Expression::FunctionArgument(index) = expression {
                self.values[handle.index()] = match self.entry {
                    Some(_) => self.inputs[*index as usize],
                    None => Graph::value_of(*index as usize),
                };
            }
        }
        let body = &self.function.body;
        self.note_set(body);
        let (_, behaviors) = self.block(body, START);
        if behaviors & NEXT != 0 {
            self.leave();
        }
        self
    }

    /// Variables assigned in `block`. Notes those of the loops and switches in it on the way.
    fn note_set(&mut self, block: &Block) -> Vec<Variable> {
        let mut set = Vec::new();
        for statement in block.iter() {
            match statement {
                Statement::Store { pointer, .. } => {
                    if let (Root::Variable(variable), _) = self.root(*pointer) {
                        set.push(variable);
                    }
                }
                Statement::Call { arguments, .. } => {
                    set.extend(arguments.iter().filter_map(
                        |argument| match self.root(*argument) {
                            (Root::Variable(variable), _) => Some(variable),
                            _ => None,
                        },
                    ));
                }
                _ => {}
            }
            let inner = blocks(statement);
            let Some(first) = inner.first().copied() else {
                continue;
            };
            let mut within = Vec::new();
            for block in inner {
                within.extend(self.note_set(block));
            }
            within.sort_unstable();
            within.dedup();
            if matches!(statement, Statement::Loop { .. } | Statement::Switch { .. }) {
                self.set_within.insert(first, within.clone());
            }
            set.extend(within);
        }
        set
    }

    /// Walks through `block` in the control flow `flow`. Returns the control flow after it, and how execution may
    /// leave it.
    fn block(&mut self, block: &'a Block, mut flow: Node) -> (Node, Behaviors) {
        let mut behaviors = NEXT;
        for (statement, span) in block.span_iter() {
            let (after, may) = self.statement(statement, *span, flow);
            flow = after;
            behaviors = behaviors & !NEXT | may;
            // The rest of the block is unreachable.
            if may & NEXT == 0 {
                break;
            }
        }
        (flow, behaviors)
    }

    fn statement(&mut self, statement: &'a Statement, span: Span, flow: Node) -> (Node, Behaviors) {
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    self.values[handle.index()] = self.evaluate(handle, flow);
                }
            }
            Statement::Block(block) => return self.block(block, flow),
            Statement::If {
                condition,
                accept,
                reject,
            } => return self.branch(*condition, [accept, reject], span, flow),
            Statement::Switch { selector, cases } => {
                return self.switch(*selector, cases, span, flow);
            }
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => return self.repeat((body, continuing, *break_if), span, flow),
            Statement::Break => {
                if let Some(around) = self.around.pop() {
                    self.flow_to(&around.exits);
                    self.around.push(around);
                }
                return (flow, BREAK);
            }
            Statement::Continue => {
                if let Some(index) = self.around.iter().rposition(|around| around.is_loop) {
                    let continues = std::mem::take(&mut self.around[index].continues);
                    self.flow_to(&continues);
                    self.around[index].continues = continues;
                }
                return (flow, CONTINUE);
            }
            Statement::Return { value } => {
                if let Some(value) = value {
                    let value = self.value(*value);
                    self.graph.edge(self.result, value);
                    self.graph.edge(self.result, flow);
                }
                self.leave();
                return (flow, RETURN);
            }
            Statement::Store { pointer, value } => {
                let stored = self.value(*value);
                self.store(*pointer, stored, flow);
            }
            Statement::Call {
                function,
                arguments,
                result,
            } => self.call(*function, arguments, *result, span, flow),
            Statement::WorkGroupUniformLoad { pointer, result } => {
                self.demand(Demand::BARRIER, span, flow);
                let pointer = self.value(*pointer);
                self.demand_of_operand(Demand::BARRIER, 0, pointer, span, flow);
                self.define(*result, [pointer, flow]);
            }
            Statement::Atomic { result, .. } => {
                if let Some(result) = result {
                    self.define(*result, [DIFFERS]);
                }
            }
            Statement::SubgroupBallot { result, predicate } => {
                self.demand(Demand::SUBGROUP, span, flow);
                let predicate = predicate.map_or(UNIFORM, |predicate| self.value(predicate));
                self.define(*result, [DIFFERS_IN_WORKGROUP, predicate, flow]);
            }
            Statement::SubgroupCollectiveOperation {
                collective_op,
                argument,
                result,
                ..
            } => {
                self.demand(Demand::SUBGROUP, span, flow);
                let differs = match collective_op {
                    CollectiveOperation::Reduce => DIFFERS_IN_WORKGROUP,
                    _ => DIFFERS,
                };
                self.define(*result, [differs, self.value(*argument), flow]);
            }
            Statement::SubgroupGather {
                mode,
                argument,
                result,
            } => {
                self.demand(Demand::SUBGROUP, span, flow);
                if let Some(operand) = uniform_operand(*mode) {
                    let operand = self.value(operand);
                    self.demand_of_operand(Demand::SUBGROUP, 1, operand, span, flow);
                }
                let differs = match mode {
                    GatherMode::BroadcastFirst | GatherMode::Broadcast(_) => DIFFERS_IN_WORKGROUP,
                    _ => DIFFERS,
                };
                self.define(*result, [differs, self.value(*argument), flow]);
            }
            Statement::RayQuery {
                fun: naga::RayQueryFunction::Proceed { result },
                ..
            } => self.define(*result, [DIFFERS]),
            other => {
                if let Some(demand) = Demand::of_statement(other) {
                    self.demand(demand, span, flow);
                }
            }
        }
        (flow, NEXT)
    }

    fn branch(
        &mut self,
        condition: Handle<Expression>,
        branches: [&'a Block; 2],
        span: Span,
        flow: Node,
    ) -> (Node, Behaviors) {
        let parted = self.part(condition, span, flow);
        let start = self.log.len();
        let (accepted, may_accept) = self.block(branches[0], parted);
        let set_accepting = self.undo(start);
        let (rejected, may_reject) = self.block(branches[1], parted);
        let set_rejecting = self.undo(start);
        let ways = [(may_accept, &set_accepting), (may_reject, &set_rejecting)];
        let mut variables: Vec<_> = ways
            .iter()
            .flat_map(|(_, set)| set.iter().map(|s| s.0))
            .collect();
        variables.sort_unstable();
        variables.dedup();
        for variable in variables {
            let held = ways.map(|(may, set)| {
                let new = set.iter().find(|(other, _)| *other == variable);
                (may & NEXT != 0).then(|| new.map_or(self.held[variable], |(_, node)| *node))
            });
            let node = match held {
                [Some(a), Some(b)] if a != b => self.graph.node_on(What::Other, [a, b]),
                [Some(one), _] | [None, Some(one)] => one,
                [None, None] => continue,
            };
            self.set(variable, node);
        }
        let behaviors = may_accept | may_reject;
        let flow = match behaviors {
            NEXT => flow,
            _ => self.graph.node_on(What::Other, [accepted, rejected]),
        };
        (flow, behaviors)
    }

    fn switch(
        &mut self,
        selector: Handle<Expression>,
        cases: &'a [SwitchCase],
        span: Span,
        flow: Node,
    ) -> (Node, Behaviors) {
        let parted = self.part(selector, span, flow);
        let set = cases.first().map(|case| &case.body);
        self.enter(set, false);
        let mut behaviors = 0;
        let mut ends = Vec::new();
        for case in cases {
            // All selectors that share a body have an empty one, except the last.
            if case.fall_through {
                continue;
            }
            let start = self.log.len();
            let (end, may) = self.block(&case.body, parted);
            ends.push(end);
            behaviors |= may;
            if may & NEXT != 0
                && let Some(around) = self.around.pop()
            {
                self.flow_to(&around.exits);
                self.around.push(around);
            }
            self.undo(start);
        }
        self.exit();
        if behaviors & BREAK != 0 {
            behaviors = behaviors & !BREAK | NEXT;
        }
        let flow = match behaviors {
            NEXT => flow,
            _ => self.graph.node_on(What::Other, ends),
        };
        (flow, behaviors)
    }

    fn repeat(
        &mut self,
        (body, continuing, break_if): (&'a Block, &'a Block, Option<Handle<Expression>>),
        span: Span,
        flow: Node,
    ) -> (Node, Behaviors) {
        let start = self.graph.node_on(What::Other, [flow]);
        let set = self.enter(Some(body), true);
        let mut begins = Vec::with_capacity(set.len());
        for variable in set {
            let begin = self.graph.node_on(What::Other, [self.held[variable]]);
            begins.push((variable, begin));
            self.set(variable, begin);
        }
        let (after_body, mut may) = self.block(body, start);
        if may & NEXT != 0
            && let Some(around) = self.around.pop()
        {
            self.flow_to(&around.continues);
            self.around.push(around);
        }
        // `continuing` is unreachable where no path through the body leads to it.
        if may & (NEXT | CONTINUE) != 0 {
            if let Some(around) = self.around.last() {
                for (variable, node) in around.continues.clone() {
                    self.set(variable, node);
                }
            }
            let (mut after, _) = self.block(continuing, after_body);
            if let Some(condition) = break_if {
                after = self.part(condition, Span::UNDEFINED, after);
                may |= BREAK;
                if let Some(around) = self.around.pop() {
                    self.flow_to(&around.exits);
                    self.around.push(around);
                }
            }
            self.graph.edge(start, after);
            self.flow_to(&begins);
        } else if self.check.places.text(span).starts_with("while") {
            // By the specification, every loop iterates again. Browsers drop that edge for loops that never do, but
            // not for `while`.
            self.graph.edge(start, after_body);
        }
        self.exit();
        let behaviors = match may & BREAK {
            0 => may & RETURN,
            _ => may & RETURN | NEXT,
        };
        let flow = match behaviors {
            NEXT => flow,
            _ => after_body,
        };
        (flow, behaviors)
    }

    /// Enters a loop or switch whose first block is `first`; returns the variables assigned within.
    fn enter(&mut self, first: Option<&Block>, is_loop: bool) -> Vec<Variable> {
        let set = first.and_then(|first| self.set_within.get(&std::ptr::from_ref(first)));
        let set = set.cloned().unwrap_or_default();
        let graph = &mut self.graph;
        let mut fresh = || {
            let nodes = set
                .iter()
                .map(|&variable| (variable, graph.node(What::Other)));
            nodes.collect::<Vec<_>>()
        };
        let exits = fresh();
        let continues = if is_loop { fresh() } else { Vec::new() };
        self.around.push(Around {
            is_loop,
            exits,
            continues,
        });
        set
    }

    /// Leaves the innermost loop or switch.
    fn exit(&mut self) {
        if let Some(around) = self.around.pop() {
            for (variable, node) in around.exits {
                self.set(variable, node);
            }
        }
    }

    /// Lets the variables' current values flow to `nodes`.
    fn flow_to(&mut self, nodes: &[(Variable, Node)]) {
        for (variable, node) in nodes {
            self.graph.edge(*node, self.held[*variable]);
        }
    }

    /// Control flow after a branch on `condition`.
    fn part(&mut self, condition: Handle<Expression>, span: Span, flow: Node) -> Node {
        let value = self.value(condition);
        let own = self.function.expressions.get_span(condition);
        let span = if own.is_defined() { own } else { span };
        self.graph.node_on(What::Branch(span), [value, flow])
    }

    /// Records the contents of the pointer parameters where execution leaves the function.
    fn leave(&mut self) {
        let locals = self.function.local_variables.len();
        for index in 0..self.after.len() {
            if let Some(after) = self.after[index] {
                self.graph.edge(after, self.held[locals + index]);
            }
        }
    }

    fn set(&mut self, variable: Variable, node: Node) {
        self.log.push((variable, self.held[variable]));
        self.held[variable] = node;
    }

    /// Undoes the assignments made since the log had `start` entries; returns the variables and the values that
    /// they had been assigned.
    fn undo(&mut self, start: usize) -> Vec<(Variable, Node)> {
        let mut set = Vec::new();
        for (variable, before) in self.log.drain(start..).rev() {
            if !std::mem::replace(&mut self.seen[variable], true) {
                set.push((variable, self.held[variable]));
            }
            self.held[variable] = before;
        }
        for (variable, _) in &set {
            self.seen[*variable] = false;
        }
        set
    }

    fn store(&mut self, pointer: Handle<Expression>, stored: Node, flow: Node) {
        let (Root::Variable(variable), whole) = self.root(pointer) else {
            return;
        };
        let place = self.value(pointer);
        let node = self.graph.node_on(What::Other, [stored, place, flow]);
        if !whole {
            self.graph.edge(node, self.held[variable]);
        }
        self.set(variable, node);
    }

    fn call(
        &mut self,
        callee: Handle<Function>,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
        span: Span,
        flow: Node,
    ) {
        let check = self.check;
        let summary = &check.summaries[callee.index()];
        let at = self.graph.node_on(What::Other, [flow]);
        let values: Vec<_> = arguments
            .iter()
            .map(|argument| {
                let value = self.value(*argument);
                let own = self.function.expressions.get_span(*argument);
                let span = if own.is_defined() { own } else { span };
                self.graph.node_on(What::Argument(span), [value, at])
            })
            .collect();
        let roots: Vec<_> = arguments
            .iter()
            .map(|argument| self.root(*argument))
            .collect();
        let contents: Vec<_> = roots
            .iter()
            .map(|(root, _)| match root {
                Root::Variable(variable) => self.held[*variable],
                Root::Constant => UNIFORM,
                Root::Outside => DIFFERS,
            })
            .collect();
        let mut returned = vec![at];
        let feeds = |feeds: &super::Feeds, nodes: &mut Vec<Node>| {
            nodes.extend(feeds.values.iter().map(|&i| values[i as usize]));
            nodes.extend(feeds.contents.iter().map(|&i| contents[i as usize]));
            for (origin, node) in feeds.origins.iter().zip([DIFFERS_IN_WORKGROUP, DIFFERS]) {
                nodes.extend(origin.map(|_| node));
            }
        };
        feeds(&summary.result, &mut returned);
        if let Some(result) = result {
            self.define(result, returned);
        }
        for (index, parameter) in summary.parameters.iter().enumerate() {
            let (Root::Variable(variable), whole) = roots[index] else {
                continue;
            };
            let Some(after) = &parameter.after else {
                continue;
            };
            let mut on = vec![at];
            feeds(after, &mut on);
            if !whole {
                on.extend([self.held[variable], values[index]]);
            }
            let what = What::After(callee, index as u32, span);
            let node = self.graph.node_on(what, on);
            self.set(variable, node);
        }
        let mut need = |needs: &super::Needs, node: Node, part: Part| {
            for (scope, need) in [Scope::Workgroup, Scope::Subgroup].into_iter().zip(needs) {
                if let Some(need) = need {
                    self.requirements.push(Requirement {
                        scope,
                        severity: need.severity,
                        node,
                        cause: Cause {
                            span,
                            kind: CauseKind::Call(callee, part),
                        },
                    });
                }
            }
        };
        need(&summary.call, at, Part::Itself);
        for (index, parameter) in summary.parameters.iter().enumerate() {
            let number = index as u32;
            need(&parameter.value, values[index], Part::Value(number));
            need(&parameter.contents, contents[index], Part::Contents(number));
        }
    }

    fn demand(&mut self, demand: Demand, span: Span, node: Node) {
        self.require(demand, span, node, CauseKind::ControlFlow(demand));
    }

    fn demand_of_operand(
        &mut self,
        demand: Demand,
        index: u32,
        value: Node,
        span: Span,
        flow: Node,
    ) {
        let node = self.graph.node_on(What::Other, [value, flow]);
        self.require(demand, span, node, CauseKind::Operand(index, demand));
    }

    fn require(&mut self, demand: Demand, span: Span, node: Node, kind: CauseKind) {
        let severity = match demand.rule {
            Some(rule) => self.check.places.severity(rule, span),
            None => Severity::Error,
        };
        if severity > Severity::Off {
            self.requirements.push(Requirement {
                scope: demand.scope,
                severity,
                node,
                cause: Cause { span, kind },
            });
        }
    }

    /// Gives `expression` a value that depends on `on`.
    fn define(&mut self, expression: Handle<Expression>, on: impl IntoIterator<Item = Node>) {
        let node = self.graph.node_on(What::Value(expression), on);
        self.values[expression.index()] = node;
    }

    fn value(&self, expression: Handle<Expression>) -> Node {
        self.values[expression.index()]
    }
}
