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
    pub(super) depth: Option<wgpu::TextureFormat>,
    pub(super) compare: wgpu::CompareFunction,
    pub(super) write_depth: bool,
    pub(super) cull: Option<wgpu::Face>,
    pub(super) front: wgpu::FrontFace,
    /// Names of textures and samplers in the pass's and the light's group that are not to be filtered.
    pub(super) unfiltered: BTreeSet<String>,
}

impl DrawState {
    /// That of a pass without targets.
    pub(super) const NOTHING: Self = Self {
        color: None,
        depth: None,
        compare: wgpu::CompareFunction::Always,
        write_depth: false,
        cull: None,
        front: wgpu::FrontFace::Ccw,
        unfiltered: BTreeSet::new(),
    };
}

/// How a pass writes colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ColorState {
    pub(super) format: wgpu::TextureFormat,
    /// How what is drawn meets what is there; without it, it takes its place.
    pub(super) blend: Option<wgpu::BlendState>,
    /// The channels that are written.
    pub(super) channels: wgpu::ColorWrites,
}

/// A shader and what it wants bound.
pub(super) struct Program {
    pub(super) permutation: Arc<Permutation>,
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    /// By group; none where the shader reads nothing of it.
    pub(super) groups: Vec<Option<wgpu::BindGroupLayout>>,
}

impl Program {
    /// That of `permutation`, in which `unfiltered` names textures and samplers of the pass's and the light's
    /// group that are not to be filtered.
    fn new(
        gpu: &Gpu,
        permutation: Arc<Permutation>,
        unfiltered: &BTreeSet<String>,
    ) -> Result<Self, RenderError> {
        let label = permutation.key.to_string();
        let module = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(&label),
                source: wgpu::ShaderSource::Naga(Cow::Owned(permutation.module.clone())),
            });
        let groups = group_layouts(gpu, &permutation, unfiltered)?;
        let layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(&label),
                bind_group_layouts: &groups.iter().map(Option::as_ref).collect::<Vec<_>>(),
                immediate_size: 0,
            });
        Ok(Self {
            permutation,
            module,
            layout,
            groups,
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

/// A compute pipeline.
pub(super) struct Computation {
    pub(super) program: Program,
    pub(super) pipeline: wgpu::ComputePipeline,
}

impl Computation {
    pub(super) fn new(
        gpu: &Gpu,
        permutation: Arc<Permutation>,
        unfiltered: &BTreeSet<String>,
    ) -> Result<Self, RenderError> {
        let program = Program::new(gpu, permutation, unfiltered)?;
        let entry = program.permutation.reflection.entry_point(Stage::Compute);
        let pipeline = gpu
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&program.permutation.key.to_string()),
                layout: Some(&program.layout),
                module: &program.module,
                entry_point: entry.map(|entry| entry.name.as_str()),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
        Ok(Self { program, pipeline })
    }
}

/// A render pipeline.
pub(super) struct Pipeline {
    pub(super) program: Program,
    pub(super) pipeline: wgpu::RenderPipeline,
    /// The attribute in each vertex buffer's place.
    pub(super) attributes: Vec<u32>,
}

impl Pipeline {
    pub(super) fn new(
        gpu: &Gpu,
        permutation: Arc<Permutation>,
        state: &DrawState,
    ) -> Result<Self, RenderError> {
        let program = Program::new(gpu, permutation, &state.unfiltered)?;
        let module = &program.module;
        let entry = |stage| program.permutation.reflection.entry_point(stage);
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
            blend: color.blend,
            write_mask: color.channels,
        })];
        let pipeline = gpu
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(&program.permutation.key.to_string()),
                layout: Some(&program.layout),
                vertex: wgpu::VertexState {
                    module,
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
                    module,
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
            program,
            pipeline,
            attributes,
        })
    }
}

/// Adds what is drawn to what is there.
pub(super) const ADD: wgpu::BlendState = blend(ONES, wgpu::BlendOperation::Add);

/// Keeps the larger one, channel by channel.
pub(super) const MAX: wgpu::BlendState = blend(ONES, wgpu::BlendOperation::Max);

/// Multiplies what is there with what is drawn.
pub(super) const MULTIPLY: wgpu::BlendState = blend(
    [wgpu::BlendFactor::Zero, wgpu::BlendFactor::Src],
    wgpu::BlendOperation::Add,
);

