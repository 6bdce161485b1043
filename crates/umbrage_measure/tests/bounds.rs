//! In every hard case, a shadow term that bounds decide first is the filter's own: bit by bit, in every pixel.

use std::sync::Arc;

use umbrage_compose::{Composer, Library, Target};
use umbrage_measure::{cases, study::Config};
use umbrage_render::{Gpu, Picture, RenderOptions, Renderer, Scene, Shadow, What};
use umbrage_shadow::LightKind;

#[test]
fn bounds_change_no_pixel_of_any_hard_case() {
    let package = umbrage_shader_lib::package().expect("the shader library");
    let library = Library::new([package]).expect("the library");
    let composer = Arc::new(Composer::new(library.clone(), Target::default()));
    let registry = umbrage_methods::registry().expect("names are unique");
    let gpu = Arc::new(Gpu::new().expect("an adapter"));
    let mut renderer = Renderer::new(gpu, composer, registry.clone());
    let mut faults = Vec::new();
    let (mut pictures, mut dark, mut decided, mut all) = (0, 0, 0, 0);
    for case in cases::all().iter().filter(|case| has_tiles(&case.scene)) {
        for name in ["basic", "pssm"] {
            for width in ["3", "5", "7", "15"] {
                let variant = |filter: &str| {
                    let shadow = Shadow::new(name).with("pcf", width).with("filter", filter);
                    Config {
                        shadow: match filter {
                            "pcf" => shadow,
                            // Pictures are too small for bounds to pay.
                            _ => shadow.with_setting("always_bounded", 1.0),
                        },
                        ..Config::default()
                    }
                };
                let mut draw = |what, filter: &str| {
                    // A case that is about a filter's width, or about ways to find a map, has its own.
                    let variant = variant(filter);
                    let choice = variant.shadow.choice(&registry, &library);
                    let choice = choice.expect("they are there");
                    let options = case.options(&variant, &choice).ok()?;
                    let options = RenderOptions { what, ..options };
                    let rendered = renderer.render(&case.scene, &options);
                    Some(rendered.expect("renders").picture)
                };
                let whole = draw(What::ShadowTerm, "pcf");
                let found = draw(What::ShadowTerm, "hpsm");
                let (Some(Picture::ShadowTerm(whole)), Some(Picture::ShadowTerm(found))) =
                    (whole, found)
                else {
                    continue;
                };
                let pairs = whole.iter().flatten().zip(found.iter().flatten());
                let differ = pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
                if differ > 0 {
                    faults.push(format!("{}, {name}, {width}: {differ} pixels", case.name));
                }
                pictures += 1;
                dark += whole.iter().flatten().filter(|term| **term < 0.5).count();
                if let Some(Picture::Fetches(counts)) = draw(What::Fetches, "hpsm") {
                    decided += counts.iter().flatten().filter(|n| **n == 1.0).count();
                    all += counts.iter().flatten().filter(|n| **n > 0.0).count();
                }
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
    // Pictures without shadow, or bounds that decide nothing, would never differ.
    assert!(pictures > 100 && dark > 100_000, "{pictures}, {dark}");
    assert!(2 * decided > all, "{decided} of {all} are decided");
}

/// Whether all lights have maps of one rectangle.
fn has_tiles(scene: &Scene) -> bool {
    let mut lights = scene.lights.iter();
    lights.all(|light| !matches!(light.light.kind, LightKind::Point { .. }))
}
