//! Names that a host knows: in the printed text, all that a host names has the name that its author gave it, as
//! the reflection tells.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{collections::BTreeSet, fs};

use naga::{
    Module,
    valid::{Capabilities, ValidationFlags, Validator},
};
use proptest::prelude::*;
use umbrage_compose::{
    BindingKind, Composer, Error, InSpirv, Library, OverrideType, Package, Permutation, Target,
    link_file,
};

/// Links all of `main.wesl` of `files`.
fn link(files: &[(&str, &str)]) -> Result<Permutation, Error> {
    let dir = tempfile::tempdir().expect("a folder");
    for (path, text) in files {
        let path = dir.path().join(path);
        fs::create_dir_all(path.parent().expect("a file lies in a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    let main = dir.path().join("main.wesl");
    link_file(&main, None, &[], &[], Target::webgpu())
}

/// The text printed for `files`, and naga's module of it, which must be valid and print the same text again.
fn printed(files: &[(&str, &str)]) -> (String, Module) {
    let linked = link(files).unwrap_or_else(|error| panic!("{error}"));
    let text = linked.wgsl().unwrap_or_else(|error| panic!("{error}"));
    let module = read(&text);
    for entry in &linked.module.entry_points {
        let again = module.entry_points.iter().find(|e| e.name == entry.name);
        let again = again.unwrap_or_else(|| panic!("no {} in\n{text}", entry.name));
        assert_eq!(again.stage, entry.stage);
    }
    let settable = |module: &Module| -> BTreeSet<_> {
        let named = module.overrides.iter();
        let named = named.filter(|(_, item)| item.name.is_some());
        named
            .map(|(_, item)| match item.id {
                Some(id) => id.to_string(),
                None => item.name.clone().unwrap_or_default(),
            })
            .collect()
    };
    assert_eq!(settable(&module), settable(&linked.module), "{text}");
    assert_eq!(structs(&module), structs(&linked.module), "{text}");
    (text, module)
}

fn read(text: &str) -> Module {
    let module =
        naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .unwrap_or_else(|error| panic!("{error:?}\n{text}"));
    module
}

/// Each struct's members, with offsets, and its size; a struct may have another name.
fn structs(module: &Module) -> BTreeSet<(Vec<(String, u32)>, u32)> {
    let structs = module.types.iter().filter_map(|(_, ty)| match &ty.inner {
        naga::TypeInner::Struct { members, span } => {
            let members = members.iter();
            let members =
                members.map(|member| (member.name.clone().unwrap_or_default(), member.offset));
            Some((members.collect(), *span))
        }
        _ => None,
    });
    structs.collect()
}

/// An override and a member of the same name, which ends in a digit.
#[test]
fn a_member_of_an_overrides_name() {
    let (text, _) = printed(&[(
        "main.wesl",
        "override K1: f32 = 1.0;\nstruct P { K1: f32 }\n@group(0) @binding(0) var<uniform> p: P;\n\
         @fragment fn fs() -> @location(0) vec4f { return vec4f(p.K1 * K1); }\n",
    )]);
    assert!(text.contains("override K1: f32 = 1f;"), "{text}");
    assert!(text.contains("    K1: f32,"), "{text}");
    assert!(text.contains("p.K1") && text.contains("* K1)"), "{text}");
}

/// Other declarations with a host's name are renamed, and nothing else is.
#[test]
fn what_else_may_have_a_hosts_name() {
    let own = "override K1: f32 = 1.0;\nfn helper() -> f32 { return K1; }\n\
         @fragment fn fs1() -> @location(0) vec4f { return vec4f(helper() + package::lib::helper()); }\n";
    let others = [
        "const K1 = 3.0f;\nfn helper() -> f32 { return K1; }\n",
        "fn K1() -> f32 { return 3.0; }\nfn helper() -> f32 { return K1(); }\n",
        "fn fs1() -> f32 { return 3.0; }\nfn helper() -> f32 { return fs1(); }\n",
        "var<private> K1: f32 = 3.0;\nfn helper() -> f32 { return K1; }\n",
        "struct K1 { K1: f32, fs1: f32 }\nfn helper() -> f32 { return K1(3.0, 1.0).K1; }\n",
        "fn part(K1: f32) -> f32 { return K1; }\nfn helper() -> f32 { let fs1 = part(3.0); var K1 = fs1; { let K1 = 4.0 * K1; return K1; } }\n",
        "alias K1 = f32;\nfn helper() -> f32 { return K1(3.0); }\n",
    ];
    for other in others {
        let (text, module) = printed(&[("main.wesl", own), ("lib.wesl", other)]);
        assert!(text.contains("override K1: f32 = 1f;"), "{text}");
        assert!(text.contains("fn fs1() -> @location(0)"), "{text}");
        assert_eq!(module.overrides.len(), 1);
    }
}

/// A name of WGSL's own may be an author's where no code uses WGSL's; members may have any name.
#[test]
fn names_that_wgsl_has_too() {
    let (text, _) = printed(&[(
        "main.wesl",
        "override position: f32 = 1.0;\nstruct P { f32: f32, fract: f32, min: vec3f, vertex: u32, @size(32) storage: f32 }\n\
         @group(0) @binding(0) var<uniform> uniform1: P;\n\
         fn saturate(x: f32) -> f32 { let clamp = x; return clamp + uniform1.f32 + uniform1.min.x; }\n\
         @vertex fn vertex() -> @builtin(position) vec4f { return vec4f(saturate(position)); }\n\
         @fragment fn fragment(@builtin(position) at: vec4f) -> @location(0) vec4f { return at * max(at, at); }\n",
    )]);
    for kept in [
        "override position: f32",
        "fn vertex() -> @builtin(position)",
        "fn fragment(@builtin(position) at: vec4<f32>)",
        "fn saturate(x: f32) -> f32",
        "let clamp = ",
        "var<uniform> uniform1: P;",
        "    f32: f32,",
        "    fract: f32,",
        "    min: vec3<f32>,",
        "    @size(32) storage: f32,",
    ] {
        assert!(
            text.contains(kept) || (kept == "let clamp = " && text.contains("return ((x +")),
            "no `{kept}` in\n{text}"
        );
    }
    // Where another module means WGSL's own, the author's word gives way.
    let (text, _) = printed(&[
        (
            "main.wesl",
            "import package::lib::most;\nfn max(a: f32) -> f32 { return a; }\n\
             @fragment fn fs() -> @location(0) vec4f { return vec4f(most(max(1.0))); }\n",
        ),
        (
            "lib.wesl",
            "fn most(a: f32) -> f32 { let vec4f = a; return max(vec4f, 2.0); }\n",
        ),
    ]);
    assert!(text.contains("fn max_1(a: f32)"), "{text}");
}

/// A host's name that cannot be kept is refused, by `check` as by what prints.
#[test]
fn a_hosts_name_that_wgsl_needs() {
    let error = link(&[
        (
            "main.wesl",
            "import package::lib::most;\noverride max: f32 = 1.0;\n\
             @fragment fn fs() -> @location(0) vec4f { return vec4f(most(max)); }\n",
        ),
        (
            "lib.wesl",
            "fn most(a: f32) -> f32 { return max(a, 2.0); }\n",
        ),
    ])
    .expect_err("one name has two meanings");
    let fault = &error.faults()[0];
    assert!(fault.message.contains("`max`"), "{error}");
    let place = fault
        .location()
        .unwrap_or_else(|| panic!("no place: {error}"));
    assert!(
        place.file.ends_with("main.wesl") && place.line == 2,
        "{error}"
    );
}

/// Names that naga's writer makes up, and others that it changes.
#[test]
fn names_of_nagas_making() {
    let (text, _) = printed(&[(
        "main.wesl",
        "override _e3: f32 = 1.0;\noverride x_1: f32 = 1.0;\noverride tail_: f32 = 1.0;\noverride a__b: f32 = 1.0;\n\
         override größe: f32 = 1.0;\noverride const_f32: f32 = 1.0;\noverride umbrage_0n: f32 = 1.0;\n\
         struct S { _e3: f32, größe: f32, x_1: f32, tail_: f32 }\n@group(0) @binding(0) var<uniform> s2: S;\n\
         fn x(x_1: f32) -> f32 { var x = x_1; x += s2._e3; let _e1 = x * s2.größe; let _e4 = _e1 + s2.x_1; x = _e4; return x + _e4 + s2.tail_; }\n\
         @fragment fn fs_1() -> @location(0) vec4f {\n    let y = x(_e3) + x(x_1) + x(größe);\n    return vec4f(y + tail_ + a__b + const_f32 + umbrage_0n);\n}\n",
    )]);
    for kept in [
        "override _e3: f32",
        "override x_1: f32",
        "override tail_: f32",
        "override a__b: f32",
        "override größe: f32",
        "override const_f32: f32",
        "override umbrage_0n: f32",
        "    größe: f32,",
        "    tail_: f32,",
        "var<uniform> s2: S;",
        "fn fs_1()",
    ] {
        assert!(text.contains(kept), "no `{kept}` in\n{text}");
    }
}

/// Overrides stay overrides, whatever is worked out from them.
#[test]
fn overrides_are_kept() {
    let (text, module) = printed(&[(
        "main.wesl",
        "@id(7) override A: f32 = 2.0;\noverride B: f32 = A * 2.0 + 1.0;\noverride N: u32 = 3u;\noverride on: bool = B > 4.0;\n\
         override none: i32;\noverride M = max(N, 2u) * 2u;\n\
         var<private> start: vec2f = vec2f(B, select(A, -A, on));\n\
         var<workgroup> tile: array<vec4f, N>;\nvar<workgroup> wide: array<array<f32, 4>, N * 2u + 1>;\nvar<workgroup> long: array<f32, N * 3u>;\n\
         @compute @workgroup_size(N, M + 1u, 2) fn cs1(@builtin(local_invocation_index) i: u32) {\n\
             tile[i % N] = vec4f(start, B, f32(none));\n    wide[i % (N * 2u + 1)][0] = tile[N - 1u].x + long[i % N];\n}\n",
    )]);
    for kept in [
        "@id(7) override A: f32 = 2f;",
        "override B: f32 = ((A * 2f) + 1f);",
        "override N: u32 = 3u;",
        "override on: bool = (B > 4f);",
        "override none: i32;",
        "override M: u32 = (max(N, 2u) * 2u);",
        "var<private> start: vec2<f32> = vec2<f32>(B, select(A, -(A), on));",
        "var<workgroup> tile: array<vec4<f32>, N>;",
        "var<workgroup> wide: array<array<f32, 4>, ((N * 2u) + 1u)>;",
        "var<workgroup> long: array<f32, (N * 3u)>;",
        "@compute @workgroup_size(N, (M + 1u), 2) ",
    ] {
        assert!(text.contains(kept), "no `{kept}` in\n{text}");
    }
    let values = |module: &Module| {
        let values = [("7", 3.0), ("none", 1.0), ("N", 5.0)];
        let constants = values.map(|(name, value)| (name.to_owned(), value));
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(module)
            .expect("valid");
        let (resolved, _) = naga::back::pipeline_constants::process_overrides(
            module,
            &info,
            None,
            &constants.into_iter().collect(),
        )
        .expect("resolved");
        resolved.entry_points[0].workgroup_size
    };
    // N = 5, so M = 10.
    assert_eq!(values(&module), [5, 11, 2]);
}

/// SPIR-V has arrays and workgroups at their overrides' defaults.
#[test]
fn overrides_at_their_defaults() {
    let shader = |length: &str| {
        format!(
            "override N: u32 = {length};\nvar<workgroup> wide: array<f32, N * 2u>;\noverride M: u32 = N + 1u;\n\
             var<workgroup> tile: array<f32, N>;\noverride L: u32 = M * 2u;\nvar<workgroup> long: array<f32, L - M>;\n\
             @compute @workgroup_size(N, M) fn cs(@builtin(local_invocation_index) i: u32) {{ wide[i] = f32(L); tile[i] = wide[i]; long[i] = 1.0; }}\n"
        )
    };
    let (_, module) = printed(&[("main.wesl", &shader("4u"))]);
    assert_eq!(module.overrides.len(), 5, "two lengths have no name");
    let linked = link(&[("main.wesl", &shader("4u"))]).unwrap_or_else(|error| panic!("{error}"));
    let spirv = linked.spirv().unwrap_or_else(|error| panic!("{error}"));
    // Instructions: the length in words and the operation, then the operands.
    let mut instructions = Vec::new();
    let mut rest = &spirv[5..];
    while let Some(first) = rest.first() {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        instructions.push((first & 0xffff, &instruction[1..]));
        rest = after;
    }
    let of = |op: u32| instructions.iter().filter(move |(other, _)| *other == op);
    // OpExecutionMode … LocalSize.
    let sizes: Vec<_> = of(16).map(|(_, operands)| &operands[1..]).collect();
    assert_eq!(sizes, [&[17, 4, 5, 1]]);
    // OpTypeArray, whose length is an OpConstant.
    let lengths = of(28).map(|(_, array)| {
        let mut constants = of(43);
        constants
            .find(|(_, constant)| constant[1] == array[2])
            .map(|(_, constant)| constant[2])
    });
    let lengths: BTreeSet<_> = lengths.collect::<Option<_>>().expect("constants");
    assert_eq!(lengths, [4, 5, 8].into());
    // A default that will not do is told before anything is printed.
    let error = link(&[("main.wesl", &shader("0u"))]).expect_err("a size of 0");
    let place = error.faults()[0].location().expect("a place");
    assert!(place.file.ends_with("main.wesl"), "{error}");
}

/// Results of `modf` and `frexp` have a type without a name.
#[test]
fn variables_of_nameless_types() {
    let (text, _) = printed(&[(
        "main.wesl",
        "@fragment fn fs(@location(0) x: vec3f) -> @location(0) vec4f {\n    var parts = modf(x.x);\n    var fract = frexp(x);\n    let whole = modf(x);\n\
         if x.y > 0.0 { parts = modf(x.y); fract.fract.x = parts.whole; }\n    return vec4f(fract.fract, parts.fract + whole.whole.x + f32(fract.exp.x));\n}\n",
    )]);
    assert!(text.contains("var parts = modf(f32());"), "{text}");
    assert!(text.contains("var fract = frexp(vec3<f32>());"), "{text}");
    let shader = |kind: &str| {
        format!(
            "@group(0) @binding(0) var<storage, read_write> a: atomic<u32>;\n@compute @workgroup_size(1) fn cs() {{ {kind} r = atomicCompareExchangeWeak(&a, 1u, 2u); if r.exchanged {{ atomicStore(&a, r.old_value); }} }}\n"
        )
    };
    printed(&[("main.wesl", &shader("let"))]);
    let error = link(&[("main.wesl", &shader("var"))]).expect_err("no word for it");
    assert!(error.to_string().contains("use `let`"), "{error}");
    let place = error.faults()[0].location().expect("a place");
    assert!(
        place.file.ends_with("main.wesl") && place.line == 2,
        "{error}"
    );
}

/// The reflection lists what a host may set.
#[test]
fn overrides_are_reflected() {
    let linked = link(&[
        (
            "main.wesl",
            "import package::lib::scaled;\n@id(7) override A: f32 = 2.5;\noverride none: i32;\noverride lost: i32 = none + 1;\n\
             override N: u32 = 3u;\noverride on: bool = N > 2u;\n\
             @compute @workgroup_size(N * 2u, 4) fn cs() { _ = scaled(A) + f32(lost); _ = on; }\n",
        ),
        ("lib.wesl", "override SCALE = 2.0 * 3.0;\noverride TWICE: f32 = SCALE * 2.0;\nfn scaled(a: f32) -> f32 { return a * TWICE; }\n"),
    ])
    .unwrap_or_else(|error| panic!("{error}"));
    let found: Vec<_> = linked
        .reflection
        .overrides
        .iter()
        .map(|item| {
            let module = item.module.rsplit("::").next().unwrap_or("");
            (
                item.name.as_str(),
                item.id,
                item.ty,
                item.default,
                item.derived,
                module,
            )
        })
        .collect();
    use OverrideType::*;
    assert_eq!(
        found,
        [
            ("A", Some(7), F32, Some(2.5), false, "main"),
            ("N", None, U32, Some(3.0), false, "main"),
            ("SCALE", None, F32, Some(6.0), false, "lib"),
            ("TWICE", None, F32, Some(12.0), true, "lib"),
            ("lost", None, I32, None, true, "main"),
            ("none", None, I32, None, false, "main"),
            ("on", None, Bool, Some(1.0), true, "main"),
        ]
    );
    assert_eq!(linked.reflection.entry_points[0].workgroup_size, [6, 4, 1]);
    let spirv: Vec<_> = linked
        .reflection
        .overrides
        .iter()
        .map(|o| o.spirv)
        .collect();
    assert_eq!(spirv[0], InSpirv::FixedAtDefault);
    assert_eq!(spirv[5], InSpirv::NotWritten);
    let error = linked.spirv().expect_err("an override has no default");
    assert!(error.to_string().contains("`none`"), "{error}");
}

/// Bindings and members are printed as the reflection tells.
#[test]
fn the_reflection_and_the_text_agree() {
    let files = [
        (
            "main.wesl",
            "import package::lib::look;\nstruct Tint { rgb1: vec3f, @align(32) fade_: f32 }\n\
             @group(2) @binding(0) var<uniform> tint2: Tint;\n@group(2) @binding(1) var map_0: texture_2d<f32>;\n\
             @fragment fn fs1() -> @location(0) vec4f { return vec4f(look(), 1.0) * tint2.fade_ + textureLoad(map_0, vec2i(), 0); }\n",
        ),
        (
            "lib.wesl",
            "struct Look { rgb1: vec3f, 強さ: f32 }\n@group(2) @binding(0) var<uniform> look3: Look;\nfn look() -> vec3f { let map_0 = look3.rgb1; return map_0 * look3.強さ; }\n",
        ),
    ];
    let linked = link(&files).unwrap_or_else(|error| panic!("{error}"));
    let (text, module) = printed(&files);
    assert_eq!(linked.reflection.bindings.len(), 3);
    for binding in &linked.reflection.bindings {
        let mut variables = module.global_variables.iter().map(|(_, variable)| variable);
        let variable = variables
            .find(|variable| variable.name.as_ref() == Some(&binding.name))
            .unwrap_or_else(|| panic!("no {} in\n{text}", binding.name));
        let at = variable.binding.as_ref().expect("a binding");
        assert_eq!((at.group, at.binding), (binding.group, binding.binding));
        let BindingKind::Uniform(layout) = &binding.kind else {
            continue;
        };
        let naga::TypeInner::Struct { members, span } = &module.types[variable.ty].inner else {
            panic!("no struct");
        };
        assert_eq!(layout.size, *span);
        let printed = members.iter().map(|m| (m.name.as_deref(), m.offset));
        let told = layout
            .members
            .iter()
            .map(|m| (Some(m.name.as_str()), m.offset));
        assert!(printed.eq(told), "{text}");
    }
}

/// Composes the pass `main` of a package.
fn compose(files: &[(&str, &str)]) -> Result<(), Error> {
    let axes = r#"(axes: { "pass": (values: { "main": (root: "package::main") }) })"#;
    let mut all = vec![("axes.ron".to_owned(), axes.to_owned())];
    all.extend(
        files
            .iter()
            .map(|(path, text)| ((*path).to_owned(), (*text).to_owned())),
    );
    let library = Library::new([Package::from_sources("demo", "demo", all)?])?;
    let key = library.key([("pass", "main")])?;
    let composed = Composer::new(library, Target::webgpu()).compose(&key)?;
    read(&composed.permutation.wgsl()?);
    Ok(())
}

/// Two overrides that a host cannot tell apart are a fault, with both places.
#[test]
fn overrides_that_a_host_cannot_tell_apart() {
    let main = "import package::a::of_a;\nimport package::b::of_b;\n@fragment fn fs2() -> @location(0) vec4f { return vec4f(of_a() + of_b()); }\n";
    let module =
        |text: &str, name: &str| format!("{text}\nfn of_{name}() -> f32 {{ return f32(S); }}\n");
    let clash = |a: &str, b: &str| {
        let error = compose(&[
            ("main.wesl", main),
            ("a.wesl", &module(a, "a")),
            ("b.wesl", &module(b, "b")),
        ]);
        let error = error.expect_err("a clash");
        let files: Vec<_> = error.faults()[0]
            .locations
            .iter()
            .map(|at| (at.file.as_str(), at.line))
            .collect();
        assert_eq!(files, [("demo/b.wesl", 1), ("demo/a.wesl", 1)], "{error}");
        error.to_string()
    };
    let text = clash("override S: f32 = 1.0;", "override S: f32 = 2.0;");
    assert!(
        text.contains("`demo::a` and `demo::b` both have an override `S`"),
        "{text}"
    );
    clash("override S: f32 = 1.0;", "override S: u32 = 2u;");
    let text = clash(
        "@id(4) override S: f32 = 1.0;",
        "const FOUR = 4;\n@id(FOUR) override S: f32 = 2.0;"
            .replace('\n', " ")
            .as_str(),
    );
    assert!(text.contains("`@id(4)`"), "{text}");
    // One declaration reached twice is one; so are two with numbers of their own, or one with and one without.
    let shared = ("c.wesl", "override S: f32 = 1.0;\n");
    let import = "import package::c::S;";
    compose(&[
        ("main.wesl", main),
        shared,
        ("a.wesl", &module(import, "a")),
        ("b.wesl", &module(import, "b")),
    ])
    .expect("one");
    compose(&[
        ("main.wesl", main),
        shared,
        (
            "a.wesl",
            &module("import package::c::S as T; const S = 1;", "a"),
        ),
        ("b.wesl", &module("import package::c::S;", "b")),
    ])
    .expect("one");
    compose(&[
        ("main.wesl", main),
        ("a.wesl", &module("@id(1) override S: f32;", "a")),
        ("b.wesl", &module("@id(2) override S: f32;", "b")),
    ])
    .expect("two numbers");
    compose(&[
        ("main.wesl", main),
        ("a.wesl", &module("@id(1) override S: f32;", "a")),
        ("b.wesl", &module("override S: f32;", "b")),
    ])
    .expect("a number and a name");
    // Declarations that nothing reaches clash with nothing.
    compose(&[
        ("main.wesl", main),
        ("a.wesl", &module("override S: f32;", "a")),
        (
            "b.wesl",
            "override S: f32;\nfn of_b() -> f32 { return 1.0; }\n",
        ),
    ])
    .expect("one is unused");
}

#[test]
fn two_overrides_of_one_number_in_a_module() {
    let error = compose(&[(
        "main.wesl",
        "@id(3) override a: f32 = 1.0;\n@id(1 + 2) override b: f32 = 1.0;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(a + b); }\n",
    )])
    .expect_err("a clash");
    let fault = &error.faults()[0];
    assert!(
        fault
            .message
            .contains("`demo::main` has two overrides `@id(3)`"),
        "{error}"
    );
    let lines: Vec<_> = fault.locations.iter().map(|at| at.line).collect();
    assert_eq!(lines, [2, 1], "{error}");
}

#[test]
fn an_override_of_an_entry_points_name() {
    let error = compose(&[
        ("main.wesl", "import package::a::of_a;\n@fragment fn fs2() -> @location(0) vec4f { return vec4f(of_a()); }\n"),
        ("a.wesl", "override fs2: f32 = 1.0;\nfn of_a() -> f32 { return fs2; }\n"),
    ])
    .expect_err("a clash");
    let places: Vec<_> = error.faults()[0]
        .locations
        .iter()
        .map(|at| (at.file.as_str(), at.line))
        .collect();
    assert_eq!(
        places,
        [("demo/a.wesl", 1), ("demo/main.wesl", 2)],
        "{error}"
    );
}

fn name() -> impl Strategy<Value = String> {
    // Few, so that many are equal; what naga changes, what it makes up, what WGSL has, and what is beyond ASCII.
    let names = [
        "a",
        "a1",
        "a_1",
        "a_1_1",
        "a1_",
        "a_",
        "b__c",
        "_e1",
        "_e2",
        "_e3",
        "K1",
        "fs2",
        "é",
        "é1",
        "名前",
        "unnamed",
        "type_1",
        "const_f32",
        "min",
        "vertex",
        "position",
        "storage",
        "read",
        "local",
        "param",
        "umbrage_1n",
        "umbrage_12n",
        "_naga_a",
    ];
    prop::sample::select(names.to_vec()).prop_map(str::to_owned)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Names do not change what the printed text means: naga finds the linked hosts' names, members and layouts in it,
    /// and prints the same text from it again.
    #[test]
    fn any_names(
        entry in name(), set in name(), numbered in name(), bound in name(), members in prop::collection::btree_set(name(), 3),
        constant in name(), variable in name(), function in name(), record in name(), parameter in name(),
        local in name(), inner in name(), other in prop::collection::vec(name(), 6),
    ) {
        let own = [&entry, &set, &numbered, &bound, &constant, &variable, &function, &record];
        prop_assume!(own.iter().collect::<BTreeSet<_>>().len() == own.len());
        let [m0, m1, m2] = members.iter().collect::<Vec<_>>()[..] else { unreachable!("three members") };
        let theirs: BTreeSet<_> = other[..4].iter().collect();
        prop_assume!(theirs.len() == 4 && !theirs.contains(&entry) && !theirs.contains(&set));
        let [o0, o1, o2, o3, o4, o5] = &other[..] else { unreachable!("six names") };
        let lib = format!(
            "struct {o0} {{ {m0}: f32, @size(16) {m1}: f32 }}\nvar<private> {o1}: f32 = 2.0;\nconst {o2}: f32 = 3.0;\n\
             fn {o3}({o4}: f32) -> f32 {{ var thing: {o0}; thing.{m1} = {o4}; let {o5} = {o4} + thing.{m0}; return {o5} * thing.{m1}; }}\n\
             fn entrance(x: f32) -> f32 {{ {o1} += {o2}; return {o3}(x) + {o1}; }}\n"
        );
        let main = format!(
            "override {set}: f32 = 1.0;\n@id(5) override {numbered}: u32 = 2u;\n\
             struct {record} {{ {m0}: f32, {m1}: vec3f, @align(64) {m2}: f32 }}\n\
             @group(0) @binding(0) var<uniform> {bound}: {record};\nvar<private> {variable}: f32 = 5.0;\nconst {constant}: f32 = 4.0;\n\
             fn {function}() -> f32 {{ {variable} = {variable} * {bound}.{m0} + {constant}; return {variable} + f32({numbered}) + {bound}.{m1}.x; }}\n\
             fn work(parameter: f32) -> f32 {{ return parameter * 2.0; }}\n\
             @fragment fn {entry}() -> @location(0) vec4f {{ return vec4f({function}() * {set} + work({bound}.{m2}) + package::lib::entrance({set}) + apart::inner(1.0)); }}\n"
        );
        let apart = format!(
            "fn inner({parameter}: f32) -> f32 {{ var {local} = {parameter_value}; {local} += 1.0; if {local} > 2.0 {{ let {inner} = {local} * 3.0; return {inner} + cos(sin({inner})); }} return {local}; }}\n",
            parameter_value = if parameter == local { "1.0" } else { parameter.as_str() },
            local = if parameter == local { format!("{local}x") } else { local.clone() },
        );
        let main = format!("import package::apart;\n{main}");
        let files = [("main.wesl", main.as_str()), ("lib.wesl", lib.as_str()), ("apart.wesl", apart.as_str())];
        // Modules that naga itself refuses have nothing to do with names.
        let Ok(linked) = link(&files) else { return Err(TestCaseError::reject("refused")) };
        let Ok(_) = linked.wgsl() else { return Err(TestCaseError::reject("a host's name that WGSL needs")) };
        let (text, _) = printed(&files);
        prop_assert!(text.contains(&format!("fn {entry}() -> @location(0)")), "{}", text);
        let again = printed(&[("main.wesl", &text)]).0;
        prop_assert_eq!(again.lines().count(), text.lines().count());
        prop_assert!(again.contains(&format!("fn {entry}() -> @location(0)")), "{}", again);
    }
}
