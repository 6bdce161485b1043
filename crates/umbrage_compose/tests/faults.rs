//! Texts that a developer reads when something is wrong: one snapshot a fault.

use umbrage_compose::{Composer, Error, Library, Package, Target};

const AXES: &str = r#"(
    axes: {
        "pass": (values: { "main": (root: "package::main") }),
        "method": (
            default: "none",
            values: {
                "none": (
                    bind: { "package::interface::shadow": "package::interface::shadow" },
                    provides: ["sight"],
                ),
                "mine": (bind: { "package::interface::shadow": "package::mine" }),
                "unbound": (provides: ["sight"]),
            },
        ),
        "fog": (default: "off", values: { "off": (), "on": (features: ["FOG"], needs: ["sight"]) }),
    },
    capabilities: { "sight": "a method that sees through fog" },
)"#;

const INTERFACE: &str = "fn calc_shadow(position_ws: vec3f) -> f32 { return 1.0; }\n";

const MAIN: &str = "import package::interface::shadow::calc_shadow;
@fragment fn fs_main() -> @location(0) vec4f { return vec4f(calc_shadow(vec3f())); }
";

fn library(files: &[(&str, &str)]) -> Result<Library, Error> {
    let mut all = vec![
        ("axes.ron", AXES),
        ("interface/shadow.wesl", INTERFACE),
        ("main.wesl", MAIN),
        ("mine.wesl", INTERFACE),
    ];
    all.retain(|(path, _)| files.iter().all(|(other, _)| other != path));
    all.extend(files);
    let files = all
        .into_iter()
        .map(|(path, text)| (path.to_owned(), text.to_owned()));
    Library::new([Package::from_sources("demo", "demo", files)?])
}

fn compose(files: &[(&str, &str)], choices: &[(&str, &str)]) -> Result<(), Error> {
    let library = library(files)?;
    let key = library.key(choices.iter().copied())?;
    Composer::new(library, Target::webgpu())
        .compose(&key)
        .map(drop)
}

/// The fault in `files`, which must be told with a place in one of them.
#[track_caller]
fn fault(files: &[(&str, &str)], choices: &[(&str, &str)]) -> String {
    let error = compose(files, choices).expect_err("the fault goes unnoticed");
    for fault in error.faults() {
        let location = fault.location().expect("the fault has no place");
        assert!(location.file.starts_with("demo/") && location.line > 0 && location.column > 0);
    }
    error.to_string()
}

const PLAIN: &[(&str, &str)] = &[("pass", "main")];
const MINE: &[(&str, &str)] = &[("pass", "main"), ("method", "mine")];

/// Declares a test a fault: `name, choices, [(file, text), …]`.
macro_rules! faults {
    ($($name:ident, $choices:expr, [$(($file:expr, $text:expr)),+ $(,)?];)+) => {
        $(#[test]
        fn $name() {
            insta::assert_snapshot!(fault(&[$(($file, $text)),+], $choices));
        })+
    };
}

