//! `umbrage list`: how many permutations packages or a manifest have, and which axes make them.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
    hash::{DefaultHasher, Hash, Hasher},
    process::ExitCode,
};

use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Serialize;
use umbrage::compose::{Composer, Error, Manifest, Selection, Target, Variants};

use crate::{
    args::ListArgs,
    output::{print, print_json},
    packages::library,
};

/// What `--json` prints.
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

pub(crate) fn list(args: &ListArgs) -> Result<ExitCode> {
    let (library, selection) = match &args.manifest {
        Some(path) => {
            let manifest = Manifest::load(path)
                .with_context(|| format!("{} cannot be listed", path.display()))?;
            (manifest.library().clone(), manifest.selection().clone())
        }
        None => (library(&args.packages)?, Selection::all()),
    };
    // Nothing is composed: which permutations there are is the same for all targets.
    let composer = Composer::new(library, Target::webgpu());
    let listing = Listing::new(&composer, &selection).with_context(|| match &args.manifest {
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

/// What is counted of some permutations.
#[derive(Default)]
struct Counts {
    permutations: usize,
    /// Permutations by axis, where its values matter, but for that value: a number for each.
    without: BTreeMap<String, BTreeSet<u64>>,
    /// How many permutations each axis matters to.
    matters: BTreeMap<String, usize>,
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
            let matters = counts.matters.get(&axis.name).copied().unwrap_or(0);
            let without = counts.without.get(&axis.name).map_or(0, BTreeSet::len);
            let without = counts.permutations - matters + without;
            let listed = ListedAxis {
                values: axis.values().filter(occurs).map(str::to_owned).collect(),
                unused: axis
                    .values()
                    .filter(|value| !occurs(value))
                    .map(str::to_owned)
                    .collect(),
                multiplier: counts.permutations as f64 / without.max(1) as f64,
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

impl Counts {
    fn of(part: Variants<'_>) -> Result<Self, Error> {
        let mut counts = Self::default();
        for variant in part {
            if let Some(error) = variant.fault() {
                return Err(error);
            }
            counts.permutations += 1;
            let key = variant.key();
            for axis in variant.mattering() {
                let mut hasher = DefaultHasher::new();
                let others = key.choices().filter(|(name, _)| **name != **axis);
                others.for_each(|choice| choice.hash(&mut hasher));
                let without = counts.without.entry(axis.to_string()).or_default();
                without.insert(hasher.finish());
                *counts.matters.entry(axis.to_string()).or_default() += 1;
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
        for (axis, without) in other.without {
            self.without.entry(axis).or_default().extend(without);
        }
        for (axis, matters) in other.matters {
            *self.matters.entry(axis).or_default() += matters;
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
