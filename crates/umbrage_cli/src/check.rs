//! `umbrage check`: every permutation of packages, or of manifests, validated.

mod github;
mod junit;
mod report;
mod sarif;

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    process::ExitCode,
    sync::Arc,
};

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use umbrage::compose::{
    Axes, Cause, Composer, Error, Fault, Key, Lint, Linted, Location, Manifest, Nearness, Variant,
    Variants,
};

use self::report::{Finding, Level, Report};
use crate::{
    args::{CheckArgs, Format},
    cause::{Axis, Checked, smallest_cause, subjects as bits},
    known::Known,
    output::{print, print_json, progress},
};

/// Most keys that are told of one fault.
const TOLD: usize = 100;

/// Identity of a fault: findings that agree in it are the same.
type Identity = (Cause, Vec<Location>, String);

/// Keys to check.
struct Subject {
    composer: Composer,
    manifest: Manifest,
    /// The manifest's file, where there are several.
    origin: Option<String>,
}

/// Findings about some permutations.
#[derive(Default)]
struct Findings {
    /// Permutations of subjects that share none with another.
    permutations: usize,
    /// Permutations of others, with the first subject that may share them.
    shared: BTreeSet<(usize, Key)>,
    failed: u128,
    warnings: BTreeSet<String>,
    /// Each fault, with the permutations that have it.
    faults: BTreeMap<Identity, Found>,
    /// Findings of lints, each once, by their places.
    lints: BTreeMap<(Lint, Vec<Location>, String), Fault>,
}

/// A fault, and where it was found.
struct Found {
    fault: Fault,
    failed: u128,
    /// Permutations with the fault, ascending.
    permutations: Vec<Ordinal>,
    /// Choices that matter to some of them, as axis and value: for each one of its keys.
    choices: BTreeMap<(Arc<str>, String), Faulty>,
    /// Keys to tell.
    keys: BTreeSet<Key>,
}

/// A key with a fault, and its subject.
type Faulty = (u32, Key);

/// Place of a permutation in the walk: its subject, the part of the walk, and its place there.
type Ordinal = (u32, u32, u32);

/// Manifests are told apart as if they were an axis.
const ORIGIN: &str = "the manifest";

pub(crate) fn check(args: &CheckArgs, known: &Known) -> Result<ExitCode> {
    if args.budget.is_some() && args.manifests.is_empty() && args.keys.keys.is_empty() {
        bail!(
            "--budget compiles every permutation that is meant, and none is selected: name a manifest, or keys (--key)"
        );
    }
    if let Some(lint) = args.denied.iter().find(|lint| args.allowed.contains(lint)) {
        bail!(
            "the lint `{}` is denied and allowed: choose one",
            lint.name()
        );
    }
    let (subjects, mut findings) = subjects(args, known)?;
    for index in 0..subjects.len() {
        findings.examine(index, &subjects);
    }
    // Permutations with a fault or a warning are not known in parts, so what these use is not.
    if findings.faults.is_empty() && findings.warnings.is_empty() {
        for subject in &subjects {
            if subject.manifest.selection().is_all() {
                findings.add_lints(subject.composer.lint_space());
            }
        }
    }
    for subject in &subjects {
        let warnings = subject.composer.library().warnings();
        let warnings = warnings.iter().map(ToString::to_string);
        findings.warnings.extend(warnings);
    }
    let mut report = report(&findings, &subjects);
    report.lints = findings.told_lints(args);
    if let Some(path) = &args.budget {
        match report.is_faulty() {
            true => eprintln!("the budget was not looked at: what is faulty costs nothing"),
            false => report.faults = over_budget(&subjects, path)?,
        }
    }
    tell(&report, args.format())?;
    Ok(match report.is_faulty() {
        false => ExitCode::SUCCESS,
        true => ExitCode::FAILURE,
    })
}

