//! Hybrid min/max plane shadow maps.
use umbrage_shadow::{ComputePass, Constants, Pass, PlanError, Frame, Reads, ShadowPlan, Value};
use wgpu_types::TextureFormat;

use crate::{
    job,
    maps::{Sheet, texture},
};

/// The binding of the texture with a slab for each block.
const BLOCKS: &str = "hpsm_blocks";

/// The side of a block, texels: the axis `block`.
pub(crate) fn block(frame: &Frame<'_>) -> Result<u32, PlanError> {
    job::choice(frame, "block", &[("2", 2), ("4", 4), ("8", 8)])
}

/// Adds to `plan` what bounds the depths in `sheet`, around blocks of `block` texels for a filter `width` texels wide.
pub(crate) fn add(plan: &mut ShadowPlan, sheet: &Sheet, width: u32, block: u32) {
    let Some(map) = sheet.maps.first() else {
        plan.textures.push(texture(BLOCKS, TextureFormat::Rgba32Float, [1, 1]));
        return;
    };
    let side = map.tile.width;
    let blocks = side.div_ceil(block);
    let tiles = sheet.size.map(|texels| texels / side);
    let size = tiles.map(|tiles| tiles * blocks);
    plan.textures.push(texture(BLOCKS, TextureFormat::Rgba32Float, size));
    let groups = blocks.div_ceil(blocks_a_group(width, block));
    let constants = Constants::new()
        .with("side", Value::U32(side))
        .with("columns", Value::U32(tiles[0]));
    plan.passes.push(Pass::Compute(ComputePass {
        shader: "hpsm".to_owned(),
        workgroups: [groups, groups, sheet.maps.len() as u32],
        writes: vec![BLOCKS.to_owned()],
        reads: Reads {
            constants,
            ..Reads::default()
        },
    }));
}

/// Blocks along the part of a tile that a workgroup has: the constants of the shader's `passes/hpsm.wesl`.
fn blocks_a_group(width: u32, block: u32) -> u32 {
    const SPAN: u32 = 16;
    let beyond = (width + 3) / 4 * 2;
    let cell = block.min(1 << beyond.trailing_zeros());
    (SPAN - 2 * (beyond / cell)) / (block / cell)
}
