//! Rules for a stage's use of resources: no vertex stage writes, and a storage texture's format allows only some
//! kinds of access (<https://gpuweb.github.io/gpuweb/#texture-format-caps>).

use naga::{
    AddressSpace, Handle, ImageClass, Module, ShaderStage, StorageAccess, StorageFormat, Type,
    TypeInner,
    valid::{GlobalUse, ModuleInfo},
};

use super::Subject;
use crate::Fault;

pub(super) fn check(subject: &Subject<'_>, info: &ModuleInfo) -> Result<(), Fault> {
    for (handle, global) in subject.module.global_variables.iter() {
        let entries = subject.module.entry_points.iter().enumerate();
        let mut used = entries
            .filter(|(index, _)| info.get_entry_point(*index)[handle] != GlobalUse::empty())
            .map(|(_, entry)| entry);
        let name = global.name.as_deref().unwrap_or("");
        if global.space == AddressSpace::WorkGroup {
            let Some(entry) = used.find(|entry| entry.stage != ShaderStage::Compute) else {
                continue;
            };
            let message = format!(
                "`{}` uses the workgroup variable `{name}`, but is no compute stage",
                entry.name
            );
            let advice = "a `private` variable is an invocation's own";
            return Err(subject.at_variable(handle, message).note(advice));
        }
        let (kind, writes) = match (global.space, &subject.module.types[global.ty].inner) {
            (AddressSpace::Storage { access }, _) => {
                if !access.contains(StorageAccess::STORE) && has_atomic(subject.module, global.ty) {
                    let message =
                        format!("the storage buffer `{name}` has atomics and is read-only");
                    let advice = "atomics need `read_write` access";
                    return Err(subject.at_variable(handle, message).note(advice));
                }
                ("storage buffer", access)
            }
            (
                _,
                TypeInner::Image {
                    class: ImageClass::Storage { format, access },
                    ..
                },
            ) => {
                storage_texture(*format, *access).map_err(|(message, advice)| {
                    subject.at_variable(handle, message).note(advice)
                })?;
                ("storage texture", *access)
            }
            _ => continue,
        };
        let vertex = used.find(|entry| entry.stage == ShaderStage::Vertex);
        if let Some(entry) = vertex
            && writes.contains(StorageAccess::STORE)
            && !subject.target.has_vertex_writes()
        {
            let message = format!(
                "the vertex stage `{}` uses the {kind} `{name}`, which is not read-only",
                entry.name
            );
            let advice = "a vertex stage writes nothing: declare it with `read` access, or move the work into a compute stage";
            return Err(subject.at_variable(handle, message).note(advice));
        }
    }
    Ok(())
}

fn has_atomic(module: &Module, ty: Handle<Type>) -> bool {
    match &module.types[ty].inner {
        TypeInner::Atomic(_) => true,
        TypeInner::Array { base, .. } => has_atomic(module, *base),
        TypeInner::Struct { members, .. } => {
            members.iter().any(|member| has_atomic(module, member.ty))
        }
        _ => false,
    }
}

/// Whether a storage texture may have `format` with `access`, on a device without optional features.
fn storage_texture(
    format: StorageFormat,
    access: StorageAccess,
) -> Result<(), (String, &'static str)> {
    use StorageFormat as F;
    let name = wgsl_name(format);
    match format {
        // Any access is allowed.
        F::R32Uint | F::R32Sint | F::R32Float => Ok(()),
        // Reading or writing is allowed, but not both.
        F::Rgba8Unorm
        | F::Rgba8Snorm
        | F::Rgba8Uint
        | F::Rgba8Sint
        | F::Rgba16Uint
        | F::Rgba16Sint
        | F::Rgba16Float
        | F::Rg32Uint
        | F::Rg32Sint
        | F::Rg32Float
        | F::Rgba32Uint
        | F::Rgba32Sint
        | F::Rgba32Float => {
            if access.contains(StorageAccess::LOAD) && access.contains(StorageAccess::STORE) {
                Err((
                    format!(
                        "a storage texture of the format `{name}` cannot be read and written at once"
                    ),
                    "of WebGPU's formats `r32float`, `r32uint` and `r32sint` can; or read from one texture and write to another",
                ))
            } else {
                Ok(())
            }
        }
        _ => Err((
            format!(
                "a storage texture cannot have the format `{name}` without a feature of the device"
            ),
            "every device has the formats of 32 bits a channel, `rgba8…` and, but for normalised ones, `rgba16…`",
        )),
    }
}

/// WGSL's name for `format`: naga's, in lower case.
fn wgsl_name(format: StorageFormat) -> String {
    format!("{format:?}").to_lowercase()
}
