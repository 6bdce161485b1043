//! Filters written again, in the text of a linked module.

use std::fmt::Write as _;

use naga::{Block, Expression, Function, Module, Span, Statement, diagnostic_filter::Severity};
use serde::{Deserialize, Serialize};

use super::{OWN, On, Places, Rule, Setting, severity_name};
use crate::uniformity::{Demand, blocks};

/// Filters to print in a linked module's text.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Written {
    /// Settings that all functions share.
    directives: Vec<Setting>,
    /// Attributes of each function, by its index.
    functions: Vec<Attributes>,
    entry_points: Vec<Attributes>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Attributes {
    function: Vec<Setting>,
    /// Settings of blocks, by the order in which the blocks open; the function's own block is number 0.
    blocks: Vec<(u32, Setting)>,
}

impl Written {
    /// Filters that `module` must print so that each operation has the severity that its author asked for.
    ///
    /// Some places of an attribute have no statement in naga's IR. The block around such a place takes the mildest
    /// severity that is asked for in it, so that nothing is refused that the author allowed.
    pub(crate) fn new(module: &Module, places: &Places<'_>) -> Self {
        if places.filters.values().all(|filters| filters.0.is_empty()) {
            return Self::default();
        }
        let functions = module.functions.iter().map(|(_, function)| function);
        let entries = module.entry_points.iter().map(|entry| &entry.function);
        let mut all: Vec<_> = functions
            .chain(entries)
            .map(|function| attributes(function, places))
            .collect();
        let mut directives = Vec::new();
        let settings = all
            .iter()
            .flat_map(|(attributes, _)| attributes.function.clone());
        let mut settings: Vec<_> = settings.collect();
        settings.sort();
        settings.dedup();
        for setting in settings {
            let agree = |(attributes, rules): &(Attributes, Vec<&str>)| {
                let idle = Rule::known(&setting.rule) && !rules.contains(&setting.rule.as_str());
                attributes.function.contains(&setting) || idle
            };
            if all.iter().all(agree) {
                for (attributes, _) in &mut all {
                    attributes.function.retain(|other| *other != setting);
                }
                directives.push(setting);
            }
        }
        // A severity equal to the rule's default needs no attribute.
        let default =
            |setting: &Setting| Rule::known(&setting.rule) && setting.severity == Severity::Error;
        directives.retain(|setting| !default(setting));
        for (attributes, _) in &mut all {
            attributes.function.retain(|setting| !default(setting));
        }
        let mut functions: Vec<_> = all.into_iter().map(|(attributes, _)| attributes).collect();
        let entry_points = functions.split_off(module.functions.len());
        Self {
            directives,
            functions,
            entry_points,
        }
    }

    /// `text`, as naga wrote it, with the filters added.
    pub(crate) fn annotate(&self, text: &str) -> String {
        let mut out = String::with_capacity(text.len());
        for setting in &self.directives {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "diagnostic({setting});");
        }
        if !self.directives.is_empty() && !text.starts_with("enable ") {
            out.push('\n');
        }
        let mut all = self.functions.iter().chain(&self.entry_points);
        let mut attributes = None;
        let mut opened = 0;
        // The writer prints functions in the module's order, entry points last, and opens a block only at the end
        // of a line.
        for line in text.split_inclusive('\n') {
            if line.starts_with("fn ") {
                attributes = all.next();
                opened = 0;
                for setting in attributes
                    .iter()
                    .flat_map(|attributes| &attributes.function)
                {
                    let _ = writeln!(out, "@diagnostic({setting})");
                }
            }
            let open = line.trim_end().strip_suffix('{');
            let Some((open, attributes)) = open.zip(attributes) else {
                out.push_str(line);
                continue;
            };
            out.push_str(open);
            for (_, setting) in attributes
                .blocks
                .iter()
                .filter(|(block, _)| *block == opened)
            {
                let _ = write!(out, "@diagnostic({setting}) ");
            }
            out.push_str("{\n");
            opened += 1;
        }
        out
    }
}

impl std::fmt::Display for Setting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {}", severity_name(self.severity), self.rule)
    }
}

