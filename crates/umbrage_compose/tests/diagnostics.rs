//! Diagnostic filters and extensions: naga's IR cannot express them, yet the printed text has them.

use std::sync::Arc;

use naga::valid::Capabilities;
use umbrage_compose::{Composed, Composer, Error, Library, Package, Permutation, Source, Target};

const AXES: &str = r#"(axes: {
    "pass": (values: { "main": (root: "package::main") }),
    "loud": (default: "off", values: { "off": (), "on": (features: ["LOUD"]) }),
})"#;

fn composer(files: &[(&str, &str)]) -> Result<Composer, Error> {
    let all = [("axes.ron", AXES)]
        .into_iter()
        .chain(files.iter().copied());
    let files = all.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let library = Library::new([Package::from_sources("demo", "demo", files)?])?;
    Ok(Composer::new(
        library,
        Target::new("all", Capabilities::all()),
    ))
}

fn compose(composer: &Composer, loud: &str) -> Result<Composed, Error> {
    let key = composer
        .library()
        .key([("pass", "main"), ("loud", loud)])
        .expect("a key");
    composer.compose(&key)
}

fn linked(files: &[(&str, &str)]) -> Result<Arc<Permutation>, Error> {
    Ok(compose(&composer(files)?, "off")?.permutation)
}

#[track_caller]
fn wgsl(files: &[(&str, &str)]) -> String {
    let linked = linked(files).expect("it is sound");
    linked.wgsl().expect("it can be said in WGSL")
}

/// A module whose function takes a derivative where control flow has parted.
const HELPER: &str = "fn helped(x: f32) -> f32 {
    if x > 1.0 {
        return fwidth(x);
    }
    return 0.0;
}
";

const MAIN: &str = "import package::helper::helped;
@fragment fn fs(@location(0) x: f32) -> @location(0) vec4f {
    return vec4f(helped(x) + dpdx(x));
}
";

const DIRECTIVE: &str = "diagnostic(off, derivative_uniformity);\n";

#[test]
fn a_directive_holds_for_its_module_alone() {
    let helper = format!("{DIRECTIVE}{HELPER}");
    let text = wgsl(&[("main.wesl", MAIN), ("helper.wesl", &helper)]);
    assert!(!text.contains("diagnostic(off, derivative_uniformity);"));
    assert!(text.contains("@diagnostic(off, derivative_uniformity)\nfn helped("));
    assert_eq!(text.matches("diagnostic").count(), 1, "{text}");

    // The root's says nothing of the helper's functions.
    let main = MAIN.replacen('@', &format!("{DIRECTIVE}@"), 1);
    let error = linked(&[("main.wesl", &main), ("helper.wesl", HELPER)]).expect_err("a fault");
    let fault = &error.faults()[0];
    let places: Vec<_> = fault
        .locations
        .iter()
        .map(|at| (at.file.as_str(), at.line, at.column))
        .collect();
    let expected = [
        ("demo/helper.wesl", 3, 16),
        ("demo/main.wesl", 4, 18),
        ("demo/helper.wesl", 2, 8),
        ("demo/main.wesl", 3, 30),
    ];
    assert_eq!(places, expected, "{error}");
    insta::assert_snapshot!(error.to_string());
}

#[test]
fn what_all_functions_agree_on_is_a_directive() {
    let main = MAIN.replacen('@', &format!("{DIRECTIVE}@"), 1);
    let helper = format!("{DIRECTIVE}{HELPER}");
    let text = wgsl(&[("main.wesl", &main), ("helper.wesl", &helper)]);
    assert!(text.starts_with(DIRECTIVE), "{text}");
    assert_eq!(text.matches("diagnostic").count(), 1, "{text}");
}

#[test]
fn what_no_operation_needs_is_left_out() {
    let main = format!("{DIRECTIVE}@fragment fn fs() -> @location(0) vec4f {{ return vec4f(); }}");
    let text = wgsl(&[("main.wesl", &main)]);
    assert!(!text.contains("diagnostic"), "{text}");
}

#[test]
fn attributes_of_statements_are_kept_on_blocks() {
    let helper = "fn helped(x: f32) -> f32 {
    var sum = dpdx(x);
    @diagnostic(off, derivative_uniformity)
    for (var i = 0.0; i < x; i += 1.0) {
        sum += dpdy(x);
    }
    if x > 1.0 {
        sum += 1.0;
    } else @diagnostic(off, derivative_uniformity) {
        sum += fwidth(x);
    }
    return sum;
}
";
    let text = wgsl(&[("main.wesl", MAIN), ("helper.wesl", helper)]);
    let blocks: Vec<_> = text
        .lines()
        .filter(|line| line.contains("diagnostic"))
        .map(str::trim)
        .collect();
    let expected = [
        "@diagnostic(off, derivative_uniformity) {",
        "} else @diagnostic(off, derivative_uniformity) {",
    ];
    assert_eq!(blocks, expected, "{text}");
}

