//! Limits on permutations' costs.

use std::{collections::BTreeMap, ops::Range, path::Path};

use serde::{Deserialize, Serialize};
use umbrage_compose::{Axes, Error, Key, Permutation, RonFile, Stage, When};

use crate::{CompilerOptions, StageCost};

/// Limits on stages' costs on one GPU family: a file for a person to keep and a job to check.
///
/// ```ron
/// (
///     family: "navi21",
///     rules: [
///         (
///             when: { "pass": "shadow_term", "method": "basic", "pcf": ["3", "5"] },
///             stage: "fragment",
///             max: (instructions: 400, vgprs: 40),
///             reason: "more registers than these halve the waves in flight",
///         ),
///     ],
/// )
/// ```
/// A rule holds for a stage of a permutation where one of the keys that share the permutation fits `when`; where
/// several rules limit a figure, the least counts. `max` limits any of [`StageCost::figures`], but for the waves,
/// of which more are better.
#[derive(Debug)]
pub struct Budget {
    file: RonFile,
    family: String,
    rules: Vec<(Rule, Range<usize>)>,
}

/// A figure that is greater than it may be.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Excess {
    /// The stage.
    pub stage: Stage,
    /// The figure's name.
    pub figure: &'static str,
    /// The figure found.
    pub found: u64,
    /// The greatest figure allowed.
    pub allowed: u64,
    /// Why, in the budget's words; often empty.
    pub reason: String,
}

impl Budget {
    /// Reads the budget at `path`, for keys of `axes`.
    ///
    /// # Errors
    /// An unreadable or malformed file, an unknown field, axis, value or stage, a rule that limits nothing, and
    /// a budget without rules.
    pub fn load(path: &Path, axes: &Axes) -> Result<Self, Error> {
        let file = RonFile::load(path)?;
        let budget: BudgetFile = file.parse()?;
        if budget.rules.is_empty() {
            let fault = file.fault("the budget has no rule", 0..0, &[]);
            return Err(fault.note("add one to `rules`: it checks nothing").into());
        }
        let ranges = (0..budget.rules.len()).map(|rule| file.at(&format!("rules[{rule}]")));
        let rules: Vec<_> = budget.rules.into_iter().zip(ranges).collect();
        for (rule, range) in &rules {
            rule.when.check(axes, &file, range.clone())?;
            if rule.max.0.is_empty() {
                let fault = file.fault("a rule limits nothing", range.clone(), &["max"]);
                return Err(fault
                    .note(format!("figures: {}", FIGURES.join(", ")))
                    .into());
            }
        }
        Ok(Self {
            file,
            family: budget.family.to_ascii_lowercase(),
            rules,
        })
    }

    /// The GPU family that the limits are for.
    pub fn family(&self) -> &str {
        &self.family
    }

    /// Checks that each rule holds for a stage of one of `permutations`, given with the keys that share each.
    ///
    /// # Errors
    /// A rule that guards nothing.
    pub fn check<'a>(
        &self,
        axes: &Axes,
        permutations: impl IntoIterator<Item = (&'a [Key], &'a Permutation)>,
    ) -> Result<(), Error> {
        let mut unused: Vec<_> = self.rules.iter().collect();
        for (keys, permutation) in permutations {
            let entries = &permutation.reflection.entry_points;
            unused.retain(|(rule, _)| {
                !entries.iter().any(|entry| rule.stage.0 == entry.stage) || !rule.fits(axes, keys)
            });
        }
        match unused.first() {
            None => Ok(()),
            Some((_, range)) => {
                let message = "a rule fits no stage of any permutation";
                let fault = self.file.fault(message, range.clone(), &[]);
                Err(fault
                    .note("remove it, or mend its `when` and `stage`")
                    .into())
            }
        }
    }

    /// Figures of a permutation's `costs` over the limits, by stage and figure. `keys` share the permutation.
    pub fn over(&self, axes: &Axes, keys: &[Key], costs: &[StageCost]) -> Vec<Excess> {
        let fitting: Vec<_> = self
            .rules
            .iter()
            .map(|(rule, _)| rule)
            .filter(|rule| rule.fits(axes, keys))
            .collect();
        let mut over = Vec::new();
        for cost in costs {
            let rules = fitting.iter().filter(|rule| rule.stage.0 == cost.stage);
            for (figure, found) in cost.figures() {
                let limits = rules
                    .clone()
                    .filter_map(|rule| Some((*rule.max.0.get(figure)?, &rule.reason)));
                let least = limits.min_by_key(|(allowed, _)| *allowed);
                over.extend(least.filter(|(allowed, _)| found > *allowed).map(
                    |(allowed, reason)| Excess {
                        stage: cost.stage,
                        figure,
                        found,
                        allowed,
                        reason: reason.clone(),
                    },
                ));
            }
        }
        over
    }
}

impl Rule {
    fn fits(&self, axes: &Axes, keys: &[Key]) -> bool {
        keys.iter().any(|key| self.when.fits(axes, key))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BudgetFile {
    #[serde(default = "default_family")]
    family: String,
    rules: Vec<Rule>,
}

fn default_family() -> String {
    CompilerOptions::FAMILY.to_owned()
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rule {
    when: When,
    stage: StageName,
    max: Limits,
    #[serde(default)]
    reason: String,
}

#[derive(Debug, Deserialize)]
#[serde(try_from = "String")]
struct StageName(Stage);

impl TryFrom<String> for StageName {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        Ok(Self(match name.as_str() {
            "vertex" => Stage::Vertex,
            "fragment" => Stage::Fragment,
            "compute" => Stage::Compute,
            _ => {
                return Err(format!(
                    "there is no stage `{name}`; stages: vertex, fragment, compute"
                ));
            }
        }))
    }
}

/// Limits by figure.
#[derive(Debug, Deserialize)]
#[serde(from = "LimitsFile")]
struct Limits(BTreeMap<&'static str, u64>);

/// Declares the figures that may be limited once, as fields and as names.
macro_rules! limits {
    ($($figure:ident),+ $(,)?) => {
        const FIGURES: &[&str] = &[$(stringify!($figure)),+];

        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct LimitsFile {
            $(#[serde(default)] $figure: Option<u64>,)+
        }

        impl From<LimitsFile> for Limits {
            fn from(file: LimitsFile) -> Self {
                let limits = [$((stringify!($figure), file.$figure)),+];
                let limits = limits.into_iter();
                Self(limits.filter_map(|(figure, limit)| Some((figure, limit?))).collect())
            }
        }
    };
}

limits!(
    instructions,
    vgprs,
    sgprs,
    code_size,
    latency,
    inverse_throughput,
    spilled_vgprs,
    spilled_sgprs,
    lds_size,
    scratch_size,
);
