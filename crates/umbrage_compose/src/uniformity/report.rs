//! Report of a demand that is not met: the operation, the calls that lead to it, the reason, and the advice.

use naga::{AddressSpace, Binding, Expression, Function, Handle, Span};

use super::{
    Cause, CauseKind, Check, Demand, Need, Origin, Part, Requirement, Scope, What, Which,
    graph::branch,
};
use crate::{Cause as Kind, Fault, diagnostics::Rule};

impl Check<'_> {
    /// Fault of `requirement` in the function `which`; `path` leads from the node that must be uniform to the
    /// source of non-uniformity.
    pub(super) fn fault(&self, which: Which, requirement: &Requirement, path: &[What]) -> Fault {
        let mut cause = requirement.cause;
        let mut calls = Vec::new();
        // Where the demand is on an argument, the branch lies within the called function.
        let mut parts = None;
        while let Some((callee, part, need)) = self.within(cause, requirement.scope) {
            calls.push((callee, cause.span));
            if !matches!(part, Part::Itself) {
                parts = need.branch.or(parts);
            }
            cause = need.cause;
        }
        let operation = self.word(cause.span);
        let (message, demand) = match cause.kind {
            CauseKind::Operand(index, demand) => {
                let index = index + 1;
                (
                    format!("argument {index} of `{operation}` must be uniform"),
                    demand,
                )
            }
            CauseKind::ControlFlow(demand) => {
                let subgroup = match demand.scope {
                    Scope::Workgroup => "",
                    Scope::Subgroup => "subgroup ",
                };
                let message = format!(
                    "`{operation}` must only be called from {subgroup}uniform control flow"
                );
                (message, demand)
            }
            // Not reached: the chain of calls always ends at an operation.
            CauseKind::Call(_, _) => return Fault::new(Kind::Validation, "not uniform"),
        };
        let mut fault = Fault::new(Kind::Validation, message);
        let mut places = vec![(cause.span, String::new())];
        for (callee, span) in calls.into_iter().rev() {
            places.push((span, format!("`{}` is called here", self.name(callee))));
        }
        if let Some(span) = parts.or_else(|| branch(path)) {
            let label = "control flow depends on a value that may not be uniform";
            places.push((span, label.to_owned()));
        }
        let last = path.last().copied().unwrap_or(What::Other);
        let own = Origin {
            function: which,
            node: last,
        };
        let origin = self.origin(which, last, requirement.scope);
        match last {
            What::Value(value)
                if matches!(
                    self.body(which).expressions[value],
                    Expression::CallResult(_)
                ) =>
            {
                places.push((self.place(own), self.reason(own)));
                places.push((self.place(origin), self.reason(origin)));
            }
            What::After(..) => {
                places.push((self.place(own), self.reason(own)));
                places.push((self.place(origin), self.reason(origin)));
            }
            _ => places.push((self.place(own), self.reason(own))),
        }
        places.dedup();
        for (span, label) in places {
            if let Some(place) = self.places.place(span, label) {
                fault = fault.at(place);
            }
        }
        fault.note(advice(&operation, demand))
    }

    /// Demand in the called function behind `cause`, where `cause` is a call.
    fn within(&self, cause: Cause, scope: Scope) -> Option<(Handle<Function>, Part, &Need)> {
        let CauseKind::Call(callee, part) = cause.kind else {
            return None;
        };
        let summary = &self.summaries[callee.index()];
        let needs = match part {
            Part::Itself => &summary.call,
            Part::Value(index) => &summary.parameters[index as usize].value,
            Part::Contents(index) => &summary.parameters[index as usize].contents,
        };
        Some((callee, part, needs[scope as usize].as_ref()?))
    }

    /// Place of `origin` in the text.
    fn place(&self, origin: Origin) -> Span {
        let function = self.body(origin.function);
        match origin.node {
            What::Value(value) => function.expressions.get_span(value),
            What::Input(index) => {
                let mut expressions = function.expressions.iter();
                let input = expressions
                    .find(|(_, e)| matches!(e, Expression::FunctionArgument(i) if *i == index));
                input.map_or(Span::UNDEFINED, |(handle, _)| {
                    function.expressions.get_span(handle)
                })
            }
            What::Branch(span) | What::Argument(span) | What::After(_, _, span) => span,
            What::Other => Span::UNDEFINED,
        }
    }

    /// Reason why `origin` may differ between invocations.
    fn reason(&self, origin: Origin) -> String {
        let function = self.body(origin.function);
        let what = match origin.node {
            What::Input(index) => {
                let argument = &function.arguments[index as usize];
                let name = argument.name.as_deref().unwrap_or_default();
                match argument.binding {
                    Some(Binding::BuiltIn(_)) => format!("the built-in value `{name}`"),
                    Some(_) => format!("the input `{name}`"),
                    None => format!("what is in the input `{name}`"),
                }
            }
            What::Value(value) => match &function.expressions[value] {
                Expression::Load { pointer } => self.memory(function, *pointer),
                Expression::CallResult(callee) => {
                    format!("what `{}` returns", self.name(*callee))
                }
                _ => format!(
                    "what `{}` returns",
                    self.word(function.expressions.get_span(value))
                ),
            },
            What::After(callee, _, _) => {
                format!(
                    "what `{}` leaves where its argument points",
                    self.name(callee)
                )
            }
            What::Branch(_) | What::Argument(_) | What::Other => "this".to_owned(),
        };
        format!("{what} may differ between invocations")
    }

    fn memory(&self, function: &Function, mut pointer: Handle<Expression>) -> String {
        loop {
            let root = &function.expressions[pointer];
            pointer = match root {
                Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => *base,
                Expression::GlobalVariable(global) => {
                    let global = &self.module.global_variables[*global];
                    let name = global.name.as_deref().unwrap_or_default();
                    return match global.space {
                        AddressSpace::Private => format!("the private variable `{name}`"),
                        AddressSpace::WorkGroup => format!("the workgroup variable `{name}`"),
                        AddressSpace::Storage { .. } => {
                            format!("the read-write storage buffer `{name}`")
                        }
                        _ => format!("`{name}`"),
                    };
                }
                Expression::FunctionArgument(index) => {
                    let name = function.arguments[*index as usize].name.as_deref();
                    return format!("what `{}` points to", name.unwrap_or_default());
                }
                _ => return "this".to_owned(),
            };
        }
    }

    fn name(&self, function: Handle<Function>) -> &str {
        let name = self.module.functions[function].name.as_deref();
        name.unwrap_or_default()
    }

    /// Word of the author's text at `span`.
    fn word(&self, span: Span) -> String {
        let text = self.places.text(span);
        let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
        match &text[..end.unwrap_or(text.len())] {
            "" => "this operation".to_owned(),
            word => word.to_owned(),
        }
    }
}

fn advice(operation: &str, demand: Demand) -> String {
    let filter = |rule: Rule| {
        format!(
            "or say that it does no harm here: `@diagnostic(off, {})` on the function or statement",
            rule.name()
        )
    };
    match demand.rule {
        Some(rule @ Rule::DerivativeUniformity) => {
            let instead = match operation {
                "textureSampleCompare" => ", or take `textureSampleCompareLevel`",
                "textureSample" | "textureSampleBias" => {
                    ", or take `textureSampleLevel` or `textureSampleGrad`"
                }
                _ => "",
            };
            format!(
                "call it before control flow parts{instead}, {}",
                filter(rule)
            )
        }
        Some(rule @ Rule::SubgroupUniformity) => {
            format!("call it where all of a subgroup come by, {}", filter(rule))
        }
        None => "all invocations must come by together: move it out of the branch or loop, or let the condition be the same for all"
            .to_owned(),
    }
}
