//! The limits that the hard cases are held to: `limits.ron`, and how it is read.

use std::{collections::BTreeMap, fmt, sync::LazyLock};

use serde::{Deserialize, Deserializer, Serialize, de::Error as _};
use umbrage_compose::{Error, Fault, Library, RonFile};
use umbrage_shadow::Registry;

use super::figure::{Excepted, Figure, known, unknown};
use crate::{Config, StudyError};

/// The limits of all hard cases, and the variants of methods that are held to them.
///
/// A variant meets a case where it meets each of its limits: those of `every`, those of the case's
/// `any`, which stand in their place, and its own under `methods`. A limit that it cannot meet is listed
/// under `exceptions` with the reason; its own limit then says how far it may go.
///
/// A limit that a variant cannot meet by its nature is said once: its own limits `throughout` stand in the place of all that
/// are stricter.
///
/// A variant that is `like` another takes that one's limits and exceptions over, case by case, where it has none
/// of its own. Each exception must be needed by each variant that has it.
///
/// A variant of which most cases would say the same is tried in those alone that `only` has for it.
///
/// A table that `extends` the project's own adds variants to it, and limits and exceptions of these alone.
#[derive(Clone, Debug)]
pub struct Limits {
    file: RonFile,
    table: Table,
}

/// Contents of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    /// Whether it adds to the project's own table.
    #[serde(default)]
    extends: bool,
    /// How many of the variants are that table's.
    #[serde(skip)]
    extended: usize,
    variants: Vec<Config>,
    /// By variants, the one whose limits and exceptions are theirs too.
    #[serde(default, deserialize_with = "RonFile::unique")]
    like: BTreeMap<String, String>,
    /// By variants, the cases that they are tried in; without, all.
    #[serde(default, deserialize_with = "RonFile::unique")]
    only: BTreeMap<String, Only>,
    /// For all variants in all cases, wherever the case has the figure.
    #[serde(default, deserialize_with = "RonFile::unique")]
    every: Bounds,
    /// For one variant in all cases, where those for all are stricter.
    #[serde(default, deserialize_with = "RonFile::unique")]
    throughout: BTreeMap<String, OwnLimits>,
    #[serde(default, deserialize_with = "RonFile::unique")]
    cases: BTreeMap<CaseName, CaseLimits>,
}

/// Where a variant is tried, and why nowhere else.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Only {
    cases: Vec<CaseName>,
    why: Reason,
}

/// The limits of one case.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct CaseLimits {
    /// For all variants. The case must have the figure.
    #[serde(deserialize_with = "RonFile::unique")]
    pub(super) any: Bounds,
    /// For a variant, beside those for all.
    #[serde(deserialize_with = "RonFile::unique")]
    pub(super) methods: BTreeMap<String, OwnLimits>,
    /// Limits for all that a variant does not meet, and why.
    #[serde(deserialize_with = "RonFile::unique")]
    pub(super) exceptions: BTreeMap<String, Exceptions>,
}

/// Limits by figure.
pub(super) type Bounds = BTreeMap<Figure, Limit>;

/// A variant's own limits.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub(super) struct OwnLimits(#[serde(deserialize_with = "RonFile::unique")] pub(super) Bounds);

/// Reasons by figure.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub(super) struct Exceptions(
    #[serde(deserialize_with = "RonFile::unique")] pub(super) BTreeMap<Excepted, Reason>,
);

/// Bound of a figure: the most or the least that it may be.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, try_from = "WrittenLimit")]
pub struct Limit {
    /// The most that the figure may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// The least that it may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// Reason for the limit.
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

impl Limits {
    /// The project's own table, `crates/umbrage_measure/limits.ron`.
    ///
    /// # Errors
    /// A table that is refused.
    pub fn built_in() -> Result<Self, Error> {
        let path = "crates/umbrage_measure/limits.ron";
        Self::read(RonFile::new(path, include_str!("../../limits.ron")))
    }

