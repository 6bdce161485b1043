//! d / d_i against the formulas that it goes by.

use glam::{DMat2, DMat4, DVec2, DVec3, DVec4};
use proptest::prelude::*;
use umbrage_render::Scene;
use umbrage_shadow::{Lens, LightKind, Rect, ShadowPlan};

use super::{DOWN, floor_from, light, look, pass, plan, sun_plan};
use crate::figures::{
    Alias,
    alias::{Texel, texels},
    aliasing,
    surface::Surface,
};

const RESOLUTION: u32 = 256;
/// Half the map's width, 1 m from a spot light.
const HALF: f64 = 0.4;
/// Pixels along each side; odd, so that one sees the middle.
const SIZE: u32 = 9;

/// A floor under a spot light that shines at its middle, as planned in one map.
fn under_a_spot(eye: DVec3, lamp: DVec3) -> (Scene, ShadowPlan) {
    let direction = -lamp.normalize();
    let kind = LightKind::Spot {
        position: lamp,
        direction,
        inner_angle: 0.2,
        outer_angle: 0.5,
        range: 1000.0,
    };
    let lens = Lens::spot(lamp - eye, direction);
    let map = pass(RESOLUTION, lens.matrix(&Rect::square(HALF), 0.01, 1000.0));
    (floor_from(eye, kind), plan(vec![map], 1.5))
}

fn of_picture(scene: &Scene, plan: &ShadowPlan, size: u32) -> Vec<Option<Alias>> {
    let light = &scene.lights[0].light;
    aliasing(scene, &look(scene, size, size), light, plan).expect("one scene")
}

fn of_middle<T: Clone>(picture: &[Option<T>]) -> T {
    picture[picture.len() / 2].clone().expect("in the map")
}

fn texel_of_middle(scene: &Scene, plan: &ShadowPlan) -> Texel {
    let surface = Surface::new(scene, &look(scene, SIZE, SIZE)).expect("one scene");
    of_middle(&texels(&surface, &scene.lights[0].light, plan))
}

/// Off the floor, on neither axis.
fn above() -> impl Strategy<Value = DVec3> {
    [-8.0..8.0, 0.5..8.0, 0.1..8.0].prop_map(DVec3::from)
}

/// The angle of a cell in the middle of `cells`, which are `2 * slope` wide at 1 m.
fn angle(slope: f64, cells: u32) -> f64 {
    2.0 * slope / f64::from(cells)
}

fn close(a: f64, b: f64) -> bool {
    // The plan's matrices are f32.
    (a - b).abs() <= 1e-5 * b.abs()
}