#[test]
fn an_attribute_that_a_condition_needs_goes_to_the_block_around() {
    let helper = "fn helped(x: f32) -> f32 {
    @diagnostic(off, derivative_uniformity)
    if x > 1.0 && dpdx(x) > 0.0 {
        return 1.0;
    }
    return 0.0;
}
";
    let text = wgsl(&[("main.wesl", MAIN), ("helper.wesl", helper)]);
    assert!(
        text.contains("@diagnostic(off, derivative_uniformity)\nfn helped("),
        "{text}"
    );
}

#[test]
fn a_condition_decides_about_filters_too() {
    for filter in [
        format!("@if(!LOUD)\n{DIRECTIVE}{HELPER}"),
        format!("@if(!LOUD) @diagnostic(off, derivative_uniformity)\n{HELPER}@else\n{HELPER}"),
    ] {
        let composer = composer(&[("main.wesl", MAIN), ("helper.wesl", &filter)]).expect("sound");
        assert!(compose(&composer, "off").is_ok(), "{filter}");
        let error = compose(&composer, "on").expect_err("nothing is filtered");
        assert!(error.to_string().contains("`fwidth` must only be called"));
    }
}

#[test]
fn what_a_filter_makes_less_than_an_error_is_told() {
    for severity in ["warning", "info"] {
        let helper = format!("diagnostic({severity}, derivative_uniformity);\n{HELPER}");
        let linked = linked(&[("main.wesl", MAIN), ("helper.wesl", &helper)]).expect("it is sound");
        let [warning] = linked.warnings.as_slice() else {
            unreachable!("one warning, not {:?}", linked.warnings);
        };
        assert!(warning.starts_with("`fwidth` must only be called from uniform control flow"));
        assert!(warning.contains("demo/helper.wesl:4:16"), "{warning}");
        assert!(warning.contains(&format!("`{severity}`")), "{warning}");
    }
}

#[test]
fn rules_that_are_none_are_told() {
    let helper = format!(
        "@diagnostic(off, derivative_unifomity)\n{}",
        HELPER.replace("fwidth(x)", "x")
    );
    let linked = linked(&[("main.wesl", MAIN), ("helper.wesl", &helper)]).expect("it is sound");
    let warning = linked.warnings.first().expect("a warning");
    assert!(warning.contains("WGSL has no diagnostic rule `derivative_unifomity`"));
    assert!(warning.contains("demo/helper.wesl:1:1"), "{warning}");
    assert!(warning.contains("did you mean `derivative_uniformity`?"));
}

#[test]
fn rules_of_other_tools_are_kept() {
    let helper = format!("diagnostic(info, tool.rule);\n{DIRECTIVE}{HELPER}");
    let text = wgsl(&[("main.wesl", MAIN), ("helper.wesl", &helper)]);
    assert!(
        text.contains("@diagnostic(info, tool.rule)\nfn helped("),
        "{text}"
    );
    assert_eq!(text.matches("tool.rule").count(), 1, "{text}");
}

#[test]
fn the_disk_cache_keeps_filters_and_warnings() {
    let dir = tempfile::tempdir().expect("a folder");
    let helper = format!("diagnostic(warning, derivative_uniformity);\n{HELPER}");
    let made = || {
        let composer = composer(&[("main.wesl", MAIN), ("helper.wesl", &helper)])
            .and_then(|composer| composer.with_disk_cache(dir.path()))
            .expect("sound");
        compose(&composer, "off").expect("it is sound")
    };
    let (linked, found) = (made(), made());
    assert_eq!(
        (linked.source, found.source),
        (Source::Linked, Source::Disk)
    );
    assert_eq!(linked.warnings, found.warnings);
    assert_eq!(found.warnings.len(), 1);
    let text = |composed: &Composed| composed.permutation.wgsl().expect("WGSL");
    assert_eq!(text(&linked), text(&found));
    assert!(text(&found).contains("@diagnostic(warning, derivative_uniformity)\nfn helped("));
}

const HALVES: &str = "enable f16;
struct Half { x: f16 }
fn half(x: f32) -> Half { return Half(f16(x)); }
fn whole(x: f32) -> f32 { return x; }
";

