//! The limits that the hard cases are held to: `limits.ron`, and how it is read.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt,
    marker::PhantomData,
    path::{Path, PathBuf},
    sync::LazyLock,
};

use ron::extensions::Extensions;
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error as _, MapAccess, Visitor},
};
use umbrage_shadow::names::{nearest, suggestion};

use super::judge::{NEVER_EXCEPTED, figure_names};

/// The limits of all hard cases.
///
/// A method meets a case where it meets each of its limits: those of `every`, those of the case's
/// `any`, which stand in their place, and its own under `methods`. What it cannot meet is listed
/// under `exceptions` with the reason; its own limit then says how far it may go.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// For all methods in all cases, wherever the case has the figure.
    #[serde(deserialize_with = "unique")]
    pub(super) every: Bounds,
    #[serde(deserialize_with = "unique")]
    pub(super) cases: BTreeMap<CaseName, CaseLimits>,
}

/// The limits of one case.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct CaseLimits {
    /// For all methods. The case must have the figure.
    #[serde(deserialize_with = "unique")]
    pub(super) any: Bounds,
    /// For a method, beside those for all.
    #[serde(deserialize_with = "unique")]
    pub(super) methods: BTreeMap<String, OwnLimits>,
    /// What a method does not meet of the limits for all, and why.
    #[serde(deserialize_with = "unique")]
    pub(super) exceptions: BTreeMap<String, Exceptions>,
}

/// Limits by figure.
pub(super) type Bounds = BTreeMap<Figure, Limit>;

/// A method's own limits.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub(super) struct OwnLimits(#[serde(deserialize_with = "unique")] pub(super) Bounds);

/// Reasons by figure.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub(super) struct Exceptions(
    #[serde(deserialize_with = "unique")] pub(super) BTreeMap<Excepted, Reason>,
);

/// What a figure must not exceed, or not fall below.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, try_from = "WrittenLimit")]
pub struct Limit {
    /// The most that the figure may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// The least that it may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// What the limit follows from.
    pub why: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Limit")]
struct WrittenLimit {
    most: Option<f64>,
    least: Option<f64>,
    why: Reason,
}

impl TryFrom<WrittenLimit> for Limit {
    type Error = String;

    fn try_from(written: WrittenLimit) -> Result<Self, String> {
        let WrittenLimit { most, least, why } = written;
        if most.is_some() == least.is_some() {
            return Err("a limit is either the `most` or the `least`; give one of them".to_owned());
        }
        for value in [most, least].into_iter().flatten() {
            if !(value.is_finite() && value >= 0.0) {
                return Err(format!(
                    "a limit is {value}, but must be finite and not below 0"
                ));
            }
        }
        let why = why.0;
        Ok(Self { most, least, why })
    }
}

impl Limit {
    /// Whether it holds; not for what is no number.
    pub fn holds(&self, found: f64) -> bool {
        !found.is_nan()
            && self.most.is_none_or(|most| found <= most)
            && self.least.is_none_or(|least| found >= least)
    }

    /// Whether some figure meets `other` and not this one.
    fn is_stricter_than(&self, other: &Self) -> bool {
        let less = |own: Option<f64>, general: Option<f64>| match (own, general) {
            (Some(own), Some(general)) => own < general,
            (own, _) => own.is_some(),
        };
        less(self.most, other.most) || less(other.least, self.least)
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.most, self.least) {
            (Some(most), _) => write!(f, "at most {most}"),
            (None, Some(least)) => write!(f, "at least {least}"),
            (None, None) => f.write_str("anything"),
        }
    }
}

/// Why a table of limits was refused: where in the file, what, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}:{line}:{column}: {message}", path.display())]
pub struct LimitsError {
    /// The file.
    pub path: PathBuf,
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    /// What is wrong.
    pub message: String,
}

impl Limits {
    /// The project's own table, `crates/umbrage_measure/limits.ron`.
    ///
    /// # Errors
    /// A table that is refused.
    pub fn built_in() -> Result<Self, LimitsError> {
        let path = "crates/umbrage_measure/limits.ron";
        Self::parse(include_str!("../../limits.ron"), Path::new(path))
    }

    /// Reads a table; `path` is what errors call it.
    ///
    /// # Errors
    /// What is not RON or has fields that are not known; a figure or a case that there is not, or a case that
    /// is not in the table; a limit or an exception without a reason; an exception to what has no limit or
    /// admits none; a method's own limit that asks for no more than the one for all.
    pub fn parse(text: &str, path: &Path) -> Result<Self, LimitsError> {
        let at = |(line, column), message| LimitsError {
            path: path.to_owned(),
            line,
            column,
            message,
        };
        let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
        let limits: Self = options.from_str(text).map_err(|error| {
            let place = error.span.start;
            at((place.line, place.col), error.code.to_string())
        })?;
        for name in CASES.iter() {
            if !limits.cases.contains_key(&CaseName(name)) {
                let message = format!(
                    "the case `{name}` is not in the table; add it, `\"{name}\": ()` where it is held to no more than \
                     every case is"
                );
                return Err(at(place(text, &["cases"]), message));
            }
        }
        for (case, own) in &limits.cases {
            limits.check(case, own).map_err(|(words, message)| {
                let path: Vec<_> = ["cases", case.0].into_iter().chain(words).collect();
                at(place(text, &path), message)
            })?;
        }
        Ok(limits)
    }

