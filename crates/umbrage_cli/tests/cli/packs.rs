//! Packs and records in use: what a renderer takes from a pack, and what it does with one that does not fit.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;
use umbrage::compose::{Composer, Key, Library, Manifest, Pack, Source, Target};

use super::{json, path_in, prebuild::prebuild, refusal, root, stderr, stdout, umbrage, write};

const SCENE: &str = "examples/scenes/bunny_sun.ron";

/// A picture, small, and the report of it.
fn render(folder: &TempDir, name: &str, more: &[&str]) -> (Vec<u8>, Value, String) {
    let out = path_in(folder, name);
    let args = ["render", SCENE, "--size", "64x36", "--json", "--out", &out];
    let output = umbrage(&[&args, more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stderr(&output).to_owned();
    (fs::read(&out).expect("a picture"), json(&output), said)
}

/// From a recorded run to a pack of what it used, to a run that composes nothing.
#[test]
fn a_recorded_run_makes_a_pack_that_the_next_composes_nothing_beside() {
    let folder = TempDir::new().expect("a folder");
    let (record, pack) = (path_in(&folder, "run.record"), path_in(&folder, "run.pack"));
    let (picture, first, _) = render(&folder, "first.png", &["--record", &record]);
    let used = first["permutations"]["composed"]
        .as_u64()
        .expect("a number");
    assert!(used > 2);
    // A second run adds nothing.
    let lines = fs::read_to_string(&record).expect("a record");
    render(&folder, "again.png", &["--record", &record]);
    assert_eq!(fs::read_to_string(&record).expect("a record"), lines);

    let keys: Vec<_> = lines
        .lines()
        .filter_map(|line| line.split(' ').next())
        .collect();
    assert_eq!(keys.len() as u64, used);
    let shaders = root().join("shader_lib").display().to_string();
    let manifest =
        |keys: &[&str]| format!("(packages: {{ \"umbrage\": {shaders:?} }}, keys: {keys:?})");
    write(&folder, "run.ron", &manifest(&keys));
    let run = path_in(&folder, "run.ron");
    let covered = json(&umbrage(&["cover", &record, &run, "--json"]));
    assert_eq!(
        (&covered["missing"], &covered["never_used"]),
        (
            &Value::from(Vec::<Value>::new()),
            &Value::from(Vec::<Value>::new())
        )
    );
    assert_eq!(covered["used"], used);

    prebuild(&[&run, "--out", &pack]);
    let (same, second, said) = render(&folder, "second.png", &["--pack", &pack]);
    assert!(picture == same, "the picture differs");
    assert_eq!(second["permutations"]["composed"], 0, "{said}");
    let from = second["permutations"]["used"].as_array().expect("a list");
    assert!(from.iter().all(|used| used["from"] == "pack"), "{second}");

    // A manifest that lacks one of them, and has another.
    let (lost, kept) = keys.split_first().expect("keys");
    write(
        &folder,
        "less.ron",
        &manifest(&[kept, &["pass=base"]].concat()),
    );
    let output = umbrage(&["cover", &record, &path_in(&folder, "less.ron"), "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let covered = json(&output);
    assert_eq!(covered["missing"], serde_json::json!([lost]));
    // A key that is legal no more, and a line that was cut short.
    fs::write(
        &record,
        format!(
            "{lines}pass=gone {}\npass=sha",
            &blake3::hash(b"pass=gone").to_hex()[..8]
        ),
    )
    .expect("written");
    let output = umbrage(&["cover", &record, &run]);
    let said = stderr(&output);
    assert_eq!((output.status.code(), stdout(&output)), (Some(1), ""));
    assert!(
        said.contains("unreachable: pass=gone") && said.contains("passed over"),
        "{said}"
    );
    // A run that goes on with it repairs the end.
    render(
        &folder,
        "third.png",
        &["--record", &record, "--method", "none"],
    );
    assert!(
        fs::read_to_string(&record)
            .expect("a record")
            .contains("\npass=sha\n")
    );

    // Where what is needed of it is damaged, that is told, and the picture is right.
    let whole = fs::read(&pack).expect("a pack");
    let mut flipped = whole.clone();
    let opened = Pack::open(&pack).expect("a pack");
    for row in opened.rows().expect("an index") {
        let ir = opened.file(&row.files["ir"]).expect("a file");
        let mut places = whole.windows(ir.len());
        let place = places
            .position(|bytes| bytes == ir)
            .expect("stored as it is");
        flipped[place + ir.len() / 2] ^= 0x55;
    }
    fs::write(&pack, &flipped).expect("written");
    let (same, third, said) = render(&folder, "flipped.png", &["--pack", &pack]);
    assert!(said.contains("run.pack cannot be used"), "{said}");
    assert!(picture == same, "the picture differs");
    assert_eq!(third["permutations"]["composed"], used, "{said}");
    fs::write(&pack, &whole[..whole.len() / 2]).expect("written");
    let said = refusal(&[
        "render",
        SCENE,
        "--pack",
        &pack,
        "--out",
        &path_in(&folder, "f.png"),
    ]);
    assert!(said.contains("no whole zip archive"), "{said}");
}

/// Every permutation of a pack is what composing gives, by its own key and by each key that it stands for.
#[test]
fn a_pack_gives_what_composing_gives() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "demo.pack");
    prebuild(&["permutations/demo.ron", "--out", &out]);
    let manifest = Manifest::load(&root().join("permutations/demo.ron")).expect("a manifest");
    let library = manifest.library().clone();
    let pack = std::sync::Arc::new(Pack::open(&out).expect("a pack"));
    let packed = Composer::new(library.clone(), Target::webgpu()).with_pack(pack);
    let linked = Composer::new(library, Target::webgpu());
    for variant in linked.select(manifest.selection()) {
        let keys = variant.keys();
        for key in keys.iter().take(3).chain([&Key::from(variant.key())]) {
            let found = packed.compose(key).expect("composes");
            let own = linked.compose(key).expect("composes");
            assert_ne!(found.source, Source::Linked, "{key}");
            let (found, own) = (found.permutation, own.permutation);
            assert_eq!(found.key, own.key);
            assert_eq!(found.reflection, own.reflection, "{key}");
            assert_eq!(
                found.wgsl().expect("WGSL"),
                own.wgsl().expect("WGSL"),
                "{key}"
            );
        }
    }
}

/// Of other sources, a pack gives those permutations whose own modules are the same, and no other.
#[test]
fn a_stale_pack_gives_no_other_shader() {
    let folder = super::faulty_package();
    write(
        &folder,
        "good.ron",
        r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["main"] }])"#,
    );
    let (manifest, out) = (path_in(&folder, "good.ron"), path_in(&folder, "out.pack"));
    prebuild(&[&manifest, "--out", &out]);
    let compose = || {
        let manifest = Manifest::load(manifest.as_ref()).expect("a manifest");
        let library: Library = manifest.library().clone();
        let key = library.key([("pass", "main")]).expect("a key");
        let pack = std::sync::Arc::new(Pack::open(&out).expect("a pack"));
        let composer = Composer::new(library, Target::webgpu()).with_pack(pack);
        composer.compose(&key).expect("composes")
    };
    assert_eq!(compose().source, Source::Pack);
    write(
        &folder,
        "pkg/bad.wesl",
        "fn calc_shadow(position: vec3f) -> f32 { return 0.5; }\n",
    );
    assert_eq!(compose().source, Source::Pack);
    write(
        &folder,
        "pkg/good.wesl",
        "fn calc_shadow(position: vec3f) -> f32 { return position.z; }\n",
    );
    let composed = compose();
    assert_eq!(composed.source, Source::Linked);
    assert!(
        composed
            .warnings
            .iter()
            .any(|told| told.contains("out.pack has no `pass=main`"))
    );
    assert!(composed.permutation.wgsl().expect("WGSL").contains(".z"));
}
