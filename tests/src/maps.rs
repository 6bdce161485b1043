//! Made-up shadow maps and receivers: planes, steps, slivers, curves, noise, holes.

use umbrage::shadow::Viewport;

/// Depths in a texture, of which tiles are maps.
pub struct Maps {
    /// By rows.
    pub depths: Vec<f32>,
    seed: u64,
    columns: u32,
    tiles: Vec<(Viewport, [f64; 3])>,
}

/// A receiver in a map.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    tile: Viewport,
    /// Texels from the tile's corner.
    at: [f32; 2],
    /// Depth's slope per texel, and depth.
    plane: [f32; 3],
}

impl Place {
    /// Its place, as the shader reads it.
    pub fn at(&self) -> [f32; 4] {
        [
            self.at[0],
            self.at[1],
            self.tile.x as f32,
            self.tile.y as f32,
        ]
    }

    /// Its plane, as the shader reads it.
    pub fn plane(&self) -> [f32; 4] {
        [self.plane[0], self.plane[1], self.plane[2], 0.0]
    }
}

impl Maps {
    /// Maps made up from `seed` in a texture of this size.
    pub fn new(seed: u64, [columns, rows]: [u32; 2], tiles: &[Viewport]) -> Self {
        let mut depths = vec![0.0; (columns * rows) as usize];
        let mut random = Random(seed);
        let mut planes = Vec::new();
        for tile in tiles {
            let ground = plane(&mut random, tile.width);
            let kind = random.below(8);
            let wall = plane(&mut random, tile.width);
            let across = [random.unit() - 0.5, random.unit() - 0.5];
            for y in 0..tile.height {
                for x in 0..tile.width {
                    let [u, v] = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                    let half = 0.5 * f64::from(tile.width);
                    let side = (u - half) * across[0] + (v - half) * across[1];
                    let bottom = depth(ground, u, v);
                    let texel = match kind {
                        // A plane, a step, slivers of one texel, a curve, noise, holes, a corner of nothing.
                        0 | 1 => bottom,
                        2 if side > 0.0 => depth(wall, u, v),
                        3 if (x * 3 + y) % 29 == 0 => 0.9,
                        4 => bottom + 0.02 * (side / half).powi(2),
                        5 => random.unit(),
                        6 if random.below(40) == 0 => 0.0,
                        7 if side > 0.0 => 0.0,
                        _ => bottom,
                    };
                    let index = (tile.y + y) * columns + tile.x + x;
                    depths[index as usize] = texel.clamp(0.0, 1.0) as f32;
                }
            }
            planes.push((*tile, ground));
        }
        Self {
            depths,
            seed,
            columns,
            tiles: planes,
        }
    }

    /// Receivers: on the ground of their map as a method biases it, above, below, or anywhere.
    pub fn places(&self, count: u32) -> Vec<Place> {
        let mut random = Random(!self.seed);
        let place = |_| {
            let (tile, ground) = self.tiles[random.below(self.tiles.len() as u64) as usize];
            let side = f64::from(tile.width);
            let mut at = [random.unit() * side, random.unit() * side];
            match random.below(8) {
                // Where blocks and tiles begin and end.
                0 => at = at.map(f64::round),
                // Where a tap reads a texel that is all but a texel away.
                1 | 2 => at = at.map(|at| at.floor() + 0.5 + 1e-4 * (random.unit() - 0.5)),
                _ => {}
            }
            let [a, b, c] = if random.below(4) == 0 {
                plane(&mut random, tile.width)
            } else {
                ground
            };
            let on = depth([a, b, c], at[0], at[1]);
            // A method's bias: a texel's slope either way, and some texels of bias.
            let slope_bias = a.abs() + b.abs();
            let bias = match random.below(8) {
                0 => 0.0,
                1 => slope_bias,
                2 => slope_bias * (1.0 + 1e-6 * random.unit()),
                3 => slope_bias + 0.1 * random.unit(),
                4 => -0.2 * random.unit(),
                // About as far as bounds need, but for what is rounded.
                5 | 6 => {
                    let side = if random.below(2) == 0 { 1.0 } else { -1.0 };
                    let rounding = 16.0 * (random.unit() - 0.5) / f64::from(1_u32 << 24);
                    side * slope_bias * (1.0 + random.unit() / 32.0) + rounding
                }
                _ => slope_bias + (0.5 + random.unit()) * (slope_bias + 1e-5),
            };
            let slope = if random.below(8) == 0 {
                [0.0; 2]
            } else {
                [a, b]
            };
            Place {
                tile,
                at: at.map(|at| at as f32),
                plane: [slope[0], slope[1], on + bias].map(|n| n as f32),
            }
        };
        (0..count).map(place).collect()
    }

    /// Whether the filter `width` texels wide finds any texel lit, and any in shadow, at `place`: by what the filter is
    /// said to be in `common/pcf.wesl`, texel by texel, in f64.
    pub fn filter(&self, place: &Place, width: u32) -> (bool, bool) {
        let width = i64::from(width);
        let line = |at: f32| -> Vec<(f64, i64)> {
            let corner = f64::from(at) - 0.5 * width as f64;
            let first = corner.floor();
            let part = corner - first;
            let weight = |column: i64| match column {
                0 => 1.0 - part,
                column if column == width => part,
                _ => 1.0,
            };
            let read = |column: i64| {
                let pair = column & !1;
                let far = weight(pair + 1) / (weight(pair) + weight(pair + 1));
                let tap = first + pair as f64 + 0.5 + far;
                (weight(column) > 0.0).then_some((tap - f64::from(at), first as i64 + column))
            };
            (0..=width).filter_map(read).collect()
        };
        let last = i64::from(place.tile.width) - 1;
        let [a, b, c] = place.plane.map(f64::from);
        let (mut any_lit, mut any_dark) = (false, false);
        for (down, row) in line(place.at[1]) {
            for &(right, column) in &line(place.at[0]) {
                let depth = (c + a * right + b * down).clamp(0.0, 1.0);
                let x = place.tile.x + column.clamp(0, last) as u32;
                let y = place.tile.y + row.clamp(0, last) as u32;
                let lit = depth >= f64::from(self.depths[(y * self.columns + x) as usize]);
                any_lit |= lit;
                any_dark |= !lit;
            }
        }
        (any_lit, any_dark)
    }
}

/// A plane's slopes per texel and its depth at a map's corner: gentle, steep, or facing the light, all but or quite.
fn plane(random: &mut Random, side: u32) -> [f64; 3] {
    let across = f64::from(side);
    let steep = [0.0, 1e-7, 1e-6, 0.05 / across, 0.5 / across, 2.0 / across];
    let steep = steep[random.below(6) as usize];
    let [a, b] = [(random.unit() - 0.5) * steep, (random.unit() - 0.5) * steep];
    let middle = 0.2 + 0.6 * random.unit();
    [a, b, middle - 0.5 * f64::from(side) * (a + b)]
}

fn depth([a, b, c]: [f64; 3], u: f64, v: f64) -> f64 {
    c + a * u + b * v
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// 0 to 1, without 1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }
}
