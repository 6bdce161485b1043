//! Binding numbers.

use std::collections::{BTreeMap, btree_map};

use naga::{AddressSpace, GlobalVariable, Handle, Module, ResourceBinding};

use crate::{Cause, Fault, Library, names::Item};

/// Gives every resource its binding number: the author's where it is free in its group, otherwise
/// the least that is, in the order of instances and of the modules' paths.
pub(crate) fn allocate(
    library: &Library,
    module: &mut Module,
    (owners, instances): (&[Item], &[usize]),
) -> Result<(), Fault> {
    let mut resources = Vec::new();
    for (handle, global) in module.global_variables.iter() {
        let resource = match global.space {
            AddressSpace::Uniform | AddressSpace::Storage { .. } | AddressSpace::Handle => true,
            AddressSpace::Function
            | AddressSpace::Private
            | AddressSpace::WorkGroup
            | AddressSpace::Immediate
            | AddressSpace::TaskPayload
            | AddressSpace::RayPayload
            | AddressSpace::IncomingRayPayload => false,
        };
        let Some(item) = owners.get(handle.index()).filter(|_| resource) else {
            continue;
        };
        let source = library.source(item.module);
        let Some(binding) = global.binding else {
            let message = format!(
                "the resource `{}` has no `@group` and `@binding`",
                item.name
            );
            return Err(Fault::new(Cause::Type, message)
                .at(source.find(&item.name))
                .note("group 0 is the pass's, 1 the light's and its method's, 2 the material's, 3 the objects'"));
        };
        resources.push((
            binding.group,
            instances[handle.index()],
            source.path.as_str(),
            binding.binding,
            &item.name,
            handle,
        ));
    }
    resources.sort();
    let mut taken: BTreeMap<(u32, u32), Handle<GlobalVariable>> = BTreeMap::new();
    let mut late = Vec::new();
    for (group, _, _, binding, _, handle) in &resources {
        match taken.entry((*group, *binding)) {
            btree_map::Entry::Vacant(entry) => {
                entry.insert(*handle);
            }
            btree_map::Entry::Occupied(_) => late.push((*group, *handle)),
        }
    }
    for (group, handle) in late {
        let free = (0..).find(|binding| !taken.contains_key(&(group, *binding)));
        taken.insert((group, free.unwrap_or(u32::MAX)), handle);
    }
    for ((group, binding), handle) in taken {
        module.global_variables.get_mut(handle).binding = Some(ResourceBinding { group, binding });
    }
    Ok(())
}
