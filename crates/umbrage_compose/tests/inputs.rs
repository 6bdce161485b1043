//! Packages and files as people have them: names, encodings, imports that lead nowhere.

use std::{fs, path::Path};

use tempfile::TempDir;
use umbrage_compose::{Composer, Error, Library, Manifest, Package, Target, link_file};

const AXES: &str = r#"(axes: { "pass": (values: { "main": (root: "package::main") }) })"#;

const SOUND: &str = "@fragment fn fs() -> @location(0) vec4f { return vec4f(1.0); }\n";

/// A folder with `files`, as paths and contents.
fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    for (path, text) in files {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    folder
}

fn compose(package: Package) -> Result<(), Error> {
    let library = Library::new([package])?;
    let key = library.key([("pass", "main")])?;
    Composer::new(library, Target::webgpu())
        .compose(&key)
        .map(drop)
}

fn compose_in(dir: &Path) -> Result<(), Error> {
    compose(Package::load("demo", dir)?)
}

fn compose_texts(files: &[(&str, &str)]) -> Result<(), Error> {
    let files = files.iter().chain([&("axes.ron", AXES)]);
    let files = files.map(|(path, text)| ((*path).to_owned(), (*text).to_owned()));
    compose(Package::from_sources("demo", "demo", files)?)
}

fn link(file: &Path) -> Result<String, Error> {
    link_file(file, None, &[], &[], Target::webgpu())?.wgsl()
}

