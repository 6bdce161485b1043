//! Products of axes' values, combination by combination.

use std::{collections::BTreeMap, sync::Arc};

use crate::{
    Axes, Axis, Cause, Fault,
    bits::Bits,
    file::SourceText,
    key,
    manifest::{Choice, in_manifest},
};

/// Limit on the number of keys: more must be a mistake, as no one can build so many.
const MOST_KEYS: usize = 1 << 20;

/// A product of axes, each with some of its values.
pub(crate) struct Product(Vec<Factor>);

/// Some values of an axis, sorted, with the default kept apart.
struct Factor {
    axis: Arc<str>,
    default: Option<Arc<str>>,
    others: Vec<Arc<str>>,
}

/// A combination of values that a manifest leaves out.
#[derive(Clone, Debug)]
pub(crate) struct Rule {
    pub(crate) exclude: BTreeMap<String, Vec<String>>,
    pub(crate) reason: String,
}

/// Capabilities that the values of a product provide and need.
pub(crate) struct Legality {
    /// By the axes that are no factors, at their defaults.
    rest: Needs,
    /// By each value of each factor.
    factors: Vec<BTreeMap<Arc<str>, Needs>>,
}

#[derive(Clone, Default)]
struct Needs {
    provided: Bits,
    needed: Bits,
}

/// Combinations of a product that a rule excludes.
pub(crate) struct Excludes {
    /// Whether the rule can exclude any combination.
    possible: bool,
    /// Factors, each with the values of which an excluded combination has one.
    values: Vec<(usize, Vec<Arc<str>>)>,
}

impl Product {
    /// Product of the axes and values that a manifest names.
    pub(crate) fn new(
        axes: &Axes,
        source: &SourceText,
        named: &BTreeMap<String, Choice>,
    ) -> Result<Self, Fault> {
        let mut factors = Vec::new();
        let mut size = Some(1usize);
        for (name, choice) in named {
            let axis = axes
                .check_axis(name)
                .map_err(|fault| in_manifest(fault, source, &["keys", name]))?;
            let mut values: Vec<Arc<str>> = match choice {
                Choice::All => axis.values.keys().cloned().collect(),
                Choice::Some(values) => {
                    let known = values.iter().map(|value| {
                        axes.check_value(axis, value)
                            .cloned()
                            .map_err(|fault| in_manifest(fault, source, &["keys", name, value]))
                    });
                    known.collect::<Result<_, _>>()?
                }
            };
            values.sort();
            values.dedup();
            size = size.and_then(|size| size.checked_mul(values.len()));
            let is_default = |value: &Arc<str>| axis.default.as_deref() == Some(&**value);
            factors.push(Factor {
                axis: axes.name(name),
                default: values.iter().find(|value| is_default(value)).cloned(),
                others: values
                    .into_iter()
                    .filter(|value| !is_default(value))
                    .collect(),
            });
        }
        if size.is_none_or(|size| size > MOST_KEYS) {
            let message = format!("a product of more than {MOST_KEYS} keys");
            let fault = Fault::new(Cause::Manifest, message);
            return Err(in_manifest(fault, source, &["keys"]));
        }
        axes.check_complete(|axis| named.contains_key(axis))
            .map_err(|fault| in_manifest(fault, source, &["keys"]))?;
        Ok(Self(factors))
    }

    /// For each of `rules`, the combinations that it excludes. An axis that is not a factor is at its default.
    pub(crate) fn rules(&self, axes: &Axes, rules: &[Rule]) -> Vec<Excludes> {
        let compiled = rules.iter().map(|rule| {
            let mut excludes = Excludes {
                possible: true,
                values: Vec::new(),
            };
            for (axis, values) in &rule.exclude {
                match self.0.iter().position(|factor| *factor.axis == **axis) {
                    Some(factor) => {
                        let values = values.iter().map(|value| value.as_str().into());
                        excludes.values.push((factor, values.collect()));
                    }
                    None => {
                        let default = axes.get(axis).and_then(|axis| axis.default.as_ref());
                        excludes.possible &= default.is_some_and(|value| values.contains(value));
                    }
                }
            }
            excludes
        });
        compiled.collect()
    }

    /// Decides which combinations have all that their values need. An axis that is not a factor is at its default.
    pub(crate) fn legality(&self, axes: &Axes) -> Legality {
        let of = |axis: &Axis, value: &str| {
            let numbers = axis.values.get(value).map(|effect| &effect.numbers);
            numbers.map_or_else(Needs::default, |numbers| Needs {
                provided: numbers.provided.clone(),
                needed: numbers.needed.clone(),
            })
        };
        let mut rest = Needs::default();
        for axis in axes.iter() {
            if let Some(default) = &axis.default
                && !self.0.iter().any(|factor| *factor.axis == *axis.name)
            {
                rest.add(&of(axis, default));
            }
        }
        let factors = self.0.iter().map(|factor| {
            let values = factor.others.iter().chain(&factor.default);
            let axis = axes.get(&factor.axis);
            let needs = values.filter_map(|value| Some((value.clone(), of(axis?, value))));
            needs.collect()
        });
        Legality {
            rest,
            factors: factors.collect(),
        }
    }

    /// Calls `visit` with each combination (a value for each factor) and its key's choices, in the order of the
    /// keys.
    pub(crate) fn for_each(&self, visit: &mut Visit<'_>) {
        let values = self.0.iter().map(|factor| match &factor.default {
            Some(default) => default.clone(),
            None => "".into(),
        });
        let mut walk = Walk {
            factors: &self.0,
            values: values.collect(),
            key: Vec::new(),
            visit,
        };
        walk.from(0);
    }
}

impl Needs {
    fn add(&mut self, other: &Self) {
        self.provided.union(&other.provided);
        self.needed.union(&other.needed);
    }
}

impl Legality {
    pub(crate) fn allows(&self, combination: &[Arc<str>]) -> bool {
        let mut all = self.rest.clone();
        for (values, value) in self.factors.iter().zip(combination) {
            if let Some(needs) = values.get(value) {
                all.add(needs);
            }
        }
        all.provided.has_all(&all.needed)
    }
}

impl Excludes {
    pub(crate) fn fits(&self, combination: &[Arc<str>]) -> bool {
        let has =
            |(factor, values): &(usize, Vec<Arc<str>>)| values.contains(&combination[*factor]);
        self.possible && self.values.iter().all(has)
    }
}

/// Callback for a combination: a value for each factor, and its key's choices.
type Visit<'a> = dyn FnMut(&[Arc<str>], &[key::Choice]) + 'a;

struct Walk<'a, 'v> {
    factors: &'a [Factor],
    /// Value of each factor; the default for a factor that is not yet chosen.
    values: Vec<Arc<str>>,
    key: Vec<key::Choice>,
    visit: &'a mut Visit<'v>,
}

impl Walk<'_, '_> {
    /// Visits all combinations of the factors from `first` on. A key leaves defaults out, so in the order of keys
    /// the combination with all of them at their defaults comes first, and a combination that has another value on
    /// an earlier axis comes before those that have one only on later axes.
    fn from(&mut self, first: usize) {
        let factors = self.factors;
        if (factors[first..].iter()).all(|factor| factor.default.is_some()) {
            (self.visit)(&self.values, &self.key);
        }
        for (index, factor) in factors.iter().enumerate().skip(first) {
            for value in &factor.others {
                self.values[index] = value.clone();
                self.key.push((factor.axis.clone(), value.clone()));
                self.from(index + 1);
                self.key.pop();
            }
            match &factor.default {
                Some(default) => self.values[index] = default.clone(),
                None => break,
            }
        }
    }
}
