//! The composer on the project's own shader library: projection, caches, bindings, determinism.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
    thread,
};

use umbrage_compose::{
    BindingKind, Composer, Key, Library, Manifest, Package, ProjectedKey, Source, Stage, Target,
};

fn library() -> Library {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shader_lib");
    let package = Package::load("umbrage", &dir).expect("the shader library is sound");
    Library::new([package]).expect("its axes are sound")
}

fn composer() -> Composer {
    Composer::new(library(), Target::webgpu())
}

fn key(library: &Library, choices: &[(&str, &str)]) -> Key {
    library
        .key(choices.iter().copied())
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_key_has_one_spelling() {
    let library = library();
    let one = key(
        &library,
        &[
            ("pass", "illumination"),
            ("pcf", "5"),
            ("light", "directional"),
        ],
    );
    let other = key(
        &library,
        &[
            ("pcf", "5"),
            ("alpha_test", "off"),
            ("pass", "illumination"),
        ],
    );
    assert_eq!(one, other);
    assert_eq!(one.to_string(), "pass=illumination,pcf=5");
}

#[test]
fn choices_that_make_no_difference_are_projected_away() {
    let composer = composer();
    let project = |choices: &[(&str, &str)]| {
        composer
            .project(&key(composer.library(), choices))
            .expect("it is sound")
            .to_string()
    };
    // A caster knows no light, method, surface or cookie.
    let caster = [
        ("pass", "caster"),
        ("light", "spot"),
        ("method", "basic"),
        ("surface", "ggx"),
        ("cookie", "on"),
        ("pcf", "7"),
    ];
    assert_eq!(project(&caster), "pass=caster");
    // Without an alpha test a caster needs no texture.
    assert_eq!(
        project(&[("pass", "caster"), ("base_color_texture", "on")]),
        "pass=caster"
    );
    // Without a method there is no filter.
    assert_eq!(
        project(&[("pass", "shadow_term"), ("pcf", "7"), ("light", "point")]),
        "pass=shadow_term"
    );
    // The bare shadow term out of a mask is the same of all lights.
    assert_eq!(
        project(&[
            ("pass", "shadow_term"),
            ("method", "mask"),
            ("light", "spot")
        ]),
        "method=mask,pass=shadow_term"
    );
    // A sun's map has no perspective.
    assert_eq!(
        project(&[
            ("pass", "shadow_term"),
            ("method", "basic"),
            ("light", "spot")
        ]),
        "light=spot,method=basic,pass=shadow_term"
    );
    assert_eq!(
        project(&[
            ("pass", "shadow_term"),
            ("method", "basic"),
            ("light", "point")
        ]),
        "light=point,method=basic,pass=shadow_term"
    );
}

/// Projection is sound and useful: keys of one projection link to the same shader, and keys of
/// different projections to different ones.
#[test]
fn projections_and_shaders_are_one_to_one() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../permutations/demo.ron");
    let manifest = Manifest::load(&path).unwrap_or_else(|error| panic!("{error}"));
    let composer = Composer::new(manifest.library().clone(), Target::webgpu());
    let mut shaders: BTreeMap<String, BTreeSet<ProjectedKey>> = BTreeMap::new();
    let variants = composer.select(manifest.selection());
    let keys: Vec<_> = variants.flat_map(|variant| variant.keys()).collect();
    for key in &keys {
        // A composer of its own has nothing from keys before.
        let fresh = Composer::new(manifest.library().clone(), Target::webgpu());
        let composed = fresh.compose(key).unwrap_or_else(|error| panic!("{error}"));
        let projected = composer.project(key).expect("it composes");
        assert_eq!(composed.permutation.key, projected);
        shaders
            .entry(composed.permutation.wgsl().expect("WGSL"))
            .or_default()
            .insert(projected);
    }
    let mut projected = 0;
    for keys in shaders.values() {
        assert_eq!(keys.len(), 1, "these are one shader: {keys:?}");
        projected += 1;
    }
    assert!(projected > 1 && projected < keys.len());
}

