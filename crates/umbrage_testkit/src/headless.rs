//! A device without a window, and a picture drawn on it.

use std::sync::mpsc;

use image::RgbImage;
use pollster::block_on;

/// Why there is no device, or no picture.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct HeadlessError(String);

impl HeadlessError {
    fn new(error: impl ToString) -> Self {
        Self(error.to_string())
    }
}

/// The machine's first Vulkan device, with what plans may need beyond WebGPU's baseline where it has that.
///
/// # Errors
/// No adapter, or one below the baseline.
pub fn device() -> Result<(wgpu::Device, wgpu::Queue), HeadlessError> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::VULKAN,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapter = block_on(instance.request_adapter(&Default::default()));
    let adapter = adapter.map_err(HeadlessError::new)?;
    let descriptor = wgpu::DeviceDescriptor {
        required_features: adapter.features()
            & (wgpu::Features::FLOAT32_BLENDABLE | wgpu::Features::FLOAT32_FILTERABLE),
        ..Default::default()
    };
    block_on(adapter.request_device(&descriptor)).map_err(HeadlessError::new)
}

/// A picture with depths, 8 bits of sRGB a channel.
pub struct Canvas {
    /// The colours.
    pub color: wgpu::Texture,
    /// The depths, reversed: cleared to 0, the farthest.
    pub depth: wgpu::Texture,
}

impl Canvas {
    /// A canvas of so many pixels across and down.
    pub fn new(device: &wgpu::Device, [width, height]: [u32; 2]) -> Self {
        use wgpu::{TextureFormat as Format, TextureUsages as Usage};
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("canvas"),
                size: wgpu::Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | Usage::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        Self {
            color: texture(Format::Rgba8UnormSrgb, Usage::COPY_SRC),
            depth: texture(Format::Depth32Float, Usage::empty()),
        }
    }

    /// A pass into it, which it clears first where that is asked for: to black, and the farthest depth.
    pub fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        clear: bool,
    ) -> wgpu::RenderPass<'e> {
        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        let (color, depth) = (view(&self.color), view(&self.depth));
        let load = match clear {
            true => wgpu::LoadOp::Clear(wgpu::Color::BLACK),
            false => wgpu::LoadOp::Load,
        };
        let depths = match clear {
            true => wgpu::LoadOp::Clear(0.0),
            false => wgpu::LoadOp::Load,
        };
        let store = wgpu::StoreOp::Store;
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("canvas"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load, store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations {
                    load: depths,
                    store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// The picture, once all that was submitted is done.
    ///
    /// # Errors
    /// Refusals of the device.
    pub fn read(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<RgbImage, HeadlessError> {
        let size = self.color.size();
        let row = (4 * size.width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("canvas"),
            size: u64::from(row) * u64::from(size.height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.color.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            size,
        );
        queue.submit([encoder.finish()]);
        let (sender, receiver) = mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The wait below hears of it.
            let _ = sender.send(result);
        });
        let waited = device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(HeadlessError::new)?;
        let mapped = receiver.recv().map_err(HeadlessError::new)?;
        mapped.map_err(HeadlessError::new)?;
        let bytes = buffer.get_mapped_range(..).map_err(HeadlessError::new)?;
        let mut picture = RgbImage::new(size.width, size.height);
        for (y, row) in (0..).zip(bytes.chunks_exact(row as usize)) {
            for (x, pixel) in (0..size.width).zip(row.as_chunks::<4>().0) {
                picture.put_pixel(x, y, image::Rgb([pixel[0], pixel[1], pixel[2]]));
            }
        }
        Ok(picture)
    }
}