#[test]
fn what_an_imported_module_enables_is_enabled_for_what_is_taken() {
    let main = "import package::halves::{Half, half};
@fragment fn fs(@location(0) x: f32) -> @location(0) vec4f {
    let taken: Half = half(x);
    return vec4f(f32(taken.x));
}
";
    let text = wgsl(&[("main.wesl", main), ("halves.wesl", HALVES)]);
    assert!(text.starts_with("enable f16;\n"), "{text}");

    // Places stay the author's.
    let main = main.replace("vec4f(f32(taken.x))", "vec4f(taken.y)");
    let error = linked(&[("main.wesl", &main), ("halves.wesl", HALVES)]).expect_err("a fault");
    let place = error.faults()[0].location().expect("a place");
    assert_eq!(
        (place.file.as_str(), place.line),
        ("demo/main.wesl", 4),
        "{error}"
    );
}

#[test]
fn what_nothing_needs_is_not_enabled() {
    let main = "import package::halves::whole;
@fragment fn fs(@location(0) x: f32) -> @location(0) vec4f { return vec4f(whole(x)); }
";
    let text = wgsl(&[("main.wesl", main), ("halves.wesl", HALVES)]);
    assert!(!text.contains("enable"), "{text}");
}

#[test]
fn subgroups_are_enabled_where_they_are_used() {
    let main = |enable: &str, value: &str| {
        format!(
            "{enable}@compute @workgroup_size(64) fn cs() {{ _ = {value}; }}
@fragment fn fs(@location(0) x: f32) -> @location(0) vec4f {{ return vec4f(x); }}
"
        )
    };
    for enable in [
        "",
        "enable subgroups;\n",
        "enable f16, subgroups;\n",
        "enable subgroups, f16;\n",
    ] {
        let text = wgsl(&[("main.wesl", &main(enable, "subgroupAdd(1.0)"))]);
        assert!(text.starts_with("enable subgroups;\n"), "{text}");
        assert!(!text.contains("f16"), "{text}");
        let text = wgsl(&[("main.wesl", &main(enable, "1.0"))]);
        assert!(!text.contains("enable"), "{text}");
    }
}

#[test]
fn subgroup_operations_have_a_rule_of_their_own() {
    let main = |filter: &str| {
        format!(
            "enable subgroups;
@compute @workgroup_size(64) fn cs(@builtin(local_invocation_id) local: vec3u) {{
    {filter}if local.x > 3 {{
        _ = subgroupAdd(1);
    }}
}}
"
        )
    };
    let error = linked(&[("main.wesl", &main(""))]).expect_err("a fault");
    assert!(
        error.to_string().contains("subgroup uniform control flow"),
        "{error}"
    );
    let other = main("@diagnostic(off, derivative_uniformity) ");
    assert!(linked(&[("main.wesl", &other)]).is_err());
    let text = wgsl(&[("main.wesl", &main("@diagnostic(off, subgroup_uniformity) "))]);
    assert!(
        text.contains("diagnostic(off, subgroup_uniformity)"),
        "{text}"
    );
}

/// Naga lays out a struct within another without what `@align` asks of its members.
#[test]
fn an_alignment_within_a_member_is_not_lost_unawares() {
    let main = |outer: &str| {
        format!(
            "struct Inner {{ @align(32) x: f32, y: f32 }}
struct Outer {{ {outer} }}
@group(0) @binding(0) var<storage> given: Outer;
@fragment fn fs() -> @location(0) vec4f {{ let inner = given.inner; return vec4f(); }}
"
        )
    };
    for outer in ["z: f32, inner: Inner", "z: f32, inner: array<Inner, 2>"] {
        let error = linked(&[("main.wesl", &main(outer))]).expect_err("another layout");
        let fault = &error.faults()[0];
        assert!(fault.message.contains("aligned to 32"), "{error}");
        let place = fault.location().expect("a place");
        let column = "struct Outer { ".len() + outer.find("inner").unwrap_or(0) + 1;
        assert_eq!((place.line, place.column), (2, column), "{error}");
    }
    let text = wgsl(&[("main.wesl", &main("z: f32, @align(32) inner: Inner"))]);
    assert!(text.contains("@size(32) z: f32"), "{text}");
    // The last member lacks only padding.
    for outer in ["inner: Inner", "inner: Inner, z: f32"] {
        let text = wgsl(&[("main.wesl", &main(outer))]);
        assert!(text.contains("@size(28) y: f32"), "{text}");
    }
}
