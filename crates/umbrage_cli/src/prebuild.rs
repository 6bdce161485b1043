//! `umbrage prebuild`: every permutation of the manifests, as files.

use std::{collections::BTreeMap, fs, io, path::Path, process::ExitCode};

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use tempfile::TempDir;
use umbrage::compose::{Composer, Key, Manifest};

use crate::{args::PrebuildArgs, output::progress, permutations::Permutations, targets::target};

/// What a folder that prebuild wrote is known by.
const INDEX: &str = "index.json";

/// Marks an index as prebuild's own. The number goes up when the folder's layout changes.
const FORMAT: &str = "umbrage prebuild 1";

/// Hexadecimal digits of a file's name.
const STEM: usize = 32;

/// What a permutation's files end in.
const EXTENSIONS: [&str; 3] = ["wgsl", "spv", "json"];

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
            format: FORMAT.to_owned(),
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
            stem: hash[..STEM].to_owned(),
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

/// Refuses to replace a folder unless all that it holds is prebuild's own.
fn check_replaceable(out: &Path) -> Result<()> {
    let entries = match fs::read_dir(out) {
        Ok(entries) => entries.collect::<io::Result<Vec<_>>>(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => Err(error),
    };
    let entries =
        entries.with_context(|| format!("{} cannot be used as a folder", out.display()))?;
    if entries.is_empty() {
        return Ok(());
    }
    if let Err(reason) = written_by_prebuild(out, &entries) {
        bail!(
            "the folder {} holds what is no prebuild: {reason:#}; nothing in it was touched. Name a new or \
             empty folder with --out, or move away what is not prebuild's",
            out.display()
        );
    }
    Ok(())
}

/// An error that says which of `entries` prebuild did not write, or that there is no index of its own.
fn written_by_prebuild(out: &Path, entries: &[fs::DirEntry]) -> Result<()> {
    for entry in entries {
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|name| {
            name == INDEX
                || name.split_once('.').is_some_and(|(stem, extension)| {
                    is_stem(stem) && EXTENSIONS.contains(&extension)
                })
        });
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

fn is_stem(stem: &str) -> bool {
    stem.len() == STEM && stem.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
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

    // Composing takes a while, in which someone may have put a file there.
    check_replaceable(&out)?;
    put_in_place(fresh.path(), &out, sibling(parent)?, |from, to| {
        fs::rename(from, to)
    })
}

/// Renames `fresh` to `out`. An old `out` steps into `aside` first, as a rename does not replace a folder
/// with files; it is removed only when the new one stands.
fn put_in_place(
    fresh: &Path,
    out: &Path,
    aside: TempDir,
    rename: impl Fn(&Path, &Path) -> io::Result<()>,
) -> Result<()> {
    let old = aside.path().join("old");
    let had_old = out.exists();
    if had_old {
        rename(out, &old)?;
    }
    let Err(error) = rename(fresh, out) else {
        return Ok(());
    };
    if had_old && let Err(restoring) = rename(&old, out) {
        let kept = aside.keep().join("old");
        return Err(error).with_context(|| {
            format!(
                "the earlier prebuild could not be put back either ({restoring}): it is in {}; move it back \
                 by hand",
                kept.display()
            )
        });
    }
    Err(error.into())
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

#[cfg(test)]
mod tests {
    use super::*;

    /// An old prebuild and a new one, and renames of which those that `fails` names do nothing.
    fn replaced(fails: fn(&Path, &Path) -> bool) -> (TempDir, Result<()>) {
        let folder = TempDir::new().expect("a folder");
        let (fresh, out) = (folder.path().join("fresh"), folder.path().join("out"));
        for (path, text) in [(&fresh, "new"), (&out, "old")] {
            fs::create_dir(path).expect("a folder");
            fs::write(path.join("file"), text).expect("a file");
        }
        let aside = sibling(folder.path()).expect("a folder");
        let done = put_in_place(&fresh, &out, aside, |from, to| {
            if fails(from, to) {
                return Err(io::Error::other("no"));
            }
            fs::rename(from, to)
        });
        (folder, done)
    }

    fn text(folder: &TempDir) -> Option<String> {
        fs::read_to_string(folder.path().join("out/file")).ok()
    }

    #[test]
    fn the_new_folder_takes_the_place_of_the_old() {
        let (folder, done) = replaced(|_, _| false);
        assert!(done.is_ok());
        assert_eq!(text(&folder).as_deref(), Some("new"));
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 1);
    }

    #[test]
    fn the_old_folder_is_put_back() {
        let (folder, done) = replaced(|from, _| from.ends_with("fresh"));
        assert!(done.is_err());
        assert_eq!(text(&folder).as_deref(), Some("old"));
    }

    #[test]
    fn what_cannot_be_put_back_is_kept_and_told() {
        let (folder, done) = replaced(|_, to| to.ends_with("out"));
        let said = format!("{:#}", done.expect_err("no rename"));
        assert_eq!(text(&folder), None);
        let kept = fs::read_dir(folder.path())
            .expect("listed")
            .map(|entry| entry.expect("an entry").path().join("old"))
            .find(|path| path.is_dir())
            .expect("the old folder is kept");
        assert!(said.contains(&kept.display().to_string()), "{said}");
        assert_eq!(fs::read_to_string(kept.join("file")).expect("read"), "old");
    }
}
