//! The disk cache: permutations by the hash of all that they depend on, in a [`Store`].
//!
//! An entry read must be of the key that was asked for, and its module must pass the validator.

use std::{path::PathBuf, sync::OnceLock};

use naga::Module;
use serde::{Deserialize, Serialize};

use crate::{
    Error, Library, Limit, Pass, Permutation, ProjectedKey, Reflection, Target,
    bits::Bits,
    diagnostics::Written,
    permutation::validate,
    project::Dependencies,
    store::{Kind, Look, Store},
};

/// Of what an entry looks like; the header changes with it.
const KIND: Kind = Kind {
    header: b"umbrage cache 06",
    extension: "umbrage",
};

/// The version of naga that wrote the IR; a test holds it against the lock file.
pub const NAGA_VERSION: &str = "30.0.1";

#[derive(Debug)]
pub(crate) struct DiskCache(Store);

#[derive(Serialize)]
struct EntryOut<'a> {
    key: String,
    module: &'a Module,
    reflection: &'a Reflection,
    warnings: &'a [String],
    written: &'a Written,
}

#[derive(Deserialize)]
struct EntryIn {
    key: String,
    module: Module,
    reflection: Reflection,
    warnings: Vec<String>,
    written: Written,
}

impl DiskCache {
    pub(crate) fn open(dir: PathBuf) -> Result<Self, Error> {
        Store::open(dir, KIND).map(Self)
    }

    /// The name of the entry for `keys`: the hash of what the permutation depends on.
    pub(crate) fn name(
        library: &Library,
        target: &Target,
        keys: &[ProjectedKey],
        dependencies: &[&Dependencies],
    ) -> String {
        let parts = keys.iter().zip(dependencies);
        identity(
            library,
            target,
            parts.map(|(key, found)| (key, &found.modules)),
        )
    }

    /// The bytes of an entry for `permutation`.
    pub(crate) fn encode(permutation: &Permutation) -> postcard::Result<Vec<u8>> {
        postcard::to_stdvec(&EntryOut {
            key: text(permutation.keys()),
            module: &permutation.module,
            reflection: &permutation.reflection,
            warnings: &permutation.warnings,
            written: &permutation.written,
        })
    }

    pub(crate) fn look(
        &self,
        name: &str,
        (keys, pass): (&[ProjectedKey], Option<Pass>),
        target: &Target,
    ) -> Look<Permutation> {
        let decode = |payload: &[u8]| decode(payload, (keys, pass), target, false);
        self.0.look(name, decode)
    }

    /// Keeps `permutation`; a warning where that fails.
    pub(crate) fn keep(&self, name: &str, permutation: &Permutation) -> Option<String> {
        match Self::encode(permutation) {
            Ok(payload) => self.0.keep(name, &payload),
            Err(error) => Some(format!("a cache entry cannot be encoded: {error}")),
        }
    }
}

/// The hash of all that a permutation of these keys, each made of some modules, follows from.
pub(crate) fn identity<'a>(
    library: &Library,
    target: &Target,
    parts: impl IntoIterator<Item = (&'a ProjectedKey, &'a Bits)>,
) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut part = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    part(KIND.header);
    part(NAGA_VERSION.as_bytes());
    part(target_hash(target).as_bytes());
    for (key, modules) in parts {
        part(key.to_string().as_bytes());
        // The choices' demands on the linker may change with the axes, and the key stay the same.
        for demand in library.demands(key) {
            part(demand);
        }
        for module in modules.iter() {
            part(library.module_hash(module));
        }
    }
    hasher.finalize().to_hex().to_string()
}

/// The hash of all that a target offers.
pub(crate) fn target_hash(target: &Target) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(target.name().as_bytes());
    hasher.update(&target.capabilities().bits().to_le_bytes());
    for limit in Limit::ALL {
        hasher.update(&target.limit(*limit).to_le_bytes());
    }
    hasher.update(&[u8::from(target.has_vertex_writes())]);
    hasher.finalize().to_hex().to_string()
}

fn text<'a>(keys: impl IntoIterator<Item = &'a ProjectedKey>) -> String {
    let keys = keys.into_iter().map(ToString::to_string);
    keys.collect::<Vec<_>>().join(" + ")
}

/// The permutation of an entry. One that is `known` to be valid is not validated.
pub(crate) fn decode(
    payload: &[u8],
    (keys, pass): (&[ProjectedKey], Option<Pass>),
    target: &Target,
    known: bool,
) -> Result<Permutation, &'static str> {
    let entry: EntryIn = postcard::from_bytes(payload).map_err(|_| "it cannot be decoded")?;
    let Some((key, others)) = keys.split_first().filter(|_| entry.key == text(keys)) else {
        return Err("it is of another key");
    };
    let capabilities = target.capabilities();
    let info = match known {
        true => OnceLock::new(),
        false => validate(&entry.module, capabilities)
            .map(OnceLock::from)
            .map_err(|_| "its module is not valid")?,
    };
    Ok(Permutation {
        key: key.clone(),
        others: others.to_vec(),
        pass,
        module: entry.module,
        capabilities,
        info,
        reflection: entry.reflection,
        warnings: entry.warnings,
        written: entry.written,
    })
}
