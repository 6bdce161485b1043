//! What the shader's way to find a split's map reads.

use glam::{DVec4, Vec4};
use umbrage_shadow::{
    Atlas, CasterPass, Constants, DepthTest, Frame, MAX_SPLITS, Pass, PlanError, SamplerDesc,
    ShadowPlan, TextureDesc, TextureShape, Value, Viewport,
};
use wgpu_types::{CompareFunction, FilterMode, TextureFormat};

use super::fit::{Job, Split, Splits, Transition};
use crate::job;

/// The binding of the atlas.
const MAP: &str = "shadow_map";

/// How a split's map is found: the axis `lookup`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lookup {
    Packed,
}

impl Lookup {
    const ALL: [(&'static str, Self); 1] = [("packed", Self::Packed)];

    pub(super) fn of(frame: &Frame<'_>) -> Result<Self, PlanError> {
        let name = job::axis(frame, "lookup");
        let known = Self::ALL.iter().find(|(known, _)| *known == name);
        known
            .map(|(_, lookup)| *lookup)
            .ok_or_else(|| PlanError::Invalid {
                what: "the axis `lookup`".to_owned(),
                value: name.to_owned(),
                expected: Self::ALL.map(|(known, _)| known).join(", "),
            })
    }
}

/// The plan of a frame's splits.
pub(super) fn plan(job: &Job, splits: &Splits) -> Result<ShadowPlan, PlanError> {
    let count = splits.splits.len() as u32;
    // Where no receiver is seen: the least that the shader can bind, and it reads none of it.
    let (columns, [width, height]) = match count {
        0 => (1, [1, 1]),
        count => {
            let atlas = atlas(job, count)?;
            (atlas.columns(), atlas.size())
        }
    };
    let sampler = SamplerDesc {
        name: "shadow_sampler".to_owned(),
        filter: FilterMode::Linear,
        compare: Some(CompareFunction::GreaterEqual),
    };
    let taps = job.width.div_ceil(2);
    let lookups = if job.transition == Transition::Blend {
        2
    } else {
        1
    };
    let mut plan = ShadowPlan {
        samplers: vec![sampler],
        constants: constants(job, splits, columns as f32),
        fetches_per_pixel: lookups * taps * taps,
        filter_radius: 0.5 * f64::from(job.width) + 0.5,
        shadow_distance: job.shadow_distance,
        ..ShadowPlan::default()
    };
    plan.textures.push(TextureDesc {
        name: MAP.to_owned(),
        format: TextureFormat::Depth32Float,
        width,
        height,
        shape: TextureShape::D2,
    });
    for (number, split) in (0..).zip(&splits.splits) {
        let viewport = atlas(job, count)?.tile(number);
        plan.passes.push(pass(split, MAP, viewport, number == 0));
    }
    Ok(plan)
}

fn atlas(job: &Job, count: u32) -> Result<Atlas, PlanError> {
    Atlas::new(count, job.tile, job::margin(job.width).ceil() as u32)
}

/// Both sides of each triangle are drawn: a mesh may be open, a leaf without thickness, a transform
/// a mirror.
fn pass(split: &Split, target: &str, viewport: Viewport, clear: bool) -> Pass {
    Pass::Casters(CasterPass {
        target: target.to_owned(),
        color: None,
        layer: 0,
        viewport,
        clear: clear.then_some(0.0),
        depth_test: DepthTest {
            compare: CompareFunction::GreaterEqual,
            unclipped: false,
        },
        cull: None,
        view_proj: split.view_proj.as_mat4(),
        casters: split.casters.clone(),
        receivers: Some(split.depths),
    })
}

/// The members of `PssmShadow`, for any lookup and transition.
fn constants(job: &Job, splits: &Splits, columns: f32) -> Constants {
    let splits_of = |value: &dyn Fn(&Split) -> f64, none: f32| {
        let value = |i: usize| splits.splits.get(i).map_or(none, |s| value(s) as f32);
        let four = |i: usize| Vec4::from_array([0, 1, 2, 3].map(|j| value(4 * i + j)));
        Value::Array(vec![Value::Vec4(four(0)), Value::Vec4(four(1))])
    };
    let length = |split: &Split| job.band * (split.depths[1] - split.depths[0]);
    // The last split, and one before a gap, passes into nothing.
    let has_next = |split: &Split| {
        let mut all = splits.splits.iter();
        all.any(|next| next.depths[0] == split.depths[1])
    };
    let rate = |split: &Split| {
        if has_next(split) {
            1.0 / length(split)
        } else {
            0.0
        }
    };
    let reach = splits
        .splits
        .last()
        .map_or(f32::MIN, |last| last.depths[1] as f32);
    Constants::new()
        .with("base", Value::Mat4(splits.base.as_mat4()))
        .with("forward", Value::Vec3(job.forward().as_vec3()))
        .with("reach", Value::F32(reach))
        .with("ends", splits_of(&|split| split.depths[1], f32::MAX))
        .with(
            "bands",
            splits_of(&|split| split.depths[1] - length(split), 0.0),
        )
        .with("band_rates", splits_of(&rate, 0.0))
        .with("tile", Value::F32(job.tile as f32))
        .with("columns", Value::F32(columns))
        .with("crops", crops(splits))
}

/// Each split's crop, for all splits that there may be.
fn crops(splits: &Splits) -> Value {
    let crop = |i| {
        let split = splits.splits.get(i);
        let [place, depth] = split.map_or([Vec4::ZERO; 2], crop);
        let members = Constants::new().with("place", Value::Vec4(place));
        Value::Struct(members.with("depth", Value::Vec4(depth)))
    };
    Value::Array((0..MAX_SPLITS).map(crop).collect())
}

/// The two members of a `Crop`.
fn crop(split: &Split) -> [Vec4; 2] {
    let (scale, offset, bias) = (split.scale, split.offset, split.bias);
    let place = DVec4::new(scale.x, scale.y, offset.x, offset.y);
    let depth = DVec4::new(scale.z, offset.z, bias.x, bias.y);
    [place.as_vec4(), depth.as_vec4()]
}
