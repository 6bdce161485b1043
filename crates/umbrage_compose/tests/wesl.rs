//! WESL: what is linked means what the `wesl` crate, another implementation, says it means. Both link
//! the same modules, and its interpreter runs `probe()` in either result.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{borrow::Cow, collections::HashMap, fs};

use proptest::prelude::*;
use umbrage_compose::{Target, link_file};
use wesl::{
    CompileOptions, ManglerKind, ModulePath, VirtualResolver, Wesl,
    syntax::{Expression, TranslationUnit},
};

/// Result of `probe()` in our linking of `files`, of which `main.wesl` is the root.
fn ours(files: &[(&str, &str)], features: &[&str]) -> String {
    let dir = tempfile::tempdir().expect("a folder");
    for (path, text) in files {
        let path = dir.path().join(path);
        fs::create_dir_all(path.parent().expect("a file lies in a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    let features: Vec<_> = features.iter().map(|name| (*name).to_owned()).collect();
    let main = dir.path().join("main.wesl");
    let linked = link_file(&main, None, &features, &[], Target::webgpu())
        .unwrap_or_else(|error| panic!("{error}"));
    let wgsl = linked.wgsl().expect("it can be said in WGSL");
    run(&wgsl
        .parse()
        .unwrap_or_else(|error| panic!("{error}\n{wgsl}")))
}

fn run(unit: &TranslationUnit) -> String {
    let call = "probe()".parse::<Expression>().expect("a call");
    let (result, _) = wesl::exec(&call, unit, HashMap::new(), HashMap::new());
    match result {
        Ok(Some(value)) => value.to_string(),
        Ok(None) => panic!("no result of {unit}"),
        Err(error) => panic!("{error} in {unit}"),
    }
}

/// Result of `probe()` in the `wesl` crate's own linking.
fn theirs(files: &[(&str, &str)], features: &[&str]) -> String {
    let mut compiler = Wesl::new_barebones().set_custom_resolver(resolver(files));
    compiler
        .use_imports(true)
        .use_condcomp(true)
        .use_stripping(true)
        .use_lower(true);
    compiler.set_mangler(ManglerKind::Escape);
    compiler.keep_declarations(vec!["probe".to_owned()]);
    compiler.set_features(features.iter().map(|name| (name, true)));
    let linked = compiler
        .compile(&ModulePath::from_path("/main"))
        .unwrap_or_else(|error| panic!("{error}"));
    run(&linked.syntax)
}

fn resolver<'a>(files: &[(&str, &'a str)]) -> VirtualResolver<'a> {
    let mut resolver = VirtualResolver::new();
    for (path, text) in files {
        let path = format!("/{}", path.trim_end_matches(".wesl"));
        resolver.add_module(ModulePath::from_path(path), Cow::Borrowed(*text));
    }
    resolver
}

#[track_caller]
fn agree(files: &[(&str, &str)], features: &[&str], expected: &str) {
    assert_eq!(ours(files, features), expected);
    assert_eq!(theirs(files, features), expected);
}

/// Imports that lead nowhere are no fault until they are used.
#[test]
fn imports_that_are_not_used_may_lead_nowhere() {
    for import in [
        "nowhere::a",
        "package::nowhere::a",
        "package::units::NOWHERE",
        "{nowhere::a, package_too::b}",
        "package::nowhere",
    ] {
        let main = format!("import {import};\nfn probe() -> u32 {{ return 7u; }}\n");
        let files = with_main(&main);
        assert_eq!(ours(&files, &[]), "7u", "{import}");
        let theirs = std::panic::catch_unwind(|| lazy(&files));
        assert_eq!(theirs.expect(import), "7u");
    }
}

/// Result of `probe()` where the `wesl` crate links as its specification has it: unused modules stay unread.
fn lazy(files: &[(&str, &str)]) -> String {
    let mut compiler = Wesl::new_barebones().set_custom_resolver(resolver(files));
    compiler.set_options(CompileOptions {
        keep: Some(vec!["probe".to_owned()]),
        ..CompileOptions::default()
    });
    let linked = compiler
        .compile(&ModulePath::from_path("/main"))
        .unwrap_or_else(|error| panic!("{error}"));
    run(&linked.syntax)
}

