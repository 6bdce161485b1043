//! The disk cache: permutations by the hash of all that they depend on.
//!
//! An entry is a header, the hash of what follows, and what follows. It is written to a temporary
//! file beside its place and then renamed, so that another process sees it whole or not at all;
//! when read, its hash must fit and its module must pass the validator.

use std::{
    fs, io,
    io::Write as _,
    path::{Path, PathBuf},
};

use naga::Module;
use serde::{Deserialize, Serialize};

use crate::{
    Cause, Error, Fault, Key, Library, Permutation, Reflection, Target, permutation::validate,
    project::Dependencies,
};

/// Of what an entry looks like; changes with it.
const HEADER: &[u8; 16] = b"umbrage cache 01";

/// The version of naga that wrote the IR; a test holds it against the lock file.
pub const NAGA_VERSION: &str = "30.0.1";

#[derive(Debug)]
pub(crate) struct DiskCache {
    dir: PathBuf,
}

#[derive(Serialize)]
struct EntryOut<'a> {
    key: &'a Key,
    module: &'a Module,
    reflection: &'a Reflection,
}

#[derive(Deserialize)]
struct EntryIn {
    key: Key,
    module: Module,
    reflection: Reflection,
}

/// What came of a look.
pub(crate) enum Look {
    Found(Box<Permutation>),
    Missing,
    /// An entry was damaged or foreign, and is gone.
    Dropped(String),
}

impl DiskCache {
    pub(crate) fn open(dir: PathBuf) -> Result<Self, Error> {
        let unusable = |error: io::Error| {
            let message = format!(
                "the cache folder `{}` cannot be used: {error}",
                dir.display()
            );
            Fault::new(Cause::File, message).note("name a folder that can be made and written to")
        };
        fs::create_dir_all(&dir).map_err(unusable)?;
        // Whether it can be written to shows only when something is.
        tempfile::NamedTempFile::new_in(&dir).map_err(unusable)?;
        Ok(Self { dir })
    }

    /// The name of the entry for `key`: the hash of what the permutation depends on.
    pub(crate) fn name(
        library: &Library,
        target: &Target,
        key: &Key,
        dependencies: &Dependencies,
    ) -> String {
        let mut hasher = blake3::Hasher::new();
        let mut part = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        part(HEADER);
        part(NAGA_VERSION.as_bytes());
        part(target.name().as_bytes());
        part(&target.capabilities().bits().to_le_bytes());
        part(key.to_string().as_bytes());
        // What the choices ask of the linker may change with the axes, and the key stay the same.
        for (axis, effect) in library.axes().effects(key) {
            part(axis.name.as_bytes());
            let asked = (
                &effect.root,
                &effect.bind,
                &effect.features,
                &effect.count_fetches,
            );
            part(format!("{asked:?}").as_bytes());
        }
        for module in &dependencies.modules {
            let source = library.source(*module);
            part(source.path.as_bytes());
            part(source.text.as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    pub(crate) fn look(&self, name: &str, key: &Key, target: &Target) -> Look {
        let path = self.path(name);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Look::Missing,
            Err(error) => return drop_entry(&path, &error.to_string()),
        };
        match decode(&bytes, key, target) {
            Ok(permutation) => Look::Found(Box::new(permutation)),
            Err(reason) => drop_entry(&path, reason),
        }
    }

    /// Keeps `permutation`; a warning where that fails.
    pub(crate) fn keep(&self, name: &str, permutation: &Permutation) -> Option<String> {
        let path = self.path(name);
        let result = encode(permutation).and_then(|bytes| {
            let mut file = tempfile::NamedTempFile::new_in(&self.dir)?;
            file.write_all(&bytes)?;
            file.persist(&path).map(drop).map_err(|error| error.error)
        });
        let error = result.err()?;
        Some(format!(
            "the cache entry `{}` cannot be written: {error}",
            path.display()
        ))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.join(format!("{name}.umbrage"))
    }
}

fn drop_entry(path: &Path, reason: &str) -> Look {
    let gone = match fs::remove_file(path) {
        Ok(()) => "it is dropped and made anew".to_owned(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            "another process dropped it".to_owned()
        }
        Err(error) => format!("it cannot be dropped: {error}"),
    };
    Look::Dropped(format!(
        "the cache entry `{}` is no good ({reason}); {gone}",
        path.display()
    ))
}

fn encode(permutation: &Permutation) -> io::Result<Vec<u8>> {
    let entry = EntryOut {
        key: &permutation.key,
        module: &permutation.module,
        reflection: &permutation.reflection,
    };
    let payload = postcard::to_stdvec(&entry).map_err(io::Error::other)?;
    let mut bytes = HEADER.to_vec();
    bytes.extend_from_slice(blake3::hash(&payload).as_bytes());
    bytes.extend_from_slice(&payload);
    Ok(bytes)
}

fn decode(bytes: &[u8], key: &Key, target: &Target) -> Result<Permutation, &'static str> {
    let rest = bytes
        .strip_prefix(HEADER)
        .ok_or("it is of another format")?;
    let (hash, payload) = rest.split_at_checked(32).ok_or("it is cut short")?;
    if blake3::hash(payload).as_bytes() != hash {
        return Err("its contents do not fit its hash");
    }
    let entry: EntryIn = postcard::from_bytes(payload).map_err(|_| "it cannot be decoded")?;
    if entry.key != *key {
        return Err("it is of another key");
    }
    let info = validate(&entry.module, target).map_err(|_| "its module is not valid")?;
    Ok(Permutation {
        key: entry.key,
        module: entry.module,
        info,
        reflection: entry.reflection,
    })
}