proptest! {
    /// The printed formula, d_s r_s / (d_i r_i) · N·V / N·L, in the middle of map and picture. Away from
    /// the middle a cell is seen from farther away and aslant: it takes cos³ of the angle to the axis.
    #[test]
    fn a_spot_lights_texel_is_as_the_formula_says(eye in above(), lamp in above()) {
        let (scene, plan) = under_a_spot(eye, lamp);
        let size = |point: DVec3, from: DVec3, angle: f64| {
            let ray = (point - from).normalize();
            angle * (point - from).length() * ray.dot(-from.normalize()).powf(1.5)
        };
        let (d_s, d_i) = (angle(HALF, RESOLUTION), angle(30_f64.to_radians().tan(), SIZE));
        let sight = look(&scene, SIZE, SIZE);
        let aliases = of_picture(&scene, &plan, SIZE);
        let mut held = 0;
        for (seen, alias) in sight.seen().iter().zip(&aliases) {
            let (Some(seen), Some(alias)) = (seen, alias) else { continue };
            let point = eye + seen.position;
            let expected = size(point, lamp, d_s) / size(point, eye, d_i);
            prop_assert!(close(alias.perspective, expected), "{} {expected}", alias.perspective);
            let cosine = |from: DVec3| (from - point).normalize().y;
            let expected = cosine(eye) / cosine(lamp);
            prop_assert!(close(alias.projection, expected), "{} {expected}", alias.projection);
            held += 1;
        }
        prop_assert!(held > 0);
        let middle = of_middle(&aliases);
        let printed = d_s * lamp.length() / (d_i * eye.length())
            * (eye.normalize().y / lamp.normalize().y);
        prop_assert!(close(middle.ratio(), printed), "{} {printed}", middle.ratio());
    }

    /// From texels to pixels by way of the floor, by differences: where viewer, light and normal lie in
    /// one plane, the stretch along it is d / d_i, and the one across it is d / d_i without the slopes.
    #[test]
    fn on_one_plane_the_larger_stretch_of_the_homography_is_the_ratio(
        turns in [-1.3..1.3, -1.3..1.3], distances in [1.0..9.0, 1.0..9.0],
    ) {
        let at = |i: usize| {
            let (sin, cos) = f64::sin_cos(turns[i]);
            distances[i] * DVec3::new(sin, cos, 0.0)
        };
        let (scene, plan) = under_a_spot(at(0), at(1));
        let alias = of_middle(&of_picture(&scene, &plan, SIZE));
        let stretch = largest(homography(&scene, at(1)));
        let expected = alias.perspective * alias.projection.max(1.0);
        prop_assert!(close(stretch, expected), "{stretch} {expected}");
    }

    /// The same stretch, wherever viewer and light stand, is what the cause of an error goes by.
    #[test]
    fn a_texels_pixels_are_the_larger_stretch_of_the_homography(eye in above(), lamp in above()) {
        let (scene, plan) = under_a_spot(eye, lamp);
        prop_assume!(lamp.normalize().y > 0.06);
        let (stretch, texel) = (largest(homography(&scene, lamp)), texel_of_middle(&scene, &plan));
        prop_assert!(close(texel.pixels, stretch), "{} {stretch}", texel.pixels);
        let width = angle(HALF, RESOLUTION) * lamp.length();
        prop_assert!(close(texel.width, width) && close(texel.slope, 1.0 / lamp.normalize().y));
    }

    #[test]
    fn each_face_of_a_cube_holds_what_it_looks_at(
        eye in above(), lamp in [-2.0..2.0, 0.5..4.0, -2.0..2.0],
    ) {
        let lamp = DVec3::from(lamp);
        let scene = floor_from(eye, LightKind::Point { position: lamp, range: 1000.0 });
        let faces = Lens::cube(lamp - eye);
        let faces = faces.map(|lens| pass(RESOLUTION, lens.matrix(&Rect::square(1.0), 0.01, 1000.0)));
        let aliases = of_picture(&scene, &plan(faces.into(), 1.0), SIZE);
        for (seen, alias) in look(&scene, SIZE, SIZE).seen().iter().zip(aliases) {
            let Some(seen) = seen else { continue };
            let (d_s, d_i) = (angle(1.0, RESOLUTION), angle(30_f64.to_radians().tan(), SIZE));
            let offset = eye + seen.position - lamp;
            let cosine = offset.abs().max_element() / offset.length();
            let texel = d_s * offset.length() * cosine.powf(1.5);
            let axis = seen.position.normalize().dot(-eye.normalize());
            let expected = texel / (d_i * seen.position.length() * axis.powf(1.5));
            let alias = alias.expect("every direction is some face's");
            prop_assert!(close(alias.perspective, expected), "{} {expected}", alias.perspective);
        }
    }

    /// Any projection, affine or not, against differences.
    #[test]
    fn derivatives_are_what_differences_come_to(
        rows in prop::array::uniform16(-1.0..1.0), point in [-1.0..1.0, -1.0..1.0, -1.0..1.0],
    ) {
        let clip = DMat4::from_cols_array(&rows) + DMat4::from_diagonal(DVec4::new(0.0, 0.0, 0.0, 6.0));
        let size = DVec2::new(640.0, 360.0);
        let cells = crate::figures::surface::Cells::new(clip, size);
        let point = DVec3::from(point);
        let place = |p: DVec3| {
            let ndc = clip.project_point3(p);
            DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size
        };
        let directions = [DVec3::new(0.3, -0.4, 0.7), DVec3::new(-0.2, 0.9, 0.1)];
        let step = 1e-5;
        let [a, b] = directions.map(|d| (place(point + step * d) - place(point - step * d)) / (2.0 * step));
        let found = cells.derivative(point, directions);
        prop_assert!(found.abs_diff_eq(DMat2::from_cols(a, b), 1e-5), "{found}");
        if let Some(found) = cells.place(point) {
            prop_assert!(found.abs_diff_eq(place(point), 1e-9));
        }
    }
}

