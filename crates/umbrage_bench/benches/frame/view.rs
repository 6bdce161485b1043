//! A scene with a renderer of its own, and measurements of its frames.

use std::{error::Error, sync::Arc, time::Instant};

use cpu_time::ThreadTime;
use stats_alloc::Region;
use umbrage_compose::{Composer, Library, Purpose, Target};
use umbrage_render::{Gpu, RenderOptions, Renderer, Report, Scene, Shadow};

use crate::HEAP;

/// Pixels on each side.
const SIZE: u32 = 512;

/// A scene, and a renderer that renders it alone: what stands in one is not disturbed by another.
pub(crate) struct View {
    pub(crate) scene: Scene,
    pub(crate) options: RenderOptions,
    renderer: Renderer,
}

/// A frame, measured.
pub(crate) struct Shot {
    /// Milliseconds from the scene to the picture.
    pub(crate) frame: f64,
    /// Milliseconds of these that this thread computed.
    pub(crate) own_cpu: f64,
    /// Allocations on the heap, growing ones included.
    pub(crate) allocations: f64,
    pub(crate) report: Report,
}

impl View {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
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
            renderer: Renderer::new(Arc::clone(gpu), composer, methods),
        };
        // The first frames make what later ones keep.
        for _ in 0..3 {
            view.shoot(true)?;
        }
        Ok(view)
    }

    /// Renders a frame; a `fresh` one draws all maps, though they stand.
    pub(crate) fn shoot(&mut self, fresh: bool) -> Result<Shot, Box<dyn Error>> {
        self.options.fresh = fresh;
        let heap = Region::new(HEAP);
        let (cpu, wall) = (ThreadTime::now(), Instant::now());
        let rendered = self.renderer.render(&self.scene, &self.options)?;
        let (wall, cpu) = (wall.elapsed(), cpu.elapsed());
        let heap = heap.change();
        Ok(Shot {
            frame: 1e3 * wall.as_secs_f64(),
            own_cpu: 1e3 * cpu.as_secs_f64(),
            allocations: (heap.allocations + heap.reallocations) as f64,
            report: rendered.report,
        })
    }
}

impl Shot {
    /// Milliseconds in passes into shadow maps; none where passes were not timed.
    pub(crate) fn in_maps(&self) -> Option<f64> {
        let times = &self.report.times;
        let maps = times.iter().filter(|time| time.purpose == Purpose::Maps);
        (!times.is_empty()).then(|| maps.map(|time| time.milliseconds).sum())
    }
}
