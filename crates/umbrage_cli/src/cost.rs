//! `umbrage cost`: what a GPU's compiler makes of every permutation, without a GPU.

use std::{fmt::Write, path::Path, process::ExitCode, sync::Arc};

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use serde::Serialize;
use umbrage::compose::{Composer, Key, Manifest, Permutation, Stage, Target};
use umbrage_isa::{Budget, CompilerOptions, IsaError, PipelineState, StageCost, costs};

use crate::{
    args::CostArgs,
    known::Known,
    output::{print, print_json, progress},
    targets::target,
};

/// Output of `--json`.
#[derive(Serialize)]
struct Report {
    family: String,
    /// A stage of a permutation each, sorted by key and in the order of a pipeline's stages.
    permutations: Vec<Row>,
    /// Figures over the budget; empty without one.
    over_budget: Vec<Over>,
    /// Permutations that the driver could not compile.
    failed: Vec<Failed>,
}

#[derive(Serialize)]
struct Row {
    key: String,
    stage: Stage,
    entry_point: String,
    instructions: u64,
    vgprs: u64,
    sgprs: u64,
    code_size: u64,
    latency: u64,
    inverse_throughput: u64,
    spilled_vgprs: u64,
    spilled_sgprs: u64,
    lds_size: u64,
    scratch_size: u64,
    waves_per_simd: u64,
}

#[derive(Serialize)]
struct Over {
    key: String,
    #[serde(flatten)]
    excess: umbrage_isa::Excess,
}

#[derive(Serialize)]
struct Failed {
    key: String,
    error: String,
}

/// A permutation, and the keys that share it.
struct Subject {
    permutation: Arc<Permutation>,
    keys: Vec<Key>,
}

pub(crate) fn cost(args: &CostArgs, known: &Known) -> Result<ExitCode> {
    let manifest = match &args.manifest {
        Some(path) => Manifest::load(path).map_err(Into::into),
        None => known.selected(&args.keys),
    };
    let report = manifest.and_then(|manifest| {
        let target = target(manifest.target())?;
        examine(
            &manifest,
            target,
            args.family.as_deref(),
            args.budget.as_deref(),
        )
    });
    let report = report.with_context(|| {
        let named = args.manifest.as_ref();
        let named = named.map_or("--key".to_owned(), |path| path.display().to_string());
        format!("what the permutations of {named} cost cannot be told")
    })?;
    if args.json {
        print_json(&report)?;
    } else {
        print(&table(&report)?)?;
    }
    for failed in &report.failed {
        eprintln!("error: {}", failed.error);
    }
    for over in &report.over_budget {
        eprintln!("{}", over.line()?);
    }
    if args.budget.is_some() {
        eprintln!("{} figures are over the budget", report.over_budget.len());
    }
    Ok(match report.failed.len() + report.over_budget.len() {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    })
}

/// Figures over the budget at `path`, and what could not be compiled to tell them: a line for each key.
pub(crate) fn over_budget(
    manifest: &Manifest,
    target: Target,
    path: &Path,
) -> Result<Vec<(String, String)>> {
    let report = examine(manifest, target, None, Some(path)).with_context(|| {
        format!(
            "what permutations cost cannot be held against the budget {}",
            path.display()
        )
    })?;
    let mut told = Vec::new();
    for over in report.over_budget {
        told.push((over.key.clone(), over.line()?));
    }
    let failed = report.failed.into_iter();
    told.extend(failed.map(|failed| (failed.key, failed.error)));
    Ok(told)
}

fn examine(
    manifest: &Manifest,
    target: Target,
    family: Option<&str>,
    path: Option<&Path>,
) -> Result<Report> {
    let axes = manifest.library().axes();
    let budget = path.map(|path| Budget::load(path, axes)).transpose()?;
    let family = self::family(family, path.zip(budget.as_ref()))?;
    let subjects = compose(manifest, target)?;
    if let Some(budget) = &budget {
        let given = subjects
            .iter()
            .map(|s| (s.keys.as_slice(), &*s.permutation));
        budget.check(axes, given)?;
    }
    let compiled = compile(&family, &subjects)?;
    let mut report = Report {
        family,
        permutations: Vec::new(),
        over_budget: Vec::new(),
        failed: Vec::new(),
    };
    for (subject, costs) in subjects.iter().zip(compiled) {
        let key = subject.permutation.key.to_string();
        match costs {
            Ok(costs) => {
                let over = budget
                    .iter()
                    .flat_map(|b| b.over(axes, &subject.keys, &costs));
                report.over_budget.extend(over.map(|excess| Over {
                    key: key.clone(),
                    excess,
                }));
                report
                    .permutations
                    .extend(costs.into_iter().map(|cost| row(&key, cost)));
            }
            Err(error) => report.failed.push(Failed {
                key,
                error: error.to_string(),
            }),
        }
    }
    Ok(report)
}

