use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    process::{Command, Stdio},
    thread,
    time::Instant,
};

use serde_json::Value;
use tempfile::TempDir;

use super::{faulty_package, path_in, refusal, root, stderr, stdout, umbrage, write};

fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).expect("a folder");
    entries
        .map(|entry| {
            let path = entry.expect("an entry").path();
            let name = path
                .file_name()
                .expect("a name")
                .to_string_lossy()
                .into_owned();
            (name, fs::read(path).expect("a file"))
        })
        .collect()
}

fn prebuild(manifests: &[&str], out: &str) {
    let mut args = vec!["prebuild"];
    args.extend(manifests);
    args.extend(["--out", out]);
    let output = umbrage(&args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stdout(&output), "");
}

#[test]
fn each_permutation_once_and_the_same_bytes_twice() {
    let folder = TempDir::new().expect("a folder");
    let (first, second) = (path_in(&folder, "first"), path_in(&folder, "second"));
    prebuild(&["permutations/demo.ron"], &first);
    // A manifest given twice adds nothing.
    prebuild(&["permutations/demo.ron", "permutations/demo.ron"], &second);
    let files = contents(Path::new(&first));
    assert!(
        files == contents(Path::new(&second)),
        "the two folders differ"
    );

    let index: Value = serde_json::from_slice(&files["index.json"]).expect("JSON");
    let permutations = index["permutations"].as_u64().expect("a number") as usize;
    assert_eq!(files.len(), 3 * permutations + 1);
    assert_eq!(index["format"], "umbrage prebuild 1");
    for (key, entry) in index["keys"].as_object().expect("keys") {
        let file = |kind: &str| &files[entry[kind].as_str().expect("a name")];
        let wgsl = std::str::from_utf8(file("wgsl")).expect("UTF-8");
        assert!(naga::front::wgsl::parse_str(wgsl).is_ok(), "{key}: {wgsl}");
        assert_eq!(file("spv")[..4], 0x0723_0203_u32.to_le_bytes(), "{key}");
        let reflection: Value = serde_json::from_slice(file("reflection")).expect("JSON");
        assert!(
            !reflection["entry_points"]
                .as_array()
                .expect("entry points")
                .is_empty(),
            "{key}"
        );
    }
    let left: Vec<_> = fs::read_dir(folder.path()).expect("a folder").collect();
    assert_eq!(left.len(), 2, "only the two folders are left: {left:?}");
}

#[test]
fn an_earlier_prebuild_is_replaced_and_nothing_else_is() {
    let folder = faulty_package();
    write(
        &folder,
        "good.ron",
        r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["main"] }])"#,
    );
    let (manifest, out) = (path_in(&folder, "good.ron"), path_in(&folder, "out"));
    prebuild(&[&manifest], &out);
    write(&folder, &format!("out/{:032x}.wgsl", 7), "");
    prebuild(&[&manifest], &out);
    assert_eq!(contents(Path::new(&out)).len(), 4);

    let said = refusal(&["prebuild", &manifest, "--out", &path_in(&folder, "pkg")]);
    assert!(said.contains("no prebuild"), "{said}");
    assert!(folder.path().join("pkg/axes.ron").is_file());
}

#[test]
fn what_only_looks_like_a_prebuild_stays() {
    let folder = faulty_package();
    write(
        &folder,
        "good.ron",
        r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["main"] }])"#,
    );
    let (manifest, out) = (path_in(&folder, "good.ron"), path_in(&folder, "out"));
    prebuild(&[&manifest], &out);
    let index = fs::read_to_string(folder.path().join("out/index.json")).expect("an index");
    let refused = |part: &str| {
        let before = contents(Path::new(&out));
        let said = refusal(&["prebuild", &manifest, "--out", &out]);
        assert!(
            said.contains("no prebuild") && said.contains("--out"),
            "{said}"
        );
        assert!(said.contains(part), "{part}: {said}");
        assert!(before == contents(Path::new(&out)), "{part}: files changed");
    };
    // Somebody's file among prebuild's own.
    for name in [
        "notes.txt",
        "logo.json",
        "0123456789ABCDEF0123456789ABCDEF.wgsl",
    ] {
        write(&folder, &format!("out/{name}"), "mine");
        refused(name);
        fs::remove_file(folder.path().join("out").join(name)).expect("removed");
    }
    fs::create_dir(folder.path().join(format!("out/{:032x}.spv", 7))).expect("a folder");
    let said = refusal(&["prebuild", &manifest, "--out", &out]);
    assert!(said.contains("no prebuild"), "{said}");
    fs::remove_dir(folder.path().join(format!("out/{:032x}.spv", 7))).expect("removed");
    // Somebody's index.
    for (other, part) in [
        ("{}".to_owned(), "index.json"),
        (index.replacen('{', r#"{ "title": "my site","#, 1), "title"),
        (
            index.replace("umbrage prebuild 1", "umbrage prebuild 0"),
            "prebuild 0",
        ),
        (index[..index.len() / 2].to_owned(), "index.json"),
    ] {
        write(&folder, "out/index.json", &other);
        refused(part);
    }
    fs::remove_file(folder.path().join("out/index.json")).expect("removed");
    refused("index.json");
    write(&folder, "out/index.json", &index);
    prebuild(&[&manifest], &out);
}

#[test]
fn a_fault_leaves_no_file() {
    let folder = faulty_package();
    let before = contents_of(&folder);
    let out = path_in(&folder, "out");
    let said = refusal(&["prebuild", &path_in(&folder, "all.ron"), "--out", &out]);
    assert!(said.contains("bad.wesl:2"), "{said}");
    write(
        &folder,
        "empty.ron",
        r#"(packages: { "pkg": "pkg" }, keys: [])"#,
    );
    assert!(refusal(&["prebuild", &path_in(&folder, "empty.ron"), "--out", &out]).contains("key"));
    fs::remove_file(folder.path().join("empty.ron")).expect("removed");
    assert_eq!(contents_of(&folder), before);
}

fn contents_of(folder: &TempDir) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder.path())
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

