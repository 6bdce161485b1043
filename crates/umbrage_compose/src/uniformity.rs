//! Uniformity: whether invocations come together to what they must do together, as WGSL has it
//! (<https://www.w3.org/TR/WGSL/#uniformity>). Naga's own analysis decides less, and otherwise.
//!
//! A function is a graph of values and of control flow, with an edge from each to what it depends on
//! (`graph`, `walk`). An operation demands that no path leads from where it stands to something that may
//! differ between invocations. Paths that end at the function's own start, or at a parameter, are demands
//! on its callers: they are the function's [`Summary`], and naga puts callees before callers, so that one
//! pass over the module decides. Each edge is walked once a scope, so the time is linear in the module.
//!
//! Invocations are taken together at two [`Scope`]s, as browsers do: those of a subgroup for subgroup
//! operations, those of a workgroup, a quad or a draw for all else.

mod graph;
mod report;
mod walk;

use std::collections::BTreeSet;

use naga::{
    Barrier, Block, EntryPoint, Expression, Function, GatherMode, Handle, Module, Span, Statement,
    diagnostic_filter::Severity,
};

use crate::{
    Fault,
    diagnostics::{Places, Rule, severity_name},
};
use graph::{Graph, Node};
use walk::Walk;

pub(crate) use walk::for_each_operand;

/// Checks the module: a fault for what is an error, and faults to be told as warnings for what the
/// author's filters make less.
pub(crate) fn check(module: &Module, places: &Places<'_>) -> Result<Vec<Fault>, Fault> {
    let wanted = wanted(module);
    let mut check = Check {
        module,
        places,
        summaries: Vec::with_capacity(module.functions.len()),
        told: Vec::new(),
    };
    for ((handle, function), wanted) in module.functions.iter().zip(wanted) {
        let summary = match wanted {
            true => check.function(function, Which::Function(handle), None)?,
            false => Summary::default(),
        };
        check.summaries.push(summary);
    }
    for (index, entry) in module.entry_points.iter().enumerate() {
        let demands = survey(&entry.function);
        let calls = demands.calls.iter().map(|callee| callee.index());
        if demands.any || calls.into_iter().any(|callee| check.demands(callee)) {
            check.function(&entry.function, Which::EntryPoint(index), Some(entry))?;
        }
    }
    Ok(check.told)
}

/// Invocations that are taken together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Scope {
    Workgroup,
    Subgroup,
}

/// What an operation asks of the control flow that it stands in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Demand {
    scope: Scope,
    /// The rule by which an author may switch it off, where one may.
    pub(crate) rule: Option<Rule>,
}

impl Demand {
    const DERIVATIVE: Self = Self {
        scope: Scope::Workgroup,
        rule: Some(Rule::DerivativeUniformity),
    };
    const BARRIER: Self = Self {
        scope: Scope::Workgroup,
        rule: None,
    };
    const SUBGROUP: Self = Self {
        scope: Scope::Subgroup,
        rule: Some(Rule::SubgroupUniformity),
    };

    /// What `expression` demands where it is evaluated.
    pub(crate) fn of_expression(expression: &Expression) -> Option<Self> {
        match expression {
            Expression::Derivative { .. } => Some(Self::DERIVATIVE),
            Expression::ImageSample { level, .. } => {
                level.implicit_derivatives().then_some(Self::DERIVATIVE)
            }
            Expression::CooperativeLoad { .. } | Expression::CooperativeMultiplyAdd { .. } => {
                Some(Self::BARRIER)
            }
            _ => None,
        }
    }

    /// What `statement` itself demands, without what is within it.
    pub(crate) fn of_statement(statement: &Statement) -> Option<Self> {
        match statement {
            Statement::ControlBarrier(barrier) if *barrier == Barrier::SUB_GROUP => {
                Some(Self::SUBGROUP)
            }
            Statement::ControlBarrier(_)
            | Statement::WorkGroupUniformLoad { .. }
            | Statement::CooperativeStore { .. } => Some(Self::BARRIER),
            Statement::SubgroupBallot { .. }
            | Statement::SubgroupCollectiveOperation { .. }
            | Statement::SubgroupGather { .. } => Some(Self::SUBGROUP),
            _ => None,
        }
    }
}

/// What of `mode` must be the same for all of a subgroup.
fn uniform_operand(mode: GatherMode) -> Option<Handle<Expression>> {
    match mode {
        GatherMode::ShuffleDown(by) | GatherMode::ShuffleUp(by) | GatherMode::ShuffleXor(by) => {
            Some(by)
        }
        _ => None,
    }
}

/// A function of the module.
#[derive(Clone, Copy, Debug)]
enum Which {
    Function(Handle<Function>),
    EntryPoint(usize),
}

