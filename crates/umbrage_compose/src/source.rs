//! Modules: a text, its syntax tree, and the tokens of what the tree gives no places for.

use std::{collections::BTreeSet, ops::Range, sync::Arc};

use wgsl_parse::{
    error::{Error as ParseError, ErrorKind},
    lexer::{Lexer, Token},
    parser::TranslationUnitParser,
    syntax::{GlobalDeclaration, TranslationUnit},
};

use crate::{Cause, Fault, error::Place, limits, names::declared};

/// A module's text.
#[derive(Debug)]
pub(crate) struct Source {
    /// The package and the path, joined by `::`.
    pub(crate) path: String,
    /// The package.
    pub(crate) package: usize,
    /// The file, as it was named to the composer.
    pub(crate) file: String,
    /// The text.
    pub(crate) text: Arc<str>,
    /// The reason why the text could not be read.
    pub(crate) fault: Option<Fault>,
    /// Where the text starts among all texts of the library: spans in linked modules count from
    /// the first text's start, so that each tells its file.
    pub(crate) base: usize,
}

/// A module's syntax.
#[derive(Debug)]
pub(crate) struct Syntax {
    pub(crate) tree: TranslationUnit,
    pub(crate) tokens: Vec<(Token, Range<usize>)>,
    /// Names of all functions, whatever features they stand under.
    pub(crate) functions: BTreeSet<String>,
    /// Whether it may have assertions.
    pub(crate) asserts: bool,
}

