//! How long passes take, by the device's own clock.

use std::mem;

use umbrage_compose::Purpose;

use crate::{Gpu, GpuError, PassTime};

/// Queries in a set, two a pass. WebGPU allows 4096; most frames need few.
const SET: u32 = 128;

// A set is resolved to where WebGPU lets it begin, and a pass's two queries are in one set.
const _: () = assert!(
    SET <= wgpu::QUERY_SET_MAX_QUERIES
        && SET.is_multiple_of(2)
        && ((SET * wgpu::QUERY_SIZE) as u64).is_multiple_of(wgpu::QUERY_RESOLVE_BUFFER_ALIGNMENT)
);

/// Takes the times of the passes of a frame.
#[derive(Default)]
pub(super) struct Timer {
    /// Nanoseconds a tick; none where no times are taken.
    period: Option<f32>,
    sets: Vec<wgpu::QuerySet>,
    /// Passes marked since the last times were read.
    marked: Vec<Marked>,
}

/// A marked pass.
struct Marked {
    pass: String,
    light: Option<String>,
    purpose: Purpose,
    computes: bool,
}

/// Where a pass notes when it begins and when it ends.
pub(super) struct Mark {
    set: wgpu::QuerySet,
    first: u32,
}

impl Mark {
    /// The queries of its beginning and its end.
    pub(super) fn queries(&self) -> (wgpu::QuerySet, [u32; 2]) {
        (self.set.clone(), [self.first, self.first + 1])
    }

    pub(super) fn writes(&self) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(self.first),
            end_of_pass_write_index: Some(self.first + 1),
        }
    }
}

impl Timer {
    /// A timer that takes times if they are `wanted` and the device can tell them.
    pub(super) fn new(gpu: &Gpu, wanted: bool) -> Self {
        Self {
            period: gpu.timestamp_period().filter(|_| wanted),
            ..Self::default()
        }
    }

    /// A mark for the next pass, which draws or `computes`; none where no times are taken.
    pub(super) fn mark(
        &mut self,
        gpu: &Gpu,
        (pass, purpose): (&str, Purpose),
        light: Option<&str>,
        computes: bool,
    ) -> Option<Mark> {
        self.period?;
        let query = 2 * self.marked.len() as u32;
        self.marked.push(Marked {
            pass: pass.to_owned(),
            light: light.map(str::to_owned),
            purpose,
            computes,
        });
        let set = (query / SET) as usize;
        if self.sets.len() == set {
            let desc = wgpu::QuerySetDescriptor {
                label: Some("times"),
                ty: wgpu::QueryType::Timestamp,
                count: SET,
            };
            self.sets.push(gpu.device.create_query_set(&desc));
        }
        Some(Mark {
            set: self.sets.get(set)?.clone(),
            first: query % SET,
        })
    }

    /// Has `encoder` put what was marked where the host can read it.
    pub(super) fn resolve(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Option<wgpu::Buffer> {
        let queries = 2 * self.marked.len() as u32;
        if queries == 0 {
            return None;
        }
        let bytes = |queries: u32| u64::from(queries * wgpu::QUERY_SIZE);
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("times"),
                size: bytes(queries.next_multiple_of(SET)),
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let resolved = buffer(Usage::QUERY_RESOLVE | Usage::COPY_SRC);
        let readable = buffer(Usage::COPY_DST | Usage::MAP_READ);
        for (index, set) in (0..).zip(&self.sets) {
            let first = index * SET;
            if first < queries {
                let count = SET.min(queries - first);
                encoder.resolve_query_set(set, 0..count, &resolved, bytes(first));
            }
        }
        encoder.copy_buffer_to_buffer(&resolved, 0, &readable, 0, bytes(queries));
        Some(readable)
    }

    /// The times that `resolve` put into `buffer`, once the device is done; the timer is as new.
    pub(super) fn read(
        &mut self,
        gpu: &Gpu,
        buffer: &wgpu::Buffer,
    ) -> Result<Vec<PassTime>, GpuError> {
        let marked = mem::take(&mut self.marked);
        let period = f64::from(self.period.unwrap_or_default());
        let mut ticks = Vec::new();
        gpu.read(buffer, |bytes| {
            let words = bytes.as_chunks::<8>().0.iter().copied();
            ticks.extend(words.map(u64::from_le_bytes));
        })?;
        let computes: Vec<_> = marked.iter().map(|marked| marked.computes).collect();
        let spans = spans(&computes, ticks.as_chunks::<2>().0);
        let passes = marked.into_iter().zip(spans);
        Ok(passes
            .map(|(marked, ticks)| PassTime {
                pass: marked.pass,
                light: marked.light,
                purpose: marked.purpose,
                milliseconds: ticks as f64 * period * 1e-6,
            })
            .collect())
    }
}

/// The ticks that passes take which began and ended so, each of which `computes` or draws.
///
/// Mesa's llvmpipe notes the beginning of a compute pass that follows another at its end. As nothing is done between the
/// two, it begins where the other ends.
fn spans(computes: &[bool], noted: &[[u64; 2]]) -> Vec<u64> {
    let mut before = None;
    let passes = computes.iter().zip(noted);
    passes
        .map(|(computes, [start, end])| {
            let ended = before.filter(|_| *computes).unwrap_or(*start);
            before = computes.then_some(*end);
            // A clock that was set back between the two tells nothing.
            end.saturating_sub(ended.min(*start))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_compute_pass_begins_where_the_one_before_it_ends() {
        // Drawn, computed, computed and noted late, computed, drawn after a while; and a clock set back.
        let noted = [
            [10, 20],
            [25, 40],
            [69, 70],
            [71, 80],
            [100, 130],
            [150, 140],
        ];
        let computes = [false, true, true, true, false, true];
        assert_eq!(spans(&computes, &noted), [10, 15, 30, 10, 30, 0]);
    }

    /// More passes than a set holds are all told, in their order.
    #[test]
    fn times_of_many_passes_come_in_order() {
        let gpu = Gpu::new().expect("an adapter");
        if !gpu.has_timestamps() {
            return;
        }
        let size = wgpu::Extent3d {
            width: 8,
            height: 8,
            depth_or_array_layers: 1,
        };
        let format = wgpu::TextureFormat::Depth32Float;
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let texture = gpu.texture("a map", size, 1, format, usage).expect("small");
        let view = texture.create_view(&Default::default());
        let mut timer = Timer::new(&gpu, true);
        for count in [1, 3 * SET as usize / 2, 0, 2] {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            for pass in 0..count {
                let mark = timer
                    .mark(&gpu, (&pass.to_string(), Purpose::Maps), None, false)
                    .expect("timed");
                encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                        view: &view,
                        depth_ops: Some(wgpu::Operations {
                            load: wgpu::LoadOp::Clear(0.0),
                            store: wgpu::StoreOp::Store,
                        }),
                        stencil_ops: None,
                    }),
                    timestamp_writes: Some(mark.writes()),
                    ..Default::default()
                });
            }
            let buffer = timer.resolve(&gpu, &mut encoder);
            assert_eq!(buffer.is_some(), count > 0);
            gpu.queue.submit([encoder.finish()]);
            let Some(buffer) = buffer else { continue };
            let times = timer.read(&gpu, &buffer).expect("read");
            assert_eq!(times.len(), count);
            for (number, time) in times.iter().enumerate() {
                assert_eq!(time.pass, number.to_string());
                assert!((0.0..1e4).contains(&time.milliseconds), "{time:?}");
            }
        }
    }
}
