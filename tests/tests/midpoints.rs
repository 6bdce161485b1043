//! However a midpoint map is made, and however its tile is found, the picture is one: the shadow terms of the example
//! scenes, pixel by pixel.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{collections::BTreeMap, path::Path, sync::Arc};

use umbrage::{
    compose::{Composer, Target},
    render::{Gpu, Picture, RenderError, RenderOptions, Renderer, Scene, Shadow, What},
};

const DEPTHS: [&str; 3] = ["midpoint", "midpoint_sampled", "midpoint_two_passes"];
const LOOKUPS: [&str; 4] = ["packed", "masks", "matrix_texture", "storage"];

/// What is blended by hand has weights of 24 bits, what the hardware blends of 8 on many devices: of nine texels' shares
/// of the light a 256th at the most. More is a decision, where a depth is within rounding of the one compared with.
const ROUNDING: f32 = 1.0 / 256.0;

/// Pixels that may stand at such a decision, of 30,000.
const DECISIONS: usize = 3;

fn renderer() -> Renderer {
    let gpu = Arc::new(Gpu::new().unwrap_or_else(|error| panic!("{error}")));
    let library = umbrage::shader_library().expect("the shader library is sound");
    let composer = Arc::new(Composer::new(library, Target::webgpu()));
    let registry = umbrage::methods::registry().expect("names are unique");
    Renderer::new(gpu, composer, registry)
}

fn example(name: &str) -> Scene {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes");
    Scene::load(scenes.join(name)).unwrap_or_else(|error| panic!("{error}"))
}

fn terms(
    renderer: &mut Renderer,
    scene: &Scene,
    (method, axes): (&str, &[(&str, &str)]),
) -> Result<Vec<f32>, RenderError> {
    let axes = axes.iter().copied();
    let mut scene = scene.clone();
    scene.lights[0].shadow = Some(Shadow {
        method: method.to_owned(),
        axes: axes.map(|(a, v)| (a.to_owned(), v.to_owned())).collect(),
        settings: BTreeMap::new(),
    });
    let options = RenderOptions {
        width: 240,
        height: 135,
        what: What::ShadowTerm,
        ..RenderOptions::default()
    };
    match renderer.render(&scene, &options)?.picture {
        Picture::ShadowTerm(terms) => Ok(terms[0].clone()),
        _ => unreachable!("a shadow term was asked for"),
    }
}

#[test]
fn all_ways_give_one_picture() {
    let mut renderer = renderer();
    for scene_name in ["bunny_sun.ron", "leaves.ron", "suzanne_spot.ron"] {
        let scene = example(scene_name);
        for method in ["basic", "pssm"] {
            let lookups = if method == "pssm" {
                &LOOKUPS[..]
            } else {
                &[""]
            };
            let mut first: Option<Vec<f32>> = None;
            for (depth, lookup) in DEPTHS
                .iter()
                .flat_map(|d| lookups.iter().map(move |l| (*d, *l)))
            {
                let chosen = [("depth", depth), ("pcf", "5"), ("lookup", lookup)];
                let chosen = if method == "pssm" {
                    &chosen[..]
                } else {
                    &chosen[..2]
                };
                let found = terms(&mut renderer, &scene, (method, chosen));
                let found = found.unwrap_or_else(|error| panic!("{error}"));
                let Some(expected) = &first else {
                    let dark = found.iter().filter(|term| **term < 0.5).count();
                    assert!(dark > 100 && dark < found.len() / 2, "{scene_name}: {dark}");
                    first = Some(found);
                    continue;
                };
                let apart = || expected.iter().zip(&found).map(|(a, b)| (a - b).abs());
                let wrong = apart()
                    .filter(|apart| apart.is_nan() || *apart > ROUNDING)
                    .count();
                let most = apart()
                    .filter(|apart| *apart <= ROUNDING)
                    .fold(0.0, f32::max);
                println!("{scene_name}, {method}, {depth}, {lookup}: {wrong}, else {most}");
                assert!(
                    wrong <= DECISIONS,
                    "{scene_name}, {method}: {wrong} pixels of `{depth}`, `{lookup}` differ"
                );
            }
        }
    }
}

/// A cube map, and maps that are no tiles, hold the nearest depths alone; what is said names what to choose.
#[test]
fn what_cannot_hold_midpoints_says_what_can() {
    let mut renderer = renderer();
    let depth = ("depth", "midpoint");
    let mut refusal = |scene: &str, method, axes: &[(&str, &str)]| {
        let refused = terms(&mut renderer, &example(scene), (method, axes));
        refused.expect_err("refused").to_string()
    };
    assert_eq!(
        refusal("room_point.ron", "basic", &[depth]),
        "light `lamp`: the axis `depth` is midpoint, but must be nearest under a point light, whose cube map knows no other"
    );
    assert_eq!(
        refusal("bunny_sun.ron", "pssm", &[depth, ("lookup", "weights")]),
        "light `sun`: the axis `lookup` is weights, but must be masks, matrix_texture, packed or storage where `depth` is not `nearest` or `filter` is not `pcf`"
    );
}
