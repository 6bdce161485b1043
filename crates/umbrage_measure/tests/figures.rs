//! The figures of the method `basic`, whose faults are known.

mod common;

use std::{path::Path, sync::Arc};

use umbrage_measure::{
    figures::{Figures, Frame, Sample, Terms, figures, shimmer},
    truth::{Sight, Source, Tracer},
};
use umbrage_render::{Picture, RenderOptions, Renderer, Scene, What};
use umbrage_shadow::ShadowPlan;

use common::renderer;

const SIZE: (u32, u32) = (480, 320);

/// A scene as rendered, and what is true of it; of its first light.
struct Measured {
    scene: Scene,
    sight: Sight,
    raster: Vec<Option<(u32, u32)>>,
    truth: Vec<Option<f32>>,
    gaps: Vec<Option<f64>>,
    rendered: Vec<f32>,
    plan: Option<ShadowPlan>,
}

impl Measured {
    fn new(renderer: &mut Renderer, scene: Scene) -> Self {
        let (width, height) = SIZE;
        let options = RenderOptions {
            width,
            height,
            what: What::ShadowTerm,
            ..RenderOptions::default()
        };
        let rendered = renderer.render(&scene, &options).expect("renders");
        let Picture::ShadowTerm(mut terms) = rendered.picture else {
            unreachable!("a shadow term was asked for")
        };
        let mut plans = rendered.report.plans;
        let options = RenderOptions {
            what: What::Triangles,
            ..options
        };
        let seen = renderer.render(&scene, &options).expect("renders");
        let Picture::Triangles(raster) = seen.picture else {
            unreachable!("triangles were asked for")
        };
        let tracer = Tracer::new(&scene).expect("a sound scene");
        let sight = tracer.look(width, height, &|| ()).expect("a size");
        let truth = tracer.shadow(&sight, 0, Source::Sharp, &|| ());
        Self {
            raster,
            truth: truth.expect("a light"),
            gaps: tracer.gaps(&sight, 0, &|| ()).expect("a light"),
            rendered: terms.swap_remove(0),
            plan: plans.swap_remove(0).map(Arc::unwrap_or_clone),
            sight,
            scene,
        }
    }

    fn figures(&self) -> Figures {
        let sample = Sample {
            light: &self.scene.lights[0].light,
            truth: &self.truth,
            gaps: &self.gaps,
            rendered: &self.rendered,
            plan: self.plan.as_ref(),
        };
        figures(&self.scene, &self.sight, &self.raster, &[sample]).expect("of one size")
    }

    fn frame(&self) -> Frame<'_> {
        Frame {
            scene: &self.scene,
            sight: &self.sight,
            raster: &self.raster,
            lights: vec![Terms {
                light: &self.scene.lights[0].light,
                truth: &self.truth,
                rendered: &self.rendered,
            }],
        }
    }
}

/// An example scene whose first light has `basic` so.
fn example(name: &str, axes: &[(&str, &str)], settings: &[(&str, f64)]) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    let mut scene = Scene::load(folder.join(name)).expect("a sound scene");
    let shadow = scene.lights[0].shadow.as_mut().expect("it has a method");
    for (axis, value) in axes {
        shadow.axes.insert((*axis).to_owned(), (*value).to_owned());
    }
    for (setting, value) in settings {
        shadow.settings.insert((*setting).to_owned(), *value);
    }
    scene
}

/// The shadow of a ball that is not in the picture, and so high above the ground that no bias reaches it.
fn ball_in_the_sun(resolution: u32, pcf: &str) -> Scene {
    let dir = tempfile::TempDir::new().expect("a folder");
    let path = dir.path().join("scene.ron");
    let text = format!(
        r#"(
        camera: (position: (2.5, 1.8, 3.2), target: (1.2, 0, 0.8), fov_degrees: 45),
        lights: [(
            kind: directional(direction: (0.4, -1, 0.27)),
            shadow: (method: "basic", axes: {{"pcf": "{pcf}"}}, settings: {{"resolution": {resolution}}}),
        )],
        models: [
            (shape: plane(size: (6, 6))),
            (shape: sphere(radius: 1, segments: 256), translation: (0, 3, 0)),
        ])"#
    );
    std::fs::write(&path, text).expect("written");
    Scene::load(path).expect("a sound scene")
}

/// Half the texel, half the displacement, and half the d / d_i; and only the edge is wrong.
#[test]
fn edges_are_displaced_by_half_as_much_with_half_the_texel() {
    let mut renderer = renderer();
    let found = [32, 64, 128, 256].map(|resolution| {
        let figures = Measured::new(&mut renderer, ball_in_the_sun(resolution, "3")).figures();
        println!("{resolution}: {figures:?}");
        assert!(figures.edge > 0.0);
        assert_eq!([figures.acne, figures.leak], [0.0; 2], "{resolution}");
        let value = |figure: Option<f64>| figure.expect("there are edges");
        [
            value(figures.edge_p95),
            value(figures.alias_p95),
            figures.edge,
        ]
    });
    for pair in found.windows(2) {
        let [[edge, alias, wrong], [edge_after, alias_after, wrong_after]] = [pair[0], pair[1]];
        // A little less than half, as the map keeps a margin of 3 texels on each side.
        let ratio = alias_after / alias;
        assert!((0.42..0.5).contains(&ratio), "{found:?}");
        // Both edges run between pixels: each is within half a pixel's diagonal of its place, before and
        // after.
        let margin = (1.0 + ratio) * 0.5_f64.sqrt();
        assert!((edge_after - ratio * edge).abs() <= margin, "{found:?}");
        assert!(wrong_after < 0.75 * wrong, "{found:?}");
    }
}

