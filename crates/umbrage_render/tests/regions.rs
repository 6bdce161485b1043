//! A mask filled region by region is the mask of one pass, and each pixel is its own region's.

mod common;

use std::collections::BTreeMap;

use common::{
    example, methods,
    probe::{probing, refusal},
    renderer, scene, small,
};
use glam::{DVec2, DVec3};
use umbrage_compose::ProjectedKey;
use umbrage_render::{Gpu, Path, Picture, RenderOptions, Rendered, Renderer, Scene, Shadow, What};
use umbrage_shadow::{Frame, Region, ShadowPlan};

/// Another permutation may round its sums in another order; where a depth is within rounding of the one compared
/// with, a texel falls the other way.
const ROUNDING: f32 = 1e-4;

/// The share of pixels that may stand at such a decision.
const DECISIONS: f64 = 1e-4;

/// How far the forward path's terms may be from a mask's, and the share that may be farther: see `masks.rs`.
const STEP: f32 = 1.0 / 256.0;
const FORWARD: f64 = 1e-4;

fn options(path: Path, axes: &[(&str, &str)]) -> RenderOptions {
    let shadow = Shadow::new("pssm");
    RenderOptions {
        width: 480,
        height: 320,
        what: What::ShadowTerm,
        shadow: axes.iter().fold(shadow, |shadow, (a, v)| shadow.with(a, v)),
        path,
        fresh: true,
        ..RenderOptions::default()
    }
}

fn terms(rendered: &Rendered) -> &[f32] {
    match &rendered.picture {
        Picture::ShadowTerm(lights) => &lights[0],
        _ => unreachable!("shadow terms were asked for"),
    }
}

/// How many of the terms are apart by more than rounding; NaN is.
fn apart(a: &Rendered, b: &Rendered, rounding: f32) -> usize {
    let (a, b) = (terms(a), terms(b));
    assert_eq!(a.len(), b.len());
    let near = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() <= rounding);
    a.len() - near.count()
}

#[test]
fn region_by_region_the_mask_is_the_same() {
    let mut renderer = renderer(methods());
    for name in ["avenue.ron", "leaves.ron", "suzanne_spot.ron"] {
        let mut scene = example(name);
        for transition in ["hard", "blend", "dither"] {
            let axes = [("transition", transition), ("pcf", "7")];
            scene.lights[0].shadow = Some(Shadow {
                method: "pssm".to_owned(),
                // Splits of like lengths: several of them in each scene.
                settings: [("lambda".to_owned(), 0.3)].into(),
                ..Shadow::default()
            });
            let [once, split] = [Path::Mask, Path::MaskBySplit].map(|path| {
                let options = options(path, &axes);
                renderer.render(&scene, &options).expect("renders")
            });
            let dark = terms(&once).iter().filter(|term| **term < 0.5).count();
            assert!(dark > 1000, "{name}: {dark} pixels in shadow");
            let passes = split.report.passes - once.report.passes;
            assert!(passes >= 3, "{name}: {passes} passes more");
            let count = apart(&once, &split, ROUNDING);
            let most = DECISIONS * terms(&once).len() as f64;
            assert!(count as f64 <= most, "{name}, {transition}: {count} apart");
        }
    }
}

/// With a width for each split, the loop of one pass, and the constant widths of a pass each, are one filter.
#[test]
fn tapering_filters_are_one_on_all_paths() {
    let mut renderer = renderer(methods());
    // Splits of such sizes that a filter's width in the far ones is seen.
    for (name, lambda) in [
        ("avenue.ron", 0.9),
        ("leaves.ron", 0.9),
        ("suzanne_spot.ron", 1.0),
    ] {
        let mut scene = example(name);
        scene.lights[0].shadow = Some(Shadow {
            method: "pssm".to_owned(),
            settings: [("lambda".to_owned(), lambda)].into(),
            ..Shadow::default()
        });
        for transition in ["hard", "blend", "dither"] {
            let mut render = |path, taper: &str| {
                let axes = [("transition", transition), ("pcf", "7"), ("taper", taper)];
                renderer
                    .render(&scene, &options(path, &axes))
                    .expect("renders")
            };
            let all = [Path::Forward, Path::Mask, Path::MaskBySplit];
            let [forward, once, split] = all.map(|path| render(path, "on"));
            let even = render(Path::Mask, "off");
            let pixels = terms(&once).len() as f64;
            // It is seen at all.
            let count = apart(&even, &once, 0.1);
            assert!(count > 200, "{name}: {count} changed");
            let count = apart(&once, &split, ROUNDING);
            assert!(
                count as f64 <= DECISIONS * pixels,
                "{name}, {transition}: {count} apart"
            );
            // Noise is of a position's bits, which the forward path has of its own.
            let count = apart(&forward, &once, STEP);
            assert!(
                transition == "dither" || count as f64 <= FORWARD * pixels,
                "{name}, {transition}: {count} apart"
            );
            // A constant width for each split, each less by two texels than the one before.
            let used = split.report.permutations.iter().map(|used| &used.key);
            let constant =
                |key: &&ProjectedKey| key.get("pass") == Some("mask") && key.get("taper").is_none();
            let widths = used
                .filter(constant)
                .map(|key| key.get("pcf").unwrap_or("3"));
            let widths: Vec<_> = widths.collect();
            let all = ["7", "5", "3", "1"];
            assert!(widths.len() > 1 && all.starts_with(&widths), "{widths:?}");
        }
    }
}

