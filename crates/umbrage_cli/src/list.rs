//! `umbrage list`: how many permutations packages or a manifest have, and which axes make them.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    fmt::Write,
    process::ExitCode,
};

use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Serialize;
use umbrage::compose::{Composer, Error, Manifest, Selection, Target, Variants};

use crate::{
    args::ListArgs,
    known::Known,
    output::{print, print_json},
};

/// Output of `--json`.
#[derive(Serialize)]
struct Listing {
    /// How many legal keys there are, at most 2^64 - 1.
    keys: u64,
    permutations: usize,
    axes: BTreeMap<String, ListedAxis>,
    /// Modules that no permutation reads.
    unread: BTreeSet<String>,
}

#[derive(Serialize)]
struct ListedAxis {
    /// The values that occur in the keys.
    values: BTreeSet<String>,
    /// The other values.
    unused: BTreeSet<String>,
    /// By how much the axis multiplies the number of permutations.
    multiplier: f64,
}

pub(crate) fn list(args: &ListArgs, known: &Known) -> Result<ExitCode> {
    let manifest = match &args.manifest {
        Some(path) => {
            Manifest::load(path).with_context(|| format!("{} cannot be listed", path.display()))?
        }
        None => known.selected(&args.keys)?,
    };
    // Nothing is composed: which permutations there are is the same for all targets.
    let composer = Composer::new(manifest.library().clone(), Target::webgpu());
    let listing =
        Listing::new(&composer, manifest.selection()).with_context(|| match &args.manifest {
            Some(path) => format!("{} cannot be listed", path.display()),
            None => "the permutations cannot be listed".to_owned(),
        })?;
    if args.json {
        print_json(&listing)?;
    } else {
        print(&table(&listing)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Counts of some permutations.
#[derive(Default)]
struct Counts {
    permutations: usize,
    /// Permutations that each axis matters to.
    axes: BTreeMap<String, OfAxis>,
    /// Modules that are read.
    modules: BTreeSet<String>,
}

impl Listing {
    fn new(composer: &Composer, selection: &Selection) -> Result<Self, Error> {
        let library = composer.library();
        let parts = composer.select(selection).split(512).into_par_iter();
        let counts = parts.map(Counts::of);
        let counts = counts.try_reduce(Counts::default, |a, b| Ok(a.and(b)))?;
        let axes = library.axes().iter().map(|axis| {
            let occurs = |value: &&str| {
                let number = library.value(&axis.name, value);
                number.is_some_and(|number| selection.has(library, number))
            };
            let of_axis = counts.axes.get(&axis.name);
            let permutations = counts.permutations as f64;
            let without = permutations - of_axis.map_or(0.0, OfAxis::saved);
            let listed = ListedAxis {
                values: axis.values().filter(occurs).map(str::to_owned).collect(),
                unused: axis
                    .values()
                    .filter(|value| !occurs(value))
                    .map(str::to_owned)
                    .collect(),
                multiplier: permutations / without.max(1.0),
            };
            (axis.name.clone(), listed)
        });
        let unread = library
            .modules()
            .filter(|module| !counts.modules.contains(*module));
        Ok(Self {
            keys: u64::try_from(selection.count(library)).unwrap_or(u64::MAX),
            permutations: counts.permutations,
            axes: axes.collect(),
            unread: unread.map(str::to_owned).collect(),
        })
    }
}

/// Permutations that an axis matters to, and classes of those that are the same but for it. Of very many classes a
/// share is counted that is chosen by their numbers, as in M. Wegman's adaptive sampling (P. Flajolet, 1990).
#[derive(Default)]
struct OfAxis {
    count: usize,
    /// Classes by number, with how many permutations each has.
    classes: HashMap<u64, u32>,
    /// Classes are counted whose numbers end in as many zeros.
    zeros: u32,
}

/// Most classes that are counted: so many tell a multiplier to within a hundredth.
const CLASSES: usize = 1 << 14;

impl OfAxis {
    fn add(&mut self, class: u64, permutations: u32) {
        if class.trailing_zeros() >= self.zeros {
            *self.classes.entry(class).or_default() += permutations;
        }
        while self.classes.len() > CLASSES {
            self.zeros += 1;
            self.classes
                .retain(|class, _| class.trailing_zeros() >= self.zeros);
        }
    }

    fn and(&mut self, other: Self) {
        self.count += other.count;
        self.zeros = self.zeros.max(other.zeros);
        self.classes
            .retain(|class, _| class.trailing_zeros() >= self.zeros);
        for (class, permutations) in other.classes {
            self.add(class, permutations);
        }
    }

    /// How many permutations fewer there were, had the axis one value.
    fn saved(&self) -> f64 {
        let counted: f64 = self.classes.values().map(|count| f64::from(*count)).sum();
        self.count as f64 * (1.0 - self.classes.len() as f64 / counted.max(1.0))
    }
}

impl Counts {
    fn of(part: Variants<'_>) -> Result<Self, Error> {
        let mut counts = Self::default();
        for variant in part {
            if let Some(error) = variant.fault() {
                return Err(error);
            }
            counts.permutations += 1;
            for (axis, others) in variant.siblings() {
                let of_axis = match counts.axes.get_mut(&**axis) {
                    Some(of_axis) => of_axis,
                    None => counts.axes.entry(axis.to_string()).or_default(),
                };
                of_axis.count += 1;
                of_axis.add(others, 1);
            }
            for module in variant.modules() {
                if !counts.modules.contains(module) {
                    counts.modules.insert(module.to_owned());
                }
            }
        }
        Ok(counts)
    }

    fn and(mut self, other: Self) -> Self {
        self.permutations += other.permutations;
        for (axis, other) in other.axes {
            self.axes.entry(axis).or_default().and(other);
        }
        self.modules.extend(other.modules);
        self
    }
}

fn table(listing: &Listing) -> Result<String, std::fmt::Error> {
    let mut table = String::new();
    writeln!(
        table,
        "{} keys, {} permutations",
        listing.keys, listing.permutations
    )?;
    let list = |names: &BTreeSet<String>| names.iter().cloned().collect::<Vec<_>>().join(", ");
    let width = listing.axes.keys().map(String::len).max().unwrap_or(0);
    for (name, axis) in &listing.axes {
        let (multiplier, values) = (axis.multiplier, list(&axis.values));
        writeln!(table, "{name:width$}  × {multiplier:<6.3}  {values}")?;
    }
    for (name, axis) in listing
        .axes
        .iter()
        .filter(|(_, axis)| !axis.unused.is_empty())
    {
        writeln!(table, "no key has of {name}: {}", list(&axis.unused))?;
    }
    if !listing.unread.is_empty() {
        writeln!(table, "no permutation reads: {}", list(&listing.unread))?;
    }
    Ok(table)
}
