//! All ways to find a split's map give the same picture: the shadow terms of the example scenes, pixel by pixel.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{collections::BTreeMap, path::Path, sync::Arc};

use umbrage::{
    compose::{Composer, Target},
    render::{Gpu, Picture, RenderOptions, Renderer, Scene, Shadow, What},
};

const LOOKUPS: [&str; 7] = [
    "packed",
    "branches",
    "channels",
    "masks",
    "matrix_texture",
    "storage",
    "weights",
];

/// Coordinates differ in the last digits of f32, so that a texel's weight does in 10,000ths; more only where a
/// depth is within rounding of the one compared with, and then by a whole texel of the filter.
const ROUNDING: f32 = 1e-3;

/// Pixels that may stand at such a decision, of 30,000.
const DECISIONS: usize = 3;

#[test]
fn all_lookups_give_one_picture() {
    let gpu = Arc::new(Gpu::new().unwrap_or_else(|error| panic!("{error}")));
    let library = umbrage::shader_library().expect("the shader library is sound");
    let composer = Arc::new(Composer::new(library, Target::webgpu()));
    let registry = umbrage::methods::registry().expect("names are unique");
    let mut renderer = Renderer::new(gpu, composer, registry);
    let mut terms = |scene: &Scene| {
        let options = RenderOptions {
            width: 240,
            height: 135,
            what: What::ShadowTerm,
            ..RenderOptions::default()
        };
        let rendered = renderer.render(scene, &options);
        match rendered.unwrap_or_else(|error| panic!("{error}")).picture {
            Picture::ShadowTerm(terms) => terms[0].clone(),
            _ => unreachable!("a shadow term was asked for"),
        }
    };
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes");
    for name in ["bunny_sun", "leaves", "suzanne_spot"] {
        let path = scenes.join(name).with_extension("ron");
        let mut scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        for transition in ["hard", "blend", "dither"] {
            let mut first: Option<Vec<f32>> = None;
            for lookup in LOOKUPS {
                let chosen = [("lookup", lookup), ("transition", transition)];
                let axes = chosen.map(|(axis, value)| (axis.to_owned(), value.to_owned()));
                scene.lights[0].shadow = Some(Shadow {
                    method: "pssm".to_owned(),
                    axes: axes.into(),
                    // Splits of like lengths: bands of some width in each scene.
                    settings: BTreeMap::from([("lambda".to_owned(), 0.3)]),
                });
                let found = terms(&scene);
                let Some(expected) = &first else {
                    // A picture without shadow, or without light, would be alike everywhere.
                    let dark = found.iter().filter(|term| **term < 0.5).count();
                    assert!(
                        dark > 100 && dark < found.len() / 2,
                        "{name}: {dark} are dark"
                    );
                    first = Some(found);
                    continue;
                };
                let apart = expected.iter().zip(&found).map(|(a, b)| (a - b).abs());
                let wrong = apart
                    .filter(|apart| apart.is_nan() || *apart > ROUNDING)
                    .count();
                assert!(
                    wrong <= DECISIONS,
                    "{name}, {transition}: {wrong} pixels of `{lookup}` differ from `packed`"
                );
            }
        }
    }
}
