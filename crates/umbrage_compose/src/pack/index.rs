//! Contents of a pack's two JSON files.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::{Error, Language, Library, NAGA_VERSION, Target, cache, library::Request};

/// The format's name, which changes with it.
pub(super) const FORMAT: &str = "umbrage pack 1";

/// `pack.json`: what a pack was made from. Packs with equal headers have the same bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// The format and its version.
    pub format: String,
    /// The version of naga that validated and wrote the permutations, and whose IR they are in.
    pub naga: String,
    /// The name of the target that they are valid for.
    pub target: String,
    /// The hash of all that the target offers.
    pub target_hash: String,
    /// The languages that they are written in, beside the IR.
    pub languages: BTreeSet<Language>,
    /// The hash of all modules and axes.
    pub library: String,
    /// The hash of the keys that were selected.
    pub selected: String,
    /// The part of the permutations that is here, from 1, and of how many; none where all of them are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<[u32; 2]>,
}

/// `pack.json`, with what ties it to the other.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Head {
    pub(super) header: Header,
    pub(super) permutations: usize,
    /// How many files the archive has, with its two of JSON.
    pub(super) files: usize,
    /// The hash of `index.json`.
    pub(super) index: String,
}

/// `index.json`: the permutations.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Index {
    /// Modules, by path, with the hash of each one's text.
    pub(super) sources: Vec<(String, String)>,
    /// Names of features.
    pub(super) features: Vec<String>,
    /// Sorted by key.
    pub(super) permutations: Vec<Row>,
}

/// A permutation of a pack.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Its key, as text.
    pub key: String,
    /// The hash of all that it follows from: the texts of its modules, what its choices ask of the linker, the target.
    pub identity: String,
    /// The modules that it is made of, by their places among the sources.
    pub(super) modules: Vec<usize>,
    pub(super) asks: Asks,
    /// Its files by language; of one with a text for each entry point, `glsl` and the entry point's name.
    pub files: BTreeMap<String, String>,
    /// Overrides that a host can set in the WGSL alone: other languages have them at their defaults.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub overrides: Vec<String>,
    /// Languages that it cannot be written in, and why.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub lacks: BTreeMap<Language, String>,
}

/// Questions that the linking asks of a key, with the answers of this permutation's keys: a legal key that gives the same
/// answers makes it. Modules and features are by their places in the index.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Asks {
    pub(super) root: usize,
    pub(super) on: Vec<usize>,
    pub(super) off: Vec<usize>,
    /// Interfaces, and what is bound to each.
    pub(super) bound: Vec<(usize, Option<usize>)>,
    /// The hash of what fetches are counted by; empty where none are.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(super) counting: String,
}

impl Asks {
    /// Whether a key with these demands gives the same answers.
    pub(super) fn meets(&self, request: &Request, counting: &str) -> bool {
        let is_on = |feature: &usize| request.features.contains(*feature);
        self.root == request.root
            && self.on.iter().all(is_on)
            && !self.off.iter().any(is_on)
            && (self.bound.iter()).all(|(i, to)| request.bindings.get(i) == to.as_ref())
            && self.counting == counting
    }
}

/// The hash of what counts fetches.
pub(super) fn counting(request: &Request) -> String {
    match request.counting.as_slice() {
        [] => String::new(),
        counting => short(format!("{counting:?}").as_bytes()),
    }
}

impl Header {
    /// The header of a pack with `selected` keys of `library` for `target`.
    pub fn new(
        library: &Library,
        target: &Target,
        languages: BTreeSet<Language>,
        selected: String,
    ) -> Self {
        Self {
            format: FORMAT.to_owned(),
            naga: NAGA_VERSION.to_owned(),
            target: target.name().to_owned(),
            target_hash: cache::target_hash(target),
            languages,
            library: library.hash(),
            selected,
            shard: None,
        }
    }

    /// Whether another's outputs can be taken over where their identities are the same.
    pub(super) fn is_alike(&self, other: &Self) -> bool {
        self.format == other.format
            && self.naga == other.naga
            && self.target_hash == other.target_hash
            && self.languages == other.languages
    }

    /// Whether it is of this library and target: a key's permutation is then known without reading modules.
    pub(super) fn is_of(&self, library: &Library, target: &Target) -> bool {
        self.is_usable(target) && self.library == library.hash()
    }

    /// Whether its IR is of this version of naga, and valid for `target`.
    pub(super) fn is_usable(&self, target: &Target) -> bool {
        self.naga == NAGA_VERSION && self.target_hash == cache::target_hash(target)
    }
}

/// The hash of `bytes` in 32 hexadecimal digits.
pub(super) fn short(bytes: &[u8]) -> String {
    let mut hash = blake3::hash(bytes).to_hex().to_string();
    hash.truncate(32);
    hash
}

/// JSON with a line's end.
pub(super) fn json(value: &impl Serialize) -> Result<Vec<u8>, Error> {
    let mut text = serde_json::to_vec_pretty(value).map_err(|error| {
        crate::Fault::new(
            crate::Cause::File,
            format!("no JSON can be written: {error}"),
        )
    })?;
    text.push(b'\n');
    Ok(text)
}
