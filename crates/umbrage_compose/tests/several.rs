//! Several keys in one shader: each has what it binds for itself, the pass's own side is there once.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use umbrage_compose::{BindingKind, Composer, Error, Key, Library, Package, Permutation, Target};

const AXES: &str = r#"(axes: {
    "pass": (values: {
        "all": (
            root: "package::main",
            each: "package::interface::lit",
            bind: { "package::interface::lit": "package::lit" },
        ),
        "one": (root: "package::main", bind: { "package::interface::lit": "package::lit" }),
        "alone": (root: "package::alone"),
        "asking": (
            root: "package::asking",
            each: "package::interface::asked",
            bind: { "package::interface::asked": "package::answer" },
        ),
    }),
    "light": (default: "sun", values: {
        "sun": (bind: { "package::interface::light": "package::sun" }),
        "lamp": (bind: { "package::interface::light": "package::lamp" }),
        "wide": (bind: { "package::interface::light": "package::wide" }),
    }),
    "noted": (default: "off", values: { "off": (), "on": (features: ["NOTED"]) }),
    "tinted": (default: "off", values: { "off": (), "on": (features: ["TINTED"]) }),
    "wide": (default: "off", values: { "off": (), "on": (features: ["WIDE"]) }),
})"#;

const FILES: &[(&str, &str)] = &[
    (
        "interface/lit.wesl",
        "fn add(place: vec2f, sum: ptr<function, vec3f>) {}\n",
    ),
    (
        "interface/light.wesl",
        "fn light(place: vec2f) -> vec3f { return vec3f(); }\n",
    ),
    ("interface/asked.wesl", "fn ask() -> f32 { return 0.0; }\n"),
    ("answer.wesl", "fn ask() -> f32 { return 1.0; }\n"),
    ("alone.wesl", "@fragment fn fs() {}\n"),
    (
        "asking.wesl",
        "import package::interface::asked::ask;\n@fragment fn fs() -> @location(0) vec4f {\n    return vec4f(ask());\n}\n",
    ),
    (
        "main.wesl",
        "import package::interface::lit::add;
import package::noted::note;
@if(TINTED) import package::shared::tint;
@group(0) @binding(0) var<uniform> frame: vec4f;
@fragment fn fs(@builtin(position) at: vec4f) -> @location(0) vec4f {
    note(at.x);
    var sum = frame.rgb;
    if at.x > 1.0 {
        add(at.xy, &sum);
    }
    @if(TINTED) sum *= tint(sum);
    return vec4f(sum, 1.0);
}
",
    ),
    (
        "lit.wesl",
        "import package::interface::light::light;
fn add(place: vec2f, sum: ptr<function, vec3f>) {
    *sum += light(place);
}
",
    ),
    (
        "noted.wesl",
        "var<private> noted: f32;\nfn note(x: f32) { noted = x; }\nfn what_is_noted() -> f32 { return noted; }\n",
    ),
    (
        "shared.wesl",
        "fn tint(color: vec3f) -> vec3f { return color * vec3f(0.5, 0.25, 1.0); }\n",
    ),
    (
        "state.wesl",
        "var<private> calls: f32;\nfn count() -> f32 { calls += 1.0; return calls; }\n",
    ),
    (
        "sun.wesl",
        "import package::shared::tint;
import package::state::count;
@if(NOTED) import package::noted::what_is_noted;
const WIDTH: f32 = @if(WIDE) 2.0 @else 1.0;
@group(1) @binding(0) var<uniform> color: vec3f;
fn light(place: vec2f) -> vec3f {
    @if(NOTED) return vec3f(what_is_noted());
    return tint(color) * count();
}
",
    ),
    // With a function and a variable that other keys' features do not give it.
    (
        "wide.wesl",
        "@if(WIDE) @group(1) @binding(3) var<uniform> width: vec3f;\n@if(WIDE) fn light(place: vec2f) -> vec3f { return width; }\n",
    ),
    (
        "lamp.wesl",
        "import package::shared::tint;
@group(1) @binding(0) var<uniform> color: vec3f;
@group(1) @binding(1) var cookie: texture_2d<f32>;
fn light(place: vec2f) -> vec3f {
    return tint(color) * textureLoad(cookie, vec2i(place), 0).rgb;
}
",
    ),
];

