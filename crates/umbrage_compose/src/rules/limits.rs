//! Limits of a device.

use std::fmt;

use naga::{
    AddressSpace, ArraySize, BuiltIn, EntryPoint, GlobalVariable, Handle, Module, ShaderStage,
    Type, TypeInner,
    valid::{GlobalUse, ModuleInfo},
};

use super::{Subject, constants::Constants, varyings};
use crate::{
    Fault,
    reflect::{Binding, BindingKind, Reflection, Stage},
    target::Limit,
};

pub(super) fn check(
    subject: &Subject<'_>,
    info: &ModuleInfo,
    reflection: &Reflection,
    constants: &Constants<'_>,
) -> Result<(), Fault> {
    for binding in &reflection.bindings {
        binding_within(subject, binding)?;
    }
    let stages = [
        (Stage::Vertex, "vertex"),
        (Stage::Fragment, "fragment"),
        (Stage::Compute, "compute"),
    ];
    for stage in stages {
        bindings_of_stage(subject, reflection, stage)?;
    }
    for (index, entry) in subject.module.entry_points.iter().enumerate() {
        match entry.stage {
            ShaderStage::Vertex => vertex(subject, entry)?,
            ShaderStage::Fragment => fragment(subject, entry)?,
            _ => workgroup_memory(subject, info, (index, entry), constants)?,
        }
    }
    Ok(())
}

/// Checks the number of invocations in a workgroup.
pub(super) fn workgroup_sizes(
    subject: &Subject<'_>,
    constants: &Constants<'_>,
) -> Result<(), Fault> {
    for entry in &subject.module.entry_points {
        if entry.stage != ShaderStage::Compute {
            continue;
        }
        let name = &entry.name;
        let refuse = |message: String| subject.at_entry(entry, name, message);
        let mut invocations = 1u64;
        let limits = [
            ('x', Limit::ComputeWorkgroupSizeX),
            ('y', Limit::ComputeWorkgroupSizeY),
            ('z', Limit::ComputeWorkgroupSizeZ),
        ];
        for (dimension, (axis, limit)) in limits.into_iter().enumerate() {
            let given = entry
                .workgroup_size_overrides
                .and_then(|sizes| sizes[dimension]);
            let size = match given.map(|size| constants.integer(size)) {
                None => entry.workgroup_size[dimension].into(),
                Some(Some(size)) => size,
                // An override without a default: the host sets the size.
                Some(None) => 1,
            };
            if size < 1 {
                return Err(refuse(format!(
                    "`{name}` has workgroups of the size {size} along {axis}"
                ))
                .note("a workgroup has a size of 1 at the least"));
            }
            let what = format_args!("invocations along {axis} are in a workgroup of `{name}`");
            subject
                .limit(limit, size as u64, what)
                .map_err(|message| refuse(message).note("make the workgroup smaller"))?;
            invocations = invocations.saturating_mul(size as u64);
        }
        let what = format_args!("invocations are in a workgroup of `{name}`");
        subject
            .limit(Limit::ComputeInvocationsPerWorkgroup, invocations, what)
            .map_err(|message| refuse(message).note("make the workgroup smaller"))?;
    }
    Ok(())
}

fn at_binding(subject: &Subject<'_>, binding: &Binding, message: String) -> Fault {
    let fault = Fault::new(crate::Cause::Validation, message);
    match subject.library.module(&binding.module) {
        Some(module) => fault.at(subject.library.source(module).find(&binding.name)),
        None => fault,
    }
}

fn binding_within(subject: &Subject<'_>, binding: &Binding) -> Result<(), Fault> {
    let name = &binding.name;
    let within = |limit, found, what: fmt::Arguments<'_>, advice: &str| {
        subject
            .limit(limit, found, what)
            .map_err(|message| at_binding(subject, binding, message).note(advice))
    };
    let what = format_args!("bind groups are needed for `{name}`");
    let advice = "groups count from 0; use a lower one";
    within(
        Limit::BindGroups,
        u64::from(binding.group) + 1,
        what,
        advice,
    )?;
    let what = format_args!("binding numbers are needed for `{name}`");
    let advice = "bindings count from 0 in each group; use a lower one";
    let number = u64::from(binding.binding) + 1;
    within(Limit::BindingsPerBindGroup, number, what, advice)?;

    match &binding.kind {
        BindingKind::Uniform(layout) => within(
            Limit::UniformBufferBindingSize,
            layout.size.into(),
            format_args!("bytes are in the uniform buffer `{name}`"),
            "make it smaller, or a storage buffer",
        ),
        BindingKind::Storage {
            run_time: false,
            layout,
            ..
        } => within(
            Limit::StorageBufferBindingSize,
            layout.size.into(),
            format_args!("bytes are in the storage buffer `{name}`"),
            "make it smaller, or a run-time array that is bound in parts",
        ),
        _ => Ok(()),
    }
}

