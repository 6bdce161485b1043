//! Lists of the objects that passes draw: of each batch those that are there, in one draw, whichever they are.

use std::ops::Range;

use umbrage_wgpu::device;

use crate::{Gpu, GpuError, RenderError};

/// One draw's objects, all of a batch.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Draw {
    pub(super) batch: usize,
    /// The first one's slot.
    pub(super) first: usize,
    /// Their places in the list.
    pub(super) instances: Range<u32>,
}

/// The lists of a frame, one after another in a buffer that is kept. A list that a pass before had is there already.
#[derive(Default)]
pub(super) struct Lists {
    slots: Vec<u32>,
    /// Ends of the lists, and their draws.
    lists: Vec<(Range<usize>, Vec<Draw>)>,
    buffer: Option<wgpu::Buffer>,
    /// The slots that the buffer holds.
    held: Vec<u32>,
    /// Buffers of this frame that got too small for further lists, and what they are to hold.
    full: Vec<(wgpu::Buffer, Vec<u32>)>,
}

impl Lists {
    /// Begins a frame of so many objects.
    pub(super) fn begin_frame(&mut self, objects: usize) {
        self.slots.clear();
        self.lists.clear();
        self.full.clear();
        // Lists of what is seen, and of what four maps' casters are.
        self.slots.reserve(4 * objects);
    }

    /// The draws that cover `slots`, which ascend, where `batch` tells each one's.
    pub(super) fn list(
        &mut self,
        gpu: &Gpu,
        slots: &[usize],
        batch: impl Fn(usize) -> usize,
    ) -> Result<Vec<Draw>, RenderError> {
        let is = |(places, _): &&(Range<usize>, Vec<Draw>)| {
            let known = self.slots[places.clone()].iter();
            places.len() == slots.len() && known.zip(slots).all(|(a, b)| *a as usize == *b)
        };
        if let Some((_, draws)) = self.lists.iter().find(is) {
            return Ok(draws.clone());
        }
        self.make_room(gpu, slots.len())?;
        let start = self.slots.len();
        let mut draws: Vec<Draw> = Vec::new();
        for slot in slots {
            let (place, batch) = (self.slots.len() as u32, batch(*slot));
            self.slots.push(*slot as u32);
            match draws.last_mut() {
                Some(draw) if draw.batch == batch => draw.instances.end += 1,
                _ => draws.push(Draw {
                    batch,
                    first: *slot,
                    instances: place..place + 1,
                }),
            }
        }
        self.lists.push((start..self.slots.len(), draws.clone()));
        Ok(draws)
    }

    /// The buffer that the last list is in.
    pub(super) fn buffer(&mut self, gpu: &Gpu) -> Result<wgpu::Buffer, RenderError> {
        self.make_room(gpu, 0)?;
        match &self.buffer {
            Some(buffer) => Ok(buffer.clone()),
            None => self.grow(gpu, 1),
        }
    }

    /// Makes room for so many more.
    fn make_room(&mut self, gpu: &Gpu, more: usize) -> Result<(), RenderError> {
        let needed = self.slots.len() + more;
        let room = self.buffer.as_ref().map_or(0, |buffer| buffer.size() / 4);
        if needed as u64 <= room {
            return Ok(());
        }
        if let Some(buffer) = self.buffer.take() {
            self.full.push((buffer, std::mem::take(&mut self.slots)));
            self.lists.clear();
        }
        self.grow(gpu, needed).map(|_| ())
    }

    fn grow(&mut self, gpu: &Gpu, needed: usize) -> Result<wgpu::Buffer, RenderError> {
        let room = needed
            .next_power_of_two()
            .max(self.slots.capacity())
            .max(64);
        let (what, usage) = ("the list of objects", wgpu::BufferUsages::STORAGE);
        let made = device::zeros(&gpu.device, what, usage, 4 * room as u64);
        let made = made.map_err(GpuError::from)?;
        self.held.clear();
        self.buffer = Some(made.clone());
        Ok(made)
    }

    /// Writes what the buffers do not hold yet.
    pub(super) fn upload(&mut self, gpu: &Gpu) {
        for (buffer, slots) in self.full.drain(..) {
            gpu.queue
                .write_buffer(&buffer, 0, bytemuck::cast_slice(&slots));
        }
        if let Some(buffer) = &self.buffer
            && !self.held.starts_with(&self.slots)
        {
            gpu.queue
                .write_buffer(buffer, 0, bytemuck::cast_slice(&self.slots));
            self.held.clone_from(&self.slots);
        }
    }
}
