//! Places in RON texts.

use serde::de::DeserializeOwned;

use crate::{Cause, Error, Fault, error::Place, package::SourceText};

/// Reads a RON text; a fault names the line and column.
pub(crate) fn parse<T: DeserializeOwned>(source: &SourceText, cause: Cause) -> Result<T, Error> {
    let options =
        ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
    options.from_str(&source.text).map_err(|error| {
        let start = offset(&source.text, error.span.start.line, error.span.start.col);
        let end = offset(&source.text, error.span.end.line, error.span.end.col).max(start);
        Fault::new(cause, format!("{}", error.code))
            .at(source.place(start..end))
            .into()
    })
}

fn offset(text: &str, line: usize, column: usize) -> usize {
    let mut start = 0;
    for (index, content) in text.split_inclusive('\n').enumerate() {
        if index + 1 == line {
            let within: usize = content
                .chars()
                .take(column.saturating_sub(1))
                .map(char::len_utf8)
                .sum();
            return start + within;
        }
        start += content.len();
    }
    text.len()
}

/// The place of the word or string literal that follows the others of `path` in turn: RON's values carry no
/// places of their own.
pub(crate) fn literal<'a>(source: &'a SourceText, path: &[&str]) -> Place<'a> {
    let mut start = 0;
    let mut range = 0..0;
    for word in path {
        let quoted = format!("\"{word}\"");
        let text = &source.text[start..];
        let found = text.find(&quoted).map(|at| (at, quoted.len()));
        let found = found.or_else(|| text.find(word).map(|at| (at, word.len())));
        if let Some((at, length)) = found {
            range = start + at..start + at + length;
            start = range.end;
        }
    }
    source.place(range)
}