fn bindings_of_stage(
    subject: &Subject<'_>,
    reflection: &Reflection,
    (stage, stage_name): (Stage, &str),
) -> Result<(), Fault> {
    type IsKind = fn(&BindingKind) -> bool;
    let kinds: [(&str, Limit, IsKind); 5] = [
        (
            "textures are read",
            Limit::SampledTexturesPerStage,
            |kind| matches!(kind, BindingKind::Texture { .. }),
        ),
        ("samplers are used", Limit::SamplersPerStage, |kind| {
            matches!(kind, BindingKind::Sampler { .. })
        }),
        (
            "uniform buffers are read",
            Limit::UniformBuffersPerStage,
            |kind| matches!(kind, BindingKind::Uniform(_)),
        ),
        (
            "storage buffers are used",
            Limit::StorageBuffersPerStage,
            |kind| matches!(kind, BindingKind::Storage { .. }),
        ),
        (
            "storage textures are used",
            Limit::StorageTexturesPerStage,
            |kind| matches!(kind, BindingKind::StorageTexture { .. }),
        ),
    ];
    for (what, limit, kind) in kinds {
        let used = reflection
            .bindings
            .iter()
            .filter(|binding| binding.stages.contains(&stage));
        let used: Vec<_> = used.filter(|binding| kind(&binding.kind)).collect();
        let what = format_args!("{what} in the {stage_name} stage");
        subject
            .limit(limit, used.len() as u64, what)
            .map_err(|message| {
                let mut fault = match used.last() {
                    Some(last) => at_binding(subject, last, message),
                    None => Fault::new(crate::Cause::Limit, message),
                };
                fault.cause = crate::Cause::Limit;
                fault.note("use fewer, or pack them together")
            })?;
    }
    Ok(())
}

fn vertex(subject: &Subject<'_>, entry: &EntryPoint) -> Result<(), Fault> {
    let (taken, given) = (
        varyings::inputs(subject.module, entry),
        varyings::outputs(subject.module, entry),
    );
    located(
        subject,
        entry,
        &taken,
        (Limit::VertexAttributes, 0),
        "vertex attributes are read",
    )?;
    located(
        subject,
        entry,
        &given,
        (Limit::InterStageShaderVariables, 0),
        "variables are handed on",
    )
}

fn fragment(subject: &Subject<'_>, entry: &EntryPoint) -> Result<(), Fault> {
    let (taken, given) = (
        varyings::inputs(subject.module, entry),
        varyings::outputs(subject.module, entry),
    );
    // Each of these built-in values takes the room of a variable.
    let counted = |built_in: &&BuiltIn| {
        matches!(
            built_in,
            BuiltIn::FrontFacing | BuiltIn::SampleIndex | BuiltIn::SampleMask
        )
    };
    let built_ins = taken.built_ins.iter().filter(counted).count() as u64;
    located(
        subject,
        entry,
        &taken,
        (Limit::InterStageShaderVariables, built_ins),
        "variables, `front_facing`, `sample_index` and `sample_mask` among them, are taken",
    )?;
    located(
        subject,
        entry,
        &given,
        (Limit::ColorAttachments, 0),
        "colours are written",
    )
}

