//! The table of limits, and how figures are held against it.

use std::{collections::BTreeSet, fmt::Write as _};

use umbrage_compose::RonFile;

use super::{DIFFERS, Limits, all, figure::Figure};
use crate::figures::Figures;

const VARIANTS: &str = r#"[(name: "basic", method: "basic"), (name: "other", method: "basic"), (name: "wide", method: "basic")]"#;

/// A table with `grazing` for the case `grazing-85`, and nothing more for the others.
fn table(every: &str, grazing: &str) -> String {
    let mut text = format!(
        "( // \"basic\", \"other\"\n  every: {{ {every} }}, variants: {VARIANTS}, like: {{ \"wide\": \"basic\" }},\n  cases: {{\n"
    );
    for case in all() {
        let entry = if case.name == "grazing-85" {
            grazing
        } else {
            "()"
        };
        writeln!(text, "    \"{}\": {entry},", case.name).expect("written");
    }
    text + "  },\n)"
}

fn read(every: &str, grazing: &str) -> Limits {
    Limits::read(RonFile::new("limits.ron", table(every, grazing))).expect("a sound table")
}

/// The place and the message.
fn refusal(text: &str) -> String {
    let refused = Limits::read(RonFile::new("limits.ron", text));
    let refused = refused.expect_err("it must be refused");
    let fault = &refused.faults()[0];
    let at = fault.location().expect("a place");
    format!("{}:{}:{}: {}", at.file, at.line, at.column, fault.message)
}

/// Line of the entry `grazing-85` in `table`.
fn line() -> usize {
    let before = all().iter().position(|case| case.name == "grazing-85");
    4 + before.expect("the case")
}

const BAD: &str = r#""bad_pixels": (most: 0, why: "w")"#;

#[test]
fn the_built_in_table_is_sound() {
    let limits = Limits::built_in().expect("a sound table");
    let names: Vec<_> = limits.variants().iter().map(|v| v.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "basic",
            "basic 15",
            "basic midpoint",
            "basic esm",
            "basic esm half",
            "basic hpsm",
            "pssm",
            "pssm esm",
            "pssm hpsm",
            "pssm midpoint",
            "pssm tight"
        ]
    );
    let twins: BTreeSet<_> = all()
        .iter()
        .filter(|c| c.same_as.is_some())
        .map(|c| c.name)
        .collect();
    let held = all().into_iter().filter(|case| {
        let own = limits.case(case.name).expect("the case");
        own.any.contains_key(&Figure(DIFFERS))
    });
    assert_eq!(held.map(|case| case.name).collect::<BTreeSet<_>>(), twins);
    for case in all() {
        let bad = Figures {
            bad_pixels: 1,
            compared: 10_000,
            ..Figures::default()
        };
        let verdict = limits
            .judge(case.name, "basic", &bad, Some(0.0))
            .expect("the case");
        assert!(!verdict.passed, "{}", case.name);
    }
}

