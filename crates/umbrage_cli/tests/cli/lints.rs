//! Lints: what is valid and yet likely not meant, told as warnings, denied or allowed.

use serde_json::Value;
use tempfile::TempDir;

use super::{faulty_package, json, path_in, refusal, stderr, umbrage, write};

/// A package without a fault, with something for each lint.
fn suspect_package() -> TempDir {
    let folder = faulty_package();
    write(
        &folder,
        "pkg/bad.wesl",
        "fn calc_shadow(position: vec3f) -> f32 { return position.z; }\nfn reach() -> f32 { return 3.0; }\n",
    );
    write(
        &folder,
        "pkg/interface/shadow.wesl",
        "fn calc_shadow(position: vec3f) -> f32 { return 1.0; }\nfn reach() -> f32 { return 1.0; }\n",
    );
    let projected = "\
@group(0) @binding(0) var<uniform> to_map: mat4x4f;
@group(0) @binding(1) var<uniform> forgotten: vec4f;
fn reach() -> f32 { return 2.0; }
fn calc_shadow(position: vec3f) -> f32 {
    let place = to_map * vec4f(position, 1.0);
    let at = place.xyz / place.w;
    return at.z;
}
";
    write(&folder, "pkg/good.wesl", projected);
    folder
}

fn lints(args: &[&str]) -> Vec<(String, u64, String)> {
    let output = umbrage(&[&["check", "--json"], args].concat());
    let report = json(&output);
    let lints = report["lints"].as_array().expect("a list").iter();
    let text = |value: &Value| value.as_str().expect("a text").to_owned();
    lints
        .map(|lint| {
            let line = lint["line"].as_u64().expect("a line");
            (text(&lint["rule"]), line, text(&lint["level"]))
        })
        .collect()
}

#[test]
fn each_lint_finds_its_own() {
    let folder = suspect_package();
    let package = path_in(&folder, "pkg");
    let warning = |rule: &str, line| (rule.to_owned(), line, "warning".to_owned());
    let all = [
        warning("division_by_w", 6),
        warning("unreachable_function", 2),
        warning("unused_binding", 2),
    ];
    assert_eq!(lints(&["--package", &package]), all);
    let output = umbrage(&["check", "--package", &package]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("let at = place.xyz / place.w;"),
        "{}",
        stderr(&output)
    );
    // Of some keys it cannot be said what no other uses.
    let some = path_in(&folder, "all.ron");
    assert_eq!(lints(&[&some]), all[..1]);
}

#[test]
fn a_lint_is_denied_or_allowed() {
    let folder = suspect_package();
    let package = path_in(&folder, "pkg");
    let status = |args: &[&str]| {
        let args = [&["check", "--package", &package], args].concat();
        umbrage(&args).status.code()
    };
    assert_eq!(status(&["--deny", "division_by_w"]), Some(1));
    assert_eq!(status(&["--deny", "too_many_varyings"]), Some(0));
    let allowed = lints(&["--package", &package, "--allow", "division_by_w"]);
    assert_eq!(allowed.len(), 2, "{allowed:?}");
    assert!(refusal(&["check", "--deny", "divison_by_w"]).contains("division_by_w"));
    let both = [
        "check",
        "--deny",
        "unused_binding",
        "--allow",
        "unused_binding",
    ];
    assert!(refusal(&both).contains("choose one"));
}

#[test]
fn a_comparison_or_a_filter_is_an_answer() {
    let folder = suspect_package();
    let good = path_in(&folder, "pkg/good.wesl");
    let text = std::fs::read_to_string(&good).expect("a module");
    let manifest = path_in(&folder, "all.ron");
    assert_eq!(lints(&[&manifest]).len(), 1);
    let compared = text.replace(
        "    let at =",
        "    if !(place.w > 0.0) { return 1.0; }\n    let at =",
    );
    write(&folder, "pkg/good.wesl", &compared);
    assert_eq!(lints(&[&manifest]), []);
    let filter = "@diagnostic(off, umbrage.division_by_w)\nfn calc_shadow";
    let filtered = text.replace("fn calc_shadow", filter);
    write(&folder, "pkg/good.wesl", &filtered);
    assert_eq!(lints(&[&manifest]), []);
    write(&folder, "pkg/good.wesl", &filtered.replace("by_w", "by_v"));
    let output = umbrage(&["check", &manifest]);
    assert!(
        stderr(&output).contains("did you mean `division_by_w`?"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn variables_that_some_target_does_not_take_are_told() {
    let folder = suspect_package();
    let members: String = (0..16)
        .map(|at| format!("@location({at}) a{at}: f32, "))
        .collect();
    let main = format!(
        "struct Out {{ @builtin(position) clip: vec4f, {members} }}\n@vertex\nfn vs_main() -> Out {{ return Out(); }}\n"
    );
    write(&folder, "pkg/main.wesl", &main);
    let manifest = path_in(&folder, "all.ron");
    let found = lints(&[&manifest]);
    assert_eq!(
        found,
        [("too_many_varyings".to_owned(), 3, "warning".to_owned())]
    );
    // For such a target it is a fault.
    let output = umbrage(&["check", &manifest, "--target", "gles"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
}
