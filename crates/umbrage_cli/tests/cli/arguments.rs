//! Arguments that cannot be used.

use super::{json, refusal, stderr, stdout, umbrage, umbrage_with};

const SCENE: &str = "examples/scenes/bunny_sun.ron";

#[test]
fn nothing_at_all() {
    assert_eq!(umbrage(&[]).status.code(), Some(2));
    assert_eq!(umbrage(&["--help"]).status.code(), Some(0));
}

#[test]
fn sizes() {
    for size in [
        "0x100", "100x0", "100", "x", "100x", "-1x100", "1e9x1", "NaNxNaN",
    ] {
        let said = refusal(&[
            "render",
            SCENE,
            &format!("--size={size}"),
            "--out",
            "never.png",
        ]);
        assert!(said.contains("such as 1280x720"), "{said}");
    }
}

#[test]
fn missing_and_unknown() {
    assert!(refusal(&["render", SCENE]).contains("--out"));
    assert!(refusal(&["render", "--out", "never.png"]).contains("<SCENE>"));
    assert!(
        refusal(&["render", SCENE, "--what", "heat", "--out", "never.png"]).contains("shadow-term")
    );
    assert!(refusal(&["prebuild", "--out", "never.pack"]).contains("MANIFEST"));
    assert!(refusal(&["check", "permutations/demo.ron", "--target", "gameboy"]).contains("webgpu"));
    assert!(refusal(&["prebuild", "permutations/demo.ron"]).contains("--out"));
    assert!(refusal(&["link", "x.wesl", "--bind", "interface"]).contains("INTERFACE=MODULE"));
    assert!(refusal(&["chek"]).contains("check"));
}

