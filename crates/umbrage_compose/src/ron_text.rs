//! Places in RON texts.

use std::{collections::BTreeMap, fmt, marker::PhantomData};

use serde::{
    Deserialize,
    de::{DeserializeOwned, Error as _, MapAccess, Visitor},
};

use crate::{Cause, Error, Fault, error::Place, file::SourceText};

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

/// A map in which each key stands once: RON lets a later one win.
pub(crate) fn unique<'de, D, K, V>(deserializer: D) -> Result<BTreeMap<K, V>, D::Error>
where
    D: serde::Deserializer<'de>,
    K: Deserialize<'de> + Ord + fmt::Display,
    V: Deserialize<'de>,
{
    struct Unique<K, V>(PhantomData<(K, V)>);
    impl<'de, K, V> Visitor<'de> for Unique<K, V>
    where
        K: Deserialize<'de> + Ord + fmt::Display,
        V: Deserialize<'de>,
    {
        type Value = BTreeMap<K, V>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a map")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Self::Value, A::Error> {
            let mut map = BTreeMap::new();
            while let Some(key) = entries.next_key::<K>()? {
                // Before the value is read, so that the place is the key's.
                if map.contains_key(&key) {
                    return Err(A::Error::custom(format!("`{key}` stands twice")));
                }
                map.insert(key, entries.next_value()?);
            }
            Ok(map)
        }
    }
    deserializer.deserialize_map(Unique(PhantomData))
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

/// The place of the word or string literal that follows the others of `path` in turn, comments apart: RON's
/// values carry no places of their own.
pub(crate) fn literal<'a>(source: &'a SourceText, path: &[&str]) -> Place<'a> {
    let code = without_comments(&source.text);
    let mut start = 0;
    let mut range = 0..0;
    for word in path {
        let quoted = format!("\"{word}\"");
        let text = &code[start..];
        let found = text.find(&quoted).map(|at| (at, quoted.len()));
        let found = found.or_else(|| text.find(word).map(|at| (at, word.len())));
        if let Some((at, length)) = found {
            range = start + at..start + at + length;
            start = range.end;
        }
    }
    source.place(range)
}

/// The text with spaces in the place of line comments, as long as before in bytes.
fn without_comments(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let (mut is_string, mut is_escaped) = (false, false);
    let mut rest = text;
    while let Some(next) = rest.chars().next() {
        let length = match !is_string && rest.starts_with("//") {
            true => rest.find('\n').unwrap_or(rest.len()),
            false => 0,
        };
        code.extend(std::iter::repeat_n(' ', length));
        if length == 0 {
            code.push(next);
            is_string ^= next == '"' && !is_escaped;
            is_escaped = is_string && next == '\\' && !is_escaped;
        }
        rest = &rest[length.max(next.len_utf8())..];
    }
    code
}
