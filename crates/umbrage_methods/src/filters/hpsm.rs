//! Hybrid min/max plane shadow maps (Gruen, "Hybrid Min/Max Plane-Based Shadow Maps"): values of the axis `filter` that
//! know of most receivers what percentage-closer filtering would give, and filter the rest. Their shader halves are
//! `filters/hpsm.wesl`, `filters/hpsm_naive.wesl`, `filters/min_max_tree.wesl` and the passes of the same names.
//!
//! # How it works
//! A map is divided into blocks. Of each block a texel holds bounds of all depths that the filter of any receiver in it
//! reads: two parallel planes, by their slope per texel and their depths over the block's middle. Most receivers
//! lie before both, or behind both, at every tap of their filter: one fetch tells that they are all lit, or all in
//! shadow. The rest is filtered as `pcf` does. The law is that no pixel differs from what `pcf` gives, in any bit; the
//! tests hold it on made-up maps and receivers, and in all hard cases.
//!
//! - `hpsm`: planes along the surface at the block's middle, where there is one. Where there is none, their slope is
//!   zero, and they are the least and the greatest depth.
//! - `min_max`: the least and the greatest depth alone.
//! - `hpsm_naive`: planes of the blocks themselves. The filter's footprint lies over several, and all are fetched.
//! - `min_max_tree`: the least and the greatest depth of squares of texels, and of squares of those, and so on (Dmitriev and
//!   Uralsky 2007, "Soft Shadows Using Hierarchical Min-Max Shadow Maps"): large ones are read first, smaller ones where
//!   those leave it open.
//!
//! # Planes in texels
//! The article keeps planes in the light's linear space, and calls a block planar whose texels are within a distance
//! EPS of a plane. Here a plane is depth = c + a · x + b · y in texels: the map's projection takes planes to planes, of
//! spot lights too, so that nothing is made linear and no light has a formula of its own. A receiver's plane is in the
//! same space already, with the bias in it, and both sides of all comparisons have one unit. There is no EPS to choose:
//! the two planes are as far apart as the texels between them ask for, and a curved surface has a thicker slab. A
//! normal's length and side, and the distance that goes with it, cannot be mistaken, as there is none.
//!
//! A tap at t (texels from the receiver) compares the receiver's plane there with the four texels around, whose places
//! are t + e, each coordinate of e within one texel. With the slopes s of the receiver and g of the slab, what the two
//! differ by changes from tap to tap by no more than |s − g| · (W − 1) / 2 + |g|, slopes measured as |x| + |y|. So the
//! receiver is lit if, at its own place, its depth is that much above the slab's near plane, and in shadow if it is that
//! much below the far one. On its own surface (s = g) what is left is the bias: a tap's depth is biased by |s| already.
//! The rest is rounding: a 64th of a texel for places, 2⁻²¹ of the depths for a dozen operations in f32. An empty
//! texel, 0, counts as infinitely far: it shades nothing, and no receiver is behind it.
//!
//! # The footprint
//! The filter of width W reads W + 1 texels from floor(x − W / 2) on. Of all receivers in a block these begin (W + 1) / 2
//! texels before it, and end as many after it. Beside the tile are copies of its edge, as fetches are clamped.
//!
//! # Construction
//! One compute pass for all tiles in use. A workgroup takes 16 × 16 cells: squares of texels by which both the block
//! and what is beyond it can be divided (4 × 4 for blocks of 4 and W = 7 or 15; where (W + 1) / 2 is odd, one texel more is
//! taken in). Each cell is bounded along the plane of least squares through its texels, or flat where that plane makes
//! the slab less than twice as thin. In workgroup memory lie the cells' slabs, not their texels. A block takes the slope
//! of its middle cell and bounds its cells' slabs. Beside what the seed does, a plane through three neighbouring texels,
//! this leaves less to filter: of the bunny's receivers 18.0 % instead of 21.2 % at W = 15; the mean slope of all cells,
//! 20.7 % (where a cell is flat unless its plane makes the slab four times as thin; with twice, the middle cell's
//! leaves 17.7 %).
//!
//! # When bounds are built
//! Bounds pay where many receivers share a map's texels. A texel costs about two fetches to build, whatever is seen. Of
//! a receiver's F = ((W + 1) / 2)² fetches half are saved, in the scenes below, and the decision itself takes the time of
//! about nine. So bounds are built only where
//!
//! > pixels · (F / 2 − 9) > 2 · texels,
//!
//! with the pixels of the camera's depth and the texels of all of the light's maps: never for filters up to 7 wide, and
//! for a map of 2048² with W = 15 from 365,000 pixels on. Elsewhere no pass is planned, and the shader filters as `pcf`
//! does, with the same terms and fetches. Where a frame does not tell the size of the camera's depth, bounds are built.
//!
//! # Settings and axes
//! `always_bounded`: 1 builds bounds whether or not they pay, to measure or to test them.
//! `block`: texels along a block, 2, 4 or 8. Smaller blocks decide more; larger ones cost less to build.
//! `pcf` is the filter's width, as ever.
//!
//! # Cost
//! 16 bytes a block; each texel is read 1.3 to 4 times to build (W = 15: blocks of 8, 4, 2 texels 1.3, 1.8, 4), four by a
//! gather. A receiver takes one fetch (`hpsm`, `min_max`), and ((W + 1) / 2)² more where it stays open.
//!
//! Receivers decided with W = 15, in percent of those that sample a map, blocks of 4 (pixels of `umbrage render --size
//! 640x360 --axis pcf=15 --axis filter=hpsm --setting always_bounded=1 --what decisions`; `umbrage compare` has the same of the samples that it
//! compares); beside it how many have a term that is neither 0 nor 1, which no bounds could decide:
//!
//! | scene | method | partly lit | `hpsm` | `hpsm_naive` | `min_max` | `min_max_tree` |
//! | --- | --- | ---: | ---: | ---: | ---: | ---: |
//! | bunny_sun | `basic` | 10.0 | 82.3 | 84.3 | 2.0 | 2.8 |
//! | suzanne_spot | `basic` | 4.6 | 91.8 | 91.7 | 1.4 | 2.3 |
//! | leaves | `basic` | 27.1 | 69.5 | 70.3 | 1.6 | 1.7 |
//! | avenue | `pssm` | 31.0 | 51.8 | 54.0 | 1.9 | 2.5 |
//! | avenue | `basic` | 62.9 | 21.0 | 23.3 | 0.2 | 0.8 |
//!
//! The time saved depends on the device. Fetches are the same on all: of 64 a receiver at W = 15, with blocks of 8,
//! `hpsm` leaves 6.9 (suzanne_spot), 14.4 (bunny_sun), 21.8 (leaves), 34.1 (avenue, `pssm`); of 16 at W = 7 2.2, 3.7, 5.5, 8.2.
//! On Mesa's llvmpipe, a CPU, the time of building and of the shadow terms of 1280 × 720 pixels, each found once, is 0.36,
//! 0.53, 0.65 and 0.78 of `pcf`'s at W = 15, 0.59 of the sum; at W = 7 0.81, 1.42, 1.43 and 1.55. Where objects are drawn one
//! after another it is 0.48, 0.58, 0.67 and 0.87: what is hidden later is filtered, a receiver on a triangle's rim for its
//! neighbour as well, and those left open lie where triangles are small (`cargo bench --profile dev -p umbrage_bench --bench methods`). Of `pcf`'s
//! 70 ms in bunny_sun, building takes 9, 10 are for all but the filter, and the rest for receivers left open, and for rows of
//! the filter that no receiver takes: a branch there is a mask and no jump. At W = 7 `pcf` takes 20 ms, and
//! building alone 12. The partly lit, which no bounds spare, would by themselves leave 0.06, 0.12, 0.28 and 0.32 of the fetches.
//!
//! The least and the greatest depth decide next to nothing: a receiver on a slope is between the two in its own block,
//! whatever its bias.
//!
//! # Limits
//! Point lights are refused, whose maps are cubes, and the lookups of `pssm` that bind maps of their own. Curved
//! receivers and those at edges stay open. A filter three texels wide is cheaper than what would spare it.