/// Its term tells which permutation a pixel was shaded with.
const STRIPES: &str = "fn calc_shadow(position_ws: vec3f) -> f32 {
    @if(PCF_1) return 0.25;
    @elif(PCF_5) return 0.5;
    @else return 0.75;
}";

fn striped(regions: &[(f64, &str)]) -> Renderer {
    let region = |(end, width): &(f64, &str)| Region {
        end: *end,
        axes: BTreeMap::from([("pcf".to_owned(), (*width).to_owned())]),
    };
    let regions: Vec<_> = regions.iter().map(region).collect();
    probing(STRIPES, move |_: &Frame<'_>| ShadowPlan {
        regions: regions.clone(),
        ..ShadowPlan::default()
    })
}

fn floor() -> Scene {
    scene(
        r#"(
        camera: (position: (0, 2, 0), target: (1, 0, -9), near: 0.1, far: 400),
        lights: [(name: "sun", kind: directional(direction: (0, -1, 0)))],
        models: [(shape: plane(size: (300, 300)))])"#,
    )
}

/// The view depth at which a pixel sees the floor, if it does.
fn depth(scene: &Scene, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> Option<f64> {
    let view = scene.view(width, height);
    let at = (DVec2::new(x.into(), y.into()) + 0.5) / DVec2::new(width.into(), height.into());
    let ndc = DVec3::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.5);
    let ray = view.view_proj_relative().inverse().project_point3(ndc);
    let hit = ray * (-view.position.y / ray.y);
    let inside = (hit + view.position).abs().max_element() < 150.0;
    (ray.y < 0.0 && inside).then(|| hit.dot(view.forward()))
}

/// Whether a rasteriser's grid may move what a pixel sees to the other side: by more where it sees far.
fn is_near(depth: f64, end: f64) -> bool {
    (depth - end).abs() < 0.01 * end * end / 2.0
}

#[test]
fn each_pixel_is_shaded_by_its_own_region() {
    let regions = [(4.0, "1"), (4.5, "5"), (9.0, "1"), (60.0, "3")];
    let expected = [0.25, 0.5, 0.25, 0.75, 1.0];
    let scene = floor();
    let options = RenderOptions {
        shadow: Shadow::new("probe"),
        path: Path::MaskBySplit,
        timed: true,
        ..small(What::ShadowTerm)
    };
    let rendered = striped(&regions).render(&scene, &options).expect("renders");
    let mut seen = [0; 6];
    for (pixel, term) in terms(&rendered).iter().enumerate() {
        let at = [pixel as u32 % rendered.width, pixel as u32 / rendered.width];
        let Some(depth) = depth(&scene, at, [rendered.width, rendered.height]) else {
            assert_eq!(*term, 1.0, "the sky at {at:?}");
            seen[5] += 1;
            continue;
        };
        if regions.iter().any(|(end, _)| is_near(depth, *end)) {
            continue;
        }
        let number = regions.iter().filter(|(end, _)| depth >= *end).count();
        assert_eq!(*term, expected[number], "{depth} m at {at:?}");
        seen[number] += 1;
    }
    assert!(seen.iter().all(|count| *count > 20), "{seen:?}");
    // Planes, regions, a pass for each region, and the picture's own.
    assert_eq!(rendered.report.passes, 2 + 4 + 1);
    assert_eq!(rendered.report.mask_bytes, 24 * 160 * 120);
    if Gpu::new().expect("an adapter").has_timestamps() {
        let times = rendered.report.times.iter();
        let times: Vec<_> = times
            .map(|time| (time.pass.as_str(), time.light.as_deref()))
            .collect();
        let sun = Some("sun");
        let masks = ["mask 0", "mask 1", "mask 2", "mask 3"].map(|pass| (pass, sun));
        let mut expected = vec![("linear_depth", None), ("region", sun)];
        expected.extend(masks);
        expected.push(("shadow_term", sun));
        assert_eq!(times, expected);
    }
}

