//! Midpoint shadow maps: against the truth, and where they must be as the nearest depths are.

mod common;

use std::{collections::BTreeMap, sync::Arc};

use umbrage_compose::{Composer, Library, Target};
use umbrage_measure::{
    cases::{self, Case, Limits},
    figures::Figures,
    study::{Config, Lab, stress},
};
use umbrage_render::{Gpu, Picture, RenderOptions, Renderer, Scene, Shadow, What};

use common::renderer;

type Axes<'a> = &'a [(&'a str, &'a str)];
type Settings<'a> = &'a [(&'a str, f64)];

const NEAREST: (&str, &str) = ("depth", "nearest");
const VARIANTS: [&str; 3] = ["midpoint", "midpoint_sampled", "midpoint_two_passes"];

/// Light that slants, so that no face of an upright box is on edge to it.
const SUN: &str = "(kind: directional(direction: (0.55, -1, -0.4)))";
const LAMP: &str = "(kind: spot(position: (-2.2, 4, 1.6), direction: (0.55, -1, -0.4), inner_degrees: 30, outer_degrees: 40, range: 12))";

fn scene(light: &str, camera: &str, models: &str) -> Scene {
    let dir = tempfile::TempDir::new().expect("a folder");
    let path = dir.path().join("scene.ron");
    let text = format!("(camera: {camera}, lights: [{light}], models: [{models}])");
    std::fs::write(&path, text).expect("written");
    Scene::load(path).expect("a sound scene")
}

const ABOVE: &str = "(position: (1.6, 2.8, 4.2), target: (0.2, 0.2, 0), fov_degrees: 45)";

fn lab() -> Lab {
    let package = umbrage_shader_lib::package().expect("the shader library");
    let library = Library::new([package]).expect("the library");
    let composer = Arc::new(Composer::new(library, Target::default()));
    let registry = umbrage_methods::registry().expect("names are unique");
    let gpu = Arc::new(Gpu::new().expect("an adapter"));
    Lab::new(gpu, composer, registry)
}

/// How `basic` errs in a case, chosen so.
fn errors(lab: &mut Lab, case: &Case, axes: Axes<'_>, settings: Settings<'_>) -> Figures {
    let limits = Limits::built_in().expect("a sound table");
    let variant = Config {
        name: "basic".to_owned(),
        shadow: basic(axes, settings),
        ..Config::default()
    };
    let cases = std::slice::from_ref(case);
    let stressed = stress(lab, &[variant], cases, &limits, None, &()).expect("measured");
    stressed.results[0].figures.clone()
}

fn basic(axes: Axes<'_>, settings: Settings<'_>) -> Shadow {
    let shadow = Shadow::new("basic");
    let shadow = axes.iter().fold(shadow, |shadow, (a, v)| shadow.with(a, v));
    let settings = settings.iter();
    settings.fold(shadow, |shadow, (s, v)| shadow.with_setting(s, *v))
}

fn contact() -> Case {
    let mut cases = cases::all().into_iter();
    cases.find(|case| case.name == "contact").expect("a case")
}

/// A scene of a test's own; its limits are no one's concern.
fn own(scene: Scene) -> Case {
    Case {
        scene,
        axes: BTreeMap::new(),
        settings: BTreeMap::new(),
        ..contact()
    }
}

fn terms(
    renderer: &mut Renderer,
    scene: &Scene,
    axes: Axes<'_>,
    settings: Settings<'_>,
) -> Vec<f32> {
    let options = RenderOptions {
        width: 256,
        height: 144,
        what: What::ShadowTerm,
        shadow: basic(axes, settings),
        ..RenderOptions::default()
    };
    match renderer.render(scene, &options).expect("renders").picture {
        Picture::ShadowTerm(mut lights) => lights.remove(0),
        _ => unreachable!("a shadow term was asked for"),
    }
}

/// Pixels in which two pictures differ by more than a hundredth of the light: a bilinear weight has 8 bits on many
/// devices.
fn apart(a: &[f32], b: &[f32]) -> usize {
    let pairs = a.iter().zip(b);
    let apart = pairs.map(|(a, b)| (a - b).abs());
    apart
        .filter(|apart| apart.is_nan() || *apart > 0.01)
        .count()
}

fn dark(terms: &[f32]) -> usize {
    terms.iter().filter(|term| **term < 0.5).count()
}

#[test]
fn contacts_are_closer_than_with_the_nearest_depths() {
    let mut lab = lab();
    let case = contact();
    for pcf in ["1", "3", "5", "15"] {
        let nearest = errors(&mut lab, &case, &[NEAREST, ("pcf", pcf)], &[]);
        for depth in VARIANTS {
            let found = errors(&mut lab, &case, &[("depth", depth), ("pcf", pcf)], &[]);
            println!(
                "{pcf} {depth}: {:.5} falsely lit ({:.5}), {:.5} peter-panning ({:.5})",
                found.false_lit, nearest.false_lit, found.peter_panning, nearest.peter_panning
            );
            // Light that is let through falls on backs as well, where nobody sees it.
            let let_through = |figures: &Figures| figures.peter_panning + figures.back_facing;
            assert!(
                let_through(&found) < let_through(&nearest),
                "{depth}, {pcf}"
            );
            assert!(
                found.peter_panning <= nearest.peter_panning,
                "{depth}, {pcf}"
            );
            assert!(found.false_lit <= nearest.false_lit, "{depth}, {pcf}");
            assert!(found.leak <= nearest.leak, "{depth}, {pcf}");
            assert_eq!(found.acne, 0.0, "{depth}, {pcf}");
        }
    }
}

/// On ground that has a thickness, without any bias and whatever the receiver's plane.
#[test]
fn closed_bodies_need_no_bias() {
    let mut lab = lab();
    let models = "(shape: box(size: (12, 1, 12)), translation: (0, -0.5, 0)),
        (shape: sphere(radius: 0.5), translation: (0.8, 0.5, 0.6)),
        (shape: box(size: (0.6, 0.9, 0.5)), translation: (-0.8, 0.45, 0.4)),
        (shape: box(size: (1.2, 0.1, 0.8)), translation: (0.1, 0.7, -0.8), rotation: degrees(35, 10, 15))";
    for light in [SUN, LAMP] {
        let case = own(scene(light, ABOVE, models));
        for plane in ["constant", "plane"] {
            let unbiased: Settings<'_> = &[("depth_bias", 0.0), ("resolution", 512.0)];
            let bias = ("receiver_bias", plane);
            let nearest = errors(&mut lab, &case, &[NEAREST, bias], unbiased);
            if plane == "constant" {
                assert!(nearest.acne > 0.05, "too easy: {}", nearest.acne);
            }
            for depth in VARIANTS {
                let found = errors(&mut lab, &case, &[("depth", depth), bias], unbiased);
                println!("{plane}, {depth}: acne {} ({})", found.acne, nearest.acne);
                // A body ends in edges, where it is thin; only a plane that is followed needs no more.
                let most = if plane == "plane" {
                    0.0
                } else {
                    0.01 * nearest.acne
                };
                assert!(found.acne <= most, "{depth}, {plane}: {}", found.acne);
                assert!(found.false_lit < 0.01, "{depth}, {plane}: {found:?}");
            }
        }
    }
}

/// A sheet that faces the light, one that shows it its back, and a box whose faces look inwards, on ground that is a
/// sheet: nothing has an inside, so the bias is the receivers', and the picture the same.
#[test]
fn without_an_inside_all_is_as_with_the_nearest_depths() {
    let models = "(shape: plane(size: (12, 12))),
        (shape: plane(size: (0.9, 0.7)), translation: (0.9, 0.5, 0.7)),
        (shape: plane(size: (0.9, 0.7)), translation: (-0.9, 0.5, 0.7), rotation: degrees(180, 0, 0)),
        (shape: box(size: (0.6, 0.8, 0.5)), translation: (0, 0.4, -0.7))";
    let mut renderer = renderer();
    for light in [SUN, LAMP] {
        let mut scene = scene(light, ABOVE, models);
        turn_inside_out(&mut scene, 3);
        for pcf in ["1", "5"] {
            let size = [("resolution", 512.0)];
            let nearest = terms(&mut renderer, &scene, &[NEAREST, ("pcf", pcf)], &size);
            assert!(dark(&nearest) > 1000, "{} are dark", dark(&nearest));
            for depth in VARIANTS {
                let axes = [("depth", depth), ("pcf", pcf)];
                let found = terms(&mut renderer, &scene, &axes, &size);
                let apart = apart(&nearest, &found);
                assert!(apart <= 2, "{apart} pixels differ with {depth}, {pcf}");
            }
        }
    }
}

/// The same box, upright and mirrored, without any bias; turned inside out it shades itself.
#[test]
fn mirrors_keep_what_is_inside() {
    let models = |scale: &str| {
        format!(
            "(shape: box(size: (12, 1, 12)), translation: (0, -0.5, 0)),
            (shape: box(size: (0.9, 1.2, 0.8)), translation: (0, 0.6, 0), scale: {scale})"
        )
    };
    let mut renderer = renderer();
    let unbiased: Settings<'_> = &[("depth_bias", 0.0), ("resolution", 256.0)];
    for depth in VARIANTS {
        let axes = [("depth", depth), ("receiver_bias", "constant")];
        let upright = scene(SUN, ABOVE, &models("(1, 1, 1)"));
        let mut inside_out = upright.clone();
        turn_inside_out(&mut inside_out, 1);
        let mirrored = scene(SUN, ABOVE, &models("(-1, 1, 1)"));
        let [upright, inside_out, mirrored] = [&upright, &inside_out, &mirrored]
            .map(|scene| terms(&mut renderer, scene, &axes, unbiased));
        assert_eq!(apart(&upright, &mirrored), 0, "{depth}");
        let acne = dark(&inside_out) - dark(&upright);
        assert!(acne > 200, "{depth}: too easy, {acne}");
    }
}

fn turn_inside_out(scene: &mut Scene, object: usize) {
    let mut mesh = (*scene.objects[object].mesh).clone();
    for triangle in mesh.indices.chunks_exact_mut(3) {
        triangle.swap(1, 2);
    }
    scene.objects[object].mesh = Arc::new(mesh);
}

/// A plate under a table, above half of the way to the floor's underside: the middle of the table's top and what is
/// farthest would lie below it, and light it. Texels of 7 cm make room for middles of a metre.
#[test]
fn the_farthest_surface_is_not_the_second() {
    let models = "(shape: box(size: (12, 1, 12)), translation: (0, -0.5, 0)),
        (shape: box(size: (2, 0.1, 2)), translation: (0, 1, 0)),
        (shape: box(size: (1.6, 0.1, 1.6)), translation: (0, 0.4, 0))";
    let low = "(position: (0.4, 1.3, 3.6), target: (0, 0.5, 0), fov_degrees: 45)";
    let sun = "(kind: directional(direction: (0.1, -1, -0.1)))";
    let scene = scene(sun, low, models);
    let mut renderer = renderer();
    let mut drawn = |depth| {
        let axes = [("depth", depth), ("receiver_bias", "constant")];
        terms(&mut renderer, &scene, &axes, &[("resolution", 256.0)])
    };
    let nearest = drawn("nearest");
    assert!(dark(&nearest) > 2000, "{} are dark", dark(&nearest));
    for depth in VARIANTS {
        let found = drawn(depth);
        let both = nearest.iter().zip(&found);
        let lost = both.filter(|(dark, found)| **dark < 0.01 && **found > 0.01);
        assert_eq!(lost.count(), 0, "{depth}");
    }
}

/// Its front and the block's back are nearest to the light; their middle is inside of the block.
#[test]
fn an_open_mesh_shades_the_closed_body_behind_it() {
    let models = "(shape: box(size: (12, 2, 12)), translation: (0, -1, 0)),
        (shape: plane(size: (1.2, 1)), translation: (0, 0.3, 0))";
    let mut lab = lab();
    for light in [SUN, LAMP] {
        let case = own(scene(light, ABOVE, models));
        for depth in VARIANTS {
            let found = errors(&mut lab, &case, &[("depth", depth)], &[]);
            assert_eq!(found.leak, 0.0, "{depth}: {found:?}");
            assert!(found.false_lit < 0.003, "{depth}: {found:?}");
        }
    }
}