fn composer() -> Result<Composer, Error> {
    let files = FILES.iter().map(|(path, text)| {
        // `@else` stands on declarations alone.
        let text = text.replace(
            "const WIDTH: f32 = @if(WIDE) 2.0 @else 1.0;",
            "@if(WIDE) const WIDTH: f32 = 2.0;\n@if(!WIDE) const WIDTH: f32 = 1.0;",
        );
        ((*path).to_owned(), text)
    });
    let axes = [("axes.ron".to_owned(), AXES.to_owned())];
    let package = Package::from_sources("demo", "demo", files.chain(axes))?;
    Ok(Composer::new(Library::new([package])?, Target::webgpu()))
}

fn keys(composer: &Composer, texts: &[&str]) -> Result<Vec<Key>, Error> {
    let keys = texts.iter().map(|text| composer.library().parse_key(text));
    keys.collect()
}

fn all(texts: &[&str]) -> Result<std::sync::Arc<Permutation>, Error> {
    let composer = composer()?;
    let keys = keys(&composer, texts)?;
    Ok(composer.compose_all(&keys)?.permutation)
}

/// Names, instances and binding numbers of what is in a group.
fn bindings(permutation: &Permutation, group: u32) -> Vec<(&str, usize, u32)> {
    let bindings = permutation.reflection.bindings.iter();
    let own = bindings.filter(|binding| binding.group == group);
    own.map(|binding| (binding.name.as_str(), binding.instance, binding.binding))
        .collect()
}

#[test]
fn each_key_has_resources_of_its_own() -> Result<(), Error> {
    let permutation = all(&["pass=all", "pass=all,light=lamp", "pass=all,light=lamp"])?;
    assert_eq!(bindings(&permutation, 0), [("frame", 0, 0)]);
    assert_eq!(
        bindings(&permutation, 1),
        [
            ("color", 0, 0),
            ("cookie", 1, 1),
            ("color", 1, 2),
            ("color", 2, 3),
            ("cookie", 2, 4),
        ]
    );
    let texts: Vec<_> = permutation.keys().map(ToString::to_string).collect();
    assert_eq!(
        texts,
        ["pass=all", "light=lamp,pass=all", "light=lamp,pass=all"]
    );
    Ok(())
}

#[test]
fn each_key_is_called_in_turn_and_the_rest_is_there_once() -> Result<(), Error> {
    let permutation = all(&["pass=all", "pass=all,light=lamp", "pass=all"])?;
    insta::assert_snapshot!(permutation.wgsl()?);
    Ok(())
}

/// Notes of the pass that one key reads are kept, whichever key it is.
#[test]
fn what_any_key_reads_is_kept() -> Result<(), Error> {
    let text = |keys: &[&str]| all(keys)?.wgsl();
    assert!(!text(&["pass=all", "pass=all,light=lamp"])?.contains("noted"));
    for keys in [
        ["pass=all,noted=on", "pass=all,light=lamp"],
        ["pass=all,light=lamp", "pass=all,noted=on"],
    ] {
        let text = text(&keys)?;
        assert!(
            text.contains("noted = x") && text.contains("note(at.x)"),
            "{text}"
        );
    }
    Ok(())
}

/// A private variable of an instance is that instance's: each sun counts its own calls.
#[test]
fn private_variables_are_told_apart() -> Result<(), Error> {
    let permutation = all(&["pass=all", "pass=all"])?;
    let text = permutation.wgsl()?;
    assert_eq!(text.matches("var<private>").count(), 2, "{text}");
    let uniform = |b: &&umbrage_compose::Binding| matches!(b.kind, BindingKind::Uniform(_));
    let bindings = || permutation.reflection.bindings.iter();
    assert_eq!(bindings().filter(uniform).count(), 2);
    // The second one's is in storage.
    let blocks = bindings().filter(|b| b.kind.block().is_some());
    assert_eq!(blocks.count(), 3);
    Ok(())
}

