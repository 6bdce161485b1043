//! Pipelines, made from what a linked permutation says of itself.

use std::{borrow::Cow, collections::BTreeSet, sync::Arc};

use umbrage_compose::{
    Binding, BindingKind, Blend, Factor, Permutation, ProjectedKey, Stage, TextureDimension,
    TextureSample,
};

use crate::Error;

/// Textures and samplers that are not to be filtered: their names, and the [instances](Binding::instance) that they are of.
pub type Unfiltered = BTreeSet<(usize, String)>;

/// How a pass draws, apart from its shader.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct DrawState {
    /// Where colours go, by location; none where they are not written.
    pub colors: Vec<ColorState>,
    /// The format of the depths; none where there are none.
    pub depth: Option<wgpu::TextureFormat>,
    /// How depths are compared.
    pub compare: wgpu::CompareFunction,
    /// Whether depths are written.
    pub write_depth: bool,
    /// Which faces are left out.
    pub cull: Option<wgpu::Face>,
    /// Which faces are fronts.
    pub front: wgpu::FrontFace,
    /// Textures and samplers that are not to be filtered.
    pub unfiltered: Unfiltered,
}

impl DrawState {
    /// The state of a pass without targets.
    pub const NOTHING: Self = Self {
        colors: Vec::new(),
        depth: None,
        compare: wgpu::CompareFunction::Always,
        write_depth: false,
        cull: None,
        front: wgpu::FrontFace::Ccw,
        unfiltered: BTreeSet::new(),
    };

    /// The same for what is mirrored, if it is. Where it makes no difference which side is the front, one pipeline serves both.
    #[must_use]
    pub fn facing(mut self, mirrored: bool, permutation: &Permutation) -> Self {
        if mirrored && (self.cull.is_some() || reads_facing(permutation)) {
            self.front = wgpu::FrontFace::Cw;
        }
        self
    }
}

/// Layouts of vertex buffers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Vertices(Vec<(u64, wgpu::VertexStepMode, Vec<wgpu::VertexAttribute>)>);

impl Vertices {
    /// These layouts.
    pub fn new(layouts: &[wgpu::VertexBufferLayout<'_>]) -> Self {
        let owned = |layout: &wgpu::VertexBufferLayout<'_>| {
            let attributes = layout.attributes.to_vec();
            (layout.array_stride, layout.step_mode, attributes)
        };
        Self(layouts.iter().map(owned).collect())
    }

    /// The same, as a pipeline is made from them.
    pub fn layouts(&self) -> Vec<wgpu::VertexBufferLayout<'_>> {
        let layouts = self.0.iter();
        let layouts = layouts.map(|(stride, step, attributes)| wgpu::VertexBufferLayout {
            array_stride: *stride,
            step_mode: *step,
            attributes,
        });
        layouts.collect()
    }
}

/// All that tells render pipelines apart.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct PipelineId {
    keys: Vec<ProjectedKey>,
    pub(crate) state: DrawState,
    vertices: Vertices,
}

impl PipelineId {
    /// The pipeline that draws vertices in buffers of these layouts with `permutation`.
    pub(crate) fn new(
        permutation: &Permutation,
        state: DrawState,
        vertices: &[wgpu::VertexBufferLayout<'_>],
    ) -> Self {
        Self {
            keys: permutation.keys().cloned().collect(),
            state,
            vertices: Vertices::new(vertices),
        }
    }
}

/// How a pass writes colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ColorState {
    /// The format.
    pub format: wgpu::TextureFormat,
    /// How what is drawn meets what is there; without it, it takes its place.
    pub blend: Option<wgpu::BlendState>,
    /// The channels that are written.
    pub channels: wgpu::ColorWrites,
}

impl ColorState {
    /// All channels of a `format`; without a `blend`, what is drawn takes the place of what is there.
    pub fn new(format: wgpu::TextureFormat, blend: Option<wgpu::BlendState>) -> Self {
        Self {
            format,
            blend,
            channels: wgpu::ColorWrites::ALL,
        }
    }
}