faults! {
    // Syntax.
    syntax_missing_brace, PLAIN, [("main.wesl", "fn a() -> f32 {\n    return 1.0;\n")];
    syntax_missing_semicolon, PLAIN, [("main.wesl", "const A = 1\nconst B = 2;\n")];
    syntax_reserved_word, PLAIN, [("main.wesl", "fn a() {\n    let class = 1;\n}\n")];
    syntax_stray_token, PLAIN, [("main.wesl", "fn a() {\n    let b = 1 $ 2;\n}\n")];
    syntax_too_deep, PLAIN, [("main.wesl", &format!("const A = {}1{};\n", "(".repeat(300), ")".repeat(300)))];
    limit_alternatives, PLAIN, [("main.wesl", &format!("fn a(x: f32) {{\n    if x > 0.0 {{}}\n{}}}\n", "    else if x > 1.0 {}\n".repeat(600)))];
    limit_templates, PLAIN, [("main.wesl", &format!("alias T = {}f32{};\n", "array<".repeat(30), ", 2>".repeat(30)))];
    limit_operators, PLAIN, [("main.wesl", &format!("const A = 1{};\n", " + 1".repeat(600)))];
    limit_conditions, PLAIN, [("main.wesl", &format!("@if(FOG{})\nconst A = 1;\n", " && FOG".repeat(600)))];
    limit_exponent, PLAIN, [("main.wesl", "const A = 0x1.fp+99999999999999;\n")];
    limit_member, PLAIN, [("main.wesl", "struct S {\n    @size(4294967295) a: f32,\n}\n")];
    condition_unknown_feature, PLAIN, [("main.wesl", "@if(FOGG)\nconst A = 1;\n")];
    condition_not_boolean, PLAIN, [("main.wesl", "@if(FOG + 1)\nconst A = 1;\n")];
    condition_else_without_if, PLAIN, [("main.wesl", "const A = 1;\n@else\nconst B = 1;\n")];
    condition_two_on_one, PLAIN, [("main.wesl", "@if(FOG) @if(true)\nconst A = 1;\n")];

    // Imports.
    import_no_module, PLAIN, [("main.wesl", "import package::interface::shadows::calc_shadow;\n@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f(calc_shadow(vec3f()));\n}\n")];
    import_no_item, PLAIN, [("main.wesl", "import package::interface::shadow::calc_shadows;\n@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f(calc_shadows(vec3f()));\n}\n")];
    import_no_package, PLAIN, [("main.wesl", "import dem::interface::shadow::calc_shadow;\n@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f(calc_shadow(vec3f()));\n}\n")];
    import_hidden_by_feature, PLAIN, [
        ("main.wesl", "import package::fog::density;\n@fragment fn fs_main() -> @location(0) vec4f { return vec4f(density()); }\n"),
        ("fog.wesl", "@if(FOG)\nfn density() -> f32 { return 1.0; }\n"),
    ];
    import_twice, PLAIN, [
        ("main.wesl", "import package::a::size;\nimport package::b::size;\nconst A = size;\n"),
        ("a.wesl", "const size = 1;\n"),
        ("b.wesl", "const size = 2;\n"),
    ];
    import_and_declaration, PLAIN, [
        ("main.wesl", "import package::a::size;\nconst size = 3;\n"),
        ("a.wesl", "const size = 1;\n"),
    ];
    import_super_too_far, PLAIN, [("main.wesl", "import super::super::a::size;\nconst A = size;\n")];
    import_not_made, PLAIN, [
        ("main.wesl", "@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f(thickness);\n}\n"),
        ("walls.wesl", "const thickness = 0.3;\n"),
    ];
    path_in_code_no_item, PLAIN, [("main.wesl", "fn a() -> f32 {\n    return package::interface::shadow::calc_shade(vec3f());\n}\n")];
    path_in_code_unknown_start, PLAIN, [("main.wesl", "fn a() -> f32 {\n    return shadow::calc_shadow(vec3f());\n}\n")];

    // Interfaces.
    interface_unbound, &[("pass", "main"), ("method", "unbound")], [("main.wesl", MAIN)];
    interface_unbound_and_commented, &[("pass", "main"), ("method", "unbound")], [("main.wesl", "// What calc_shadow is bound to, this pass need not know.\nimport package::interface::shadow::calc_shadow;\n@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f(calc_shadow(vec3f()));\n}\n")];
    interface_missing_function, MINE, [("mine.wesl", "fn calc_shadows(position_ws: vec3f) -> f32 {\n    return 0.5;\n}\n")];
    interface_wrong_parameter, MINE, [("mine.wesl", "const ONE = 1.0;\nfn calc_shadow(position_ws: vec4f) -> f32 {\n    return ONE;\n}\n")];
    interface_wrong_result, MINE, [("mine.wesl", "fn calc_shadow(position_ws: vec3f) -> vec3f {\n    return position_ws;\n}\n")];

    // Types.
    type_unknown_name, PLAIN, [("main.wesl", "const falloff = 2.0;\n@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f(fallof);\n}\n")];
    type_mismatch, PLAIN, [("main.wesl", "@fragment fn fs_main() -> @location(0) vec4f {\n    let a: vec3f = vec2f(1.0);\n    return vec4f(a, 1.0);\n}\n")];
    type_wrong_argument, MINE, [("mine.wesl", "fn calc_shadow(position_ws: vec3f) -> f32 {\n    return half(position_ws);\n}\nfn half(value: f32) -> f32 {\n    return value * 0.5;\n}\n")];
    type_wrong_return, MINE, [("mine.wesl", "fn calc_shadow(position_ws: vec3f) -> f32 {\n    let depth = position_ws;\n    return depth;\n}\n")];
    type_unknown_member, PLAIN, [("main.wesl", "@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f(vec3f().w);\n}\n")];
type_in_an_imported_declaration, PLAIN, [
        ("main.wesl", "import package::a::Light;\n@fragment fn fs_main() -> @location(0) vec4f {\n    var light: Light;\n    return vec4f(light.power);\n}\n"),
        ("a.wesl", "// A light.\nstruct Light {\n    power: f33,\n}\n"),
    ];
    type_of_imported_struct, PLAIN, [
        ("main.wesl", "import package::light::Light;\n@fragment fn fs_main() -> @location(0) vec4f {\n    var light: Light;\n    return vec4f(light.colour, 1.0);\n}\n"),
        ("light.wesl", "struct Light {\n    color: vec3f,\n}\n"),
    ];
    resource_without_binding, PLAIN, [("main.wesl", "var<uniform> tint: vec4f;\n@fragment fn fs_main() -> @location(0) vec4f {\n    return tint;\n}\n")];

    // Recursion.
    recursion_within_a_module, PLAIN, [("main.wesl", "fn a() -> f32 {\n    return b();\n}\nfn b() -> f32 {\n    return a();\n}\n@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f(a());\n}\n")];
    recursion_across_modules, MINE, [
        ("main.wesl", "import package::interface::shadow::calc_shadow;\nfn density() -> f32 {\n    return calc_shadow(vec3f());\n}\n@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f(density());\n}\n"),
        ("mine.wesl", "import package::main::density;\nfn calc_shadow(position_ws: vec3f) -> f32 {\n    return density();\n}\n"),
    ];
    recursion_of_a_type, PLAIN, [("main.wesl", "struct Node {\n    next: Node,\n}\n@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f();\n}\n")];
    recursion_of_types_across_modules, PLAIN, [
        ("main.wesl", "import package::b::B;\nstruct A {\n    b: B,\n}\n@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f();\n}\n"),
        ("b.wesl", "import package::main::A;\nstruct B {\n    a: A,\n}\n"),
    ];

    // Validation.
    validation_capability, PLAIN, [("main.wesl", "enable f16;\n@fragment fn fs_main() -> @location(0) vec4f {\n    let a = f16(1.0);\n    return vec4f(f32(a));\n}\n")];
    validation_input_without_location, PLAIN, [("main.wesl", "@fragment fn fs_main(depth: f32) -> @location(0) vec4f {\n    return vec4f(depth);\n}\n")];
    validation_too_many_textures, PLAIN, [("main.wesl", &seventeen_textures())];
    validation_in_an_imported_module, MINE, [("mine.wesl", "@group(1) @binding(0) var<uniform> flag: bool;\nfn calc_shadow(position_ws: vec3f) -> f32 {\n    return select(0.0, 1.0, flag);\n}\n")];
    validation_too_many_groups, PLAIN, [("main.wesl", "@group(4) @binding(0) var<uniform> tint: vec4f;\n@fragment fn fs_main() -> @location(0) vec4f {\n    return tint;\n}\n")];
    entry_point_called, PLAIN, [
        ("main.wesl", "import package::other::fs_other;\n@fragment fn fs_main() -> @location(0) vec4f {\n    fs_other();\n    return vec4f();\n}\n"),
        ("other.wesl", "@fragment fn fs_other() {}\n"),
    ];

    // Axes.
    axes_unknown_field, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (valuez: {}),\n    },\n)\n")];