/// The keys to check, and faults of packages that do not load.
fn subjects(args: &CheckArgs, known: &Known) -> Result<(Vec<Subject>, Findings)> {
    let mut subjects = Vec::new();
    let mut findings = Findings::default();
    let several = args.manifests.len() > 1;
    let target = |manifest: &Manifest| {
        crate::targets::target(args.target.as_deref().unwrap_or(manifest.target()))
    };
    for path in &args.manifests {
        match Manifest::load(path) {
            Ok(manifest) => {
                let target = target(&manifest)
                    .with_context(|| format!("{} cannot be checked", path.display()))?;
                subjects.push(Subject {
                    composer: Composer::new(manifest.library().clone(), target),
                    origin: several.then(|| path.display().to_string()),
                    manifest,
                });
            }
            Err(error) => findings.refuse(error, path)?,
        }
    }
    if args.manifests.is_empty() {
        let manifest = known.selected(&args.keys)?;
        subjects.push(Subject {
            composer: Composer::new(manifest.library().clone(), target(&manifest)?),
            origin: None,
            manifest,
        });
    }
    Ok((subjects, findings))
}

/// Faults of permutations that cost more than the budget at `path` allows.
fn over_budget(subjects: &[Subject], path: &Path) -> Result<Vec<Finding>> {
    let mut faults = Vec::new();
    for subject in subjects {
        let target = subject.composer.target().clone();
        let over = crate::cost::over_budget(&subject.manifest, target, path)?;
        faults.extend(over.into_iter().map(|(key, line)| Finding {
            rule: "budget".to_owned(),
            level: Level::Error,
            file: Some(path.display().to_string()),
            line: None,
            column: None,
            rendered: format!("{line}\n"),
            message: line,
            notes: Vec::new(),
            failed: 0,
            permutations: 1,
            keys: vec![key],
            cause: String::new(),
        }));
    }
    Ok(faults)
}

/// Tells a person on standard error, and prints what was asked for.
fn tell(report: &Report, format: Format) -> Result<()> {
    match format {
        Format::Text => {}
        Format::Json => print_json(report)?,
        Format::Github => print(&github::annotations(report))?,
        Format::Sarif => print_json(&sarif::log(report)?)?,
        Format::Junit => print(&junit::document(report)?)?,
    }
    for warning in &report.warnings {
        eprintln!("warning: {warning}");
    }
    for finding in report.findings() {
        eprintln!("{}: {}", finding.level.name(), finding.for_a_person());
    }
    eprintln!("{}", report.summary());
    Ok(())
}

impl Findings {
    /// Checks each permutation of a subject.
    fn examine(&mut self, index: usize, subjects: &[Subject]) {
        let subject = &subjects[index];
        let is_kin = |other: &&Subject| {
            other.manifest.packages() == subject.manifest.packages()
                && other.composer.target() == subject.composer.target()
        };
        let mut kin = subjects
            .iter()
            .enumerate()
            .filter(|(_, other)| is_kin(other));
        let first = kin.next().map_or(index, |(first, _)| first);
        let is_alone = first == index && kin.next().is_none();
        let parts = subject.parts();
        let bar = progress("checking", parts.len());
        let parts = parts.into_par_iter().enumerate().map(|(number, part)| {
            let mut findings = Self::default();
            for (place, variant) in part.enumerate() {
                match is_alone {
                    true => findings.permutations += 1,
                    false => drop(findings.shared.insert((first, variant.key().into()))),
                }
                let checked = subject.composer.check(&variant);
                findings.warnings.extend(checked.warnings);
                findings.add_lints(checked.lints);
                if let Some(error) = checked.fault {
                    let ordinal = (index as u32, number as u32, place as u32);
                    let axes = subject.composer.library().axes();
                    findings.fail(axes, ordinal, &variant, error);
                }
            }
            bar.inc(1);
            findings
        });
        let parts: Vec<_> = parts.collect();
        bar.finish_and_clear();
        for part in parts {
            self.merge(part);
        }
    }