impl Source {
    pub(crate) fn place(&self, range: Range<usize>) -> Place<'_> {
        self.place_labelled(range, "")
    }

    pub(crate) fn place_labelled(
        &self,
        range: Range<usize>,
        label: impl Into<String>,
    ) -> Place<'_> {
        Place {
            file: &self.file,
            text: &self.text,
            range,
            label: label.into(),
        }
    }

    /// The place of the first `word` that is no part of a comment or of a longer word, for faults that
    /// the syntax tree has no place for.
    pub(crate) fn find(&self, word: &str) -> Place<'_> {
        self.find_within(0..self.text.len(), word)
    }

    /// Place of the first `word` within `range`, as `find` looks for it; the whole range where there is none.
    pub(crate) fn find_within(&self, range: Range<usize>, word: &str) -> Place<'_> {
        let part = |c: char| c.is_alphanumeric() || c == '_';
        let whole = |start: usize| {
            let (before, after) = (&self.text[..start], &self.text[start + word.len()..]);
            !before.ends_with(part) && !after.starts_with(part) && !self.in_comment(start)
        };
        let text = self.text.get(range.clone()).unwrap_or("");
        let mut places = (text.match_indices(word)).map(|(start, _)| range.start + start);
        match places.find(|start| !word.is_empty() && whole(*start)) {
            Some(start) => self.place(start..start + word.len()),
            None if range.len() == self.text.len() => self.place(0..0),
            None => self.place(range),
        }
    }

    /// The components of the module's path within its package.
    pub(crate) fn within_package(&self) -> impl Iterator<Item = &str> {
        self.path.split("::").skip(1)
    }

    /// Whether the module is a contract that others implement: it lies in the folder `interface`
    /// of its package.
    pub(crate) fn is_interface(&self) -> bool {
        self.within_package().next() == Some("interface")
    }

    pub(crate) fn parse(&self) -> Result<Syntax, Fault> {
        if let Some(fault) = &self.fault {
            return Err(match fault.locations.is_empty() {
                true => fault.clone().at(self.place(0..0)),
                false => fault.clone(),
            });
        }
        let tokens = self.tokens()?;
        // The parser would find the tokens again, which takes it as long as all the rest.
        let found = tokens
            .iter()
            .map(|(token, range)| (range.start, token.clone(), range.end));
        let parsed = TranslationUnitParser::new().parse(found);
        let tree = parsed.map_err(ParseError::from).map_err(|error| {
            let message = match &error.error {
                ErrorKind::InvalidToken => "no token of WESL".to_owned(),
                ErrorKind::UnexpectedToken { token, expected } => {
                    format!("unexpected {}{}", quoted(token), alternatives(expected))
                }
                ErrorKind::UnexpectedEof { expected } => {
                    format!("unexpected end of file{}", alternatives(expected))
                }
                other => other.to_string(),
            };
            let message = self.beyond_wgsl(error.span.range()).unwrap_or(message);
            let last = self.text.trim_end().len();
            let start = error.span.start.min(last);
            let misplaced = misplaced(&tokens, start);
            let (better, advice) = misplaced.unwrap_or_default();
            let fault = Fault::new(Cause::Syntax, better.unwrap_or(message))
                .at(self.place(start..error.span.end.min(last)));
            match advice {
                "" => fault,
                advice => fault.note(advice),
            }
        })?;
        let functions = tree
            .global_declarations
            .iter()
            .filter(|node| matches!(node.node(), GlobalDeclaration::Function(_)))
            .filter_map(|node| declared(node));
        Ok(Syntax {
            functions: functions.collect(),
            asserts: self.text.contains("const_assert"),
            tree,
            tokens,
        })
    }

    /// Message for a `range` that the parser does not know, where it is a native extension of WGSL.
    fn beyond_wgsl(&self, range: Range<usize>) -> Option<String> {
        let place = self.text.get(range.clone())?;
        let before = self.text[..range.start].chars().next_back();
        let what = match place {
            "binding_array" => "the type `binding_array`".to_owned(),
            "lu" | "li" | "lf" if before.is_some_and(|c| c.is_ascii_digit()) => {
                format!("the suffix `{place}` of a 64-bit number")
            }
            _ if place.starts_with("@builtin(") => {
                let name = place["@builtin(".len()..].trim_end_matches(')').trim();
                format!("the built-in value `{name}`")
            }
            _ if place.starts_with("var<") => {
                const OWN: [&str; 5] = ["function", "private", "workgroup", "uniform", "storage"];
                let space = place["var<".len()..].split(['>', ',']).next()?.trim();
                if OWN.contains(&space) {
                    return None;
                }
                format!("the address space `{space}`")
            }
            _ => return None,
        };
        Some(format!(
            "{what} is none of WGSL's, and what some devices offer beyond it modules cannot ask for"
        ))
    }

    fn tokens(&self) -> Result<Vec<(Token, Range<usize>)>, Fault> {
        limits::check(&self.text).map_err(|(message, range)| {
            Fault::new(Cause::Syntax, message)
                .at(self.place(range))
                .note("name inner parts with `let`, or move them into functions and modules")
        })?;
        let mut tokens = Vec::new();
        let mut end_of_last = 0;
        for token in Lexer::new(&self.text) {
            let (start, token, end) = token.map_err(|(start, _, end)| {
                Fault::new(Cause::Syntax, "no token of WESL").at(self.place(start..end))
            })?;
            self.check_gap(end_of_last..start)?;
            end_of_last = end;
            tokens.push((token, start..end));
        }
        self.check_gap(end_of_last..self.text.len())?;
        Ok(tokens)
    }

    /// Whether there are only spaces and comments in `range`, between two tokens: the lexer passes
    /// over what it does not know.
    fn check_gap(&self, range: Range<usize>) -> Result<(), Fault> {
        let mut rest = self.text.get(range.clone()).unwrap_or("");
        if rest.bytes().all(|byte| byte.is_ascii_whitespace()) {
            return Ok(());
        }
        loop {
            rest = rest
                .trim_start_matches(|c: char| c.is_whitespace() || "\u{200e}\u{200f}".contains(c));
            if rest.starts_with("//") {
                rest = rest.find('\n').map_or("", |end| &rest[end..]);
            } else if rest.starts_with("/*") {
                rest = after_block_comment(rest);
            } else {
                break;
            }
        }
        match rest.chars().next() {
            None => Ok(()),
            Some(stray) => {
                let start = range.end - rest.len();
                Err(
                    Fault::new(Cause::Syntax, format!("`{stray}` is no token of WESL"))
                        .at(self.place(start..start + stray.len_utf8())),
                )
            }
        }
    }

    fn in_comment(&self, index: usize) -> bool {
        let before = &self.text[..index];
        let line = before.rsplit('\n').next().unwrap_or("");
        let open = before
            .rfind("/*")
            .is_some_and(|at| !before[at..].contains("*/"));
        line.contains("//") || open
    }
}