/// Across an edge, a filter W texels wide makes a ramp of W texels (a little rounder, as each fetch blends). A
/// ramp of length L is off by an x² that comes to L / 12 from end to end: the mean square grows as the
/// width, and falls as the resolution rises. An edge that is straight stays in its place; around a disc of
/// radius r it moves inwards by the filter's variance over 2 r, so that false light grows as W².
#[test]
fn error_grows_with_the_filter_and_falls_with_the_texel_as_it_must() {
    let mut renderer = renderer();
    let mut measure = |resolution, pcf| {
        let figures = Measured::new(&mut renderer, ball_in_the_sun(resolution, pcf)).figures();
        println!("{resolution}, {pcf}: {figures:?}");
        assert!(figures.edge_p50 <= Some(1.0), "{pcf}: {figures:?}");
        let wrong = figures.false_lit + figures.false_shadow;
        (figures.rmse * figures.rmse, wrong)
    };
    let near = |found: f64, expected: f64| (0.85..1.15).contains(&(found / expected));
    let [five, nine, fifteen] = ["5", "9", "15"].map(|pcf| measure(256, pcf));
    assert!(near(nine.0 / five.0, 9.0 / 5.0), "{nine:?} {five:?}");
    assert!(near(fifteen.0 / five.0, 15.0 / 5.0), "{fifteen:?} {five:?}");
    let growth = (fifteen.1 - five.1) / (nine.1 - five.1);
    assert!(near(growth, (225.0 - 25.0) / (81.0 - 25.0)), "{growth}");
    let (fine, _) = measure(512, "5");
    assert!(near(fine / five.0, 0.5), "{fine} {five:?}");
}

const SCENES: [&str; 3] = ["bunny_sun.ron", "suzanne_spot.ron", "room_point.ron"];

/// As the scenes have it, `basic` errs at edges and at contacts. Without a bias the receivers shade
/// themselves; with too much of one, what touches them does not shade them any more.
#[test]
fn each_fault_is_put_down_to_its_cause() {
    let mut renderer = renderer();
    for name in SCENES {
        let mut of = |axes: &[_], settings: &[_]| {
            let figures = Measured::new(&mut renderer, example(name, axes, settings)).figures();
            println!("{name} {axes:?} {settings:?}: {figures:?}");
            let Figures {
                acne,
                peter_panning,
                leak,
                beyond_range,
                edge,
                ..
            } = figures;
            let causes = acne + peter_panning + leak + beyond_range + edge;
            assert!((causes - figures.false_lit - figures.false_shadow).abs() < 1e-12);
            assert_eq!((figures.bad_pixels, beyond_range), (0, 0.0));
            // Where a triangle's edge goes through a pixel's middle, ray and rasteriser may differ.
            assert!(1000 * figures.left_out < figures.compared, "{name}");
            figures
        };
        let sound = of(&[], &[]);
        assert_eq!(sound.acne, 0.0, "{name}");
        assert!(
            sound.leak < 1e-4 && sound.edge + sound.peter_panning < 0.01,
            "{name}"
        );

        let unbiased = of(&[("receiver_bias", "constant")], &[("depth_bias", 0.0)]);
        assert!(
            unbiased.acne > 0.1 && unbiased.acne > 5.0 * unbiased.edge,
            "{name}"
        );
        assert!(
            unbiased.peter_panning < sound.peter_panning && unbiased.leak < 1e-4,
            "{name}"
        );

        let lifted = of(&[], &[("depth_bias", 30.0)]);
        // Of thin things, a bias lights the backs first, where nobody sees it.
        let let_through = |figures: &Figures| figures.peter_panning + figures.back_facing;
        assert!(let_through(&lifted) > 4.0 * let_through(&sound), "{name}");
        assert!(lifted.peter_panning > 2.0 * sound.peter_panning, "{name}");
        assert_eq!(lifted.acne, 0.0, "{name}");
        // Hardly anything that the bias lets through is taken for a leak.
        assert!(lifted.leak < 0.01 * lifted.peter_panning, "{name}");
    }
}

/// The map follows the camera, and so the edges of its texels move on the ground.
#[test]
fn larger_texels_shimmer_more() {
    let mut renderer = renderer();
    let mut of = |resolution: u32| {
        let frames: Vec<_> = (0..4)
            .map(|frame| {
                let mut scene = ball_in_the_sun(resolution, "3");
                scene.camera.position.x += 0.02 * f64::from(frame);
                Measured::new(&mut renderer, scene)
            })
            .collect();
        let frames: Vec<_> = frames.iter().map(Measured::frame).collect();
        shimmer(&frames)
            .expect("of one size")
            .expect("known samples")
    };
    let found = [16, 32, 64, 512].map(&mut of);
    println!("{found:?}");
    assert!(found[0] > 1e-3 && found[3] < 0.02 * found[0], "{found:?}");
    assert!(
        found.is_sorted_by(|coarse, fine| coarse > fine),
        "{found:?}"
    );
}