/// What a function's callers must know of it.
#[derive(Debug, Default)]
struct Summary {
    /// What it demands of where it is called.
    call: Needs,
    parameters: Vec<Parameter>,
    /// What its result depends on.
    result: Feeds,
}

/// What a function does with a parameter.
#[derive(Debug, Default)]
struct Parameter {
    /// What it demands of the value.
    value: Needs,
    /// What it demands of what the pointer leads to.
    contents: Needs,
    /// What the pointer's contents depend on after the call, where it is a pointer to a function's variable.
    after: Option<Feeds>,
}

/// The strongest demand of each scope.
type Needs = [Option<Need>; 2];

/// A demand, and where it comes from.
#[derive(Clone, Copy, Debug)]
struct Need {
    severity: Severity,
    cause: Cause,
    /// Where control flow parts by the parameter that the need is of.
    branch: Option<Span>,
}

/// What in a function's body demands something.
#[derive(Clone, Copy, Debug)]
struct Cause {
    span: Span,
    kind: CauseKind,
}

#[derive(Clone, Copy, Debug)]
enum CauseKind {
    /// An operation of WGSL's own demands uniform control flow.
    ControlFlow(Demand),
    /// It demands that this argument of its be uniform.
    Operand(u32, Demand),
    /// A call demands something, as the function called does.
    Call(Handle<Function>, Part),
}

/// What of a function's call is meant.
#[derive(Clone, Copy, Debug)]
enum Part {
    Itself,
    Value(u32),
    Contents(u32),
}

/// What a value depends on, as its function's callers see it.
#[derive(Debug, Default)]
struct Feeds {
    /// What may make it differ between invocations, whatever the arguments are, for each scope.
    origins: [Option<Origin>; 2],
    /// The arguments, by their numbers.
    values: Vec<u32>,
    /// The arguments whose contents it depends on.
    contents: Vec<u32>,
}

/// What may differ between invocations, to begin with.
#[derive(Clone, Copy, Debug)]
struct Origin {
    function: Which,
    node: What,
}

/// What a node stands for, as far as faults tell of it.
#[derive(Clone, Copy, Debug)]
enum What {
    Other,
    /// An expression's value.
    Value(Handle<Expression>),
    /// An entry point's input, by its number.
    Input(u32),
    /// Control flow that parts, at the value that it parts by.
    Branch(Span),
    /// An argument of a call, at the call.
    Argument(Span),
    /// What a pointer leads to after a call of the function.
    After(Handle<Function>, u32, Span),
}

/// What a function's own body demands and calls.
#[derive(Default)]
struct Survey {
    any: bool,
    calls: Vec<Handle<Function>>,
}

/// The functions whose summaries matter: those that demand something, and what these call.
fn wanted(module: &Module) -> Vec<bool> {
    let surveys: Vec<_> = module.functions.iter().map(|(_, f)| survey(f)).collect();
    let mut wanted: Vec<bool> = Vec::with_capacity(surveys.len());
    for survey in &surveys {
        let demands = survey.any || survey.calls.iter().any(|callee| wanted[callee.index()]);
        wanted.push(demands);
    }
    let demands = wanted.clone();
    for entry in &module.entry_points {
        let survey = survey(&entry.function);
        if survey.any || survey.calls.iter().any(|callee| demands[callee.index()]) {
            survey.calls.iter().for_each(|c| wanted[c.index()] = true);
        }
    }
    for (index, survey) in surveys.iter().enumerate().rev() {
        if wanted[index] {
            survey.calls.iter().for_each(|c| wanted[c.index()] = true);
        }
    }
    wanted
}

fn survey(function: &Function) -> Survey {
    let mut survey = Survey::default();
    let mut expressions = function.expressions.iter();
    survey.any = expressions.any(|(_, e)| Demand::of_expression(e).is_some());
    survey_block(&function.body, &mut survey);
    survey
}

fn survey_block(block: &Block, survey: &mut Survey) {
    for statement in block.iter() {
        survey.any |= Demand::of_statement(statement).is_some();
        if let Statement::Call { function, .. } = statement {
            survey.calls.push(*function);
        }
        for inner in blocks(statement) {
            survey_block(inner, survey);
        }
    }
}

/// The blocks within `statement`, in the order in which they are written down.
pub(crate) fn blocks(statement: &Statement) -> Vec<&Block> {
    match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        Statement::Loop {
            body, continuing, ..
        } => vec![body, continuing],
        _ => Vec::new(),
    }
}

struct Check<'a> {
    module: &'a Module,
    places: &'a Places<'a>,
    /// By the functions' numbers.
    summaries: Vec<Summary>,
    /// What is no error.
    told: Vec<Fault>,
}

