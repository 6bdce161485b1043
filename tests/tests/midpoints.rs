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

/// Blending by hand has weights of 24 bits, blending by hardware of 8 on many devices: of nine texels' shares of the light a
/// 256th at the most. More is a decision, where a depth is within rounding of the one compared with.
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

/// A cube map, and maps that are no tiles, hold the nearest depths alone, and no bounds can be built of depths that are
/// made while sampling; what is said names what to choose.
#[test]
fn what_does_not_go_together_says_what_does() {
    let mut renderer = renderer();
    let mut refused = |scene: &str, method, axes: &[(&str, &str)], [said, advice]: [&str; 2]| {
        let refused = terms(&mut renderer, &example(scene), (method, axes));
        let refused = refused.expect_err("refused").to_string();
        assert!(
            refused.contains(said) && refused.contains(advice),
            "{refused}"
        );
    };
    let depth = ("depth", "midpoint");
    refused(
        "room_point.ron",
        "basic",
        &[depth],
        [
            "light `lamp`: the combination depth=midpoint,light=point,method=basic,pass=shadow_term is excluded: depth=midpoint needs `planar`",
            "choose light=directional or light=spot, or another value for `depth`",
        ],
    );
    let tiles = "choose lookup=masks or lookup=matrix_texture or lookup=packed or lookup=storage";
    for (axis, value) in [depth, ("filter", "esm"), ("filter", "hpsm")] {
        refused(
            "bunny_sun.ron",
            "pssm",
            &[(axis, value), ("lookup", "weights")],
            [&format!("{axis}={value} needs `tiles`"), tiles],
        );
    }
    refused(
        "bunny_sun.ron",
        "basic",
        &[("depth", "midpoint_sampled"), ("filter", "hpsm")],
        [
            "filter=hpsm needs `stored_depths`",
            "depth=midpoint or depth=midpoint_two_passes or depth=nearest",
        ],
    );
}
