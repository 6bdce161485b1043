//! Distances between edges that can be written down.

use glam::DVec3;
use proptest::prelude::*;

use super::{DOWN, Made, look};
use crate::{
    figures::{
        Figures,
        edges::{Edges, side},
        surface::Surface,
    },
    truth::tests::stage::{HERE, ball, scene, square},
};

fn displaced(
    width: u32,
    height: u32,
    truth: impl Fn(f64, f64) -> f32,
    rendered: impl Fn(f64, f64) -> f32,
) -> Figures {
    let mut made = Made::new(width, height);
    for pixel in 0..made.truth.len() {
        let at = |from: usize| from as f64 + 0.5;
        let (x, y) = (at(pixel % width as usize), at(pixel / width as usize));
        made.truth[pixel] = Some(truth(x, y));
        made.rendered[pixel] = rendered(x, y);
    }
    made.figures()
}

fn lit(is_lit: bool) -> f32 {
    f32::from(u8::from(is_lit))
}

#[test]
fn a_shifted_edge_is_as_far_off_as_it_was_shifted() {
    for shift in 0..7 {
        let across = displaced(
            32,
            20,
            |x, _| lit(x > 11.0),
            |x, _| lit(x > 11.0 + f64::from(shift)),
        );
        let down = displaced(
            32,
            20,
            |_, y| lit(y > 6.0),
            |_, y| lit(y > 6.0 + f64::from(shift)),
        );
        for figures in [across, down] {
            let expected = Some(f64::from(shift));
            assert_eq!(
                [figures.edge_p50, figures.edge_p95, figures.edge_max],
                [expected; 3]
            );
        }
    }
}

/// Between two pixels in half shadow, or on one of exactly ½, the level ½ is in the same place.
#[test]
fn a_soft_edge_lies_at_its_half() {
    let ramp = |x: f64, middle: f64| ((x - middle) / 8.0 + 0.5).clamp(0.0, 1.0) as f32;
    let on_a_pixel = displaced(32, 8, |x, _| lit(x > 12.0), |x, _| ramp(x, 14.5));
    assert_eq!(on_a_pixel.edge_max, Some(2.5));
    let between = displaced(32, 8, |x, _| lit(x > 12.0), |x, _| ramp(x, 15.0));
    assert_eq!(between.edge_max, Some(3.0));
}

#[test]
fn a_larger_disc_is_larger_by_the_difference_of_the_radii() {
    let disc = |radius: f64| move |x: f64, y: f64| lit((x - 64.0).hypot(y - 64.0) > radius);
    let figures = displaced(128, 128, disc(20.0), disc(29.0));
    let [p50, p95, max] =
        [figures.edge_p50, figures.edge_p95, figures.edge_max].map(Option::unwrap_or_default);
    // A crack lies within half a pixel's diagonal of its circle.
    let margin = 2_f64.sqrt();
    for found in [p50, p95, max] {
        assert!((found - 9.0).abs() <= margin, "{found}");
    }
    assert!(p50 <= p95 && p95 <= max);
}

#[test]
fn edges_without_a_counterpart_are_a_diagonal_away() {
    let edge = |x: f64, _: f64| lit(x > 11.0);
    let none = |_: f64, _: f64| 1.0;
    for figures in [displaced(30, 40, edge, none), displaced(30, 40, none, edge)] {
        assert_eq!([figures.edge_p50, figures.edge_max], [Some(50.0); 2]);
    }
    let figures = displaced(30, 40, none, none);
    assert_eq!(
        [figures.edge_p50, figures.edge_p95, figures.edge_max],
        [None; 3]
    );
}

