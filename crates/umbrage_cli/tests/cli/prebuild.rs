//! `prebuild` and `merge`, as a build engineer runs them.

use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
    thread,
    time::Instant,
};

use serde_json::Value;
use tempfile::TempDir;
use umbrage::compose::Pack;

use super::{faulty_package, json, path_in, refusal, root, stderr, stdout, umbrage, write};

const DEMO: &str = "permutations/demo.ron";
const GOOD: &str = r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["main"], "light": All }])"#;

/// Runs prebuild, and gives what it says.
pub(super) fn prebuild(args: &[&str]) -> String {
    let output = umbrage(&[&["prebuild"], args].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stdout(&output), "");
    stderr(&output).to_owned()
}

fn bytes(path: &str) -> Vec<u8> {
    fs::read(path).expect("a file")
}

/// Names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name().into_string());
    let mut names: Vec<_> = names.map(|name| name.expect("UTF-8")).collect();
    names.sort();
    names
}

/// A package without faults, and a manifest of its keys.
fn good_package() -> (TempDir, String, String) {
    let folder = faulty_package();
    write(&folder, "good.ron", GOOD);
    let (manifest, out) = (path_in(&folder, "good.ron"), path_in(&folder, "out.pack"));
    (folder, manifest, out)
}

#[test]
fn each_permutation_once_in_all_languages() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "demo.pack");
    prebuild(&[DEMO, "--targets", "wgsl,spirv,msl,hlsl,glsl", "--out", &out]);
    let pack = Pack::open(&out).expect("a pack");
    let rows = pack.rows().expect("an index");
    let listed = json(&umbrage(&["list", DEMO, "--json"]));
    assert_eq!(Value::from(rows.len()), listed["permutations"]);
    for row in rows {
        let file = |kind: &str| pack.file(&row.files[kind]).expect("a file");
        let text = |kind: &str| String::from_utf8(file(kind)).expect("UTF-8");
        let wgsl = text("wgsl");
        assert!(naga::front::wgsl::parse_str(&wgsl).is_ok(), "{wgsl}");
        assert_eq!(file("spirv")[..4], 0x0723_0203_u32.to_le_bytes());
        let reflection: Value = serde_json::from_slice(&file("reflection")).expect("JSON");
        let entries = reflection["entry_points"].as_array().expect("a list");
        assert!(!entries.is_empty(), "{}", row.key);
        for entry in entries {
            let name = entry["name"].as_str().expect("a name");
            assert!(text("msl").contains(name) && text("hlsl").contains(name));
            let glsl = format!("glsl {name}");
            let lacking = row.lacks.keys().any(|language| language.name() == "glsl");
            assert!(
                lacking || text(&glsl).starts_with("#version 310 es"),
                "{}",
                row.key
            );
        }
    }
    // Files have the names of their contents, so that no two are the same.
    assert_eq!(names(folder.path()), ["demo.pack"]);
    // Ordinary tools open it as a zip archive.
    let mut zip = zip::ZipArchive::new(fs::File::open(&out).expect("a file")).expect("a zip");
    assert_eq!(zip.by_index(0).expect("an entry").name(), "pack.json");
}

