//! `umbrage list`: how many permutations a manifest has, and which axes make them.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
    process::ExitCode,
};

use anyhow::{Context, Result};
use serde::Serialize;
use umbrage::compose::{Composer, Key, Library, Manifest, Target};

use crate::{
    args::ListArgs,
    output::{print, print_json},
    permutations::Permutations,
};

/// What `--json` prints.
#[derive(Serialize)]
struct Listing {
    keys: usize,
    permutations: usize,
    axes: BTreeMap<String, ListedAxis>,
}

#[derive(Serialize)]
struct ListedAxis {
    /// The values that occur in the manifest's keys.
    values: BTreeSet<String>,
    /// By how much the axis multiplies the number of permutations.
    multiplier: f64,
}

pub(crate) fn list(args: &ListArgs) -> Result<ExitCode> {
    let manifest = Manifest::load(&args.manifest)
        .with_context(|| format!("{} cannot be listed", args.manifest.display()))?;
    // Nothing is composed: which permutations there are is the same for all targets.
    let composer = Composer::new(manifest.library().clone(), Target::webgpu());
    let permutations = Permutations::of(&composer, manifest.keys())
        .all()
        .with_context(|| format!("{} cannot be listed", args.manifest.display()))?;
    let listing = listing(manifest.library(), manifest.keys(), permutations.keys());
    if args.json {
        print_json(&listing)?;
    } else {
        print(&table(&listing)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn listing<'a>(
    library: &Library,
    keys: &[Key],
    permutations: impl ExactSizeIterator<Item = &'a Key> + Clone,
) -> Listing {
    // How many keys have each value; all others have the axis's default.
    let mut occurring: BTreeMap<&str, BTreeMap<&str, usize>> = BTreeMap::new();
    for (axis, value) in keys.iter().flat_map(Key::choices) {
        *occurring.entry(axis).or_default().entry(value).or_default() += 1;
    }
    let axes = library
        .axes()
        .iter()
        .map(|axis| {
            let name = axis.name.as_str();
            let others = occurring.remove(name).unwrap_or_default();
            let rest = keys.len() - others.values().sum::<usize>();
            let default = axis.default.as_deref().filter(|_| rest > 0);
            let values = others.into_keys().chain(default).map(str::to_owned);
            let without: BTreeSet<Vec<_>> = permutations
                .clone()
                .map(|key| key.choices().filter(|(axis, _)| *axis != name).collect())
                .collect();
            let multiplier = permutations.len() as f64 / without.len().max(1) as f64;
            let values = values.collect();
            (name.to_owned(), ListedAxis { values, multiplier })
        })
        .collect();
    Listing {
        keys: keys.len(),
        permutations: permutations.len(),
        axes,
    }
}

fn table(listing: &Listing) -> Result<String, std::fmt::Error> {
    let mut table = String::new();
    writeln!(
        table,
        "{} keys, {} permutations",
        listing.keys, listing.permutations
    )?;
    let width = listing.axes.keys().map(String::len).max().unwrap_or(0);
    for (name, axis) in &listing.axes {
        let values: Vec<_> = axis.values.iter().map(String::as_str).collect();
        writeln!(
            table,
            "{name:width$}  × {:<6.3}  {}",
            axis.multiplier,
            values.join(", ")
        )?;
    }
    Ok(table)
}
