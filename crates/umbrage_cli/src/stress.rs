//! `umbrage stress`: variants of methods in the hard cases.

use std::{path::Path, process::ExitCode, sync::Arc};

use anyhow::{Context, Result, bail};
use serde::Serialize;
use umbrage::{
    compose::{Composer, RonFile, Target, sweep_beside, write_whole},
    render::Gpu,
};
use umbrage_measure::{
    cases::{self, Case, Limits},
    study::{CaseResult, Config, Lab, stress as measure},
    truth::TruthStore,
};

use crate::{
    args::StressArgs,
    compare::chosen,
    known::Known,
    output::{Bars, print, print_json},
};

/// Output of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    adapter: &'a str,
    cases: &'a [CaseResult],
    skipped: Vec<Skipped<'a>>,
}

#[derive(Serialize)]
struct Skipped<'a> {
    case: &'a str,
    variant: &'a str,
    reason: &'a str,
}

pub(crate) fn stress(args: &StressArgs, known: Known) -> Result<ExitCode> {
    let library = known.library(&[])?;
    let registry = known.registry;
    let methods = chosen(args.methods.as_deref(), &registry)?;
    let cases = chosen_cases(args.cases.as_deref())?;
    let limits = match &args.limits {
        Some(path) => Limits::read(RonFile::load(path)?)?,
        None => Limits::built_in()?,
    };
    let mut composer = Composer::new(library, Target::webgpu());
    if let Some(folder) = &args.cache {
        composer = composer.with_disk_cache(folder)?;
    }
    let store = args.cache.as_ref().map(TruthStore::open).transpose()?;
    let variants = limits.variants_of(&methods, &registry, composer.library())?;
    let variants = chosen_variants(args.variants.as_deref(), variants)?;
    let mut lab = Lab::new(Arc::new(Gpu::new()?), Arc::new(composer), registry);
    let bars = Bars::default();
    let measured = measure(&mut lab, &variants, &cases, &limits, store.as_ref(), &bars);
    bars.clear();
    let stressed = measured?;
    for warning in &stressed.warnings {
        eprintln!("warning: {warning}");
    }
    if let Some(folder) = &args.pictures {
        save(&stressed.results, folder)?;
    }
    let skipped = stressed
        .skipped
        .iter()
        .map(|(case, variant, reason)| Skipped {
            case,
            variant,
            reason,
        });
    let report = Report {
        adapter: lab.adapter(),
        cases: &stressed.results,
        skipped: skipped.collect(),
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(&lines(&report))?;
    }
    let passed = stressed.results.iter().all(|result| result.verdict.passed);
    Ok(ExitCode::from(u8::from(!passed)))
}

/// The cases named by `--cases`, with those that they must look like; all where it is missing.
fn chosen_cases(asked: Option<&str>) -> Result<Vec<Case>> {
    let mut cases = cases::all();
    let Some(asked) = asked else {
        return Ok(cases);
    };
    let names: Vec<_> = asked.split(',').map(str::trim).collect();
    if let Some(unknown) = names
        .iter()
        .find(|name| !cases.iter().any(|case| case.name == **name))
    {
        let known: Vec<_> = cases.iter().map(|case| case.name).collect();
        bail!(
            "--cases: there is no case `{unknown}` (known: {})",
            known.join(", ")
        );
    }
    let twins: Vec<_> = (cases.iter().filter(|case| names.contains(&case.name)))
        .filter_map(|case| case.same_as)
        .collect();
    cases.retain(|case| names.contains(&case.name) || twins.contains(&case.name));
    Ok(cases)
}

/// The variants named by `--variants`, of the methods asked for; all where it is missing.
fn chosen_variants(asked: Option<&str>, mut variants: Vec<Config>) -> Result<Vec<Config>> {
    let Some(asked) = asked else {
        return Ok(variants);
    };
    let names: Vec<_> = asked.split(',').map(str::trim).collect();
    let known: Vec<_> = variants.iter().map(|v| v.name.as_str()).collect();
    if let Some(unknown) = names.iter().find(|name| !known.contains(name)) {
        bail!(
            "--variants: there is no variant `{unknown}` (known: {})",
            known.join(", ")
        );
    }
    variants.retain(|variant| names.contains(&variant.name.as_str()));
    Ok(variants)
}

/// A line for each case and variant, and one for each limit that is missed.
fn lines(report: &Report<'_>) -> String {
    let mut text = String::new();
    for result in report.cases {
        let verdict = &result.verdict;
        let word = match (verdict.passed, &verdict.exception) {
            (false, _) => "FAILED",
            (true, Some(_)) => "excepted",
            (true, None) => "passed",
        };
        let figures = &result.figures;
        text += &format!(
            "{word:8}  {:26} {:12} {:6.2} % falsely lit, {:6.2} % falsely in shadow, edges {} px\n",
            result.case,
            result.variant,
            100.0 * figures.false_lit,
            100.0 * figures.false_shadow,
            figures
                .edge_p95
                .map_or("-".to_owned(), |edge| format!("{edge:.1}")),
        );
        for miss in &verdict.missed {
            let found = miss
                .found
                .map_or("missing".to_owned(), |found| format!("{found:.6}"));
            let why = match &miss.excepted {
                Some(reason) => format!("excepted: {reason}"),
                None => format!("limit: {}", miss.limit.why),
            };
            text += &format!(
                "          {} is {found}, not {}; {why}\n",
                miss.figure, miss.limit
            );
        }
        for figure in &verdict.unnecessary {
            text += &format!("          the exception for {figure} is not needed any more\n");
        }
    }
    for skipped in &report.skipped {
        text += &format!(
            "skipped   {:26} {:12} {}\n",
            skipped.case, skipped.variant, skipped.reason
        );
    }
    let failed = report
        .cases
        .iter()
        .filter(|result| !result.verdict.passed)
        .count();
    text += &format!(
        "{} of {} passed\n",
        report.cases.len() - failed,
        report.cases.len()
    );
    text
}

/// Writes for each case and variant what was drawn, what is true and how they differ.
fn save(results: &[CaseResult], folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("--pictures {} cannot be made", folder.display()))?;
    sweep_beside(&folder.join("any"));
    for result in results {
        for (what, png) in result.pictures.files() {
            let file = folder.join(format!("{}-{}-{what}.png", result.case, result.variant));
            write_whole(&file, png)
                .with_context(|| format!("{} cannot be written", file.display()))?;
        }
    }
    Ok(())
}