    /// Reads a table.
    ///
    /// # Errors
    /// Text that is not RON or has fields that are not known; a figure, a case or a variant that there is not, or a case
    /// that is not in the table; two variants of one name, or one that is like itself or like one that is like
    /// another; a limit or an exception without a reason; an exception to what has no limit or
    /// admits none; a variant's own limit that asks for no more than the one for all; a table that extends the
    /// project's own and says something of what that one has. With the place in the file.
    pub fn read(file: RonFile) -> Result<Self, Error> {
        let mut table: Table = file.parse()?;
        let fault = |(words, message): Found<'_>| file.fault(message, file.all(), &words);
        table.check_extent().map_err(fault)?;
        if table.extends {
            table = table.on(Self::built_in()?.table);
        }
        table.check().map_err(fault)?;
        Ok(Self { file, table })
    }

    /// The variants, in the file's order. Their methods, axes and settings are not checked.
    pub fn variants(&self) -> &[Config] {
        &self.table.variants
    }

    /// Variants of `methods` to be held against the limits: those that the table lists of each; a method of which it lists
    /// none with its defaults, by its own name.
    ///
    /// # Errors
    /// A method that is not registered; a variant with an axis, a value or a setting that its method does not
    /// have, with the place in the table; a method without a variant that is called as another's is.
    pub fn variants_of(
        &self,
        methods: &[String],
        registry: &Registry,
        library: &Library,
    ) -> Result<Vec<Config>, StudyError> {
        let plain = |method: &str| Ok(vec![Config::plain(method, method)]);
        let variants = Config::of_each(methods, registry, self.variants(), plain)?;
        for variant in &variants {
            let listed = self.variants().iter().find(|v| v.name == variant.name);
            let checked = match listed
                .filter(|listed| listed.shadow.method != variant.shadow.method)
            {
                Some(listed) => Err(format!(
                    "a variant of `{}` is called as the method `{}`; rename it, or list a variant of that method",
                    listed.shadow.method, variant.name
                )),
                None => variant.check(registry, library),
            };
            checked.map_err(|problem| {
                umbrage_compose::Error::from(self.fault(&variant.name, problem))
            })?;
        }
        Ok(variants)
    }

    /// Why the table has a variant not be tried in a case; none where it is to be.
    pub(crate) fn passes_over(&self, case: &str, variant: &str) -> Option<&str> {
        let only = self.table.only.get(variant)?;
        let is_tried = only.cases.iter().any(|own| own.0 == case);
        (!is_tried).then_some(only.why.0.as_str())
    }

    /// A fault of the file, at the variant called `name`.
    pub(crate) fn fault(&self, name: &str, message: String) -> Fault {
        let mut names = self.table.variants.iter();
        let words = match names.position(|variant| variant.name == name) {
            Some(index) => self.table.words_to(index),
            None => vec!["variants"],
        };
        self.file.fault(message, self.file.all(), &words)
    }

    /// The limits of one case; none where there is no such case.
    pub(super) fn case(&self, name: &str) -> Option<&CaseLimits> {
        let mut cases = self.table.cases.iter();
        cases.find_map(|(case, limits)| (case.0 == name).then_some(limits))
    }

    /// The limits for all variants in a case.
    pub(super) fn general(&self, case: &CaseLimits) -> Bounds {
        self.table.general(case)
    }

    /// The limit that a variant has of its own in all cases, where it is looser than `general`.
    pub(super) fn looser(&self, variant: &str, figure: Figure, general: &Limit) -> Option<&Limit> {
        let own = self.table.throughout.get(variant)?.0.get(&figure)?;
        general.is_stricter_than(own).then_some(own)
    }

    /// The variants that have limits of their own in all cases, and the figures.
    pub fn throughout(&self) -> impl Iterator<Item = (&str, &'static str)> {
        let variants = self.table.throughout.iter();
        variants.flat_map(|(variant, own)| own.0.keys().map(|figure| (variant.as_str(), figure.0)))
    }

