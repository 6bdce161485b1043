//! WGSL text of a module, with its structs' layouts.
//!
//! Naga's writer leaves `@size` and `@align` out, so that a struct whose author asked for padding
//! would lie otherwise when read again. Here every member that is followed by more room than it needs
//! says so by `@size`, which fixes all offsets.

use naga::{
    Handle, Module, Type, TypeInner,
    back::wgsl::{WriterFlags, write_string},
    proc::Layouter,
    valid::ModuleInfo,
};

pub(crate) fn write(module: &Module, info: &ModuleInfo) -> Result<String, naga::back::wgsl::Error> {
    let text = write_string(module, info, WriterFlags::empty())?;
    let mut layouter = Layouter::default();
    // A valid module has a layout.
    if layouter.update(module.to_ctx()).is_err() {
        return Ok(text);
    }
    let mut sizes = module
        .types
        .iter()
        .filter(|(handle, _)| !is_predeclared(module, *handle))
        .filter_map(|(_, ty)| sizes(&layouter, ty));
    let mut out = String::with_capacity(text.len());
    let mut members = Vec::new().into_iter();
    for line in text.split_inclusive('\n') {
        // The writer puts structs down in the order of their types, a member a line.
        if line.starts_with("struct ") {
            members = sizes.next().unwrap_or_default().into_iter();
        } else if line.starts_with("    ")
            && let Some(Some(size)) = members.next()
        {
            out.push_str(&format!("    @size({size}) {}", line.trim_start()));
            continue;
        }
        out.push_str(line);
    }
    Ok(out)
}

fn is_predeclared(module: &Module, handle: Handle<Type>) -> bool {
    module
        .special_types
        .predeclared_types
        .values()
        .any(|known| *known == handle)
}

/// For each member of a struct the room that it must ask for, if it takes more than it needs.
fn sizes(layouter: &Layouter, ty: &Type) -> Option<Vec<Option<u32>>> {
    let TypeInner::Struct { members, span } = &ty.inner else {
        return None;
    };
    let alignment = members
        .iter()
        .map(|member| layouter[member.ty].alignment)
        .max()?;
    let sizes = members.iter().enumerate().map(|(index, member)| {
        let natural = member.offset + layouter[member.ty].size;
        let (expected, end) = match members.get(index + 1) {
            Some(next) => (layouter[next.ty].alignment.round_up(natural), next.offset),
            None => (alignment.round_up(natural), *span),
        };
        (expected != end).then(|| end - member.offset)
    });
    Some(sizes.collect())
}