/// Checks that no location exceeds the limit, nor the number of values at locations plus `more`.
fn located(
    subject: &Subject<'_>,
    entry: &EntryPoint,
    all: &varyings::Varyings,
    (limit, more): (Limit, u64),
    what: &str,
) -> Result<(), Fault> {
    let Some((location, last)) = all.located.last_key_value() else {
        return Ok(());
    };
    let refuse = |message| subject.at_entry(entry, &last.name, message);
    let count = all.located.len() as u64 + more;
    subject
        .limit(limit, count, format_args!("{what} by `{}`", entry.name))
        .map_err(|message| refuse(message).note("use fewer, or pack them together"))?;
    let locations = u64::from(*location) + 1;
    let what = format_args!(
        "locations are needed for location {location} of `{}`",
        entry.name
    );
    subject
        .limit(limit, locations, what)
        .map_err(|message| refuse(message).note("locations count from 0; use a lower one"))
}

fn workgroup_memory(
    subject: &Subject<'_>,
    info: &ModuleInfo,
    (index, entry): (usize, &EntryPoint),
    constants: &Constants<'_>,
) -> Result<(), Fault> {
    let mut bytes = 0u64;
    let mut largest: Option<(u64, Handle<GlobalVariable>)> = None;
    for (handle, global) in subject.module.global_variables.iter() {
        if global.space != AddressSpace::WorkGroup
            || info.get_entry_point(index)[handle] == GlobalUse::empty()
        {
            continue;
        }
        // Each variable starts at a multiple of 16 bytes.
        let size = layout(subject.module, global.ty, constants)
            .size
            .next_multiple_of(16);
        bytes = bytes.saturating_add(size);
        if largest.is_none_or(|(most, _)| size > most) {
            largest = Some((size, handle));
        }
    }
    let what = format_args!("bytes of workgroup memory are used by `{}`", entry.name);
    subject
        .limit(Limit::ComputeWorkgroupStorageSize, bytes, what)
        .map_err(|message| {
            let fault = match largest {
                Some((_, handle)) => subject.at_variable(handle, message),
                None => subject.at_entry(entry, &entry.name, message),
            };
            fault.note(
                "this variable is the largest; make it smaller, or let the workgroup share less",
            )
        })
}

/// A type's size and alignment in bytes.
struct Extent {
    size: u64,
    align: u64,
}

/// Size and alignment of a value of the type, by WGSL's rules. They differ from naga's: a `bool` takes four bytes,
/// not one, and an array's length may be an override.
fn layout(module: &Module, ty: Handle<Type>, constants: &Constants<'_>) -> Extent {
    match &module.types[ty].inner {
        TypeInner::Vector { size, scalar } => {
            let width = width(*scalar);
            let slots = u64::from(*size as u8).next_power_of_two();
            Extent {
                size: u64::from(*size as u8) * width,
                align: slots * width,
            }
        }
        TypeInner::Matrix {
            columns,
            rows,
            scalar,
        } => {
            let align = u64::from(*rows as u8).next_power_of_two() * width(*scalar);
            Extent {
                size: u64::from(*columns as u8) * align,
                align,
            }
        }
        TypeInner::Array { base, size, .. } => {
            let element = layout(module, *base, constants);
            let count = match size {
                ArraySize::Constant(count) => u64::from(count.get()),
                ArraySize::Pending(item) => constants
                    .default(*item)
                    .and_then(|count| u64::try_from(count).ok())
                    .unwrap_or(1),
                ArraySize::Dynamic => 1,
            };
            Extent {
                size: element
                    .size
                    .next_multiple_of(element.align.max(1))
                    .saturating_mul(count),
                align: element.align,
            }
        }
        TypeInner::Struct { members, span } => {
            let mut extent = Extent { size: 0, align: 1 };
            for member in members {
                let own = layout(module, member.ty, constants);
                // Naga's offsets take the author's `@size` and `@align` into account.
                let start = extent.size.next_multiple_of(own.align.max(1));
                extent.size = start.max(member.offset.into()) + own.size;
                extent.align = extent.align.max(own.align);
            }
            extent.size = extent
                .size
                .next_multiple_of(extent.align)
                .max(u64::from(*span));
            extent
        }
        TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => Extent {
            size: width(*scalar),
            align: width(*scalar),
        },
        other => Extent {
            size: other.size(module.to_ctx()).into(),
            align: 1,
        },
    }
}

fn width(scalar: naga::Scalar) -> u64 {
    match scalar.kind {
        naga::ScalarKind::Bool => 4,
        _ => scalar.width.into(),
    }
}
