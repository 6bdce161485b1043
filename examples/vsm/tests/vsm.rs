//! The filter over both methods: its shadows are those of `pcf` of the same width, but for what its page says of it.

use std::{path::Path, process::Command, sync::Arc};

use umbrage::{
    compose::{Composer, Library, RonFile, Target},
    render::{Gpu, Picture, RenderOptions, Renderer, Scene, Shadow, What},
    shadow::Registry,
};
use umbrage_example_vsm::{Vsm, package};
use umbrage_testkit::{Limits, conformance, pictures};

fn library() -> Library {
    let ours = umbrage::shader_package().expect("the shader library is sound");
    Library::new([ours, package().expect("a package")]).expect("they fit together")
}

fn registry() -> Registry {
    let mut registry = umbrage::methods::registry().expect("names are unique");
    registry.filters.add(Vsm).expect("a name of its own");
    registry
}

fn renderer() -> Renderer {
    let composer = Composer::new(library(), Target::webgpu());
    Renderer::new(
        Arc::new(Gpu::new().expect("an adapter")),
        Arc::new(composer),
        registry(),
    )
}

fn scene(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    Scene::load(folder.join(name)).expect("a sound scene")
}

fn options(method: &str, filter: &str) -> RenderOptions {
    RenderOptions {
        width: 160,
        height: 90,
        what: What::ShadowTerm,
        shadow: Shadow::new(method).with("filter", filter).with("pcf", "5"),
        ..RenderOptions::default()
    }
}

#[test]
fn shadows_are_those_of_comparisons() {
    let mut renderer = renderer();
    let scenes = [
        ("bunny_sun.ron", "basic"),
        ("suzanne_spot.ron", "basic"),
        ("avenue.ron", "pssm"),
        ("suzanne_spot.ron", "pssm"),
    ];
    for (name, method) in scenes {
        let scene = scene(name);
        let mut terms = |filter| {
            let rendered = renderer.render(&scene, &options(method, filter));
            let rendered = rendered.expect("renders");
            assert_eq!(rendered.report.plans.len(), scene.lights.len());
            match rendered.picture {
                Picture::ShadowTerm(terms) => terms,
                other => unreachable!("{other:?}"),
            }
        };
        let (compared, bounded) = (terms("pcf"), terms("vsm"));
        let pairs = compared.iter().flatten().zip(bounded.iter().flatten());
        let (mut apart, mut dark, mut count) = (0.0, 0, 0);
        for (compared, bounded) in pairs {
            assert!((0.0..=1.0).contains(bounded), "{name}: {bounded}");
            apart += f64::from((compared - bounded).abs());
            dark += u32::from(*bounded < 0.1);
            count += 1;
        }
        let mean = apart / f64::from(count);
        println!("{name}, {method}: {mean:.4} apart, {dark} of {count} dark");
        assert!(mean < 0.03, "{name}, {method}: {mean}");
        assert!(
            dark > 100 && dark < count - 100,
            "{name}, {method}: {dark} of {count}"
        );
    }
}

/// The command in `main.rs` draws the picture of README.md, and holds the filter to its limits in the hard cases.
#[test]
fn the_command_knows_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let run = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbrage_example_vsm"));
        let output = command.current_dir(folder).args(words).output();
        let output = output.expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{words:?}: {said}");
    };
    let drawn = Path::new(env!("CARGO_TARGET_TMPDIR")).join("vsm.png");
    let drawn = drawn.to_str().expect("a path");
    run(&[
        "render",
        "../scenes/avenue.ron",
        "--method=pssm",
        "--axis=filter=vsm",
        "--axis=pcf=7",
        "--size=640x360",
        "--out",
        drawn,
    ]);
    let picture = image::open(drawn).expect("a picture").into_rgb8();
    let checked = pictures::check(&picture, &folder.join("vsm.png"));
    assert_eq!(checked, Ok(()));
    run(&[
        "stress",
        "--limits=limits.ron",
        "--variants=vsm",
        "--cases=contact",
    ]);
    let key = "filter=vsm,light=spot,method=pssm,pass=shadow_term,taper=on";
    run(&["check", "--key", key, "--key", "filter=vsm,pass=vsm_down"]);
}

/// The filter keeps what all parts promise, and its limits in the hard cases.
#[test]
fn it_conforms() {
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("limits.ron");
    let limits = RonFile::load(&table).and_then(Limits::read);
    let limits = limits.expect("a sound table");
    let packages = [
        umbrage::shader_package().expect("the shader library is sound"),
        package().expect("the package is sound"),
    ];
    let held = conformance(packages, registry(), &limits, &["vsm", "vsm pssm"]);
    let held = held.unwrap_or_else(|broken| panic!("{broken}"));
    assert_eq!(held.variants, 2);
}

/// A filter is small: what its page promises who reads it.
#[test]
fn it_is_small() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let lines = |paths: &[&str]| -> usize {
        let text = |path: &&str| std::fs::read_to_string(folder.join(path)).expect("a file");
        paths.iter().map(|path| text(path).lines().count()).sum()
    };
    assert!(lines(&["src/lib.rs"]) <= 120);
    assert!(lines(&["shaders/vsm.wesl", "shaders/blur.wesl"]) <= 100);
    assert!(lines(&["src/main.rs"]) <= 12);
}
