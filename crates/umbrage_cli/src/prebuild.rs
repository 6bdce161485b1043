//! `umbrage prebuild`: every permutation of the manifests, as files.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
    process::ExitCode,
};

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use umbrage::compose::{Composed, Composer, Error, Key, Manifest};

use crate::{
    args::PrebuildArgs,
    folder::{Kind, store},
    known::Known,
    output::progress,
    targets::target,
};

/// File by which a folder that prebuild wrote is known.
const INDEX: &str = "index.json";

/// Marks an index as prebuild's own. The number goes up when the folder's layout changes.
const FORMAT: &str = "umbrage prebuild 1";

/// Hexadecimal digits of a file's name.
const STEM: usize = 32;

/// Extensions of a permutation's files.
const EXTENSIONS: [&str; 3] = ["wgsl", "spv", "json"];

const PREBUILD: Kind = Kind {
    name: "prebuild",
    check: written_by_prebuild,
    own: is_file_name,
};

/// `index.json`: from each key to its permutation's files.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Index {
    format: String,
    /// How many permutations there are.
    permutations: usize,
    keys: BTreeMap<String, Files>,
}

/// A permutation's files, relative to the index.
#[derive(Clone, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Files {
    wgsl: String,
    /// None where overrides have no defaults that SPIR-V could hold.
    spv: Option<String>,
    reflection: String,
}

/// A permutation's contents.
struct Built {
    stem: String,
    wgsl: String,
    spv: Option<Vec<u8>>,
    reflection: String,
    /// Warnings to print.
    warnings: Vec<String>,
    /// The part that SPIR-V cannot hold.
    lost: Lost,
}

/// The part of a permutation that SPIR-V cannot hold.
enum Lost {
    Nothing,
    /// The choice of these overrides' values: SPIR-V has their defaults.
    Overrides(Vec<String>),
    /// The whole permutation, and why.
    All(Error),
}

pub(crate) fn prebuild(args: &PrebuildArgs, known: &Known) -> Result<ExitCode> {
    PREBUILD.check_replaceable(&args.out)?;
    let mut keys: BTreeMap<String, Files> = BTreeMap::new();
    let mut permutations: BTreeMap<String, Built> = BTreeMap::new();
    let named = args.manifests.iter();
    let mut sources: Vec<_> = named
        .map(|path| (path.display().to_string(), Some(path)))
        .collect();
    if sources.is_empty() {
        sources.push(("what --key names".to_owned(), None));
    }
    for (source, path) in sources {
        let manifest = match path {
            Some(path) => Manifest::load(path).map_err(Into::into),
            None => known.selected(&args.keys),
        };
        let built = manifest.and_then(|manifest| build(&manifest));
        let built = built.with_context(|| format!("{source} cannot be prebuilt"))?;
        for (sharing, built) in built {
            let files = built.files();
            for key in sharing {
                let known = keys.entry(key.to_string()).or_insert_with(|| files.clone());
                if *known != files {
                    bail!(
                        "{source} and a manifest before it give the key {key} different permutations; \
                         prebuild them into folders of their own"
                    );
                }
            }
            permutations.insert(built.stem.clone(), built);
        }
    }
    if permutations.is_empty() {
        bail!(
            "the manifests have no permutation, so there is nothing to prebuild; add keys to them"
        );
    }
    tell_lost(permutations.values());
    let warnings: BTreeSet<_> = permutations
        .values()
        .flat_map(|built| &built.warnings)
        .collect();
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
    let count = permutations.len();
    let index = Index {
        format: FORMAT.to_owned(),
        permutations: count,
        keys,
    };
    PREBUILD.replace(&args.out, |folder| {
        write_files(folder, &index, permutations.values())
    })?;
    eprintln!("{count} permutations are in {}", args.out.display());
    Ok(ExitCode::SUCCESS)
}

/// Tells what is in the permutations' WGSL alone.
fn tell_lost<'a>(permutations: impl Iterator<Item = &'a Built>) {
    let (mut fixed, mut overrides) = (0, BTreeSet::new());
    for built in permutations {
        match &built.lost {
            Lost::Nothing => {}
            Lost::Overrides(names) => {
                fixed += 1;
                overrides.extend(names);
            }
            Lost::All(error) => eprintln!("no SPIR-V of {}: {error}", built.files().wgsl),
        }
    }
    if fixed > 0 {
        let names: Vec<_> = overrides
            .into_iter()
            .map(|name| format!("`{name}`"))
            .collect();
        eprintln!(
            "{} can be set in the WGSL alone: the SPIR-V of {fixed} permutations has overrides at their defaults, as \
             naga writes no specialisation constants",
            names.join(", "),
        );
    }
}

