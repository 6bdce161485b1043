//! Uniformity analysis: whether invocations arrive together at operations that they must execute together, by
//! WGSL's rules (<https://www.w3.org/TR/WGSL/#uniformity>). Naga's own analysis covers less, and differs.
//!
//! A function is a graph of values and of control flow, with an edge from each node to those that it depends on
//! (`graph`, `walk`). An operation demands that no path leads from its control flow (or its operand) to a source of
//! non-uniformity. Paths that end at the function's start, or at a parameter, become demands on its callers: they
//! make up the function's [`Summary`]. Naga puts callees before callers, so one pass over the module is enough.
//! Where every operation stands before any branch, no graph is made (`early`).
//!
//! Uniformity is decided for two [`Scope`]s, as browsers do: among the invocations of a subgroup for subgroup
//! operations, and among those of a workgroup, a quad or a draw for all others.

mod early;
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

/// Checks the module. Returns a fault for the first error, and otherwise the faults that the author's filters
/// reduce to warnings.
pub(crate) fn check(module: &Module, places: &Places<'_>) -> Result<Vec<Fault>, Fault> {
    if early::all_early(module) {
        return Ok(Vec::new());
    }
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

/// A function's demands and dependencies as its callers see them, without their causes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Shape(Vec<u32>);

/// Shapes of a valid module's functions, by index.
///
/// # Errors
/// A fault, which a valid module does not have.
pub(crate) fn shapes(module: &Module, places: &Places<'_>) -> Result<Vec<Shape>, Fault> {
    let mut check = Check {
        module,
        places,
        summaries: Vec::with_capacity(module.functions.len()),
        told: Vec::new(),
    };
    for (handle, function) in module.functions.iter() {
        let summary = check.function(function, Which::Function(handle), None)?;
        check.summaries.push(summary);
    }
    Ok(check.summaries.iter().map(Summary::shape).collect())
}

impl Summary {
    fn shape(&self) -> Shape {
        let mut shape = Vec::new();
        let needs = |needs: &Needs, shape: &mut Vec<u32>| {
            shape.extend(needs.map(|need| need.map_or(0, |need| need.severity as u32 + 1)));
        };
        let feeds = |feeds: &Feeds, shape: &mut Vec<u32>| {
            shape.extend(feeds.origins.map(|origin| u32::from(origin.is_some())));
            for arguments in [&feeds.values, &feeds.contents] {
                shape.push(arguments.len() as u32);
                shape.extend(arguments);
            }
        };
        needs(&self.call, &mut shape);
        for parameter in &self.parameters {
            needs(&parameter.value, &mut shape);
            needs(&parameter.contents, &mut shape);
            shape.push(u32::from(parameter.after.is_some()));
            if let Some(after) = &parameter.after {
                feeds(after, &mut shape);
            }
        }
        feeds(&self.result, &mut shape);
        Shape(shape)
    }
}

/// Sets of invocations among which something is uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Scope {
    Workgroup,
    Subgroup,
}

/// Demand of an operation for uniformity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Demand {
    scope: Scope,
    /// The diagnostic rule by which an author may switch the demand off; none where that is not possible.
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

    /// Demand of `expression` on the control flow in which it is evaluated.
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

    /// Demand of `statement` itself, without those of the statements within it.
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

/// Operand of `mode` that must be uniform within a subgroup.
fn uniform_operand(mode: GatherMode) -> Option<Handle<Expression>> {
    match mode {
        GatherMode::ShuffleDown(by) | GatherMode::ShuffleUp(by) | GatherMode::ShuffleXor(by) => {
            Some(by)
        }
        _ => None,
    }
}

/// A function or an entry point of the module.
#[derive(Clone, Copy, Debug)]
enum Which {
    Function(Handle<Function>),
    EntryPoint(usize),
}

/// Summary of a function for its callers.
#[derive(Debug, Default)]
struct Summary {
    /// Demands on the control flow of a call.
    call: Needs,
    parameters: Vec<Parameter>,
    /// Dependencies of the result.
    result: Feeds,
}

/// A parameter's demands, and its contents after a call.
#[derive(Debug, Default)]
struct Parameter {
    /// Demands on the value.
    value: Needs,
    /// Demands on the contents of the variable that the pointer leads to.
    contents: Needs,
    /// Dependencies of the pointer's contents after the call, where it points to a function's variable.
    after: Option<Feeds>,
}

/// Strongest demand for each scope.
type Needs = [Option<Need>; 2];

/// A demand, with its cause.
#[derive(Clone, Copy, Debug)]
struct Need {
    severity: Severity,
    cause: Cause,
    /// Branch that makes control flow depend on the parameter in question.
    branch: Option<Span>,
}

/// Operation or call in a function's body that makes a demand.
#[derive(Clone, Copy, Debug)]
struct Cause {
    span: Span,
    kind: CauseKind,
}

#[derive(Clone, Copy, Debug)]
enum CauseKind {
    /// A built-in operation, which demands uniform control flow.
    ControlFlow(Demand),
    /// A built-in operation, which demands that the argument of this number be uniform.
    Operand(u32, Demand),
    /// A call of a function, which passes on the function's demand.
    Call(Handle<Function>, Part),
}

/// Part of a call that a demand is about: the call itself, an argument's value, or the contents that it points to.
#[derive(Clone, Copy, Debug)]
enum Part {
    Itself,
    Value(u32),
    Contents(u32),
}

/// Dependencies of a value, as the function's callers see them.
#[derive(Debug, Default)]
struct Feeds {
    /// For each scope, a source of non-uniformity that does not depend on the arguments.
    origins: [Option<Origin>; 2],
    /// Arguments that it depends on, by number.
    values: Vec<u32>,
    /// Arguments on whose contents it depends, by number.
    contents: Vec<u32>,
}

/// A source of non-uniformity.
#[derive(Clone, Copy, Debug)]
struct Origin {
    function: Which,
    node: What,
}

/// Meaning of a node, as far as faults report it.
#[derive(Clone, Copy, Debug)]
enum What {
    Other,
    /// An expression's value.
    Value(Handle<Expression>),
    /// Input of an entry point, by number.
    Input(u32),
    /// Control flow after a branch, at its condition.
    Branch(Span),
    /// Argument of a call, at the call.
    Argument(Span),
    /// Contents of an argument of this number after a call of the function.
    After(Handle<Function>, u32, Span),
}

/// Survey of a function's own body: whether it demands anything, and its calls.
#[derive(Default)]
struct Survey {
    any: bool,
    calls: Vec<Handle<Function>>,
}

/// Functions whose summaries matter: those that demand something, and all that these call.
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

/// Blocks within `statement`, in the order in which they are printed.
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
    /// Summaries by the functions' indices.
    summaries: Vec<Summary>,
    /// Faults that are not errors.
    told: Vec<Fault>,
}

/// A demand within a function.
#[derive(Clone, Copy, Debug)]
struct Requirement {
    scope: Scope,
    severity: Severity,
    /// Node that must be uniform.
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
                        // Only one fault of a kind is reported for each function, as browsers do.
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

    /// Source of non-uniformity behind `node`; where it is the result of a call, the source within the called
    /// function.
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
