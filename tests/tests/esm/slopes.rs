//! Effect of a slope: where a receiver's distance from the light grows by a share s of the range a texel, its term is
//! multiplied by sinh(x) / x, x = k s W / 2, whatever else makes it, be it light, a leak, or what lies behind.
//!
//! Sheets are parallel, and steep along x, for the light is tilted or they are. A map's contents change at a line of
//! equal distance, so that a window has the same slope on both sides of it.

use glam::{DMat4, DVec2, DVec3};

use crate::studio::{Choice, Drawn, FILTERS, RESOLUTION, Sheet, Studio, rounding};

/// The filter's, texels.
const WIDTH: u32 = 15;

/// The camera's height.
const EYE: f64 = -9.0;

/// Where what a window holds changes, z: no axis of symmetry, on which the middles of texels lie.
const EDGE: f64 = 0.011;

/// Half the length of the sheets along x and z.
const HALF: DVec2 = DVec2::new(8.0, 1.4);

/// A receiver through the origin, and what of the map lies how far in front of it along the light (metres): before the edge
/// and beyond it.
struct Case {
    name: &'static str,
    gaps: [f64; 2],
}

const CASES: [Case; 3] = [
    Case {
        name: "a shadow's edge",
        gaps: [3.0, 0.0],
    },
    Case {
        name: "something behind",
        gaps: [3.0, -0.03],
    },
    Case {
        name: "two occluders",
        gaps: [3.0, 0.2],
    },
];

/// How steep the sheets are towards the light, the tangent, and what the documentation says of it.
const STEEP: [(f64, f64); 2] = [(1.0, 1.2), (3.0, 3.9)];

/// Parts of the scene that tilt.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Tilted {
    Light,
    Sheets,
}

impl Case {
    /// The receiver's sheet first.
    fn sheets(&self, tilted: Tilted, tangent: f64) -> Vec<Sheet> {
        // From a sheet to the one a metre nearer to the light along its direction: up, and along x.
        let (up, along) = match tilted {
            Tilted::Sheets => (1.0, 0.0),
            Tilted::Light => (1.0 / tangent.hypot(1.0), -tangent / tangent.hypot(1.0)),
        };
        let sheet = |gap: f64, from: f64, to: f64| Sheet {
            min: DVec2::new(gap * along - HALF.x, from),
            max: DVec2::new(gap * along + HALF.x, to),
            height: gap * up,
        };
        let [before, beyond] = self.gaps;
        // A receiver ends where something is behind it.
        let end = if beyond < 0.0 { EDGE } else { HALF.y };
        let mut sheets = vec![sheet(0.0, -HALF.y, end)];
        for (gap, from, to) in [(before, -HALF.y, EDGE), (beyond, EDGE, HALF.y)] {
            if gap != 0.0 {
                sheets.push(sheet(gap, from, to));
            }
        }
        sheets
    }
}

/// A map, and how the receiver lies in it.
struct Map {
    /// Camera-relative to texels.
    to_texels: DMat4,
    slope: f64,
    /// The map's axis along which the receiver is steep, and by which share of the range a texel.
    axis: usize,
    steep: f64,
}

impl Map {
    fn new(drawn: &Drawn, slope: f64) -> Self {
        let to_texels = DMat4::from_translation(DVec3::new(0.5, 0.5, 0.0) * RESOLUTION)
            * DMat4::from_scale(DVec3::new(0.5 * RESOLUTION, -0.5 * RESOLUTION, -1.0))
            * drawn.view_proj();
        let mut map = Self {
            to_texels,
            slope,
            axis: 0,
            steep: 0.0,
        };
        let [here, x, z] = [DVec2::ZERO, DVec2::X, DVec2::Y].map(|place| map.at(place));
        let (x, z) = (x - here, z - here);
        map.axis = usize::from(x.y.abs() > x.x.abs());
        map.steep = x.z / x[map.axis];
        assert!(
            x[1 - map.axis].abs() < 1e-3 && z[map.axis].abs() < 1e-3 && z.z.abs() < 1e-6,
            "lines of equal distance lie along an axis: {x}, {z}"
        );
        map
    }

