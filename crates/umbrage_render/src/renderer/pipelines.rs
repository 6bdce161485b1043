//! Pipelines, made from what a linked permutation says of itself.

use std::{borrow::Cow, collections::BTreeSet, sync::Arc};

use umbrage_compose::{
    Binding, BindingKind, EntryPoint, Permutation, Stage, TextureDimension, TextureSample,
};

use crate::{Gpu, RenderError};

/// How a pass draws, apart from its shader.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct DrawState {
    pub(super) color: Option<ColorState>,
    /// None where there is no depth to test.
    pub(super) depth: Option<wgpu::TextureFormat>,
    pub(super) compare: wgpu::CompareFunction,
    pub(super) write_depth: bool,
    pub(super) cull: Option<wgpu::Face>,
    pub(super) front: wgpu::FrontFace,
    /// Names of textures and samplers in the pass's and the light's group that are not to be filtered.
    pub(super) unfiltered: BTreeSet<String>,
}

/// How a pass writes colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ColorState {
    pub(super) format: wgpu::TextureFormat,
    pub(super) blend: Blend,
    /// The channels that are written.
    pub(super) channels: wgpu::ColorWrites,
}

/// What becomes of what is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Blend {
    /// What is drawn takes its place.
    Replace,
    /// What is drawn is added to it.
    Add,
    /// It is multiplied with what is drawn.
    Multiply,
}

/// A pipeline and what it wants bound.
pub(super) struct Pipeline {
    pub(super) permutation: Arc<Permutation>,
    pub(super) pipeline: wgpu::RenderPipeline,
    /// By group; none where the shader reads nothing of it.
    pub(super) groups: Vec<Option<wgpu::BindGroupLayout>>,
    /// The attribute in each vertex buffer's place.
    pub(super) attributes: Vec<u32>,
}

impl Pipeline {
    pub(super) fn new(
        gpu: &Gpu,
        permutation: Arc<Permutation>,
        state: &DrawState,
    ) -> Result<Self, RenderError> {
        let label = permutation.key.to_string();
        let module = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(&label),
                source: wgpu::ShaderSource::Naga(Cow::Owned(permutation.module.clone())),
            });
        let groups = group_layouts(gpu, &permutation, state)?;
        let layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(&label),
                bind_group_layouts: &groups.iter().map(Option::as_ref).collect::<Vec<_>>(),
                immediate_size: 0,
            });
        let entry = |stage| entry_point(&permutation, stage);
        let vertex = entry(Stage::Vertex);
        let attributes = attributes(vertex);
        let buffers: Vec<_> = attributes
            .iter()
            .map(|attribute| {
                Some(wgpu::VertexBufferLayout {
                    array_stride: attribute.format.size(),
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: std::slice::from_ref(attribute),
                })
            })
            .collect();
        let targets = [state.color.map(|color| wgpu::ColorTargetState {
            format: color.format,
            blend: color.blend.state(),
            write_mask: color.channels,
        })];
        let pipeline = gpu
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(&label),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: vertex.map(|entry| entry.name.as_str()),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &buffers,
                },
                primitive: wgpu::PrimitiveState {
                    front_face: state.front,
                    cull_mode: state.cull,
                    ..Default::default()
                },
                depth_stencil: state.depth.map(|format| wgpu::DepthStencilState {
                    format,
                    depth_write_enabled: Some(state.write_depth),
                    depth_compare: Some(state.compare),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState::default(),
                fragment: entry(Stage::Fragment).map(|entry| wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(&entry.name),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: if state.color.is_some() { &targets } else { &[] },
                }),
                multiview_mask: None,
                cache: None,
            });
        let attributes = attributes
            .iter()
            .map(|attribute| attribute.shader_location)
            .collect();
        Ok(Self {
            permutation,
            pipeline,
            groups,
            attributes,
        })
    }

    /// The bindings of one group.
    pub(super) fn bindings(&self, group: usize) -> impl Iterator<Item = &Binding> {
        let bindings = &self.permutation.reflection.bindings;
        bindings
            .iter()
            .filter(move |binding| binding.group as usize == group)
    }
}

impl Blend {
    fn state(self) -> Option<wgpu::BlendState> {
        use wgpu::BlendFactor::{One, Src, Zero};
        let (src_factor, dst_factor) = match self {
            Self::Replace => return None,
            Self::Add => (One, One),
            Self::Multiply => (Zero, Src),
        };
        let all = wgpu::BlendComponent {
            src_factor,
            dst_factor,
            operation: wgpu::BlendOperation::Add,
        };
        Some(wgpu::BlendState {
            color: all,
            alpha: all,
        })
    }
}