#[test]
fn a_folder_that_cannot_be_written() {
    let folder = faulty_package();
    write(
        &folder,
        "good.ron",
        r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["main"] }])"#,
    );
    write(&folder, "file", "");
    for out in ["file", "file/below"] {
        let out = path_in(&folder, out);
        let said = refusal(&["prebuild", &path_in(&folder, "good.ron"), "--out", &out]);
        assert!(said.contains(&out), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_earlier_prebuild() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "out");
    prebuild(&["permutations/demo.ron"], &out);
    let before = contents(Path::new(&out));
    // Files of at most 512 bytes: the same write fails as on a full disk. The signal that comes with the
    // limit would end the process; a full disk sends none.
    let output = Command::new("sh")
        .args(["-c", r#"trap "" XFSZ; ulimit -f 1; exec "$0" "$@""#])
        .args([env!("CARGO_BIN_EXE_umbrage"), "prebuild"])
        .args(["permutations/demo.ron", "--out", &out])
        .current_dir(root())
        .output()
        .expect("a shell");
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains(&out) && said.contains(".wgsl could not be written"),
        "{said}"
    );
    assert!(before == contents(Path::new(&out)), "the files changed");
    assert_eq!(contents_of(&folder), ["out"]);
}

/// A kill at any moment leaves a whole tree, the old or the new; the next run removes everything else.
#[cfg(unix)]
#[test]
fn a_kill_leaves_a_whole_prebuild() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "out");
    let begun = Instant::now();
    prebuild(&["permutations/demo.ron"], &out);
    let whole_run = begun.elapsed();
    let whole = contents(Path::new(&out));
    for turn in 0..12 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_umbrage"))
            .args(["prebuild", "permutations/demo.ron", "--out", &out])
            .current_dir(root())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command starts");
        thread::sleep(whole_run * turn / 10);
        child.kill().expect("killed");
        child.wait().expect("an end");
        assert!(whole == contents(Path::new(&out)), "turn {turn}");
    }
    prebuild(&["permutations/demo.ron"], &out);
    assert_eq!(contents_of(&folder), ["out"]);
}

/// Whenever it comes, before, while or after the files are written.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_a_whole_prebuild_or_none() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "out");
    let begun = Instant::now();
    prebuild(&["permutations/demo.ron"], &out);
    let whole_run = begun.elapsed();
    let whole = contents(Path::new(&out));
    let mut interrupted = 0;
    for turn in 0..12 {
        fs::remove_dir_all(&out).ok();
        let mut child = Command::new(env!("CARGO_BIN_EXE_umbrage"))
            .args(["prebuild", "permutations/demo.ron", "--out", &out])
            .current_dir(root())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command starts");
        thread::sleep(whole_run * turn / 10);
        Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .stderr(Stdio::null())
            .status()
            .expect("kill");
        let status = child.wait().expect("an end");
        // Before the command waits for it, the signal ends the process as it does any other.
        match status.code() {
            Some(0) => assert!(whole == contents(Path::new(&out)), "turn {turn}"),
            Some(130) | None => {
                interrupted += 1;
                if Path::new(&out).exists() {
                    assert!(whole == contents(Path::new(&out)), "turn {turn}");
                }
            }
            other => panic!("turn {turn}: status {other:?}"),
        }
        let left = contents_of(&folder);
        assert!(left.is_empty() || left == ["out"], "turn {turn}: {left:?}");
    }
    assert!(interrupted > 0, "no turn was interrupted");
}

/// Overrides that a host sets: WGSL keeps them, the reflection lists them, and a message tells what SPIR-V loses.
#[test]
fn overrides() {
    let folder = faulty_package();
    write(
        &folder,
        "good.ron",
        r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["main"] }])"#,
    );
    let (manifest, out) = (path_in(&folder, "good.ron"), path_in(&folder, "out"));
    let built = |main: &str| {
        write(&folder, "pkg/main.wesl", main);
        let checked = umbrage(&["check", &manifest]);
        assert_eq!(checked.status.code(), Some(0), "{}", stderr(&checked));
        let output = umbrage(&["prebuild", &manifest, "--out", &out]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let files = contents(Path::new(&out));
        let index: Value = serde_json::from_slice(&files["index.json"]).expect("JSON");
        let entry = index["keys"]["pass=main"].clone();
        let text = |kind: &str| {
            let file = &files[entry[kind].as_str().expect("a name")];
            String::from_utf8(file.clone()).expect("UTF-8")
        };
        let reflection: Value = serde_json::from_str(&text("reflection")).expect("JSON");
        let said = stderr(&output).to_owned();
        (text("wgsl"), entry["spv"].clone(), reflection, said)
    };

    let (wgsl, spv, reflection, said) = built(
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
    assert!(spv.is_string());
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
    let (wgsl, spv, reflection, said) = built(
        "override near: f32;\n@fragment fn fs_main() -> @location(0) vec4f { return vec4f(near); }\n",
    );
    assert!(wgsl.contains("override near: f32;"), "{wgsl}");
    assert!(spv.is_null());
    assert_eq!(reflection["overrides"][0]["spirv"], "not_written");
    assert!(
        said.contains("no SPIR-V of ") && said.contains("`near`"),
        "{said}"
    );
}
