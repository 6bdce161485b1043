//! RON that people write: what is wrong in it has a place, and so has what is said in it.

use std::{collections::BTreeMap, fmt, marker::PhantomData, ops::Range, path::Path};

use ron::{error::SpannedError, extensions::Extensions, value::RawValue};
use serde::{
    Deserialize, Deserializer,
    de::{DeserializeOwned, Error as _, MapAccess, SeqAccess, Visitor},
};
use umbrage_hints::did_you_mean;

use crate::{Cause, Error, Fault, error::Place, file::SourceText};

/// A RON file that a person wrote, to be read and pointed into: every such file of the project is read by it, so
/// that each fault has its line and column, and says what may be meant.
///
/// ```
/// use umbrage_compose::RonFile;
///
/// #[derive(Debug, serde::Deserialize)]
/// #[serde(deny_unknown_fields)]
/// struct Lamp {
///     watts: f64,
/// }
///
/// let file = RonFile::new("lamps.ron", "[\n    (watts: 60),\n    (wats: 25),\n]");
/// let error = file.parse::<Vec<Lamp>>().unwrap_err().to_string();
/// assert!(error.contains("lamps.ron:3:6") && error.contains("did you mean `watts`?"));
///
/// // What RON cannot know to be wrong is pointed at by its path.
/// let fault = file.fault("a lamp is too bright", file.at("[0].watts"), &[]);
/// assert_eq!(fault.location().map(|at| (at.line, at.column)), Some((2, 13)));
/// ```
#[derive(Clone, Debug)]
pub struct RonFile(SourceText);

impl RonFile {
    /// A text that faults call `file`.
    pub fn new(file: impl Into<String>, text: impl Into<String>) -> Self {
        Self(SourceText::new(file, text.into()))
    }

    /// Reads the file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn load(path: &Path) -> Result<Self, Error> {
        SourceText::read(path).map(Self)
    }

    /// The file as a value. An option may be given without `Some`.
    ///
    /// # Errors
    /// Text that is no RON, or not of this type: with its line and column, and the name that may be meant.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, Error> {
        parse(&self.0)
    }

    /// Reads a map in which each key stands once, for `#[serde(deserialize_with = "RonFile::unique")]`: RON lets a
    /// later entry win.
    ///
    /// # Errors
    /// A key that stands twice, and what is no such map.
    pub fn unique<'de, D, K, V>(deserializer: D) -> Result<BTreeMap<K, V>, D::Error>
    where
        D: Deserializer<'de>,
        K: Deserialize<'de> + Ord + fmt::Display,
        V: Deserialize<'de>,
    {
        unique(deserializer)
    }

    /// All of the text: bytes.
    pub fn all(&self) -> Range<usize> {
        0..self.0.text.len()
    }

    /// Where the value at `path` stands, such as `lights[1].kind.range` or `[0]`: bytes of the text. Of a path
    /// that the file has only the beginning of, the empty range where that begins.
    pub fn at(&self, path: &str) -> Range<usize> {
        at(&self.0, path)
    }

    /// A fault of this file, at the last of `words` as they follow each other from `range` on, outside comments;
    /// with no words, at all of `range`.
    pub fn fault(&self, message: impl Into<String>, range: Range<usize>, words: &[&str]) -> Fault {
        self.place(Fault::new(Cause::Manifest, message), range, words)
    }

    /// `fault` as one of this file, at such a place.
    pub(crate) fn place(&self, mut fault: Fault, range: Range<usize>, words: &[&str]) -> Fault {
        fault.cause = Cause::Manifest;
        let start = range.start;
        if words.is_empty() {
            return fault.at(self.0.place(range));
        }
        let part = SourceText::new(self.0.file.as_str(), &self.0.text[range]);
        let found = literal(&part, words).range;
        fault.at(self.0.place(start + found.start..start + found.end))
    }
}

/// Reads a RON text; a fault names the line and column.
pub(crate) fn parse<T: DeserializeOwned>(source: &SourceText) -> Result<T, Error> {
    let parsed = options().from_str(&source.text);
    parsed.map_err(|error| refused(source, &error).into())
}

/// Where the value at `path` stands: see [`RonFile::at`].
pub(crate) fn at(source: &SourceText, path: &str) -> Range<usize> {
    let text = &*source.text;
    let mut value = text;
    let mut is_whole = true;
    for step in path.split(['.', '[']).filter(|step| !step.is_empty()) {
        let step = step.trim_end_matches(']');
        let parts = options().from_str::<Parts<'_>>(value);
        let parts = parts.map_or_else(|_| Vec::new(), |parts| parts.0);
        let part = parts.into_iter().find(|(name, _)| name == step);
        is_whole = part.is_some();
        let Some((_, part)) = part else { break };
        value = part.trim().get_ron();
    }
    // It is a part of the text, not a copy.
    let start = value.as_ptr() as usize - text.as_ptr() as usize;
    start..start + if is_whole { value.len() } else { 0 }
}

fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

