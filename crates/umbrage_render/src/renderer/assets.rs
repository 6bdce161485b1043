//! Meshes and pictures on the device, kept while the scene keeps them.

use std::{
    collections::HashMap,
    ops::Range,
    sync::{Arc, OnceLock, Weak},
};

use crate::{
    Gpu, RenderError,
    scene::{Image, Level, Mesh, Object, Texture, Wrap},
};

/// A mesh on the device.
pub(super) struct GpuMesh {
    /// By location; none where the mesh has no such attribute.
    attributes: [Option<wgpu::Buffer>; 4],
    /// None where the vertices stand in the order in which they are drawn.
    indices: Option<wgpu::Buffer>,
    count: u32,
    /// Whether it is closed, once that was asked.
    closed: OnceLock<bool>,
}

impl GpuMesh {
    /// The buffer of the attribute at `location`.
    pub(super) fn attribute(&self, location: u32) -> Option<&wgpu::Buffer> {
        self.attributes.get(location as usize)?.as_ref()
    }

    /// Whether `source`, which it was made from, is closed.
    pub(super) fn is_closed(&self, source: &Mesh) -> bool {
        *self.closed.get_or_init(|| source.is_closed())
    }

    /// Draws `instances` of it with what is set.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, instances: Range<u32>) {
        match &self.indices {
            Some(indices) => {
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..self.count, 0, instances);
            }
            None => pass.draw(0..self.count, instances),
        }
    }
}

/// How a mesh's triangles come by their vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Vertices {
    /// By indices.
    Shared,
    /// Three of its own for each triangle, in the order of the triangles: a vertex's number tells its
    /// triangle.
    Own,
}

/// Resources on the device, by the address of what each was made from. The weak reference keeps the
/// address from being given to another, and the source from being changed in place.
#[derive(Default)]
pub(super) struct Assets {
    /// Also by how they are drawn.
    meshes: HashMap<(usize, Vertices), (Weak<Mesh>, Arc<GpuMesh>)>,
    images: HashMap<usize, (Weak<Image>, wgpu::TextureView)>,
}

impl Assets {
    /// Forgets what no scene holds any more.
    pub(super) fn sweep(&mut self) {
        self.meshes
            .retain(|_, (source, _)| source.strong_count() > 0);
        self.images
            .retain(|_, (source, _)| source.strong_count() > 0);
    }

    pub(super) fn mesh(
        &mut self,
        gpu: &Gpu,
        object: &Object,
        vertices: Vertices,
    ) -> Result<Arc<GpuMesh>, RenderError> {
        let source = &object.mesh;
        let id = (address(source), vertices);
        if let Some((_, mesh)) = self.meshes.get(&id) {
            return Ok(Arc::clone(mesh));
        }
        check_mesh(object)?;
        let mesh = Arc::new(upload_mesh(gpu, object, vertices)?);
        let entry = (Arc::downgrade(source), Arc::clone(&mesh));
        self.meshes.insert(id, entry);
        Ok(mesh)
    }

    pub(super) fn image(
        &mut self,
        gpu: &Gpu,
        what: impl Fn() -> String,
        source: &Arc<Image>,
    ) -> Result<wgpu::TextureView, RenderError> {
        if let Some((_, view)) = self.images.get(&address(source)) {
            return Ok(view.clone());
        }
        let view = upload_image(gpu, &what(), source)?;
        let entry = (Arc::downgrade(source), view.clone());
        self.images.insert(address(source), entry);
        Ok(view)
    }
}

#[cfg(test)]
impl Assets {
    /// The meshes' positions, and the pictures.
    pub(super) fn kept(&self) -> (Vec<wgpu::Buffer>, Vec<wgpu::TextureView>) {
        let meshes = self.meshes.values();
        let meshes = meshes.filter_map(|(_, mesh)| mesh.attributes[0].clone());
        let images = self.images.values().map(|(_, view)| view.clone());
        (meshes.collect(), images.collect())
    }
}

/// The buffers that an object's mesh has: one for each attribute, by its location.
pub(super) fn layouts(object: &Object) -> Vec<wgpu::VertexBufferLayout<'static>> {
    const ATTRIBUTES: [wgpu::VertexAttribute; 4] = wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Float32x4
    ];
    let mesh = &object.mesh;
    let has = [
        !mesh.positions.is_empty(),
        !mesh.normals.is_empty(),
        !mesh.uvs.is_empty(),
        !mesh.colors.is_empty(),
    ];
    let mut layouts = Vec::new();
    for (location, _) in has.iter().enumerate().filter(|(_, has)| **has) {
        // Each attribute lies at the beginning of a buffer of its own.
        const OWN: [wgpu::VertexAttribute; 4] = {
            let mut own = ATTRIBUTES;
            let mut i = 0;
            while i < own.len() {
                own[i].offset = 0;
                i += 1;
            }
            own
        };
        layouts.push(wgpu::VertexBufferLayout {
            array_stride: OWN[location].format.size(),
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: std::slice::from_ref(&OWN[location]),
        });
    }
    layouts
}

