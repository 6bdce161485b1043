//! `umbrage check`: every permutation of the manifests, validated.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
};

use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Serialize;
use umbrage::compose::{
    Cause, Composer, Error, Fault, Key, Library, Location, Manifest, Nearness, Target,
};

use crate::{
    args::CheckArgs,
    cause::smallest_cause,
    output::{print_json, progress},
    permutations::{Member, Permutations},
    targets::target,
};

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    /// How many keys the manifests have.
    keys: usize,
    /// How many distinct permutations they make; one that manifests of the same packages and target share
    /// counts once.
    permutations: usize,
    /// How many keys failed.
    failed: usize,
    faults: Vec<ReportedFault>,
    /// Warnings with their source lines: harmless, but worth telling.
    warnings: Vec<String>,
}

/// One fault, however many permutations it was found in.
#[derive(Serialize)]
struct ReportedFault {
    file: Option<String>,
    line: Option<usize>,
    column: Option<usize>,
    message: String,
    keys: Vec<String>,
    /// The smallest choice of axes that triggers it.
    cause: String,
    /// The fault with its source lines, for a person.
    #[serde(skip)]
    rendered: String,
}

/// What makes two findings the same fault.
type Identity = (Cause, Vec<Location>, String);

/// What manifests of the same packages and target share: a permutation is validated, and counted, once.
struct Shared {
    packages: BTreeMap<String, PathBuf>,
    composer: Composer,
    /// What each permutation came to.
    outcomes: BTreeMap<Key, Option<Error>>,
    /// Warnings of the permutations.
    warnings: BTreeSet<String>,
}

/// All keys that were checked, and the faults found.
#[derive(Default)]
struct Findings {
    /// Each key of each manifest.
    subjects: Vec<Subject>,
    shared: Vec<Shared>,
    /// Each fault, with the subjects that it was found in, as ranges.
    faults: BTreeMap<Identity, (Fault, Vec<std::ops::Range<usize>>)>,
}

/// A key of a manifest.
struct Subject {
    member: Member,
    /// Which of [`Findings::shared`] composes it.
    shared: usize,
    /// The library of its manifest.
    library: Library,
    /// The manifest, where there are several.
    origin: Option<Arc<str>>,
}

/// Manifests are told apart as if they were an axis.
const ORIGIN: &str = "the manifest";

impl Subject {
    /// Its value of `axis`, the default where it says nothing.
    fn value(&self, axis: &str) -> Option<&str> {
        match axis {
            ORIGIN => self.origin.as_deref(),
            _ => self.library.axes().value(&self.member.key, axis),
        }
    }
}

