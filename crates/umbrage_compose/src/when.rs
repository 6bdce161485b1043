//! Which keys something is said of, in files that others than manifests read.

use std::{collections::BTreeMap, fmt, ops::Range, path::Path};

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeOwned, SeqAccess, Visitor},
};

use crate::{Axes, Cause, Error, Fault, Key, file::SourceText, ron_text};

/// A RON file that a person wrote, to be read and pointed into.
#[derive(Clone, Debug)]
pub struct RonFile(SourceText);

impl RonFile {
    /// A text that faults call `file`.
    pub fn new(file: impl Into<String>, text: impl Into<String>) -> Self {
        Self(SourceText::new(file, text.into()))
    }

    /// All of the text: bytes.
    pub fn all(&self) -> Range<usize> {
        0..self.0.text.len()
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
    /// What is no RON, or not of this type: with its line and column.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, Error> {
        ron_text::parse(&self.0, Cause::Manifest)
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
        ron_text::unique(deserializer)
    }

    /// Where each entry of the list in the field `rules` stands: bytes of the text.
    ///
    /// # Errors
    /// Where the file has no such list.
    pub fn rules(&self) -> Result<Vec<Range<usize>>, Error> {
        #[derive(Deserialize)]
        struct Rules {
            rules: Vec<Box<ron::value::RawValue>>,
        }
        let mut from = 0;
        let rules = self.parse::<Rules>()?.rules;
        let ranges = rules.iter().map(|rule| {
            let text = rule.trim().get_ron();
            // It was read from this text, and in this order.
            let start = from + self.0.text[from..].find(text).unwrap_or(0);
            from = start + text.len();
            start..from
        });
        Ok(ranges.collect())
    }

    /// A fault of this file, at the last of `words` as they follow each other from `range` on, outside comments;
    /// with no words, at all of `range`.
    pub fn fault(&self, message: impl Into<String>, range: Range<usize>, words: &[&str]) -> Fault {
        self.place(Fault::new(Cause::Manifest, message), range, words)
    }

    fn place(&self, mut fault: Fault, range: Range<usize>, words: &[&str]) -> Fault {
        fault.cause = Cause::Manifest;
        let start = range.start;
        if words.is_empty() {
            return fault.at(self.0.place(range));
        }
        let part = SourceText::new(self.0.file.as_str(), &self.0.text[range]);
        let found = ron_text::literal(&part, words).range;
        fault.at(self.0.place(start + found.start..start + found.end))
    }
}

/// Values for some axes, such as `{ "method": "basic", "pcf": ["3", "5"] }`: keys fit that have, on each of
/// these axes, one of its values. Every key fits where there is no axis.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(transparent)]
pub struct When(#[serde(deserialize_with = "ron_text::unique")] BTreeMap<String, Values>);

impl When {
    /// Whether `key` fits. Where the key says nothing, the axis's default counts.
    pub fn fits(&self, axes: &Axes, key: &Key) -> bool {
        self.0.iter().all(|(axis, values)| {
            let value = axes.value(key, axis);
            value.is_some_and(|value| values.0.iter().any(|known| known == value))
        })
    }

    /// Checks that the axes and their values exist. The fault is in `file`, in the bytes `range` that this was
    /// read from.
    ///
    /// # Errors
    /// An unknown axis or value.
    pub fn check(&self, axes: &Axes, file: &RonFile, range: Range<usize>) -> Result<(), Fault> {
        for (name, values) in &self.0 {
            let axis = axes
                .check_axis(name)
                .map_err(|fault| file.place(fault, range.clone(), &[name]))?;
            for value in &values.0 {
                axes.check_value(axis, value)
                    .map_err(|fault| file.place(fault, range.clone(), &[name, value]))?;
            }
        }
        Ok(())
    }
}

/// A value, or a list of them.
#[derive(Clone, Debug)]
struct Values(Vec<String>);

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrSeveral;
        impl<'de> Visitor<'de> for OneOrSeveral {
            type Value = Values;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a value or a list of values, as strings")
            }

            fn visit_str<E>(self, value: &str) -> Result<Values, E> {
                Ok(Values(vec![value.to_owned()]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Values, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = list.next_element()? {
                    values.push(value);
                }
                Ok(Values(values))
            }
        }
        deserializer.deserialize_any(OneOrSeveral)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> RonFile {
        RonFile::new("rules.ron", text)
    }

    fn axes() -> Axes {
        let text = r#"(axes: {
            "filter": (default: "soft", values: { "soft": (), "hard": () }),
            "light": (values: { "sun": (), "lamp": () }),
        })"#;
        let mut axes = Axes::default();
        axes.merge("demo", &file(text).0).unwrap();
        axes
    }

    #[test]
    fn keys_fit_that_have_a_value_on_each_axis() {
        let axes = axes();
        let soft_sun = axes.key([("light", "sun")]).unwrap();
        let hard_lamp = axes.key([("light", "lamp"), ("filter", "hard")]).unwrap();
        for (text, of_sun, of_lamp) in [
            (r#"{}"#, true, true),
            (r#"{ "filter": "soft" }"#, true, false),
            (r#"{ "filter": ["soft", "hard"] }"#, true, true),
            (r#"{ "filter": [] }"#, false, false),
            (r#"{ "filter": "hard", "light": ["lamp"] }"#, false, true),
            (r#"{ "filter": "hard", "light": "sun" }"#, false, false),
        ] {
            let when: When = file(text).parse().unwrap();
            assert_eq!(when.fits(&axes, &soft_sun), of_sun, "{text}");
            assert_eq!(when.fits(&axes, &hard_lamp), of_lamp, "{text}");
        }
    }

    #[test]
    fn a_fault_is_in_its_own_rule() {
        let text = "(rules: [\n  { \"light\": \"sun\" }, // \"light\": \"moon\"\n  { \"light\": \"moon\" },\n])";
        let file = file(text);
        let ranges = file.rules().unwrap();
        assert_eq!(&text[ranges[0].clone()], r#"{ "light": "sun" }"#);
        let when: When = RonFile::new("", &text[ranges[1].clone()]).parse().unwrap();
        let fault = when.check(&axes(), &file, ranges[1].clone()).unwrap_err();
        let at = fault.location().unwrap();
        assert_eq!((at.line, at.column), (3, 14));
        assert!(fault.to_string().contains("lamp, sun"), "{fault}");
        let whole = file.fault("needless", ranges[1].clone(), &[]);
        assert_eq!(whole.location().map(|at| at.line), Some(3));
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
    fn what_is_no_choice_has_its_place() {
        for (text, line) in [
            ("{\n \"a\": 3 }", 2),
            ("{ \"a\": \"b\",\n \"a\": \"c\" }", 2),
            ("{ \"a\": [\"b\",\n 1] }", 2),
        ] {
            let error = file(text).parse::<When>().unwrap_err();
            let at = error.faults()[0].location().unwrap();
            assert_eq!(at.line, line, "{error}");
        }
    }
}
