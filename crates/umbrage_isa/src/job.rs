//! Pipelines to be compiled for a permutation.

use std::borrow::Cow;

use naga::back::{pipeline_constants::process_overrides, spv};
use umbrage_compose::{Binding, EntryPoint, Permutation, Reflection, Stage};

use crate::{
    PipelineState,
    wire::{Attribute, Color, Depth, Draw, Job, Shader, Slot, Work},
    words,
};

/// A pipeline, and the entry points that are in it.
pub(crate) struct Planned {
    pub(crate) job: Job,
    pub(crate) entry_points: Vec<(Stage, String)>,
}

/// The pipelines of `permutation`: one that draws, of the first vertex and fragment stages, and one for each
/// compute stage.
pub(crate) fn plan(
    permutation: &Permutation,
    state: &PipelineState,
) -> Result<Vec<Planned>, String> {
    let reflection = &permutation.reflection;
    let mut planned = Vec::new();
    let drawn = [Stage::Vertex, Stage::Fragment].map(|stage| reflection.entry_point(stage));
    match drawn {
        [None, None] => {}
        [None, Some(fragment)] => {
            return Err(format!(
                "`{}` has no vertex stage beside it, so there is no pipeline to compile; declare one in the \
                 pass's module",
                fragment.name
            ));
        }
        [Some(vertex), fragment] => planned.push(draw(permutation, state, vertex, fragment)?),
    }
    let entries = reflection.entry_points.iter();
    for entry in entries.filter(|entry| entry.stage == Stage::Compute) {
        planned.push(Planned {
            job: Job {
                sets: sets(&permutation.reflection),
                work: Work::Compute(shader(permutation, entry)?),
            },
            entry_points: vec![(entry.stage, entry.name.clone())],
        });
    }
    if planned.is_empty() {
        return Err("it has no entry point; a pass declares at least one".to_owned());
    }
    Ok(planned)
}

fn draw(
    permutation: &Permutation,
    state: &PipelineState,
    vertex: &EntryPoint,
    fragment: Option<&EntryPoint>,
) -> Result<Planned, String> {
    let attributes = vertex.inputs.iter().map(|input| {
        let (format, size) = words::attribute(input).ok_or_else(|| {
            format!(
                "the vertex input `{}` is of no attribute's type",
                input.name
            )
        })?;
        Ok(Attribute {
            location: input.location,
            format: format.as_raw(),
            size,
        })
    });
    let format = |format| {
        let known = words::format(format).map(ash::vk::Format::as_raw);
        known.ok_or_else(|| format!("nothing is drawn into the format {format:?}"))
    };
    let colors = state.colors.iter().map(|target| {
        let Some(target) = target else {
            return Ok(Color {
                format: ash::vk::Format::UNDEFINED.as_raw(),
                write_mask: 0,
                blend: None,
            });
        };
        let blend = target.blend;
        Ok(Color {
            format: format(target.format)?,
            write_mask: ash::vk::ColorComponentFlags::RGBA.as_raw(),
            blend: blend.map(|blend| [words::blend(blend.color), words::blend(blend.alpha)]),
        })
    });
    let depth = state.depth.map(|target| {
        Ok::<_, String>(Depth {
            format: format(target.format)?,
            compare: words::compare(target.compare).as_raw(),
            write: target.write,
        })
    });
    let draw = Draw {
        vertex: shader(permutation, vertex)?,
        fragment: fragment
            .map(|entry| shader(permutation, entry))
            .transpose()?,
        attributes: attributes.collect::<Result<_, String>>()?,
        topology: ash::vk::PrimitiveTopology::TRIANGLE_LIST.as_raw(),
        cull: words::cull(state.cull).as_raw(),
        front: words::front(state.front).as_raw(),
        colors: colors.collect::<Result<_, String>>()?,
        depth: depth.transpose()?,
    };
    let entries = [Some(vertex), fragment].into_iter().flatten();
    Ok(Planned {
        job: Job {
            sets: sets(&permutation.reflection),
            work: Work::Draw(draw),
        },
        entry_points: entries
            .map(|entry| (entry.stage, entry.name.clone()))
            .collect(),
    })
}

/// The bindings by group; a group that nothing is in is an empty set.
fn sets(reflection: &Reflection) -> Vec<Vec<Slot>> {
    let slot = |binding: &Binding| {
        let stages = binding.stages.iter().copied().map(words::stage);
        let stages = stages.fold(ash::vk::ShaderStageFlags::empty(), |all, stage| all | stage);
        Slot {
            binding: binding.binding,
            descriptor: words::descriptor(&binding.kind).as_raw(),
            stages: stages.as_raw(),
        }
    };
    let groups = reflection.groups().into_iter();
    groups
        .map(|group| group.iter().map(slot).collect())
        .collect()
}

/// The SPIR-V of one entry point, as wgpu's Vulkan backend has it written for a device that keeps reads of
/// buffers and textures within bounds by itself, which RADV's do.
fn shader(permutation: &Permutation, entry: &EntryPoint) -> Result<Shader, String> {
    use naga::proc::{
        BoundsCheckPolicies,
        BoundsCheckPolicy::{Restrict, Unchecked},
    };
    let stage = match entry.stage {
        Stage::Vertex => naga::ShaderStage::Vertex,
        Stage::Fragment => naga::ShaderStage::Fragment,
        Stage::Compute => naga::ShaderStage::Compute,
    };
    let refused = |error: &dyn std::error::Error| format!("it cannot be said in SPIR-V: {error}");
    let info = permutation.info().map_err(|error| refused(&error))?;
    let (module, info): (Cow<'_, _>, Cow<'_, _>) = process_overrides(
        &permutation.module,
        info,
        Some((stage, &entry.name)),
        &Default::default(),
    )
    .map_err(|error| refused(&error))?;
    let options = spv::Options {
        lang_version: (1, 6),
        flags: spv::WriterFlags::LABEL_VARYINGS | spv::WriterFlags::FORCE_POINT_SIZE,
        bounds_check_policies: BoundsCheckPolicies {
            index: Restrict,
            buffer: Unchecked,
            image_load: Unchecked,
            binding_array: Unchecked,
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::Native,
        ..Default::default()
    };
    let pipeline = spv::PipelineOptions {
        shader_stage: stage,
        entry_point: entry.name.clone(),
    };
    let code = spv::write_vec(&module, &info, &options, Some(&pipeline));
    Ok(Shader {
        entry_point: entry.name.clone(),
        code: code.map_err(|error| refused(&error))?,
    })
}