    fn fail(&mut self, axes: &Axes, ordinal: Ordinal, variant: &Variant<'_>, error: Error) {
        let count = variant.count();
        let keys = match count <= TOLD as u128 {
            true => variant.keys(),
            false => vec![variant.key().into()],
        };
        self.failed = self.failed.saturating_add(count);
        let key = variant.key();
        let choices: Vec<_> = (variant.mattering())
            .map(|axis| {
                (
                    axis.clone(),
                    axes.value(&key, axis).unwrap_or("").to_owned(),
                )
            })
            .collect();
        for fault in error.into_faults() {
            let found = self.add(fault);
            for choice in &choices {
                found.meet(choice.clone(), (ordinal.0, key.clone().into()));
            }
            found.failed = found.failed.saturating_add(count);
            found.permutations.push(ordinal);
            let room = TOLD.saturating_sub(found.keys.len());
            found.keys.extend(keys.iter().take(room).cloned());
        }
    }

    fn add(&mut self, fault: Fault) -> &mut Found {
        let identity = (fault.cause, fault.locations.clone(), fault.message.clone());
        self.faults.entry(identity).or_insert_with(|| Found {
            fault,
            failed: 0,
            permutations: Vec::new(),
            choices: BTreeMap::new(),
            keys: BTreeSet::new(),
        })
    }

    fn add_lints(&mut self, found: impl IntoIterator<Item = Linted>) {
        for Linted { lint, fault } in found {
            let identity = (lint, fault.locations.clone(), fault.message.clone());
            self.lints.entry(identity).or_insert(fault);
        }
    }

    /// Findings of lints that are not allowed.
    fn told_lints(&self, args: &CheckArgs) -> Vec<Finding> {
        let lints = self.lints.iter();
        let told = lints.filter(|((lint, ..), _)| !args.allowed.contains(lint));
        let told = told.map(|((lint, ..), fault)| {
            let level = match args.denied.contains(lint) {
                true => Level::Error,
                false => Level::Warning,
            };
            Finding::of(fault, lint.name().to_owned(), level)
        });
        told.collect()
    }

    fn merge(&mut self, other: Self) {
        self.add_lints(
            other
                .lints
                .into_iter()
                .map(|((lint, ..), fault)| Linted { lint, fault }),
        );
        self.permutations += other.permutations;
        self.shared.extend(other.shared);
        self.failed = self.failed.saturating_add(other.failed);
        self.warnings.extend(other.warnings);
        for found in other.faults.into_values() {
            let own = self.add(found.fault);
            own.failed = own.failed.saturating_add(found.failed);
            own.permutations.extend(found.permutations);
            for (choice, faulty) in found.choices {
                own.meet(choice, faulty);
            }
            let room = TOLD.saturating_sub(own.keys.len());
            own.keys.extend(found.keys.into_iter().take(room));
        }
    }

    /// Takes a manifest that does not load: faults in its packages are findings; a manifest that cannot
    /// be read or understood leaves nothing to check.
    fn refuse(&mut self, error: Error, path: &Path) -> Result<()> {
        let unusable =
            |fault: &Fault| matches!(fault.cause, Cause::File | Cause::Manifest | Cause::Key);
        if error.faults().iter().any(unusable) {
            return Err(error).with_context(|| format!("{} cannot be checked", path.display()));
        }
        for fault in error.into_faults() {
            self.add(fault);
        }
        Ok(())
    }
}

impl Found {
    /// Takes note of a choice that matters to a faulty key; of several keys the first.
    fn meet(&mut self, choice: (Arc<str>, String), faulty: Faulty) {
        let known = self.choices.entry(choice).or_insert_with(|| faulty.clone());
        if faulty < *known {
            *known = faulty;
        }
    }
}

impl Subject {
    /// Its permutations, in parts.
    fn parts(&self) -> Vec<Variants<'_>> {
        self.composer.select(self.manifest.selection()).split(PARTS)
    }
}