#[test]
fn misspelt_figures_and_cases_are_named_with_their_place() {
    let every = refusal(&table(r#""fals_lit": (most: 0.1, why: "w")"#, "()"));
    assert_eq!(
        every,
        "limits.ron:2:13: there is no figure `fals_lit`; did you mean `false_lit`?"
    );
    let exception = refusal(&table(BAD, r#"(exceptions: { "basic": { "acme": "r" } })"#));
    let expected = format!(
        "limits.ron:{}:46: there is no figure `acme`; did you mean `acne`?",
        line()
    );
    assert_eq!(exception, expected);
    let case = refusal(&table(BAD, "()").replace("grazing-85", "grazing-58"));
    let expected = format!(
        "limits.ron:{}:6: there is no case `grazing-58`; did you mean `grazing-",
        line()
    );
    assert!(case.starts_with(&expected), "{case}");
    let other = refusal(&table(r#""speed": (most: 1, why: "w")"#, "()"));
    assert!(
        other.contains("there is no figure `speed` (known: acne, "),
        "{other}"
    );
}

#[test]
fn a_case_that_is_left_out_is_named() {
    let text = table(BAD, "()").replace("    \"grazing-85\": (),\n", "");
    assert_eq!(
        refusal(&text),
        "limits.ron:3:3: the case `grazing-85` is not in the table; add it, `\"grazing-85\": ()` where it is held to no \
         more than every case is"
    );
}

#[test]
fn a_variant_may_be_tried_in_some_cases_alone() {
    let table = |only: &str| {
        table(BAD, "()").replace("  cases: {", &format!("  only: {{ {only} }}, cases: {{"))
    };
    let text = table(r#""wide": (cases: ["grazing-85", "tiny"], why: "it says enough")"#);
    let limits = Limits::read(RonFile::new("limits.ron", text)).expect("a sound table");
    for (case, variant, reason) in [
        ("tiny", "wide", None),
        ("huge", "wide", Some("it says enough")),
        ("huge", "basic", None),
    ] {
        assert_eq!(
            limits.passes_over(case, variant),
            reason,
            "{case} {variant}"
        );
    }
    let variant = refusal(&table(r#""wild": (cases: ["tiny"], why: "w")"#));
    assert_eq!(
        variant,
        "limits.ron:3:11: there is no variant `wild`; did you mean `wide`?"
    );
    let case = refusal(&table(r#""wide": (cases: ["tinny"], why: "w")"#));
    assert!(
        case.contains("there is no case `tinny`; did you mean `tiny`?"),
        "{case}"
    );
    let reason = refusal(&table(r#""wide": (cases: ["tiny"], why: "")"#));
    assert!(reason.contains("a reason is empty"), "{reason}");
}

#[test]
fn what_says_nothing_or_too_much_is_refused() {
    let refused = |grazing: &str| refusal(&table(BAD, grazing));
    for (entry, message) in [
        (
            r#"(any: { "acne": (most: 0.1, why: " ") })"#,
            "a reason is empty",
        ),
        (
            r#"(any: { "acne": (why: "w") })"#,
            "either the `most` or the `least`",
        ),
        (
            r#"(any: { "acne": (most: 1, least: 0, why: "w") })"#,
            "either the `most` or the `least`",
        ),
        (
            r#"(any: { "acne": (most: -1, why: "w") })"#,
            "a limit is -1, but must be finite and not below 0",
        ),
        (r#"(any: { "acne": (most: 0.1) })"#, "why"),
        (
            r#"(any: { "acne": (most: 0.1, why: "w", when: "x") })"#,
            "when",
        ),
        (r#"(sometimes: {})"#, "sometimes"),
        (
            r#"(any: { "acne": (most: 1, why: "w"), "acne": (most: 2, why: "w") })"#,
            "`acne` stands twice",
        ),
        (
            r#"(exceptions: { "basic": { "bad_pixels": "r" } })"#,
            "no method is excepted from the limit of `bad_pixels`; mend the method",
        ),
        (
            r#"(exceptions: { "basic": { "acne": "r" } })"#,
            "`basic` is excepted from a limit of `acne`, but `grazing-85` has none; take the exception out",
        ),
        (
            r#"(any: { "acne": (most: 0.1, why: "w") }, methods: { "basic": { "acne": (most: 0.2, why: "w") } })"#,
            "`basic` may have a `acne` of at most 0.2, but all methods are held to at most 0.1; say under `exceptions` \
             why it need not be, or take its own limit out",
        ),
    ] {
        let refusal = refused(entry);
        assert!(refusal.contains(message), "{refusal}");
        assert!(
            refusal.starts_with(&format!("limits.ron:{}:", line())),
            "{refusal}"
        );
    }
    assert_eq!(
        refusal("(variants: [], every: {}, cases: {}"),
        "limits.ron:1:35: expected comma"
    );
}

#[test]
fn variants_are_told_apart() {
    let good = table(BAD, "()");
    for (from, to, place, message) in [
        (
            r#"name: "other""#,
            r#"name: "basic""#,
            r#""basic", method: "basic"), (name: "wide""#,
            "two variants are called `basic`; rename one",
        ),
        (
            r#""wide": "basic""#,
            r#""wide": "basics""#,
            r#""basics""#,
            "there is no variant `basics`; did you mean `basic`?",
        ),
        (
            r#""wide": "basic""#,
            r#""wade": "basic""#,
            r#""wade""#,
            "there is no variant `wade`; did you mean `wide`?",
        ),
        (
            r#""wide": "basic""#,
            r#""wide": "wide""#,
            r#""wide": "wide""#,
            "`wide` is like itself; take the line out",
        ),
        (
            r#""wide": "basic""#,
            r#""basic": "other", "wide": "basic""#,
            r#""basic" }"#,
            "`wide` is like `basic`, which is like `other`; name that one",
        ),
    ] {
        let text = good.replace(from, to);
        let line = text.lines().nth(1).expect("a second line");
        let column = 1 + line.find(place).expect("the place");
        assert_eq!(refusal(&text), format!("limits.ron:2:{column}: {message}"));
    }
    let misspelt = |field: &str| format!(r#"({field}: {{ "wider": {{}} }})"#);
    for field in ["methods", "exceptions"] {
        let refused = refusal(&table(BAD, &misspelt(field)));
        assert!(
            refused.ends_with("there is no variant `wider`; did you mean `wide`?"),
            "{refused}"
        );
        assert!(
            refused.starts_with(&format!("limits.ron:{}:", line())),
            "{refused}"
        );
    }
}

#[test]
fn a_variant_that_is_like_another_is_held_to_the_same() {
    let own = |more: &str| {
        let entry = format!(
            r#"(
                any: {{ "acne": (most: 0.2, why: "w") }},
                methods: {{ "basic": {{ "acne": (most: 0.5, why: "w") }} }},
                exceptions: {{ "basic": {{ "acne": "too steep" }}{more} }},
            )"#
        );
        table(BAD, &entry)
    };
    let limits = Limits::read(RonFile::new("limits.ron", own(""))).expect("a sound table");
    let judge = |variant: &str, acne: f64| {
        let figures = Figures {
            acne,
            ..Figures::default()
        };
        let verdict = limits.judge("grazing-85", variant, &figures, None);
        verdict.expect("a case")
    };
    for acne in [0.1, 0.3, 0.6] {
        assert_eq!(judge("wide", acne), judge("basic", acne));
        assert_eq!(judge("other", acne).passed, acne < 0.2);
    }
    // Each that has an exception must need it.
    assert_eq!(judge("wide", 0.1).unnecessary, ["acne"]);
    // And may decline it; the other's own limit then asks for no more than the one for all.
    let refused = refusal(&own(r#", "wide": {}"#));
    assert!(
        refused.contains(
            "`wide` may have a `acne` of at most 0.5, but all methods are held to at most 0.2"
        ),
        "{refused}"
    );
    let declined = own(r#", "wide": {}"#).replace(
        r#"most: 0.5, why: "w") }"#,
        r#"most: 0.5, why: "w") }, "wide": {}"#,
    );
    let limits = Limits::read(RonFile::new("limits.ron", declined)).expect("a sound table");
    let figures = |acne| Figures {
        acne,
        ..Figures::default()
    };
    let judge = |acne| limits.judge("grazing-85", "wide", &figures(acne), None);
    let verdicts = [0.1, 0.3].map(|acne| judge(acne).expect("a case"));
    assert!(verdicts[0].passed && verdicts[0].unnecessary.is_empty() && !verdicts[1].passed);
}

#[test]
fn figures_are_held_to_the_limits() {
    let limits = read(
        r#""bad_pixels": (most: 0, why: "w"), "acne": (most: 0.1, why: "w"), "edge_p95": (most: 3, why: "w")"#,
        r#"(
            any: { "acne": (most: 0.2, why: "w"), "compared": (least: 10, why: "w") },
            methods: { "basic": { "acne": (most: 0.5, why: "w") } },
            exceptions: { "basic": { "acne": "too steep" } },
        )"#,
    );
    let judge = |case: &str, method: &str, figures: &Figures| {
        limits.judge(case, method, figures, None).expect("a case")
    };
    let good = Figures {
        compared: 10,
        ..Figures::default()
    };
    let mottled = |acne: f64| Figures {
        acne,
        ..good.clone()
    };

    let verdict = judge("grazing-85", "other", &good);
    assert!(verdict.passed && verdict.missed.is_empty() && verdict.unnecessary.is_empty());
    // The case's own limit stands in the place of that for every case.
    assert!(judge("grazing-85", "other", &mottled(0.15)).passed);
    assert!(!judge("grazing-80", "other", &mottled(0.15)).passed);

    let verdict = judge("grazing-85", "other", &mottled(0.3));
    assert!(!verdict.passed && verdict.exception.is_none());
    assert_eq!(verdict.missed[0].found, Some(0.3));
    let verdict = judge("grazing-85", "basic", &mottled(0.3));
    assert!(verdict.passed && verdict.unnecessary.is_empty());
    assert_eq!(verdict.exception.as_deref(), Some("acne: too steep"));
    // An exception has its own bound, and must be needed.
    assert!(!judge("grazing-85", "basic", &mottled(0.6)).passed);
    assert_eq!(
        judge("grazing-85", "basic", &mottled(0.2)).unnecessary,
        ["acne"]
    );

    // Too few samples, what is no number, and what is missing.
    let few = Figures {
        compared: 9,
        ..Figures::default()
    };
    assert!(!judge("grazing-85", "other", &few).passed);
    assert!(!judge("grazing-80", "other", &mottled(f64::NAN)).passed);
    assert!(!judge("grazing-80", "other", &mottled(f64::INFINITY)).passed);
    assert!(
        judge(
            "grazing-80",
            "other",
            &Figures {
                edge_p95: None,
                ..good.clone()
            }
        )
        .passed
    );
    assert!(
        !judge(
            "grazing-80",
            "other",
            &Figures {
                edge_p95: Some(3.5),
                ..good.clone()
            }
        )
        .passed
    );
    let bad = Figures {
        bad_pixels: 1,
        ..good
    };
    assert!(!judge("grazing-85", "basic", &bad).passed);
    assert!(limits.judge("grazing-58", "basic", &bad, None).is_none());
}

#[test]
fn a_twin_must_have_its_figure() {
    let limits = read(BAD, r#"(any: { "differs": (most: 0.1, why: "w") })"#);
    let passed = |differs| {
        let verdict = limits.judge("grazing-85", "basic", &Figures::default(), differs);
        verdict.expect("a case").passed
    };
    assert!(passed(Some(0.1)) && !passed(Some(0.2)) && !passed(None));
}

/// Additions of a table to the project's own.
#[test]
fn a_table_may_extend_the_projects_own() {
    let own = r#"( // "basic"
  extends: true, variants: [(name: "soft", method: "basic")], like: { "soft": "basic" },
  throughout: { "soft": { "leak": (most: 0.5, why: "w") } },
  cases: { "grazing-85": (exceptions: { "soft": { "acne": "w" } }) },
)"#;
    let limits = Limits::read(RonFile::new("own.ron", own)).expect("a sound table");
    let base = Limits::built_in().expect("a sound table");
    assert_eq!(limits.variants().len(), base.variants().len() + 1);
    assert!(limits.throughout().any(|own| own == ("soft", "leak")));
    let throughout = base.throughout().count();
    assert_eq!(limits.throughout().count(), throughout + 1);
    let refused = |from: &str, to: &str| refusal(&own.replace(from, to));
    let second = ", (name: \"pssm\", method: \"pssm\")],";
    assert_eq!(
        refused("], like", &format!("{second} like")),
        "limits.ron:2:69: two variants are called `pssm`; rename one"
    );
    for (from, to, place) in [
        ("like: { \"soft\"", "like: { \"pssm\"", "2:71"),
        ("throughout: { \"soft\"", "throughout: { \"basic\"", "3:17"),
        ("exceptions: { \"soft\"", "exceptions: { \"basic\"", "4:41"),
    ] {
        let said = refused(from, to);
        let expected =
            "is no variant of this table, and what holds of it is said in the extended one";
        assert!(said.contains(expected), "{said}");
        assert!(said.starts_with(&format!("limits.ron:{place}: ")), "{said}");
    }
    let general = "limits of all variants are the extended table's; give those of your own under `throughout`, or \
                   under a case's `methods`";
    let bound = r#""leak": (most: 0.5, why: "w")"#;
    assert_eq!(
        refused(
            "extends: true,",
            &format!("extends: true, every: {{ {bound} }},")
        ),
        format!("limits.ron:2:18: {general}")
    );
    assert_eq!(
        refused(
            "(exceptions: {",
            &format!("(any: {{ {bound} }}, exceptions: {{")
        ),
        format!("limits.ron:4:27: {general}")
    );
    assert!(
        refused("extends: true,", "").contains("give it limits for `every` case, or have it add"),
        "{}",
        refused("extends: true,", "")
    );
}
