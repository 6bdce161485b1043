//! Our own parts, held to what is asked of anybody's.

use umbrage::{
    compose::RonFile,
    methods::{filters::pcf::Pcf, registry},
    shadow::{Filter, Frame, Part, PlanError, Registry},
};
use umbrage_measure::cases::{self, Limits};
use umbrage_testkit::conformance;

#[test]
fn our_parts_keep_what_all_parts_promise() {
    let package = umbrage::shader_package().expect("the shader library");
    let parts = registry().expect("names are unique");
    let limits = Limits::built_in().expect("a sound table");
    let held = conformance([package], parts, &limits, &[]);
    let held = held.unwrap_or_else(|broken| panic!("{broken}"));
    assert_eq!(held.variants, limits.variants().len());
    // `basic` shadows every light, in each hard case.
    assert!(held.lights >= held.variants && held.pictures > 8 * held.lights);
    assert!(held.cases >= cases::all().len());
}

/// Comparing by `pcf`, with another account of what it costs.
struct Boaster;

impl Part for Boaster {
    fn name(&self) -> &str {
        "pcf"
    }

    fn axes(&self) -> &[&str] {
        Pcf.axes()
    }
}

impl Filter for Boaster {
    fn reach(&self, frame: &Frame<'_>, number: usize) -> Result<f64, PlanError> {
        Pcf.reach(frame, number)
    }

    fn fetches(&self, _: &Frame<'_>, _: usize) -> Result<u32, PlanError> {
        Ok(1)
    }
}

/// A promise that is broken is told, with the variant and the light; a variant that there is not, as well.
#[test]
fn a_broken_promise_is_told() {
    let cases = cases::all().into_iter();
    let cases: String = cases
        .map(|case| format!("\"{}\": (),", case.name))
        .collect();
    let table = format!(
        r#"(
        variants: [(name: "boaster", method: "basic")],
        only: {{ "boaster": (cases: ["contact"], why: "one case will do") }},
        every: {{ "acne": (most: 1.0, why: "anything goes") }},
        cases: {{ {cases} }},
    )"#
    );
    let limits = Limits::read(RonFile::new("limits.ron", &table)).expect("a sound table");
    let mut parts = registry().expect("names are unique");
    parts.filters = Registry::new().filters;
    parts.filters.add(Boaster).expect("the only one");
    let package = umbrage::shader_package().expect("the shader library");
    let broken = conformance([package], parts, &limits, &["boaster", "bosater"]);
    let said = broken.expect_err("it boasts").to_string();
    let lines: Vec<_> = said.lines().collect();
    assert_eq!(lines[0], "no method has the variant `bosater`");
    let told = "boaster under a directional light: 4 fetches for a pixel, but the plan says 1";
    assert!(lines.contains(&told), "{said}");
}
