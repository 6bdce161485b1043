//! Every variant of every method in every hard case, against the limits.

use std::{collections::BTreeSet, sync::Arc};

use umbrage_compose::{Composer, Library, Target};
use umbrage_measure::{
    cases::{self, Limits},
    study::{Lab, stress},
};
use umbrage_render::Gpu;

#[test]
fn every_variant_meets_its_limits_and_needs_its_exceptions() {
    let package = umbrage_shader_lib::package().expect("the shader library");
    let library = Library::new([package]).expect("the library");
    let composer = Arc::new(Composer::new(library, Target::default()));
    let registry = umbrage_methods::registry().expect("names are unique");
    let methods: Vec<_> = registry.methods.names().map(str::to_owned).collect();
    let limits = Limits::built_in().expect("a sound table");
    let variants = limits.variants_of(&methods, &registry, composer.library());
    let variants = variants.expect("sound variants");
    let listed: BTreeSet<_> = limits.variants().iter().map(|v| v.name.as_str()).collect();
    let tried: BTreeSet<_> = variants.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(
        listed, tried,
        "a variant of no method, or a method that has none"
    );
    let mut lab = Lab::new(
        Arc::new(Gpu::new().expect("an adapter")),
        composer,
        registry,
    );
    let cases = cases::all();
    let stressed = stress(&mut lab, &variants, &cases, &limits, None, &()).expect("measured");

    let mut faults = Vec::new();
    for result in &stressed.results {
        let (case, variant, verdict) = (result.case, &result.variant, &result.verdict);
        for miss in verdict.missed.iter().filter(|miss| miss.excepted.is_none()) {
            faults.push(format!(
                "{variant} in {case}: {} is {:?}, not {}",
                miss.figure, miss.found, miss.limit
            ));
        }
        for figure in &verdict.unnecessary {
            faults.push(format!(
                "{variant} in {case}: the exception for {figure} is not needed; take it out of limits.ron"
            ));
        }
        assert_eq!(result.figures.bad_pixels, 0, "{variant} in {case}");
    }
    assert!(faults.is_empty(), "{faults:#?}");

    let spared: BTreeSet<_> = (stressed.results.iter())
        .flat_map(|r| {
            r.verdict
                .spared
                .iter()
                .map(|f| (r.variant.as_str(), f.as_str()))
        })
        .collect();
    for own in limits.throughout() {
        assert!(
            spared.contains(&own),
            "{own:?} is not needed throughout; take it out of limits.ron"
        );
    }

    // Nothing was passed over in silence.
    let tried: BTreeSet<_> = (stressed.results.iter())
        .map(|result| (result.case, result.variant.as_str()))
        .collect();
    let skipped = (stressed.skipped.iter()).map(|(case, variant, _)| (*case, variant.as_str()));
    let all = tried
        .iter()
        .copied()
        .chain(skipped)
        .collect::<BTreeSet<_>>();
    assert_eq!(all.len(), cases.len() * variants.len());
    let basic = tried.iter().filter(|(_, variant)| *variant == "basic");
    assert_eq!(basic.count(), cases.len(), "basic shadows every light");
}