axes_value_twice, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (values: {\n            \"main\": (root: \"package::main\"),\n            \"main\": (),\n        }),\n    },\n)\n")];
    axes_no_module, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (values: { \"main\": (root: \"package::mian\") }),\n    },\n)\n")];
    axes_not_an_interface, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (values: { \"main\": (bind: { \"package::mine\": \"package::mine\" }) }),\n    },\n)\n")];
    axes_bad_default, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (default: \"mian\", values: { \"main\": (root: \"package::main\") }),\n    },\n)\n")];
    axes_need_undeclared, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (values: { \"main\": (root: \"package::main\", needs: [\"ligth\"]) }),\n        \"fog\": (default: \"off\", values: { \"off\": (provides: [\"light\"]), \"on\": () }),\n    },\n    capabilities: { \"light\": \"light\", \"sight\": \"sight\" },\n)\n")];
    axes_need_without_provider, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (values: { \"main\": (root: \"package::main\", needs: [\"light\"]) }),\n        \"fog\": (default: \"off\", values: { \"off\": (), \"on\": (provides: [\"sight\"]) }),\n    },\n    capabilities: { \"light\": \"light\", \"sight\": \"sight\" },\n)\n")];
    axes_provider_without_need, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (values: { \"main\": (root: \"package::main\", needs: [\"light\"]) }),\n        \"fog\": (default: \"off\", values: { \"off\": (provides: [\"light\"]), \"on\": (provides: [\"sight\"]) }),\n    },\n    capabilities: { \"light\": \"light\", \"sight\": \"sight\" },\n)\n")];
    axes_capability_unused, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (values: { \"main\": (root: \"package::main\", needs: [\"light\"]) }),\n        \"fog\": (default: \"off\", values: { \"off\": (provides: [\"light\"]), \"on\": () }),\n    },\n    capabilities: { \"light\": \"light\", \"sight\": \"sight\" },\n)\n")];
    axes_needs_in_a_circle, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (values: { \"main\": (root: \"package::main\", provides: [\"sight\"], needs: [\"light\"]) }),\n        \"fog\": (default: \"off\", values: { \"off\": (provides: [\"light\"], needs: [\"sight\"]), \"on\": () }),\n    },\n    capabilities: { \"light\": \"light\", \"sight\": \"sight\" },\n)\n")];
}