/// Parts that a space is checked in: enough for many threads, though the parts differ in size.
const PARTS: usize = 512;

fn report(findings: &Findings, subjects: &[Subject]) -> Report {
    let at_most = |count: u128| u64::try_from(count).unwrap_or(u64::MAX);
    let keys = subjects.iter().map(|subject| {
        let library = subject.composer.library();
        subject.manifest.selection().count(library)
    });
    let reported = |found: &Found| {
        let mut fault = found.fault.clone();
        fault.keys = found.keys.iter().cloned().collect();
        Finding {
            failed: at_most(found.failed),
            permutations: found.permutations.len(),
            cause: cause(found, subjects),
            ..Finding::of(&fault, fault.cause.name().to_owned(), Level::Error)
        }
    };
    Report {
        warnings: findings.warnings.iter().cloned().collect(),
        keys: at_most(keys.fold(0, u128::saturating_add)),
        permutations: findings.permutations + findings.shared.len(),
        failed: at_most(findings.failed),
        faults: findings.faults.values().map(reported).collect(),
        lints: Vec::new(),
    }
}

/// The smallest choice of axes that triggers a fault.
fn cause(found: &Found, subjects: &[Subject]) -> String {
    // A fault of a package that does not even load is there whatever is chosen.
    if found.permutations.is_empty() {
        return "always".to_owned();
    }
    // A choice that matters to no faulty permutation has nothing to do with it, even where it goes with one that has.
    // Of the others those come first that chose the module that the fault lies in.
    let mut nearness = BTreeMap::from([(ORIGIN.to_owned(), Nearness::None)]);
    for ((axis, _), (subject, key)) in &found.choices {
        let composer = &subjects[*subject as usize].composer;
        let near = composer.nearness(key, axis, &found.fault);
        let nearest = nearness.entry(axis.to_string()).or_insert(Nearness::None);
        *nearest = near.max(*nearest);
    }
    let mut axes: Vec<_> = nearness.into_iter().collect();
    axes.sort_by(|(a, near), (b, other)| (other, a).cmp(&(near, b)));
    let values = |axis: &str| -> BTreeSet<String> {
        let libraries = subjects.iter().map(|subject| subject.composer.library());
        let known = libraries.filter_map(|library| library.axes().get(axis));
        let values = known.flat_map(|axis| axis.values().map(str::to_owned));
        match axis {
            ORIGIN => subjects.iter().filter_map(|s| s.origin.clone()).collect(),
            _ => values.collect(),
        }
    };
    let axes: Vec<Axis> = (axes.into_iter())
        .map(|(axis, _)| {
            let values = values(&axis).into_iter().collect();
            (axis, values)
        })
        .collect();
    let mut checked = Vec::new();
    for (index, subject) in (0..).zip(subjects) {
        let (library, origin) = (subject.composer.library(), subject.origin.as_ref());
        // Values that the subject's library has, by number; a manifest is one or is not.
        let values = axes.iter().flat_map(|(axis, values)| {
            values.iter().map(move |value| match axis.as_str() {
                ORIGIN => Err(origin == Some(value)),
                axis => library.value(axis, value).ok_or(false),
            })
        });
        let values: Vec<_> = values.collect();
        let parts = subject.parts().into_par_iter().enumerate();
        let rows = parts.flat_map_iter(|(number, part)| {
            let rows = (0..).zip(part).map(|(place, variant)| -> Checked {
                let has = values.iter().map(|value| match value {
                    Ok(value) => variant.may_have(*value),
                    Err(is_origin) => *is_origin,
                });
                let ordinal = (index, number as u32, place);
                let is_faulty = found.permutations.binary_search(&ordinal).is_ok();
                (bits(has), is_faulty)
            });
            let mut rows: Vec<_> = rows.collect();
            rows.sort_unstable();
            rows.dedup();
            rows
        });
        checked.extend(rows.collect::<Vec<_>>());
    }
    smallest_cause(&axes, checked)
}