/// Features are each key's own: what one key's module has under them, it has whatever the other keys choose.
#[test]
fn features_are_each_keys_own() -> Result<(), Error> {
    for keys in [
        ["pass=all", "pass=all,light=wide,wide=on"],
        ["pass=all,light=wide,wide=on", "pass=all"],
    ] {
        let permutation = all(&keys)?;
        let names: Vec<_> = bindings(&permutation, 1)
            .into_iter()
            .map(|(name, instance, _)| (name, instance))
            .collect();
        let wide = usize::from(keys[0] == "pass=all");
        assert!(names.contains(&("width", wide)) && names.contains(&("color", 1 - wide)));
    }
    Ok(())
}

#[test]
fn one_key_is_its_own_permutation() -> Result<(), Error> {
    let composer = composer()?;
    let keys = keys(&composer, &["pass=all,light=lamp"])?;
    let one = composer.compose(&keys[0])?.permutation;
    let all = composer.compose_all(&keys)?.permutation;
    assert!(std::sync::Arc::ptr_eq(&one, &all));
    // A pass that calls nothing in turn makes the same text.
    let plain = composer.library().parse_key("pass=one,light=lamp")?;
    assert_eq!(composer.compose(&plain)?.permutation.wgsl()?, one.wgsl()?);
    Ok(())
}

#[test]
fn it_is_made_once_and_kept() -> Result<(), Error> {
    use umbrage_compose::Source;
    let dir = tempfile::tempdir()
        .map_err(|e| panic!("{e}"))
        .unwrap_or_else(|()| unreachable!());
    let texts = ["pass=all", "pass=all,light=lamp"];
    // A choice that makes no difference to a lamp.
    let alike = ["pass=all", "pass=all,light=lamp,wide=on"];
    let first = composer()?.with_disk_cache(dir.path())?;
    assert_eq!(
        first.compose_all(&keys(&first, &texts)?)?.source,
        Source::Linked
    );
    assert_eq!(
        first.compose_all(&keys(&first, &texts)?)?.source,
        Source::Memory
    );
    assert_eq!(
        first.compose_all(&keys(&first, &alike)?)?.source,
        Source::Memory
    );
    let second = composer()?.with_disk_cache(dir.path())?;
    let loaded = second.compose_all(&keys(&second, &texts)?)?;
    assert_eq!(loaded.source, Source::Disk);
    assert_eq!(loaded.permutation.wgsl()?, all(&texts)?.wgsl()?);
    assert_eq!(loaded.permutation.others, all(&texts)?.others);
    let turned = [texts[1], texts[0]];
    assert_eq!(
        second.compose_all(&keys(&second, &turned)?)?.source,
        Source::Linked
    );
    Ok(())
}

#[test]
fn what_cannot_be_is_told() -> Result<(), Error> {
    let many = vec!["pass=all,light=lamp"; 17];
    let cases: &[(&str, &[&str])] = &[
        ("none", &[]),
        (
            "a pass that calls nothing in turn",
            &["pass=alone", "pass=alone"],
        ),
        ("two passes", &["pass=all", "pass=asking"]),
        ("two ways", &["pass=all,tinted=on", "pass=all"]),
        (
            "two ways, the other way round",
            &["pass=all", "pass=all,tinted=on"],
        ),
        ("a result", &["pass=asking", "pass=asking"]),
        ("too many", &many),
    ];
    let mut told = String::new();
    for (name, texts) in cases {
        match all(texts) {
            Ok(_) => panic!("{name} is composed"),
            Err(error) => told.push_str(&format!("# {name}\n{error}\n\n")),
        }
    }
    insta::assert_snapshot!(told);
    Ok(())
}