fn seventeen_textures() -> String {
    let textures = 0..17;
    let declared = textures
        .clone()
        .map(|i| format!("@group(0) @binding({i}) var map_{i}: texture_2d<f32>;\n"));
    let read = textures.map(|i| format!("textureLoad(map_{i}, vec2i(), 0)"));
    let read = read.collect::<Vec<_>>().join(" + ");
    let declared = declared.collect::<String>();
    format!("{declared}@fragment fn fs_main() -> @location(0) vec4f {{\n    return {read};\n}}\n")
}

/// Keys have no file: what they say is all there is.
#[test]
fn keys() {
    let library = library(&[]).expect("the library is sound");
    let wrong = |choices: &[(&str, &str)]| {
        library
            .key(choices.iter().copied())
            .expect_err("the key is wrong")
            .to_string()
    };
    insta::assert_snapshot!("key_unknown_axis", wrong(&[("pas", "main")]));
    insta::assert_snapshot!("key_unknown_value", wrong(&[("pass", "mian")]));
    insta::assert_snapshot!("key_missing_axis", wrong(&[("fog", "on")]));
    insta::assert_snapshot!(
        "key_two_values",
        wrong(&[("pass", "main"), ("fog", "on"), ("fog", "off")])
    );
    insta::assert_snapshot!(
        "key_excluded",
        wrong(&[("pass", "main"), ("fog", "on"), ("method", "mine")])
    );
}

/// Choices that ask for different things and may go together are refused with the library.
#[test]
fn choices_that_contradict_each_other() {
    let axes = AXES.replace(
        "\"on\": (features: [\"FOG\"], ",
        "\"on\": (bind: { \"package::interface::shadow\": \"package::mine\" }, ",
    );
    let error = compose(&[("axes.ron", &axes)], &[("pass", "main"), ("fog", "on")]);
    insta::assert_snapshot!(
        "key_two_bindings",
        error.expect_err("it is bound twice").to_string()
    );
}

/// An assertion in a module that only a constant is taken from is checked all the same.
#[test]
fn assertions_of_imported_modules() {
    let main = "import package::sizes::WIDTH;\n@fragment fn fs_main() -> @location(0) vec4f {\n    return vec4f(WIDTH);\n}\n";
    let sizes = "const WIDTH = 9.0;\nconst_assert WIDTH < 9.0;\n";
    let text = fault(&[("main.wesl", main), ("sizes.wesl", sizes)], PLAIN);
    insta::assert_snapshot!("const_assert", text);
}

/// The same module is sound where nothing is wrong: the harness does not fail by itself.
#[test]
fn sound() {
    compose(&[], PLAIN).expect("the null object is bound by name");
    compose(&[], MINE).expect("the method implements the interface");
}

/// Words of naga, wgpu or Rust for their own things, which an author of WGSL does not know.
const FOREIGN: [&str; 18] = [
    "naga",
    "Capabilities",
    "::valid",
    "TypeInner",
    "Scalar {",
    "Scalar(",
    "Vector {",
    "Some(",
    "None",
    "Handle",
    "Sint",
    "Uint",
    "Float,",
    "kind:",
    "width:",
    "GlobalUse",
    "StorageAccess",
    "ShaderStages",
];

