//! Inputs of a fragment stage must match the outputs of the vertex stage in its module: at each location, the same
//! type and the same interpolation (<https://gpuweb.github.io/gpuweb/#validating-inter-stage-interfaces>).

use std::collections::BTreeMap;

use naga::{
    Binding, EntryPoint, Handle, Interpolation, Module, Sampling, ShaderStage, Type, TypeInner,
};

use super::Subject;
use crate::Fault;

pub(super) fn check(subject: &Subject<'_>) -> Result<(), Fault> {
    let stage = |stage| {
        let entries = subject.module.entry_points.iter();
        entries.filter(move |entry| entry.stage == stage)
    };
    for compute in stage(ShaderStage::Compute) {
        let taken = inputs(subject.module, compute);
        if !taken.located.is_empty() || compute.function.result.is_some() {
            let message = format!(
                "the compute stage `{}` takes or gives something at a location",
                compute.name
            );
            let advice = "a compute stage has built-in inputs alone; it reads and writes buffers and textures";
            return Err(subject
                .at_entry(compute, &compute.name, message)
                .note(advice));
        }
    }
    for fragment in stage(ShaderStage::Fragment) {
        let taken = inputs(subject.module, fragment);
        let mut refusal = None;
        for vertex in stage(ShaderStage::Vertex) {
            match fits(&taken, &outputs(subject.module, vertex), fragment, vertex) {
                Ok(()) => {
                    refusal = None;
                    break;
                }
                Err(reason) => {
                    refusal.get_or_insert(reason);
                }
            }
        }
        if let Some((word, message)) = refusal {
            return Err(subject
                .at_entry(fragment, &word, message)
                .note("let both stages share one struct"));
        }
    }
    Ok(())
}

/// An input or output at a location.
pub(super) struct Varying {
    pub(super) name: String,
    ty: Handle<Type>,
    /// Interpolation and sampling, with WGSL's defaults filled in where the author wrote none.
    how: (Option<Interpolation>, Option<Sampling>),
}

/// Inputs or outputs of an entry point, by location, and its built-in values.
pub(super) struct Varyings {
    pub(super) located: BTreeMap<u32, Varying>,
    pub(super) built_ins: Vec<naga::BuiltIn>,
}

pub(super) fn inputs(module: &Module, entry: &EntryPoint) -> Varyings {
    let arguments = entry.function.arguments.iter();
    let parts = arguments.flat_map(|argument| {
        parts(
            module,
            argument.ty,
            &argument.name,
            argument.binding.as_ref(),
        )
    });
    Varyings::new(parts)
}

pub(super) fn outputs(module: &Module, entry: &EntryPoint) -> Varyings {
    let result = entry.function.result.iter();
    Varyings::new(
        result.flat_map(|result| parts(module, result.ty, &None, result.binding.as_ref())),
    )
}

type Part<'a> = (Handle<Type>, &'a Option<String>, Option<&'a Binding>);

/// The value itself, or the members of a struct.
fn parts<'a>(
    module: &'a Module,
    ty: Handle<Type>,
    name: &'a Option<String>,
    binding: Option<&'a Binding>,
) -> Vec<Part<'a>> {
    match &module.types[ty].inner {
        TypeInner::Struct { members, .. } => members
            .iter()
            .map(|member| (member.ty, &member.name, member.binding.as_ref()))
            .collect(),
        _ => vec![(ty, name, binding)],
    }
}

impl Varyings {
    fn new<'a>(parts: impl Iterator<Item = Part<'a>>) -> Self {
        let mut all = Self {
            located: BTreeMap::new(),
            built_ins: Vec::new(),
        };
        for (ty, name, binding) in parts {
            match binding {
                Some(Binding::Location {
                    location,
                    interpolation,
                    sampling,
                    ..
                }) => {
                    let how = match (interpolation, sampling) {
                        (Some(Interpolation::Flat), None) => {
                            (*interpolation, Some(Sampling::First))
                        }
                        (_, None) => (*interpolation, Some(Sampling::Center)),
                        (_, given) => (*interpolation, *given),
                    };
                    let name = name.clone().unwrap_or_default();
                    all.located.insert(*location, Varying { name, ty, how });
                }
                Some(Binding::BuiltIn(built_in)) => all.built_ins.push(*built_in),
                None => {}
            }
        }
        all
    }
}

/// First mismatch between the inputs of `fragment` and the outputs of `vertex`: the word to point at, and the
/// reason.
fn fits(
    taken: &Varyings,
    given: &Varyings,
    fragment: &EntryPoint,
    vertex: &EntryPoint,
) -> Result<(), (String, String)> {
    let (fragment, vertex) = (&fragment.name, &vertex.name);
    for (location, input) in &taken.located {
        let refuse = |message| Err((input.name.clone(), message));
        let Some(output) = given.located.get(location) else {
            return refuse(format!(
                "`{fragment}` takes location {location}, which `{vertex}` does not give"
            ));
        };
        if input.ty != output.ty {
            return refuse(format!(
                "`{fragment}` takes location {location} as another type than `{vertex}` gives"
            ));
        }
        if input.how != output.how {
            return refuse(format!(
                "`{fragment}` takes location {location} interpolated otherwise than `{vertex}` gives it"
            ));
        }
    }
    Ok(())
}
