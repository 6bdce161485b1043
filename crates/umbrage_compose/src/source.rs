//! Modules: a text, its syntax tree, and the tokens of what the tree gives no places for.

use std::{ops::Range, sync::Arc};

use wgsl_parse::{
    error::ErrorKind,
    lexer::{Lexer, Token},
    syntax::TranslationUnit,
};

use crate::{Cause, Fault, error::Place, limits};

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
    /// Where the text starts among all texts of the library: spans in linked modules count from
    /// the first text's start, so that each tells its file.
    pub(crate) base: usize,
}

/// A module's syntax.
#[derive(Debug)]
pub(crate) struct Syntax {
    pub(crate) tree: TranslationUnit,
    pub(crate) tokens: Vec<(Token, Range<usize>)>,
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
        let part = |c: char| c.is_alphanumeric() || c == '_';
        let whole = |start: usize| {
            let (before, after) = (&self.text[..start], &self.text[start + word.len()..]);
            !before.ends_with(part) && !after.starts_with(part) && !self.in_comment(start)
        };
        let mut places = self.text.match_indices(word).map(|(start, _)| start);
        match places.find(|start| !word.is_empty() && whole(*start)) {
            Some(start) => self.place(start..start + word.len()),
            None => self.place(0..0),
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
        let tokens = self.tokens()?;
        let tree = wgsl_parse::parse_str(&self.text).map_err(|error| {
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
            let last = self.text.trim_end().len();
            let start = error.span.start.min(last);
            Fault::new(Cause::Syntax, message).at(self.place(start..error.span.end.min(last)))
        })?;
        Ok(Syntax { tree, tokens })
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

fn quoted(token: &str) -> String {
    if token.contains('`') {
        token.to_owned()
    } else {
        format!("`{token}`")
    }
}

/// What follows the block comment at the start of `text`; such comments nest.
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
