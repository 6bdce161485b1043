//! Where RADV is missing these tests fail, and say what to install: it comes with Mesa's Vulkan drivers.

use std::fs;

use serde_json::{Value, json};
use tempfile::TempDir;

use super::{faulty_package, json, path_in, refusal, stderr, stdout, umbrage, umbrage_with, write};

const DEMO: &str = "permutations/demo.ron";
const BUDGET: &str = "permutations/budget.ron";

/// Some of the demo's permutations, which take a moment.
const SMALL: &str = r#"(
    packages: { "umbrage": "SHADERS" },
    keys: [
        { "pass": ["shadow_term"], "method": ["basic", "none"], "surface": All },
        { "pass": ["caster"], "alpha_test": All },
    ],
)"#;

fn small() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let shaders = super::root().join("shader_lib");
    let shaders = shaders.canonicalize().expect("a folder");
    let text = SMALL.replace("SHADERS", shaders.to_str().expect("UTF-8"));
    write(&folder, "small.ron", &text);
    folder
}

#[test]
fn the_demo_is_within_its_budget() {
    let output = umbrage(&["cost", DEMO, "--budget", BUDGET, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&output);
    assert_eq!(report["family"], "navi21");
    assert_eq!(report["over_budget"], json!([]));
    assert_eq!(report["failed"], json!([]));
    let rows = report["permutations"].as_array().expect("a list");
    let mut keys: Vec<_> = rows.iter().map(|row| row["key"].as_str()).collect();
    keys.dedup();
    let listed = json(&umbrage(&["list", DEMO, "--json"]));
    assert_eq!(listed["permutations"], keys.len(), "each once");
    for row in rows {
        for figure in [
            "instructions",
            "vgprs",
            "sgprs",
            "code_size",
            "latency",
            "inverse_throughput",
        ] {
            assert!(row[figure].as_u64() > Some(0), "{figure} of {row}");
        }
    }
    let stages = |key: &str| {
        let rows = rows.iter().filter(|row| row["key"] == key);
        rows.map(|row| row["stage"].clone()).collect::<Vec<Value>>()
    };
    assert_eq!(stages("pass=caster"), ["vertex"]);
    assert_eq!(stages("pass=base"), ["vertex", "fragment"]);
}

#[test]
fn the_same_bytes_whatever_is_set() {
    let folder = small();
    let manifest = path_in(&folder, "small.ron");
    let home = TempDir::new().expect("a folder");
    let home_path = home.path().to_str().expect("UTF-8");
    let plain = umbrage(&["cost", &manifest, "--json"]);
    let set = [
        ("RADV_DEBUG", "nongg"),
        ("RADV_PERFTEST", "pswave32"),
        ("ACO_DEBUG", "noopt"),
        ("RADV_FORCE_FAMILY", "vega10"),
        ("HOME", home_path),
        ("XDG_CACHE_HOME", home_path),
    ];
    let other = umbrage_with(&["cost", &manifest, "--json", "--family", "NAVI21"], &set);
    assert_eq!(plain.status.code(), Some(0), "{}", stderr(&plain));
    assert_eq!(stdout(&plain), stdout(&other), "{}", stderr(&other));
    assert_eq!(
        fs::read_dir(home.path()).expect("listed").count(),
        0,
        "nothing is kept"
    );
    assert_eq!(stderr(&plain), "");
}

#[test]
fn a_person_reads_a_table() {
    let folder = small();
    let output = umbrage(&["cost", &path_in(&folder, "small.ron"), "--family", "vega10"]);
    let lines: Vec<_> = stdout(&output).lines().collect();
    assert!(
        lines[0].contains("instructions") && lines[0].contains("vega10"),
        "{lines:?}"
    );
    // Sorted by key: two casters, of which one has no fragment stage, and two shadow terms.
    assert_eq!(lines.len(), 1 + 3 + 4, "{lines:?}");
    assert!(
        lines[1].contains("vertex") && lines[1].ends_with("alpha_test=on,pass=caster"),
        "{lines:?}"
    );
    assert!(
        lines[3].ends_with("method=basic,pass=shadow_term"),
        "{lines:?}"
    );
}

#[test]
fn over_budget() {
    let folder = small();
    let budget = r#"(rules: [
        (when: { "method": "basic", "surface": "ggx" }, stage: "fragment", max: (instructions: 100, latency: 99999)),
        (when: { "method": "none" }, stage: "fragment", max: (instructions: 100)),
    ])"#;
    write(&folder, "budget.ron", budget);
    let (manifest, budget) = (
        path_in(&folder, "small.ron"),
        path_in(&folder, "budget.ron"),
    );
    let output = umbrage(&["cost", &manifest, "--budget", &budget, "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let report = json(&output);
    let over = report["over_budget"].as_array().expect("a list");
    assert_eq!(over.len(), 1, "{over:?}");
    let rows = report["permutations"].as_array().expect("a list");
    let row = rows
        .iter()
        .find(|row| row["key"] == over[0]["key"] && row["stage"] == "fragment");
    assert_eq!(over[0]["key"], "method=basic,pass=shadow_term");
    assert_eq!(over[0]["figure"], "instructions");
    assert_eq!(over[0]["found"], row.expect("its row")["instructions"]);
    assert_eq!(over[0]["allowed"], 100);
    let line = stderr(&output)
        .lines()
        .find(|line| line.starts_with("over budget"));
    let line = line.expect("a line");
    for part in [
        "method=basic,pass=shadow_term",
        "fragment",
        "instructions",
        "100 allowed",
    ] {
        assert!(line.contains(part), "{line}");
    }
}

#[test]
fn what_has_no_pipeline_is_told_and_the_rest_goes_on() {
    let folder = faulty_package();
    let manifest = r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["main"] }])"#;
    write(&folder, "good.ron", manifest);
    let output = umbrage(&["cost", &path_in(&folder, "good.ron"), "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let report = json(&output);
    assert_eq!(report["failed"][0]["key"], "pass=main");
    assert!(
        stderr(&output).contains("vertex stage"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn what_cannot_be_used() {
    let folder = small();
    let manifest = path_in(&folder, "small.ron");
    let refused = |budget: &str| {
        write(&folder, "bad.ron", budget);
        refusal(&["cost", &manifest, "--budget", &path_in(&folder, "bad.ron")])
    };
    let said = refused("(rules: [\n (when: {}, stage: \"fragment\", max: (speed: 1)),\n])");
    assert!(
        said.contains("bad.ron:2:") && said.contains("speed"),
        "{said}"
    );
    let said = refused(
        "(rules: [\n (when: { \"light\": \"spot\" }, stage: \"fragment\", max: (vgprs: 1)),\n])",
    );
    assert!(
        said.contains("bad.ron:2:") && said.contains("fits no stage"),
        "{said}"
    );
    let said = refusal(&["cost", &manifest, "--budget", BUDGET, "--family", "vega10"]);
    assert!(said.contains("navi21") && said.contains("vega10"), "{said}");
    assert!(refusal(&["cost", "gone.ron"]).contains("gone.ron"));
    let said = refusal(&["cost", &manifest, "--family", "navi99"]);
    assert!(said.contains("navi99") && said.contains("navi21"), "{said}");
}

#[test]
fn no_driver() {
    let folder = small();
    let empty = TempDir::new().expect("a folder");
    let empty = empty.path().to_str().expect("UTF-8");
    let nowhere = [
        "HOME",
        "XDG_CONFIG_HOME",
        "XDG_CONFIG_DIRS",
        "XDG_DATA_HOME",
        "XDG_DATA_DIRS",
    ];
    let output = umbrage_with(
        &["cost", &path_in(&folder, "small.ron"), "--json"],
        &nowhere.map(|name| (name, empty)),
    );
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(stdout(&output), "");
    assert!(
        stderr(&output).contains("mesa-vulkan-drivers"),
        "{}",
        stderr(&output)
    );
}

/// One command checks permutations and holds their costs against a budget.
#[test]
fn a_check_keeps_the_budget_too() {
    let folder = small();
    let manifest = path_in(&folder, "small.ron");
    let budget = |instructions: u32| {
        let text = format!(
            r#"(rules: [(when: {{ "method": "basic" }}, stage: "fragment", max: (instructions: {instructions}))])"#
        );
        write(&folder, "budget.ron", &text);
        path_in(&folder, "budget.ron")
    };
    let check = |budget: &str| umbrage(&["check", &manifest, "--budget", budget, "--json"]);
    let output = check(&budget(100_000));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let output = check(&budget(100));
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let fault = &json(&output)["faults"][0];
    assert_eq!(fault["rule"], "budget");
    assert_eq!(fault["keys"], json!(["method=basic,pass=shadow_term"]));
    // A service shows it at the budget.
    assert!(
        fault["file"]
            .as_str()
            .expect("a file")
            .ends_with("budget.ron")
    );
    assert!(refusal(&["check", "--budget", BUDGET]).contains("--key"));
}
