//! Legal keys of our library: what provides and needs allow is what lists of excluded combinations, one a reason, allow.

use std::collections::BTreeMap;

use umbrage::compose::Library;

const BOUNDED_OR_BLURRED: &[&str] = &[
    "esm",
    "esm_half",
    "esm_log",
    "hpsm",
    "hpsm_naive",
    "min_max",
    "min_max_tree",
];
const MIDPOINTS: &[&str] = &["midpoint", "midpoint_sampled", "midpoint_two_passes"];
/// Lookups that read no tiles of one texture.
const APART: &[&str] = &["branches", "channels", "weights"];

/// Excluded combinations: values of some axes that make no sense together.
const EXCLUDED: &[&[(&str, &[&str])]] = &[
    // A cube map can only be sampled by comparing, holds the nearest depths alone, and has no splits.
    &[("filter", BOUNDED_OR_BLURRED), ("light", &["point"])],
    &[("depth", MIDPOINTS), ("light", &["point"])],
    &[("method", &["pssm"]), ("light", &["point"])],
    // Only tiles of one texture can be sampled otherwise than by comparing, and hold other depths than the nearest.
    &[
        ("filter", BOUNDED_OR_BLURRED),
        ("method", &["pssm"]),
        ("lookup", APART),
    ],
    &[
        ("depth", MIDPOINTS),
        ("method", &["pssm"]),
        ("lookup", APART),
    ],
    // A pass that computes from a map wants its depths.
    &[
        ("filter", BOUNDED_OR_BLURRED),
        ("depth", &["midpoint_sampled"]),
    ],
    // A mask holds terms of the pixels seen, and nothing of how they were found.
    &[
        (
            "pass",
            &["decision", "fetch_count", "shaft_fetches", "shafts"],
        ),
        ("method", &["mask"]),
    ],
    // In the air, a sum over many points hides what more than four taps, or a blend of splits, would show.
    &[("pass", IN_THE_AIR), ("taper", &["on"])],
    &[("pass", &["mask"]), ("method", &["mask", "none"])],
    // Only a spot light has the one projection that a cookie needs.
    &[("cookie", &["on"]), ("light", &["directional", "point"])],
    // There are no splits to narrow the filter over.
    &[("taper", &["on"]), ("method", &["basic"])],
    // Light that is not added to a picture is not dimmed on its way.
    &[("medium", &["on"]), ("pass", ADDING_NO_LIGHT)],
];

const ADDING_NO_LIGHT: &[&str] = &[
    "base",
    "caster",
    "caster_depth",
    "caster_faces",
    "decision",
    "depth_range",
    "esm_across",
    "esm_down",
    "esm_round",
    "fetch_count",
    "haze",
    "hpsm",
    "linear_depth",
    "mask",
    "midpoint",
    "min_max_tree",
    "region",
    "shadow_term",
    "shaft_fetches",
    "triangle",
];

const IN_THE_AIR: &[&str] = &["shaft_fetches", "shafts"];

/// Excluded combinations of the axes that only these are about.
const EXCLUDED_OF_FEW: &[&[(&str, &[&str])]] = &[
    &[
        ("pass", IN_THE_AIR),
        ("pcf", &["5", "7", "9", "11", "13", "15"]),
    ],
    &[("pass", IN_THE_AIR), ("transition", &["blend", "dither"])],
    // A point in the air has no plane.
    &[("pass", IN_THE_AIR), ("receiver_bias", &["plane"])],
    // A mean of one texel along a row is the mean along its column.
    &[("pass", &["esm_down"]), ("pcf", &["1"])],
];

/// Passes that make what certain values alone read: the pass, the axis, and these values.
const MAKERS: &[(&str, &str, &[&str])] = &[
    ("esm_across", "filter", &["esm", "esm_half", "esm_log"]),
    ("esm_down", "filter", &["esm", "esm_half", "esm_log"]),
    ("esm_round", "filter", &["esm_half"]),
    ("hpsm", "filter", &["hpsm", "hpsm_naive", "min_max"]),
    ("midpoint", "depth", &["midpoint", "midpoint_two_passes"]),
    ("min_max_tree", "filter", &["min_max_tree"]),
];

