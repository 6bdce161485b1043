//! Percentage-closer filtering of a square map on the CPU, in f64.
//!
//! It is computed the plain way, as the mean of W × W bilinear comparisons a texel apart, and so checks the
//! shader's trick of reading two columns (and rows) of texels in one fetch. One thing follows the shader
//! exactly, since it changes results: the four texels of one fetch are compared with one depth, the receiver's
//! plane at the fetch's own place.

use glam::DVec2;

/// A filter `width` texels wide in a map of `size` texels a side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Filter {
    pub width: u32,
    pub size: u32,
}

impl Filter {
    /// The share of the light that passes about `at` (texels), where the depth compared is `depth` and rises by
    /// `slope` a texel. `depth_at` is what the map holds.
    pub(crate) fn lit(
        self,
        at: DVec2,
        depth: f64,
        slope: DVec2,
        depth_at: impl Fn(u32, u32) -> f32,
    ) -> f64 {
        let (columns, rows) = (self.line(at.x), self.line(at.y));
        let mut lit = 0.0;
        for row in &rows {
            for column in &columns {
                let there = DVec2::new(column.fetch, row.fetch) - at;
                let reference = (depth + slope.dot(there)).clamp(0.0, 1.0);
                if reference >= f64::from(depth_at(column.texel, row.texel)) {
                    lit += column.weight * row.weight;
                }
            }
        }
        lit
    }

    /// The mean of `value` over the texels about `at`.
    pub(crate) fn mean(self, at: DVec2, value: impl Fn(u32, u32) -> f64) -> f64 {
        let (columns, rows) = (self.line(at.x), self.line(at.y));
        let of_row = |row: &Read| {
            let part = |c: &Read| c.weight * value(c.texel, row.texel);
            row.weight * columns.iter().map(part).sum::<f64>()
        };
        rows.iter().map(of_row).sum()
    }

    /// The texels that the filter about `middle` (texels) reads along one axis.
    fn line(self, middle: f64) -> Vec<Read> {
        let (count, last) = (self.width as usize, f64::from(self.size) - 1.0);
        // W linear fetches a texel apart, each sharing its weight between two texels.
        let first = (middle - 0.5 * f64::from(self.width)).floor();
        let mut weights = vec![0.0; count + 1];
        for fetch in 0..count {
            let place = middle + fetch as f64 - 0.5 * (f64::from(self.width) - 1.0);
            let part = (place - 0.5) - (first + fetch as f64);
            weights[fetch] += (1.0 - part) / f64::from(self.width);
            weights[fetch + 1] += part / f64::from(self.width);
        }
        // The shader reads the texels two by two, at the middle of their weights.
        let center = |i: usize| first + i as f64 + 0.5;
        let read = |i: usize| {
            let (a, b) = (i & !1, i | 1);
            let fetch =
                (weights[a] * center(a) + weights[b] * center(b)) / (weights[a] + weights[b]);
            let texel = (first + i as f64).clamp(0.0, last) as u32;
            Read {
                texel,
                weight: weights[i],
                fetch,
            }
        };
        (0..=count).map(read).collect()
    }
}

/// One texel's part in a filter, along one axis.
struct Read {
    texel: u32,
    weight: f64,
    /// Where the shader's fetch of it lies, texels.
    fetch: f64,
}
