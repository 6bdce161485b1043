//! Permutations to draw, and to ask other compilers about.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use umbrage::compose::{Composer, Error, Key, Manifest, Selection};

/// Manifests of what is drawn in tests.
const DRAWN: [&str; 2] = ["demo.ron", "drawn.ron"];

fn manifests() -> Result<Vec<Manifest>, Error> {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../permutations");
    let manifests = DRAWN.iter().map(|name| Manifest::load(&dir.join(name)));
    manifests.collect()
}

/// Keys of the manifests of what is drawn: one for each distinct permutation, and for each depth that it may read, which
/// is what other passes draw, and no part of the permutation.
///
/// # Errors
/// Faults in our shaders or manifests.
pub fn drawn(composer: &Composer) -> Result<Vec<Key>, Error> {
    let mut distinct = BTreeMap::new();
    for manifest in manifests()? {
        for variant in composer.select(manifest.selection()) {
            for key in variant.keys() {
                let depth = composer.library().axes().value(&key, "depth");
                let depth = depth.unwrap_or("").to_owned();
                distinct.entry((variant.key(), depth)).or_insert(key);
            }
        }
    }
    Ok(distinct.into_values().collect())
}

/// Keys of what is drawn, and of a [cover](Composer::cover) of the whole space, in which every pair of choices occurs:
/// one for each distinct permutation.
///
/// # Errors
/// Faults in our shaders or manifests.
pub fn drawn_or_covering(composer: &Composer) -> Result<Vec<Key>, Error> {
    let mut keys: BTreeSet<_> = composer.cover(&Selection::all())?.into_iter().collect();
    for manifest in manifests()? {
        keys.extend(
            composer
                .select(manifest.selection())
                .map(|variant| variant.key()),
        );
    }
    Ok(keys.into_iter().collect())
}