    /// Entry for `variant` in `entries`.
    pub(super) fn entry<'a, T>(
        &'a self,
        entries: &'a BTreeMap<String, T>,
        variant: &str,
    ) -> Option<&'a T> {
        let (_, entry) = self.table.entry(entries, variant)?;
        Some(entry)
    }
}

/// The words that lead to a fault, and what is wrong.
type Found<'a> = (Vec<&'a str>, String);

impl Table {
    fn general(&self, case: &CaseLimits) -> Bounds {
        let mut general = self.every.clone();
        general.extend(case.any.clone());
        general
    }

    /// The variant's own entry, or else that of the one that it is like; by the name that it is written under.
    fn entry<'a, T>(
        &'a self,
        entries: &'a BTreeMap<String, T>,
        variant: &str,
    ) -> Option<(&'a str, &'a T)> {
        let own = entries.get_key_value(variant);
        let entry = own.or_else(|| entries.get_key_value(self.like.get(variant)?));
        entry.map(|(name, entry)| (name.as_str(), entry))
    }

    /// Checks that what is said is what a table that extends another says, or one that stands alone.
    fn check_extent(&self) -> Result<(), Found<'_>> {
        if !self.extends {
            return match self.every.is_empty() {
                true => Err((
                    Vec::new(),
                    "the table holds no variant to anything; give it limits for `every` case, or have it add to the \
                     project's own by `extends: true`"
                        .to_owned(),
                )),
                false => Ok(()),
            };
        }
        let of_all = "limits of all variants are the extended table's; give those of your own under `throughout`, or \
                      under a case's `methods`";
        if !self.every.is_empty() {
            return Err((vec!["every"], of_all.to_owned()));
        }
        let own = |name: &String| self.variants.iter().any(|variant| variant.name == *name);
        let theirs = |name: &str| {
            format!(
                "`{name}` is no variant of this table, and what holds of it is said in the extended one"
            )
        };
        let named = [
            ("throughout", self.throughout.keys().collect::<Vec<_>>()),
            ("only", self.only.keys().collect()),
            ("like", self.like.keys().collect()),
        ];
        for (field, names) in named {
            if let Some(name) = names.into_iter().find(|name| !own(name)) {
                return Err((vec![field, name], theirs(name)));
            }
        }
        for (CaseName(case), limits) in &self.cases {
            if !limits.any.is_empty() {
                return Err((vec!["cases", case, "any"], of_all.to_owned()));
            }
            let mut names = limits.methods.keys().chain(limits.exceptions.keys());
            if let Some(name) = names.find(|name| !own(name)) {
                return Err((vec!["cases", case, name], theirs(name)));
            }
        }
        Ok(())
    }

    /// `base` with what this table adds.
    fn on(self, base: Self) -> Self {
        let mut all = Self {
            extends: true,
            extended: base.variants.len(),
            ..base
        };
        all.variants.extend(self.variants);
        all.like.extend(self.like);
        all.only.extend(self.only);
        all.throughout.extend(self.throughout);
        for (case, limits) in self.cases {
            let known = all.cases.entry(case).or_default();
            known.methods.extend(limits.methods);
            known.exceptions.extend(limits.exceptions);
        }
        all
    }

    /// Checks what no single entry shows.
    fn check(&self) -> Result<(), Found<'_>> {
        self.check_variants()?;
        for name in CASES.iter() {
            if !self.cases.contains_key(&CaseName(name)) {
                let message = format!(
                    "the case `{name}` is not in the table; add it, `\"{name}\": ()` where it is held to no more than \
                     every case is"
                );
                return Err((vec!["cases"], message));
            }
        }
        for (CaseName(case), limits) in &self.cases {
            let checked = self.check_case(case, limits);
            checked.map_err(|(words, message)| {
                let words = ["cases", case].into_iter().chain(words).collect();
                (words, message)
            })?;
        }
        Ok(())
    }

    /// The words that lead to a variant's name: methods may be called the same.
    fn words_to(&self, variant: usize) -> Vec<&str> {
        let names = self.variants.iter().take(variant + 1);
        let names = names.skip(self.extended);
        let names = names.flat_map(|variant| ["name", &variant.name]);
        std::iter::once("variants").chain(names).collect()
    }

    fn check_variants(&self) -> Result<(), Found<'_>> {
        for (index, Config { name, .. }) in self.variants.iter().enumerate() {
            if self.variants[..index]
                .iter()
                .any(|other| other.name == *name)
            {
                let message = format!("two variants are called `{name}`; rename one");
                return Err((self.words_to(index), message));
            }
        }
        for variant in self.throughout.keys() {
            self.check_name(variant)
                .map_err(|message| (vec!["throughout", variant.as_str()], message))?;
        }
        for variant in self.only.keys() {
            self.check_name(variant)
                .map_err(|message| (vec!["only", variant.as_str()], message))?;
        }
        for (name, other) in &self.like {
            for known in [name, other] {
                self.check_name(known)
                    .map_err(|message| (vec!["like", known.as_str()], message))?;
            }
            if name == other {
                let message = format!("`{name}` is like itself; take the line out");
                return Err((vec!["like", name], message));
            }
            if let Some(third) = self.like.get(other) {
                let message =
                    format!("`{name}` is like `{other}`, which is like `{third}`; name that one");
                return Err((vec!["like", name, other], message));
            }
        }
        Ok(())
    }

    fn check_name(&self, variant: &str) -> Result<(), String> {
        let names = || self.variants.iter().map(|config| config.name.as_str());
        match names().any(|name| name == variant) {
            true => Ok(()),
            false => Err(unknown("variant", variant, names())),
        }
    }

    fn check_case<'a>(&'a self, case: &str, limits: &'a CaseLimits) -> Result<(), Found<'a>> {
        let named = |field: &'static str, name: &'a str| {
            let checked = self.check_name(name);
            checked.map_err(|message| (vec![field, name], message))
        };
        let general = self.general(limits);
        for (variant, exceptions) in &limits.exceptions {
            named("exceptions", variant)?;
            for Excepted(figure) in exceptions.0.keys() {
                if !general.contains_key(figure) {
                    let message = format!(
                        "`{variant}` is excepted from a limit of `{figure}`, but `{case}` has none; take the exception \
                         out"
                    );
                    return Err((vec!["exceptions", variant, figure.0], message));
                }
            }
        }
        for variant in limits.methods.keys() {
            named("methods", variant)?;
        }
        for Config { name: variant, .. } in &self.variants {
            let Some((from, own)) = self.entry(&limits.methods, variant) else {
                continue;
            };
            let excepted = self.entry(&limits.exceptions, variant);
            for (figure, limit) in &own.0 {
                let is_excepted = excepted
                    .is_some_and(|(_, excepted)| excepted.0.contains_key(&Excepted(*figure)));
                if let Some(general) = general.get(figure)
                    && !is_excepted
                    && !limit.is_stricter_than(general)
                {
                    let message = format!(
                        "`{variant}` may have a `{figure}` of {limit}, but all methods are held to {general}; say under \
                         `exceptions` why it need not be, or take its own limit out"
                    );
                    return Err((vec!["methods", from, figure.0], message));
                }
            }
        }
        Ok(())
    }
}

/// The names of all cases; making the scenes takes a while.
static CASES: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| super::all().iter().map(|case| case.name).collect());

/// The name of a case that there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CaseName(pub(super) &'static str);

/// A reason; it says something.
#[derive(Clone, Debug)]
pub(super) struct Reason(pub(super) String);

impl fmt::Display for CaseName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl<'de> Deserialize<'de> for CaseName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        known("case", &String::deserialize(deserializer)?, &CASES).map(Self)
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
