//! WGSL text of a module, with its structs' layouts.
//!
//! Naga's writer leaves `@size` and `@align` out, so that a struct whose author asked for padding
//! would lie otherwise when read again. Here every member that is followed by more room than it needs
//! says so by `@size`, which fixes all offsets.

use crate::diagnostics::{Written, uses_subgroups};
use naga::{
    Handle, Module, Type, TypeInner,
    back::wgsl::{WriterFlags, write_string},
    proc::Layouter,
    valid::ModuleInfo,
};

/// The text of `module`, with the diagnostic filters that are `written` in it.
pub(crate) fn write(
    module: &Module,
    info: &ModuleInfo,
    written: &Written,
) -> Result<String, naga::back::wgsl::Error> {
    let text = written.annotate(&write_module(module, info)?);
    Ok(match uses_subgroups(module) {
        true => format!("enable subgroups;\n{text}"),
        false => text,
    })
}

fn write_module(module: &Module, info: &ModuleInfo) -> Result<String, naga::back::wgsl::Error> {
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
    Ok(with_own_names(module, out))
}

/// Whether an array's size is an override, for which the writer has no words.
pub(crate) fn has_sizes_of_overrides(module: &Module) -> bool {
    module.types.iter().any(|(_, ty)| match ty.inner {
        TypeInner::Array { size, .. } | TypeInner::BindingArray { size, .. } => {
            matches!(size, naga::ArraySize::Pending(_))
        }
        _ => false,
    })
}

/// Whether the writer can say the module's overrides: it knows values, but neither expressions of other
/// overrides nor workgroups' sizes that depend on them.
pub(crate) fn can_say_overrides(module: &Module) -> bool {
    let derived =
        |expression: &naga::Expression| matches!(expression, naga::Expression::Override(_));
    let sized = |entry: &naga::EntryPoint| {
        let sizes = entry.workgroup_size_overrides.iter().flatten();
        sizes.flatten().next().is_some()
    };
    !module
        .global_expressions
        .iter()
        .any(|(_, expression)| derived(expression))
        && !module.entry_points.iter().any(sized)
}

/// Gives entry points and overrides the names that a host knows them by: the writer adds `_` to a name
/// that ends in a digit, and numbers one that something else has, too.
fn with_own_names(module: &Module, text: String) -> String {
    let mut entries = module.entry_points.iter().map(|entry| entry.name.as_str());
    let named = module
        .overrides
        .iter()
        .filter(|(_, item)| item.id.is_none());
    let mut overrides = named.filter_map(|(_, item)| item.name.as_deref());
    let mut renames = Vec::new();
    let mut stage = false;
    for line in text.lines() {
        // Both come in the module's order, a stage's attribute on a line of its own.
        let (written, own) = if let Some(rest) = line.strip_prefix("override ") {
            (rest.split(':').next(), overrides.next())
        } else if stage && line.starts_with("fn ") {
            (line["fn ".len()..].split('(').next(), entries.next())
        } else {
            stage = ["@vertex", "@fragment", "@compute"]
                .iter()
                .any(|s| line.starts_with(s));
            continue;
        };
        stage = false;
        if let (Some(written), Some(own)) = (written, own)
            && written != own
        {
            renames.push((written.to_owned(), own));
        }
    }
    renames.into_iter().fold(text, |text, (written, own)| {
        // What has the name already makes way.
        let text = replace_word(&text, own, &format!("{own}_other"));
        replace_word(&text, &written, own)
    })
}

fn replace_word(text: &str, word: &str, with: &str) -> String {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let mut out = String::with_capacity(text.len());
    let mut from = 0;
    for (at, _) in text.match_indices(word) {
        let whole = !text[..at].ends_with(part) && !text[at + word.len()..].starts_with(part);
        // A member keeps its name.
        if at >= from && whole && !text[..at].ends_with('.') {
            out.push_str(&text[from..at]);
            out.push_str(with);
            from = at + word.len();
        }
    }
    out.push_str(&text[from..]);
    out
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
