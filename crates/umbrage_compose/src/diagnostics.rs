//! Diagnostic filters: `diagnostic(off, derivative_uniformity)`, as a directive, on a function, on a
//! statement or on a block (<https://www.w3.org/TR/WGSL/#diagnostics>).
//!
//! Naga reads filters only on functions, and writes none. So they are read here, blanked out of the text that naga
//! sees, looked up by place, and written again. A directive holds for the functions of its own module.

use std::{fmt::Write as _, ops::Range, sync::Arc};

use naga::{Block, Expression, Function, Module, Span, Statement, diagnostic_filter::Severity};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use wgsl_parse::lexer::Token;

use crate::{
    Cause, Fault, Library,
    error::{Place, nearest},
    source::Source,
    uniformity::{Demand, blocks},
};

/// A rule that authors may filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    DerivativeUniformity,
    SubgroupUniformity,
}

impl Rule {
    const ALL: [Self; 2] = [Self::DerivativeUniformity, Self::SubgroupUniformity];

    /// Whether WGSL has a rule of the name `rule`.
    fn known(rule: &str) -> bool {
        Self::ALL.iter().any(|known| known.name() == rule)
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::DerivativeUniformity => "derivative_uniformity",
            Self::SubgroupUniformity => "subgroup_uniformity",
        }
    }
}

const SEVERITIES: [(&str, Severity); 4] = [
    ("off", Severity::Off),
    ("info", Severity::Info),
    ("warning", Severity::Warning),
    ("error", Severity::Error),
];

pub(crate) fn severity_name(severity: Severity) -> &'static str {
    let known = SEVERITIES.iter().find(|(_, known)| *known == severity);
    known.map_or("error", |(name, _)| name)
}

/// A module's filters.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Filters(Vec<Filter>);

#[derive(Debug, PartialEq)]
struct Filter {
    setting: Setting,
    /// The part of the text that the filter applies to.
    range: Range<usize>,
    /// The filter's own place in the text.
    written: Range<usize>,
    on: On,
}

/// Kind of construct that a filter is written on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum On {
    Module,
    Function,
    Statement,
}

/// A rule, and the severity of a breach.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
struct Setting {
    rule: String,
    severity: Severity,
}

impl Filters {
    /// Reads the filters among `tokens`, outside of `blanks`.
    pub(crate) fn read(
        source: &Source,
        tokens: &[(Token, Range<usize>)],
        blanks: &[Range<usize>],
    ) -> Result<Self, Fault> {
        let mut reader = Reader {
            source,
            tokens,
            filters: Vec::new(),
        };
        let mut index = 0;
        while index < tokens.len() {
            let start = tokens[index].1.start;
            let before = blanks.partition_point(|blank| blank.start <= start);
            let blank = before > 0 && start < blanks[before - 1].end;
            let next = match (&tokens[index].0, reader.word(index + 1)) {
                _ if blank => None,
                (Token::SymAttr, _) => Some(reader.attributes(index)?),
                // Only a directive begins this way.
                _ if reader.word(index) == "diagnostic" && reader.begins_statement(index) => {
                    Some(reader.directive(index)?)
                }
                _ => None,
            };
            index = next.unwrap_or(index + 1);
        }
        reader
            .filters
            .sort_by_key(|filter| (filter.range.start, std::cmp::Reverse(filter.range.end)));
        Ok(Self(reader.filters))
    }

    /// Places of the filters themselves in the text.
    pub(crate) fn written(&self) -> impl Iterator<Item = Range<usize>> {
        self.0.iter().map(|filter| filter.written.clone())
    }

    /// Severity by the innermost filter for `rule` around `offset`.
    fn severity(&self, rule: &str, offset: usize) -> Option<Severity> {
        let around = self.around(offset);
        let mut of_rule = around.filter(|filter| filter.setting.rule == rule);
        of_rule.next().map(|filter| filter.setting.severity)
    }

    /// Filters that apply at `offset`, innermost first.
    fn around(&self, offset: usize) -> impl Iterator<Item = &Filter> {
        let starts = self
            .0
            .partition_point(|filter| filter.range.start <= offset);
        let before = self.0[..starts].iter().rev();
        before.filter(move |filter| offset < filter.range.end)
    }
}