#[test]
fn the_adapter_has_a_name() {
    let output = umbrage(&["adapter"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stdout(&output).trim().lines().count(), 1);
}

#[test]
fn no_adapter() {
    // The loader is pointed to a driver that does not exist.
    let output = umbrage_with(&["adapter"], &[("VK_DRIVER_FILES", "/nonexistent.json")]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(stdout(&output), "");
    // These words are what xtask tells a machine without an adapter by.
    assert!(
        stderr(&output).contains("no Vulkan adapter was found"),
        "{}",
        stderr(&output)
    );
    assert!(
        stderr(&output).contains("mesa-vulkan-drivers"),
        "{}",
        stderr(&output)
    );
}

/// Mesa's complaints about a missing desktop session do not reach the user.
#[cfg(unix)]
#[test]
fn success_says_nothing_on_standard_error() {
    for session in [None, Some(""), Some("relative")] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_umbrage"));
        command.arg("adapter").env_remove("NODEVICE_SELECT");
        match session {
            Some(folder) => command.env("XDG_RUNTIME_DIR", folder),
            None => command.env_remove("XDG_RUNTIME_DIR"),
        };
        let output = command.output().expect("the command starts");
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert_eq!(stderr(&output), "", "{session:?}");
        assert!(!stdout(&output).is_empty());
    }
}

/// Errors carry their causes, and each is told once.
#[test]
fn no_cause_is_told_twice() {
    let folder = tempfile::TempDir::new().expect("a folder");
    super::write(&folder, "bad.wesl", "fn f( {");
    super::write(&folder, "half.ron", "(");
    super::write(&folder, "half.glb", "glTF");
    super::write(
        &folder,
        "lone.ron",
        r#"(objects: [(model: "gone.glb")], lights: [], camera: (position: (0, 1, 2), target: (0, 0, 0)))"#,
    );
    let path = |name: &str| super::path_in(&folder, name);
    let (bad, half, glb, lone) = (
        path("bad.wesl"),
        path("half.ron"),
        path("half.glb"),
        path("lone.ron"),
    );
    let out = path("out.png");
    let gone = path("gone/out.png");
    let cases: &[&[&str]] = &[
        &["render", SCENE, "--out", &out, "--setting", "resolutoin=4"],
        &["render", SCENE, "--out", &out, "--setting", "resolution=0"],
        &["render", SCENE, "--out", &out, "--method", "bassic"],
        &["render", SCENE, "--out", &out, "--axis", "filter=hard"],
        &["render", SCENE, "--out", &out, "--axis", "filtr=pcf"],
        &["render", SCENE, "--out", &out, "--size", "999999x1"],
        &["render", SCENE, "--out", &out, "--shaft-steps", "0"],
        &["render", SCENE, "--out", &gone],
        &["render", "gone.ron", "--out", &out],
        &["render", &half, "--out", &out],
        &["render", &glb, "--out", &out],
        &["render", &lone, "--out", &out],
        &["truth", "gone.ron", "--out", &out],
        &["truth", SCENE, "--out", &out, "--light", "9"],
        &["truth", SCENE, "--out", &out, "--light-size", "-1"],
        &["compare", "gone.ron", "--out", &path("report")],
        &["compare", SCENE, SCENE, "--out", &path("report")],
        &[
            "compare",
            SCENE,
            "--out",
            &path("report"),
            "--methods",
            "bassic",
        ],
        &[
            "compare",
            SCENE,
            "--out",
            &path("report"),
            "--configs",
            &half,
        ],
        &["stress", "--methods", "bassic"],
        &["stress", "--limits", &half],
        &["check", &half],
        &["check", "gone.ron"],
        &["list", "gone.ron"],
        &["prebuild", "gone.ron", "--out", &path("tree.pack")],
        &["prebuild", "permutations/demo.ron", "--out", &bad],
        &["cost", "gone.ron"],
        &["cost", "permutations/demo.ron", "--family", "gone"],
        &["cost", "permutations/demo.ron", "--budget", &half],
        &["link", &bad],
        &["link", "gone.wesl"],
    ];
    for case in cases {
        let said = refusal(case);
        let parts: Vec<_> = said
            .trim_start_matches("error: ")
            .split(": ")
            .map(str::trim)
            .filter(|part| part.len() > 12)
            .collect();
        for (index, part) in parts.iter().enumerate() {
            assert!(
                !parts[..index].contains(part),
                "`{part}` twice in {case:?}: {said}"
            );
        }
    }
}

/// Every command that is about permutations takes a key as faults print it.
#[test]
fn a_key_is_taken_as_it_is_printed() {
    const KEY: &str = "light=spot,method=basic,pass=shadow_term";
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out.pack").display().to_string();
    let said = |args: &[&str]| {
        let output = umbrage(args);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{args:?}: {}",
            stderr(&output)
        );
        stdout(&output).to_owned()
    };
    assert_eq!(
        json(&umbrage(&["check", "--key", KEY, "--json"]))["permutations"],
        1
    );
    let both = [
        "list",
        "--key",
        KEY,
        "--key",
        "pass=base",
        "--key",
        KEY,
        "--json",
    ];
    assert_eq!(json(&umbrage(&both))["keys"], 2);
    assert!(said(&["explain", KEY]).contains(KEY));
    assert!(said(&["link", "--key", KEY]).contains("fn fs_shadow_term"));
    assert!(said(&["cost", "--key", KEY]).contains(KEY));
    said(&["prebuild", "--key", KEY, "--out", &out]);
    let pack = umbrage::compose::Pack::open(&out).expect("a pack");
    assert_eq!(pack.rows().expect("an index")[0].key, KEY);

    let bad = "light=spto,pass=shadow_term";
    for args in [
        &["check", "--key", bad][..],
        &["list", "--key", bad],
        &["explain", bad],
        &["link", "--key", bad],
        &["cost", "--key", bad],
        &["prebuild", "--key", bad, "--out", &out],
    ] {
        let said = refusal(args);
        assert!(said.contains("did you mean `spot`"), "{args:?}: {said}");
    }
    assert!(refusal(&["check", "permutations/demo.ron", "--key", KEY]).contains("cannot be used"));
}