use umbrage_shadow::{
    ComputePass, Constants, Filter, Frame, Maps, Part, Pass, PlanError, Reads, SamplerDesc,
    Setting, ShadowPlan, TextureDesc, Value,
};
use wgpu_types::{FilterMode, TextureFormat};

use super::{Width, pcf};

/// The format of slabs.
const FORMAT: TextureFormat = TextureFormat::Rgba32Float;

/// Whether bounds are built where they do not pay.
const ALWAYS: Setting = Setting {
    name: "always_bounded",
    doc: "1: bounds of maps are built even where they cost more than the fetches that they save",
    min: 0.0,
    max: 1.0,
    default: 0.0,
    whole: true,
};

/// Costs of bounds in the time of one fetch by `pcf`, as Mesa's llvmpipe takes it: of a texel to build, and of a
/// receiver's decision.
const BUILT: u64 = 2;
const DECISION: u64 = 9;

/// The filters `hpsm`, `hpsm_naive`, `min_max` and `min_max_tree`: how the texels of a map are bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hpsm {
    /// Blocks and what a filter reads beyond them, by planes.
    Planes,
    /// Blocks alone, by planes.
    Naive,
    /// Blocks and what a filter reads beyond them, by the least and the greatest depth.
    MinMax,
    /// Blocks alone, squares of 2 × 2 of them, and so on, by the least and the greatest depth.
    MinMaxTree,
}

