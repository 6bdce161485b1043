//! `umbrage cover`: recorded runs against a manifest.

use std::{collections::BTreeSet, process::ExitCode};

use anyhow::{Context, Result, bail};
use serde::Serialize;
use umbrage::compose::{Composer, Key, Manifest, record};

use crate::{args::CoverArgs, output::print_json, targets::target};

/// Output of `--json`: keys of permutations.
#[derive(Serialize)]
struct Report {
    /// How many permutations the manifest selects.
    selected: usize,
    /// How many of them some run used.
    used: usize,
    /// Used by a run, and not selected.
    missing: Vec<String>,
    /// Selected, and used by no run.
    never_used: Vec<String>,
    /// Recorded keys that the library has no more, and why.
    unreachable: Vec<Unreachable>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Unreachable {
    key: String,
    reason: String,
}

/// Most keys of a kind that are told to a person.
const TOLD: usize = 20;

pub(crate) fn cover(args: &CoverArgs) -> Result<ExitCode> {
    let Some((manifest, records)) = args.files.split_last() else {
        bail!("name records, and a manifest as the last");
    };
    let path = manifest;
    let manifest = Manifest::load(path).with_context(|| {
        format!(
            "{} cannot be used as a manifest, which comes last",
            path.display()
        )
    })?;
    let (mut recorded, mut warnings) = (BTreeSet::new(), Vec::new());
    for path in records {
        let record = record::read(path)?;
        recorded.extend(record.keys);
        warnings.extend(record.warnings);
    }
    let library = manifest.library().clone();
    let composer = Composer::new(library.clone(), target(manifest.target())?);
    let selected = composer.select(manifest.selection());
    let selected: BTreeSet<Key> = selected.map(|variant| variant.key().into()).collect();
    let (mut used, mut unreachable) = (BTreeSet::new(), Vec::new());
    for text in recorded {
        let key = library.parse_key(&text);
        // The same permutation may have had another key when it was recorded.
        match key.and_then(|key| composer.project(&key)) {
            Ok(key) => drop(used.insert(Key::from(key))),
            Err(error) => unreachable.push(Unreachable {
                reason: error
                    .faults()
                    .iter()
                    .map(|fault| fault.message.clone())
                    .collect::<Vec<_>>()
                    .join("; "),
                key: text,
            }),
        }
    }
    let texts = |keys: &mut dyn Iterator<Item = &Key>| keys.map(ToString::to_string).collect();
    let report = Report {
        selected: selected.len(),
        used: used.intersection(&selected).count(),
        missing: texts(&mut used.difference(&selected)),
        never_used: texts(&mut selected.difference(&used)),
        unreachable,
        warnings,
    };
    tell(&report);
    if args.json {
        print_json(&report)?;
    }
    let is_covered = report.missing.is_empty() && report.unreachable.is_empty();
    Ok(match is_covered {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

/// The report for a person, on standard error.
fn tell(report: &Report) {
    for warning in &report.warnings {
        eprintln!("warning: {warning}");
    }
    let unreachable = report.unreachable.iter();
    let unreachable: Vec<_> = unreachable
        .map(|lost| format!("{}: {}", lost.key, lost.reason))
        .collect();
    for (what, keys) in [
        ("missing", &report.missing),
        ("never used", &report.never_used),
        ("unreachable", &unreachable),
    ] {
        for key in keys.iter().take(TOLD) {
            eprintln!("{what}: {key}");
        }
        if keys.len() > TOLD {
            eprintln!("{what}: {} more; --json has them all", keys.len() - TOLD);
        }
    }
    eprintln!(
        "{} permutations selected, {} of them used; {} missing, {} recorded keys unreachable",
        report.selected,
        report.used,
        report.missing.len(),
        report.unreachable.len(),
    );
}