/// A demand within a function.
#[derive(Clone, Copy, Debug)]
struct Requirement {
    scope: Scope,
    severity: Severity,
    /// What must be uniform.
    node: Node,
    cause: Cause,
}

impl Check<'_> {
    fn demands(&self, callee: usize) -> bool {
        let summary = &self.summaries[callee];
        let parameters = summary.parameters.iter();
        let mut needs = parameters.flat_map(|p| [&p.value, &p.contents]);
        summary.call.iter().any(Option::is_some) || needs.any(|n| n.iter().any(Option::is_some))
    }

    fn function(
        &mut self,
        function: &Function,
        which: Which,
        entry: Option<&EntryPoint>,
    ) -> Result<Summary, Fault> {
        let walk = Walk::new(self, function, entry).run();
        let Walk {
            mut graph,
            mut requirements,
            result,
            after,
            ..
        } = walk;
        let mut summary = Summary {
            parameters: function
                .arguments
                .iter()
                .map(|_| Parameter::default())
                .collect(),
            ..Summary::default()
        };
        requirements.sort_by_key(|r| (r.scope, std::cmp::Reverse(r.severity)));
        let mut told = BTreeSet::new();
        let mut scope = None;
        for requirement in requirements {
            if scope != Some(requirement.scope) {
                scope = Some(requirement.scope);
                graph.forget();
            }
            let leaves = graph.leaves(requirement.node);
            for (leaf, from) in leaves {
                let need = || Need {
                    severity: requirement.severity,
                    cause: requirement.cause,
                    branch: graph.branch(from),
                };
                let index = requirement.scope as usize;
                match graph.kind(leaf) {
                    graph::Leaf::Start => {
                        summary.call[index].get_or_insert_with(need);
                    }
                    graph::Leaf::Value(i) => {
                        summary.parameters[i].value[index].get_or_insert_with(need);
                    }
                    graph::Leaf::Contents(i) => {
                        summary.parameters[i].contents[index].get_or_insert_with(need);
                    }
                    graph::Leaf::Differs(of)
                        if of == Scope::Subgroup || of == requirement.scope =>
                    {
                        // One of a kind is told for each function, as browsers do.
                        if told.insert((requirement.scope, requirement.severity)) {
                            let path = graph.path(from);
                            let fault = self.fault(which, &requirement, &path);
                            if requirement.severity == Severity::Error {
                                return Err(fault);
                            }
                            let severity = severity_name(requirement.severity);
                            let note =
                                format!("no error: a filter makes its severity `{severity}`");
                            self.told.push(fault.note(note));
                        }
                    }
                    graph::Leaf::Differs(_) => {}
                }
            }
        }
        if entry.is_none() {
            summary.result = self.feeds(&mut graph, which, result);
            for (parameter, after) in summary.parameters.iter_mut().zip(after) {
                parameter.after = after.map(|node| self.feeds(&mut graph, which, node));
            }
        }
        Ok(summary)
    }

    fn feeds(&self, graph: &mut Graph, which: Which, node: Node) -> Feeds {
        graph.forget();
        let mut feeds = Feeds::default();
        for (leaf, from) in graph.leaves(node) {
            match graph.kind(leaf) {
                graph::Leaf::Start => {}
                graph::Leaf::Value(i) => feeds.values.push(i as u32),
                graph::Leaf::Contents(i) => feeds.contents.push(i as u32),
                graph::Leaf::Differs(scope) => {
                    let origin = self.origin(which, graph.what(from), scope);
                    feeds.origins[scope as usize].get_or_insert(origin);
                }
            }
        }
        for arguments in [&mut feeds.values, &mut feeds.contents] {
            arguments.sort_unstable();
            arguments.dedup();
        }
        feeds
    }

    /// Where what may differ comes from: of a call's result, what makes it differ within the function called.
    fn origin(&self, function: Which, node: What, scope: Scope) -> Origin {
        let inner = match node {
            What::Value(value) => match self.body(function).expressions[value] {
                Expression::CallResult(callee) => {
                    self.summaries[callee.index()].result.origins[scope as usize]
                }
                _ => None,
            },
            What::After(callee, argument, _) => {
                let parameter = &self.summaries[callee.index()].parameters[argument as usize];
                parameter
                    .after
                    .as_ref()
                    .and_then(|feeds| feeds.origins[scope as usize])
            }
            _ => None,
        };
        inner.unwrap_or(Origin { function, node })
    }

    fn body(&self, which: Which) -> &Function {
        match which {
            Which::Function(handle) => &self.module.functions[handle],
            Which::EntryPoint(index) => &self.module.entry_points[index].function,
        }
    }
}
