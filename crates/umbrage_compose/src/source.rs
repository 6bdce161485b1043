//! Modules: a text, its syntax tree, and the tokens of what the tree gives no places for.

use std::{ops::Range, sync::Arc};

use wgsl_parse::{
    error::ErrorKind,
    lexer::{Lexer, Token},
    syntax::TranslationUnit,
};

use crate::{Cause, Fault, error::Place};

/// Brackets nested deeper than this are refused: parsers and drops of syntax trees recurse.
const DEEPEST_NESTING: usize = 200;

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

    pub(crate) fn place_labelled(&self, range: Range<usize>, label: impl Into<String>) -> Place<'_> {
        Place { file: &self.file, text: &self.text, range, label: label.into() }
    }

    /// The place of the first `word` in the text, for faults of a whole module.
    pub(crate) fn find(&self, word: &str) -> Place<'_> {
        let start = self.text.find(word).unwrap_or(0);
        let length = if self.text[start..].starts_with(word) { word.len() } else { 0 };
        self.place(start..start + length)
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
                    format!("unexpected {}, expected {}", quoted(token), alternatives(expected))
                }
                ErrorKind::UnexpectedEof { expected } => {
                    format!("unexpected end of file, expected {}", alternatives(expected))
                }
                other => other.to_string(),
            };
            Fault::new(Cause::Syntax, message).at(self.place(error.span.range()))
        })?;
        Ok(Syntax { tree, tokens })
    }

    fn tokens(&self) -> Result<Vec<(Token, Range<usize>)>, Fault> {
        self.check_nesting()?;
        let mut tokens = Vec::new();
        for token in Lexer::new(&self.text) {
            let (start, token, end) = token.map_err(|(start, _, end)| {
                Fault::new(Cause::Syntax, "no token of WESL").at(self.place(start..end))
            })?;
            tokens.push((token, start..end));
        }
        Ok(tokens)
    }

    fn check_nesting(&self) -> Result<(), Fault> {
        let mut depth = 0usize;
        let mut prefixes = 0usize;
        for (index, byte) in self.text.bytes().enumerate() {
            match byte {
                b'(' | b'[' | b'{' | b'<' => depth += 1,
                // `<` may be less-than: statements end what it opened.
                b')' | b']' | b'}' | b'>' => depth = depth.saturating_sub(1),
                b';' => depth = depth.min(DEEPEST_NESTING / 2),
                _ => {}
            }
            match byte {
                b'!' | b'-' | b'~' | b'&' | b'*' => prefixes += 1,
                byte if byte.is_ascii_whitespace() => {}
                _ => prefixes = 0,
            }
            // A row of stars or dashes in a comment is no expression.
            let comment = prefixes > DEEPEST_NESTING && self.in_comment(index);
            if depth > DEEPEST_NESTING || (prefixes > DEEPEST_NESTING && !comment) {
                let message = format!("nested more than {DEEPEST_NESTING} deep");
                return Err(Fault::new(Cause::Syntax, message)
                    .at(self.place(index..index + 1))
                    .note("name the inner parts with `let`, or move them into functions"));
            }
        }
        Ok(())
    }

    fn in_comment(&self, index: usize) -> bool {
        let before = &self.text[..index];
        let line = before.rsplit('\n').next().unwrap_or("");
        let open = before.rfind("/*").is_some_and(|at| !before[at..].contains("*/"));
        line.contains("//") || open
    }
}

fn quoted(token: &str) -> String {
    if token.contains('`') { token.to_owned() } else { format!("`{token}`") }
}

/// The parser lists every token that it would take: more than a few tell nothing.
fn alternatives(expected: &[String]) -> String {
    const MOST: usize = 6;
    let mut known: Vec<_> = expected.iter().map(|token| token.replace('"', "`")).collect();
    known.sort();
    known.dedup();
    match known.len() {
        0 => "something else".to_owned(),
        1 => known.remove(0),
        2..=MOST => format!("one of {}", known.join(", ")),
        _ => "something else here".to_owned(),
    }
}