fn refused(source: &SourceText, error: &SpannedError) -> Fault {
    let start = offset(&source.text, error.span.start.line, error.span.start.col);
    let end = offset(&source.text, error.span.end.line, error.span.end.col).max(start);
    let message = lowercase(error.code.to_string());
    let fault = Fault::new(Cause::Manifest, message).at(source.place(start..end));
    let hint = match &error.code {
        ron::Error::NoSuchStructField {
            expected, found, ..
        }
        | ron::Error::NoSuchEnumVariant {
            expected, found, ..
        } => did_you_mean(found, expected.iter().copied()),
        _ => None,
    };
    match hint {
        Some(hint) => fault.note(hint),
        None => fault,
    }
}

/// `message` as a fragment, as all faults' messages are; RON's begin with a capital.
fn lowercase(message: String) -> String {
    let mut characters = message.chars();
    match characters.next() {
        Some(first) => first.to_lowercase().chain(characters).collect(),
        None => message,
    }
}

/// The parts of a value, as they stand in the text, by field or key, or by number in a list.
struct Parts<'a>(Vec<(String, &'a RawValue)>);

impl<'de: 'a, 'a> Deserialize<'de> for Parts<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Whole;
        impl<'de> Visitor<'de> for Whole {
            type Value = Vec<(String, &'de RawValue)>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a value with parts")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut parts = Vec::new();
                while let Some(part) = map.next_entry()? {
                    parts.push(part);
                }
                Ok(parts)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
                let mut parts = Vec::new();
                while let Some(part) = list.next_element()? {
                    parts.push((parts.len().to_string(), part));
                }
                Ok(parts)
            }

            fn visit_some<D: Deserializer<'de>>(self, inner: D) -> Result<Self::Value, D::Error> {
                inner.deserialize_any(self)
            }
        }
        deserializer.deserialize_any(Whole).map(Parts)
    }
}

/// A map in which each key stands once: RON lets a later one win.
pub(crate) fn unique<'de, D, K, V>(deserializer: D) -> Result<BTreeMap<K, V>, D::Error>
where
    D: Deserializer<'de>,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> RonFile {
        RonFile::new("rules.ron", text)
    }

    #[test]
    fn what_a_comment_says_is_not_meant() {
        let text =
            "// sun, \"moon\": a lamp\n(a: \"// \\\" sun\", // moon\n moon: \"lämp\", b: \"lamp\")";
        let file = file(text);
        let place = |words: &[&str]| {
            let fault = file.fault("wrong", file.all(), words);
            fault.location().map(|at| (at.line, at.column))
        };
        assert_eq!(place(&["moon"]), Some((3, 2)));
        assert_eq!(place(&["sun"]), Some((2, 12)));
        assert_eq!(place(&["moon", "lamp"]), Some((3, 19)));
    }

    #[test]
    fn a_path_leads_to_its_value() {
        let text = "// a: 1\n#![enable(implicit_some)]\nScene(x1: 1, /* b */ a: [1, Some((c: \"a\")), spot(c: 1 // 2\n)], d: 7)";
        let file = file(text);
        for (path, expected) in [
            ("x1", "1"),
            ("a[0]", "1"),
            ("a[1].c", "\"a\""),
            ("a[2]", "spot(c: 1 // 2\n)"),
            ("a[2].c", "1"),
            ("d", "7"),
        ] {
            assert_eq!(&text[file.at(path)], expected, "{path}");
        }
        let list = file.at("a").start;
        for path in ["a[3]", "a[x].y", "a.b.c", "a[18446744073709551616]"] {
            assert_eq!(file.at(path), list..list, "{path}");
        }
        assert_eq!(file.at("d.e"), file.at("d").start..file.at("d").start);
        assert_eq!(file.at("e"), 0..0);
        assert_eq!(file.at(""), file.all());
    }

    #[test]
    fn no_text_and_no_path_is_too_strange() {
        for text in [
            "",
            "(",
            "(a: (",
            "\u{feff}",
            "[[[[",
            "(a: 'x)",
            "{1: 2}",
            "(a: r#\"b)",
        ] {
            for path in ["", "a", "[0]", "a..b", "]]", "[", "ä", "1"] {
                let at = file(text).at(path);
                assert!(text.get(at.clone()).is_some(), "{text:?} {path:?}: {at:?}");
            }
        }
    }

    #[test]
    fn what_may_be_meant_is_said() {
        #[derive(Debug, Deserialize)]
        #[serde(deny_unknown_fields, rename_all = "snake_case")]
        #[expect(dead_code, reason = "only how it is read counts")]
        enum Shape {
            Sphere { radius: f32 },
        }
        for (text, at, hint) in [
            ("\nspere(radius: 1)", (2, 1), "did you mean `sphere`?"),
            ("sphere(\n  radios: 1)", (2, 3), "did you mean `radius`?"),
        ] {
            let error = file(text).parse::<Shape>().unwrap_err();
            let fault = &error.faults()[0];
            let found = fault.location().map(|at| (at.line, at.column));
            assert_eq!(
                (found, fault.notes.as_slice()),
                (Some(at), &[hint.to_owned()][..])
            );
            assert!(fault.message.starts_with("unexpected "), "{fault}");
        }
    }
}
