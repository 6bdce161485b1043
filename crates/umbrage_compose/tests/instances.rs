//! Two implementations of one interface in one shader: what they would share without a word is a fault, and nothing
//! else is.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{fs, path::Path};

use umbrage_compose::{Cause, Composer, Error, Library, Package, Permutation, Target};

const AXES: &str = r#"(axes: {
    "pass": (values: { "main": (root: "package::main") }),
    "shadow": (default: "none", values: {
        "none": (bind: { "package::interface::shadow": "package::interface::shadow" }),
        "a": (bind: { "package::interface::shadow": "package::methods::a" }),
        "over": (bind: { "package::interface::shadow": "package::methods::over" }),
    }),
    "light": (default: "sun", values: { "sun": (bind: { "package::interface::light": "package::sun" }) }),
})"#;

const SHADOW: &str = "fn calc_shadow(position_ws: vec3f) -> f32 { return 1.0; }\n";
const LIGHT: &str = "fn lit(position_ws: vec3f) -> f32 { return 1.0; }\n";
const SURFACE: &str = "fn shade(position_ws: vec3f) -> f32 { return 1.0; }\n";

/// One map that modules may read.
const MAPS: &str = "@group(0) @binding(0) var shadow_map: texture_2d<f32>;\nfn look(at: vec2f) -> f32 { return textureLoad(shadow_map, vec2i(at), 0).x; }\n";
const BY_MAPS: &str = "import package::maps::look;\nfn calc_shadow(position_ws: vec3f) -> f32 { return look(position_ws.xy); }\n";
const OWN_MAP: &str = "@group(1) @binding(0) var shadow_map: texture_2d<f32>;\nfn calc_shadow(position_ws: vec3f) -> f32 { return textureLoad(shadow_map, vec2i(), 0).x; }\nfn helper(x: f32) -> f32 { return x * textureLoad(shadow_map, vec2i(1), 0).x; }\n";

fn compose(files: &[(&str, &str)], choices: &[(&str, &str)]) -> Result<Permutation, Error> {
    let mut all = vec![
        ("axes.ron", AXES),
        ("interface/shadow.wesl", SHADOW),
        ("interface/light.wesl", LIGHT),
        ("interface/surface.wesl", SURFACE),
        ("methods/a.wesl", SHADOW),
        ("methods/over.wesl", SHADOW),
        ("sun.wesl", LIGHT),
    ];
    all.retain(|(path, _)| files.iter().all(|(other, _)| other != path));
    all.extend(files);
    let files = all
        .into_iter()
        .map(|(path, text)| (path.to_owned(), text.to_owned()));
    let library = Library::new([Package::from_sources("demo", "demo", files)?])?;
    let key = library.key([("pass", "main")].iter().chain(choices).copied())?;
    let composed = Composer::new(library, Target::webgpu()).compose(&key)?;
    drop(composed.permutation.wgsl()?);
    Ok(
        std::sync::Arc::into_inner(composed.permutation)
            .unwrap_or_else(|| panic!("kept elsewhere")),
    )
}

/// Composes a pass that multiplies what `near` and `far` give.
fn two(imports: &str, files: &[(&str, &str)]) -> Result<Permutation, Error> {
    let main = format!(
        "{imports}\n@fragment fn fs() -> @location(0) vec4f {{\n    return vec4f(near(vec3f()) * far(vec3f()));\n}}\n"
    );
    let mut all = vec![("main.wesl", main.as_str())];
    all.extend(files);
    compose(&all, &[])
}

const AB: &str = "import package::methods::a::calc_shadow as near;\nimport package::methods::b::calc_shadow as far;";

#[track_caller]
fn refused(result: Result<Permutation, Error>, message: &str, places: &[(&str, usize)]) {
    let error = result.expect_err("they share");
    let fault = &error.faults()[0];
    assert_eq!(fault.cause, Cause::Interface, "{error}");
    assert!(fault.message.contains(message), "{error}");
    let found: Vec<_> = fault
        .locations
        .iter()
        .map(|at| (at.file.trim_start_matches("demo/"), at.line))
        .collect();
    assert_eq!(found, places, "{error}");
    assert!(!fault.notes.is_empty(), "{error}");
}

