//! Each pixel's plane, as the camera sees it before any light is added.

use glam::Vec3;
use umbrage_wgpu::DrawState;

use super::{
    Renderer, Shot,
    assets::Vertices,
    draw::record,
    frame::{FrameState, PLANE, PassInputs, state},
    passes::NamedPass,
    target::{Target, begin},
};
use crate::RenderError;

impl Renderer {
    /// Lays down the planes that are seen, once for a picture; where the target is `fresh`, depth with them, else it is
    /// there already.
    pub(super) fn lay_planes(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        (target, fresh): (&Target, bool),
    ) -> Result<(), RenderError> {
        if frame.planes.is_some() {
            return Ok(());
        }
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let planes = self.mask_part(frame, "the planes seen", PLANE, usage)?;
        let drawn = DrawState {
            write_depth: fresh,
            ..state(PLANE, wgpu::CompareFunction::GreaterEqual)
        };
        let inputs = inputs(shot, self.pass("linear_depth")?, drawn);
        let visible = frame.objects.visible();
        let commands = self.prepare(frame, &inputs, &visible)?;
        let mark = frame.timer.mark(
            &self.gpu,
            (inputs.pass.name, inputs.pass.purpose),
            None,
            false,
        );
        let nothing = Some(wgpu::Color::TRANSPARENT);
        let mut pass = begin(
            &mut frame.encoder,
            (&planes, nothing),
            (&target.depth, fresh),
            mark.as_ref(),
        );
        record(&mut pass, &commands);
        drop(pass);
        frame.report.passes += 1;
        frame.planes = Some(planes);
        Ok(())
    }
}

/// Inputs of a pass for no light.
fn inputs<'a>(shot: &Shot<'_>, pass: NamedPass<'a>, state: DrawState) -> PassInputs<'a> {
    PassInputs {
        pass,
        cause: None,
        view_proj: shot.view_proj,
        ambient: Vec3::ZERO,
        lights: Vec::new(),
        vertices: Vertices::Shared,
        state,
    }
}
