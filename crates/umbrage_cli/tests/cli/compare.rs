use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use super::{path_in, refusal, stderr, stdout, umbrage, write};

/// A floor and a ball under a sun and a lamp.
const SCENE: &str = r#"(
    camera: (position: (0, 3, 4), target: (0, 0.5, 0)),
    lights: [
        (kind: directional(direction: (1, -1, 0))),
        (kind: point(position: (2, 3, 0), range: 20)),
    ],
    models: [
        (shape: plane(size: (9, 9))),
        (shape: sphere(radius: 0.5), translation: (0, 1, 0)),
    ],
)"#;

const CONFIGS: &str = r#"[
    (name: "small", method: "basic", axes: {"pcf": "1"}, settings: {"resolution": 128}),
    (name: "large", method: "basic", axes: {"pcf": "5"}, settings: {"resolution": 1024}),
    (name: "too large", method: "basic", settings: {"resolution": 16384}),
]"#;

/// Figures that a row must have, as numbers.
const FIGURES: [&str; 23] = [
    "false_lit",
    "false_shadow",
    "acne",
    "peter_panning",
    "leak",
    "beyond_range",
    "rmse",
    "p99",
    "edge_p50",
    "edge_p95",
    "edge_max",
    "alias_p95",
    "alias_over_1",
    "shimmer",
    "flip",
    "bad_pixels",
    "back_facing",
    "texels_written",
    "triangles",
    "vertices",
    "memory_bytes",
    "fetches_per_pixel",
    "passes",
];

fn number(row: &Value, name: &str) -> f64 {
    row[name].as_f64().expect(name)
}