impl Part for Hpsm {
    fn name(&self) -> &str {
        match self {
            Self::Planes => "hpsm",
            Self::Naive => "hpsm_naive",
            Self::MinMax => "min_max",
            Self::MinMaxTree => "min_max_tree",
        }
    }

    fn settings(&self) -> &[Setting] {
        &[ALWAYS]
    }

    fn axes(&self) -> &[&str] {
        &["block", Width::AXIS]
    }
}

impl Filter for Hpsm {
    fn reach(&self, frame: &Frame<'_>, number: usize) -> Result<f64, PlanError> {
        Ok(Width::of(frame)?.reach(number))
    }

    fn fetches(&self, frame: &Frame<'_>, number: usize) -> Result<u32, PlanError> {
        // The bounds are those of the widest filter.
        let bounds = self.fetches_of_bounds(Width::of(frame)?.widest, block(frame)?);
        Ok(bounds + pcf::fetches(frame, number)?)
    }

    fn prepare(
        &self,
        frame: &Frame<'_>,
        maps: &Maps,
        plan: &mut ShadowPlan,
    ) -> Result<(), PlanError> {
        maps.check_reversed(self.name())?;
        let (width, block) = (Width::of(frame)?.widest, block(frame)?);
        let (shader, name) = match self {
            Self::Planes | Self::Naive | Self::MinMax => ("hpsm", "hpsm_blocks"),
            Self::MinMaxTree => ("min_max_tree", "min_max_levels"),
        };
        if maps.maps.is_empty() || !is_bounded(frame, maps)? {
            // A tile with more blocks along than this has texels has no bounds: so the shader knows.
            plan.textures.push(TextureDesc::d2(name, FORMAT, [1, 1]));
            return Ok(());
        }
        let side = maps.side();
        let [columns, rows] = maps.size.map(|texels| texels / side);
        let [across, blocks] = self.size(side, block);
        let size = [columns * across, rows * blocks];
        plan.textures.push(TextureDesc::d2(name, FORMAT, size));
        plan.samplers
            .push(SamplerDesc::new("depths_sampler", FilterMode::Nearest));
        let groups = blocks.div_ceil(self.blocks_a_group(width, block));
        plan.passes.push(Pass::Compute(ComputePass {
            shader: shader.to_owned(),
            workgroups: [groups, groups, maps.maps.len() as u32].into(),
            writes: vec![name.into()],
            reads: Reads {
                constants: Constants::new()
                    .with("side", Value::U32(side))
                    .with("columns", Value::U32(columns)),
                ..Reads::default()
            },
        }));
        Ok(())
    }
}

