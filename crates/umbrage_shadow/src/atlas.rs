//! Several maps in one texture.

use glam::DVec2;

use crate::{PlanError, Viewport};

/// Square tiles of one size in rows of one texture.
///
/// # The guard band
/// A filter about a place in a tile reads texels around it. `guard` texels along each edge of a tile hold what
/// such a filter may read and are not themselves looked up, so that none reads a neighbour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Atlas {
    tiles: u32,
    tile: u32,
    guard: u32,
}

impl Atlas {
    /// The most texels along an edge: what WebGPU promises.
    pub const MOST_TEXELS: u32 = 8192;

    /// An atlas of `tiles` tiles with `tile` texels along each side, of which `guard` along each edge are
    /// its guard band.
    ///
    /// # Errors
    /// No tile; tiles that their guard bands fill; an atlas larger than [`MOST_TEXELS`](Self::MOST_TEXELS).
    pub fn new(tiles: u32, tile: u32, guard: u32) -> Result<Self, PlanError> {
        let atlas = Self { tiles, tile, guard };
        PlanError::check(tiles > 0, "the number of tiles", tiles, "1 at the least")?;
        PlanError::check(
            u64::from(tile) > 2 * u64::from(guard),
            "a tile's size in texels",
            tile,
            &format!(
                "above {}: each edge has a guard band of {guard} for the filter",
                2 * u64::from(guard)
            ),
        )?;
        let (columns, rows) = (u64::from(atlas.columns()), u64::from(atlas.rows()));
        let longest = columns.max(rows) * u64::from(tile);
        PlanError::check(
            longest <= u64::from(Self::MOST_TEXELS),
            "the atlas's size in texels",
            format!("{} x {}", columns * u64::from(tile), rows * u64::from(tile)),
            &format!(
                "{} along each edge at the most: choose smaller tiles or fewer splits",
                Self::MOST_TEXELS
            ),
        )?;
        Ok(atlas)
    }

    /// Tiles in a row: as many as keep the texture near a square and few tiles unused.
    pub fn columns(&self) -> u32 {
        match self.tiles {
            1 => 1,
            2..=4 => 2,
            5..=6 | 9 => 3,
            7..=8 => 4,
            tiles => tiles.isqrt() + u32::from(tiles.isqrt().pow(2) < tiles),
        }
    }

    /// Rows of tiles.
    pub fn rows(&self) -> u32 {
        self.tiles.div_ceil(self.columns())
    }

    /// Texels across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.columns() * self.tile, self.rows() * self.tile]
    }

    /// The tile with this number, by rows.
    pub fn tile(&self, number: u32) -> Viewport {
        Viewport {
            x: number % self.columns() * self.tile,
            y: number / self.columns() * self.tile,
            width: self.tile,
            height: self.tile,
        }
    }

    /// Texels along a tile's side that may be looked up.
    pub fn inner(&self) -> u32 {
        self.tile - 2 * self.guard
    }

    /// A place in a tile (texels from its corner) moved to where a linear fetch reads no other tile.
    pub fn clamp(&self, at: DVec2) -> DVec2 {
        let last = f64::from(self.tile) - 0.5;
        at.clamp(DVec2::splat(0.5), DVec2::splat(last))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn apart(a: &Viewport, b: &Viewport) -> bool {
        a.x + a.width <= b.x
            || b.x + b.width <= a.x
            || a.y + a.height <= b.y
            || b.y + b.height <= a.y
    }

    proptest! {
        #[test]
        fn tiles_lie_apart_and_inside(tiles in 1u32..20, tile in 64u32..1024, guard in 0u32..16) {
            let atlas = Atlas::new(tiles, tile, guard)?;
            let [width, height] = atlas.size();
            let all: Vec<_> = (0..tiles).map(|number| atlas.tile(number)).collect();
            for (i, a) in all.iter().enumerate() {
                prop_assert!(a.x + a.width <= width && a.y + a.height <= height);
                prop_assert!(all[..i].iter().all(|b| apart(a, b)));
            }
        }

        /// Texels that a filter of width W reads about a place off the guard band are of the place's own tile, and so
        /// is what a clamped fetch reads from anywhere.
        #[test]
        fn filters_stay_in_their_tile(
            half in 0u32..8, tile in 32u32..256, at in [0.0..1.0, 0.0..1.0], far in [-9.0..9.0, -9.0..9.0],
        ) {
            let width = f64::from(2 * half + 1);
            let reach = 0.5 * width + 0.5;
            let atlas = Atlas::new(4, tile, reach.ceil() as u32)?;
            let guard = reach.ceil();
            let at = guard + DVec2::from(at) * f64::from(atlas.inner());
            let side = f64::from(tile);
            prop_assert!((at - reach).min_element() >= 0.0);
            prop_assert!((at + reach).max_element() <= side);
            let fetched = atlas.clamp(DVec2::from(far) * side);
            prop_assert!((fetched - 0.5).min_element() >= 0.0);
            prop_assert!((fetched + 0.5).max_element() <= side);
        }
    }

    #[test]
    fn packings_waste_little() -> Result<(), PlanError> {
        let shape = |tiles| Atlas::new(tiles, 8, 2).map(|atlas| [atlas.columns(), atlas.rows()]);
        let expected = [
            [1, 1],
            [2, 1],
            [2, 2],
            [2, 2],
            [3, 2],
            [3, 2],
            [4, 2],
            [4, 2],
        ];
        for (tiles, expected) in (1..).zip(expected) {
            assert_eq!(shape(tiles)?, expected);
        }
        Ok(())
    }

    #[test]
    fn what_does_not_fit_is_told() {
        let message = |tiles, tile, guard| {
            let atlas = Atlas::new(tiles, tile, guard).map_err(|error| error.to_string());
            atlas.err().unwrap_or_default()
        };
        assert_eq!(
            message(8, 4096, 2),
            "the atlas's size in texels is 16384 x 8192, but must be 8192 along each edge at the most: choose smaller tiles or fewer splits"
        );
        assert_eq!(
            message(4, 16, 8),
            "a tile's size in texels is 16, but must be above 16: each edge has a guard band of 8 for the filter"
        );
        assert_eq!(
            message(0, 16, 2),
            "the number of tiles is 0, but must be 1 at the least"
        );
        assert_ne!(message(4, u32::MAX, 2), "");
        assert_eq!(message(4, 4096, 8), "");
    }
}