/// From the map's texels to the picture's pixels at the floor's middle, by differences and by nothing
/// of the code under test.
fn homography(scene: &Scene, lamp: DVec3) -> DMat2 {
    let eye = scene.camera.position;
    let lens = Lens::spot(lamp, -lamp.normalize());
    let clip = scene.camera.view(SIZE, SIZE).view_proj_relative();
    let texel = |p: DVec3| lens.place(p).0 / angle(HALF, RESOLUTION);
    let pixel = |p: DVec3| 0.5 * f64::from(SIZE) * clip.project_point3(p - eye).truncate();
    let step = 1e-5 * eye.length().min(lamp.length());
    let difference = |f: &dyn Fn(DVec3) -> DVec2| {
        let [x, z] = [DVec3::X, DVec3::Z].map(|d| f(step * d) - f(-step * d));
        DMat2::from_cols(x, z)
    };
    difference(&pixel) * difference(&texel).inverse()
}

/// The largest singular value, as the root of the larger eigenvalue of mᵀ m.
fn largest(m: DMat2) -> f64 {
    let m = m.transpose() * m;
    let half = 0.5 * (m.x_axis.x + m.y_axis.y);
    (half + (half * half - m.determinant()).max(0.0).sqrt()).sqrt()
}

#[test]
fn twice_the_texels_halve_it_and_three_times_the_pixels_make_it_three() {
    let direction = DVec3::new(0.5, -1.0, 0.2).normalize();
    let scene = floor_from(
        DVec3::new(2.0, 3.0, 4.0),
        LightKind::Directional { direction },
    );
    let at = |resolution: u32, size: u32| {
        of_middle(&of_picture(
            &scene,
            &sun_plan(&scene, direction, 8.0, resolution),
            size,
        ))
    };
    let (one, two, three) = (at(64, 9), at(128, 9), at(64, 27));
    assert!(close(two.ratio(), 0.5 * one.ratio()));
    assert!(close(three.ratio(), 3.0 * one.ratio()));
    // Sixteen metres in 64 texels, seen from √29 m.
    let pixel = angle(30_f64.to_radians().tan(), 9) * 29_f64.sqrt();
    assert!(close(one.perspective, 0.25 / pixel), "{one:?}");
}

#[test]
fn the_finest_map_that_holds_a_point_counts() {
    let scene = floor_from(DVec3::new(0.0, 10.0, 0.0), DOWN);
    let wide = sun_plan(&scene, DVec3::NEG_Y, 8.0, 64);
    let narrow = sun_plan(&scene, DVec3::NEG_Y, 1.0, 64);
    let alone = of_picture(&scene, &wide, 27);
    for passes in [[&wide, &narrow], [&narrow, &wide]] {
        let passes = passes.iter().flat_map(|plan| plan.passes.clone());
        let both = of_picture(&scene, &plan(passes.collect(), 1.0), 27);
        let mut finer = 0;
        for ((seen, both), alone) in look(&scene, 27, 27).seen().iter().zip(both).zip(&alone) {
            let point = seen.expect("the floor").position;
            let held = point.x.abs().max(point.z.abs()) < 1.0;
            let (both, alone) = (both.expect("in a map"), alone.expect("in a map"));
            let expected = alone.perspective / if held { 8.0 } else { 1.0 };
            assert!(close(both.perspective, expected), "{point}");
            finer += usize::from(held);
        }
        assert!((9..500).contains(&finer), "{finer}");
    }
}