/// With `Max`, WebGPU allows no other factors.
const ONES: [wgpu::BlendFactor; 2] = [wgpu::BlendFactor::One; 2];

const fn blend(
    [src_factor, dst_factor]: [wgpu::BlendFactor; 2],
    operation: wgpu::BlendOperation,
) -> wgpu::BlendState {
    let component = wgpu::BlendComponent {
        src_factor,
        dst_factor,
        operation,
    };
    wgpu::BlendState {
        color: component,
        alpha: component,
    }
}

/// Whether a fragment asks which side of its triangle is seen.
pub(super) fn reads_facing(permutation: &Permutation) -> bool {
    let facing = Some(wgpu::naga::Binding::BuiltIn(
        wgpu::naga::BuiltIn::FrontFacing,
    ));
    let module = &permutation.module;
    let entries = module.entry_points.iter();
    entries
        .flat_map(|entry| &entry.function.arguments)
        .any(|argument| match &module.types[argument.ty].inner {
            wgpu::naga::TypeInner::Struct { members, .. } => {
                members.iter().any(|member| member.binding == facing)
            }
            _ => argument.binding == facing,
        })
}

/// The vertex inputs as attributes of the mesh's buffers; what a mesh does not have is left to the
/// device to refuse, by name.
fn attributes(vertex: Option<&EntryPoint>) -> Vec<wgpu::VertexAttribute> {
    let inputs = vertex.map_or(&[][..], |entry| &entry.inputs);
    let format = |location| match location {
        0 | 1 => Some(wgpu::VertexFormat::Float32x3),
        2 => Some(wgpu::VertexFormat::Float32x2),
        3 => Some(wgpu::VertexFormat::Float32x4),
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
    unfiltered: &BTreeSet<String>,
) -> Result<Vec<Option<wgpu::BindGroupLayout>>, RenderError> {
    let reflection = &permutation.reflection;
    let limit = gpu.device.limits().max_bind_groups;
    let mut bindings = reflection.bindings.iter();
    if let Some(beyond) = bindings.find(|binding| binding.group >= limit) {
        let problem = format!(
            "group {} is beyond the device's {limit} groups",
            beyond.group
        );
        return Err(RenderError::binding(&permutation.key, beyond, problem));
    }
    let mut layouts = Vec::new();
    for (group, bindings) in reflection.groups().into_iter().enumerate() {
        let mut entries = Vec::new();
        for binding in bindings {
            let unfiltered = group <= 1 && unfiltered.contains(&binding.name);
            let ty = binding_type(&binding.kind, unfiltered).ok_or_else(|| {
                let problem = "no pass has such a resource to give";
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
            view_dimension: view_dimension(*dimension),
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
        BindingKind::StorageTexture {
            dimension,
            format,
            read: false,
            ..
        } => wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: storage_format(format)?,
            view_dimension: view_dimension(*dimension),
        },
        BindingKind::Storage {
            read_only: false, ..
        }
        | BindingKind::StorageTexture { read: true, .. } => return None,
    })
}

fn view_dimension(dimension: TextureDimension) -> wgpu::TextureViewDimension {
    match dimension {
        TextureDimension::D1 => wgpu::TextureViewDimension::D1,
        TextureDimension::D2 => wgpu::TextureViewDimension::D2,
        TextureDimension::D2Array => wgpu::TextureViewDimension::D2Array,
        TextureDimension::Cube => wgpu::TextureViewDimension::Cube,
        TextureDimension::CubeArray => wgpu::TextureViewDimension::CubeArray,
        TextureDimension::D3 => wgpu::TextureViewDimension::D3,
    }
}

/// The formats of floats that WebGPU's baseline can store to.
pub(super) const STORED: [wgpu::TextureFormat; 3] = [
    wgpu::TextureFormat::R32Float,
    wgpu::TextureFormat::Rgba16Float,
    wgpu::TextureFormat::Rgba32Float,
];

/// A format to store to, by naga's name, which is wgpu's.
fn storage_format(name: &str) -> Option<wgpu::TextureFormat> {
    let mut formats = STORED.into_iter();
    formats.find(|format| format!("{format:?}") == name)
}