#[test]
fn memory_and_disk() {
    let dir = tempfile::tempdir().expect("a folder");
    let cached = || {
        composer()
            .with_disk_cache(dir.path())
            .expect("the folder can be written to")
    };
    let first = cached();
    let wanted = key(
        first.library(),
        &[
            ("pass", "illumination"),
            ("method", "basic"),
            ("light", "spot"),
        ],
    );
    let linked = first.compose(&wanted).expect("it is sound");
    assert_eq!(linked.source, Source::Linked);
    assert_eq!(
        first.compose(&wanted).expect("it is sound").source,
        Source::Memory
    );

    // Another process finds it, and it is the same.
    let found = cached().compose(&wanted).expect("it is sound");
    assert_eq!(found.source, Source::Disk);
    assert!(found.warnings.is_empty());
    assert_eq!(found.permutation.reflection, linked.permutation.reflection);
    assert_eq!(
        found.permutation.wgsl().expect("WGSL"),
        linked.permutation.wgsl().expect("WGSL")
    );
    assert_eq!(
        found.permutation.spirv().expect("SPIR-V"),
        linked.permutation.spirv().expect("SPIR-V")
    );
}

/// A damaged, cut or foreign entry is told of, dropped, and made anew.
#[test]
fn damaged_entries() {
    let dir = tempfile::tempdir().expect("a folder");
    let cached = || {
        composer()
            .with_disk_cache(dir.path())
            .expect("the folder can be written to")
    };
    let library = library();
    let wanted = key(&library, &[("pass", "caster")]);
    let other = key(&library, &[("pass", "base")]);
    cached().compose(&other).expect("it is sound");
    let foreign = entries(dir.path()).into_values().next().expect("an entry");
    cached().compose(&wanted).expect("it is sound");
    let (path, whole) = entries(dir.path())
        .into_iter()
        .find(|(_, bytes)| *bytes != foreign)
        .expect("an entry");

    let mut flipped = whole.clone();
    *flipped.last_mut().expect("bytes") ^= 1;
    let damages: [(&str, Vec<u8>); 5] = [
        ("hash", flipped),
        ("short", whole[..20].to_vec()),
        ("format", b"something else entirely".to_vec()),
        ("format", Vec::new()),
        ("key", foreign),
    ];
    for (word, bytes) in damages {
        fs::write(&path, bytes).expect("the entry can be written");
        let composed = cached().compose(&wanted).expect("damage does no harm");
        assert_eq!(composed.source, Source::Linked);
        let warning = composed.warnings.first().expect("it is told of");
        assert!(warning.contains(word), "{warning:?} does not say {word:?}");
        assert_eq!(fs::read(&path).expect("it is made anew"), whole);
    }
}

fn entries(dir: &Path) -> BTreeMap<std::path::PathBuf, Vec<u8>> {
    let entries = fs::read_dir(dir)
        .expect("the folder")
        .map(|entry| entry.expect("an entry").path());
    entries
        .map(|path| (path.clone(), fs::read(path).expect("a file")))
        .collect()
}

#[test]
fn a_cache_that_cannot_be() {
    let file = tempfile::NamedTempFile::new().expect("a file");
    let error = composer()
        .with_disk_cache(file.path())
        .map(drop)
        .expect_err("a file is no folder");
    assert!(error.to_string().contains("cannot be used"), "{error}");
}

/// Eight threads on one composer, and eight composers on one folder: the bytes are the same.
#[test]
fn many_at_once() {
    let dir = tempfile::tempdir().expect("a folder");
    let shared = composer();
    let keys: Vec<_> = ["1", "3", "5", "7"]
        .iter()
        .flat_map(|pcf| ["directional", "spot", "point"].map(|light| (*pcf, light)))
        .map(|(pcf, light)| {
            key(
                shared.library(),
                &[
                    ("pass", "illumination"),
                    ("method", "basic"),
                    ("pcf", pcf),
                    ("light", light),
                ],
            )
        })
        .collect();
    let all = |composer: &Composer, backwards: bool| {
        let mut words: Vec<Vec<u32>> = Vec::new();
        let order: Vec<_> = if backwards {
            keys.iter().rev().collect()
        } else {
            keys.iter().collect()
        };
        for key in order {
            let composed = composer
                .compose(key)
                .unwrap_or_else(|error| panic!("{error}"));
            assert!(composed.warnings.is_empty(), "{:?}", composed.warnings);
            words.push(composed.permutation.spirv().expect("SPIR-V"));
        }
        if backwards {
            words.reverse();
        }
        words
    };
    let expected = all(&composer(), false);
    thread::scope(|scope| {
        for index in 0..8 {
            let (all, shared, expected, dir) = (&all, &shared, &expected, dir.path());
            scope.spawn(move || {
                assert_eq!(all(shared, index % 2 == 0), *expected);
                let own = composer()
                    .with_disk_cache(dir)
                    .expect("the folder can be written to");
                assert_eq!(all(&own, index % 2 == 1), *expected);
            });
        }
    });
}

