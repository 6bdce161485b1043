//! Constants of other modules in attributes and array lengths, held against naga's reading of the same text in one
//! module, and against the `wesl` crate.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{borrow::Cow, collections::BTreeSet, fs};

use naga::{Binding, Module, TypeInner, valid::Capabilities};
use umbrage_compose::{Permutation, Target, link_file};
use wesl::{ManglerKind, ModulePath, VirtualResolver, Wesl};

fn link(files: &[(&str, &str)], features: &[&str]) -> Permutation {
    let dir = tempfile::tempdir().expect("a folder");
    for (path, text) in files {
        let path = dir.path().join(path);
        fs::create_dir_all(path.parent().expect("a file lies in a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    let features: Vec<_> = features.iter().map(|name| (*name).to_owned()).collect();
    let main = dir.path().join("main.wesl");
    let target = Target::new("all", Capabilities::all());
    let linked = link_file(&main, None, &features, &[], target);
    linked.unwrap_or_else(|error| panic!("{error}"))
}

fn parse(text: &str) -> Module {
    naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A member's name, offset and place between stages.
type Member = (String, u32, String);

/// Each struct's members with their offsets and places between stages, and its size.
fn structs(module: &Module) -> BTreeSet<(Vec<Member>, u32)> {
    let structs = module.types.iter().filter_map(|(_, ty)| match &ty.inner {
        TypeInner::Struct { members, span } => {
            let members = members.iter().map(|member| {
                let name = member.name.clone().unwrap_or_default();
                (name, member.offset, format!("{:?}", member.binding))
            });
            Some((members.collect(), *span))
        }
        _ => None,
    });
    structs.collect()
}

/// Output of the `wesl` crate for `files`, with `kept` and everything that `kept` reaches.
fn theirs(files: &[(&str, &str)], features: &[&str], kept: &str) -> String {
    let mut resolver = VirtualResolver::new();
    for (path, text) in files {
        let path = format!("/{}", path.trim_end_matches(".wesl"));
        resolver.add_module(ModulePath::from_path(path), Cow::Borrowed(*text));
    }
    let mut compiler = Wesl::new_barebones().set_custom_resolver(resolver);
    compiler
        .use_imports(true)
        .use_condcomp(true)
        .use_stripping(true);
    compiler.set_mangler(ManglerKind::Escape);
    compiler.keep_declarations(vec![kept.to_owned()]);
    compiler.set_features(features.iter().map(|name| (name, true)));
    let linked = compiler.compile(&ModulePath::from_path("/main"));
    linked.unwrap_or_else(|error| panic!("{error}")).to_string()
}

const K: &str = "const PAD = 32;\nconst N = 2u;\nconst M = N * 8;\nconst LOC = 3;\n@if(WIDE) const STEP = 64; @else const STEP = 16;\n";

/// Structs of other modules lie as they would in one.
#[test]
fn layouts() {
    let flat_k =
        "const PAD = 32;\nconst N = 2u;\nconst M = N * 8;\nconst LOC = 3;\nconst STEP = 16;\n";
    let l = "import package::k::{PAD, N as COUNT};\nimport package::k;\n\
        struct L { a: f32, @align(PAD) c: vec3f, @size(COUNT * 16) d: f32, @align(package::k::M) @size(package::k::M * 2 + 4) e: u32, f: array<vec4f, COUNT * 2>, @align(package::k::STEP) g: Inner }\n\
        struct Inner { @size(PAD) a: f32, b: array<f32, package::k::M> }\n\
        fn make() -> L { return L(); }\nfn take(l: L) -> f32 { return l.d; }\n";
    let flat_l = "struct L { a: f32, @align(PAD) c: vec3f, @size(N * 16) d: f32, @align(M) @size(M * 2 + 4) e: u32, f: array<vec4f, N * 2>, @align(STEP) g: Inner }\n\
        struct Inner { @size(PAD) a: f32, b: array<f32, M> }\n";
    let flat = parse(&format!("{flat_k}{flat_l}"));
    let mains = [
        // Imported, by a path in code, by an alias of another module, only by functions' types, and within its own.
        "import package::l::L;\n@group(0) @binding(0) var<storage> ls: array<L>;\nfn probe() -> f32 { return ls[0].d; }\n",
        "@group(0) @binding(0) var<storage> ls: array<package::l::L>;\nfn probe() -> f32 { return ls[0].d; }\n",
        "import package::again::Again;\nvar<private> l: Again;\nfn probe() -> f32 { return l.d; }\n",
        "import package::l::{make, take};\nfn probe() -> f32 { return take(make()); }\n",
        "import package::again::through;\nfn probe() -> f32 { return through().d; }\n",
    ];
    let again = "import package::l::{L, make};\nalias Again = L;\nfn through() -> Again { return make(); }\n";
    for main in mains {
        let files = [
            ("main.wesl", main),
            ("k.wesl", K),
            ("l.wesl", l),
            ("again.wesl", again),
        ];
        let linked = link(&files, &[]);
        assert_eq!(structs(&linked.module), structs(&flat), "{main}");
        let text = linked.wgsl().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(structs(&parse(&text)), structs(&flat), "{text}");
        // Version 0.4 of the `wesl` crate cannot import a module.
        let l = l.replace("import package::k;\n", "");
        let files = [
            ("main.wesl", main),
            ("k.wesl", K),
            ("l.wesl", &l),
            ("again.wesl", again),
        ];
        assert_eq!(
            structs(&parse(&theirs(&files, &[], "probe"))),
            structs(&flat),
            "{main}"
        );
    }
    // With what a feature gives, and what it takes away.
    let l = "import package::k::STEP;\nstruct L { a: f32, @if(WIDE) @align(STEP) b: f32, @if(!WIDE) @size(STEP) b: f32, @if(FAR) @size(package::k::FAR) c: f32, d: f32 }\n";
    let main = mains[0];
    let files = [("main.wesl", main), ("k.wesl", K), ("l.wesl", l)];
    let wide = "struct L { a: f32, @align(64) b: f32, d: f32 }";
    let narrow = "struct L { a: f32, @size(16) b: f32, d: f32 }";
    for (features, flat) in [(&["WIDE"][..], wide), (&[], narrow)] {
        let linked = link(&files, features);
        assert_eq!(structs(&linked.module), structs(&parse(flat)));
        assert_eq!(
            structs(&parse(&theirs(&files, features, "probe"))),
            structs(&parse(flat))
        );
    }
}

/// Places between stages, sizes of workgroups, numbers of overrides and bindings.
#[test]
fn places_and_numbers() {
    let io = "import package::k::{LOC, N};\nenable dual_source_blending;\n\
        struct Varyings { @builtin(position) clip: vec4f, @location(LOC) @interpolate(flat) a: u32, @location(package::k::LOC + 1) b: vec2f }\n\
        struct Blend { @location(package::k::N - 2) @blend_src(N - 2) first: vec4f, @location(0) @blend_src(N - 1) second: vec4f }\n\
        @id(N * 2) override SCALE: f32 = 1.0;\n@id(package::k::M) override TWICE: f32 = SCALE * 2.0;\n\
        @group(N) @binding(LOC + 1) var<uniform> tint: vec4f;\n\
        fn look() -> vec4f { return tint * TWICE; }\n";
    let main = "import package::io::{Varyings, Blend, look};\nimport package::k::{N, LOC as PLACE};\nenable dual_source_blending;\n\
        @vertex fn vs(@location(PLACE * 2) at: vec4f, @location(package::k::N) c: vec4f) -> Varyings { return Varyings(at, 1u, c.xy); }\n\
        @fragment fn fs(v: Varyings) -> Blend { return Blend(look(), vec4f(v.b, 0.0, 1.0)); }\n\
        @fragment fn one(@location(PLACE) @interpolate(flat) a: u32) -> @location(N - 1) vec4f { return vec4f(f32(a)); }\n\
        @compute @workgroup_size(package::k::M, N, PLACE - N) fn cs() {}\n";
    let linked = link(&[("main.wesl", main), ("k.wesl", K), ("io.wesl", io)], &[]);
    let module = &linked.module;
    let entry = |name: &str| {
        let mut entries = module.entry_points.iter();
        entries
            .find(|e| e.name == name)
            .unwrap_or_else(|| panic!("no {name}"))
    };
    let location = |binding: &Option<Binding>| match binding {
        Some(Binding::Location {
            location,
            blend_src,
            ..
        }) => (*location, *blend_src),
        other => panic!("no location: {other:?}"),
    };
    let arguments = &entry("vs").function.arguments;
    assert_eq!(location(&arguments[0].binding), (6, None));
    assert_eq!(location(&arguments[1].binding), (2, None));
    let result = entry("one").function.result.as_ref().expect("a result");
    assert_eq!(location(&result.binding), (1, None));
    assert_eq!(entry("cs").workgroup_size, [16, 2, 1]);
    let members = |function: &str| {
        let result = entry(function).function.result.as_ref().expect("a result");
        match &module.types[result.ty].inner {
            TypeInner::Struct { members, .. } => members.clone(),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(location(&members("vs")[1].binding), (3, None));
    assert_eq!(location(&members("vs")[2].binding), (4, None));
    assert_eq!(location(&members("fs")[0].binding), (0, Some(0)));
    assert_eq!(location(&members("fs")[1].binding), (0, Some(1)));
    let ids: Vec<_> = module.overrides.iter().filter_map(|(_, o)| o.id).collect();
    assert_eq!(ids, [4, 16]);
    let bound = &linked.reflection.bindings[0];
    assert_eq!((bound.group, bound.binding), (2, 4));
    let text = linked.wgsl().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(structs(&parse(&text)), structs(module), "{text}");
}

/// Faults in an attribute are told at their place.
#[test]
fn a_fault_in_an_attribute() {
    let dir = tempfile::tempdir().expect("a folder");
    fs::write(
        dir.path().join("main.wesl"),
        "import package::l::L;\nvar<private> l: L;\n",
    )
    .expect("a file");
    fs::write(
        dir.path().join("l.wesl"),
        "const PAD = 32;\nstruct L { @align(PADD) c: vec3f }\n",
    )
    .expect("a file");
    let error = link_file(
        &dir.path().join("main.wesl"),
        None,
        &[],
        &[],
        Target::webgpu(),
    );
    let error = error.expect_err("no such constant");
    let place = error.faults()[0].location().expect("a place");
    assert!(
        place.file.ends_with("l.wesl") && place.line == 2 && place.column == 19,
        "{error}"
    );
}
