//! What a developer reads when something is wrong: one snapshot a fault.

use umbrage_compose::{Composer, Error, Library, Package, Target};

const AXES: &str = r#"(
    axes: {
        "pass": (values: { "main": (root: "package::main") }),
        "method": (
            default: "none",
            values: {
                "none": (bind: { "package::interface::shadow": "package::interface::shadow" }),
                "mine": (bind: { "package::interface::shadow": "package::mine" }),
                "unbound": (),
            },
        ),
        "fog": (default: "off", values: { "off": (), "on": (features: ["FOG"]) }),
    },
    rules: [(exclude: { "fog": ["on"], "method": ["mine"] }, reason: "my method knows no fog")],
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
    import_no_module, PLAIN, [("main.wesl", "import package::interface::shadows::calc_shadow;\nconst A = 1;\n")];
    import_no_item, PLAIN, [("main.wesl", "import package::interface::shadow::calc_shadows;\nconst A = 1;\n")];
    import_no_package, PLAIN, [("main.wesl", "import dem::interface::shadow::calc_shadow;\nconst A = 1;\n")];
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
    axes_rule_of_no_axis, PLAIN, [("axes.ron", "(\n    axes: {\n        \"pass\": (values: { \"main\": (root: \"package::main\") }),\n    },\n    rules: [(exclude: { \"pas\": [\"main\"] }, reason: \"none\")],\n)\n")];
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

/// Two choices that ask for different things are no key.
#[test]
fn choices_that_contradict_each_other() {
    let axes = AXES.replace(
        "\"on\": (features: [\"FOG\"])",
        "\"on\": (bind: { \"package::interface::shadow\": \"package::mine\" })",
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
