//! Audits: whether what stands is what drawing it all would give.

use umbrage_shadow::TextureDesc;

use crate::{Error, Executed, Executor, Host, Job, size};

/// Contents of a light's textures as they stood, and as drawn anew, on the way to the engine.
///
/// A caster that changed without another [revision](crate::Identity::revision) or other bounds, and one whose triangles lie
/// outside its bounds, show as a texture that differs.
#[derive(Debug, Default)]
pub struct Audit(Vec<Pair>);

#[derive(Debug)]
struct Pair {
    texture: String,
    stood: wgpu::Buffer,
    drawn: wgpu::Buffer,
}

impl Audit {
    /// The buffers to map for reading, when the encoder is done.
    pub fn buffers(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        self.0.iter().flat_map(|pair| [&pair.stood, &pair.drawn])
    }

    /// The textures in which what stood differs from what was drawn anew; `bytes` reads a mapped buffer. None where casters
    /// told all their changes.
    pub fn differing(&self, mut bytes: impl FnMut(&wgpu::Buffer) -> Vec<u8>) -> Vec<&str> {
        let differs = |pair: &&Pair| bytes(&pair.stood) != bytes(&pair.drawn);
        let differing = self.0.iter().filter(differs);
        differing.map(|pair| pair.texture.as_str()).collect()
    }
}

impl Executor {
    /// The light's shadow as [`shadow`](Self::shadow) gives it, and then once more with everything drawn anew: for looking
    /// for casters that do not tell that they changed. It takes the time of a whole drawing, and memory for twice the light's
    /// textures. What is compared are textures that stood; after the first audit of a light these are all, as textures that
    /// can be copied are made for it.
    ///
    /// # Errors
    /// As [`shadow`](Self::shadow)'s.
    pub fn audit(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        job: &Job<'_>,
        host: &mut dyn Host,
    ) -> Result<(Executed, Audit), Error> {
        self.shared.copies = true;
        let executed = self.shadow(encoder, job, host)?;
        if executed.question.is_some() {
            return Ok((executed, Audit::default()));
        }
        let stood = self.copies(encoder, job.light);
        self.forget(job.light);
        self.shadow(encoder, job, host)?;
        let drawn = self.copies(encoder, job.light);
        let pairs = stood.into_iter().zip(drawn);
        let pairs = pairs.map(|((texture, stood), (_, drawn))| Pair {
            texture,
            stood,
            drawn,
        });
        Ok((executed, Audit(pairs.collect())))
    }

    /// Copies of a light's textures, largest mip levels, as far as they can be copied.
    fn copies(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        light: u64,
    ) -> Vec<(String, wgpu::Buffer)> {
        let textures = self.lights.get(&light);
        let textures = textures.into_iter().flat_map(|memory| &memory.textures);
        let copied = textures.filter_map(|(name, (desc, texture))| {
            Some((name.clone(), self.copy(encoder, desc, texture)?))
        });
        copied.collect()
    }

    fn copy(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        desc: &TextureDesc,
        texture: &wgpu::Texture,
    ) -> Option<wgpu::Buffer> {
        if !texture.usage().contains(wgpu::TextureUsages::COPY_SRC) {
            return None;
        }
        let texel = desc.format.block_copy_size(None)?;
        let row = (desc.width * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let extent = size(desc);
        let bytes = u64::from(row) * u64::from(desc.height) * u64::from(desc.shape.layers());
        let buffer = self.shared.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("audit"),
            size: bytes,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row),
            rows_per_image: Some(desc.height),
        };
        let to = wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout,
        };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, extent);
        Some(buffer)
    }
}
