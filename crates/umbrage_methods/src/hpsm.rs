//! Hybrid min/max plane shadow maps.
use umbrage_shadow::{ComputePass, Constants, Frame, Pass, PlanError, Reads, ShadowPlan, Value};
use wgpu_types::TextureFormat;

use crate::{
    job,
    maps::{Sheet, texture},
};

/// The format of slabs.
const FORMAT: TextureFormat = TextureFormat::Rgba32Float;

/// The side of a block, texels: the axis `block`.
pub(crate) fn block(frame: &Frame<'_>) -> Result<u32, PlanError> {
    job::choice(frame, "block", &[("2", 2), ("4", 4), ("8", 8)])
}

/// How the texels of a map are bounded: the value of the axis `filter`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bounds {
    /// Blocks and what a filter reads beyond them (`hpsm`, `min_max`).
    Around,
    /// Blocks alone (`hpsm_naive`).
    Bare,
    /// Blocks alone, and squares of 2 × 2 of them, and so on (`min_max_tree`).
    Tree,
}

impl Bounds {
    /// Adds to `plan` what bounds the depths in `sheet`, by blocks of `block` texels, for a filter `width` texels wide.
    pub(crate) fn add(self, plan: &mut ShadowPlan, sheet: &Sheet, width: u32, block: u32) {
        let (shader, name) = match self {
            Self::Around | Self::Bare => ("hpsm", "hpsm_blocks"),
            Self::Tree => ("min_max_tree", "min_max_levels"),
        };
        let Some(map) = sheet.maps.first() else {
            plan.textures.push(texture(name, FORMAT, [1, 1]));
            return;
        };
        let side = map.tile.width;
        let blocks = side.div_ceil(block);
        let [columns, rows] = sheet.size.map(|texels| texels / side);
        let across = match self {
            Self::Around | Self::Bare => blocks,
            Self::Tree => (0..levels(width, block))
                .map(|level| blocks.div_ceil(1 << level))
                .sum(),
        };
        plan.textures
            .push(texture(name, FORMAT, [columns * across, rows * blocks]));
        let groups = blocks.div_ceil(self.blocks_a_group(width, block));
        plan.passes.push(Pass::Compute(ComputePass {
            shader: shader.to_owned(),
            workgroups: [groups, groups, sheet.maps.len() as u32],
            writes: vec![name.to_owned()],
            reads: Reads {
                constants: Constants::new()
                    .with("side", Value::U32(side))
                    .with("columns", Value::U32(columns)),
                ..Reads::default()
            },
        }));
    }

    /// The most fetches that these bounds take for one receiver.
    pub(crate) fn fetches(self, width: u32, block: u32) -> u32 {
        // Of squares of this side, so many lie along a footprint of width + 1 texels at the most.
        let along = |side: u32| width.div_ceil(side) + 1;
        match self {
            Self::Around => 1,
            Self::Bare => along(block).pow(2),
            Self::Tree => (0..levels(width, block))
                .map(|level| along(block << level).pow(2))
                .sum(),
        }
    }

    /// Blocks along the part of a tile that a workgroup has: the constants of the shaders.
    fn blocks_a_group(self, width: u32, block: u32) -> u32 {
        const SPAN: u32 = 16;
        match self {
            Self::Around => {
                let beyond = (width + 3) / 4 * 2;
                let cell = block.min(1 << beyond.trailing_zeros());
                (SPAN - 2 * (beyond / cell)) / (block / cell)
            }
            Self::Bare => SPAN,
            Self::Tree => 8,
        }
    }
}

/// Levels of a tree: as many as it takes for two squares of the last to cover a footprint.
fn levels(width: u32, block: u32) -> u32 {
    u32::BITS - (width / block).leading_zeros() + 1
}