    /// The methods that are named.
    pub fn methods(&self) -> BTreeSet<&str> {
        let cases = self.cases.values();
        let names = cases.flat_map(|case| case.methods.keys().chain(case.exceptions.keys()));
        names.map(String::as_str).collect()
    }

    /// The limit for all methods.
    pub(super) fn general(&self, case: &CaseLimits, figure: Figure) -> Option<Limit> {
        case.any
            .get(&figure)
            .or_else(|| self.every.get(&figure))
            .cloned()
    }

    /// Checks what no single entry shows. A fault says which words lead to it.
    fn check<'a>(
        &self,
        case: &CaseName,
        limits: &'a CaseLimits,
    ) -> Result<(), ([&'a str; 3], String)> {
        let CaseName(case) = case;
        for (method, exceptions) in &limits.exceptions {
            for Excepted(figure) in exceptions.0.keys() {
                if self.general(limits, *figure).is_none() {
                    let Figure(figure) = figure;
                    let message = format!(
                        "`{method}` is excepted from a limit of `{figure}`, but `{case}` has none; take the exception out"
                    );
                    return Err((["exceptions", method, figure], message));
                }
            }
        }
        for (method, own) in &limits.methods {
            for (figure, limit) in &own.0 {
                let excepted = limits.exceptions.get(method);
                let is_excepted = excepted.is_some_and(|e| e.0.contains_key(&Excepted(*figure)));
                let general = self.general(limits, *figure);
                if let Some(general) = general
                    && !is_excepted
                    && !limit.is_stricter_than(&general)
                {
                    let Figure(figure) = figure;
                    let message = format!(
                        "`{method}` may have a `{figure}` of {limit}, but all methods are held to {general}; say under \
                         `exceptions` why it need not be, or take its own limit out"
                    );
                    return Err((["methods", method, figure], message));
                }
            }
        }
        Ok(())
    }
}

/// The line and column, from 1, of the last of `words`, each looked for after the one before: RON's values
/// carry no places of their own.
fn place(text: &str, words: &[&str]) -> (usize, usize) {
    let (mut start, mut from) = (0, 0);
    for word in words {
        let quoted = format!("\"{word}\"");
        let rest = &text[from..];
        if let Some(at) = rest.find(&quoted).or_else(|| rest.find(word)) {
            start = from + at;
            from = start + word.len();
        }
    }
    let before = &text[..start];
    let line = 1 + before.matches('\n').count();
    let last = before.rsplit('\n').next().unwrap_or_default();
    (line, 1 + last.chars().count())
}

/// The names of all cases; making the scenes takes a while.
static CASES: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| super::all().iter().map(|case| case.name).collect());

/// The name of a case that there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CaseName(pub(super) &'static str);

/// The name of a figure that there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Figure(pub(super) &'static str);

/// A figure that a method may be excepted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Excepted(pub(super) Figure);

/// A reason; it says something.
#[derive(Clone, Debug)]
pub(super) struct Reason(pub(super) String);

impl<'de> Deserialize<'de> for CaseName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        known("case", &String::deserialize(deserializer)?, &CASES).map(Self)
    }
}

impl<'de> Deserialize<'de> for Figure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        known(
            "figure",
            &String::deserialize(deserializer)?,
            figure_names(),
        )
        .map(Self)
    }
}

impl<'de> Deserialize<'de> for Excepted {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let figure = Figure::deserialize(deserializer)?;
        if NEVER_EXCEPTED.contains(&figure.0) {
            let message = format!(
                "no method is excepted from the limit of `{}`; mend the method",
                figure.0
            );
            return Err(D::Error::custom(message));
        }
        Ok(Self(figure))
    }
}

impl<'de> Deserialize<'de> for Reason {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let reason = String::deserialize(deserializer)?;
        if reason.trim().is_empty() {
            return Err(D::Error::custom(
                "a reason is empty; say what the limit follows from",
            ));
        }
        Ok(Self(reason))
    }
}

/// The name as `known` has it.
fn known<E: serde::de::Error>(
    what: &str,
    name: &str,
    known: &[&'static str],
) -> Result<&'static str, E> {
    let found = known.iter().find(|known| **known == name).copied();
    found.ok_or_else(|| {
        let near = nearest(name, known.iter().copied());
        let hint = match near {
            Some(_) => suggestion(&near),
            None => format!(" (known: {})", known.join(", ")),
        };
        E::custom(format!("there is no {what} `{name}`{hint}"))
    })
}

/// A map in which each key stands once: RON lets a later one win.
fn unique<'de, D, K, V>(deserializer: D) -> Result<BTreeMap<K, V>, D::Error>
where
    D: Deserializer<'de>,
    K: Deserialize<'de> + Ord + fmt::Debug,
    V: Deserialize<'de>,
{
    struct Unique<K, V>(PhantomData<(K, V)>);
    impl<'de, K, V> Visitor<'de> for Unique<K, V>
    where
        K: Deserialize<'de> + Ord + fmt::Debug,
        V: Deserialize<'de>,
    {
        type Value = BTreeMap<K, V>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a map")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Self::Value, A::Error> {
            let mut map = BTreeMap::new();
            while let Some(key) = entries.next_key::<K>()? {
                if map.contains_key(&key) {
                    return Err(A::Error::custom(format!("{key:?} stands twice; keep one")));
                }
                let value = entries.next_value()?;
                map.insert(key, value);
            }
            Ok(map)
        }
    }
    deserializer.deserialize_map(Unique(PhantomData))
}
