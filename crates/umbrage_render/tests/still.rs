//! A stable fit's shadows stay where they are while the camera moves: walls that the camera looks straight at, and steps
//! of whole pixels, so that the same points are seen in all pictures and nothing of a measure's own stands between.

mod common;

use std::collections::BTreeMap;

use common::{methods, renderer, scene};
use glam::DVec3;
use umbrage_render::{Picture, RenderOptions, Renderer, Scene, Shadow, What};
use umbrage_shadow::Field;

/// Metres from the camera to the two walls: one pixel on the farther is two on the nearer.
const DEPTHS: [f64; 2] = [20.0, 10.0];

/// Steps of the camera in pixels of the farther wall: no whole number of texels, near and far.
const STEPS: [[i32; 2]; 6] = [[1, 0], [3, -2], [-4, 1], [7, 6], [0, -9], [-11, 5]];

/// Pixels across and down.
const SIZE: [i32; 2] = [320, 240];

/// How far a term may move: a texel's weight in 3 × 3 by what f32 leaves open of a place, a 1000th of a texel.
const ROUNDING: f32 = 1e-3;

struct Seen {
    terms: Vec<f32>,
    /// The number of the wall.
    walls: Vec<Option<usize>>,
}

/// The farther wall is `side` metres wide and high, the nearer one half as wide.
fn walls(side: f64) -> Scene {
    let (half, middle) = (0.5 * side, -0.25 * side);
    scene(&format!(
        r#"(
        camera: (position: (0, 0, 20), target: (0, 0, 0), fov_degrees: 60, near: 0.5, far: 60),
        lights: [(name: "sun", kind: directional(direction: (-0.5, -0.35, -0.79)))],
        models: [
            (shape: box(size: ({side}, {side}, 0.2)), name: "far", translation: (0, 0, -0.1)),
            (shape: box(size: ({half}, {side}, 0.2)), name: "near", translation: ({middle}, 0, 9.9)),
            (shape: sphere(radius: 0.7, segments: 24), translation: (3, 2, 2)),
            (shape: box(size: (0.3, 5, 0.3)), translation: (5, 0, 1.5), rotation: degrees(10, 20, 30)),
            (shape: sphere(radius: 0.4, segments: 24), translation: (-1.5, -1, 11)),
            (shape: box(size: (2.5, 0.12, 0.12)), translation: (-2, 1.5, 11), rotation: degrees(10, 20, 30)),
        ])"#
    ))
}

fn look(renderer: &mut Renderer, scene: &Scene) -> Seen {
    let mut draw = |what| {
        let [width, height] = SIZE.map(|side| side as u32);
        let options = RenderOptions {
            width,
            height,
            what,
            ..RenderOptions::default()
        };
        renderer.render(scene, &options).expect("renders").picture
    };
    let (Picture::ShadowTerm(mut terms), Picture::Triangles(triangles)) =
        (draw(What::ShadowTerm), draw(What::Triangles))
    else {
        unreachable!("as asked for")
    };
    let wall = |seen: Option<(u32, u32)>| {
        let (object, _) = seen?;
        (object < 2).then_some(object as usize)
    };
    Seen {
        terms: terms.swap_remove(0),
        walls: triangles.into_iter().map(wall).collect(),
    }
}

/// Of the points seen in both pictures, the camera having moved by `step`: how many there are, how many have another term,
/// and how many are on another side of ½. A step is so many pixels on the farther and on the nearer wall.
fn compare(first: &Seen, then: &Seen, step: [i32; 2], pixels: [i32; 2]) -> [usize; 3] {
    let [width, height] = SIZE;
    let mut counts = [0; 3];
    for y in 0..height {
        for x in 0..width {
            let before = (y * width + x) as usize;
            let Some(wall) = first.walls[before] else {
                continue;
            };
            let (x, y) = (x - pixels[wall] * step[0], y + pixels[wall] * step[1]);
            let after = (y * width + x) as usize;
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            if !inside || then.walls[after] != Some(wall) {
                continue;
            }
            let [a, b] = [first.terms[before], then.terms[after]];
            counts[0] += 1;
            counts[1] += usize::from((a - b).abs() > ROUNDING);
            counts[2] += usize::from((a < 0.5) != (b < 0.5));
        }
    }
    counts
}

#[test]
fn a_moving_camera_leaves_stable_shadows_alone() {
    let mut renderer = renderer(methods());
    // A pixel of the farther wall, metres.
    let pixel = 2.0 * 30f64.to_radians().tan() * DEPTHS[0] / f64::from(SIZE[1]);
    // Walls of 24 m are less than the balls around the splits: their maps hold all that there is.
    let spreading = DEPTHS.map(|depth| (DEPTHS[0] / depth) as i32);
    let parallel = [1; 2];
    for (side, origin, fit, pixels) in [
        (60.0, 0.0, "stable", spreading),
        (60.0, 1e6, "stable", spreading),
        (24.0, 0.0, "stable", spreading),
        (24.0, 1e6, "stable", spreading),
        (60.0, 0.0, "tight", spreading),
        (60.0, 0.0, "stable", parallel),
        (60.0, 1e6, "stable", parallel),
        (24.0, 0.0, "stable", parallel),
        (60.0, 0.0, "tight", parallel),
    ] {
        let mut scene = walls(side);
        if pixels == parallel {
            let height = pixel * f64::from(SIZE[1]);
            scene.camera.field = Field::Orthographic { height };
        }
        let axes = BTreeMap::from([("fit".to_owned(), fit.to_owned())]);
        scene.lights[0].shadow = Some(Shadow {
            method: "pssm".to_owned(),
            axes,
            settings: BTreeMap::from([("resolution".to_owned(), 512.0)]),
        });
        for object in &mut scene.objects {
            object.transform.translation.x += origin;
            object.bounds = object.mesh.bounds(&object.transform);
        }
        scene.camera.position.x += origin;
        let first = look(&mut renderer, &scene);
        let dark = first.terms.iter().filter(|term| **term < 0.5).count();
        assert!(dark > 300, "{dark} are dark");
        let mut sum = [0; 3];
        for step in STEPS {
            let mut moved = scene.clone();
            let [x, y] = step.map(|pixels| f64::from(pixels) * pixel);
            // Parallel rays are as long as one likes.
            let z = if pixels == parallel { 0.3 * x } else { 0.0 };
            moved.camera.position += DVec3::new(x, y, z);
            let counts = compare(&first, &look(&mut renderer, &moved), step, pixels);
            for (sum, count) in sum.iter_mut().zip(counts) {
                *sum += count;
            }
        }
        let [seen, moved, flipped] = sum;
        assert!(seen > 300_000, "{seen} points");
        if fit == "stable" {
            assert_eq!(
                (moved, flipped),
                (0, 0),
                "{side}, {origin}: of {seen} points"
            );
        } else {
            // Motion is found in what follows the camera: the test can fail.
            assert!(moved > 1000 && flipped > 20, "{moved}, {flipped}");
        }
    }
}
