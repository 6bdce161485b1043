//! The space of permutations, walked: what it yields is what listing all keys and projecting each yields.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::atomic::{AtomicUsize, Ordering},
};

use naga::valid::{ValidationFlags, Validator};
use proptest::prelude::*;
use umbrage_compose::{
    Composer, Key, Library, Manifest, Package, ProjectedKey, Selection, Target, Variant,
};

mod generated;

/// The library of a package with `files`.
fn library(files: &[(&str, &str)]) -> Library {
    let files = files
        .iter()
        .map(|(path, text)| ((*path).to_owned(), (*text).to_owned()));
    let package = Package::from_sources("demo", "demo", files).expect("a package");
    Library::new([package]).unwrap_or_else(|error| panic!("{error}"))
}

/// Distinct permutations, found by listing keys: each with its keys.
fn listed(composer: &Composer, keys: &[Key]) -> BTreeMap<ProjectedKey, Vec<Key>> {
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
            prop_assert_eq!(variant.count(), same.len() as u128, "{}", &key);
            for (axis, values) in variant.values() {
                let values: BTreeSet<_> = values.iter().map(|value| &**value).collect();
                let used = same.iter().filter_map(|key| library.axes().value(key, &axis));
                prop_assert_eq!(values, used.collect(), "{} {}", &key, axis);
            }
            prop_assert!(found.insert(key));
        }
        prop_assert_eq!(found.len(), listed.len());
        let order = |parts: Vec<umbrage_compose::Variants<'_>>| -> Vec<ProjectedKey> {
            parts.into_iter().flatten().map(|variant| variant.key()).collect()
        };
        let whole = order(vec![composer.variants()]);
        for count in [2, 7, 1000] {
            prop_assert_eq!(order(composer.variants().split(count)), whole.clone());
        }
    }
}

/// Values that a manifest names for some axes, drawn by `pick`.
fn named(library: &Library, picks: &[(usize, u8)]) -> BTreeMap<String, BTreeSet<String>> {
    let axes: Vec<_> = library.axes().iter().collect();
    let mut named: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
    for (axis, bits) in picks {
        let axis = axes[axis % axes.len()];
        let values = axis.values().enumerate();
        let values = values.filter(|(index, _)| *index == 0 || bits >> index & 1 == 1);
        let values = values.map(|(_, value)| value.to_owned());
        named.entry(axis.name.clone()).or_default().extend(values);
    }
    named
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// A manifest selects the keys of its products that are legal and not excluded.
    #[test]
    fn manifests_select(
        recipe in generated::recipe(false),
        products in prop::collection::vec(prop::collection::vec((0..99usize, any::<u8>()), 0..5), 1..4),
        excluded in prop::collection::vec((0..99usize, any::<u8>()), 1..3),
    ) {
        let library = recipe.library();
        let products: Vec<_> = products.iter().map(|picks| {
            let mut named = named(&library, picks);
            for axis in library.axes().iter().filter(|axis| axis.default.is_none()) {
                let all = axis.values().map(str::to_owned);
                named.entry(axis.name.clone()).or_insert_with(|| all.collect());
            }
            named
        }).collect();
        let excluded = named(&library, &excluded);
        let value = |key: &Key, axis: &str| library.axes().value(key, axis).map(str::to_owned);
        let has = |key: &Key, named: &BTreeMap<String, BTreeSet<String>>| {
            named.iter().all(|(axis, values)| value(key, axis).is_some_and(|v| values.contains(&v)))
        };
        let in_product = |key: &Key, product: &BTreeMap<String, BTreeSet<String>>| {
            has(key, product) && key.choices().all(|(axis, _)| product.contains_key(axis))
        };
        let keys = recipe.keys(&library);
        let of_products = keys.iter().filter(|key| products.iter().any(|p| in_product(key, p)));
        let (out, expected): (Vec<_>, BTreeSet<_>) = {
            let (out, rest): (Vec<_>, Vec<_>) = of_products.cloned().partition(|key| has(key, &excluded));
            (out, rest.into_iter().collect())
        };
        let folder = tempfile::tempdir().expect("a folder");
        for (path, text) in recipe.files() {
            let path = folder.path().join("demo").join(path);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, text).expect("a file");
        }
        let text = format!(
            "(packages: {{ \"demo\": \"demo\" }}, keys: {products:?}, exclude: [(when: {excluded:?}, reason: \"no\")])"
        );
        let text = text.replace("{\"", "{ \"");
        let text = as_lists(&text);
        let path = folder.path().join("some.ron");
        std::fs::write(&path, &text).expect("a file");
        let manifest = Manifest::load(&path);
        if out.is_empty() || expected.is_empty() {
            prop_assert!(manifest.is_err(), "{text}");
            return Ok(());
        }
        let manifest = manifest.map_err(|error| TestCaseError::fail(format!("{error}\n{text}")))?;
        let composer = Composer::new(manifest.library().clone(), Target::webgpu());
        let mut found = BTreeSet::new();
        let mut seen = BTreeSet::new();
        for variant in composer.select(manifest.selection()) {
            let keys = variant.keys();
            prop_assert_eq!(keys.len() as u128, variant.count());
            prop_assert!(!keys.is_empty() && seen.insert(variant.key()));
            for key in keys {
                prop_assert_eq!(composer.project(&key).expect("sound"), variant.key());
                prop_assert!(found.insert(key), "twice");
            }
        }
        prop_assert_eq!(found, expected);
    }
}

