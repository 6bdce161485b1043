//! `umbrage prebuild`: every permutation of the manifests, as files.

use std::{collections::BTreeMap, fs, io, path::Path, process::ExitCode};

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use serde::Serialize;
use tempfile::TempDir;
use umbrage::compose::{Composer, Key, Manifest};

use crate::{args::PrebuildArgs, output::progress, permutations::Permutations, targets::target};

/// Names of a folder that prebuild wrote, and may replace.
const INDEX: &str = "index.json";

/// `index.json`: from each key to its permutation's files.
#[derive(Serialize)]
struct Index {
    /// How many permutations there are.
    permutations: usize,
    keys: BTreeMap<String, Files>,
}

/// A permutation's files, relative to the index.
#[derive(Clone, PartialEq, Eq, Serialize)]
struct Files {
    wgsl: String,
    spv: String,
    reflection: String,
}

/// A permutation's contents.
struct Built {
    stem: String,
    wgsl: String,
    spv: Vec<u8>,
    reflection: String,
}

pub(crate) fn prebuild(args: &PrebuildArgs) -> Result<ExitCode> {
    check_replaceable(&args.out)?;
    let mut keys: BTreeMap<String, Files> = BTreeMap::new();
    let mut permutations: BTreeMap<String, Built> = BTreeMap::new();
    for path in &args.manifests {
        let built =
            build(path).with_context(|| format!("{} cannot be prebuilt", path.display()))?;
        for (sharing, built) in built {
            let files = built.files();
            for key in sharing {
                let known = keys.entry(key.to_string()).or_insert_with(|| files.clone());
                if *known != files {
                    bail!(
                        "{} and a manifest before it give the key {key} different permutations; \
                         prebuild them into folders of their own",
                        path.display()
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
    let count = permutations.len();
    write_folder(
        &args.out,
        &Index {
            permutations: count,
            keys,
        },
        permutations.values(),
    )
    .with_context(|| {
        format!(
            "the folder {} could not be written; choose one where new folders can be made",
            args.out.display()
        )
    })?;
    eprintln!("{count} permutations are in {}", args.out.display());
    Ok(ExitCode::SUCCESS)
}

/// Composes each permutation of a manifest once.
fn build(path: &Path) -> Result<Vec<(Vec<Key>, Built)>> {
    let manifest = Manifest::load(path)?;
    let composer = Composer::new(manifest.library().clone(), target(manifest.target())?);
    let permutations = Permutations::of(&composer, manifest.keys()).all()?;
    let bar = progress("prebuilding", permutations.len());
    let built = permutations
        .into_par_iter()
        .map(|(projected, keys)| {
            let built = Built::new(&composer, &projected)?;
            bar.inc(1);
            Ok((keys, built))
        })
        .collect();
    bar.finish_and_clear();
    built
}

impl Built {
    fn new(composer: &Composer, key: &Key) -> Result<Self> {
        let permutation = composer.compose(key)?.permutation;
        let wgsl = permutation.wgsl()?;
        let spv: Vec<u8> = permutation
            .spirv()?
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect();
        let mut reflection = serde_json::to_string_pretty(&permutation.reflection)?;
        reflection.push('\n');
        // Named by content: equal permutations of several manifests are one, and nothing else is.
        let mut hasher = blake3::Hasher::new();
        for part in [wgsl.as_bytes(), &spv, reflection.as_bytes()] {
            hasher
                .update(&(part.len() as u64).to_le_bytes())
                .update(part);
        }
        let hash = hasher.finalize().to_hex();
        Ok(Self {
            stem: hash[..32].to_owned(),
            wgsl,
            spv,
            reflection,
        })
    }

    fn files(&self) -> Files {
        let name = |extension| format!("{}.{extension}", self.stem);
        Files {
            wgsl: name("wgsl"),
            spv: name("spv"),
            reflection: name("json"),
        }
    }
}

/// Refuses to replace what prebuild has not written.
fn check_replaceable(out: &Path) -> Result<()> {
    match fs::read_dir(out) {
        Ok(mut entries) => {
            if entries.next().is_some() && !out.join(INDEX).is_file() {
                bail!(
                    "the folder {} holds files that are no prebuild; name a new or empty folder with --out",
                    out.display()
                );
            }
            Ok(())
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => {
            Err(error).with_context(|| format!("{} cannot be used as a folder", out.display()))
        }
    }
}

/// Writes all files beside `out` and then puts them in its place: a half-written folder is never seen.
fn write_folder<'a>(
    out: &Path,
    index: &Index,
    permutations: impl Iterator<Item = &'a Built>,
) -> Result<()> {
    let out = std::path::absolute(out)?;
    let parent = out.parent().context("it has no parent folder")?;
    fs::create_dir_all(parent)
        .with_context(|| format!("its parent {} could not be made", parent.display()))?;
    let fresh = sibling(parent)?;
    for built in permutations {
        let files = built.files();
        fs::write(fresh.path().join(files.wgsl), &built.wgsl)?;
        fs::write(fresh.path().join(files.spv), &built.spv)?;
        fs::write(fresh.path().join(files.reflection), &built.reflection)?;
    }
    let mut text = serde_json::to_string_pretty(index)?;
    text.push('\n');
    fs::write(fresh.path().join(INDEX), text)?;

    // The old folder steps aside first, as a rename does not replace a folder with files.
    let aside = sibling(parent)?;
    let old = aside.path().join("old");
    let had_old = out.exists();
    if had_old {
        fs::rename(&out, &old)?;
    }
    if let Err(error) = fs::rename(fresh.path(), &out) {
        if had_old {
            fs::rename(&old, &out)?;
        }
        return Err(error.into());
    }
    Ok(())
}

/// A folder of a passing name in `parent`, open to whom the process's umask allows.
fn sibling(parent: &Path) -> io::Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".prebuild-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o777));
    }
    builder.tempdir_in(parent)
}
