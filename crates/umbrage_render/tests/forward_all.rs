//! All lights in one shader draw what a pass for each light adds up to.

mod common;

use common::{methods, renderer, scene};
use umbrage_compose::Purpose;
use umbrage_render::{Path, Picture, RenderOptions, Rendered, Renderer, Scene};

const SUN: &str = r#"(name: "sun", kind: directional(direction: (0.6, -1, -0.4)), intensity: 2.0,
    shadow: (method: "pssm", axes: {"filter": "hpsm"}, settings: {"resolution": 256, "always_bounded": 1})),"#;
const SPOT: &str = r#"(name: "spot", kind: spot(position: (2, 5, 3.5), target: (0, 0.3, -0.3), inner_degrees: 24,
    outer_degrees: 30, range: 20), color: (0.4, 0.6, 1.0), intensity: 90,
    shadow: (method: "basic", axes: {"filter": "esm", "pcf": "7"}, settings: {"resolution": 256})),"#;
const LAMP: &str = r#"(name: "lamp", kind: point(position: (-2, 2.4, 1), range: 7), color: (1.0, 0.7, 0.4), intensity: 16,
    shadow: (method: "basic", settings: {"resolution": 256})),"#;
const BARE: &str = r#"(name: "bare", kind: point(position: (3, 1, 2), range: 5), intensity: 4, shadow: (method: "none")),"#;
const MIDPOINT: &str = r#"(name: "midpoint", kind: spot(position: (-3, 5, 3), target: (0, 0, 0), inner_degrees: 24,
    outer_degrees: 30, range: 20), color: (0.9, 0.2, 0.2), intensity: 60,
    shadow: (method: "basic", axes: {"depth": "midpoint_sampled"}, settings: {"resolution": 256})),"#;

fn lit_by(lights: &[&str]) -> Scene {
    let lights = lights.concat();
    scene(&format!(
        r#"(
        camera: (position: (0, 2.2, 4.6), target: (0, 0.7, 0), fov_degrees: 45, near: 0.1, far: 60),
        ambient: (0.06, 0.06, 0.08),
        lights: [{lights}],
        models: [
            (shape: sphere(radius: 0.5), name: "ball", translation: (0, 0.7, 0), surface: "ggx",
                material: (base_color: (0.8, 0.8, 0.8), metallic: 0.5, roughness: 0.35)),
            (shape: box(size: (0.4, 0.8, 0.4)), name: "block", translation: (1.1, 0.4, 0.3),
                material: (base_color: (0.8, 0.5, 0.3))),
            (shape: plane(size: (30, 30)), name: "ground", material: (base_color: (0.7, 0.7, 0.7))),
        ])"#
    ))
}

fn render(renderer: &mut Renderer, scene: &Scene, path: Path) -> Rendered {
    let options = RenderOptions {
        width: 240,
        height: 180,
        path,
        ..RenderOptions::default()
    };
    renderer.render(scene, &options).expect("renders")
}

/// Keys of the permutations that lit surfaces, by shader.
fn lighting(rendered: &Rendered) -> Vec<usize> {
    let used = rendered.report.permutations.iter();
    let lighting = used.filter(|used| used.purpose == Purpose::Light);
    lighting.map(|used| used.keys().len()).collect()
}

/// Draws of what is seen.
fn seen(rendered: &Rendered) -> u32 {
    rendered.report.draws - rendered.report.caster_draws
}

/// The picture of all lights at once, held against one pass a light.
fn assert_equal_sums(renderer: &mut Renderer, lights: &[&str]) -> [Rendered; 2] {
    let scene = lit_by(lights);
    let both = [Path::Forward, Path::ForwardAll].map(|path| render(renderer, &scene, path));
    let [each, all] = both.each_ref().map(|rendered| match &rendered.picture {
        Picture::Shaded(pixels) => pixels.as_flattened(),
        _ => unreachable!("a shaded picture was asked for"),
    });
    // A pass a light rounds to half floats as often as there are lights; one pass, once.
    let times = (lights.len() + 1) as f32;
    let rounding = |value: f32| times * (value / 1024.0).max(2f32.powi(-24));
    for (pixel, (a, b)) in each.iter().zip(all).enumerate() {
        let bound = rounding(a.max(*b));
        assert!((a - b).abs() <= bound, "channel {pixel}: {a} and {b}");
    }
    assert!(each.iter().any(|c| *c > 0.5), "light arrives");
    both
}

#[test]
fn the_sum_equals_a_pass_for_each_light() {
    let mut renderer = renderer(methods());
    for lights in [
        &[SUN][..],
        &[SUN, SPOT],
        &[SPOT, SUN],
        &[SUN, LAMP, SPOT],
        &[LAMP, BARE, MIDPOINT],
        &[MIDPOINT, SPOT, SUN, LAMP],
        // Two of a kind are two all the same.
        &[SUN, SUN],
    ] {
        assert_equal_sums(&mut renderer, lights);
    }
}

/// An object is drawn once, by a shader of those lights alone that reach it.
#[test]
fn an_object_is_drawn_once_for_the_lights_that_reach_it() {
    let mut renderer = renderer(methods());
    let [each, all] = assert_equal_sums(&mut renderer, &[SUN, SPOT, BARE]);
    // Three objects, each in three lights, and once for what is around.
    let [each, once] = [&each, &all].map(seen);
    assert_eq!((each, once), (12, 6));
    assert_eq!(lighting(&all), [3, 3]);

    // A lamp that reaches the block alone.
    let near =
        r#"(name: "near", kind: point(position: (1.1, 1.2, 0.3), range: 0.45), intensity: 1),"#;
    let [_, all] = assert_equal_sums(&mut renderer, &[SUN, near]);
    let mut counts = lighting(&all);
    counts.sort_unstable();
    assert_eq!(counts, [1, 1, 2]);
}

/// More lights than a shader may read are split over several shaders.
#[test]
fn lights_beyond_the_targets_limits_are_added_by_further_shaders() {
    let mut renderer = renderer(methods());
    let many = [SUN, SPOT, LAMP, MIDPOINT, SUN, SPOT, LAMP, MIDPOINT, BARE];
    let [_, all] = assert_equal_sums(&mut renderer, &many);
    let counts = lighting(&all);
    assert!(counts.iter().all(|count| *count < many.len()), "{counts:?}");
    // For each of two surfaces, all lights.
    assert_eq!(counts.iter().sum::<usize>(), 2 * many.len());
}

/// A still scene draws no map, whichever way light is added.
#[test]
fn maps_are_kept() {
    let mut renderer = renderer(methods());
    let scene = lit_by(&[SUN, SPOT, LAMP]);
    let first = render(&mut renderer, &scene, Path::ForwardAll);
    let second = render(&mut renderer, &scene, Path::ForwardAll);
    assert!(first.report.kept_passes == 0 && first.report.caster_draws > 0);
    assert_eq!(second.report.caster_draws, 0);
    assert!(second.report.kept_passes > 0);
    assert!(matches!(
        (first.picture, second.picture),
        (Picture::Shaded(a), Picture::Shaded(b)) if a == b
    ));
}
