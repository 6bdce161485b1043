//! The method `basic` against the truth.

mod common;

use glam::DVec3;
use umbrage_measure::truth::{Source, Tracer};
use umbrage_render::{Picture, RenderOptions, Renderer, Scene, What};
use umbrage_shadow::LightKind;

use common::renderer;

const SIZE: (u32, u32) = (400, 300);
/// Metres along each side of the ground.
const GROUND: f64 = 6.0;
const RADIUS: f64 = 1.0;
/// High above the ground, so that no bias reaches its shadow.
const CENTRE: DVec3 = DVec3::new(0.0, 3.0, 0.0);
/// Texels that `basic` compares along each side.
const WIDTH: f64 = 3.0;

fn ball_in_the_sun(resolution: u32) -> Scene {
    let dir = tempfile::TempDir::new().expect("a folder");
    let path = dir.path().join("scene.ron");
    let text = format!(
        r#"(
        camera: (position: (1.3, 6, 4.7), target: (1.1, 0, 0.7), fov_degrees: 45),
        lights: [(
            kind: directional(direction: (0.4, -1, 0.27)),
            shadow: (method: "basic", axes: {{"pcf": "{WIDTH}"}}, settings: {{"resolution": {resolution}}}),
        )],
        models: [
            (shape: plane(size: ({GROUND}, {GROUND}))),
            (shape: sphere(radius: {RADIUS}, segments: 256), translation: (0, {}, 0)),
        ])"#,
        CENTRE.y
    );
    std::fs::write(&path, text).expect("written");
    Scene::load(path).expect("a sound scene")
}

fn rendered(renderer: &mut Renderer, scene: &Scene) -> Vec<f32> {
    let options = RenderOptions {
        width: SIZE.0,
        height: SIZE.1,
        what: What::ShadowTerm,
        ..RenderOptions::default()
    };
    match renderer.render(scene, &options).expect("renders").picture {
        Picture::ShadowTerm(mut lights) => lights.remove(0),
        _ => unreachable!("a shadow term was asked for"),
    }
}

/// Pixels of the ground: all, those that are lit but should not be, and the reverse. Each wrong one must
/// lie within `reach` metres of the true edge, seen along the light.
fn wrong(scene: &Scene, terms: &[f32], reach: f64) -> [usize; 3] {
    let LightKind::Directional { direction } = scene.lights[0].light.kind else {
        unreachable!("it has a sun")
    };
    let tracer = Tracer::new(scene).expect("a sound scene");
    let sight = tracer.look(SIZE.0, SIZE.1, &|| ()).expect("a size");
    let truth = tracer
        .shadow(&sight, 0, Source::Sharp, &|| ())
        .expect("a light");
    let mut counts = [0; 3];
    for ((seen, truth), term) in sight.seen().iter().zip(truth).zip(terms) {
        let Some(seen) = seen.filter(|seen| seen.object == 0) else {
            continue;
        };
        counts[0] += 1;
        let lit = *term >= 0.5;
        if truth == Some(f32::from(u8::from(lit))) {
            continue;
        }
        counts[if lit { 1 } else { 2 }] += 1;
        let offset = scene.camera.position + seen.position - CENTRE;
        let aside = offset.reject_from_normalized(direction).length();
        // The rasteriser's pixel may see the ball beside the ground, whose shadow ends elsewhere.
        assert!(
            (aside - RADIUS).abs() <= reach,
            "{offset} is {aside} m from the axis"
        );
    }
    counts
}

/// Where the ball's shadow ends in the map is known to half a texel on each axis, and a comparison of
/// W texels with weights moves its half-way value by W / 2 at the most: √2 (W + 1) / 2 texels. A texel
/// is no larger than the ground's diagonal over the resolution.
fn reach(resolution: u32) -> f64 {
    let texel = GROUND * 2_f64.sqrt() / f64::from(resolution);
    2_f64.sqrt() * 0.5 * (WIDTH + 1.0) * texel
}