/// Every combination of the axes that are excluded somewhere is legal exactly where no list excludes it.
#[test]
fn needs_exclude_what_makes_no_sense_and_nothing_else() {
    let legal = legal(EXCLUDED, |combination| {
        // The one bias that goes with them.
        let in_the_air = |(axis, value): &_| *axis == "pass" && IN_THE_AIR.contains(value);
        let airy = combination.iter().any(in_the_air);
        Vec::from_iter(airy.then_some(("receiver_bias", "constant")))
    });
    assert!(legal > 10_000, "{legal}");
    // Passes that make what others read go with some of these.
    let legal = self::legal(EXCLUDED_OF_FEW, |combination| {
        let makers = MAKERS
            .iter()
            .filter(|(maker, ..)| combination.contains(&("pass", maker)));
        let read = makers.map(|(_, axis, values)| (*axis, values[0]));
        read.chain([("method", "basic")]).collect()
    });
    assert!(legal > 100, "{legal}");
}

/// Holds what the library makes of every combination of the axes of `excluded` against it, and counts the legal ones.
/// Each goes with what `with` it is chosen.
fn legal(
    excluded: &[&[(&'static str, &[&str])]],
    with: impl Fn(&[(&'static str, &str)]) -> Vec<(&'static str, &'static str)>,
) -> u32 {
    let package = umbrage::shader_package().expect("our package");
    let library = Library::new([package]).expect("a library");
    let mut axes: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (name, _) in excluded.iter().copied().flatten() {
        let axis = library.axes().get(name).expect("an axis");
        axes.insert(name, axis.values().collect());
    }
    let mut combinations = vec![Vec::new()];
    for (axis, values) in &axes {
        let longer = combinations.iter().flat_map(|combination: &Vec<_>| {
            let with = |value| {
                combination
                    .iter()
                    .copied()
                    .chain([(*axis, value)])
                    .collect()
            };
            values.iter().copied().map(with)
        });
        combinations = longer.collect();
    }
    let mut legal = 0;
    for combination in combinations {
        let combination: Vec<_> = with(&combination).into_iter().chain(combination).collect();
        let has = |(axis, values): &(&str, &[&str])| {
            let mut chosen = combination.iter();
            chosen.any(|(known, value)| known == axis && values.contains(value))
        };
        let made_for_none = MAKERS
            .iter()
            .any(|(pass, axis, readers)| has(&("pass", &[pass])) && !has(&(axis, readers)));
        let none = excluded.iter().any(|values| values.iter().all(has));
        let excluded = made_for_none || none;
        let key = library.key(combination.iter().copied());
        assert_eq!(key.is_err(), excluded, "{combination:?}: {key:?}");
        legal += u32::from(!excluded);
    }
    legal
}

/// A filter of another package, with its module, is chosen without a line of ours: two files.
#[test]
fn a_filter_from_outside_edits_no_other_value() {
    let axes = r#"(axes: {
        "filter": (values: {
            "bright": (
                bind: { "umbrage::interface::filter": "package::bright" },
                needs: ["planar", "stored_depths", "tiles"],
            ),
        }),
    })"#;
    let files = [("axes.ron", axes), ("bright.wesl", BRIGHT)];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let outside = umbrage::compose::Package::from_sources("outside", "outside", files);
    let packages = [
        umbrage::shader_package().expect("our package"),
        outside.expect("a package"),
    ];
    let library = Library::new(packages).expect("a library");
    let key = |light| {
        library.key([
            ("pass", "shadow_term"),
            ("method", "basic"),
            ("filter", "bright"),
            ("light", light),
        ])
    };
    let error = key("point")
        .expect_err("a cube map has no plane")
        .to_string();
    assert!(error.contains("filter=bright needs `planar`"), "{error}");
    let composer =
        umbrage::compose::Composer::new(library.clone(), umbrage::compose::Target::webgpu());
    composer
        .compose(&key("spot").expect("a key"))
        .expect("a permutation");
}

/// An axis's provisions are said once, so that its values mean the same whichever packages there are.
#[test]
fn two_packages_cannot_say_what_an_axis_provides() {
    let axes = r#"(axes: { "method": (provides: ["tiles"], values: {}) })"#;
    let files = [("axes.ron".to_owned(), axes.to_owned())];
    let outside = umbrage::compose::Package::from_sources("outside", "outside", files);
    let ours = umbrage::shader_package().expect("our package");
    let error = Library::new([ours, outside.expect("a package")]).expect_err("said twice");
    let told = error.to_string();
    // Packages are read in the order of their names.
    assert!(told.contains("already what `method` provides"), "{told}");
    assert!(
        told.contains("umbrage") || told.contains("shader_lib"),
        "{told}"
    );
}

const BRIGHT: &str = "import umbrage::interface::filter::Tile;
fn filter_map(at: vec2f, plane: vec3f, tile: Tile) -> f32 {
    return 0.5;
}
";