/// A hue ends where its split does: what is told of a pixel is what its view depth says, and nothing beyond the reach.
#[test]
fn splits_are_seen_where_they_are_read() {
    let scene = floor();
    let options = RenderOptions {
        shadow: Shadow::new("pssm").with_setting("shadow_distance", 40.0),
        ..small(What::Splits)
    };
    let rendered = renderer(methods())
        .render(&scene, &options)
        .expect("renders");
    let Picture::Splits { colors, splits } = &rendered.picture else {
        unreachable!("splits were asked for")
    };
    let plan = rendered.report.plans[0].as_ref().expect("a plan");
    let ends: Vec<_> = plan.regions.iter().map(|region| region.end).collect();
    assert_eq!(ends.len(), 4);
    assert_eq!(ends.last(), Some(&40.0));
    let mut seen = [0; 6];
    for (pixel, split) in splits[0].iter().enumerate() {
        let at = [pixel as u32 % rendered.width, pixel as u32 / rendered.width];
        let Some(depth) = depth(&scene, at, [rendered.width, rendered.height]) else {
            assert_eq!(*split, None, "the sky at {at:?}");
            seen[5] += 1;
            continue;
        };
        if ends.iter().any(|end| is_near(depth, *end)) {
            continue;
        }
        let number = ends.iter().filter(|end| depth >= **end).count();
        let expected = (number < 4).then_some(number as u32);
        assert_eq!(*split, expected, "{depth} m at {at:?}");
        seen[number] += 1;
    }
    assert!(seen.iter().all(|count| *count > 20), "{seen:?}");
    let shaded = RenderOptions {
        what: What::Shaded,
        ..options
    };
    let shaded = renderer(methods())
        .render(&scene, &shaded)
        .expect("renders");
    assert!(shaded.picture == Picture::Shaded(colors.clone()));
}

/// A region that no receiver's box reaches into has no pass, and leaves the rest as it is.
#[test]
fn what_is_in_no_region_costs_no_pass() {
    let mut scene = floor();
    let options = RenderOptions {
        shadow: Shadow::new("probe"),
        path: Path::MaskBySplit,
        ..small(What::ShadowTerm)
    };
    let mut renderer = striped(&[
        (0.05, "1"),
        (1.0, "1"),
        (9.0, "5"),
        (900.0, "3"),
        (1e6, "1"),
    ]);
    let passes = |rendered: Rendered| rendered.report.passes;
    // Before the near plane nothing is seen, and nothing beyond the floor's end.
    let all = renderer.render(&scene, &options).expect("renders");
    assert!(terms(&all).contains(&0.75) && terms(&all).contains(&0.5));
    assert_eq!(passes(all), 2 + 3 + 1);
    let floor = &mut scene.objects[0];
    floor.transform.translation.z = -200.0;
    floor.bounds = floor.mesh.bounds(&floor.transform);
    let far = renderer.render(&scene, &options).expect("renders");
    assert!(!terms(&far).contains(&0.5));
    assert_eq!(passes(far), 2 + 1 + 1);
    // One pass does where a plan has no regions.
    let once = striped(&[]).render(&scene, &options).expect("renders");
    assert_eq!(once.report.mask_bytes, 20 * 160 * 120);
    assert_eq!(passes(once), 1 + 1 + 1);
}

#[test]
fn regions_that_cannot_be_are_named() {
    let refused = |regions: &[(f64, &str)]| refusal(&mut striped(regions));
    let message = refused(&[(2.0, "3"), (2.0, "1")]);
    assert!(message.contains("from 2 m to 2 m"), "{message}");
    assert!(refused(&[(f64::NAN, "3")]).contains("to NaN m"));
    assert!(refused(&[(-1.0, "3")]).contains("from 0 m to -1 m"));
    let many: Vec<_> = (1..=17).map(|i| (f64::from(i), "3")).collect();
    assert!(refused(&many).contains("17 regions of view depth: 16 at the most"));
    let mut strange = probing(STRIPES, |_: &Frame<'_>| ShadowPlan {
        regions: vec![Region {
            end: 1.0,
            axes: BTreeMap::from([("lookup".to_owned(), "masks".to_owned())]),
        }],
        ..ShadowPlan::default()
    });
    let message = refusal(&mut strange);
    assert!(
        message.contains("the axis `lookup`, which is none of its axes"),
        "{message}"
    );
}