#[test]
fn basic_errs_near_the_edge_alone_and_half_as_much_with_half_the_texel() {
    let mut renderer = renderer();
    let mut before: Option<f64> = None;
    for resolution in [64, 128, 256] {
        let scene = ball_in_the_sun(resolution);
        let terms = rendered(&mut renderer, &scene);
        let [all, lit, dark] = wrong(&scene, &terms, reach(resolution));
        let count = (lit + dark) as f64;
        println!("{resolution}: {lit} falsely lit, {dark} falsely dark, of {all}");
        if let Some(before) = before {
            // The displacement is a texel's share, so the band's area halves. The pixels that it meets are
            // chance: for a count n, √n either way, and three of those on both sides are a margin that
            // one run in a thousand would miss if the pixels were drawn anew.
            let margin = 3.0 * (before.sqrt() * 0.5 + count.sqrt());
            assert!(count <= 0.5 * before + margin, "{count} after {before}");
        }
        before = Some(count);
    }
}

/// The bunny on its ground: where the ground is wrongly lit or dark, the true shadow's edge, or the
/// bunny itself, is no farther than theory allows; and so few pixels are wrong.
#[test]
fn basic_keeps_to_the_edges_of_the_bunnys_shadow() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    let scene = Scene::load(folder.join("bunny_sun.ron")).expect("a sound scene");
    let terms = rendered(&mut renderer(), &scene);
    let tracer = Tracer::new(&scene).expect("a sound scene");
    let sight = tracer.look(SIZE.0, SIZE.1, &|| ()).expect("a size");
    let truth = tracer
        .shadow(&sight, 0, Source::Sharp, &|| ())
        .expect("a light");
    // The ground alone; its edges and the bunny's are none of this test's.
    let ground: Vec<_> = sight
        .seen()
        .iter()
        .zip(&truth)
        .map(|(seen, term)| seen.filter(|seen| seen.object == 1).and(*term))
        .collect();

    let LightKind::Directional { direction } = scene.lights[0].light.kind else {
        unreachable!("it has a sun")
    };
    // Sixteen metres in 2048 texels, compared five at a time; and a bias of 1.5 texels towards the
    // light. All of it on the ground, where the light's slope stretches it.
    let texel = 16.0 * 2_f64.sqrt() / 2048.0;
    let reach = (2_f64.sqrt() * 0.5 * (5.0 + 1.0) + 1.5) * texel / direction.y.abs();
    // Pixels that `reach` covers at a depth, where it is seen from straight above.
    let slope = 0.5 * scene.view(1, 1).projection.size_at(1.0).y;
    let forward = scene.camera.rotation * DVec3::NEG_Z;
    let pixels = |depth: f64| (reach * f64::from(SIZE.1) / (2.0 * depth * slope)).ceil() as i32;

    let at = |x: i32, y: i32| {
        let inside = (0..SIZE.0 as i32).contains(&x) && (0..SIZE.1 as i32).contains(&y);
        inside.then(|| ground[(y * SIZE.0 as i32 + x) as usize])
    };
    let (mut wrong, mut near) = (0, 0);
    for (index, (truth, term)) in ground.iter().zip(&terms).enumerate() {
        let Some(truth) = *truth else { continue };
        let (x, y) = (
            (index % SIZE.0 as usize) as i32,
            (index / SIZE.0 as usize) as i32,
        );
        let around = sight.seen()[index].map_or(0, |seen| pixels(seen.position.dot(forward)));
        let is_near = (-around..=around).any(|down| {
            (-around..=around)
                .any(|across| at(x + across, y + down).is_some_and(|other| other != Some(truth)))
        });
        let is_wrong = (*term >= 0.5) != (truth >= 0.5);
        assert!(
            is_near || !is_wrong,
            "pixel {x}, {y} is wrong far from any edge"
        );
        wrong += usize::from(is_wrong);
        near += usize::from(is_near);
    }
    println!(
        "{wrong} wrong, {near} so near to an edge, of {}",
        terms.len()
    );
    // The band lies on both sides of each edge, and an edge is displaced to one of them.
    assert!(2 * wrong < near, "{wrong} of {near}");
}