#[test]
fn bindings_belong_to_their_owners() {
    let composer = composer();
    let wanted = key(
        composer.library(),
        &[
            ("pass", "illumination"),
            ("method", "basic"),
            ("light", "spot"),
            ("cookie", "on"),
            ("base_color_texture", "on"),
        ],
    );
    let composed = composer.compose(&wanted).expect("it is sound");
    let reflection = &composed.permutation.reflection;
    let mut places = BTreeSet::new();
    for binding in &reflection.bindings {
        assert!(
            places.insert((binding.group, binding.binding)),
            "two resources in one place"
        );
        let group = match binding.module.as_str() {
            "umbrage::lights::spot" | "umbrage::methods::basic" | "umbrage::depths::nearest" => 1,
            "umbrage::common::material" => 2,
            _ => match binding.name.as_str() {
                "frame" => 0,
                "instances" | "drawn" => 3,
                other => panic!("whose is {other}?"),
            },
        };
        assert_eq!(binding.group, group, "{}", binding.name);
    }
    let named = |name: &str| {
        let found = reflection
            .bindings
            .iter()
            .find(|binding| binding.name == name);
        found.unwrap_or_else(|| panic!("no {name}"))
    };
    assert_eq!(
        named("shadow_sampler").kind,
        BindingKind::Sampler { comparison: true }
    );
    assert_eq!(named("instances").stages, [Stage::Vertex]);
    let BindingKind::Uniform(light) = &named("light").kind else {
        panic!("the light is a uniform")
    };
    let cookie = light
        .members
        .iter()
        .find(|member| member.name == "cookie_matrix");
    assert_eq!(
        cookie.map(|member| (member.offset, member.size)),
        Some((48, 64))
    );
}

/// Only what is needed arrives: names that must not be in a permutation's text.
#[test]
fn what_is_not_needed_is_not_there() {
    let composer = composer();
    let text = |choices: &[(&str, &str)]| {
        let key = key(composer.library(), choices);
        composer
            .compose(&key)
            .expect("it is sound")
            .permutation
            .wgsl()
            .expect("WGSL")
    };
    // The pass's notes for methods are gone where none asks for them, derivatives and all.
    let unshadowed = text(&[("pass", "shadow_term")]);
    assert!(
        !unshadowed.contains("note_receiver") && !unshadowed.contains("dpdx"),
        "{unshadowed}"
    );
    let constant = text(&[
        ("pass", "shadow_term"),
        ("method", "basic"),
        ("receiver_bias", "constant"),
    ]);
    assert!(
        !constant.contains("dpdx") && !constant.contains("plane_to_map"),
        "{constant}"
    );
    let plane = text(&[("pass", "shadow_term"), ("method", "basic")]);
    assert!(
        plane.contains("dpdx") && plane.contains("plane_to_map"),
        "{plane}"
    );
    let caster = text(&[("pass", "caster")]);
    assert!(!caster.contains("@fragment"), "{caster}");
    assert!(!caster.contains("material"), "{caster}");
}

/// The linked text of each kind of permutation, for a person to read when it changes; naga reads it
/// again, and finds it valid.
#[test]
fn linked_text() {
    let composer = composer();
    let keys: [(&str, &[(&str, &str)]); 5] = [
        ("caster", &[("pass", "caster")]),
        (
            "caster_of_leaves",
            &[
                ("pass", "caster"),
                ("alpha_test", "on"),
                ("base_color_texture", "on"),
            ],
        ),
        (
            "shadow_term_sun",
            &[
                ("pass", "shadow_term"),
                ("method", "basic"),
                ("receiver_bias", "constant"),
            ],
        ),
        (
            "shadow_term_point",
            &[
                ("pass", "shadow_term"),
                ("method", "basic"),
                ("light", "point"),
                ("pcf", "5"),
            ],
        ),
        (
            "illumination",
            &[
                ("pass", "illumination"),
                ("surface", "ggx"),
                ("light", "spot"),
                ("cookie", "on"),
            ],
        ),
    ];
    for (name, choices) in keys {
        let key = key(composer.library(), choices);
        let text = composer
            .compose(&key)
            .expect("it is sound")
            .permutation
            .wgsl()
            .expect("WGSL");
        let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{error}"));
        let capabilities = Target::webgpu().capabilities();
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
            .validate(&module)
            .unwrap_or_else(|error| panic!("{error:?}"));
        insta::assert_snapshot!(name, text);
    }
}

