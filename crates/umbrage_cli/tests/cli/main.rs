//! The command as scripts see it: what it prints, where, and with which exit status.

mod arguments;
mod check;
mod compare;
mod cost;
mod explain;
mod link;
mod lints;
mod list;
mod packs;
mod prebuild;
mod render;
mod stress;
mod truth;

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
};

use serde_json::Value;
use tempfile::TempDir;

/// Runs the command in the workspace's root.
fn umbrage(args: &[&str]) -> Output {
    umbrage_with(args, &[])
}

fn umbrage_with(args: &[&str], environment: &[(&str, &str)]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_umbrage"))
        .args(args)
        .envs(environment.iter().copied())
        .current_dir(root())
        .stdin(Stdio::null())
        .output()
        .expect("the command starts")
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).expect("UTF-8")
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("UTF-8")
}

/// All of standard output as JSON.
fn json(output: &Output) -> Value {
    let error = |error| format!("{error} in {:?}: {}", stdout(output), stderr(output));
    serde_json::from_str(stdout(output))
        .map_err(error)
        .expect("JSON")
}

/// Runs the command with unusable arguments or input, and returns the paragraph that it says.
fn refusal(args: &[&str]) -> String {
    let output = umbrage(args);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {said}");
    assert_eq!(stdout(&output), "", "{args:?}");
    assert!(said.starts_with("error: "), "{args:?}: {said}");
    assert!(!said.contains("panicked"), "{args:?}: {said}");
    said.to_owned()
}

/// A folder with a package `pkg` of two methods and two lights, one combination of which is faulty,
/// and a manifest `all.ron` of all its keys.
fn faulty_package() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let files = [
        ("pkg/axes.ron", AXES),
        (
            "pkg/interface/shadow.wesl",
            "fn calc_shadow(position: vec3f) -> f32 { return 1.0; }\n",
        ),
        (
            "pkg/good.wesl",
            "fn calc_shadow(position: vec3f) -> f32 { return position.x; }\n",
        ),
        ("pkg/bad.wesl", BAD),
        ("pkg/main.wesl", MAIN),
        ("all.ron", MANIFEST),
    ];
    for (path, text) in files {
        write(&folder, path, text);
    }
    folder
}

fn write(folder: &TempDir, path: &str, text: &str) {
    let path = folder.path().join(path);
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    fs::write(path, text).expect("a file");
}

fn path_in(folder: &TempDir, path: &str) -> String {
    folder.path().join(path).to_str().expect("UTF-8").to_owned()
}

const AXES: &str = r#"(
    axes: {
        "pass": (doc: "what is drawn", values: { "main": (root: "package::main") }),
        "method": (
            doc: "how the shadow term is computed",
            default: "good",
            values: {
                "good": (bind: { "package::interface::shadow": "package::good" }),
                "bad": (bind: { "package::interface::shadow": "package::bad" }),
            },
        ),
        "light": (
            doc: "where light comes from",
            default: "sun",
            values: { "sun": (), "lamp": (features: ["LAMP"]) },
        ),
        "unread": (doc: "read by no module", default: "off", values: { "off": (), "on": (features: ["UNREAD"]) }),
    },
)
"#;

const BAD: &str = "\
fn calc_shadow(position: vec3f) -> f32 {
    @if(LAMP) let wrong: f32 = position;
    return position.x;
}
";

const MAIN: &str = "\
import package::interface::shadow::calc_shadow;

@fragment
fn fs_main(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    return vec4f(calc_shadow(clip.xyz));
}
";

const MANIFEST: &str = r#"(
    packages: { "pkg": "pkg" },
    keys: [{ "pass": ["main"], "method": All, "light": All, "unread": All }],
)
"#;
