//! What the camera sees, before any light is added: each pixel's plane, and between which depths all of them are.

use glam::Vec3;
use umbrage_wgpu::DrawState;

use super::{
    Renderer, Shot,
    assets::Vertices,
    draw::{FrameState, PassInputs, record},
    masks::state,
    passes::NamedPass,
    target::{Target, begin, read},
    timer::Mark,
};
use crate::RenderError;

/// The binding of what `linear_depth` lays down.
pub(super) const SEEN_PLANES: &str = "seen_planes";

/// The binding of what `depth_range` finds.
pub(super) const SEEN_DEPTHS: &str = "seen_depths";

/// Each pixel's plane: the unit normal and the linear depth, 0 where nothing is seen. In 16 bytes a
/// pixel, all floats: a normal in two halves is 1e-3 radians off, which at a slope of 19, light at 87°, moves a
/// receiver's plane by a third.
pub(super) const PLANE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The least and the greatest depth in a block of pixels, in what the baseline can store to.
const RANGE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Pixels along a block's side, as the shader has it.
const BLOCK: u32 = 64;

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
        let size = picture_size(frame);
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let planes = self.gpu.texture("the planes seen", size, 1, PLANE, usage)?;
        frame.report.mask_bytes += PLANE.theoretical_memory_footprint(size);
        let planes = planes.create_view(&Default::default());
        let drawn = DrawState {
            write_depth: fresh,
            ..state(PLANE, wgpu::CompareFunction::GreaterEqual)
        };
        let inputs = inputs(shot, self.pass("linear_depth")?, drawn);
        let commands = self.prepare(frame, &inputs, &shot.visible)?;
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

    /// The least and the greatest view depth (metres) that a pixel sees; the first is greater than the second where none
    /// sees anything. Found once for a picture, and waited for.
    pub(super) fn seen_depths(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        to: (&Target, bool),
    ) -> Result<[f64; 2], RenderError> {
        const NOTHING: [f64; 2] = [f64::MAX, 0.0];
        if let Some(known) = frame.seen {
            return Ok(known);
        }
        let first = shot.visible.first();
        let object = first.and_then(|slot| frame.objects.object(*slot));
        let Some(object) = object else {
            return Ok(NOTHING);
        };
        self.lay_planes(frame, shot, to)?;
        let blocks = [frame.options.width, frame.options.height].map(|side| side.div_ceil(BLOCK));
        let size = wgpu::Extent3d {
            width: blocks[0],
            height: blocks[1],
            depth_or_array_layers: 1,
        };
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let ranges = self.gpu.texture("the depths seen", size, 1, RANGE, usage)?;
        frame.depths = Some(ranges.create_view(&Default::default()));
        let unfiltered = DrawState {
            unfiltered: [(0, SEEN_PLANES.to_owned())].into(),
            ..DrawState::NOTHING
        };
        let inputs = inputs(shot, self.pass("depth_range")?, unfiltered);
        let permutation = self.compose(frame, &inputs, &object.name, None)?;
        let mark = frame.timer.mark(
            &self.gpu,
            (inputs.pass.name, inputs.pass.purpose),
            None,
            true,
        );
        let [across, down] = blocks;
        let unfiltered = inputs.state.unfiltered.clone();
        let computation = self.executor.computation(&permutation, unfiltered)?;
        let groups = self.bind_all(frame, &inputs, &computation.program)?;
        let mut recorded = frame
            .encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(inputs.pass.name),
                timestamp_writes: mark.as_ref().map(Mark::compute_writes),
            });
        recorded.set_pipeline(&computation.pipeline);
        for (group, bound) in (0..).zip(&groups) {
            if let Some(bound) = bound {
                recorded.set_bind_group(group, bound, &[]);
            }
        }
        recorded.dispatch_workgroups(across, down, 1);
        drop(recorded);
        frame.report.passes += 1;
        self.submit(frame)?;
        let bytes = read(&self.gpu, &ranges)?;
        let found = bytes.as_chunks::<16>().0.iter();
        let found = found.map(|&[a, b, c, d, e, f, g, h, ..]| {
            let [least, most] = [[a, b, c, d], [e, f, g, h]].map(f32::from_le_bytes);
            [f64::from(least), f64::from(most)]
        });
        let seen = found
            .filter(|[_, most]| *most > 0.0)
            .fold(NOTHING, |all, one| [all[0].min(one[0]), all[1].max(one[1])]);
        frame.seen = Some(seen);
        Ok(seen)
    }
}

/// A texture's size that has a texel for each pixel of the picture.
pub(super) fn picture_size(frame: &FrameState<'_>) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width: frame.options.width,
        height: frame.options.height,
        depth_or_array_layers: 1,
    }
}

/// What a pass for no light draws with.
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
