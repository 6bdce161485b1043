//! `umbrage prebuild` and `umbrage merge`: permutations made ahead, as a pack.

use std::{
    collections::{BTreeMap, BTreeSet},
    num::NonZeroUsize,
    path::Path,
    process::ExitCode,
    sync::Arc,
    thread,
};

use anyhow::{Context, Result, bail};
use serde::Serialize;
use umbrage::compose::{
    Composer, Error, Filled, Header, Language, Manifest, Pack, PackWriter, Selection, Variant,
};

use crate::{
    args::{MergeArgs, PrebuildArgs},
    known::Known,
    output::{check_file, print_json, waiting},
    targets::target,
};

/// Output of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    pack: &'a Path,
    /// How many permutations the pack has.
    permutations: usize,
    /// How many were composed, the others taken from the pack that was there before.
    composed: usize,
    /// Whether the pack that was there is of the same sources and keys, and was left as it is.
    unchanged: bool,
    /// Languages that permutations cannot be written in, with how many and why.
    lacks: Vec<Lack>,
    warnings: Vec<String>,
}

/// Permutations that one language cannot say.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
struct Lack {
    language: Language,
    permutations: usize,
    reason: String,
}

pub(crate) fn prebuild(args: &PrebuildArgs, known: &Known) -> Result<ExitCode> {
    check_file(&args.out, "pack", "pack")?;
    let (composer, selections) = selected(args, known)?;
    let selected = selections.iter().map(Selection::hash).collect::<Vec<_>>();
    let languages: BTreeSet<_> = args.targets.iter().copied().collect();
    let mut header = Header::new(
        composer.library(),
        composer.target(),
        languages,
        selected.join("+"),
    );
    header.shard = args.shard;
    // One that is damaged, or no pack, is not heeded: it is replaced.
    let before = match args.out.exists() {
        true => Pack::open(&args.out).ok().map(Arc::new),
        false => None,
    };
    if let Some(before) = before.as_ref().filter(|pack| *pack.header() == header)
        && before.is_whole()
    {
        let count = before.len();
        eprintln!(
            "{count} permutations are in {} already, of these sources and keys",
            args.out.display()
        );
        return report(args, (count, 0), true, before, Vec::new());
    }
    let cores = thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let jobs = args.jobs.map_or(cores, NonZeroUsize::get);
    let mut writer = PackWriter::new(&composer, header)?;
    // Permutations of several manifests are made once.
    let mut seen = BTreeSet::new();
    let variants = selections.iter().flat_map(|some| composer.select(some));
    let is_new = |variant: &Variant<'_>| selections.len() == 1 || seen.insert(variant.key());
    let bar = waiting("prebuilding");
    let filled = writer.fill(
        &composer,
        variants.filter(is_new),
        jobs,
        before.as_ref(),
        |done, composed| {
            bar.set_message(format!(
                "prebuilding: {done} permutations, {composed} composed"
            ));
        },
    );
    bar.finish_and_clear();
    let Filled { composed, warnings } = filled?;
    let count = writer.finish(&args.out)?;
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    let warnings = warnings.into_iter().collect();
    let written = Pack::open(&args.out)?;
    eprintln!(
        "{count} permutations are in {}: {composed} composed, {} as they were",
        args.out.display(),
        count.saturating_sub(composed),
    );
    report(args, (count, composed), false, &written, warnings)
}

pub(crate) fn merge(args: &MergeArgs) -> Result<ExitCode> {
    check_file(&args.out, "pack", "pack")?;
    let shards = args
        .shards
        .iter()
        .map(|path| Pack::open(path).map(Arc::new));
    let shards = shards.collect::<Result<Vec<_>, Error>>()?;
    let count = PackWriter::merge(&shards)?.finish(&args.out)?;
    eprintln!("{count} permutations are in {}", args.out.display());
    Ok(ExitCode::SUCCESS)
}

/// The composer of all that is to be prebuilt, and the keys of each manifest.
fn selected(args: &PrebuildArgs, known: &Known) -> Result<(Composer, Vec<Selection>)> {
    let mut manifests = Vec::new();
    for path in &args.manifests {
        let manifest = Manifest::load(path);
        let manifest =
            manifest.with_context(|| format!("{} cannot be prebuilt", path.display()))?;
        manifests.push((path.display().to_string(), manifest));
    }
    if manifests.is_empty() {
        let manifest = known.selected(&args.keys)?;
        manifests.push(("what --key names".to_owned(), manifest));
    }
    let Some((first, manifest)) = manifests.first() else {
        bail!("there is nothing to prebuild; name a manifest or a key");
    };
    let library = manifest.library().clone();
    for (other, manifest) in &manifests[1..] {
        if !manifest.library().is_same(&library) || manifest.target() != manifests[0].1.target() {
            bail!(
                "{first} and {other} are of different packages or targets; prebuild them into packs of their own"
            );
        }
    }
    let target = target(manifest.target())?;
    let selections = manifests.iter().map(|(_, m)| m.selection().clone());
    Ok((Composer::new(library, target), selections.collect()))
}

/// Tells what the languages lack, and prints the report.
fn report(
    args: &PrebuildArgs,
    (permutations, composed): (usize, usize),
    unchanged: bool,
    pack: &Pack,
    warnings: Vec<String>,
) -> Result<ExitCode> {
    // An unchanged pack told it when it was made; its index is read for the report alone.
    let lacks = match unchanged && !args.json {
        true => Vec::new(),
        false => lacks(pack)?,
    };
    for lack in &lacks {
        let (language, count) = (lack.language, lack.permutations);
        eprintln!("no {language} of {count} permutations: {}", lack.reason);
    }
    if !unchanged {
        tell_overrides(pack)?;
    }
    if args.json {
        print_json(&Report {
            pack: &args.out,
            permutations,
            composed,
            unchanged,
            lacks,
            warnings,
        })?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Tells which overrides only the WGSL leaves open.
fn tell_overrides(pack: &Pack) -> Result<()> {
    let rows = pack.rows()?.iter();
    let fixed: Vec<_> = rows.filter(|row| !row.overrides.is_empty()).collect();
    if fixed.is_empty() || pack.header().languages.iter().all(|l| *l == Language::Wgsl) {
        return Ok(());
    }
    let names = fixed.iter().flat_map(|row| &row.overrides);
    let names: BTreeSet<_> = names.map(|name| format!("`{name}`")).collect();
    let names: Vec<_> = names.into_iter().collect();
    eprintln!(
        "{} can be set in the WGSL alone: in other languages {} permutations have overrides at their defaults, as naga \
         writes no specialisation constants",
        names.join(", "),
        fixed.len(),
    );
    Ok(())
}

fn lacks(pack: &Pack) -> Result<Vec<Lack>> {
    let mut counts: BTreeMap<(Language, String), usize> = BTreeMap::new();
    for row in pack.rows()? {
        for (language, reason) in &row.lacks {
            *counts.entry((*language, reason.clone())).or_default() += 1;
        }
    }
    let lacks = counts.into_iter();
    Ok(lacks
        .map(|((language, reason), permutations)| Lack {
            language,
            permutations,
            reason,
        })
        .collect())
}