pub(crate) fn check(args: &CheckArgs) -> Result<ExitCode> {
    let mut findings = Findings::default();
    let several = args.manifests.len() > 1;
    for path in &args.manifests {
        match Manifest::load(path) {
            Ok(manifest) => {
                let target = target(args.target.as_deref().unwrap_or(manifest.target()))
                    .with_context(|| format!("{} cannot be checked", path.display()))?;
                findings.examine(&manifest, target, several.then_some(path));
            }
            Err(error) => findings.refuse(error, path)?,
        }
    }
    let report = findings.report();
    if args.json {
        print_json(&report)?;
    }
    for warning in &report.warnings {
        eprintln!("warning: {warning}");
    }
    for fault in &report.faults {
        eprintln!("error: {}  = fails when {}\n", fault.rendered, fault.cause);
    }
    eprintln!(
        "{} keys, {} permutations, {} keys failed with {} faults",
        report.keys,
        report.permutations,
        report.failed,
        report.faults.len(),
    );
    Ok(if report.faults.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

impl Shared {
    /// Composes those of `permutations` that were not composed before.
    fn validate<'a>(&mut self, permutations: impl Iterator<Item = &'a Key>) {
        let new: Vec<_> = permutations
            .filter(|key| !self.outcomes.contains_key(key))
            .cloned()
            .collect();
        let bar = progress("checking", new.len());
        let composer = &self.composer;
        let outcomes: Vec<_> = new
            .into_par_iter()
            .map(|key| {
                let outcome = composer.compose(&key).map(|composed| composed.warnings);
                bar.inc(1);
                (key, outcome)
            })
            .collect();
        bar.finish_and_clear();
        for (key, outcome) in outcomes {
            let error = match outcome {
                Ok(warnings) => {
                    self.warnings.extend(warnings);
                    None
                }
                Err(error) => Some(error),
            };
            self.outcomes.insert(key, error);
        }
    }
}

impl Findings {
    /// Validates each permutation of `manifest`, except where an earlier manifest of the same packages
    /// and target had it. Where there are several manifests, `origin` tells their keys apart, which may be
    /// equal without meaning the same.
    fn examine(&mut self, manifest: &Manifest, target: Target, origin: Option<&PathBuf>) {
        let known = self.shared.iter().position(|shared| {
            shared.packages == *manifest.packages() && *shared.composer.target() == target
        });
        let index = known.unwrap_or_else(|| {
            self.shared.push(Shared {
                packages: manifest.packages().clone(),
                composer: Composer::new(manifest.library().clone(), target),
                outcomes: BTreeMap::new(),
                warnings: BTreeSet::new(),
            });
            self.shared.len() - 1
        });
        let shared = &mut self.shared[index];
        let permutations = Permutations::of(&shared.composer, manifest.keys());
        shared.validate(permutations.keys.keys());

        let outcomes: Vec<_> = permutations
            .keys
            .into_iter()
            .map(|(projected, keys)| (keys, shared.outcomes.get(&projected).cloned().flatten()))
            .collect();
        let faulty = permutations
            .faulty
            .into_iter()
            .map(|(member, error)| (vec![member], Some(error)));
        let origin: Option<Arc<str>> = origin.map(|path| path.display().to_string().into());
        for (members, error) in outcomes.into_iter().chain(faulty) {
            let first = self.subjects.len();
            self.subjects
                .extend(members.into_iter().map(|member| Subject {
                    member,
                    shared: index,
                    library: manifest.library().clone(),
                    origin: origin.clone(),
                }));
            let subjects = first..self.subjects.len();
            for fault in error.into_iter().flat_map(Error::into_faults) {
                self.add(fault, subjects.clone());
            }
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
            self.add(fault, 0..0);
        }
        Ok(())
    }

    fn add(&mut self, fault: Fault, subjects: std::ops::Range<usize>) {
        let identity = (fault.cause, fault.locations.clone(), fault.message.clone());
        let (_, ranges) = (self.faults.entry(identity)).or_insert_with(|| (fault, Vec::new()));
        ranges.push(subjects);
    }

    fn report(self) -> Report {
        let ranges = self.faults.values().flat_map(|(_, ranges)| ranges.clone());
        let failed: BTreeSet<_> = ranges.flatten().collect();
        let reported = |(fault, ranges): &(Fault, Vec<_>)| {
            let mut fault = fault.clone();
            let subjects: BTreeSet<usize> = ranges.iter().cloned().flatten().collect();
            let cause = self.cause(&fault, &subjects);
            let keys: BTreeSet<_> = (subjects.iter())
                .map(|index| &self.subjects[*index].member.key)
                .collect();
            fault.keys = keys.into_iter().cloned().collect();
            let location = fault.location();
            ReportedFault {
                file: location.map(|at| at.file.clone()),
                line: location.map(|at| at.line),
                column: location.map(|at| at.column),
                message: fault.message.clone(),
                keys: fault.keys.iter().map(Key::to_string).collect(),
                cause,
                rendered: fault.to_string(),
            }
        };
        let warnings: BTreeSet<_> = self
            .shared
            .iter()
            .flat_map(|shared| shared.warnings.clone())
            .collect();
        Report {
            warnings: warnings.into_iter().collect(),
            keys: self.subjects.len(),
            permutations: self.shared.iter().map(|shared| shared.outcomes.len()).sum(),
            failed: failed.len(),
            faults: self.faults.values().map(reported).collect(),
        }
    }

    /// The smallest choice of axes that triggers `fault`, which was found in `faulty`.
    fn cause(&self, fault: &Fault, faulty: &BTreeSet<usize>) -> String {
        // A fault of a package that does not even load is there whatever is chosen.
        if faulty.is_empty() {
            return "always".to_owned();
        }
        // A choice that matters to no faulty key has nothing to do with it, even where it goes with one that has.
        // Of the others those come first that chose the module that the fault lies in.
        let mut nearness: BTreeMap<&str, Nearness> = BTreeMap::from([(ORIGIN, Nearness::None)]);
        let mut seen = BTreeSet::new();
        for subject in faulty.iter().map(|index| &self.subjects[*index]) {
            let Member { key, matter } = &subject.member;
            // One of each permutation.
            let values: Vec<_> = matter.iter().map(|axis| subject.value(axis)).collect();
            if !seen.insert((subject.shared, matter, values)) {
                continue;
            }
            for axis in matter.iter() {
                let near = self.shared[subject.shared]
                    .composer
                    .nearness(key, axis, fault);
                let nearest = nearness.entry(axis).or_insert(Nearness::None);
                *nearest = near.max(*nearest);
            }
        }
        let mut axes: Vec<_> = nearness.into_iter().collect();
        axes.sort_by_key(|(axis, near)| (std::cmp::Reverse(*near), *axis));
        let axes: Vec<_> = axes.into_iter().map(|(axis, _)| axis).collect();
        let checked = self.subjects.iter().enumerate().map(|(index, subject)| {
            let values = axes.iter().map(|axis| subject.value(axis));
            (values.collect(), faulty.contains(&index))
        });
        smallest_cause(&axes, checked)
    }
}