/// A number, as a pointer would keep a renderer on one thread.
fn address<T>(source: &Arc<T>) -> usize {
    Arc::as_ptr(source).addr()
}

fn check_mesh(object: &Object) -> Result<(), RenderError> {
    let mesh = &object.mesh;
    let vertices = mesh.positions.len();
    let fits = |what: &str, ok: bool| {
        let problem = format!("its {what} do not fit its {vertices} positions");
        let object = object.name.clone();
        if ok {
            Ok(())
        } else {
            Err(RenderError::Mesh { object, problem })
        }
    };
    fits("normals", mesh.normals.len() == vertices)?;
    fits("texture coordinates", mesh.uvs.len() == vertices)?;
    fits("colours", [0, vertices].contains(&mesh.colors.len()))?;
    fits(
        "indices",
        mesh.indices
            .iter()
            .all(|index| (*index as usize) < vertices),
    )?;
    fits("indices", u32::try_from(mesh.indices.len()).is_ok())
}

/// Uploads a mesh whose arrays fit each other.
fn upload_mesh(gpu: &Gpu, object: &Object, vertices: Vertices) -> Result<GpuMesh, RenderError> {
    let mesh = &object.mesh;
    let what = format!("the mesh of object `{}`", object.name);
    let vertex = |bytes: &[u8]| match bytes.is_empty() {
        true => Ok(None),
        false => gpu
            .buffer(&what, wgpu::BufferUsages::VERTEX, bytes)
            .map(Some),
    };
    let count = mesh.indices.len() as u32;
    match vertices {
        Vertices::Shared => Ok(GpuMesh {
            attributes: [
                vertex(bytemuck::cast_slice(&mesh.positions))?,
                vertex(bytemuck::cast_slice(&mesh.normals))?,
                vertex(bytemuck::cast_slice(&mesh.uvs))?,
                vertex(bytemuck::cast_slice(&mesh.colors))?,
            ],
            indices: Some(gpu.buffer(
                &what,
                wgpu::BufferUsages::INDEX,
                bytemuck::cast_slice(&mesh.indices),
            )?),
            count,
            closed: OnceLock::new(),
        }),
        Vertices::Own => Ok(GpuMesh {
            attributes: [
                vertex(bytemuck::cast_slice(&own(mesh, &mesh.positions)))?,
                vertex(bytemuck::cast_slice(&own(mesh, &mesh.normals)))?,
                vertex(bytemuck::cast_slice(&own(mesh, &mesh.uvs)))?,
                vertex(bytemuck::cast_slice(&own(mesh, &mesh.colors)))?,
            ],
            indices: None,
            count,
            closed: OnceLock::new(),
        }),
    }
}

/// `values`, one a vertex, as the mesh's indices list them.
fn own<T: Copy>(mesh: &Mesh, values: &[T]) -> Vec<T> {
    let listed = mesh.indices.iter().map(|index| values.get(*index as usize));
    listed.flatten().copied().collect()
}

fn upload_image(gpu: &Gpu, what: &str, image: &Image) -> Result<wgpu::TextureView, RenderError> {
    let size = |level: &Level| wgpu::Extent3d {
        width: level.width,
        height: level.height,
        depth_or_array_layers: 1,
    };
    let texture = gpu.texture(
        what,
        image.levels.first().map(size).unwrap_or_default(),
        image.levels.len() as u32,
        wgpu::TextureFormat::Rgba8UnormSrgb,
        wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
    )?;
    for (number, level) in image.levels.iter().enumerate() {
        let target = wgpu::TexelCopyTextureInfo {
            mip_level: number as u32,
            ..texture.as_image_copy()
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * level.width),
            rows_per_image: None,
        };
        gpu.queue.write_texture(
            target,
            bytemuck::cast_slice(&level.rgba),
            layout,
            size(level),
        );
    }
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}

/// How `texture` is sampled; without one, clamped and smooth.
pub(super) fn sampler(texture: Option<&Texture>) -> wgpu::SamplerDescriptor<'static> {
    let (wrap, smooth) = texture.map_or(([Wrap::Clamp; 2], true), |texture| {
        (texture.wrap, texture.smooth)
    });
    let [u, v] = wrap.map(|wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
    });
    let magnify = if smooth {
        wgpu::FilterMode::Linear
    } else {
        wgpu::FilterMode::Nearest
    };
    wgpu::SamplerDescriptor {
        address_mode_u: u,
        address_mode_v: v,
        mag_filter: magnify,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    }
}