/// The family to compile for: limits of one mean nothing for another.
fn family(asked: Option<&str>, budget: Option<(&Path, &Budget)>) -> Result<String> {
    let own = asked.map(str::to_ascii_lowercase);
    match (own, budget) {
        (Some(asked), Some((path, budget))) if asked != budget.family() => bail!(
            "the limits of {} are for `{}`, not for `{asked}`: leave out --family, or keep a budget for each \
             family",
            path.display(),
            budget.family()
        ),
        (Some(asked), _) => Ok(asked),
        (None, Some((_, budget))) => Ok(budget.family().to_owned()),
        (None, None) => Ok(CompilerOptions::FAMILY.to_owned()),
    }
}

/// Each permutation once, sorted by key.
fn compose(manifest: &Manifest, target: Target) -> Result<Vec<Subject>> {
    let composer = Composer::new(manifest.library().clone(), target);
    let variants: Vec<_> = composer.select(manifest.selection()).collect();
    let bar = progress("composing", variants.len());
    let subjects = variants.into_par_iter().map(|variant| {
        let permutation = composer.compose(&variant.key())?.permutation;
        bar.inc(1);
        let keys = variant.keys();
        Ok(Subject { permutation, keys })
    });
    let subjects: Result<Vec<_>> = subjects.collect();
    bar.finish_and_clear();
    let mut subjects = subjects?;
    subjects.sort_by(|a, b| a.permutation.key.cmp(&b.permutation.key));
    Ok(subjects)
}

fn compile(
    family: &str,
    subjects: &[Subject],
) -> Result<Vec<Result<Vec<StageCost>, IsaError>>, IsaError> {
    let bar = progress("compiling", subjects.len());
    let jobs: Vec<_> = subjects
        .iter()
        .map(|subject| {
            (
                &*subject.permutation,
                PipelineState::of(&subject.permutation),
            )
        })
        .collect();
    let compiled = costs(&CompilerOptions::new(family), &jobs, &|| bar.inc(1));
    bar.finish_and_clear();
    compiled
}

fn row(key: &str, cost: StageCost) -> Row {
    let StageCost {
        stage,
        entry_point,
        isa,
        room,
    } = cost;
    Row {
        key: key.to_owned(),
        stage,
        entry_point,
        instructions: isa.instructions,
        vgprs: isa.vgprs,
        sgprs: isa.sgprs,
        code_size: isa.code_size,
        latency: isa.latency,
        inverse_throughput: isa.inverse_throughput,
        spilled_vgprs: room.spilled_vgprs,
        spilled_sgprs: room.spilled_sgprs,
        lds_size: room.lds_size,
        scratch_size: room.scratch_size,
        waves_per_simd: room.waves_per_simd,
    }
}

impl Over {
    fn line(&self) -> Result<String, std::fmt::Error> {
        let umbrage_isa::Excess {
            stage,
            figure,
            found,
            allowed,
            reason,
        } = &self.excess;
        let stage = name(*stage);
        let mut line = format!(
            "over budget: {}: {stage}: {figure}: {found} found, {allowed} allowed",
            self.key
        );
        if !reason.is_empty() {
            write!(line, " ({reason})")?;
        }
        Ok(line)
    }
}

fn table(report: &Report) -> Result<String, std::fmt::Error> {
    let mut table = String::new();
    // The figures first: the keys are long, and of all lengths.
    writeln!(
        table,
        "{:>8}  {:>12} {:>5} {:>5} {:>6} {:>7} {:>9} {:>7} {:>5}  key, for {}",
        "stage",
        "instructions",
        "vgprs",
        "sgprs",
        "bytes",
        "latency",
        "1/through",
        "spilled",
        "waves",
        report.family
    )?;
    for row in &report.permutations {
        writeln!(
            table,
            "{:>8}  {:>12} {:>5} {:>5} {:>6} {:>7} {:>9} {:>7} {:>5}  {}",
            name(row.stage),
            row.instructions,
            row.vgprs,
            row.sgprs,
            row.code_size,
            row.latency,
            row.inverse_throughput,
            row.spilled_vgprs + row.spilled_sgprs,
            row.waves_per_simd,
            row.key
        )?;
    }
    Ok(table)
}

fn name(stage: Stage) -> &'static str {
    match stage {
        Stage::Vertex => "vertex",
        Stage::Fragment => "fragment",
        Stage::Compute => "compute",
    }
}