const SHAPES: &[(&str, &str)] = &[
    (
        "shapes/box.wesl",
        "import super::super::units::METRE;\nstruct Box { side: u32 }\nfn volume(b: Box) -> u32 { return b.side * b.side * b.side * METRE; }\nfn unit() -> Box { return Box(1u); }\n",
    ),
    (
        "shapes/ball.wesl",
        "import package::units::{METRE as M};\nconst PI = 3u * M;\nfn volume(radius: u32) -> u32 { return 4u * PI * radius / 3u; }\n",
    ),
    (
        "units.wesl",
        "const METRE = 10u;\noverride SCALE: u32 = 2u;\n",
    ),
];

fn with_main(main: &str) -> Vec<(&str, &str)> {
    let mut files = SHAPES.to_vec();
    files.push(("main.wesl", main));
    files
}

#[test]
fn an_item() {
    agree(
        &with_main("import package::units::METRE;\nfn probe() -> u32 { return METRE + 1u; }\n"),
        &[],
        "11u",
    );
}

#[test]
fn renamed_and_nested_lists() {
    let main = "import package::shapes::{box::{Box, unit, volume as box_volume}, ball::volume};\n\
        fn probe() -> u32 {\n    var b: Box = unit();\n    b.side = 2u;\n    return box_volume(b) + volume(3u);\n}\n";
    agree(&with_main(main), &[], "200u");
}

#[test]
fn a_module() {
    let main = "import package::shapes::ball;\nfn probe() -> u32 { return ball::volume(3u) + ball::PI; }\n";
    // Version 0.4 of the `wesl` crate cannot import a module, which the specification allows.
    assert_eq!(ours(&with_main(main), &[]), "150u");
}

#[test]
fn paths_in_code() {
    let main = "fn probe() -> u32 {\n    let b: package::shapes::box::Box = package::shapes::box::unit();\n    return package::shapes::box::volume(b) + b.side;\n}\n";
    agree(&with_main(main), &[], "11u");
}

#[test]
fn super_in_code() {
    let mut files =
        with_main("import package::deep::down::depth;\nfn probe() -> u32 { return depth(); }\n");
    files.push((
        "deep/down.wesl",
        "fn depth() -> u32 { return super::super::units::METRE + super::beside::ONE; }\n",
    ));
    files.push(("deep/beside.wesl", "const ONE = 1u;\n"));
    agree(&files, &[], "11u");
}

#[test]
fn modules_that_import_each_other() {
    let files = [
        (
            "main.wesl",
            "import package::a::even;\nfn probe() -> u32 { return even(); }\n",
        ),
        (
            "a.wesl",
            "import package::b::odd;\nconst A = 1u;\nfn even() -> u32 { return odd() + A; }\n",
        ),
        (
            "b.wesl",
            "import package::a::A;\nfn odd() -> u32 { return A + 5u; }\n",
        ),
    ];
    agree(&files, &[], "7u");
}

#[test]
fn the_same_name_in_two_modules() {
    let files = [
        (
            "main.wesl",
            "import package::a::first;\nimport package::b::second;\nfn helper() -> u32 { return 100u; }\nfn probe() -> u32 { return first() + second() + helper(); }\n",
        ),
        (
            "a.wesl",
            "fn helper() -> u32 { return 1u; }\nfn first() -> u32 { return helper(); }\n",
        ),
        (
            "b.wesl",
            "fn helper() -> u32 { return 10u; }\nfn second() -> u32 { return helper(); }\n",
        ),
    ];
    agree(&files, &[], "111u");
}

#[test]
fn a_local_shadows_an_import() {
    let main = "import package::units::METRE;\nfn probe() -> u32 {\n    let METRE = 5u;\n    return METRE;\n}\n";
    agree(&with_main(main), &[], "5u");
}

