use serde_json::json;

use crate::{faulty_package, json, path_in, refusal, stderr, stdout, umbrage};

#[test]
fn a_key_is_explained() {
    let folder = faulty_package();
    let package = path_in(&folder, "pkg");
    let key = "light=lamp,pass=main,unread=on";
    let output = umbrage(&["explain", key, "--package", &package, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&output);
    // `good` asks for no light, and nothing for `unread`.
    assert_eq!(report["permutation"], "pass=main");
    assert_eq!(report["keys"], 4);
    assert_eq!(
        report["modules"],
        json!([
            ["pkg::main", "the root of pass=main"],
            [
                "pkg::good",
                "bound to pkg::interface::shadow by method=good, asked by pkg::main"
            ],
            ["pkg::interface::shadow", "imported by pkg::main"],
        ])
    );
    assert_eq!(report["features"], json!([]));
    let output = umbrage(&["explain", "method=basic,pass=shadow_term"]);
    let said = stdout(&output);
    for words in [
        "bound to umbrage::interface::shadow by method=basic",
        "LIGHT_SPOT: off",
        "@group(0) @binding(0) frame of umbrage::common::frame",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn an_edit_is_explained() {
    let folder = faulty_package();
    let package = path_in(&folder, "pkg");
    let file = path_in(&folder, "pkg/bad.wesl");
    let output = umbrage(&["explain", &file, "--package", &package, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&output);
    assert_eq!(report["module"], "pkg::bad");
    assert_eq!(
        (&report["permutations"], &report["of"]),
        (&json!(2), &json!(3))
    );
    assert_eq!(report["values"], json!({ "method": ["bad"] }));
}

#[test]
fn what_is_no_key_and_no_module_is_refused() {
    assert!(refusal(&["explain", "pas=base"]).contains("did you mean `pass`?"));
    assert!(refusal(&["explain", "pass"]).contains("AXIS=VALUE"));
    assert!(refusal(&["explain", "gone.wesl"]).contains("--package"));
}
