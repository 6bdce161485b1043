//! How far apart true and rendered shadow edges are.

use std::cmp::Ordering;

use image::{GrayImage, Luma};
use imageproc::{definitions::Image, distance_transform::euclidean_squared_distance_transform};

use super::surface::Surface;

/// On which side of ½ a term is: lit is greater. None where it is not compared, or not a number.
pub(super) type Side = Option<Ordering>;

pub(super) fn side(term: f32) -> Side {
    term.partial_cmp(&0.5)
}

/// The edges in a picture of terms: where its level is ½. They lie on a grid twice as fine as the
/// picture's, where the pixel (x, y) stands at (2x, 2y): between two neighbours that see one
/// surface and are on different sides, or on a pixel that is ½ itself.
pub(super) struct Edges {
    /// Those that somebody sees: on what faces the light.
    places: Vec<[u32; 2]>,
    /// The squared distance to the nearest edge, seen or not, in steps of the grid; none without an edge.
    field: Option<Image<Luma<f64>>>,
}

impl Edges {
    pub(super) fn new(surface: &Surface, sides: &[Side], back_facing: &[bool]) -> Self {
        let pixels = 0..sides.len();
        let halves = pixels
            .clone()
            .filter(|pixel| sides[*pixel] == Some(Ordering::Equal))
            .map(|pixel| (pixel, pixel));
        let cracks = pixels
            .flat_map(|a| surface.around(a).map(move |b| (a, b)))
            .filter(|(a, b)| {
                let opposite = sides[*a].map(Ordering::reverse);
                let differ = opposite.is_some_and(Ordering::is_ne) && opposite == sides[*b];
                a < b && differ && surface.is_one(*a, *b)
            });
        let between = |(a, b): (usize, usize)| {
            let ([ax, ay], [bx, by]) = (surface.column_row(a), surface.column_row(b));
            [(ax + bx) as u32, (ay + by) as u32]
        };
        let edges: Vec<_> = halves.chain(cracks).collect();
        let (width, height) = (2 * surface.width as u32 - 1, 2 * surface.height as u32 - 1);
        let field = (!edges.is_empty()).then(|| {
            let mut grid = GrayImage::new(width, height);
            for [x, y] in edges.iter().copied().map(between) {
                grid.put_pixel(x, y, Luma([255]));
            }
            euclidean_squared_distance_transform(&grid)
        });
        let is_seen = |(a, b): &(usize, usize)| !back_facing[*a] && !back_facing[*b];
        let places = edges.into_iter().filter(is_seen).map(between).collect();
        Self { places, field }
    }

    /// How far a pixel's centre is from the nearest edge, in pixels; infinite without an edge.
    pub(super) fn at_pixel(&self, [x, y]: [usize; 2]) -> f64 {
        self.at_place([2 * x as u32, 2 * y as u32])
    }

    fn at_place(&self, [x, y]: [u32; 2]) -> f64 {
        let squared = self.field.as_ref().map(|field| field.get_pixel(x, y).0[0]);
        squared.map_or(f64::INFINITY, |squared| 0.5 * squared.sqrt())
    }

    /// How far each of these edges that is seen is from the nearest of the others, in pixels; `farthest` where
    /// there are no others.
    pub(super) fn distances(&self, others: &Self, farthest: f64) -> impl Iterator<Item = f64> {
        let distance = move |place: &[u32; 2]| others.at_place(*place).min(farthest);
        self.places.iter().map(distance)
    }
}