#[test]
fn beside_the_map_and_against_the_light_there_is_none() {
    let scene = floor_from(DVec3::new(0.0, 10.0, 0.0), DOWN);
    let narrow = of_picture(&scene, &sun_plan(&scene, DVec3::NEG_Y, 1.0, 64), 27);
    assert!(narrow[0].is_none() && narrow[27 * 13 + 13].is_some());
    // From below the floor, which the light shines on from above.
    let below = floor_from(DVec3::new(0.0, -10.0, 0.0), DOWN);
    let behind = of_picture(&below, &sun_plan(&below, DVec3::NEG_Y, 8.0, 64), 27);
    assert!(behind.iter().all(Option::is_none));
    // The texel is there all the same, for what is wrong there.
    let texel = texel_of_middle(&below, &sun_plan(&below, DVec3::NEG_Y, 8.0, 64));
    assert!(close(texel.width, 0.25) && close(texel.slope, 1.0));
    let nothing = aliasing(
        &scene,
        &look(&scene, 3, 3),
        &light(DOWN),
        &ShadowPlan::default(),
    );
    assert_eq!(nothing, Ok(vec![None; 9]));
}

/// Light that only grazes the floor stretches a texel without end; what errors are explained by stays
/// finite.
#[test]
fn what_grazes_is_taken_at_87_degrees() {
    let direction = DVec3::new(1.0, -1e-9, 0.0).normalize();
    let scene = floor_from(
        DVec3::new(0.0, 10.0, 0.0),
        LightKind::Directional { direction },
    );
    let texel = texel_of_middle(&scene, &sun_plan(&scene, direction, 8.0, 64));
    assert!(close(texel.slope, 20.0), "{texel:?}");
    let pixel = angle(30_f64.to_radians().tan(), SIZE) * 10.0;
    assert!(close(texel.pixels, 20.0 * 0.25 / pixel), "{texel:?}");
    assert!(texel.alias.is_some_and(|alias| alias.projection > 1e8));
}

/// Three maps over one another, the coarsest for what is nearest: a pixel reads the one for its depth,
/// and the finest where none is for it.
#[test]
fn the_map_that_is_read_counts_and_not_the_finest() {
    let direction = DVec3::new(0.5, -1.0, 0.2).normalize();
    let eye = DVec3::new(2.0, 3.0, 4.0);
    let scene = floor_from(eye, LightKind::Directional { direction });
    let sight = look(&scene, 40, 40);
    let forward = scene.camera.view(40, 40).forward();
    let seen = sight.seen().iter().flatten();
    let mut depths: Vec<_> = seen.map(|seen| seen.position.dot(forward)).collect();
    depths.sort_by(f64::total_cmp);
    // Between two depths: what is at both ends of a range is in two.
    let at = |share: f64| depths[(share * depths.len() as f64) as usize] + 1e-7;
    // A gap between the last two, and nothing beyond.
    let ranges = [[0.0, at(0.2)], [at(0.2), at(0.5)], [at(0.6), at(0.8)]];
    let resolutions = [32, 256, 64];
    let of = |resolution| sun_plan(&scene, direction, 100.0, resolution);
    let mut splits = plan(Vec::new(), 1.5);
    for (range, resolution) in ranges.into_iter().zip(resolutions) {
        for mut map in of(resolution).passes {
            if let umbrage_shadow::Pass::Casters(pass) = &mut map {
                pass.receivers = Some(range);
            }
            splits.passes.push(map);
        }
    }
    let alone = resolutions.map(|resolution| of_picture(&scene, &of(resolution), 40));
    let found = of_picture(&scene, &splits, 40);
    let mut counts = [0; 4];
    for (pixel, seen) in sight.seen().iter().enumerate() {
        let Some(seen) = seen else { continue };
        let depth = seen.position.dot(forward);
        let split = ranges.iter().position(|[a, b]| (*a..=*b).contains(&depth));
        assert_eq!(found[pixel], alone[split.unwrap_or(1)][pixel], "{depth} m");
        counts[split.unwrap_or(3)] += 1;
    }
    assert!(counts.iter().all(|count| *count > 20), "{counts:?}");
    // A range whose map does not hold the point is not read: the rest decides as without it.
    for pass in &mut splits.passes[..1] {
        if let umbrage_shadow::Pass::Casters(pass) = pass {
            pass.view_proj = glam::Mat4::from_translation(glam::Vec3::X * 9.0);
        }
    }
    let beside = of_picture(&scene, &splits, 40);
    let (near, _) = (0..)
        .zip(sight.seen())
        .find(|(_, seen)| seen.is_some_and(|seen| seen.position.dot(forward) < at(0.2)))
        .expect("the nearest");
    assert_eq!(beside[near], alone[1][near]);
}