/// A lamp that lies on what casts: in a ceiling, on a wall, on an edge and on a corner of a box. Its maps begin
/// behind that, and so does the truth.
#[test]
fn a_lamp_on_a_surface_shines_past_it() {
    const LAMPS: [(&str, [f64; 3]); 5] = [
        ("in the ceiling", [0.3, 2.9, -0.7]),
        ("on the box's side", [0.7, 0.6, 0.2]),
        ("on the box's edge", [0.7, 1.2, 0.2]),
        ("on the box's corner", [0.7, 1.2, 0.5]),
        ("in the box", [0.2, 0.7, 0.1]),
    ];
    let mut renderer = renderer();
    for (scale, origin) in [(1.0, 0.0), (1.0, 1e6), (1e-3, 0.0), (1e4, 0.0)] {
        for (where_it_is, lamp) in LAMPS {
            let at = |[x, y, z]: [f64; 3]| {
                let [x, y, z] = [x, y, z].map(|p| origin + scale * p);
                format!("({x:?}, {y:?}, {z:?})")
            };
            let range = 30.0 * scale;
            let kinds = [
                format!("point(position: {}, range: {range:?})", at(lamp)),
                format!(
                    "spot(position: {}, direction: (0.5, -0.8, 0.3), outer_degrees: 55, range: {range:?})",
                    at(lamp)
                ),
            ];
            for kind in kinds {
                let model = |shape: &str, place: [f64; 3]| {
                    let place = at(place);
                    format!(
                        "(shape: {shape}, translation: {place}, scale: ({scale:?}, {scale:?}, {scale:?}))"
                    )
                };
                let text = format!(
                    r#"(
                    camera: (position: {}, target: {}, fov_degrees: 60, near: {:?}, far: {:?}),
                    lights: [(kind: {kind}, shadow: (method: "basic"))],
                    models: [{}, {}, {}])"#,
                    at([2.7, 2.3, 2.9]),
                    at([0.3, 0.2, 0.0]),
                    0.1 * scale,
                    100.0 * scale,
                    model("plane(size: (12, 12))", [0.0; 3]),
                    model("plane(size: (9, 9))", [0.0, 2.9, 0.0]),
                    model("box(size: (1, 1.2, 0.6))", [0.2, 0.6, 0.2]),
                );
                let dir = tempfile::TempDir::new().expect("a folder");
                let path = dir.path().join("scene.ron");
                std::fs::write(&path, text).expect("written");
                let scene = Scene::load(path).expect("a sound scene");
                let terms = rendered(&mut renderer, &scene);
                let tracer = Tracer::new(&scene).expect("a sound scene");
                let sight = tracer.look(SIZE.0, SIZE.1, &|| ()).expect("a size");
                let truth = tracer
                    .shadow(&sight, 0, Source::Sharp, &|| ())
                    .expect("a light");
                let known = sight.seen().iter().zip(&truth).zip(&terms);
                let known: Vec<_> = known
                    .filter_map(|((seen, truth), term)| Some((seen.as_ref()?, (*truth)?, *term)))
                    .collect();
                let wrong = known.iter().filter(|(_, t, r)| (*t > 0.5) != (*r > 0.5));
                let share = wrong.count() as f64 / known.len() as f64;
                // Edges, of which there are 400 pixels at the most, half of them displaced by one.
                assert!(share < 0.004, "{where_it_is}, {kind}: {share}");
                let mut floor = known.iter().filter(|(seen, ..)| seen.object == 0);
                let is_lit = floor.any(|(_, t, _)| *t > 0.5);
                assert_eq!(is_lit, where_it_is != "in the box", "{where_it_is}, {kind}");
            }
        }
    }
}
