//! A scene with a renderer of its own, and measurements of its frames.

use std::{error::Error, sync::Arc, time::Instant};

use cpu_time::ThreadTime;
use stats_alloc::Region;
use umbrage::wgpu;
use umbrage_compose::{Composer, Library, Purpose, Target};
use umbrage_render::{Gpu, RenderOptions, Renderer, Report, Scene, Shadow};

use crate::HEAP;

/// Pixels on each side.
const SIZE: u32 = 512;

/// A device, and a texture that an engine would show.
pub(crate) struct Machine {
    pub(crate) gpu: Arc<Gpu>,
    device: wgpu::Device,
    shown: wgpu::TextureView,
}

/// A scene, and a renderer that renders it alone: what stands in one is not disturbed by another.
pub(crate) struct View<'m> {
    pub(crate) scene: Scene,
    pub(crate) options: RenderOptions,
    machine: &'m Machine,
    renderer: Renderer,
}

/// A frame, measured.
pub(crate) struct Shot {
    /// Milliseconds from the scene to the device's end of it; with the picture read back, where it is.
    pub(crate) frame: f64,
    /// Milliseconds of these that this thread computed.
    pub(crate) own_cpu: f64,
    /// Allocations on the heap, growing ones included.
    pub(crate) allocations: f64,
    pub(crate) report: Report,
}

impl Machine {
    pub(crate) fn new() -> Result<Self, Box<dyn Error>> {
        let (device, queue, name) = pollster::block_on(device())?;
        let shown = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shown"),
            size: wgpu::Extent3d {
                width: SIZE,
                height: SIZE,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        Ok(Self {
            gpu: Arc::new(Gpu::from_wgpu(device.clone(), queue, name)),
            device,
            shown: shown.create_view(&wgpu::TextureViewDescriptor::default()),
        })
    }
}

/// The machine's Vulkan device, with timestamps where it has them, and its adapter's name.
async fn device() -> Result<(wgpu::Device, wgpu::Queue, String), Box<dyn Error>> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN;
    let instance = wgpu::Instance::new(descriptor);
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default());
    let adapter = adapter.await?;
    let descriptor = wgpu::DeviceDescriptor {
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        ..Default::default()
    };
    let (device, queue) = adapter.request_device(&descriptor).await?;
    Ok((device, queue, adapter.get_info().name))
}

impl<'m> View<'m> {
    pub(crate) fn new(
        machine: &'m Machine,
        scene: Scene,
        shadow: Shadow,
    ) -> Result<Self, Box<dyn Error>> {
        let library = Library::new([umbrage_shader_lib::package()?])?;
        let composer = Arc::new(Composer::new(library, Target::webgpu()));
        let methods = umbrage_methods::registry()?;
        let mut view = Self {
            scene,
            options: RenderOptions {
                width: SIZE,
                height: SIZE,
                shadow,
                ..RenderOptions::default()
            },
            machine,
            renderer: Renderer::new(Arc::clone(&machine.gpu), composer, methods),
        };
        // The first frames make what later ones keep.
        for _ in 0..3 {
            view.read_back(true)?;
            view.steady()?;
        }
        Ok(view)
    }

    /// Renders a frame and reads it back; a `fresh` one draws all maps, though they stand.
    pub(crate) fn read_back(&mut self, fresh: bool) -> Result<Shot, Box<dyn Error>> {
        self.options.fresh = fresh;
        let Self {
            scene,
            options,
            renderer,
            ..
        } = self;
        shot(|| Ok(renderer.render(scene, options)?.report), || Ok(()))
    }

    /// Draws a frame as an engine's loop does. That the device comes to its end is waited for, but is no part of what the
    /// thread computes.
    pub(crate) fn steady(&mut self) -> Result<Shot, Box<dyn Error>> {
        self.options.fresh = false;
        let Self {
            scene,
            options,
            renderer,
            machine,
        } = self;
        let draw = || Ok(renderer.draw(scene, options, &machine.shown)?);
        shot(draw, || {
            machine.device.poll(wgpu::PollType::wait_indefinitely())?;
            Ok(())
        })
    }
}

/// Measures `work`, and how long it takes with the `end` that is waited for.
fn shot(
    work: impl FnOnce() -> Result<Report, Box<dyn Error>>,
    end: impl FnOnce() -> Result<(), Box<dyn Error>>,
) -> Result<Shot, Box<dyn Error>> {
    let heap = Region::new(HEAP);
    let (cpu, wall) = (ThreadTime::now(), Instant::now());
    let report = work()?;
    let (own_cpu, heap) = (cpu.elapsed(), heap.change());
    end()?;
    Ok(Shot {
        frame: 1e3 * wall.elapsed().as_secs_f64(),
        own_cpu: 1e3 * own_cpu.as_secs_f64(),
        allocations: (heap.allocations + heap.reallocations) as f64,
        report,
    })
}

impl Shot {
    /// Milliseconds in passes into shadow maps; none where passes were not timed.
    pub(crate) fn in_maps(&self) -> Option<f64> {
        let times = &self.report.times;
        let maps = times.iter().filter(|time| time.purpose == Purpose::Maps);
        (!times.is_empty()).then(|| maps.map(|time| time.milliseconds).sum())
    }
}