struct Reader<'a> {
    source: &'a Source,
    tokens: &'a [(Token, Range<usize>)],
    filters: Vec<Filter>,
}

impl Reader<'_> {
    fn word(&self, index: usize) -> &str {
        let range = self.tokens.get(index).map(|(_, range)| range.clone());
        range.map_or("", |range| &self.source.text[range])
    }

    fn begins_statement(&self, index: usize) -> bool {
        let previous = index
            .checked_sub(1)
            .map(|previous| &self.tokens[previous].0);
        // A condition (`@if(…)`) may precede a directive.
        previous.is_none_or(|token| matches!(token, Token::SymSemicolon | Token::SymParenRight))
            && self.word(index + 1) == "("
    }

    /// Reads the attributes that begin at `start`; returns the index of the token after them.
    fn attributes(&mut self, start: usize) -> Result<usize, Fault> {
        let mut settings: Vec<(Setting, Range<usize>)> = Vec::new();
        let mut index = start;
        while self
            .tokens
            .get(index)
            .is_some_and(|(token, _)| *token == Token::SymAttr)
        {
            let end = self.close(index + 2);
            if self.word(index + 1) == "diagnostic" {
                let written = self.tokens[index].1.start..self.end_of(end);
                let setting = self.setting(index + 2, end)?;
                if let Some((_, first)) = settings.iter().find(|(s, _)| s.rule == setting.rule) {
                    let message = format!("`{}` is filtered twice here", setting.rule);
                    return Err(Fault::new(Cause::Syntax, message)
                        .at(self.source.place(written))
                        .at(self.source.place_labelled(first.clone(), "the first"))
                        .note("keep one of them"));
                }
                settings.push((setting, written));
            }
            index = end;
        }
        if settings.is_empty() {
            return Ok(index);
        }
        let (on, end) = match self.word(index) {
            "fn" => (On::Function, self.block_end(index)),
            "{" | "switch" | "loop" | "for" | "while" => (On::Statement, self.block_end(index)),
            "if" => {
                let mut end = self.block_end(index);
                while self.word(end) == "else" {
                    end = self.block_end(end);
                }
                (On::Statement, end)
            }
            _ => {
                let message = "`@diagnostic` may not stand here";
                return Err(Fault::new(Cause::Syntax, message)
                    .at(self.source.place(settings[0].1.clone()))
                    .note("put it before a function, before `if`, `switch`, `loop`, `for` or `while`, or before a block's `{`"));
            }
        };
        let range = self.tokens[start].1.start..self.end_of(end);
        for (setting, written) in settings {
            self.filters.push(Filter {
                setting,
                range: range.clone(),
                written,
                on,
            });
        }
        Ok(index)
    }

    /// Reads the directive at `index`; returns the index of the token after it.
    fn directive(&mut self, index: usize) -> Result<usize, Fault> {
        let end = self.close(index + 1);
        let setting = self.setting(index + 1, end)?;
        let written = self.tokens[index].1.start..self.end_of(end + 1);
        let same =
            |filter: &&Filter| filter.on == On::Module && filter.setting.rule == setting.rule;
        if let Some(other) = self.filters.iter().find(same)
            && other.setting.severity != setting.severity
        {
            let message = format!("`{}` is filtered to two severities", setting.rule);
            return Err(Fault::new(Cause::Syntax, message)
                .at(self.source.place(written))
                .at(self
                    .source
                    .place_labelled(other.written.clone(), "the first"))
                .note("keep one of them, or put the other on the functions that it is for"));
        }
        self.filters.push(Filter {
            setting,
            range: 0..self.source.text.len(),
            written,
            on: On::Module,
        });
        Ok(end + 1)
    }

    /// Setting in the parentheses from `open` to before `end`. The parser has already checked its syntax.
    fn setting(&self, open: usize, end: usize) -> Result<Setting, Fault> {
        let severity = self.word(open + 1);
        let rule = (open + 3..end.saturating_sub(1)).map(|index| self.word(index));
        let rule = rule.collect::<String>().trim_end_matches(',').to_owned();
        match SEVERITIES.iter().find(|(name, _)| *name == severity) {
            Some((_, severity)) => Ok(Setting {
                rule,
                severity: *severity,
            }),
            None => Err(
                Fault::new(Cause::Syntax, format!("`{severity}` is no severity"))
                    .at(self.source.place(match self.tokens.get(open + 1) {
                        Some((_, range)) => range.clone(),
                        None => 0..0,
                    }))
                    .note("write `off`, `info`, `warning` or `error`"),
            ),
        }
    }

    /// Index of the token after the parentheses that open at `open`; `open` where none open there.
    fn close(&self, open: usize) -> usize {
        if self.word(open) != "(" {
            return open;
        }
        let mut depth = 0usize;
        for index in open..self.tokens.len() {
            match self.tokens[index].0 {
                Token::SymParenLeft => depth += 1,
                Token::SymParenRight if depth == 1 => return index + 1,
                Token::SymParenRight => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
        self.tokens.len()
    }

    /// Index of the token after the first block that opens at or after `start`.
    fn block_end(&self, start: usize) -> usize {
        let mut depth = 0usize;
        for index in start..self.tokens.len() {
            match self.tokens[index].0 {
                Token::SymBraceLeft => depth += 1,
                Token::SymBraceRight if depth == 1 => return index + 1,
                Token::SymBraceRight => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
        self.tokens.len()
    }

    /// Offset in the text at which the last token before `end` ends.
    fn end_of(&self, end: usize) -> usize {
        let last = end.checked_sub(1).and_then(|last| self.tokens.get(last));
        last.map_or(0, |(_, range)| range.end)
    }
}

/// The linked modules' texts and filters, by which a span leads to its author's text.
pub(crate) struct Places<'a> {
    pub(crate) library: &'a Library,
    /// By module.
    pub(crate) filters: &'a FxHashMap<usize, Arc<Filters>>,
}

impl<'a> Places<'a> {
    /// Severity of a breach of `rule` at `span`.
    pub(crate) fn severity(&self, rule: Rule, span: Span) -> Severity {
        let found = self.locate(span).and_then(|(module, range)| {
            self.filters
                .get(&module)?
                .severity(rule.name(), range.start)
        });
        found.unwrap_or(Severity::Error)
    }

    pub(crate) fn place(&self, span: Span, label: String) -> Option<Place<'a>> {
        let (module, range) = self.locate(span)?;
        Some(self.library.source(module).place_labelled(range, label))
    }

    /// The author's text at `span`.
    pub(crate) fn text(&self, span: Span) -> &'a str {
        let place = self.place(span, String::new());
        place.map_or("", |place| place.text.get(place.range).unwrap_or(""))
    }

    fn locate(&self, span: Span) -> Option<(usize, Range<usize>)> {
        let range = span.to_range()?;
        let (module, start) = self.library.locate(range.start)?;
        Some((module, start..start + range.len()))
    }

    /// Filters that have no effect, in the modules' order: those of rules that WGSL does not have (browsers warn of
    /// them, too), and those that cannot be written again.
    pub(crate) fn idle_filters(&self) -> Vec<Fault> {
        let mut modules: Vec<_> = self.filters.iter().collect();
        modules.sort_by_key(|(module, _)| **module);
        let mut faults = Vec::new();
        for (module, filters) in modules {
            for filter in &filters.0 {
                let rule = &filter.setting.rule;
                if Rule::known(rule) {
                    continue;
                }
                let place = self.library.source(*module).place(filter.written.clone());
                // A rule's name with a dot in it belongs to another tool.
                if rule.contains('.') {
                    if filter.on == On::Statement {
                        let message =
                            format!("`{rule}` is left out: no statement keeps another tool's rule");
                        let fault = Fault::new(Cause::Syntax, message).at(place);
                        faults.push(fault.note("put it on the function"));
                    }
                    continue;
                }
                let known = Rule::ALL.map(Rule::name);
                let message = format!("WGSL has no diagnostic rule `{rule}`");
                let fault = Fault::new(Cause::Syntax, message).at(place);
                faults.push(match nearest(rule, known) {
                    Some(near) => fault.note(format!("did you mean `{near}`?")),
                    None => fault.note(format!("it has `{}`", known.join("` and `"))),
                });
            }
        }
        faults
    }
}

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
            if !Rule::known(rule) && !rules.contains(&rule) {
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