/// The linked text of one file.
fn linked(text: &str) -> String {
    let dir = tempfile::tempdir().expect("a folder");
    let main = dir.path().join("main.wesl");
    fs::write(&main, text).expect("a file");
    let linked = link_file(&main, None, &[], &[], Target::webgpu());
    let linked = linked.unwrap_or_else(|error| panic!("{error}"));
    let wgsl = linked.wgsl().unwrap_or_else(|error| panic!("{error}"));
    naga::front::wgsl::parse_str(&wgsl).unwrap_or_else(|error| panic!("{error}\n{wgsl}"));
    linked.spirv().unwrap_or_else(|error| panic!("{error}"));
    wgsl
}

/// A host finds entry points and overrides by their names.
#[test]
fn names_that_a_host_knows() {
    let text = linked(
        "override scale1: f32 = 2.0;\nfn fs() -> f32 { return scale1; }\n\
         @fragment fn fs1() -> @location(0) vec4f { return vec4f(fs()); }\n\
         @vertex fn vs_2() -> @builtin(position) vec4f { return vec4f(); }\n",
    );
    assert!(text.contains("override scale1: f32"), "{text}");
    assert!(
        text.contains("fn fs1(") && text.contains("fn vs_2(") && text.contains("fn fs("),
        "{text}"
    );
}

/// Code that depends on overrides can be printed as WGSL, which keeps them, and as SPIR-V, at their defaults.
#[test]
fn overrides() {
    let shader = |body: &str| format!("override O: f32 = 2.0;\noverride N: u32 = 3u;\n{body}\n");
    let fragment = "@fragment fn fs() -> @location(0) vec4f { return vec4f(R); }";
    for derived in ["O * 2.0", "-O", "max(O, 1.0)", "O"] {
        linked(&shader(&format!(
            "override R: f32 = {derived};\n{fragment}"
        )));
    }
    linked(&shader(&format!(
        "var<private> R: f32 = O + 1.0;\n{fragment}"
    )));
    let sized = "var<workgroup> R: f32;\n@compute @workgroup_size(N) fn cs() { R = O; }";
    let text = linked(&shader(sized));
    assert!(text.contains("@workgroup_size(N, 1, 1)"), "{text}");
}

/// A struct lies in the linked text as its author asked.
#[test]
fn sizes_and_alignments() {
    let dir = tempfile::tempdir().expect("a folder");
    let light = "struct Light { @size(32) color: vec3f, @align(32) reach: f32, kind: u32, inner: Inner, last: vec2f }\n\
        struct Inner { @align(16) a: f32, b: array<vec4f, 2> }\n";
    fs::write(dir.path().join("light.wesl"), light).expect("a file");
    let main = dir.path().join("main.wesl");
    fs::write(
        &main,
        "import package::light::Light;\nstruct Plain { a: f32, b: vec3f, c: f32 }\n\
        @group(0) @binding(0) var<storage> lights: array<Light>;\n\
        @group(0) @binding(1) var<uniform> plain: Plain;\n",
    )
    .expect("a file");
    let linked = link_file(&main, None, &[], &[], Target::webgpu())
        .unwrap_or_else(|error| panic!("{error}"));
    let wgsl = linked.wgsl().expect("it can be said in WGSL");
    let again =
        naga::front::wgsl::parse_str(&wgsl).unwrap_or_else(|error| panic!("{error}\n{wgsl}"));
    let layouts = |module: &naga::Module| {
        let structs = module.types.iter().filter_map(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { members, span } => {
                let offsets: Vec<_> = members.iter().map(|member| member.offset).collect();
                Some((ty.name.clone(), (offsets, *span)))
            }
            _ => None,
        });
        structs.collect::<std::collections::BTreeMap<_, _>>()
    };
    assert_eq!(layouts(&again), layouts(&linked.module), "{wgsl}");
    assert_eq!(
        layouts(&again)[&Some("Light".to_owned())].0,
        [0, 32, 36, 48, 96]
    );
    assert!(
        wgsl.contains("    a: f32,\n    b: vec3<f32>,\n"),
        "what needs no size has none: {wgsl}"
    );
}

const CONDITIONS: &str = "
@if(A) import package::x::value;
@elif(B) import package::y::value;
@else import package::z::value;

