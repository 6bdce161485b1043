//! Whether a module implements an interface.

use naga::{Function, Handle, Module, Type, TypeInner};
use umbrage_hints::nearest;

use crate::{Cause, Fault, Library, unit::Unit};

/// Checks that `implementation` defines each function of `contract` with the same signature.
pub(crate) fn check(
    library: &Library,
    contract: (usize, &Unit),
    implementation: (usize, &Unit),
) -> Result<(), Fault> {
    let mut names: Vec<_> = contract.1.own_functions.iter().collect();
    names.sort();
    let interface = library.source(contract.0);
    let source = library.source(implementation.0);
    for (name, handle) in names {
        let expected = || written(library, contract.0, name);
        let Some(own) = implementation.1.own_functions.get(name) else {
            let message = format!("`{}` does not implement `{}`", source.path, interface.path);
            let fault = Fault::new(Cause::Interface, message)
                .at(source.place_labelled(0..0, format!("no `fn {name}` here")))
                .note(format!("expected {}", expected()));
            let known = implementation.1.own_functions.keys().map(String::as_str);
            return Err(match nearest(name, known) {
                Some(near) => fault.note(format!("is `{near}` meant to be it?")),
                None => fault,
            });
        };
        if contract.1.signature(*handle) != implementation.1.signature(*own) {
            let message = format!(
                "`{name}` does not have the signature that `{}` asks for",
                interface.path
            );
            let place = library
                .syntax(implementation.0)?
                .tree
                .global_declarations
                .iter()
                .filter(|node| crate::names::declared(node).as_ref() == Some(name))
                .map(|node| {
                    source.place(node.span().start..header_end(&source.text, node.span().start))
                })
                .next();
            let found = written(library, implementation.0, name);
            let fault = Fault::new(Cause::Interface, message);
            let fault = match place {
                Some(place) => fault.at(place),
                None => fault.at(source.find(name)),
            };
            return Err(fault
                .note(format!("expected {}", expected()))
                .note(format!("found    {found}")));
        }
    }
    Ok(())
}

/// The function's header as its author wrote it.
fn written(library: &Library, module: usize, name: &str) -> String {
    let text = &library.source(module).text;
    let start = text.match_indices("fn ").map(|(at, _)| at).find(|at| {
        text[at + 3..]
            .trim_start()
            .strip_prefix(name)
            .is_some_and(|rest| rest.trim_start().starts_with('('))
    });
    match start {
        Some(start) => {
            let header = &text[start..header_end(text, start)];
            let words: Vec<_> = header.split_whitespace().collect();
            format!("`{}`", words.join(" "))
        }
        None => format!("a function `{name}`"),
    }
}

fn header_end(text: &str, start: usize) -> usize {
    let end = text[start..].find('{').map_or(text.len(), |at| start + at);
    start + text[start..end].trim_end().len()
}

/// Types of a function's parameters and result, in words that are the same in every unit.
pub(crate) type Signature = (Vec<String>, Option<String>);

pub(crate) fn signature(unit: &Unit, handle: Handle<Function>) -> Signature {
    let function = &unit.module.functions[handle];
    let arguments = function
        .arguments
        .iter()
        .map(|a| describe(unit, &unit.module, a.ty))
        .collect();
    let result = function
        .result
        .as_ref()
        .map(|result| describe(unit, &unit.module, result.ty));
    (arguments, result)
}

fn describe(unit: &Unit, module: &Module, handle: Handle<Type>) -> String {
    match &module.types[handle].inner {
        TypeInner::Struct { members, .. } => {
            let members: Vec<_> = members
                .iter()
                .map(|member| {
                    let name = member.name.as_deref().unwrap_or("");
                    format!("{name}: {}", describe(unit, module, member.ty))
                })
                .collect();
            let name = unit.type_names[handle.index()].as_deref().unwrap_or("");
            format!("{name} {{ {} }}", members.join(", "))
        }
        TypeInner::Array { base, size, .. } => {
            format!("array<{}, {size:?}>", describe(unit, module, *base))
        }
        TypeInner::Pointer { base, space } => {
            format!("ptr<{space:?}, {}>", describe(unit, module, *base))
        }
        TypeInner::BindingArray { base, size } => {
            format!("binding_array<{}, {size:?}>", describe(unit, module, *base))
        }
        other => format!("{other:?}"),
    }
}
