//! Questions that plans end in, on their way to the engine and back.

use std::ops::Range;

use umbrage_shadow::{Answers, ShadowPlan};

use crate::resources::Buffers;

/// A question of a light's plan: what buffers hold once the encoder that its passes were recorded into is done. The
/// [crate's page](crate#questions) says how it is answered.
#[derive(Debug)]
pub struct Question {
    buffer: wgpu::Buffer,
    parts: Vec<(String, Range<usize>)>,
    answers: Answers,
}

impl Question {
    /// Records copies of what `plan` asks about; all of it is among `buffers`.
    pub(crate) fn record(
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        plan: &ShadowPlan,
        buffers: &Buffers,
        answers: &Answers,
    ) -> Option<Self> {
        let asked = plan.asks.iter();
        let asked: Vec<_> = asked
            .filter_map(|name| buffers.get_key_value(name))
            .collect();
        let size: u64 = asked.iter().map(|(_, buffer)| buffer.size()).sum();
        if size == 0 {
            return None;
        }
        let copy = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("a question"),
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let (mut parts, mut start) = (Vec::new(), 0);
        for (name, buffer) in asked {
            let end = start + buffer.size();
            encoder.copy_buffer_to_buffer(buffer, 0, &copy, start, buffer.size());
            parts.push((name.clone(), start as usize..end as usize));
            start = end;
        }
        Some(Self {
            buffer: copy,
            parts,
            answers: answers.clone(),
        })
    }

    /// The buffer to map for reading, all of it, once the encoder is submitted.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// The answers for the frame that the light's shadow is asked for with again: those of the frame before, and what the
    /// mapped buffer's `bytes` say.
    pub fn answer(&self, bytes: &[u8]) -> Answers {
        let parts = self.parts.iter();
        let held = |range: &Range<usize>| bytes.get(range.clone()).unwrap_or_default().to_vec();
        let parts = parts.map(|(name, range)| (name.clone(), held(range)));
        self.answers.clone().with(parts)
    }
}