/// Faulty modules of one pass, over what naga's front end and validator refuse.
const FAULTY: &[(&str, &str)] = &[
    (
        "binary",
        "@fragment fn fs() -> @location(0) vec4f { let a = vec2f() ; let b = vec3f(); return vec4f((a * b).x); }",
    ),
    (
        "binary of ints",
        "@fragment fn fs(@location(0) @interpolate(flat) i: i32) -> @location(0) vec4f { return vec4f(f32(i + 1u)); }",
    ),
    (
        "shift",
        "@fragment fn fs(@location(0) @interpolate(flat) i: i32) -> @location(0) vec4f { return vec4f(f32(i << 33u)); }",
    ),
    (
        "select",
        "@fragment fn fs() -> @location(0) vec4f { return vec4f(select(1.0, vec2f(2.0), true)); }",
    ),
    (
        "select condition",
        "@fragment fn fs() -> @location(0) vec4f { return vec4f(select(1.0, 2.0, 3.0)); }",
    ),
    (
        "builtin type",
        "@fragment fn fs(@builtin(position) p: vec3f) -> @location(0) vec4f { return vec4f(p, 1.0); }",
    ),
    (
        "builtin stage",
        "@fragment fn fs(@builtin(vertex_index) i: u32) -> @location(0) vec4f { return vec4f(f32(i)); }",
    ),
    (
        "input type",
        "@fragment fn fs(@location(0) m: mat2x2f) -> @location(0) vec4f { return vec4f(m[0], m[1]); }",
    ),
    (
        "output type",
        "@fragment fn fs() -> @location(0) bool { return true; }",
    ),
    (
        "return type",
        "@fragment fn fs() -> @location(0) vec4f { let a = vec3f(); return a; }",
    ),
    (
        "store type",
        "@fragment fn fs() -> @location(0) vec4f { var a = vec3f(); a = vec4f(); return vec4f(a, 1.0); }",
    ),
    (
        "store to let",
        "@fragment fn fs() -> @location(0) vec4f { let a = 1.0; a = 2.0; return vec4f(a); }",
    ),
    (
        "call argument",
        "fn f(a: vec3f) -> f32 { return a.x; }\n@fragment fn fs() -> @location(0) vec4f { let b = vec2f(); return vec4f(f(b)); }",
    ),
    (
        "call count",
        "fn f(a: vec3f) -> f32 { return a.x; }\n@fragment fn fs() -> @location(0) vec4f { return vec4f(f()); }",
    ),
    (
        "texture coordinate",
        "@group(0) @binding(0) var t: texture_2d<f32>;\n@group(0) @binding(1) var s: sampler;\n@fragment fn fs() -> @location(0) vec4f { return textureSample(t, s, vec3f()); }",
    ),
    (
        "comparison",
        "@group(0) @binding(0) var t: texture_2d<f32>;\n@group(0) @binding(1) var s: sampler_comparison;\n@fragment fn fs() -> @location(0) vec4f { return textureSample(t, s, vec2f()); }",
    ),
    (
        "storage format",
        "@group(0) @binding(0) var t: texture_storage_2d<rgba8unorm, write>;\n@fragment fn fs() -> @location(0) vec4f { textureStore(t, vec2i(), vec4u()); return vec4f(); }",
    ),
    (
        "index",
        "@fragment fn fs() -> @location(0) vec4f { let a = vec3f(); return vec4f(a[5]); }",
    ),
    (
        "index type",
        "@fragment fn fs() -> @location(0) vec4f { var a = vec3f(); return vec4f(a[1.5]); }",
    ),
    (
        "math",
        "@fragment fn fs() -> @location(0) vec4f { let a = true; return vec4f(cos(a)); }",
    ),
    (
        "math count",
        "@fragment fn fs() -> @location(0) vec4f { return vec4f(cos(1.0, 2.0)); }",
    ),
    (
        "math of vectors",
        "@fragment fn fs() -> @location(0) vec4f { let a = vec2f(); return vec4f(dot(a, vec3f())); }",
    ),
    (
        "if",
        "@fragment fn fs() -> @location(0) vec4f { let a = 1.0; if a { return vec4f(); } return vec4f(1.0); }",
    ),
    (
        "switch",
        "@fragment fn fs() -> @location(0) vec4f { let a = 1.0; switch a { default {} } return vec4f(1.0); }",
    ),
    (
        "switch case",
        "@fragment fn fs() -> @location(0) vec4f { let a = 1; switch a { case 1, 1 {} default {} } return vec4f(1.0); }",
    ),
    (
        "negation",
        "@fragment fn fs() -> @location(0) vec4f { let a = 1.0; return vec4f(f32(!a)); }",
    ),
    (
        "cast",
        "const A = i32(3e20);\n@fragment fn fs() -> @location(0) vec4f { return vec4f(f32(A)); }",
    ),
    (
        "literal",
        "@fragment fn fs() -> @location(0) vec4f { let a: u32 = -1; return vec4f(f32(a)); }",
    ),
    (
        "division",
        "@fragment fn fs() -> @location(0) vec4f { const a = 1 / 0; return vec4f(f32(a)); }",
    ),
    (
        "overflow",
        "const A = 2147483647i + 1i;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(f32(A)); }",
    ),
    (
        "compose",
        "@fragment fn fs() -> @location(0) vec4f { let a = vec2f(1.0); return vec4f(a, a, a); }",
    ),
    (
        "compose struct",
        "struct S { a: f32, b: f32 }\n@fragment fn fs() -> @location(0) vec4f { let s = S(1.0); return vec4f(s.a); }",
    ),
    (
        "zero of sampler",
        "@group(0) @binding(0) var s: sampler;\n@fragment fn fs() -> @location(0) vec4f { var t = s; return vec4f(); }",
    ),
    (
        "uniform bool",
        "@group(0) @binding(0) var<uniform> s: bool;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(f32(s)); }",
    ),
    (
        "uniform stride",
        "@group(0) @binding(0) var<uniform> s: array<f32, 4>;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(s[0]); }",
    ),
    (
        "workgroup in fragment",
        "var<workgroup> s: f32;\n@fragment fn fs() -> @location(0) vec4f { s = 1.0; return vec4f(s); }",
    ),
    (
        "write to read",
        "@group(0) @binding(0) var<storage, read> s: array<f32>;\n@fragment fn fs() -> @location(0) vec4f { s[0] = 1.0; return vec4f(s[0]); }",
    ),
    (
        "unsized in the middle",
        "struct S { a: array<f32>, b: f32 }\n@group(0) @binding(0) var<storage> s: S;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(s.b); }",
    ),
    (
        "atomic type",
        "@group(0) @binding(0) var<storage, read_write> s: atomic<f32>;\n@fragment fn fs() -> @location(0) vec4f { atomicAdd(&s, 1.0); return vec4f(); }",
    ),
    (
        "atomic operand",
        "@group(0) @binding(0) var<storage, read_write> s: atomic<u32>;\n@fragment fn fs() -> @location(0) vec4f { atomicAdd(&s, 1i); return vec4f(); }",
    ),
    (
        "array of samplers",
        "@group(0) @binding(0) var s: array<sampler, 2>;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(); }",
    ),
    (
        "array of zero",
        "var<private> s: array<f32, 0>;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(s[0]); }",
    ),
    (
        "pointer",
        "fn f(p: ptr<storage, f32>) -> f32 { return *p; }\n@group(0) @binding(0) var<storage> s: f32;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(f(&s)); }",
    ),
    (
        "interpolation",
        "@fragment fn fs(@location(0) i: i32) -> @location(0) vec4f { return vec4f(f32(i)); }",
    ),
    (
        "location twice",
        "@fragment fn fs(@location(0) a: f32, @location(0) b: f32) -> @location(0) vec4f { return vec4f(a + b); }",
    ),
    (
        "binding twice",
        "@group(0) @binding(0) var<uniform> a: vec4f;\n@group(0) @binding(0) var<uniform> b: vec4f;\n@fragment fn fs() -> @location(0) vec4f { return a + b; }",
    ),
    (
        "no position",
        "@vertex fn vs() -> @location(0) vec4f { return vec4f(); }",
    ),
    (
        "initializer",
        "var<workgroup> s: f32 = 1.0;\n@compute @workgroup_size(1) fn cs() { s = 2.0; }",
    ),
    (
        "load",
        "@group(0) @binding(0) var t: texture_2d<f32>;\n@fragment fn fs() -> @location(0) vec4f { return textureLoad(t, vec2f(), 0); }",
    ),
    (
        "gather",
        "@group(0) @binding(0) var t: texture_3d<f32>;\n@group(0) @binding(1) var s: sampler;\n@fragment fn fs() -> @location(0) vec4f { return textureGather(0, t, s, vec3f()); }",
    ),
    (
        "derivative",
        "@fragment fn fs(@location(0) @interpolate(flat) i: i32) -> @location(0) vec4f { return vec4f(f32(dpdx(i))); }",
    ),
    (
        "discard in compute",
        "@compute @workgroup_size(1) fn cs() { discard; }",
    ),
    (
        "swizzle",
        "@fragment fn fs() -> @location(0) vec4f { return vec4f(vec2f().xyz, 1.0); }",
    ),
    (
        "dereference",
        "@fragment fn fs() -> @location(0) vec4f { let a = 1.0; return vec4f(*a); }",
    ),
];

