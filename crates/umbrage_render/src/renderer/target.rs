//! What is rendered into, and how it comes back.

use super::timer::Mark;
use crate::{Gpu, GpuError, RenderError};

/// A colour and a depth texture of the picture's size.
pub(super) struct Target {
    pub(super) color: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
}

/// The depth format of the camera's passes.
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Begins a pass into a colour texture, with a colour to begin with or what is there, and a depth
/// texture, cleared or with what is there. `mark` takes its time.
pub(super) fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    (color, clear): (&wgpu::TextureView, Option<wgpu::Color>),
    (depth, clear_depth): (&wgpu::TextureView, bool),
    mark: Option<&Mark>,
) -> wgpu::RenderPass<'a> {
    let store = wgpu::StoreOp::Store;
    let load = match clear_depth {
        // Depth is reversed: 0 is the farthest.
        true => wgpu::LoadOp::Clear(0.0),
        false => wgpu::LoadOp::Load,
    };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("picture"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: color,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear),
                store,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(wgpu::Operations { load, store }),
            stencil_ops: None,
        }),
        timestamp_writes: mark.map(Mark::writes),
        ..Default::default()
    })
}

/// Bytes that are read back at a time.
const BAND: u64 = 32 << 20;

/// Textures as large as pictures, kept from frame to frame: in a frame each is one thing's, in the next another's.
#[derive(Default)]
pub(super) struct Targets {
    frame: u64,
    kept: Vec<Kept>,
}

struct Kept {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    /// The frame that took it last.
    taken: u64,
}

impl Targets {
    /// Begins a frame, when all that was recorded before is submitted: what neither of the last two frames took is let go.
    pub(super) fn begin_frame(&mut self) {
        self.frame += 1;
        self.kept.retain(|kept| kept.taken + 2 >= self.frame);
    }

    /// A view of a texture that nothing else has in this frame; what it holds is not said.
    pub(super) fn take(
        &mut self,
        gpu: &Gpu,
        what: &str,
        [width, height]: [u32; 2],
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> Result<wgpu::TextureView, GpuError> {
        let fits = |Kept { texture, taken, .. }: &&mut Kept| {
            *taken < self.frame
                && [texture.width(), texture.height()] == [width, height]
                && (texture.format(), texture.usage()) == (format, usage)
        };
        if let Some(kept) = self.kept.iter_mut().find(fits) {
            kept.taken = self.frame;
            return Ok(kept.view.clone());
        }
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        let texture = gpu.texture(what, size, 1, format, usage)?;
        let view = texture.create_view(&Default::default());
        self.kept.push(Kept {
            texture,
            view: view.clone(),
            taken: self.frame,
        });
        Ok(view)
    }
}

impl Target {
    pub(super) fn new(
        gpu: &Gpu,
        targets: &mut Targets,
        size: [u32; 2],
        format: wgpu::TextureFormat,
    ) -> Result<Self, RenderError> {
        use wgpu::TextureUsages as Usage;
        let usage = Usage::RENDER_ATTACHMENT | Usage::COPY_SRC;
        let color = targets.take(gpu, "the picture", size, format, usage)?;
        Self::onto(gpu, targets, color)
    }

    /// A target whose colours are somebody's own.
    pub(super) fn onto(
        gpu: &Gpu,
        targets: &mut Targets,
        color: wgpu::TextureView,
    ) -> Result<Self, RenderError> {
        use wgpu::TextureUsages as Usage;
        let usage = Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING;
        let size = [color.texture().width(), color.texture().height()];
        let depth = targets.take(gpu, "the picture's depth", size, DEPTH, usage)?;
        Ok(Self { color, depth })
    }

    /// Begins a pass; `clear` is the colour to begin with, none keeps what is there, depth too. `mark`
    /// takes its time.
    pub(super) fn begin<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        clear: Option<wgpu::Color>,
        mark: Option<&Mark>,
    ) -> wgpu::RenderPass<'a> {
        let color = (&self.color, clear);
        begin(encoder, color, (&self.depth, clear.is_some()), mark)
    }

    /// Begins a pass over what is there, without depth, which it may read. `mark` takes its time.
    pub(super) fn over<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        mark: Option<&Mark>,
    ) -> wgpu::RenderPass<'a> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("over the picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                },
            })],
            timestamp_writes: mark.map(Mark::writes),
            ..Default::default()
        })
    }

    /// The colours' format.
    pub(super) fn format(&self) -> wgpu::TextureFormat {
        self.color.texture().format()
    }

    /// The colour texture's bytes, as [`read`] gives them.
    pub(super) fn read(&self, gpu: &Gpu) -> Result<Vec<u8>, GpuError> {
        read(gpu, self.color.texture())
    }
}

/// The bytes of a texture of one rectangle, row by row from the top, in bands so that no buffer grows with it.
pub(super) fn read(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<u8>, GpuError> {
    let (width, height) = (texture.width(), texture.height());
    let texel = texture.format().block_copy_size(None).unwrap_or(4);
    let row = width * texel;
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let rows = ((BAND / u64::from(padded)) as u32).clamp(1, height);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read-back"),
        size: u64::from(padded) * u64::from(rows),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut bytes = Vec::with_capacity(row as usize * height as usize);
    let mut top = 0;
    while top < height {
        let band = rows.min(height - top);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y: top, z: 0 },
                ..texture.as_image_copy()
            },
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d {
                width,
                height: band,
                depth_or_array_layers: 1,
            },
        );
        gpu.queue.submit([encoder.finish()]);
        gpu.read(&buffer, |mapped| {
            let rows = mapped.chunks_exact(padded as usize).take(band as usize);
            rows.for_each(|padded| bytes.extend_from_slice(&padded[..row as usize]));
        })?;
        top += band;
    }
    Ok(bytes)
}