    /// A place of the receiver in the map, and its share of the range.
    fn at(&self, place: DVec2) -> DVec3 {
        let there = DVec3::new(place.x, self.slope * place.x, place.y);
        self.to_texels.transform_point3(there - EYE * DVec3::Y)
    }

    /// How much of a window about `place` lies beyond the edge, which is between texels.
    fn beyond(&self, place: DVec2) -> f64 {
        let across = 1 - self.axis;
        let edge = self.at(DVec2::new(place.x, EDGE))[across];
        let away = self.at(place)[across] - (edge - 0.5).ceil();
        let towards = (self.at(DVec2::Y) - self.at(DVec2::ZERO))[across].signum();
        (0.5 + towards * away / f64::from(WIDTH)).clamp(0.0, 1.0)
    }
}

/// Factors by which a slope multiplies a term, between texels' middles and on them: their mean, and what a bilinear fetch
/// makes of an exponential halfway.
fn factors(exponent: f64, steep: f64) -> [f64; 2] {
    let half = 0.5 * exponent * steep.abs();
    let width = f64::from(WIDTH);
    let mean = (width * half).sinh() / (width * half.sinh());
    [mean, mean * half.cosh()]
}

/// Their distances are known: what a window holds, and so its term, follows from where its middle lies.
#[test]
fn slopes_multiply_terms_by_the_hyperbolic_sine() {
    let mut studio = Studio::new();
    studio.size = 512;
    for (tangent, documented) in STEEP {
        for tilted in [Tilted::Light, Tilted::Sheets] {
            (studio.sun, studio.slope) = match tilted {
                Tilted::Light => (DVec3::new(tangent, -1.0, 0.0).normalize(), 0.0),
                Tilted::Sheets => (DVec3::NEG_Y, tangent),
            };
            for filter in FILTERS {
                for case in &CASES {
                    let choice = Choice {
                        filter,
                        width: WIDTH,
                        exponent: 0.0,
                    };
                    let drawn = studio.draw(&case.sheets(tilted, tangent), EYE, &choice);
                    let map = Map::new(&drawn, studio.slope);
                    let about = format!("{tangent}, {tilted:?}, {filter}, {}", case.name);
                    let factor = case.check(&drawn, &map, filter, &about);
                    // The others are at the largest exponents of their formats.
                    if filter == "esm_log" {
                        let off = factor / documented - 1.0;
                        assert!(off.abs() < 0.03, "{about}: {factor}, not {documented}");
                    }
                }
            }
        }
    }
}

impl Case {
    /// Compares the terms about the edge; gives the factor.
    fn check(&self, drawn: &Drawn, map: &Map, filter: &str, about: &str) -> f64 {
        let exponent = drawn.exponent();
        let (range, _) = drawn.range();
        let factors = factors(exponent, map.steep);
        let parts = self
            .gaps
            .map(|gap| (-exponent * (gap / range - drawn.bias())).exp());
        // Weights of 8 bits in a fetch, between two rows and two columns.
        let rows = parts[0].max(parts[1]) / f64::from(WIDTH) / 256.0;
        let columns = (exponent * map.steep.abs()).exp_m1() / 256.0;
        let mut told = 0;
        // Far from where the sheets end; and the receiver, not what lies behind it.
        let end = if self.gaps[1] < 0.0 { EDGE } else { 0.5 };
        let is_seen = |at: DVec2| at.x.abs() < 1.0 && (-0.5..end).contains(&at.y);
        for (place, term) in drawn.at(is_seen) {
            let beyond = map.beyond(place);
            let mean = beyond * parts[1] + (1.0 - beyond) * parts[0];
            let [least, most] = factors.map(|factor| factor * mean);
            let bound = (rounding(filter, exponent) + columns) * most + rows * factors[1];
            assert!(
                (least.min(1.0) - bound..=most.min(1.0) + bound).contains(&term),
                "{about}, {place}, of which {beyond} beyond: {term}, not {least} to {most}"
            );
            told += usize::from((0.01..0.99).contains(&beyond) && least < 0.98);
        }
        assert!(told > 100, "{about}: {told} pixels tell");
        factors[0]
    }
}
