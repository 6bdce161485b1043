use std::fs;

use serde_json::json;
use tempfile::TempDir;

use super::{faulty_package, json, path_in, refusal, stderr, stdout, umbrage, write};

#[test]
fn the_demo_is_faultless() {
    let output = umbrage(&["check", "permutations/demo.ron", "--json"]);
    let report = json(&output);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(report["failed"], 0);
    assert_eq!(report["faults"], json!([]));
    let count = |name: &str| report[name].as_u64().expect("a number");
    assert!(
        count("permutations") > 0 && count("keys") >= count("permutations"),
        "{report}"
    );
}

#[test]
fn the_whole_space_is_faultless() {
    let output = umbrage(&["check", "--json"]);
    let report = json(&output);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(
        (&report["failed"], &report["faults"], &report["warnings"]),
        (&json!(0), &json!([]), &json!([]))
    );
    assert_eq!(report["lints"], json!([]));
    // More than a million permutations of many more keys.
    assert!(
        report["permutations"].as_u64() > Some(1_000_000),
        "{report}"
    );
    assert!(report["keys"].as_u64() > Some(500_000_000), "{report}");
}

#[test]
fn a_fault_is_told_once_with_its_cause() {
    let folder = faulty_package();
    let output = umbrage(&["check", &path_in(&folder, "all.ron"), "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let report = json(&output);
    assert_eq!(report["keys"], 8);
    assert_eq!(
        report["permutations"], 3,
        "`unread` changes nothing, `light` only what `bad` is"
    );
    assert_eq!(report["failed"], 2);
    let faults = report["faults"].as_array().expect("faults");
    assert_eq!(faults.len(), 1, "{report}");
    let fault = &faults[0];
    assert_eq!(fault["line"], 2, "{fault}");
    assert!(fault["column"].as_u64().expect("a column") > 1);
    assert!(
        fault["file"]
            .as_str()
            .expect("a file")
            .ends_with("bad.wesl")
    );
    assert!(!fault["message"].as_str().expect("a message").is_empty());
    assert_eq!(
        fault["keys"],
        json!([
            "light=lamp,method=bad,pass=main",
            "light=lamp,method=bad,pass=main,unread=on"
        ])
    );
    assert_eq!(fault["cause"], "light=lamp, method=bad");
}

/// A package is checked whole: what is found is what a manifest of all its keys finds.
#[test]
fn a_package_needs_no_manifest() {
    let folder = faulty_package();
    let by_manifest = umbrage(&["check", &path_in(&folder, "all.ron"), "--json"]);
    let output = umbrage(&["check", "--package", &path_in(&folder, "pkg"), "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert_eq!(json(&output), json(&by_manifest));
    write(
        &folder,
        "whole.ron",
        r#"(packages: { "pkg": "pkg" }, keys: All)"#,
    );
    let output = umbrage(&["check", &path_in(&folder, "whole.ron"), "--json"]);
    assert_eq!(json(&output), json(&by_manifest));
    let both = [
        "check",
        &path_in(&folder, "all.ron"),
        "--package",
        &path_in(&folder, "pkg"),
    ];
    assert!(refusal(&both).contains("cannot be used with"));
}

/// A manifest may name keys as they are printed, such as those that a run recorded.
#[test]
fn keys_are_text_in_manifests() {
    let folder = faulty_package();
    let manifest = |keys: &str| {
        let text = format!("(packages: {{ \"pkg\": \"pkg\" }}, keys: [\n    {keys},\n])");
        write(&folder, "some.ron", &text);
        path_in(&folder, "some.ron")
    };
    let path = manifest(r#""light=lamp,method=bad,pass=main", "pass=main", { "pass": All }"#);
    let report = json(&umbrage(&["check", &path, "--json"]));
    assert_eq!(
        (&report["keys"], &report["permutations"]),
        (&json!(2), &json!(2))
    );
    assert_eq!(
        report["faults"][0]["keys"],
        json!(["light=lamp,method=bad,pass=main"])
    );
    let said = refusal(&["check", &manifest(r#""lihgt=lamp,pass=main""#)]);
    assert!(
        said.contains("did you mean `light`?") && said.contains("some.ron:2:5"),
        "{said}"
    );
    let said = refusal(&["check", &manifest(r#""light=lamp""#)]);
    assert!(
        said.contains("`pass`") && said.contains("some.ron:2:5"),
        "{said}"
    );
}

#[test]
fn a_person_reads_the_source_line() {
    let folder = faulty_package();
    let output = umbrage(&["check", &path_in(&folder, "all.ron")]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(stdout(&output), "");
    let said = stderr(&output);
    assert!(said.contains("let wrong: f32 = position;"), "{said}");
    assert!(said.contains("fails when light=lamp, method=bad"), "{said}");
}

/// Each format tells the same fault, at its place, with its cause.
#[test]
fn services_read_what_they_know() {
    let folder = faulty_package();
    let manifest = path_in(&folder, "all.ron");
    let printed = |format: &str| {
        let output = umbrage(&["check", &manifest, "--format", format]);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        stdout(&output).to_owned()
    };
    assert_eq!(printed("text"), "");
    assert_eq!(
        printed("json"),
        stdout(&umbrage(&["check", &manifest, "--json"]))
    );

    let annotations = printed("github");
    let lines: Vec<_> = annotations.lines().collect();
    // The package sets a feature that no module asks for.
    assert_eq!(lines.len(), 2, "{annotations}");
    assert!(
        lines[1].starts_with("::warning::unread=on"),
        "{annotations}"
    );
    let (properties, message) = lines[0]
        .strip_prefix("::error ")
        .and_then(|line| line.split_once("::"))
        .expect("an annotation");
    assert!(
        properties.contains("bad.wesl,line=2,col=") && properties.contains("title=umbrage%3A type"),
        "{properties}"
    );
    assert!(
        message.ends_with("%0Afails when light=lamp, method=bad, in 1 permutation of 2 keys"),
        "{message}"
    );

    let log: serde_json::Value = serde_json::from_str(&printed("sarif")).expect("JSON");
    assert_eq!(log["version"], "2.1.0");
    let run = &log["runs"][0];
    assert_eq!(run["tool"]["driver"]["name"], "umbrage");
    let results = run["results"].as_array().expect("results");
    assert_eq!(results.len(), 1, "{run}");
    let result = &results[0];
    let index = result["ruleIndex"].as_u64().expect("an index") as usize;
    assert_eq!(
        result["ruleId"],
        run["tool"]["driver"]["rules"][index]["id"]
    );
    assert_eq!(result["level"], "error");
    assert_eq!(result["properties"]["cause"], "light=lamp, method=bad");
    let place = &result["locations"][0]["physicalLocation"];
    assert_eq!(place["region"]["startLine"], 2);
    let uri = place["artifactLocation"]["uri"].as_str().expect("a place");
    assert!(uri.ends_with("pkg/bad.wesl"), "{uri}");

    let tests = quick_junit::Report::deserialize_from_str(&printed("junit")).expect("JUnit");
    assert_eq!((tests.tests, tests.failures), (1, 1));
    let case = &tests.test_suites[0].test_cases[0];
    assert!(case.name.as_str().contains("bad.wesl:2:"), "{case:?}");
}

/// Where all is well, a service is told so, in its own form.
#[test]
fn services_read_that_all_is_well() {
    let printed = |format: &str| {
        let output = umbrage(&["check", "--key", "pass=base", "--format", format]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stdout(&output).to_owned()
    };
    assert_eq!(printed("github"), "");
    let log: serde_json::Value = serde_json::from_str(&printed("sarif")).expect("JSON");
    assert_eq!(log["runs"][0]["results"], json!([]));
    let tests = quick_junit::Report::deserialize_from_str(&printed("junit")).expect("JUnit");
    assert_eq!((tests.tests, tests.failures), (1, 0));
}

#[test]
fn the_exit_status_is_told() {
    let help = umbrage(&["check", "--help"]);
    let told = stdout(&help)
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    assert!(
        told.contains("0 all is well") && told.contains("2 the check could not be carried out"),
        "{told}"
    );
    assert!(refusal(&["check", "--format", "xml"]).contains("sarif"));
}

#[test]
fn targets_differ_in_what_they_allow() {
    let folder = faulty_package();
    let manifest =
        r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["main"] }], target: "TARGET")"#;
    write(&folder, "webgpu.ron", &manifest.replace("TARGET", "webgpu"));
    write(&folder, "vulkan.ron", &manifest.replace("TARGET", "vulkan"));
    write(
        &folder,
        "gameboy.ron",
        &manifest.replace("TARGET", "gameboy"),
    );
    let doubles = "fn calc_shadow(position: vec3f) -> f32 { return f32(f64(position.x)); }\n";
    write(&folder, "pkg/good.wesl", doubles);
    write(
        &folder,
        "doubles.ron",
        "(\n    capabilities: [\"FLOAT64\"],\n)\n",
    );
    write(
        &folder,
        "own.ron",
        &manifest.replace("TARGET", "doubles.ron"),
    );
    let status = |args: &[&str]| umbrage(&[&["check"], args].concat()).status.code();
    let (webgpu, vulkan, own) = (
        path_in(&folder, "webgpu.ron"),
        path_in(&folder, "vulkan.ron"),
        path_in(&folder, "own.ron"),
    );
    // No table but the last has 64-bit floats; software Vulkan has them.
    for target in ["webgpu", "vulkan", "metal", "dx12", "gles"] {
        assert_eq!(status(&[&webgpu, "--target", target]), Some(1), "{target}");
    }
    assert_eq!(status(&[&vulkan]), Some(1));
    assert_eq!(status(&[&vulkan, "--target", "this"]), Some(0));
    assert_eq!(status(&[&own]), Some(0));
    assert_eq!(status(&[&own, "--target", "webgpu"]), Some(1));
    let doubles = path_in(&folder, "doubles.ron");
    assert_eq!(status(&[&webgpu, "--target", &doubles]), Some(0));
    write(
        &folder,
        "doubles.ron",
        "(\n    capabilities: [\"FLOAT46\"],\n)\n",
    );
    let said = refusal(&["check", &own]);
    assert!(
        said.contains("doubles.ron:2:20") && said.contains("did you mean `FLOAT64`?"),
        "{said}"
    );
    let said = refusal(&["check", &path_in(&folder, "gameboy.ron")]);
    assert!(
        said.contains("gameboy") && said.contains("webgpu, vulkan"),
        "{said}"
    );
    let said = refusal(&["check", &webgpu, "--target", "metla"]);
    assert!(said.contains("did you mean `metal`?"), "{said}");
}

#[test]
fn a_module_that_is_no_wesl_is_a_finding() {
    let folder = faulty_package();
    write(
        &folder,
        "pkg/good.wesl",
        "fn calc_shadow(position: vec3f -> f32 {}\n",
    );
    let output = umbrage(&["check", &path_in(&folder, "all.ron"), "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let report = json(&output);
    let faults = report["faults"].as_array().expect("faults");
    assert!(faults.iter().any(|fault| {
        fault["file"]
            .as_str()
            .is_some_and(|f| f.ends_with("good.wesl"))
    }));
}

#[test]
fn several_manifests_are_one_report() {
    let folder = faulty_package();
    let faulty = path_in(&folder, "all.ron");
    let output = umbrage(&["check", &faulty, "permutations/demo.ron", &faulty, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let report = json(&output);
    assert_eq!(report["faults"].as_array().expect("faults").len(), 1);
    assert_eq!(report["failed"], 4);
    assert_eq!(report["faults"][0]["cause"], "light=lamp, method=bad");
}

#[test]
fn a_permutation_that_manifests_share_counts_once() {
    let count = |manifests: &[&str], name: &str| {
        let output = umbrage(&[&["check", "--json"], manifests].concat());
        let report = json(&output);
        report[name].as_u64().expect("a number")
    };
    let folder = faulty_package();
    let (all, again, vulkan) = (
        path_in(&folder, "all.ron"),
        path_in(&folder, "below/again.ron"),
        path_in(&folder, "vulkan.ron"),
    );
    write(
        &folder,
        "below/again.ron",
        r#"(packages: { "pkg": "../pkg" }, keys: [{ "pass": ["main"], "light": All, "method": All }])"#,
    );
    write(
        &folder,
        "vulkan.ron",
        r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["main"] }], target: "vulkan")"#,
    );
    assert_eq!(count(&[&all], "permutations"), 3);
    assert_eq!(count(&[&all, &again], "permutations"), 3);
    assert_eq!(count(&[&again, &all], "keys"), 12);
    assert_eq!(count(&[&again, &all], "failed"), 3);
    // For another target it is another permutation, and so it is in other packages.
    assert_eq!(count(&[&all, &vulkan], "permutations"), 4);
    let other = faulty_package();
    assert_eq!(
        count(&[&all, &path_in(&other, "all.ron")], "permutations"),
        6
    );
}

#[test]
fn equal_keys_of_several_manifests_may_differ() {
    let (folder, other) = (faulty_package(), faulty_package());
    write(
        &other,
        "pkg/bad.wesl",
        "fn calc_shadow(position: vec3f) -> f32 { return 0.5; }\n",
    );
    let (faulty, good) = (path_in(&folder, "all.ron"), path_in(&other, "all.ron"));
    let report = json(&umbrage(&["check", &faulty, &good, "--json"]));
    let cause = report["faults"][0]["cause"].as_str().expect("a cause");
    assert_eq!(
        cause,
        format!("light=lamp, method=bad, the manifest={faulty}")
    );
}

#[test]
fn manifests_that_cannot_be_used() {
    let folder = TempDir::new().expect("a folder");
    let said = refusal(&["check", "no/such/manifest.ron", "--json"]);
    assert!(said.contains("no/such/manifest.ron"), "{said}");

    let text = fs::read_to_string(super::root().join("permutations/demo.ron")).expect("a manifest");
    write(&folder, "truncated.ron", &text[..text.len() / 2]);
    assert!(refusal(&["check", &path_in(&folder, "truncated.ron")]).contains("truncated.ron:"));

    let faults = [
        ("field", r#"(packages: {}, kees: [])"#, "kees"),
        (
            "axis",
            r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["main"], "metod": All }])"#,
            "method",
        ),
        (
            "value",
            r#"(packages: { "pkg": "pkg" }, keys: [{ "pass": ["mian"] }])"#,
            "main",
        ),
        (
            "empty",
            r#"(packages: { "pkg": "pkg" }, keys: [])"#,
            "no key",
        ),
        (
            "package",
            r#"(packages: { "pkg": "gone" }, keys: [{ "pass": ["main"] }])"#,
            "gone",
        ),
    ];
    let folder = faulty_package();
    for (name, text, part) in faults {
        let path = format!("{name}.ron");
        write(&folder, &path, text);
        let said = refusal(&["check", &path_in(&folder, &path)]);
        assert!(
            said.contains(part) && said.contains(&path),
            "{name}: {said}"
        );
    }
}

/// A pass of one's own asks for no method; that it has none is not why it fails.
#[test]
fn the_axis_that_chose_the_faulty_module_is_told() {
    let folder = faulty_package();
    let axes = r#"(axes: {
        "pass": (values: {
            "main": (root: "package::main"),
            "own": (root: "package::own"),
            "helped": (root: "package::helped"),
        }),
        "method": (default: "none", values: {
            "none": (bind: { "package::interface::shadow": "package::interface::shadow" }),
            "good": (bind: { "package::interface::shadow": "package::good" }),
        }),
        "air": (default: "off", values: { "off": (), "on": (features: ["AIR"]) }),
    })"#;
    write(&folder, "pkg/axes.ron", axes);
    write(
        &folder,
        "pkg/own.wesl",
        "@fragment fn fs() -> @location(0) vec4f { return vec3f(); }\n",
    );
    write(
        &folder,
        "pkg/helper.wesl",
        "fn help() -> f32 { return vec3f(); }\n",
    );
    write(
        &folder,
        "pkg/helped.wesl",
        "import package::helper::help;\n@fragment fn fs() -> @location(0) vec4f { return vec4f(help()); }\n",
    );
    let cause = |keys: &str, file: &str| {
        let manifest = format!(r#"(packages: {{ "pkg": "pkg" }}, keys: [{keys}])"#);
        write(&folder, "own.ron", &manifest);
        let report = json(&umbrage(&["check", &path_in(&folder, "own.ron"), "--json"]));
        let faults = report["faults"].as_array().expect("faults");
        assert_eq!(faults.len(), 1, "{report}");
        assert!(
            faults[0]["file"]
                .as_str()
                .is_some_and(|at| at.ends_with(file)),
            "{report}"
        );
        faults[0]["cause"].as_str().expect("a cause").to_owned()
    };
    // The method and the air go with the pass wherever it goes.
    let lit = r#"{ "pass": ["main"], "method": ["good"], "air": ["on"] }"#;
    for (pass, file) in [("own", "own.wesl"), ("helped", "helper.wesl")] {
        let keys = format!(r#"{lit}, {{ "pass": ["{pass}"] }}"#);
        assert_eq!(cause(&keys, file), format!("pass={pass}"));
    }
    // A method's fault is the method's, though a pass of its own goes with it.
    write(
        &folder,
        "pkg/good.wesl",
        "fn calc_shadow(position: vec3f) -> f32 { return position; }\n",
    );
    let keys = r#"{ "pass": ["main"], "method": ["good"] }, { "pass": ["main"] }"#;
    assert_eq!(cause(keys, "good.wesl"), "method=good");
}

#[test]
fn a_fault_in_a_very_long_line_is_short() {
    let folder = faulty_package();
    let filler = "const A = 1; ".repeat(30_000);
    write(
        &folder,
        "pkg/main.wesl",
        &format!("{filler}@fragment fn fs() -> @location(0) vec4f {{ return vec3f(); }}"),
    );
    let output = umbrage(&["check", &path_in(&folder, "all.ron")]);
    assert_eq!(output.status.code(), Some(1));
    let said = stderr(&output);
    assert!(said.len() < 4_000, "{} bytes", said.len());
}

#[test]
fn names_that_no_path_can_begin_with_are_told_in_the_manifest() {
    let folder = faulty_package();
    for name in ["3d", "", "a b"] {
        let manifest =
            format!(r#"(packages: {{ "{name}": "pkg" }}, keys: [{{ "pass": ["main"] }}])"#);
        write(&folder, "named.ron", &manifest);
        let said = refusal(&["check", &path_in(&folder, "named.ron")]);
        assert!(
            said.contains("named.ron:1:14") && said.contains("cannot be the name"),
            "{said}"
        );
    }
    write(
        &folder,
        "named.ron",
        r#"(packages: { "my-lib": "pkg" }, keys: [{ "pass": ["main"] }])"#,
    );
    assert_eq!(
        umbrage(&["check", &path_in(&folder, "named.ron")])
            .status
            .code(),
        Some(0)
    );
}
