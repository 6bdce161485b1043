//! The space of our library's permutations, walked.

use umbrage::compose::{Composer, Library, Target};

/// Sizes of the space, by pass.
#[test]
#[ignore = "prints figures"]
fn sizes() {
    let library = Library::new([umbrage::shader_package().expect("our package")]).expect("ours");
    let composer = Composer::new(library, Target::webgpu());
    let mut by_pass = std::collections::BTreeMap::new();
    let start = std::time::Instant::now();
    let mut keys = 0;
    composer.for_each_variant(&mut |variant| {
        assert!(variant.fault.is_none(), "{:?}", variant.fault);
        keys += variant.keys;
        *by_pass
            .entry(variant.key.get("pass").unwrap_or("").to_owned())
            .or_insert(0) += 1;
    });
    println!(
        "{by_pass:?} {} {keys} {} {:?}",
        by_pass.values().sum::<usize>(),
        composer.legal_keys(),
        start.elapsed()
    );
}
