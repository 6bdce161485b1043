use serde_json::json;

use super::{faulty_package, json, path_in, refusal, stdout, umbrage};

#[test]
fn axes_multiply() {
    let folder = faulty_package();
    let output = umbrage(&["list", &path_in(&folder, "all.ron"), "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let listing = json(&output);
    assert_eq!(listing["keys"], 8);
    assert_eq!(listing["permutations"], 3);
    let axes = &listing["axes"];
    assert_eq!(
        axes["pass"],
        json!({ "unused": [], "values": ["main"], "multiplier": 1.0 })
    );
    assert_eq!(
        axes["unread"],
        json!({ "unused": [], "values": ["off", "on"], "multiplier": 1.0 })
    );
    // Without the light, `good` and `bad` are left; without the method, `sun` and `lamp`.
    assert_eq!(
        axes["light"],
        json!({ "unused": [], "values": ["lamp", "sun"], "multiplier": 1.5 })
    );
    assert_eq!(
        axes["method"],
        json!({ "unused": [], "values": ["bad", "good"], "multiplier": 1.5 })
    );
}

#[test]
fn a_person_reads_a_table() {
    let output = umbrage(&["list", "permutations/demo.ron"]);
    assert_eq!(output.status.code(), Some(0));
    for axis in ["pass", "surface", "light", "method", "pcf", "cookie"] {
        assert!(stdout(&output).contains(axis), "{}", stdout(&output));
    }
}

#[test]
fn a_missing_manifest() {
    assert!(refusal(&["list", "gone.ron", "--json"]).contains("gone.ron"));
}