/// Whether bounds of `maps` save more fetches than they cost, or are wanted in any case. A tile of one block costs next
/// to nothing.
fn is_bounded(frame: &Frame<'_>, maps: &Maps) -> Result<bool, PlanError> {
    let is_wanted = frame.setting(&ALWAYS)? == 1.0 || maps.side() <= block(frame)?;
    let Some([width, height]) = frame.camera_depth else {
        return Ok(true);
    };
    let [width, height, side] = [width, height, maps.side()].map(u64::from);
    let texels = side.pow(2).saturating_mul(maps.maps.len() as u64);
    let widest = u64::from(Width::of(frame)?.widest);
    let fetches = (widest + 1).pow(2) / 4;
    let saved = (fetches / 2).saturating_sub(DECISION);
    let pays = (width.saturating_mul(height)).saturating_mul(saved) > BUILT.saturating_mul(texels);
    Ok(pays || is_wanted)
}

/// The side of a block, texels: the axis `block`.
fn block(frame: &Frame<'_>) -> Result<u32, PlanError> {
    frame.choice("block", &[("2", 2), ("4", 4), ("8", 8)])
}

impl Hpsm {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Planes, Self::Naive, Self::MinMax, Self::MinMaxTree];

    /// Texels across and down that bound a tile with `side` texels along each edge. They are no more than the tile's own
    /// from 34 texels on, and few below: what bounds a map fits on a device wherever the map does.
    fn size(self, side: u32, block: u32) -> [u32; 2] {
        let blocks = side.div_ceil(block);
        let across = match self {
            Self::Planes | Self::Naive | Self::MinMax => blocks,
            // Room for those of the widest filter: narrower ones may read what was built for a wider.
            Self::MinMaxTree => (0..levels(Width::MOST, block))
                .map(|level| blocks.div_ceil(1 << level))
                .sum(),
        };
        [across, blocks]
    }

    /// The most fetches that these bounds take for one receiver.
    fn fetches_of_bounds(self, width: u32, block: u32) -> u32 {
        // Of squares of this side, so many lie along a footprint of width + 1 texels at the most.
        let along = |side: u32| width.div_ceil(side) + 1;
        match self {
            Self::Planes | Self::MinMax => 1,
            Self::Naive => along(block).pow(2),
            Self::MinMaxTree => (0..levels(width, block))
                .map(|level| along(block << level).pow(2))
                .sum(),
        }
    }

    /// Blocks along the part of a tile that a workgroup has: the constants of the shaders.
    fn blocks_a_group(self, width: u32, block: u32) -> u32 {
        const SPAN: u32 = 16;
        match self {
            Self::Planes | Self::MinMax => {
                let beyond = 2 * width.div_ceil(4);
                let cell = block.min(1 << beyond.trailing_zeros());
                (SPAN - 2 * (beyond / cell)) / (block / cell)
            }
            Self::Naive => SPAN,
            Self::MinMaxTree => 8,
        }
    }
}

/// Levels of a tree: as many as it takes for two squares of the last to cover a footprint.
fn levels(width: u32, block: u32) -> u32 {
    u32::BITS - (width / block).leading_zeros() + 1
}

#[cfg(test)]
mod tests {
    use umbrage_shadow::{Atlas, MAX_SPLITS};

    use super::*;

    #[test]
    fn what_bounds_a_map_fits_where_the_map_fits() {
        for tiles in 1..=MAX_SPLITS as u32 {
            for side in 1..=Atlas::MOST_TEXELS {
                let Ok(atlas) = Atlas::new(tiles, side, 0) else {
                    continue;
                };
                for bounds in Hpsm::ALL {
                    for block in [2, 4, 8] {
                        let [across, down] = bounds.size(side, block);
                        let size = [atlas.columns() * across, atlas.rows() * down];
                        let longest = size[0].max(size[1]);
                        assert!(
                            longest <= Atlas::MOST_TEXELS,
                            "{bounds:?} by {block}, {tiles} x {side}: {size:?}"
                        );
                        let is_small = longest <= atlas.size()[0].max(atlas.size()[1]);
                        assert!(
                            is_small || side < 34,
                            "{bounds:?} by {block}, {tiles} x {side}"
                        );
                    }
                }
            }
        }
    }
}
