//! The mask path by regions of view depth: a pass over the picture for each, with its own permutation.
//!
//! A depth-bounds test (Salvi, "Fast percentage closer filtering on deferred cascaded shadow maps") with WebGPU's means: one
//! pass writes each pixel's region as a depth, and a triangle at exactly that depth, compared with *equal*, is shaded in its
//! region alone, each pixel once. The depth test rejects pixels before they are shaded: the permutations write no depth and
//! discard nothing.

use umbrage_shadow::{Constants, MAX_REGIONS, Region, Value};
use umbrage_wgpu::{ColorState, DrawState, ShadowResources};

use super::{
    Renderer,
    frame::{FrameState, LightInputs, state},
    lights::Term,
    masks::{MaskPass, Masked, Masks, TERM},
    target::DEPTH,
};
use crate::{RenderError, scene::Object};

/// From one region's depth to the next one's, as the shader has it: floats hold each of them exactly.
const STEP: f32 = 1.0 / 32.0;

/// How much farther than told a region is looked for, relative: beyond any rounding of a view depth.
const PADDING: f64 = 1.0 / 8192.0;

impl Renderer {
    /// Fills the mask where the light's receivers are, region by region.
    pub(super) fn fill_by_region(
        &mut self,
        frame: &mut FrameState<'_>,
        masks: &mut Masks,
        light: Masked<'_>,
    ) -> Result<(), RenderError> {
        let Some(shadow) = light.reads.shadow else {
            return Ok(());
        };
        let depth = self.lay_regions(frame, masks, light, &shadow.regions)?;
        let mut start = light.shot.view.projection.near;
        for (number, region) in shadow.regions.iter().enumerate() {
            let seen = seen_between(light, [start, region.end]);
            start = start.max(region.end);
            if seen.is_empty() {
                continue;
            }
            let part = Masked {
                reads: LightInputs {
                    term: Term::Region(&region.axes),
                    ..light.reads
                },
                ..light
            };
            let pass = MaskPass {
                name: &format!("mask {number}"),
                color: (&masks.mask, None),
                depth: (&depth, false),
                level: (number + 1) as f32 * STEP,
                area: light.area(frame, &seen),
            };
            let inputs = part.inputs(
                self.pass("mask")?,
                state(TERM, wgpu::CompareFunction::Equal),
            );
            self.draw_mask(frame, part, &inputs, &pass)?;
        }
        Ok(())
    }

    /// Writes each pixel's region as a depth, and clears the mask.
    fn lay_regions(
        &mut self,
        frame: &mut FrameState<'_>,
        masks: &mut Masks,
        light: Masked<'_>,
        regions: &[Region],
    ) -> Result<wgpu::TextureView, RenderError> {
        let depth = match masks.regions.clone() {
            Some(known) => known,
            None => {
                let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
                self.mask_part(frame, "the regions seen", DEPTH, usage)?
            }
        };
        masks.regions = Some(depth.clone());
        let constants = ShadowResources {
            constants: ends(regions),
            ..ShadowResources::default()
        };
        let by_regions = Masked {
            reads: LightInputs {
                shadow: Some(&constants),
                ..light.reads
            },
            ..light
        };
        let nothing = ColorState {
            format: TERM,
            blend: None,
            channels: wgpu::ColorWrites::empty(),
        };
        let region = self.pass("region")?;
        let written = DrawState {
            colors: vec![nothing],
            write_depth: region.writes_depth,
            ..state(TERM, wgpu::CompareFunction::Always)
        };
        let inputs = by_regions.inputs(region, written);
        let pass = MaskPass {
            name: inputs.pass.name,
            color: (&masks.mask, Some(wgpu::Color::WHITE)),
            depth: (&depth, true),
            level: 0.0,
            area: light.area(frame, light.receivers),
        };
        self.draw_mask(frame, by_regions, &inputs, &pass)?;
        Ok(depth)
    }
}

/// The light's receivers that may be seen between two view depths.
fn seen_between<'a>(light: Masked<'a>, [start, end]: [f64; 2]) -> Vec<&'a Object> {
    if end <= start {
        return Vec::new();
    }
    let view = &light.shot.view;
    let part = view.part_relative(start * (1.0 - PADDING), end * (1.0 + PADDING));
    let near = |object: &Object| object.bounds.translate(-view.position);
    let receivers = light.receivers.iter().copied();
    receivers
        .filter(|object| part.intersects(&near(object)))
        .collect()
}

/// The members of the shader's block `regions`.
fn ends(regions: &[Region]) -> Constants {
    let last = regions.last();
    let end = |i: usize| regions.get(i).or(last).map_or(0.0, |r| r.end as f32);
    let four = |i: usize| Value::Vec4([0, 1, 2, 3].map(|j| end(4 * i + j)).into());
    let all = (0..MAX_REGIONS.div_ceil(4)).map(four).collect();
    Constants::new().with("ends", Value::Array(all))
}