/// A ball that is lit before a floor that is not: a silhouette, and no shadow's edge.
#[test]
fn a_silhouette_is_no_edge() {
    let objects = vec![
        HERE.object("floor", square(20.0), DVec3::ZERO),
        HERE.object("ball", ball(1.0, 128), DVec3::new(0.0, 3.0, 0.0)),
        // Of one object with a step: two levels.
        HERE.object("stairs", stairs(), DVec3::new(6.0, 0.0, 0.0)),
    ];
    let camera = HERE.camera(
        DVec3::new(2.0, 12.0, 0.0),
        DVec3::new(2.0, 0.0, 0.0),
        DVec3::NEG_Z,
    );
    let scene = scene(objects, DOWN, camera);
    let sight = look(&scene, 120, 90);
    let surface = Surface::new(&scene, &sight).expect("one scene");
    let sides_by = |is_lit: &dyn Fn(u32, DVec3) -> bool| -> Vec<_> {
        let seen = sight.seen().iter();
        seen.map(|seen| seen.and_then(|seen| side(lit(is_lit(seen.object, seen.position)))))
            .collect()
    };
    let count = |is_lit: &dyn Fn(u32, DVec3) -> bool| {
        let sides = sides_by(is_lit);
        let facing = vec![false; sides.len()];
        let edges = Edges::new(&surface, &sides, &facing);
        edges.distances(&edges, 0.0).count()
    };
    assert!(sight.seen().iter().flatten().any(|seen| seen.object == 1));
    assert_eq!(count(&|object, _| object == 1), 0);
    assert_eq!(
        count(&|object, position| object != 2 || position.y > -11.0),
        0
    );
    // The same surfaces, cut across: there is an edge on each.
    assert!(count(&|_, position| position.z > 0.01) > 60);
}

/// Two level squares side by side, a metre apart in height.
fn stairs() -> umbrage_render::Mesh {
    let mut mesh = square(2.0);
    let upper: Vec<_> = mesh
        .positions
        .iter()
        .map(|p| p.with_y(1.5).with_x(p.x + 2.0))
        .collect();
    mesh.positions.extend(upper);
    mesh.normals.extend_from_within(..);
    mesh.uvs.extend_from_within(..);
    mesh.indices.extend([4, 6, 5, 4, 7, 6]);
    mesh
}

proptest! {
    /// Against all pairs of edges, each found in its own way: by the pixels on either side.
    #[test]
    fn distances_are_those_of_all_pairs(
        width in 1..9_usize, height in 1..9_usize,
        truth in prop::collection::vec(0..5_u8, 64), rendered in prop::collection::vec(0..5_u8, 64),
    ) {
        let made = Made::new(width as u32, height as u32);
        let surface = Surface::new(&made.scene, &made.sight).expect("one scene");
        // Lit, in shadow, half, and not compared.
        let sides = |picture: &[u8]| -> Vec<_> {
            let term = |value: &u8| [Some(0.0), Some(0.3), Some(0.5), Some(1.0), None][*value as usize];
            picture[..width * height].iter().map(|value| term(value).and_then(side)).collect()
        };
        let (a, b) = (sides(&truth), sides(&rendered));
        let expected = brute(width, height, &a, &b);
        let facing = vec![false; a.len()];
        let (a, b) = (Edges::new(&surface, &a, &facing), Edges::new(&surface, &b, &facing));
        let mut found: Vec<_> = a.distances(&b, 99.0).collect();
        found.sort_by(f64::total_cmp);
        prop_assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            prop_assert!((found - expected).abs() < 1e-12);
        }
    }
}

fn brute(
    width: usize,
    height: usize,
    a: &[crate::figures::edges::Side],
    b: &[crate::figures::edges::Side],
) -> Vec<f64> {
    use std::cmp::Ordering::{Equal, Greater, Less};
    let places = |sides: &[crate::figures::edges::Side]| {
        let mut places = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let at =
                    |x: usize, y: usize| (x < width && y < height).then(|| sides[y * width + x])?;
                let differ = |p, q| {
                    matches!(
                        (p, q),
                        (Some(Less), Some(Greater)) | (Some(Greater), Some(Less))
                    )
                };
                let (fx, fy) = (x as f64, y as f64);
                let here = at(x, y);
                let rows = [
                    (here == Some(Equal), (fx, fy)),
                    (differ(here, at(x + 1, y)), (fx + 0.5, fy)),
                    (differ(here, at(x, y + 1)), (fx, fy + 0.5)),
                ];
                places.extend(rows.into_iter().filter(|row| row.0).map(|row| row.1));
            }
        }
        places
    };
    let (a, b) = (places(a), places(b));
    let nearest = |p: &(f64, f64)| {
        let distances = b.iter().map(|q| (p.0 - q.0).hypot(p.1 - q.1));
        distances.fold(99.0, f64::min)
    };
    let mut distances: Vec<_> = a.iter().map(nearest).collect();
    distances.sort_by(f64::total_cmp);
    distances
}