/// A better message and advice, where the token at `start` is valid in modules, but not at this place.
fn misplaced(
    tokens: &[(Token, Range<usize>)],
    start: usize,
) -> Option<(Option<String>, &'static str)> {
    const ORDER: &str = "imports come first, then directives (`enable`, `requires`, `diagnostic`), then \
                         declarations";
    let at = tokens.iter().position(|(_, range)| range.start == start)?;
    let before = || tokens[..at].iter().map(|(token, _)| token);
    let in_import = before()
        .rev()
        .take_while(|token| **token != Token::SymSemicolon)
        .any(|token| *token == Token::KwImport);
    let word = match &tokens[at].0 {
        Token::SymStar if in_import => {
            let message = "all that a module has cannot be imported at once";
            let advice = "name what is imported, as in `import package::lights::{sun, lamp};`, or import the \
                          module, and write `lights::sun`";
            return Some((Some(message.to_owned()), advice));
        }
        _ if in_import => {
            let advice = "a path is names joined by `::`, each of letters, digits and `_`, no digit first; a \
                          file of another name cannot be imported: rename it";
            return Some((None, advice));
        }
        Token::KwImport => "an import",
        Token::KwEnable => "`enable`",
        Token::KwRequires => "`requires`",
        Token::KwDiagnostic => "`diagnostic`",
        _ => return None,
    };
    let depth = before().fold(0i32, |depth, token| match token {
        Token::SymBraceLeft => depth + 1,
        Token::SymBraceRight => depth - 1,
        _ => depth,
    });
    // Each statement and each declaration begins where another ends.
    let (mut begins, mut last) = (true, "a directive");
    for token in before() {
        let directive = [
            Token::KwEnable,
            Token::KwRequires,
            Token::KwDiagnostic,
            Token::KwImport,
        ];
        if begins && *token != Token::SymAttr && !directive.contains(token) {
            last = "a declaration";
        }
        begins = matches!(token, Token::SymSemicolon | Token::SymBraceRight);
    }
    let message = match depth {
        0 => format!("{word} after {last}"),
        _ => format!("{word} within a declaration"),
    };
    Some((Some(message), ORDER))
}

fn quoted(token: &str) -> String {
    if token.contains('`') {
        token.to_owned()
    } else {
        format!("`{token}`")
    }
}

/// Finds the rest of `text` after the block comment at its start; such comments nest.
fn after_block_comment(text: &str) -> &str {
    let mut depth = 0usize;
    let mut index = 0;
    while index < text.len() {
        let rest = &text.as_bytes()[index..];
        if rest.starts_with(b"/*") {
            depth += 1;
            index += 2;
        } else if rest.starts_with(b"*/") {
            depth = depth.saturating_sub(1);
            index += 2;
            if depth == 0 {
                return &text[index..];
            }
        } else {
            index += 1;
        }
    }
    ""
}

/// The parser lists every token that it would take: of many, only what ends something is told.
fn alternatives(expected: &[String]) -> String {
    const MOST: usize = 4;
    let mut known: Vec<_> = expected
        .iter()
        .map(|token| token.replace('"', "`"))
        .collect();
    known.sort();
    known.dedup();
    if known.len() > MOST {
        known.retain(|token| token == "`;`" || token == "`}`" || token == "`)`");
    }
    match known.as_slice() {
        [] => String::new(),
        [one] => format!(", expected {one}"),
        several => format!(", expected one of {}", several.join(", ")),
    }
}