/// The version in the cache's key is the one that is built with.
#[test]
fn nagas_version() {
    let lock = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../Cargo.lock");
    let lock = fs::read_to_string(lock).expect("the lock file");
    let packages = lock
        .split("[[package]]")
        .filter(|package| package.contains("name = \"naga\"\n"));
    let versions: Vec<_> = packages
        .filter_map(|package| package.split("version = \"").nth(1)?.split('"').next())
        .collect();
    assert!(
        versions.contains(&umbrage_compose::NAGA_VERSION),
        "the lock file has {versions:?}"
    );
    assert_eq!(versions.len(), 1, "two versions of naga: {versions:?}");
}

/// Both texts are the same once imports are blanked out, and so are the stand-ins.
#[test]
fn a_name_that_is_imported_from_two_places_is_told_apart() {
    let files = [
        (
            "axes.ron",
            r#"(axes: {
                "pass": (default: "main", values: { "main": (root: "package::main") }),
                "way": (default: "near", values: { "near": (), "far": (features: ["FAR"]) }),
            })"#,
        ),
        ("near.wesl", "fn depth() -> f32 { return 0.25; }"),
        ("far.wesl", "fn depth() -> f32 { return 0.75; }"),
        (
            "main.wesl",
            "@if(FAR) import package::far::depth;
            @if(!FAR) import package::near::depth;
            @fragment fn fs() -> @location(0) vec4f { return vec4f(depth()); }",
        ),
    ];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let package = Package::from_sources("demo", "demo", files).expect("a package");
    let library = Library::new([package]).expect("a library");
    for order in [["near", "far", "near"], ["far", "near", "far"]] {
        let composer = Composer::new(library.clone(), Target::webgpu());
        for way in order {
            let key = library.key([("way", way)]).expect("a key");
            let composed = composer.compose(&key).expect("composed");
            let text = composed.permutation.wgsl().expect("WGSL");
            assert_eq!(text.contains("0.25"), way == "near", "{way}: {text}");
            assert_eq!(text.contains("0.75"), way == "far", "{way}: {text}");
        }
    }
}

/// An engine has its own order of bind groups, and a package's modules know nothing of it.
#[test]
fn bind_groups_have_the_engines_numbers() {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shader_lib");
    let cache = tempfile::tempdir().expect("a folder");
    let groups = |numbers: &[(u32, u32)]| {
        let package = Package::load("umbrage", &dir).expect("the shader library is sound");
        let package = package.with_groups(numbers.iter().copied());
        let library = Library::new([package]).expect("its axes are sound");
        let choices = [
            ("pass", "illumination"),
            ("method", "basic"),
            ("light", "spot"),
        ];
        let key = key(&library, &choices);
        let composer = Composer::new(library, Target::webgpu());
        let composer = composer.with_disk_cache(cache.path()).expect("a folder");
        let permutation = composer.compose(&key).expect("linked").permutation;
        let text = permutation.wgsl().expect("text");
        let bindings = permutation.reflection.bindings.iter();
        let groups = bindings.map(|b| {
            let written = format!("@group({}) @binding({})", b.group, b.binding);
            assert!(text.contains(&written), "{written} of {} in {text}", b.name);
            (b.name.clone(), b.group)
        });
        groups.collect::<std::collections::BTreeMap<_, _>>()
    };
    let own = groups(&[]);
    assert_eq!((own["frame"], own["light"], own["material"]), (0, 1, 2));
    let turned = groups(&[(0, 3), (1, 0), (3, 1)]);
    for (name, group) in own {
        let expected = [3, 0, 2, 1][group as usize];
        assert_eq!(turned[&name], expected, "{name}");
    }
}
