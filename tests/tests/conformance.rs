//! Our own parts, held to what is asked of anybody's.

use umbrage::methods::registry;
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
