//! Sets of keys that something is said of, in files other than manifests.

use std::{collections::BTreeMap, fmt, ops::Range};

use serde::{
    Deserialize, Deserializer,
    de::{SeqAccess, Visitor},
};

use crate::{Axes, Fault, Key, RonFile, ron_text};

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
    use crate::file::SourceText;

    fn file(text: &str) -> RonFile {
        RonFile::new("rules.ron", text)
    }

    fn axes() -> Axes {
        let text = r#"(axes: {
            "filter": (default: "soft", values: { "soft": (), "hard": () }),
            "light": (values: { "sun": (), "lamp": () }),
        })"#;
        let mut axes = Axes::default();
        axes.merge("demo", &SourceText::new("axes.ron", text), &[])
            .unwrap();
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
        let moon = file.at("rules[1]");
        let when: When = RonFile::new("", &text[moon.clone()]).parse().unwrap();
        let fault = when.check(&axes(), &file, moon.clone()).unwrap_err();
        let at = fault.location().unwrap();
        assert_eq!((at.line, at.column), (3, 14));
        assert!(fault.to_string().contains("lamp, sun"), "{fault}");
        let whole = file.fault("needless", moon, &[]);
        assert_eq!(whole.location().map(|at| at.line), Some(3));
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