/// The attributes of `function`, and the rules that matter in it.
fn attributes<'a>(function: &Function, places: &Places<'a>) -> (Attributes, Vec<&'a str>) {
    let mut attributes = Attributes::default();
    let mut rules = Vec::new();
    for rule in Rule::ALL {
        let mut blocks = Blocks {
            function,
            places,
            rule,
            wanted: Vec::new(),
        };
        blocks.visit(&function.body, 0);
        let wanted = blocks.wanted;
        let mut some = wanted.iter().filter_map(|(_, severity)| *severity);
        let Some(first) = some.next() else {
            continue;
        };
        let agreed = some.all(|other| other == first).then_some(first);
        let own = wanted[0].1.or(agreed).unwrap_or(Severity::Error);
        let setting = |severity| Setting {
            rule: rule.name().to_owned(),
            severity,
        };
        rules.push(rule.name());
        attributes.function.push(setting(own));
        let mut held = vec![own];
        for (index, (around, wanted)) in wanted.iter().enumerate().skip(1) {
            let severity = wanted.unwrap_or(held[*around]);
            if severity != held[*around] {
                attributes.blocks.push((index as u32, setting(severity)));
            }
            held.push(severity);
        }
    }
    // A rule of another tool holds for the function as it was written on the function or on its module.
    let mut spans = function.body.span_iter().map(|(_, span)| *span);
    let at = spans.find_map(|span| places.locate(span));
    if let Some((module, range)) = at
        && let Some(filters) = places.filters.get(&module)
    {
        let around = filters.around(range.start);
        for filter in around.filter(|filter| filter.on != On::Statement) {
            let rule = filter.setting.rule.as_str();
            // Our own lints look at what authors write, not at what is printed.
            let is_own = rule.starts_with(OWN);
            if !Rule::known(rule) && !is_own && !rules.contains(&rule) {
                rules.push(rule);
                attributes.function.push(filter.setting.clone());
            }
        }
    }
    (attributes, rules)
}

/// Blocks of a function in the order in which they open, each with the mildest severity asked for directly in it.
struct Blocks<'a, 'b> {
    function: &'a Function,
    places: &'a Places<'b>,
    rule: Rule,
    /// For each block, the number of the block around it, and the severity.
    wanted: Vec<(usize, Option<Severity>)>,
}

impl Blocks<'_, '_> {
    fn visit(&mut self, block: &Block, around: usize) {
        let number = self.wanted.len();
        self.wanted.push((around, None));
        for (statement, span) in block.span_iter() {
            if let Statement::Emit(range) = statement {
                for handle in range.clone() {
                    let expression = &self.function.expressions[handle];
                    let span = self.function.expressions.get_span(handle);
                    self.want(number, Demand::of_expression(expression), span);
                }
            }
            self.want(number, Demand::of_statement(statement), *span);
            self.within(statement, number);
        }
    }

    /// Visits the blocks within `statement`, in the order in which the writer prints them.
    fn within(&mut self, statement: &Statement, around: usize) {
        match statement {
            Statement::If { accept, reject, .. } => {
                self.visit(accept, around);
                if !reject.is_empty() {
                    self.visit(reject, around);
                }
            }
            Statement::Switch { cases, .. } => {
                let own = self.wanted.len();
                self.wanted.push((around, None));
                for case in cases.iter().filter(|case| !case.fall_through) {
                    self.visit(&case.body, own);
                }
            }
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => {
                let own = self.wanted.len();
                self.visit(body, around);
                if !continuing.is_empty() || break_if.is_some() {
                    self.visit(continuing, own);
                }
            }
            other => {
                for block in blocks(other) {
                    self.visit(block, around);
                }
            }
        }
    }

    fn want(&mut self, block: usize, demand: Option<Demand>, span: Span) {
        if demand.is_some_and(|demand| demand.rule == Some(self.rule)) {
            let severity = self.places.severity(self.rule, span);
            let wanted = &mut self.wanted[block].1;
            *wanted = Some(wanted.map_or(severity, |other| other.min(severity)));
        }
    }
}

/// Whether the module has subgroup operations or built-in values. The writer prints no `enable` for them.
pub(crate) fn uses_subgroups(module: &Module) -> bool {
    let functions = module.functions.iter().map(|(_, function)| function);
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    let operations = functions.chain(entries).any(|function| {
        function.expressions.iter().any(|(_, expression)| {
            matches!(
                expression,
                Expression::SubgroupBallotResult | Expression::SubgroupOperationResult { .. }
            )
        })
    });
    let builtin = |binding: Option<&naga::Binding>| {
        matches!(
            binding,
            Some(naga::Binding::BuiltIn(
                naga::BuiltIn::SubgroupSize
                    | naga::BuiltIn::SubgroupInvocationId
                    | naga::BuiltIn::SubgroupId
                    | naga::BuiltIn::NumSubgroups
            ))
        )
    };
    operations
        || module.entry_points.iter().any(|entry| {
            let mut arguments = entry.function.arguments.iter();
            arguments.any(|argument| builtin(argument.binding.as_ref()))
        })
        || module.types.iter().any(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { members, .. } => members
                .iter()
                .any(|member| builtin(member.binding.as_ref())),
            _ => false,
        })
}