/// A shader and what it wants bound.
pub struct Program {
    /// The shader.
    pub permutation: Arc<Permutation>,
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    /// By group; none where the shader reads nothing of it.
    pub groups: Vec<Option<wgpu::BindGroupLayout>>,
}

impl Program {
    /// The program of `permutation`, in which `unfiltered` names textures and samplers that are not to be filtered.
    fn new(
        device: &wgpu::Device,
        permutation: Arc<Permutation>,
        unfiltered: &Unfiltered,
    ) -> Result<Self, Error> {
        let label = permutation.key.to_string();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(&label),
            source: wgpu::ShaderSource::Naga(Cow::Owned(permutation.module.clone())),
        });
        let groups = group_layouts(device, &permutation, unfiltered)?;
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
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
    pub fn bindings(&self, group: usize) -> impl Iterator<Item = &Binding> {
        let bindings = &self.permutation.reflection.bindings;
        bindings
            .iter()
            .filter(move |binding| binding.group as usize == group)
    }
}

/// A compute pipeline.
pub struct Computation {
    /// Its shader.
    pub program: Program,
    /// Itself.
    pub pipeline: wgpu::ComputePipeline,
}

impl Computation {
    /// The pipeline that runs `permutation`; `unfiltered` names textures and samplers that are not to be filtered.
    ///
    /// # Errors
    /// A binding that no compute pass can have.
    pub fn new(
        device: &wgpu::Device,
        permutation: Arc<Permutation>,
        unfiltered: &Unfiltered,
    ) -> Result<Self, Error> {
        let program = Program::new(device, permutation, unfiltered)?;
        let entry = program.permutation.reflection.entry_point(Stage::Compute);
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
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
pub struct Pipeline {
    /// Its shader.
    pub program: Program,
    /// Itself.
    pub pipeline: wgpu::RenderPipeline,
}

impl Pipeline {
    /// The pipeline that draws vertices in buffers of these layouts with `permutation`.
    ///
    /// # Errors
    /// A binding that no render pass can have, or a colour that the shader does not give.
    pub fn new(
        device: &wgpu::Device,
        permutation: Arc<Permutation>,
        state: &DrawState,
        vertices: &[wgpu::VertexBufferLayout<'_>],
    ) -> Result<Self, Error> {
        let given = colors(&permutation);
        let written = (0..).zip(&state.colors);
        let mut written = written.filter(|(_, color)| !color.channels.is_empty());
        if let Some((location, _)) = written.find(|(location, _)| !given.contains(location)) {
            return Err(Error::Colors {
                key: permutation.key.to_string(),
                location,
                targets: state.colors.len(),
            });
        }
        let program = Program::new(device, permutation, &state.unfiltered)?;
        let module = &program.module;
        let entry = |stage| program.permutation.reflection.entry_point(stage);
        let buffers: Vec<_> = vertices.iter().cloned().map(Some).collect();
        let targets = state.colors.iter().map(|color| {
            Some(wgpu::ColorTargetState {
                format: color.format,
                blend: color.blend,
                write_mask: color.channels,
            })
        });
        let targets: Vec<_> = targets.collect();
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(&program.permutation.key.to_string()),
            layout: Some(&program.layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: entry(Stage::Vertex).map(|entry| entry.name.as_str()),
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
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        });
        Ok(Self { program, pipeline })
    }
}

/// State for a pass's blend; none where what is drawn takes the other's place.
pub fn blend_state(blend: Blend) -> Option<wgpu::BlendState> {
    let factors = blend.factors()?.map(|factor| match factor {
        Factor::Zero => wgpu::BlendFactor::Zero,
        Factor::One => wgpu::BlendFactor::One,
        Factor::Drawn => wgpu::BlendFactor::Src,
    });
    Some(blended(factors, wgpu::BlendOperation::Add))
}

/// Keeps the larger one, channel by channel. WebGPU allows no other factors.
pub const MAX: wgpu::BlendState = blended([wgpu::BlendFactor::One; 2], wgpu::BlendOperation::Max);

const fn blended(
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

/// Those of vertex buffers' `layouts` that `permutation` reads: their places among all, and themselves.
pub fn vertices_read<'a>(
    permutation: &Permutation,
    layouts: &[wgpu::VertexBufferLayout<'a>],
) -> (Vec<usize>, Vec<wgpu::VertexBufferLayout<'a>>) {
    let entry = permutation.reflection.entry_point(Stage::Vertex);
    let inputs = entry.map_or(&[][..], |entry| &entry.inputs);
    let is_read = |layout: &wgpu::VertexBufferLayout<'_>| {
        let mut locations = layout.attributes.iter().map(|a| a.shader_location);
        locations.any(|location| inputs.iter().any(|input| input.location == location))
    };
    let all = layouts.iter().enumerate();
    let read = all.filter(|(_, layout)| is_read(layout));
    read.map(|(place, layout)| (place, layout.clone())).unzip()
}

/// The locations at which a fragment gives colours.
fn colors(permutation: &Permutation) -> BTreeSet<u32> {
    let module = &permutation.module;
    let is_fragment =
        |entry: &&wgpu::naga::EntryPoint| entry.stage == wgpu::naga::ShaderStage::Fragment;
    let entry = module.entry_points.iter().find(is_fragment);
    let Some(result) = entry.and_then(|entry| entry.function.result.as_ref()) else {
        return BTreeSet::new();
    };
    let location = |binding: &Option<wgpu::naga::Binding>| match binding {
        Some(wgpu::naga::Binding::Location { location, .. }) => Some(*location),
        _ => None,
    };
    match &module.types[result.ty].inner {
        wgpu::naga::TypeInner::Struct { members, .. } => members
            .iter()
            .filter_map(|member| location(&member.binding))
            .collect(),
        _ => location(&result.binding).into_iter().collect(),
    }
}

/// Whether a fragment asks which side of its triangle is seen.
pub fn reads_facing(permutation: &Permutation) -> bool {
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

fn group_layouts(
    device: &wgpu::Device,
    permutation: &Permutation,
    unfiltered: &Unfiltered,
) -> Result<Vec<Option<wgpu::BindGroupLayout>>, Error> {
    let reflection = &permutation.reflection;
    let limit = device.limits().max_bind_groups;
    let mut bindings = reflection.bindings.iter();
    if let Some(beyond) = bindings.find(|binding| binding.group >= limit) {
        let problem = format!(
            "group {} is beyond the device's {limit} groups",
            beyond.group
        );
        return Err(Error::binding(&permutation.key, beyond, problem));
    }
    let mut layouts = Vec::new();
    for (group, bindings) in reflection.groups().into_iter().enumerate() {
        let mut entries = Vec::new();
        for binding in bindings {
            let unfiltered = unfiltered.contains(&(binding.instance, binding.name.clone()));
            let ty = binding_type(binding, unfiltered).ok_or_else(|| {
                let problem = "no pass has such a resource to give";
                Error::binding(&permutation.key, binding, problem)
            })?;
            entries.push(wgpu::BindGroupLayoutEntry {
                binding: binding.binding,
                visibility: visibility(&binding.stages),
                ty,
                count: None,
            });
        }
        layouts.push((!entries.is_empty()).then(|| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
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

/// The layout's word for a binding; none for what passes do not bind.
fn binding_type(binding: &Binding, unfiltered: bool) -> Option<wgpu::BindingType> {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    Some(match &binding.kind {
        BindingKind::Uniform(_) => buffer(wgpu::BufferBindingType::Uniform),
        BindingKind::Storage {
            read_only: true, ..
        } => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
        BindingKind::Storage {
            read_only: false, ..
        } if binding.stages == [Stage::Compute] => {
            buffer(wgpu::BufferBindingType::Storage { read_only: false })
        }
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
pub const STORED: [wgpu::TextureFormat; 3] = [
    wgpu::TextureFormat::R32Float,
    wgpu::TextureFormat::Rgba16Float,
    wgpu::TextureFormat::Rgba32Float,
];

/// A format to store to, by naga's name, which is wgpu's.
fn storage_format(name: &str) -> Option<wgpu::TextureFormat> {
    let mut formats = STORED.into_iter();
    formats.find(|format| format!("{format:?}") == name)
}