fn entry_point(permutation: &Permutation, stage: Stage) -> Option<&EntryPoint> {
    permutation
        .reflection
        .entry_points
        .iter()
        .find(|entry| entry.stage == stage)
}

/// The vertex inputs as attributes of the mesh's buffers; what a mesh does not have is left to the
/// device to refuse, by name.
fn attributes(vertex: Option<&EntryPoint>) -> Vec<wgpu::VertexAttribute> {
    let inputs = vertex.map_or(&[][..], |entry| &entry.inputs);
    let format = |location| match location {
        0 | 1 => Some(wgpu::VertexFormat::Float32x3),
        2 => Some(wgpu::VertexFormat::Float32x2),
        _ => None,
    };
    inputs
        .iter()
        .filter_map(|input| {
            Some(wgpu::VertexAttribute {
                format: format(input.location)?,
                offset: 0,
                shader_location: input.location,
            })
        })
        .collect()
}

fn group_layouts(
    gpu: &Gpu,
    permutation: &Permutation,
    state: &DrawState,
) -> Result<Vec<Option<wgpu::BindGroupLayout>>, RenderError> {
    let bindings = &permutation.reflection.bindings;
    let count = bindings
        .iter()
        .map(|binding| binding.group + 1)
        .max()
        .unwrap_or(0);
    let limit = gpu.device.limits().max_bind_groups;
    if let Some(beyond) = bindings.iter().find(|binding| binding.group >= limit) {
        let problem = format!(
            "group {} is beyond the device's {limit} groups",
            beyond.group
        );
        return Err(RenderError::binding(&permutation.key, beyond, problem));
    }
    let mut layouts = Vec::new();
    for group in 0..count {
        let mut entries = Vec::new();
        for binding in bindings.iter().filter(|binding| binding.group == group) {
            let unfiltered = group <= 1 && state.unfiltered.contains(&binding.name);
            let ty = binding_type(&binding.kind, unfiltered).ok_or_else(|| {
                let problem = "a render pass has no such resource to give";
                RenderError::binding(&permutation.key, binding, problem)
            })?;
            entries.push(wgpu::BindGroupLayoutEntry {
                binding: binding.binding,
                visibility: visibility(&binding.stages),
                ty,
                count: None,
            });
        }
        layouts.push((!entries.is_empty()).then(|| {
            gpu.device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some(&format!("group {group} of {}", permutation.key)),
                    entries: &entries,
                })
        }));
    }
    Ok(layouts)
}

fn visibility(stages: &[Stage]) -> wgpu::ShaderStages {
    stages.iter().fold(wgpu::ShaderStages::NONE, |all, stage| {
        all | match stage {
            Stage::Vertex => wgpu::ShaderStages::VERTEX,
            Stage::Fragment => wgpu::ShaderStages::FRAGMENT,
            Stage::Compute => wgpu::ShaderStages::COMPUTE,
        }
    })
}

/// The layout's word for a binding; none for what render passes do not bind.
fn binding_type(kind: &BindingKind, unfiltered: bool) -> Option<wgpu::BindingType> {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    Some(match kind {
        BindingKind::Uniform(_) => buffer(wgpu::BufferBindingType::Uniform),
        BindingKind::Storage {
            read_only: true, ..
        } => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
        BindingKind::Texture {
            dimension,
            sample,
            multisampled,
        } => wgpu::BindingType::Texture {
            sample_type: match sample {
                TextureSample::Float => wgpu::TextureSampleType::Float {
                    filterable: !unfiltered,
                },
                TextureSample::Depth => wgpu::TextureSampleType::Depth,
                TextureSample::Sint => wgpu::TextureSampleType::Sint,
                TextureSample::Uint => wgpu::TextureSampleType::Uint,
            },
            view_dimension: match dimension {
                TextureDimension::D1 => wgpu::TextureViewDimension::D1,
                TextureDimension::D2 => wgpu::TextureViewDimension::D2,
                TextureDimension::D2Array => wgpu::TextureViewDimension::D2Array,
                TextureDimension::Cube => wgpu::TextureViewDimension::Cube,
                TextureDimension::CubeArray => wgpu::TextureViewDimension::CubeArray,
                TextureDimension::D3 => wgpu::TextureViewDimension::D3,
            },
            multisampled: *multisampled,
        },
        BindingKind::Sampler { comparison: true } => {
            wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)
        }
        BindingKind::Sampler { comparison: false } if unfiltered => {
            wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering)
        }
        BindingKind::Sampler { comparison: false } => {
            wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)
        }
        BindingKind::Storage {
            read_only: false, ..
        }
        | BindingKind::StorageTexture { .. } => {
            return None;
        }
    })
}