#[test]
fn the_same_bytes_whatever_the_threads_manifests_and_shards() {
    let folder = TempDir::new().expect("a folder");
    let path = |name: &str| path_in(&folder, name);
    let (whole, other) = (path("whole.pack"), path("other.pack"));
    prebuild(&[DEMO, "--out", &whole]);
    prebuild(&[DEMO, "--jobs", "1", "--out", &other]);
    assert!(bytes(&whole) == bytes(&other), "threads");
    let parts = ["1/3", "2/3", "3/3"].map(|shard| {
        let out = path(&format!("{}.pack", shard.replace('/', "-")));
        prebuild(&[DEMO, "--shard", shard, "--out", &out]);
        out
    });
    let merged = path("merged.pack");
    let [one, two, three] = &parts;
    let output = umbrage(&["merge", three, one, two, "--out", &merged]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(bytes(&whole) == bytes(&merged), "shards");
    let counts = parts
        .each_ref()
        .map(|part| Pack::open(part).expect("a pack").len());
    assert!(counts.iter().all(|count| *count > 0), "{counts:?}");

    for (args, part) in [
        (&[one.as_str(), two][..], "no shard 3 of 3"),
        (&[one, two, two, three], "the same shard, 2 of 3"),
        (&[one, &whole], "no shard, but a whole pack"),
    ] {
        let said = refusal(&[&["merge"], args, &["--out", &path("never.pack")]].concat());
        assert!(said.contains(part), "{part}: {said}");
    }
    let stray = path("stray.pack");
    prebuild(&["--key", "pass=base", "--shard", "1/3", "--out", &stray]);
    let said = refusal(&["merge", &stray, two, three, "--out", &path("never.pack")]);
    assert!(said.contains("shards of different packs"), "{said}");
    assert!(!Path::new(&path("never.pack")).exists());
}

#[test]
fn an_edit_makes_anew_what_it_reaches() {
    let (folder, manifest, out) = good_package();
    let counts = |said: &str| {
        let output = json(&umbrage(&["prebuild", &manifest, "--out", &out, "--json"]));
        let found =
            ["permutations", "composed"].map(|name| output[name].as_u64().expect("a number"));
        assert!(found[0] > 0, "{said}");
        (found, output["unchanged"] == true)
    };
    assert_eq!(counts("new"), ([1, 1], false));
    let first = bytes(&out);
    assert_eq!(counts("unchanged"), ([1, 0], true));
    assert!(first == bytes(&out));
    // A module that nothing selected reaches: another library, the same permutation.
    write(
        &folder,
        "pkg/bad.wesl",
        "fn calc_shadow(position: vec3f) -> f32 { return 0.5; }\n",
    );
    assert_eq!(counts("elsewhere"), ([1, 0], false));
    write(
        &folder,
        "pkg/good.wesl",
        "fn calc_shadow(position: vec3f) -> f32 { return position.y; }\n",
    );
    assert_eq!(counts("edited"), ([1, 1], false));
    // An incremental pack has the bytes of one made from nothing.
    let kept = bytes(&out);
    fs::remove_file(&out).expect("removed");
    assert_eq!(counts("anew"), ([1, 1], false));
    assert!(
        kept == bytes(&out),
        "an incremental pack differs from a new one"
    );
}

#[test]
fn an_earlier_pack_that_is_damaged_is_made_anew() {
    let (_folder, manifest, out) = good_package();
    prebuild(&[&manifest, "--out", &out]);
    let whole = bytes(&out);
    let step = (whole.len() / 97).max(1);
    for cut in (0..whole.len()).step_by(step) {
        fs::write(&out, &whole[..cut]).expect("written");
        prebuild(&[&manifest, "--out", &out]);
        assert!(whole == bytes(&out), "cut at {cut}");
    }
}

#[test]
fn a_fault_leaves_no_file() {
    let folder = faulty_package();
    let before = names(folder.path());
    let out = path_in(&folder, "out.pack");
    let said = refusal(&["prebuild", &path_in(&folder, "all.ron"), "--out", &out]);
    assert!(said.contains("bad.wesl:2"), "{said}");
    write(
        &folder,
        "empty.ron",
        r#"(packages: { "pkg": "pkg" }, keys: [])"#,
    );
    assert!(refusal(&["prebuild", &path_in(&folder, "empty.ron"), "--out", &out]).contains("key"));
    fs::remove_file(folder.path().join("empty.ron")).expect("removed");
    assert_eq!(names(folder.path()), before);
}

#[test]
fn a_place_that_cannot_be_written() {
    let (folder, manifest, _) = good_package();
    write(&folder, "file", "");
    fs::create_dir(folder.path().join("folder.pack")).expect("a folder");
    for out in ["file", "file/below.pack", "gone/out.pack", "folder.pack"] {
        let out = path_in(&folder, out);
        let said = refusal(&["prebuild", &manifest, "--out", &out]);
        assert!(said.contains(&out), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_earlier_pack() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "out.pack");
    prebuild(&["--key", "pass=base", "--out", &out]);
    let before = bytes(&out);
    // Files of at most 512 bytes: the same write fails as on a full disk. The signal that comes with the
    // limit would end the process; a full disk sends none.
    let output = Command::new("sh")
        .args(["-c", r#"trap "" XFSZ; ulimit -f 1; exec "$0" "$@""#])
        .args([
            env!("CARGO_BIN_EXE_umbrage"),
            "prebuild",
            DEMO,
            "--out",
            &out,
        ])
        .current_dir(root())
        .output()
        .expect("a shell");
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("cannot be written"), "{said}");
    assert!(before == bytes(&out), "the pack changed");
    assert_eq!(names(folder.path()), ["out.pack"]);
}

/// A kill at any moment leaves a whole pack, the old or the new; the next run removes everything else.
#[cfg(unix)]
#[test]
fn a_kill_leaves_a_whole_pack() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "out.pack");
    let begun = Instant::now();
    prebuild(&[DEMO, "--out", &out]);
    let (whole_run, new) = (begun.elapsed(), bytes(&out));
    for turn in 0..12 {
        prebuild(&["--key", "pass=base", "--out", &out]);
        let old = bytes(&out);
        let mut child = Command::new(env!("CARGO_BIN_EXE_umbrage"))
            .args(["prebuild", DEMO, "--out", &out])
            .current_dir(root())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command starts");
        thread::sleep(whole_run * turn / 10);
        child.kill().expect("killed");
        child.wait().expect("an end");
        let found = bytes(&out);
        assert!(found == old || found == new, "turn {turn}");
    }
    prebuild(&[DEMO, "--out", &out]);
    assert!(bytes(&out) == new);
    assert_eq!(names(folder.path()), ["out.pack"]);
}

/// Overrides that a host sets: WGSL keeps them, the reflection lists them, and a message tells what other languages lose.
#[test]
fn overrides() {
    let (folder, manifest, out) = good_package();
    let built = |main: &str| {
        write(&folder, "pkg/main.wesl", main);
        let said = prebuild(&[&manifest, "--out", &out]);
        let pack = Pack::open(&out).expect("a pack");
        let row = pack.rows().expect("an index")[0].clone();
        let text = |kind: &str| {
            let file = pack.file(&row.files[kind]).expect("a file");
            String::from_utf8(file).expect("UTF-8")
        };
        let reflection: Value = serde_json::from_str(&text("reflection")).expect("JSON");
        (
            text("wgsl"),
            row.files.contains_key("spirv"),
            reflection,
            said,
        )
    };
    let (wgsl, has_spirv, reflection, said) = built(
        "override K1: f32 = 1.0;\noverride N: u32 = 4u;\nstruct P { K1: f32 }\n@group(0) @binding(0) var<uniform> p: P;\n\
         var<workgroup> tile: array<f32, N>;\n@group(0) @binding(1) var<storage, read_write> out: array<f32>;\n\
         @compute @workgroup_size(N * 2u) fn cs(@builtin(local_invocation_index) i: u32) {\n\
             tile[i % N] = p.K1 * K1;\n    workgroupBarrier();\n    out[i] = tile[0];\n}\n",
    );
    assert!(naga::front::wgsl::parse_str(&wgsl).is_ok(), "{wgsl}");
    for kept in [
        "override K1: f32 = 1f;",
        "    K1: f32,",
        "array<f32, N>",
        "@workgroup_size((N * 2u), 1, 1)",
    ] {
        assert!(wgsl.contains(kept), "no `{kept}` in\n{wgsl}");
    }
    assert!(has_spirv);
    assert_eq!(reflection["entry_points"][0]["workgroup_size"][0], 8);
    let overrides = reflection["overrides"].as_array().expect("a list");
    assert_eq!(overrides.len(), 2);
    assert_eq!(
        overrides[1],
        serde_json::json!({
            "name": "N", "id": null, "module": "pkg::main", "ty": "u32", "default": 4.0,
            "derived": false, "spirv": "fixed_at_default",
        })
    );
    assert!(
        said.contains("`K1`, `N` can be set in the WGSL alone"),
        "{said}"
    );

    // Without a default there is WGSL all the same.
    let (wgsl, has_spirv, reflection, said) = built(
        "override near: f32;\n@fragment fn fs_main() -> @location(0) vec4f { return vec4f(near); }\n",
    );
    assert!(wgsl.contains("override near: f32;"), "{wgsl}");
    assert!(!has_spirv);
    assert_eq!(reflection["overrides"][0]["spirv"], "not_written");
    assert!(
        said.contains("no spirv of 1 permutations") && said.contains("`near`"),
        "{said}"
    );
}
