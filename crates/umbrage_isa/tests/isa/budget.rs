//! Limits, and budgets that cannot be used.

use std::path::PathBuf;

use tempfile::TempDir;
use umbrage_compose::{Key, Library, Stage};
use umbrage_isa::{Budget, Excess, Isa, Room, StageCost};

use super::permutation;

fn library() -> Library {
    Library::new([umbrage_shader_lib::package().expect("it loads")]).expect("a library")
}

fn file(text: &str) -> (TempDir, PathBuf) {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("budget.ron");
    std::fs::write(&path, text).expect("a file");
    (folder, path)
}

fn load(text: &str) -> Budget {
    let (_folder, path) = file(text);
    Budget::load(&path, library().axes())
        .map_err(|error| error.to_string())
        .expect("a budget")
}

fn fragment(instructions: u64, vgprs: u64) -> StageCost {
    StageCost {
        stage: Stage::Fragment,
        entry_point: "fs".to_owned(),
        isa: Isa {
            instructions,
            vgprs,
            ..Isa::default()
        },
        room: Room::default(),
    }
}

fn key(choices: &[(&str, &str)]) -> Key {
    library().key(choices.iter().copied()).expect("a key")
}

#[test]
fn the_least_limit_that_fits_counts() {
    let budget = load(
        r#"(rules: [
            (when: {}, stage: "fragment", max: (instructions: 100, vgprs: 16)),
            (when: { "light": ["spot", "point"] }, stage: "fragment", max: (instructions: 60), reason: "few"),
            (when: { "light": "spot" }, stage: "vertex", max: (instructions: 0)),
        ])"#,
    );
    assert_eq!(budget.family(), "navi21");
    let library = library();
    let over = |keys: &[Key], instructions, vgprs| {
        budget.over(library.axes(), keys, &[fragment(instructions, vgprs)])
    };
    let excess = |figure, found, allowed, reason: &str| Excess {
        stage: Stage::Fragment,
        figure,
        found,
        allowed,
        reason: reason.to_owned(),
    };
    let sun = key(&[("pass", "shadow_term")]);
    let spot = key(&[("pass", "shadow_term"), ("light", "spot")]);
    assert_eq!(over(std::slice::from_ref(&sun), 100, 16), []);
    assert_eq!(
        over(std::slice::from_ref(&sun), 101, 17),
        [
            excess("instructions", 101, 100, ""),
            excess("vgprs", 17, 16, "")
        ]
    );
    assert_eq!(
        over(std::slice::from_ref(&spot), 61, 16),
        [excess("instructions", 61, 60, "few")]
    );
    // One permutation for both: any of its keys may make a rule hold.
    assert_eq!(
        over(&[sun, spot], 61, 16),
        [excess("instructions", 61, 60, "few")]
    );
}

#[test]
fn a_rule_that_guards_nothing() {
    let text = r#"(
    family: "VEGA10",
    rules: [
        (when: { "pass": "caster" }, stage: "vertex", max: (vgprs: 64)),
        (when: { "pass": "caster" }, stage: "fragment", max: (vgprs: 64)),
    ],
)"#;
    let budget = load(text);
    assert_eq!(budget.family(), "vega10");
    let library = library();
    let keys = [key(&[("pass", "caster")])];
    let caster = permutation(&[("pass", "caster")]);
    let given = || [(&keys[..], &*caster)];
    let error = budget.check(library.axes(), given()).expect_err("needless");
    let at = error.faults()[0].location().expect("a place").clone();
    assert_eq!((at.line, at.column), (5, 9), "{error}");
    assert!(error.to_string().contains("fits no stage"), "{error}");
    let holed = [key(&[("pass", "caster"), ("alpha_test", "on")])];
    let leaves = permutation(&[("pass", "caster"), ("alpha_test", "on")]);
    let both = given().into_iter().chain([(&holed[..], &*leaves)]);
    budget.check(library.axes(), both).expect("both hold");
}

#[test]
fn what_is_no_budget() {
    let rule = |rule: &str| format!("(rules: [\n{rule},\n])");
    for (text, line, part) in [
        ("(rules: [".to_owned(), 1, ""),
        ("(rules: [])".to_owned(), 1, "no rule"),
        ("(rule: [])".to_owned(), 1, "rule"),
        ("(rules: [],\n famly: \"navi21\")".to_owned(), 2, "famly"),
        (
            rule(r#"(when: {}, stage: "fragment", max: (speed: 3))"#),
            2,
            "speed",
        ),
        (
            rule(r#"(when: {}, stage: "fragment", max: (vgprs: -3))"#),
            2,
            "",
        ),
        (
            rule(r#"(when: {}, stage: "fragment", max: ())"#),
            2,
            "inverse_throughput",
        ),
        (
            rule(r#"(when: {}, stage: "pixel", max: (vgprs: 3))"#),
            2,
            "vertex, fragment, compute",
        ),
        (rule(r#"(when: {}, max: (vgprs: 3))"#), 2, "stage"),
        (
            rule(r#"(when: { "metod": "basic" }, stage: "fragment", max: (vgprs: 3))"#),
            2,
            "`method`",
        ),
        (
            rule(r#"(when: { "method": ["basik"] }, stage: "fragment", max: (vgprs: 3))"#),
            2,
            "`basic`",
        ),
        (
            rule(r#"(when: { "pcf": 3 }, stage: "fragment", max: (vgprs: 3))"#),
            2,
            "as strings",
        ),
    ] {
        let (_folder, path) = file(&text);
        let error = Budget::load(&path, library().axes()).expect_err("no budget");
        let said = error.to_string();
        let at = error.faults()[0].location().expect("a place");
        assert_eq!(at.line, line, "{said}");
        assert!(
            at.file.ends_with("budget.ron") && said.contains(part),
            "{said}"
        );
    }
    let gone = Budget::load(&PathBuf::from("/gone/budget.ron"), library().axes());
    assert!(
        gone.expect_err("gone")
            .to_string()
            .contains("/gone/budget.ron")
    );
}