#[test]
fn a_package_has_a_name_that_paths_can_begin_with() {
    for name in [
        "", "3d", "a b", "a::b", "a.b", "-", "__a", "package", "super", "self", "import", "as",
        "ä/b",
    ] {
        let error = Package::from_sources(name, "demo", [("", ""); 0]).expect_err(name);
        let said = error.to_string();
        assert!(
            said.contains("cannot be the name of a package"),
            "{name:?}: {said}"
        );
        let files = folder(&[
            ("pkg/axes.ron", AXES.as_bytes()),
            ("pkg/main.wesl", SOUND.as_bytes()),
        ]);
        let manifest = files.path().join("all.ron");
        let text = format!(r#"(packages: {{ {name:?}: "pkg" }}, keys: [{{ "pass": All }}])"#);
        fs::write(&manifest, text).expect("a file");
        let error = Manifest::load(&manifest).expect_err(name);
        let at = error.faults()[0].location().expect("a place");
        assert!(at.file.ends_with("all.ron"), "{name:?}: {error}");
        assert_eq!((at.line, at.column), (1, 14), "{name:?}: {error}");
    }
    for name in ["a", "my_lib", "fn", "common", "größe", "a1"] {
        assert!(
            Package::from_sources(name, "demo", [("", ""); 0]).is_ok(),
            "{name}"
        );
    }
}

#[test]
fn a_hyphen_counts_as_an_underscore() {
    let axes = AXES.replace("package::", "app::");
    let main =
        "import my_lib::a::tint;\n@fragment fn fs() -> @location(0) vec4f { return tint(); }\n";
    let lib = "fn tint() -> vec4f { return vec4f(0.5); }\n";
    for manifest in [
        r#"(packages: { "app": "app", "my-lib": "lib" }, keys: [{ "pass": All }])"#,
        r#"(packages: { "app": "app" }, keys: [{ "pass": All }])"#,
    ] {
        let files = folder(&[
            ("app/wesl.toml", b"edition = \"2026_pre\"\nroot = \".\"\n[dependencies]\nmy-lib = { path = \"../lib\" }\n"),
            ("app/axes.ron", axes.as_bytes()),
            ("app/main.wesl", main.as_bytes()),
            ("lib/a.wesl", lib.as_bytes()),
            ("all.ron", manifest.as_bytes()),
        ]);
        let manifest = Manifest::load(&files.path().join("all.ron")).expect("a manifest");
        let composer = Composer::new(manifest.library().clone(), Target::webgpu());
        let variant = composer
            .select(manifest.selection())
            .next()
            .expect("a permutation");
        composer.compose(&variant.key()).expect("composed");
    }
    let files = folder(&[
        ("wesl.toml", b"edition = \"2026_pre\"\nroot = \".\"\n[dependencies]\n\"3d\" = { path = \"../lib\" }\n"),
        ("main.wesl", SOUND.as_bytes()),
    ]);
    let error = Package::load("app", files.path()).expect_err("3d");
    let at = error.faults()[0].location().expect("a place");
    assert!(at.file.ends_with("wesl.toml") && at.line == 4, "{error}");
}

#[test]
fn a_linked_file_may_lie_in_any_folder_and_have_any_name() {
    let main = "import package::lib::a::tint;\n@fragment fn fs() -> @location(0) vec4f { return tint(); }\n";
    for dir in ["3d", "my-lib", "a b", "fn", "package", "__x", "ä.ö", "self"] {
        for name in [
            "main.wesl",
            "3d.wesl",
            "my-module.wgsl",
            "a.b.wesl",
            "fn.wesl",
            "import.wesl",
            "ü b.wesl",
        ] {
            let files = folder(&[
                (&format!("{dir}/{name}"), main.as_bytes()),
                (
                    &format!("{dir}/lib/a.wesl"),
                    b"fn tint() -> vec4f { return vec4f(0.5); }\n",
                ),
            ]);
            let linked = link(&files.path().join(dir).join(name));
            let text = linked.unwrap_or_else(|error| panic!("{dir}/{name}: {error}"));
            assert!(
                naga::front::wgsl::parse_str(&text).is_ok(),
                "{dir}/{name}: {text}"
            );
        }
    }
}

#[test]
fn two_files_of_one_module_are_refused() {
    let files = folder(&[
        ("axes.ron", AXES.as_bytes()),
        ("main.wesl", SOUND.as_bytes()),
        ("util.wesl", b"const A = 1;\n"),
        ("util.wgsl", b"const A = 2;\n"),
    ]);
    let said = compose_in(files.path()).expect_err("two files").to_string();
    let (wesl, wgsl) = (said.find("util.wesl"), said.find("util.wgsl"));
    assert!(wesl.is_some() && wesl < wgsl, "{said}");
    let texts = [("main.wesl", SOUND), ("util.wgsl", ""), ("util.wesl", "")];
    let said = compose_texts(&texts).expect_err("two files").to_string();
    assert!(
        said.contains("`demo/util.wesl` and `demo/util.wgsl`"),
        "{said}"
    );
    // Names that differ in case are two modules, and a folder is none.
    let main = "import package::util::A;\nimport package::Util::B;\nimport package::util::c::C;\n\
                @fragment fn fs() -> @location(0) vec4f { return vec4f(A, B, C, 1.0); }\n";
    compose_texts(&[
        ("main.wesl", main),
        ("util.wesl", "const A = 1.0;\n"),
        ("Util.wesl", "const B = 1.0;\n"),
        ("util/c.wesl", "const C = 1.0;\n"),
    ])
    .expect("two modules");
}

#[test]
fn a_file_that_cannot_be_read_stops_those_that_need_it() {
    let uses =
        "import package::bad::f;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(f()); }\n";
    let unused =
        "import package::bad::f;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(1.0); }\n";
    let bad: &[(&[u8], &str)] = &[
        (
            b"// a\n// \xff\nfn f() -> f32 { return 1.0; }\n",
            "bad.wesl:2:4",
        ),
        (b"\xff\xfef\0n\0", "UTF-16"),
        (b"fn f() -> f32 { return 1.0; } // \xe2\x82", "offset 33"),
    ];
    for (bytes, part) in bad {
        let files = |main: &str| {
            folder(&[
                ("axes.ron", AXES.as_bytes()),
                ("main.wesl", main.as_bytes()),
                ("bad.wesl", bytes),
            ])
        };
        for sound in [SOUND, unused] {
            compose_in(files(sound).path()).expect("it is not needed");
        }
        let said = compose_in(files(uses).path())
            .expect_err("it is needed")
            .to_string();
        assert!(said.contains("not UTF-8") && said.contains(part), "{said}");
        assert!(said.contains("bad.wesl:"), "{said}");
    }
    // A byte in a file that is needed anyhow.
    let files = folder(&[
        ("axes.ron", b"(axes: {\n  \xff })"),
        ("main.wesl", SOUND.as_bytes()),
    ]);
    let said = compose_in(files.path()).expect_err("axes").to_string();
    assert!(said.contains("axes.ron:2:3"), "{said}");
}

#[test]
fn an_import_that_leads_nowhere_is_a_fault_where_it_is_used() {
    let other = "fn tint() -> vec4f { return vec4f(0.5); }\n";
    let broken = "fn tint( -> vec4f {\n";
    for (import, name) in [
        ("nowhere::a::tint", "nowhere"),
        ("package::nowhere::tint", "nowhere"),
        ("package::other::tnt as tint", "tnt"),
        ("super::super::super::a::tint", "super"),
        ("{nowhere::tint}", "nowhere"),
        ("package::broken::tint", "broken.wesl"),
    ] {
        let compose = |body: &str| {
            let main = format!(
                "// x\nimport {import};\n@fragment fn fs() -> @location(0) vec4f {{ {body} }}\n"
            );
            compose_texts(&[
                ("main.wesl", &main),
                ("other.wesl", other),
                ("broken.wesl", broken),
            ])
        };
        compose("return vec4f();").expect(import);
        // The name may be someone else's where it stands.
        compose("let tint = vec4f(); return tint;").expect(import);
        compose("let v = vec4f(); return v.xyzw; /* tint() */").expect(import);
        for body in [
            "return tint();",
            "let a = tint; return a;",
            "var a: tint; return vec4f();",
        ] {
            let error = compose(body).expect_err(import);
            let fault = &error.faults()[0];
            let at = fault.location().expect("a place");
            assert!(fault.to_string().contains(name), "{import}: {fault}");
            let expected = if name == "broken.wesl" { 1 } else { 2 };
            assert_eq!(at.line, expected, "{import}: {fault}");
            assert!(
                fault.locations.iter().any(|at| at.line == 3),
                "{import}: {fault}"
            );
        }
    }
    // A module that leads nowhere, used in a path, and in a declaration that others take.
    let main =
        "import nowhere::a;\n@fragment fn fs() -> @location(0) vec4f { return a::tint(); }\n";
    let said = compose_texts(&[("main.wesl", main)])
        .expect_err("used")
        .to_string();
    assert!(
        said.contains("no package `nowhere`") && said.contains("main.wesl:1:8"),
        "{said}"
    );
    let main = "import package::other::S;\n@fragment fn fs() -> @location(0) vec4f { var s: S; return vec4f(s.a); }\n";
    let other = "import nowhere::T;\nstruct S { a: f32, b: T }\n";
    let error = compose_texts(&[("main.wesl", main), ("other.wesl", other)]);
    let said = error.expect_err("used").to_string();
    assert!(
        said.contains("no package `nowhere`") && said.contains("other.wesl:1:8"),
        "{said}"
    );
}

#[test]
fn a_file_that_no_path_can_name_is_told_where_it_is_meant() {
    let main = "import package::my_module::A;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(A); }\n";
    let files = [("main.wesl", main), ("my-module.wesl", "const A = 1.0;\n")];
    let said = compose_texts(&files)
        .expect_err("no such module")
        .to_string();
    assert!(said.contains("no module `demo::my_module`"), "{said}");
    assert!(
        said.contains("`demo::my-module` cannot be imported") && said.contains("rename"),
        "{said}"
    );
    // It may be what a pass starts from all the same.
    let axes = AXES.replace("main\")", "my-module\")");
    let files = [("axes.ron", axes.as_str()), ("my-module.wesl", SOUND)];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    compose(Package::from_sources("demo", "demo", files).expect("a package")).expect("composed");
}