#[test]
fn configurations_become_rows_of_a_report() {
    let folder = TempDir::new().expect("a folder");
    write(&folder, "ball.ron", SCENE);
    write(&folder, "configs.ron", CONFIGS);
    let (scene, configs) = (
        path_in(&folder, "ball.ron"),
        path_in(&folder, "configs.ron"),
    );
    let (out, cache) = (path_in(&folder, "out"), path_in(&folder, "cache"));
    let args = [
        "compare",
        &scene,
        "--configs",
        &configs,
        "--size",
        "160x90",
        "--pairs",
        "7",
        "--frames",
        "4",
        "--cache",
        &cache,
        "--out",
        &out,
    ];
    let output = umbrage(&args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stdout(&output), "");
    let text = fs::read_to_string(folder.path().join("out/report.json")).expect("read");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let rows = report["rows"].as_array().expect("rows");
    let names: Vec<_> = rows
        .iter()
        .filter_map(|row| row["config"].as_str())
        .collect();
    // 16,384 texels are more than the device's texture may have: told, and the rest goes on.
    assert_eq!(names, ["small", "large"], "{}", stderr(&output));
    assert_eq!(report["skipped"][0]["config"], "too large");
    assert!(stderr(&output).contains("too large"));
    for row in rows {
        assert_eq!(row["scene"], "ball");
        assert_eq!(
            (&row["method"], &row["path"]),
            (&"basic".into(), &"forward".into())
        );
        assert!(FIGURES.iter().all(|name| number(row, name).is_finite()));
        assert_eq!(number(row, "bad_pixels"), 0.0);
        assert!(row["pareto"].is_boolean() && row["isa"]["instructions"].as_u64() > Some(50));
        let ratio = &row["time_ratio"];
        let [low, median, high] = ["low", "median", "high"].map(|name| number(ratio, name));
        assert!(0.0 < low && low <= median && median <= high, "{ratio}");
        assert_eq!(number(ratio, "pairs"), 7.0);
        assert_eq!(row["time_pairs"].as_array().map(Vec::len), Some(7));
    }
    let [small, large] = rows.as_slice() else {
        panic!("two rows")
    };
    // A rectangle and a cube, four bytes a texel; 1 fetch and 9 or 25 of them.
    assert_eq!(number(small, "memory_bytes"), 7.0 * 4.0 * 128.0 * 128.0);
    assert_eq!(number(small, "fetches_per_pixel"), 1.0);
    // All of it is filled once. The sun's pass and the faces of the lamp's cube that see either draw floor and ball.
    assert_eq!(number(small, "texels_written"), 7.0 * 128.0 * 128.0);
    assert!(number(small, "triangles") > number(small, "vertices"));
    assert_eq!(number(small, "triangles"), number(large, "triangles"));
    assert_eq!(small["fetch_shares"], serde_json::json!({ "1": 1.0 }));
    let shares = large["fetch_shares"].as_object().expect("shares");
    let (mut all, mut mean) = (0.0, 0.0);
    for (count, share) in shares {
        let share = share.as_f64().expect("a share");
        all += share;
        mean += share * count.parse::<f64>().expect("a count");
    }
    assert!(
        (all - 1.0_f64).abs() < 1e-9 && shares.len() > 1,
        "{shares:?}"
    );
    let fetches = number(large, "fetches_per_pixel");
    assert!((mean - fetches).abs() < 1e-9, "{mean} {fetches}");
    assert!((9.0..25.0).contains(&fetches), "{fetches}");
    assert!(number(large, "rmse") < number(small, "rmse"));
    assert!(number(large, "flip") < number(small, "flip"));
    assert!(number(large, "alias_p95") < number(small, "alias_p95"));
    let page = fs::read_to_string(folder.path().join("out/report.html")).expect("a page");
    assert!(page.contains("small") && page.contains("<svg") && page.contains("data:image/png"));
    assert!(!page.contains("src=\"http"));

    // Errors and counts are the same again; a folder of someone else's is not touched.
    let output = umbrage(&args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = fs::read_to_string(folder.path().join("out/report.json")).expect("read");
    let again: Value = serde_json::from_str(&text).expect("JSON");
    for (row, again) in rows.iter().zip(again["rows"].as_array().expect("rows")) {
        for name in FIGURES {
            assert_eq!(row[name], again[name], "{name}");
        }
    }
    fs::write(folder.path().join("out/mine.txt"), "mine").expect("written");
    let said = refusal(&args);
    assert!(said.contains("mine.txt"), "{said}");
}

#[test]
fn what_cannot_be_compared() {
    let folder = TempDir::new().expect("a folder");
    write(&folder, "ball.ron", SCENE);
    let scene = path_in(&folder, "ball.ron");
    let out = path_in(&folder, "out");
    let refused = |more: &[&str]| {
        let mut args = vec!["compare", "--out", &out];
        args.extend(more);
        refusal(&args)
    };
    let configs = |text: &str| {
        write(&folder, "configs.ron", text);
        refused(&[&scene, "--configs", &path_in(&folder, "configs.ron")])
    };
    for (text, expected) in [
        (
            "[(name: \"a\", method: \"basicc\")]",
            "did you mean `basic`?",
        ),
        (
            "[(name: \"a\", method: \"basic\", axes: {\"pdf\": \"3\"})]",
            "no axis `pdf`",
        ),
        (
            "[(name: \"a\", method: \"basic\", axes: {\"pcf\": \"4\"})]",
            "no value `4`",
        ),
        (
            "[(name: \"a\", method: \"basic\", settings: {\"size\": 3})]",
            "no setting `size`",
        ),
        (
            "[(name: \"a\", method: \"basic\", settings: {\"resolution\": 0})]",
            "from 1 to",
        ),
        (
            "[(name: \"a\", method: \"basic\"), (name: \"a\", method: \"basic\")]",
            "two configurations called `a`",
        ),
        (
            "[(name: \"a\", method: \"basic\", light: 3)]",
            "configs.ron:1:",
        ),
        ("[]", "there is no configuration"),
    ] {
        let said = configs(text);
        assert!(said.contains(expected), "{text}: {said}");
        assert!(said.contains("configs.ron:1:"), "{text}: {said}");
    }
    write(&folder, "configs.ron", "[(name: \"a\", method: \"basic\")]");
    write(&folder, "more.ron", "[(name: \"a\", method: \"basic\")]");
    let [one, more] = ["configs.ron", "more.ron"].map(|name| path_in(&folder, name));
    let said = refused(&[&scene, "--configs", &one, "standard", &more]);
    assert!(
        said.contains("two configurations called `a`") && said.contains("more.ron"),
        "{said}"
    );
    assert!(refused(&[&scene, &scene]).contains("two scenes are called `ball`"));
    write(
        &folder,
        "dark.ron",
        "(camera: (position: (0, 1, 1), target: (0, 0, 0)), models: [(shape: plane(size: (1, 1)))])",
    );
    let said = refused(&[&scene, &path_in(&folder, "dark.ron")]);
    assert!(
        said.contains("`dark`") && said.contains("no lights"),
        "{said}"
    );
    assert!(refused(&["gone.ron"]).contains("gone.ron"));
    assert!(refused(&[&scene, "--methods", "none"]).contains("--methods"));
    assert!(refused(&[]).contains("SCENE"));
    assert!(
        !fs::exists(&out).expect("looked up"),
        "nothing is left behind"
    );
}
