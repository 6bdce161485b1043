//! Frames that go on while workers make their pipelines.

use std::collections::BTreeMap;

use umbrage_wgpu::{Readiness, Vertices, Wanted};

use super::{
    Renderer,
    assets::layouts,
    frame::{FrameState, PassInputs},
    lists::Draw,
};
use crate::RenderError;

/// Choice of what a light's pass draws until the pipelines of all its objects are made. Passes that lay down depth, that fill or
/// compute maps, that cover the picture or that add up several lights are waited for in any case.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Meanwhile {
    /// The picture waits, and makes them itself.
    #[default]
    Stall,
    /// Nothing: the light adds no light.
    Skip,
    /// Other permutations, which the picture waits for where they are not made either.
    StandIn(StandIn),
}

/// Permutations that stand in for those that are wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct StandIn {
    /// Values of axes in place of the wanted ones. They must read what the wanted ones read, as narrower filters do of a
    /// method: maps and bias are those of what is wanted.
    pub axes: BTreeMap<String, String>,
    /// How far their shadow terms may be off those of what they stand in for, root mean square over a picture: as whoever
    /// chose them has measured. The [report](crate::Report::stand_in_error) tells it.
    pub error: f64,
}

/// How a pass is drawn in this frame.
pub(super) enum Way<'a> {
    Wanted,
    StandIn(&'a StandIn),
    Skip,
}

impl Renderer {
    /// The way in which these draws are drawn: all of them in one, so that a light is never half the one and half the other.
    pub(super) fn way<'a>(
        &mut self,
        frame: &mut FrameState<'a>,
        inputs: &PassInputs<'_>,
        draws: &[Draw],
    ) -> Result<Way<'a>, RenderError> {
        let options = frame.options;
        let way = match &options.meanwhile {
            Meanwhile::StandIn(stand_in) if inputs.lights.len() == 1 => Way::StandIn(stand_in),
            Meanwhile::Skip if inputs.lights.len() == 1 => Way::Skip,
            _ => return Ok(Way::Wanted),
        };
        let mut waiting = 0;
        for draw in draws {
            let object = frame.objects.at(draw.first);
            if object.mesh.indices.is_empty() {
                continue;
            }
            let wanted = Wanted {
                keys: self.keys(frame, inputs, Some(object), None)?,
                state: inputs.state.clone(),
                mirrored: frame.objects.is_mirrored(draw),
                vertices: Vertices::new(&layouts(object)),
            };
            match self.executor.prepare(&wanted, draw.instances.len() as u32) {
                Ok(Readiness::Ready) => {}
                Ok(Readiness::Waiting | Readiness::Failed) => waiting += 1,
                Err(error) => {
                    waiting += 1;
                    frame.report.warnings.push(error.to_string());
                }
            }
        }
        if waiting == 0 {
            return Ok(Way::Wanted);
        }
        frame.report.waiting += waiting;
        if let Way::StandIn(stand_in) = &way {
            frame.report.stand_in_error = stand_in.error;
        }
        Ok(way)
    }
}
