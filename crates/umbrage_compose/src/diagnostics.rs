//! Diagnostic filters: `diagnostic(off, derivative_uniformity)`, as a directive, on a function, on a
//! statement or on a block (<https://www.w3.org/TR/WGSL/#diagnostics>).
//!
//! Naga reads filters only on functions, and writes none. So they are read here, blanked out of the text that naga
//! sees, looked up by place, and written again. A directive holds for the functions of its own module.

mod written;

use std::{ops::Range, sync::Arc};

use naga::{Span, diagnostic_filter::Severity};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use umbrage_hints::did_you_mean;
use wgsl_parse::lexer::Token;

use crate::{Cause, Fault, Library, Lint, error::Place, source::Source};

pub(crate) use written::{Written, uses_subgroups};

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

/// Beginning of the rules that are our own lints'.
const OWN: &str = "umbrage.";

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
    pub(crate) fn severity(&self, rule: &str, offset: usize) -> Option<Severity> {
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
        self.severity_of(rule.name(), span)
            .unwrap_or(Severity::Error)
    }

    /// Severity by the innermost filter for `rule` around `span`.
    pub(crate) fn severity_of(&self, rule: &str, span: Span) -> Option<Severity> {
        let (module, range) = self.locate(span)?;
        self.filters.get(&module)?.severity(rule, range.start)
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
                if let Some(name) = rule.strip_prefix(OWN) {
                    if Lint::ALL.iter().all(|lint| lint.name() != name) {
                        let known: Vec<_> = Lint::ALL.iter().map(|lint| lint.name()).collect();
                        let message = format!("umbrage has no lint `{name}`");
                        let fault = Fault::new(Cause::Syntax, message).at(place);
                        faults.push(fault.note(match did_you_mean(name, known.iter().copied()) {
                            Some(hint) => hint,
                            None => format!("it has `{}`", known.join("`, `")),
                        }));
                    }
                    continue;
                }
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
                faults.push(match did_you_mean(rule, known) {
                    Some(hint) => fault.note(hint),
                    None => fault.note(format!("it has `{}`", known.join("` and `"))),
                });
            }
        }
        faults
    }
}
