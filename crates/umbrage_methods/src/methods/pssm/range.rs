//! Bounds of the depths that are split: the axis `range`.

use umbrage_shadow::{
    BufferContents, BufferDesc, ComputePass, Frame, Pass, PlanError, Reads, ShadowPlan,
};

/// The buffer of what is asked: the bits of the greatest depth that a pixel sees, and of the least their complement, so that
/// both grow as more is seen; zeros where none sees anything.
const BUFFER: &str = "seen_depths";

/// Pixels along the side of a workgroup's block, as the shader has it.
const BLOCK: u32 = 64;

/// Bounds of the depths that are split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Range {
    /// The receivers' boxes.
    Boxes,
    /// The depths that pixels see, which are not known yet.
    Unknown,
    /// The depths that pixels see: the least and the greatest view depth, metres.
    Seen([f64; 2]),
}

impl Range {
    pub(super) fn of(frame: &Frame<'_>) -> Result<Self, PlanError> {
        let ranges = [("boxes", false), ("depths", true)];
        // Air is seen from the near plane on, wherever surfaces are.
        if !frame.choice("range", &ranges)? || frame.casters.air.is_some() {
            return Ok(Self::Boxes);
        }
        Ok(seen(frame)?.map_or(Self::Unknown, Self::Seen))
    }
}

/// The least and the greatest view depth (metres) that a pixel sees, as a frame was answered; the first is greater than the
/// second where none sees anything. None where it was not answered yet.
///
/// # Errors
/// An answer of another size.
pub fn seen(frame: &Frame<'_>) -> Result<Option<[f64; 2]>, PlanError> {
    let Some(bytes) = frame.answers.get(BUFFER) else {
        return Ok(None);
    };
    let (words, rest) = bytes.as_chunks::<4>();
    let (&[nearest, farthest], []) = (words, rest) else {
        return Err(PlanError::Invalid {
            what: format!("the answer about `{BUFFER}`"),
            value: format!("{} bytes", bytes.len()),
            expected: "8 bytes".to_owned(),
        });
    };
    let [nearest, farthest] = [nearest, farthest].map(u32::from_le_bytes);
    if nearest == 0 {
        return Ok(Some([f64::MAX, 0.0]));
    }
    let depths = [nearest, !farthest].map(|bits| f64::from(f32::from_bits(bits)));
    Ok(Some(
        depths.map(|depth| frame.view.projection.view_depth(depth)),
    ))
}

/// The plan that asks what pixels see.
pub(super) fn question(frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
    let mut plan = ShadowPlan {
        asks: vec![BUFFER.to_owned()],
        ..ShadowPlan::default()
    };
    reduce(frame, &mut plan)?;
    Ok(plan)
}

/// Adds to `plan` the pass that finds what pixels see.
pub(super) fn reduce(frame: &Frame<'_>, plan: &mut ShadowPlan) -> Result<(), PlanError> {
    let size = frame.camera_depth.ok_or_else(|| PlanError::Invalid {
        what: "the camera's depth".to_owned(),
        value: "missing".to_owned(),
        expected: "given, as the axis `range` is `depths`; choose `boxes` where there is none"
            .to_owned(),
    })?;
    let [across, down] = size.map(|pixels| pixels.div_ceil(BLOCK));
    plan.buffers.push(BufferDesc {
        name: BUFFER.to_owned(),
        contents: BufferContents::Written(8),
    });
    plan.passes.push(Pass::Compute(ComputePass {
        shader: "depth_range".to_owned(),
        workgroups: [across, down, 1].into(),
        writes: vec![BUFFER.into()],
        reads: Reads::default(),
    }));
    Ok(())
}