/// Composes each permutation of a manifest once.
fn build(manifest: &Manifest) -> Result<Vec<(Vec<Key>, Built)>> {
    let composer = Composer::new(manifest.library().clone(), target(manifest.target())?);
    let variants: Vec<_> = composer.select(manifest.selection()).collect();
    let bar = progress("prebuilding", variants.len());
    let built = variants
        .into_par_iter()
        .map(|variant| {
            let built = Built::new(&composer, &variant.key())?;
            bar.inc(1);
            Ok((variant.keys(), built))
        })
        .collect();
    bar.finish_and_clear();
    built
}

impl Built {
    fn new(composer: &Composer, key: &Key) -> Result<Self> {
        let Composed {
            permutation,
            warnings,
            ..
        } = composer.compose(key)?;
        let wgsl = permutation.wgsl()?;
        let overrides = &permutation.reflection.overrides;
        let (spv, lost) = match permutation.spirv() {
            Ok(words) => {
                let bytes = words.into_iter().flat_map(u32::to_le_bytes).collect();
                let names = overrides.iter().map(|item| item.name.clone());
                match overrides.is_empty() {
                    true => (Some(bytes), Lost::Nothing),
                    false => (Some(bytes), Lost::Overrides(names.collect())),
                }
            }
            // A host that takes the WGSL sets them.
            Err(error) if !overrides.is_empty() => (None, Lost::All(error)),
            Err(error) => return Err(error.into()),
        };
        let mut reflection = serde_json::to_string_pretty(&permutation.reflection)?;
        reflection.push('\n');
        // Named by content: equal permutations of several manifests are one, and nothing else is.
        let mut hasher = blake3::Hasher::new();
        for part in [
            wgsl.as_bytes(),
            spv.as_deref().unwrap_or_default(),
            reflection.as_bytes(),
        ] {
            hasher
                .update(&(part.len() as u64).to_le_bytes())
                .update(part);
        }
        let hash = hasher.finalize().to_hex();
        Ok(Self {
            warnings,
            stem: hash[..STEM].to_owned(),
            wgsl,
            spv,
            reflection,
            lost,
        })
    }

    fn files(&self) -> Files {
        let name = |extension| format!("{}.{extension}", self.stem);
        Files {
            wgsl: name("wgsl"),
            spv: self.spv.as_ref().map(|_| name("spv")),
            reflection: name("json"),
        }
    }
}

/// An error that says which file in `out` prebuild did not write, or that there is no index of its own.
fn written_by_prebuild(out: &Path) -> Result<()> {
    for entry in fs::read_dir(out)? {
        let entry = entry?;
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(is_file_name);
        // A link is none of ours either, wherever it leads.
        if !ours || !entry.file_type()?.is_file() {
            bail!("{} is not a file of prebuild's", Path::new(&name).display());
        }
    }
    let text = fs::read(out.join(INDEX)).with_context(|| format!("{INDEX} cannot be read"))?;
    let index: Index = serde_json::from_slice(&text)
        .with_context(|| format!("{INDEX} is no index of prebuild's"))?;
    if index.format != FORMAT {
        bail!("{INDEX} has the format `{}`, not `{FORMAT}`", index.format);
    }
    Ok(())
}

fn is_file_name(name: &str) -> bool {
    let of_permutation =
        |(stem, extension): (&str, _)| is_stem(stem) && EXTENSIONS.contains(&extension);
    name == INDEX || name.split_once('.').is_some_and(of_permutation)
}

fn is_stem(stem: &str) -> bool {
    stem.len() == STEM && stem.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

/// Writes all files into `folder`.
fn write_files<'a>(
    folder: &Path,
    index: &Index,
    permutations: impl Iterator<Item = &'a Built>,
) -> Result<()> {
    for built in permutations {
        let files = built.files();
        store(folder, &files.wgsl, &built.wgsl)?;
        if let (Some(file), Some(spv)) = (&files.spv, &built.spv) {
            store(folder, file, spv)?;
        }
        store(folder, &files.reflection, &built.reflection)?;
    }
    let mut text = serde_json::to_string_pretty(index)?;
    text.push('\n');
    store(folder, INDEX, text)
}