/// Sets of values in RON's brackets: `Debug` prints sets in braces, as it does maps.
fn as_lists(text: &str) -> String {
    let mut depth = Vec::new();
    let mut out = String::new();
    let chars: Vec<_> = text.chars().collect();
    for (index, c) in chars.iter().enumerate() {
        match c {
            '{' => {
                let rest: String = chars[index + 1..].iter().collect();
                let end = rest.find(['{', '}', '[']).unwrap_or(rest.len());
                let is_set = !rest[..end].contains(':');
                depth.push(is_set);
                out.push(if is_set { '[' } else { '{' });
            }
            '}' => out.push(if depth.pop() == Some(true) { ']' } else { '}' }),
            c => out.push(*c),
        }
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// A cover has each pair of choices that matter together somewhere.
    #[test]
    fn covers_have_all_pairs(recipe in generated::recipe(false)) {
        let library = recipe.library();
        let composer = Composer::new(library.clone(), Target::webgpu());
        let pairs = |variant: &Variant<'_>| -> BTreeSet<(String, String)> {
            let key = variant.key();
            let choice = |axis: &str| format!("{axis}={}", library.axes().value(&key, axis).unwrap_or(""));
            let choices: Vec<_> = variant.mattering().map(|axis| choice(axis)).collect();
            let pairs = choices.iter().flat_map(|a| choices.iter().map(move |b| (a.clone(), b.clone())));
            pairs.filter(|(a, b)| a < b).collect()
        };
        let variants: Vec<_> = composer.variants().collect();
        let all: BTreeSet<_> = variants.iter().flat_map(pairs).collect();
        let cover = composer.cover(&Selection::all()).expect("sound");
        let covering = variants.iter().filter(|variant| cover.contains(&variant.key()));
        let covered: BTreeSet<_> = covering.flat_map(pairs).collect();
        prop_assert_eq!(covered, all);
        prop_assert!(cover.len() <= variants.len());
        prop_assert_eq!(Composer::new(library.clone(), Target::webgpu()).cover(&Selection::all()).expect("sound"), cover);
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
    let library = library(&files);
    assert_eq!(library.legal_keys(), 1 << 40);
    let composer = Composer::new(library, Target::webgpu());
    let found: Vec<_> = composer
        .variants()
        .map(|v| (v.key().to_string(), v.count()))
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
    let library = library(&files);
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

/// Compares what composers that know parts make of each permutation with what a new composer makes of it, which knows
/// none: verdicts and warnings of checking, twice, the second time with all valid parts known; and what composing gives,
/// in several orders. Returns the faults.
fn compare(library: &Library) -> Vec<String> {
    let new = || Composer::new(library.clone(), Target::webgpu());
    let checker = new();
    let variants: Vec<_> = checker.variants().collect();
    let expected: Vec<_> = variants
        .iter()
        .map(|variant| made(&new(), &variant.key()))
        .collect();
    for again in [false, true] {
        for (variant, expected) in variants.iter().zip(&expected) {
            let key = variant.key();
            let checked = checker.check(variant);
            let fault = checked.fault.map(|fault| fault.to_string());
            assert_eq!(fault.as_ref(), expected.as_ref().err(), "{key}");
            if let Ok(made) = expected {
                assert_eq!(checked.warnings, made.warnings, "{key}");
                assert!(
                    !(again && made.warnings.is_empty() && checked.composed),
                    "{key}"
                );
            }
        }
    }
    let count = variants.len();
    let orders: [Vec<usize>; 3] = [
        (0..count).collect(),
        (0..count).rev().collect(),
        (0..count).step_by(2).chain((1..count).step_by(2)).collect(),
    ];
    for order in orders {
        let composer = new();
        for index in order {
            let key = variants[index].key();
            assert_eq!(made(&composer, &key), expected[index], "{key}");
        }
    }
    // All parts are known.
    for (variant, expected) in variants.iter().zip(&expected) {
        assert_eq!(
            &made(&checker, &variant.key()),
            expected,
            "{}",
            variant.key()
        );
    }
    expected.into_iter().filter_map(Result::err).collect()
}

/// Observable parts of a permutation.
#[derive(Debug, PartialEq)]
struct Made {
    text: String,
    reflection: umbrage_compose::Reflection,
    warnings: Vec<String>,
}

/// Permutation that `composer` makes of `key`, held against naga's verdict; or the fault's words.
fn made(composer: &Composer, key: &Key) -> Result<Made, String> {
    let permutation = match composer.compose(key) {
        Ok(composed) => composed.permutation,
        Err(fault) => return Err(fault.to_string()),
    };
    let capabilities = composer.target().capabilities();
    let flags = ValidationFlags::all() - ValidationFlags::CONTROL_FLOW_UNIFORMITY;
    let verdict = Validator::new(flags, capabilities).validate(&permutation.module);
    assert!(verdict.is_ok(), "{key}: {verdict:?}");
    Ok(Made {
        text: permutation.wgsl().unwrap_or_else(|error| panic!("{error}")),
        reflection: permutation.reflection.clone(),
        warnings: permutation.warnings.clone(),
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn checking_by_parts_is_composing(recipe in generated::recipe(true)) {
        compare(&recipe.library());
    }
}

const FRAGMENT: &str = "@fragment fn main(@location(0) x: f32) -> @location(0) vec4f";
const COMPUTE: &str = "@compute @workgroup_size(1) fn main()";

/// Checks a package in which faults depend on company: `first` and `second` are bound to two interfaces in turn, under
/// each of the `roots`. `fault` is how many permutations have one, and its words.
fn in_company(
    axes: &str,
    roots: [&str; 2],
    [first, second]: [&str; 2],
    notes: &str,
    fault: (usize, &str),
) {
    let bind = |interface: &str| {
        let value = |module: &str| {
            format!(
                r#""{module}": (bind: {{ "package::interface::{interface}": "package::{module}" }})"#
            )
        };
        format!(
            r#""{interface}": (values: {{ {}, {} }})"#,
            value("first"),
            value("second")
        )
    };
    let axes = format!(
        r#"(axes: {{ {axes} {}, {}, "pass": (values: {{ "one": (root: "package::one"), "two": (root: "package::two") }}) }})"#,
        bind("i"),
        bind("j")
    );
    let ask = "fn ask(x: f32) -> f32 { return x; }";
    let through = "fn i(x: f32) -> f32 { return package::interface::i::ask(x); }";
    let files = [
        ("axes.ron", axes.as_str()),
        ("one.wesl", roots[0]),
        ("two.wesl", roots[1]),
        ("first.wesl", first),
        ("second.wesl", second),
        ("notes.wesl", notes),
        ("through.wesl", through),
        ("interface/i.wesl", ask),
        ("interface/j.wesl", ask),
    ];
    let library = library(&files);
    let faults = compare(&library);
    assert!(
        faults.len() == fault.0 && faults.iter().all(|text| text.contains(fault.1)),
        "{faults:#?}"
    );
}

/// A function is valid for one stage and not for another.
#[test]
fn stages_are_seen_through_calls() {
    let one = format!("{FRAGMENT} {{ return vec4f(package::through::i(x)); }}");
    let two = format!("{COMPUTE} {{ _ = package::through::i(1.0); }}");
    let first = "fn ask(x: f32) -> f32 { @diagnostic(off, derivative_uniformity) { if dpdx(x) > 9.0 { } } return x; }";
    let second = "fn ask(x: f32) -> f32 { return x; }";
    in_company(
        "",
        [&one, &two],
        [first, second],
        "",
        (1, "forbidden at this stage"),
    );
}

/// A call demands uniform control flow, or does not.
#[test]
fn demands_of_uniformity_are_seen_through_calls() {
    let one = format!("{FRAGMENT} {{ return vec4f(package::through::i(x)); }}");
    let two = format!(
        "{FRAGMENT} {{ if x > 1.0 {{ return vec4f(package::through::i(x)); }} return vec4f(); }}"
    );
    let first = "fn ask(x: f32) -> f32 { return dpdx(x); }";
    let second = "fn ask(x: f32) -> f32 { @diagnostic(off, derivative_uniformity) { return dpdx(x); } return 0.0; }";
    in_company(
        "",
        [&one, &two],
        [first, second],
        "",
        (1, "uniform control flow"),
    );
}

/// A function's store is left out of one shader and not of another.
#[test]
fn stores_that_are_left_out_are_told_apart() {
    let one = format!(
        "{COMPUTE} {{ package::notes::c = 1.0; _ = package::through::i(1.0) + package::notes::b; }}"
    );
    let two = format!(
        "{COMPUTE} {{ package::notes::c = 1.0; _ = package::through::i(1.0) + package::notes::a + package::notes::b; }}"
    );
    let first =
        "fn ask(x: f32) -> f32 { package::notes::b = x; package::notes::a = dpdx(x); return x; }";
    let second = "fn ask(x: f32) -> f32 { package::notes::b = x; return x; }";
    let notes = "var<private> a: f32; var<private> b: f32; var<private> c: f32;";
    in_company(
        "",
        [&one, &two],
        [first, second],
        notes,
        (1, "forbidden at this stage"),
    );
}

/// Two overrides of one name are a fault of the shader that has both.
#[test]
fn overrides_are_seen_through_calls() {
    let one =
        format!("override k = 3.0; {FRAGMENT} {{ return vec4f(k + package::through::i(x)); }}");
    let two = format!("{FRAGMENT} {{ return vec4f(package::through::i(x)); }}");
    let first = "override k = 1.0; fn ask(x: f32) -> f32 { return x * k; }";
    let second = "fn ask(x: f32) -> f32 { return x * 2.0; }";
    let fault = (1, "both have an override `k`");
    in_company("", [&one, &two], [first, second], "", fault);
}

/// Two implementations share a texture.
#[test]
fn shared_state_is_seen() {
    let one = format!(
        "{FRAGMENT} {{ return vec4f(package::through::i(x) + package::interface::j::ask(x)); }}"
    );
    let two = format!("{FRAGMENT} {{ return vec4f(package::through::i(x)); }}");
    let implementation = "fn ask(x: f32) -> f32 { return package::notes::load(x); }";
    let notes = "@group(0) @binding(0) var t: texture_2d<f32>; fn load(x: f32) -> f32 { return x * textureLoad(t, vec2u(), 0).x; }";
    let other = "fn ask(x: f32) -> f32 { return 1.0 + package::notes::load(x); }";
    in_company(
        "",
        [&one, &two],
        [implementation, other],
        notes,
        (2, "would share"),
    );
}

/// Fetches of a module are counted, but not where it is called by a module that is excepted.
#[test]
fn counted_fetches_are_told_apart() {
    let axes = r#""count": (default: "on", values: { "on": (count_fetches: (call: "package::notes::count", except: ["package::through"])) }),"#;
    let one =
        format!("{FRAGMENT} {{ return vec4f(package::through::i(x) + f32(package::notes::n)); }}");
    let two = format!(
        "{FRAGMENT} {{ return vec4f(package::interface::i::ask(x) + f32(package::notes::n)); }}"
    );
    let first = "fn ask(x: f32) -> f32 { package::notes::n += 1u; return x * textureLoad(package::notes::t, vec2u(), 0).x; }";
    let second = "fn ask(x: f32) -> f32 { package::notes::count(); let y = textureLoad(package::notes::t, vec2u(), 0).x; return x * y; }";
    let notes = "@group(0) @binding(0) var t: texture_2d<f32>; var<private> n: u32; fn count() { n += 1u; }";
    in_company(
        axes,
        [&one, &two],
        [first, second],
        notes,
        (1, "without counting it"),
    );
}

/// An assertion fails under a feature, in a module from which a constant alone is taken.
#[test]
fn assertions_are_checked() {
    let axes =
        r#""narrow": (default: "off", values: { "off": (), "on": (features: ["NARROW"]) }),"#;
    let root = format!("{FRAGMENT} {{ return vec4f(package::through::i(x)); }}");
    let first = "fn ask(x: f32) -> f32 { return x * package::notes::WIDTH; }";
    let second = "fn ask(x: f32) -> f32 { return x; }";
    let notes = "const WIDTH = 9.0; @if(NARROW) const_assert WIDTH < 9.0;";
    in_company(
        axes,
        [&root, &root],
        [first, second],
        notes,
        (2, "const_assert"),
    );
}

/// Axis of a feature under which something is another way.
const NARROW: &str =
    r#""narrow": (default: "off", values: { "off": (), "on": (features: ["NARROW"]) }),"#;

/// A use of another module's variable does not tell its group.
#[test]
fn declarations_are_seen_through_imports() {
    let root = format!("{FRAGMENT} {{ return vec4f(package::through::i(x)); }}");
    let first = "fn ask(x: f32) -> f32 { return x * package::notes::u; }";
    let second = "fn ask(x: f32) -> f32 { return x; }";
    let notes = "@if(NARROW) @group(7) @binding(0) var<uniform> u: f32;\n\
                 @if(!NARROW) @group(0) @binding(0) var<uniform> u: f32;";
    let words = "maxBindGroups";
    in_company(NARROW, [&root, &root], [first, second], notes, (2, words));
}

/// A use of another module's override does not tell its default.
#[test]
fn defaults_are_seen_through_imports() {
    let root = format!("{COMPUTE} {{ _ = package::through::i(1.0); }}");
    let first = "var<workgroup> room: array<f32, package::notes::ROOM>;\n\
                 fn ask(x: f32) -> f32 { return x * room[0]; }";
    let second = "fn ask(x: f32) -> f32 { return x; }";
    let notes = "@if(NARROW) override ROOM: u32 = 5000;\n@if(!NARROW) override ROOM: u32 = 50;";
    let words = "maxComputeWorkgroupStorageSize";
    in_company(NARROW, [&root, &root], [first, second], notes, (2, words));
}

/// A limit is for variables of one kind, and one name may be of two.
#[test]
fn kinds_are_seen_through_calls() {
    let root =
        format!("{FRAGMENT} {{ return vec4f(package::through::i(x) + package::notes::all()); }}");
    let other = format!("{FRAGMENT} {{ return vec4f(package::through::i(x)); }}");
    let first = "@if(NARROW) @group(1) @binding(0) var<storage> u: f32;\n\
                 @if(!NARROW) @group(1) @binding(0) var<uniform> u: f32;\n\
                 fn ask(x: f32) -> f32 { return x * u; }";
    let second = "fn ask(x: f32) -> f32 { return x; }";
    let buffers: String = (0..8)
        .map(|n| format!("@group(0) @binding({n}) var<storage> s{n}: f32;\n"))
        .collect();
    let notes =
        format!("{buffers}fn all() -> f32 {{ return s0 + s1 + s2 + s3 + s4 + s5 + s6 + s7; }}");
    let words = "maxStorageBuffersPerShaderStage";
    in_company(NARROW, [&root, &other], [first, second], &notes, (1, words));
}

/// A contract warns of its own filters, whatever implements it.
#[test]
fn warnings_of_contracts_are_seen_through_calls() {
    let axes = format!(
        r#"(axes: {{ {NARROW}
            "i": (values: {{ "one": (bind: {{ "package::interface::i": "package::one" }}) }}),
            "pass": (values: {{ "main": (root: "package::main") }}) }})"#
    );
    let main = format!("{FRAGMENT} {{ return vec4f(package::interface::i::ask(x)); }}");
    let ask = "fn ask(x: f32) -> f32 { return x; }";
    let contract = format!("@if(NARROW) diagnostic(off, unknown);\n{ask}");
    let files = [
        ("axes.ron", axes.as_str()),
        ("main.wesl", &main),
        ("one.wesl", ask),
        ("interface/i.wesl", &contract),
    ];
    assert_eq!(compare(&library(&files)), [""; 0]);
}

/// A module of which only a variable is taken, which nothing reads, warns and fails as any other.
#[test]
fn what_has_no_effect_is_seen() {
    let root = format!("{FRAGMENT} {{ return vec4f(package::through::i(x)); }}");
    let first = "fn ask(x: f32) -> f32 { package::notes::seen = x; return x; }";
    let second = "fn ask(x: f32) -> f32 { return x; }";
    let notes = "@if(!NARROW) diagnostic(off, unknown);\n\
                 var<private> seen: f32;\n\
                 @if(NARROW) const WRONG: u32 = -1;";
    let words = "WRONG";
    in_company(NARROW, [&root, &root], [first, second], notes, (2, words));
}

fn our_library() -> Library {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shader_lib");
    let package = Package::load("umbrage", &path).unwrap_or_else(|error| panic!("{error}"));
    Library::new([package]).unwrap_or_else(|error| panic!("{error}"))
}

/// Some of our shaders, from all over the space: what a composer makes of each does not depend on what it knows.
#[test]
fn some_of_our_space_is_composed_alike() {
    let library = our_library();
    let new = || Composer::new(library.clone(), Target::webgpu());
    let [composer, checker] = [new(), new()];
    let parts = composer.variants().split(4096);
    let variants = parts
        .into_iter()
        .step_by(16)
        .filter_map(|mut part| part.next());
    let mut known = 0;
    for variant in variants {
        let key = variant.key();
        known += usize::from(!checker.check(&variant).composed);
        let expected = made(&new(), &key);
        assert_eq!(made(&checker, &key), expected, "{key}");
        assert_eq!(made(&composer, &key), expected, "{key}");
    }
    assert!(known > 0);
}

/// The whole space of our shaders: what checking by parts finds valid, composing finds valid. It takes hours.
#[test]
#[ignore = "composes more than a million permutations: run it after a change of the checker or the linker"]
fn our_whole_space_composes() {
    let library = our_library();
    let composer = Composer::new(library.clone(), Target::webgpu());
    let parts = composer.variants().split(4096);
    let next = AtomicUsize::new(0);
    let count = AtomicUsize::new(0);
    let work = || {
        while let Some(part) = parts.get(next.fetch_add(1, Ordering::Relaxed)) {
            for variant in part.clone() {
                let key = variant.key();
                let checked = composer
                    .check(&variant)
                    .fault
                    .map(|fault| fault.to_string());
                // Another composer knows nothing of the permutation's parts.
                let oracle = Composer::new(library.clone(), Target::webgpu());
                let composed = oracle.compose(&key).err().map(|fault| fault.to_string());
                assert_eq!(checked, composed, "{key}");
                count.fetch_add(1, Ordering::Relaxed);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    assert!(count.into_inner() > 1_000_000);
}
