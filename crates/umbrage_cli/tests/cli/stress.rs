use std::fs;

use tempfile::TempDir;

use super::{json, path_in, refusal, stderr, stdout, umbrage};

#[test]
fn a_case_is_held_against_its_limits() {
    let folder = TempDir::new().expect("a folder");
    let pictures = path_in(&folder, "pictures");
    let cache = path_in(&folder, "cache");
    let base = ["stress", "--methods", "basic", "--cases", "contact, tiny"];
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
            (&case["method"], &case["passed"]),
            (&"basic".into(), &true.into())
        );
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
    let output = umbrage(&["stress", "--cases", "grazing-89", "--methods", "basic"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stdout(&output);
    assert!(
        said.starts_with("excepted") && said.contains("87 degrees"),
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
    let said = refusal(&["stress", "--methods", "basicc"]);
    assert!(
        said.contains("basicc") && said.contains("--methods"),
        "{said}"
    );
}
