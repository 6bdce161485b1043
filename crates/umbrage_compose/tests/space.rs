//! The space of permutations, walked: what it yields is what listing all keys and projecting each yields.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;
use umbrage_compose::{Checker, Composer, Error, Key, Library, Package, Target};

mod generated;

/// Distinct permutations, found by listing keys: each with its keys.
fn listed(composer: &Composer, keys: &[Key]) -> BTreeMap<Key, Vec<Key>> {
    let mut permutations: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for key in keys {
        let projected = composer
            .project(key)
            .unwrap_or_else(|error| panic!("{error}"));
        permutations.entry(projected).or_default().push(key.clone());
    }
    permutations
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn each_permutation_is_found_once_with_its_keys(recipe in generated::recipe(false)) {
        let library = recipe.library();
        let keys = recipe.keys(&library);
        prop_assert_eq!(library.legal_keys(), keys.len() as u128);
        let composer = Composer::new(library.clone(), Target::webgpu());
        let listed = listed(&composer, &keys);
        // Another composer has read nothing yet.
        let composer = Composer::new(library.clone(), Target::webgpu());
        let mut found = BTreeSet::new();
        for variant in composer.variants() {
            let key = variant.key();
            prop_assert!(variant.fault().is_none());
            let Some(same) = listed.get(&key) else {
                return Err(TestCaseError::fail(format!("{key} is no permutation")));
            };
            prop_assert_eq!(variant.keys(), same.len() as u128, "{}", &key);
            for (axis, values) in variant.values() {
                let values: BTreeSet<_> = values.iter().map(|value| &**value).collect();
                let used = same.iter().filter_map(|key| library.axes().value(key, &axis));
                prop_assert_eq!(values, used.collect(), "{} {}", &key, axis);
            }
            prop_assert!(found.insert(key));
        }
        prop_assert_eq!(found.len(), listed.len());
        let order = |parts: Vec<umbrage_compose::Variants<'_>>| -> Vec<Key> {
            parts.into_iter().flatten().map(|variant| variant.key()).collect()
        };
        let whole = order(vec![composer.variants()]);
        for count in [2, 7, 1000] {
            prop_assert_eq!(order(composer.variants().split(count)), whole.clone());
        }
    }
}

/// Two shaders under 2^40 keys. Were keys listed, this would never end.
#[test]
fn keys_cost_nothing() {
    let switches: String = (0..40)
        .map(|n| format!(r#""a{n:02}": (default: "off", values: {{ "off": (), "on": (features: ["F{n}"]) }}),"#))
        .collect();
    let axes = format!(
        r#"(axes: {{ {switches} "pass": (values: {{ "main": (root: "package::main") }}) }})"#
    );
    let main =
        "@if(F7) const A = 1.0;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(1.0); }";
    let files = [("axes.ron", axes.as_str()), ("main.wesl", main)];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let package = Package::from_sources("demo", "demo", files).expect("a package");
    let library = Library::new([package]).expect("a library");
    assert_eq!(library.legal_keys(), 1 << 40);
    let composer = Composer::new(library, Target::webgpu());
    let found: Vec<_> = composer
        .variants()
        .map(|v| (v.key().to_string(), v.keys()))
        .collect();
    assert_eq!(
        found,
        [
            ("pass=main".to_owned(), 1 << 39),
            ("a07=on,pass=main".to_owned(), 1 << 39)
        ]
    );
}

/// A key that leads to no module is a permutation with a fault.
#[test]
fn keys_without_a_root_are_told() {
    let axes = r#"(axes: { "pass": (default: "idle", values: { "idle": (), "main": (root: "package::main") }) })"#;
    let main = "@fragment fn fs() -> @location(0) vec4f { return vec4f(1.0); }";
    let files = [("axes.ron", axes), ("main.wesl", main)];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let package = Package::from_sources("demo", "demo", files).expect("a package");
    let library = Library::new([package]).expect("a library");
    let composer = Composer::new(library, Target::webgpu());
    let found: Vec<_> = composer
        .variants()
        .map(|v| v.fault().map(|fault| fault.to_string()))
        .collect();
    let told = found.iter().flatten().collect::<Vec<_>>();
    assert_eq!(found.len(), 2);
    assert!(
        matches!(told.as_slice(), [text] if text.contains("names no module to start from")),
        "{told:?}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Parts that were found valid are taken as valid, and the verdict is that of composing.
    #[test]
    fn checking_by_parts_is_composing(recipe in generated::recipe(true)) {
        let library = recipe.library();
        let composer = Composer::new(library.clone(), Target::webgpu());
        let checker = Checker::new(&composer);
        let oracle = Composer::new(library, Target::webgpu());
        for variant in composer.variants() {
            let checked = checker.check(&variant);
            let composed = oracle.compose(&variant.key());
            let texts = |error: &Error| error.to_string();
            prop_assert_eq!(checked.fault.as_ref().map(texts), composed.as_ref().err().map(texts));
            if let Ok(composed) = composed {
                prop_assert_eq!(checked.warnings, composed.warnings);
            }
        }
    }
}