#[test]
fn two_methods_over_one_map() {
    let files = [
        ("maps.wesl", MAPS),
        ("methods/a.wesl", BY_MAPS),
        ("methods/b.wesl", BY_MAPS),
    ];
    refused(
        two(AB, &files),
        "`demo::methods::a` and `demo::methods::b` would share one `shadow_map`",
        &[("main.wesl", 1), ("main.wesl", 2), ("maps.wesl", 1)],
    );
    // By inline paths as well.
    let main = "@fragment fn fs() -> @location(0) vec4f {\n    return vec4f(package::methods::a::calc_shadow(vec3f())\n        * package::methods::b::calc_shadow(vec3f()));\n}\n";
    let mut all = files.to_vec();
    all.push(("main.wesl", main));
    refused(
        compose(&all, &[]),
        "would share one `shadow_map`",
        &[("main.wesl", 2), ("main.wesl", 3), ("maps.wesl", 1)],
    );
    // A method of two, neither of which is the other's part.
    let both = "import package::methods::b::calc_shadow as b;\nimport package::methods::c::calc_shadow as c;\nfn calc_shadow(position_ws: vec3f) -> f32 { return b(position_ws) * c(position_ws); }\n";
    let all = [
        (
            "main.wesl",
            "import package::interface::shadow::calc_shadow;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(calc_shadow(vec3f())); }\n",
        ),
        ("maps.wesl", MAPS),
        ("methods/a.wesl", both),
        ("methods/b.wesl", BY_MAPS),
        ("methods/c.wesl", BY_MAPS),
    ];
    refused(
        compose(&all, &[("shadow", "a")]),
        "would share one `shadow_map`",
        &[
            ("methods/a.wesl", 1),
            ("methods/a.wesl", 2),
            ("maps.wesl", 1),
        ],
    );
}

/// The bound method and another.
#[test]
fn a_method_beside_the_bound_one() {
    let main = "import package::interface::shadow::calc_shadow;\nimport package::methods::b::calc_shadow as far;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(calc_shadow(vec3f()) * far(vec3f())); }\n";
    let files = [
        ("main.wesl", main),
        ("maps.wesl", MAPS),
        ("methods/a.wesl", BY_MAPS),
        ("methods/b.wesl", BY_MAPS),
    ];
    refused(
        compose(&files, &[("shadow", "a")]),
        "would share one `shadow_map`",
        &[("main.wesl", 1), ("main.wesl", 2), ("maps.wesl", 1)],
    );
    compose(&files, &[]).expect("the null object reads nothing");
}

#[test]
fn maps_of_one_name() {
    refused(
        two(
            AB,
            &[("methods/a.wesl", OWN_MAP), ("methods/b.wesl", OWN_MAP)],
        ),
        "each have a `shadow_map` in group 1",
        &[
            ("main.wesl", 1),
            ("main.wesl", 2),
            ("methods/a.wesl", 1),
            ("methods/b.wesl", 1),
        ],
    );
}

#[test]
fn one_method_by_two_names() {
    let imports = "import package::methods::a::calc_shadow as near;\nimport package::methods::a::calc_shadow as far;";
    refused(
        two(imports, &[("methods/a.wesl", OWN_MAP)]),
        "are one function of `demo::methods::a`, with one `shadow_map` between them",
        &[("main.wesl", 2), ("main.wesl", 1), ("methods/a.wesl", 1)],
    );
    two(imports, &[]).expect("there is nothing to share");
    // So is a module by two names, whether it implements anything or not.
    let main = "import package::methods::a as sun;\nimport package::methods::a as lamp;\n@fragment fn fs() -> @location(0) vec4f {\n    return vec4f(sun::helper(1.0)\n        * lamp::helper(1.0));\n}\n";
    refused(
        compose(&[("main.wesl", main), ("methods/a.wesl", OWN_MAP)], &[]),
        "`lamp::helper` and `sun::helper` are one function",
        &[("main.wesl", 5), ("main.wesl", 4), ("methods/a.wesl", 1)],
    );
    // One name in two spellings is one name.
    let main = "import package::methods::a;\nimport package::methods::a::helper;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(a::helper(1.0) * helper(1.0) * package::methods::a::helper(2.0)); }\n";
    compose(&[("main.wesl", main), ("methods/a.wesl", OWN_MAP)], &[]).expect("one name");
}

