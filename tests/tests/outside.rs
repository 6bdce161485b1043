//! Parts from other crates that are at fault: the error names the part, its file and the place, and what to do.

use std::sync::Arc;

use umbrage::{
    compose::{Composer, Library, Package, Target},
    methods::registry,
    render::{Gpu, RenderOptions, Renderer, Scene, Shadow, What},
    shadow::{Filter, Frame, Part, PlanError, Registry},
};

/// A filter called `own`, of one tap.
struct Own;

impl Part for Own {
    fn name(&self) -> &str {
        "own"
    }
}

impl Filter for Own {
    fn reach(&self, _: &Frame<'_>, _: usize) -> Result<f64, PlanError> {
        Ok(1.0)
    }

    fn fetches(&self, _: &Frame<'_>, _: usize) -> Result<u32, PlanError> {
        Ok(1)
    }
}

const AXES: &str = r#"(axes: {
    "filter": (values: {
        "own": (bind: { "umbrage::interface::filter": "package::own" }, needs: ["planar", "tiles"]),
    }),
})"#;

const SOUND: &str = "import umbrage::interface::filter::Tile;
fn filter_map(at: vec2f, plane: vec3f, tile: Tile) -> f32 { return 1.0; }
";

fn library(axes: &str, text: &str) -> Result<Library, String> {
    let ours = umbrage::shader_package().map_err(|e| e.to_string())?;
    let files = [("axes.ron", axes), ("own.wesl", text)];
    let package = Package::from_sources("outside", "outside/shaders", files);
    let package = package.map_err(|e| e.to_string())?;
    Library::new([ours, package]).map_err(|e| e.to_string())
}

fn parts() -> Registry {
    let mut parts = registry().expect("names are unique");
    parts.filters.add(Own).expect("a new name");
    parts
}

/// Renders with the filter; the error.
fn refused(axes: &str, text: &str, parts: Registry) -> String {
    let library = match library(axes, text) {
        Ok(library) => library,
        Err(error) => return error,
    };
    let composer = Arc::new(Composer::new(library, Target::webgpu()));
    let gpu = Arc::new(Gpu::new().expect("an adapter"));
    let mut renderer = Renderer::new(gpu, composer, parts);
    let scene = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../examples/scenes/suzanne_spot.ron"
    );
    let scene = Scene::load(scene).expect("a sound scene");
    let options = RenderOptions {
        width: 64,
        height: 48,
        what: What::ShadowTerm,
        shadow: Shadow::new("basic").with("filter", "own"),
        ..RenderOptions::default()
    };
    match renderer.render(&scene, &options) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn assert_says(said: &str, needles: &[&str]) {
    for needle in needles {
        assert!(said.contains(needle), "{said}\nlacks: {needle}");
    }
}

#[test]
fn shaders_at_fault_are_told_with_their_place() {
    assert_eq!(refused(AXES, SOUND, parts()), "", "the sound one renders");
    let cases: [(&str, &str, &[&str]); 5] = [
        (
            "no such function",
            "fn filter_maps() -> f32 { return 1.0; }\n",
            &[
                "`outside::own` does not implement `umbrage::interface::filter`",
                "no `fn filter_map` here",
                "outside/shaders/own.wesl:1:1",
                "is `filter_maps` meant to be it?",
            ],
        ),
        (
            "another signature",
            "fn filter_map(at: vec2f) -> f32 { return at.x; }\n",
            &[
                "`filter_map` does not have the signature",
                "outside/shaders/own.wesl:1:1",
                "expected `fn filter_map(",
                "found    `fn filter_map(at: vec2f) -> f32`",
            ],
        ),
        (
            "no shader at all",
            "fn filter_map(\n",
            &["outside/shaders/own.wesl:"],
        ),
        (
            "an import that there is not",
            "import umbrage::interface::filter::Tiles;\nfn filter_map(at: vec2f, plane: vec3f, tile: Tiles) -> f32 { return 1.0; }\n",
            &["no `Tiles`", "outside/shaders/own.wesl:1:"],
        ),
        (
            "more than the target has",
            "import umbrage::interface::filter::Tile;\nenable f16;\nfn filter_map(at: vec2f, plane: vec3f, tile: Tile) -> f32 { return f32(f16(at.x)); }\n",
            &["f16", "outside/shaders/own.wesl:"],
        ),
    ];
    for (what, text, needles) in cases {
        let said = refused(AXES, text, parts());
        println!("{what}:\n{said}\n");
        assert_says(&said, needles);
    }
}

#[test]
fn choices_at_fault_are_told_with_their_place() {
    let cases: [(&str, &str, &[&str]); 3] = [
        (
            "a capability that nobody provides",
            &AXES.replace("\"tiles\"", "\"tile\""),
            &["`tile`", "outside/shaders/axes.ron:", "`tiles`"],
        ),
        (
            "a value that there is",
            &AXES.replace("\"own\": (", "\"pcf\": ("),
            &[
                "two packages have a value `pcf` for the axis `filter`",
                "outside/shaders/axes.ron:3",
                "shader_lib/axes.ron:",
                "rename one",
            ],
        ),
        (
            "a module that there is not",
            &AXES.replace("package::own", "package::owner"),
            &["outside::owner", "outside/shaders/axes.ron:"],
        ),
    ];
    for (what, axes, needles) in cases {
        let said = refused(axes, SOUND, parts());
        println!("{what}:\n{said}\n");
        assert_says(&said, needles);
    }
}

#[test]
fn halves_of_a_part_that_miss_each_other_are_told() {
    // The shader is there, the Rust half is not registered.
    let said = refused(AXES, SOUND, registry().expect("names are unique"));
    assert_says(&said, &["light `window`", "filter `own`"]);
    // The Rust half is registered, the shader is not there.
    let said = refused("(axes: {})", SOUND, parts());
    assert_says(&said, &["`filter` has no value `own`"]);
    // Two parts of one name.
    let mut twice = parts();
    let said = twice.filters.add(Own).expect_err("known").to_string();
    assert_says(&said, &["`own`"]);
}

/// Numbers that are none reach no shader.
#[test]
fn plans_with_numbers_that_are_none_are_refused() {
    struct Numberless;
    impl Part for Numberless {
        fn name(&self) -> &str {
            "own"
        }
    }
    impl Filter for Numberless {
        fn reach(&self, _: &Frame<'_>, _: usize) -> Result<f64, PlanError> {
            Ok(f64::NAN)
        }
        fn fetches(&self, _: &Frame<'_>, _: usize) -> Result<u32, PlanError> {
            Ok(u32::MAX)
        }
        fn depth_bias(&self, _: &Frame<'_>, _: f64, _: u32) -> Result<f64, PlanError> {
            Ok(f64::INFINITY)
        }
    }
    let mut parts = registry().expect("names are unique");
    parts.filters.add(Numberless).expect("a new name");
    let said = refused(AXES, SOUND, parts);
    assert_says(
        &said,
        &["light `window`", "of the filter `own` is", "finite"],
    );
}
