use std::fs;

use tempfile::TempDir;

use super::{json, path_in, refusal, root, stderr, stdout, umbrage};

#[test]
fn a_case_is_held_against_its_limits() {
    let folder = TempDir::new().expect("a folder");
    let pictures = path_in(&folder, "pictures");
    let cache = path_in(&folder, "cache");
    let base = ["stress", "--variants", "basic", "--cases", "contact, tiny"];
    let mut args = base.to_vec();
    args.extend(["--json", "--pictures", &pictures, "--cache", &cache]);
    let output = umbrage(&args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&output);
    let cases = report["cases"].as_array().expect("a list");
    let names: Vec<_> = cases
        .iter()
        .filter_map(|case| case["case"].as_str())
        .collect();
    // With what it must look like.
    assert_eq!(names, ["far-away-origin", "tiny", "contact"]);
    for case in cases {
        assert_eq!(
            (&case["variant"], &case["method"]),
            (&"basic".into(), &"basic".into())
        );
        assert_eq!(case["passed"], true);
        assert!(case["exception"].is_null());
        let figures = &case["figures"];
        assert_eq!(figures["bad_pixels"], 0);
        assert!(
            figures["false_lit"]
                .as_f64()
                .is_some_and(|share| share < 0.01)
        );
        assert!(figures["compared"].as_u64() > Some(10_000));
    }
    assert_eq!(cases[1]["differs"], 0.0);
    let files = fs::read_dir(&pictures).expect("listed").count();
    assert_eq!(files, 9, "method, truth and difference of each");
    assert!(fs::read_dir(&cache).expect("listed").count() > 3);

    let output = umbrage(&base);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let lines: Vec<_> = stdout(&output).lines().collect();
    assert_eq!(lines.len(), 4, "{lines:?}");
    assert!(
        lines[..3].iter().all(|line| line.starts_with("passed")),
        "{lines:?}"
    );
    assert_eq!(lines[3], "3 of 3 passed");
}

#[test]
fn an_exception_says_why() {
    let output = umbrage(&["stress", "--cases", "depth-range", "--variants", "basic"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stdout(&output);
    assert!(
        said.starts_with("excepted") && said.contains("texels of a metre"),
        "{said}"
    );
}

#[test]
fn unknown_names_are_refused() {
    let said = refusal(&["stress", "--cases", "contact,nowhere"]);
    assert!(
        said.contains("`nowhere`") && said.contains("grazing-85"),
        "{said}"
    );
    let said = refusal(&["stress", "--methods", "pssm", "--variants", "basic 15"]);
    assert!(
        said.contains("--variants") && said.contains("`basic 15`") && said.contains("pssm tight"),
        "{said}"
    );
    let said = refusal(&["stress", "--methods", "basicc"]);
    assert!(
        said.contains("basicc") && said.contains("--methods"),
        "{said}"
    );
}

/// The project's own table, with a limit that nothing meets for one case, or with a variant that there is not.
#[test]
fn a_missed_limit_is_found_wanting() {
    let folder = TempDir::new().expect("a folder");
    let own = root().join("crates/umbrage_measure/limits.ron");
    let own = fs::read_to_string(own).expect("the table");
    let table = path_in(&folder, "limits.ron");
    let args = [
        "stress",
        "--variants",
        "basic",
        "--cases",
        "empty-head",
        "--limits",
        &table,
    ];

    fs::write(&table, &own).expect("written");
    let output = umbrage(&args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));

    let limit =
        r#""empty-head": (any: { "false_lit": (most: 0, why: "no pixel's grid, no texel") })"#;
    let strict = own.replace(r#""empty-head": ()"#, limit);
    assert_ne!(strict, own);
    fs::write(&table, strict).expect("written");
    let output = umbrage(&args);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let lines: Vec<_> = stdout(&output).lines().collect();
    assert!(lines[0].starts_with("FAILED    empty-head"), "{lines:?}");
    assert!(
        lines[1].contains("not at most 0; limit: no pixel's grid, no texel"),
        "{lines:?}"
    );
    assert_eq!(lines[2..], ["0 of 1 passed"]);

    let foreign = own.replace(r#"axes: {"pcf": "15"}"#, r#"axes: {"pcf": "14"}"#);
    assert_ne!(foreign, own);
    let line = foreign.lines().position(|line| line.contains(r#""14""#));
    fs::write(&table, &foreign).expect("written");
    let said = refusal(&args);
    let place = format!("{table}:{}:", 1 + line.expect("the variant"));
    assert!(
        said.contains(&place)
            && said.contains("axis `pcf` has no value `14` (known: 1, 11, 13, 15,"),
        "{said}"
    );
}