/// The library's own methods.
#[test]
fn two_methods_of_the_library() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shader_lib");
    let mut files = Vec::new();
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let name = path
                .strip_prefix(&root)
                .expect("within")
                .to_string_lossy()
                .into_owned();
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".wesl") || name == "axes.ron" {
                files.push((name, fs::read_to_string(path).expect("text")));
            }
        }
    }
    for (name, text) in &mut files {
        if name == "axes.ron" {
            *text = text.replace("passes::shadow_term\"", "passes::two\"");
        }
    }
    let pass = files
        .iter()
        .find(|(name, _)| name == "passes/shadow_term.wesl");
    let pass = pass.expect("the pass").1.clone();
    let pass = pass.replace(
        "import package::interface::shadow::calc_shadow;",
        "import package::methods::basic::calc_shadow as near; import package::methods::pssm::calc_shadow as far;",
    );
    let pass = pass.replace(
        "calc_shadow(in.position_ws)",
        "near(in.position_ws) * far(in.position_ws)",
    );
    assert!(pass.contains("far(in.position_ws)"), "{pass}");
    files.push(("passes/two.wesl".to_owned(), pass));
    let package = Package::from_sources("demo", "demo", files).unwrap_or_else(|e| panic!("{e}"));
    let library = Library::new([package]).unwrap_or_else(|e| panic!("{e}"));
    let key = library.key([("pass", "shadow_term"), ("method", "basic")]);
    let key = key.unwrap_or_else(|e| panic!("{e}"));
    let error = Composer::new(library, Target::webgpu())
        .compose(&key)
        .expect_err("they share");
    assert!(
        error.to_string().contains(
            "`demo::methods::basic` and `demo::methods::pssm` would share one `shadow_map`"
        ),
        "{error}"
    );
}

#[test]
fn what_is_shared_openly() {
    // A method that is another's part, alone or with a helper of it.
    let over = "import package::methods::a::{calc_shadow as inner, helper};\nfn calc_shadow(position_ws: vec3f) -> f32 { return helper(inner(position_ws)); }\n";
    let main = "import package::interface::shadow::calc_shadow;\nimport package::methods::a::helper;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(helper(calc_shadow(vec3f()))); }\n";
    let files = [
        ("main.wesl", main),
        ("methods/a.wesl", OWN_MAP),
        ("methods/over.wesl", over),
    ];
    compose(&files, &[("shadow", "over")]).expect("a part");
    compose(&files, &[("shadow", "a")]).expect("a helper");

    // Methods with maps of their own names.
    let mask = "@group(1) @binding(0) var mask: texture_2d<f32>;\nfn calc_shadow(position_ws: vec3f) -> f32 { return textureLoad(mask, vec2i(), 0).x; }\n";
    let linked =
        two(AB, &[("methods/a.wesl", OWN_MAP), ("methods/b.wesl", mask)]).expect("two maps");
    assert_eq!(linked.reflection.bindings.len(), 2);

    // A variable that the pass reads as well.
    let frame = "@group(0) @binding(0) var<uniform> frame: vec4f;\n";
    let method = |map: &str| {
        format!(
            "import package::frame::frame;\n@group(1) @binding(0) var {map}: texture_2d<f32>;\nfn calc_shadow(position_ws: vec3f) -> f32 {{ return frame.x * textureLoad({map}, vec2i(), 0).x; }}\n"
        )
    };
    let main = format!(
        "{AB}\nimport package::frame::frame;\n@fragment fn fs() -> @location(0) vec4f {{ return frame * near(vec3f()) * far(vec3f()); }}\n"
    );
    let (a, b) = (method("map_a"), method("map_b"));
    compose(
        &[
            ("main.wesl", &main),
            ("frame.wesl", frame),
            ("methods/a.wesl", &a),
            ("methods/b.wesl", &b),
        ],
        &[],
    )
    .expect("the frame is everyone's");

    // Two surfaces in the one bound light.
    let sun = "import package::interface::shadow::calc_shadow;\n@group(1) @binding(3) var<uniform> sun: vec4f;\nfn lit(position_ws: vec3f) -> f32 { return sun.x * calc_shadow(position_ws); }\n";
    let surface = "import package::interface::light::lit;\nfn shade(position_ws: vec3f) -> f32 { return lit(position_ws) * 0.5; }\n";
    let main = "import package::surfaces::dull::shade as near;\nimport package::surfaces::shiny::shade as far;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(mix(near(vec3f()), far(vec3f()), 0.5)); }\n";
    compose(
        &[
            ("main.wesl", main),
            ("surfaces/dull.wesl", surface),
            ("surfaces/shiny.wesl", surface),
            ("sun.wesl", sun),
            ("methods/a.wesl", OWN_MAP),
        ],
        &[("shadow", "a")],
    )
    .expect("one light on both");
}