#[test]
fn no_message_speaks_of_naga_s_own_things() {
    let digits_in_brackets = |text: &str| {
        text.split('[').skip(1).any(|rest| {
            rest.split_once(']').is_some_and(|(inner, _)| {
                !inner.is_empty() && inner.bytes().all(|byte| byte.is_ascii_digit())
            })
        })
    };
    let mut unnoticed = Vec::new();
    let mut wrong = Vec::new();
    for (name, text) in FAULTY {
        let Err(error) = compose(&[("main.wesl", text)], PLAIN) else {
            unnoticed.push(*name);
            continue;
        };
        for fault in error.faults() {
            let in_main = |at: &umbrage_compose::Location| at.file == "demo/main.wesl";
            let labels = fault.locations.iter().map(|at| at.label.as_str());
            let words = (fault.notes.iter().map(String::as_str)).chain([fault.message.as_str()]);
            let foreign = |said: &str| {
                let first = said.chars().next().unwrap_or('a');
                FOREIGN.iter().any(|word| said.contains(word))
                    || digits_in_brackets(said)
                    || first.is_uppercase()
            };
            if !fault.location().is_some_and(in_main) || words.chain(labels).any(foreign) {
                wrong.push(format!("{name}: {fault}"));
            }
            println!("{name}: {fault}");
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // Modules that the validator lets pass today test nothing; it must refuse most of them.
    assert!(unnoticed.len() * 5 < FAULTY.len(), "{unnoticed:?}");
}

/// A shader that needs a feature, and words of the message that tells so.
const FEATURES: &[(&str, &str)] = &[
    (
        "`f16`",
        "enable f16;\n@fragment fn fs() -> @location(0) vec4f { let a = f16(1.0); return vec4f(f32(a)); }",
    ),
    (
        "`f16`",
        "enable f16;\n@fragment fn fs(@location(0) a: f32) -> @location(0) vec4f { return vec4f(f32(f16(a))); }",
    ),
    (
        "`f16`",
        "enable f16;\n@group(0) @binding(0) var<uniform> a: vec4<f16>;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(a); }",
    ),
    (
        "`f64`",
        "@fragment fn fs(@location(0) a: f32) -> @location(0) vec4f { return vec4f(f32(f64(a) * f64(a))); }",
    ),
    (
        "`i64`",
        "@fragment fn fs(@location(0) a: f32) -> @location(0) vec4f { return vec4f(f32(i64(a))); }",
    ),
    (
        "subgroup",
        "@fragment fn fs(@location(0) a: f32) -> @location(0) vec4f { return vec4f(subgroupAdd(a)); }",
    ),
    (
        "primitive_index",
        "enable primitive_index;\n@fragment fn fs(@builtin(primitive_index) i: u32) -> @location(0) vec4f { return vec4f(f32(i)); }",
    ),
    (
        "view_index",
        "@fragment fn fs(@builtin(view_index) i: i32) -> @location(0) vec4f { return vec4f(f32(i)); }",
    ),
    (
        "immediate",
        "var<immediate> a: vec4f;\n@fragment fn fs() -> @location(0) vec4f { return a; }",
    ),
    (
        "clip_distances",
        "enable clip_distances;\nstruct V { @builtin(position) p: vec4f, @builtin(clip_distances) d: array<f32, 1> }\n@vertex fn vs() -> V { return V(vec4f(), array<f32, 1>(1.0)); }",
    ),
    (
        "blend",
        "enable dual_source_blending;\nstruct F { @location(0) @blend_src(0) a: vec4f, @location(0) @blend_src(1) b: vec4f }\n@fragment fn fs() -> F { return F(vec4f(), vec4f()); }",
    ),
    (
        "ray queries",
        "enable wgpu_ray_query;\n@group(0) @binding(0) var a: acceleration_structure;\n@fragment fn fs() -> @location(0) vec4f { var q: ray_query; rayQueryInitialize(&q, a, RayDesc(0u, 255u, 0.0, 1.0, vec3f(), vec3f(1.0))); return vec4f(f32(rayQueryProceed(&q))); }",
    ),
    (
        "binding_array",
        "enable wgpu_binding_array;\n@group(0) @binding(0) var t: binding_array<texture_2d<f32>, 4>;\n@fragment fn fs() -> @location(0) vec4f { return textureLoad(t[0], vec2i(), 0); }",
    ),
    (
        "64-bit number",
        "@fragment fn fs() -> @location(0) vec4f { return vec4f(f32(1lu)); }",
    ),
    (
        "16-bit normalized",
        "@group(0) @binding(0) var t: texture_storage_2d<rgba16unorm, write>;\n@fragment fn fs() -> @location(0) vec4f { textureStore(t, vec2i(), vec4f()); return vec4f(); }",
    ),
    (
        "64-bit integers",
        "@group(0) @binding(0) var<storage, read_write> a: atomic<u64>;\n@fragment fn fs() -> @location(0) vec4f { atomicMax(&a, u64(1u)); return vec4f(); }",
    ),
    (
        "atomics on `f32`",
        "@group(0) @binding(0) var<storage, read_write> a: atomic<f32>;\n@fragment fn fs() -> @location(0) vec4f { atomicAdd(&a, 1.0); return vec4f(); }",
    ),
    (
        "texture_external",
        "@group(0) @binding(0) var t: texture_external;\n@fragment fn fs() -> @location(0) vec4f { return textureLoad(t, vec2u()); }",
    ),
];

#[test]
fn what_the_target_lacks_is_named() {
    let mut untold = Vec::new();
    for (what, text) in FEATURES {
        let error = compose(&[("main.wesl", text)], PLAIN).expect_err(what);
        let said = error.to_string();
        println!("{said}");
        let told = said.contains("which the target `webgpu` does not offer")
            || said.contains("modules cannot ask for");
        if !(told && said.contains(what) && said.contains("demo/main.wesl:")) {
            untold.push(format!("{what}: {said}"));
        }
    }
    assert!(untold.is_empty(), "{}", untold.join("\n"));
}

#[test]
fn what_stands_in_the_wrong_order_is_told_the_order() {
    for (message, at, text) in [
        (
            "an import after a directive",
            2,
            "enable f16;\nimport package::interface::shadow::calc_shadow;\n",
        ),
        (
            "an import after a declaration",
            2,
            "const A = 1;\nimport package::interface::shadow::calc_shadow;\n",
        ),
        (
            "an import after a declaration",
            3,
            "fn f() {\n}\n@if(FOG) import package::interface::shadow::calc_shadow;\n",
        ),
        (
            "`enable` after a declaration",
            2,
            "const A = 1;\nenable f16;\n",
        ),
        (
            "`requires` after a declaration",
            2,
            "const A = 1;\nrequires readonly_and_readwrite_storage_textures;\n",
        ),
        (
            "`diagnostic` after a declaration",
            2,
            "const A = 1;\ndiagnostic(off, derivative_uniformity);\n",
        ),
        (
            "an import within a declaration",
            2,
            "fn f() {\nimport package::a::b;\n}\n",
        ),
    ] {
        let error = compose(&[("main.wesl", text)], PLAIN).expect_err(text);
        let fault = &error.faults()[0];
        assert!(fault.message.starts_with(message), "{text}: {fault}");
        assert!(
            fault
                .to_string()
                .contains("imports come first, then directives"),
            "{fault}"
        );
        assert_eq!(fault.location().map(|at| at.line), Some(at), "{fault}");
    }
}

#[test]
fn all_of_a_module_is_not_imported() {
    for text in [
        "import package::interface::shadow::*;\n",
        "import package::interface::{shadow::*};\n",
        "import package::*;\n",
    ] {
        let said = fault(&[("main.wesl", text)], PLAIN);
        assert!(
            said.starts_with("all that a module has cannot be imported at once"),
            "{said}"
        );
    }
    let said = fault(&[("main.wesl", "import package::my-module::a;\n")], PLAIN);
    assert!(said.contains("letters, digits and `_`"), "{said}");
}