struct Sum {
    @if(A) a: u32,
    base: u32,
    @if(!A && B) b: u32,
}

fn add(left: u32, @if(A) middle: u32, @else other: u32, right: u32) -> u32 {
    @if(A) return left + 100u * middle + right;
    @else return left + 1000u * other + right;
}

fn probe() -> u32 {
    var sum: Sum;
    sum.base = 1u;
    @if(A) sum.a = 2u;
    @if(!A && B) {
        sum.b = 4u;
        sum.base += sum.b;
    }
    var result = sum.base + value();
    @if(A) result += sum.a;
    switch result {
        @if(A) case 13u { result += 10000u; }
        @if(B) case 25u { result += 20000u; }
        default { result += 30000u; }
    }
    @if(A) { result += 500000u; } @else { result += 600000u; }
    for (var i = 0u; i < 2u; i++) {
        @if(B) result += 1000000u;
    }
    return add(result, 1u, 2u);
}
";

#[test]
fn conditions_everywhere() {
    let files = [
        ("main.wesl", CONDITIONS),
        ("x.wesl", "fn value() -> u32 { return 10u; }\n"),
        ("y.wesl", "fn value() -> u32 { return 20u; }\n"),
        ("z.wesl", "fn value() -> u32 { return 30u; }\n"),
    ];
    for features in [&[][..], &["A"], &["B"], &["A", "B"]] {
        assert_eq!(
            ours(&files, features),
            theirs(&files, features),
            "with {features:?}"
        );
    }
}

#[derive(Clone, Debug)]
enum Condition {
    Flag(u8),
    Constant(bool),
    Not(Box<Condition>),
    And(Box<Condition>, Box<Condition>),
    Or(Box<Condition>, Box<Condition>),
}

impl Condition {
    fn holds(&self, enabled: u8) -> bool {
        match self {
            Self::Flag(flag) => enabled >> flag & 1 == 1,
            Self::Constant(value) => *value,
            Self::Not(inner) => !inner.holds(enabled),
            Self::And(a, b) => a.holds(enabled) && b.holds(enabled),
            Self::Or(a, b) => a.holds(enabled) || b.holds(enabled),
        }
    }

    fn written(&self) -> String {
        match self {
            Self::Flag(flag) => format!("F{flag}"),
            Self::Constant(value) => value.to_string(),
            Self::Not(inner) => format!("!({})", inner.written()),
            Self::And(a, b) => format!("({} && {})", a.written(), b.written()),
            Self::Or(a, b) => format!("({} || {})", a.written(), b.written()),
        }
    }
}

fn condition() -> impl Strategy<Value = Condition> {
    let leaf = prop_oneof![
        (0u8..4).prop_map(Condition::Flag),
        any::<bool>().prop_map(Condition::Constant)
    ];
    leaf.prop_recursive(4, 24, 2, |inner| {
        prop_oneof![
            inner.clone().prop_map(|a| Condition::Not(a.into())),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| Condition::And(a.into(), b.into())),
            (inner.clone(), inner).prop_map(|(a, b)| Condition::Or(a.into(), b.into())),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// An `@if`, `@elif`, `@else` chain takes the first branch whose condition holds.
    #[test]
    fn the_first_branch_that_holds(first in condition(), second in condition(), enabled in 0u8..16) {
        let main = format!(
            "// F0 F1 F2 F3\n@if(F0 || F1 || F2 || F3 || true) const ALL = 0u;\n\
             @if({}) const BRANCH = 1u;\n@elif({}) const BRANCH = 2u;\n@else const BRANCH = 3u;\n\
             fn probe() -> u32 {{ return BRANCH + ALL; }}\n",
            first.written(), second.written(),
        );
        let expected = if first.holds(enabled) { 1 } else if second.holds(enabled) { 2 } else { 3 };
        let names = ["F0", "F1", "F2", "F3"];
        let features: Vec<_> = (0..4).filter(|flag| enabled >> flag & 1 == 1).map(|flag| names[flag]).collect();
        prop_assert_eq!(ours(&[("main.wesl", &main)], &features), format!("{expected}u"));
    }
}
