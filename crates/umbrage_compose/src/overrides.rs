//! Overrides: constants that a host sets by name or number.

use std::{
    borrow::Cow,
    collections::{BTreeMap, btree_map::Entry},
};

use naga::{
    EntryPoint, Expression, Function, Handle, Literal, LocalVariable, Module, Scalar, ScalarKind,
    ShaderStage, Span, Statement, TypeInner,
    back::{
        PipelineConstants,
        pipeline_constants::{PipelineConstantError, process_overrides},
    },
    valid::ModuleInfo,
};
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use crate::{
    Cause, Fault, Library,
    names::{self, Item},
};

/// A constant that a host may set when it makes a pipeline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Override {
    /// Its name, by which a host sets it if it has no number.
    pub name: String,
    /// Its number (`@id`), by which a host sets it if it has one.
    pub id: Option<u16>,
    /// The module that declares it, as `package::folder::module`.
    pub module: String,
    /// Its type.
    pub ty: OverrideType,
    /// Its value where the host sets nothing, in WebGPU's form (1 and 0 for true and false). None where the host
    /// must set this override, or an override that its default is computed from.
    pub default: Option<f64>,
    /// Whether its default is computed from other overrides, and so follows the values that the host sets for them.
    pub derived: bool,
    /// Its form in SPIR-V.
    pub spirv: InSpirv,
}

/// An override's type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OverrideType {
    /// `bool`.
    Bool,
    /// `f32`.
    F32,
    /// `f16`.
    F16,
    /// `i32`.
    I32,
    /// `u32`.
    U32,
}

/// Form of an override in [`Permutation::spirv`](crate::Permutation::spirv). It is never a specialisation constant,
/// as naga's writer has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InSpirv {
    /// A constant at its default, which no host can change.
    FixedAtDefault,
    /// None: the override has no default, so the permutation cannot be written as SPIR-V.
    NotWritten,
}

/// Checks that a host can tell all overrides and entry points of the linked `module` apart; `root` declares the entry
/// points.
pub(crate) fn check(
    library: &Library,
    root: usize,
    module: &Module,
    owners: &FxHashMap<Handle<naga::Override>, Item>,
) -> Result<(), Fault> {
    let mut names: BTreeMap<&str, Known<'_>> = BTreeMap::new();
    for entry in &module.entry_points {
        names.insert(&entry.name, Known::EntryPoint(root));
    }
    let mut ids: BTreeMap<u16, Known<'_>> = BTreeMap::new();
    for (handle, item) in module.overrides.iter() {
        let Some(owner) = owners.get(&handle) else {
            continue;
        };
        let (earlier, called) = match item.id {
            Some(id) => (
                ids.entry(id).or_insert(Known::Override(owner)),
                format!("`@id({id})`"),
            ),
            None => {
                let known = match names.entry(&owner.name) {
                    Entry::Vacant(entry) => entry.insert(Known::Override(owner)),
                    Entry::Occupied(entry) => entry.into_mut(),
                };
                (known, format!("`{}`", owner.name))
            }
        };
        if !matches!(earlier, Known::Override(known) if std::ptr::eq(*known, owner)) {
            return Err(clash(library, &called, earlier, owner));
        }
    }
    Ok(())
}

/// A declaration that a host may know by a name or number.
enum Known<'a> {
    /// An entry point of this module.
    EntryPoint(usize),
    Override(&'a Item),
}

fn clash(library: &Library, called: &str, earlier: &Known<'_>, later: &Item) -> Fault {
    let place = |item: &Item, label: &str| {
        let source = library.source(item.module);
        let declared = library.syntax(item.module).ok().and_then(|syntax| {
            let mut declarations = syntax.tree.global_declarations.iter();
            let named = declarations.find(|d| names::declared(d).as_ref() == Some(&item.name));
            Some(named?.span().range())
        });
        match declared {
            Some(range) => source.place_labelled(range, label),
            None => source.find(&item.name),
        }
    };
    let path = |module: usize| &library.source(module).path;
    match earlier {
        Known::Override(earlier) => {
            let message = match (path(earlier.module), path(later.module)) {
                (module, other) if module == other => format!(
                    "`{module}` has two overrides {called}, and a host that sets it sets one alone"
                ),
                (module, other) => format!(
                    "`{module}` and `{other}` both have an override {called}, and a host that sets it sets one alone"
                ),
            };
            Fault::new(Cause::Validation, message)
                .at(place(later, ""))
                .at(place(earlier, "the other"))
                .note("rename one of them, or give it an `@id` of its own; or declare it in one module, and import it in the other")
        }
        Known::EntryPoint(root) => {
            let name = &later.name;
            let message = format!(
                "`{}` has an override {called}, which is an entry point of `{}`",
                path(later.module),
                path(*root)
            );
            let mut entry = library.source(*root).find(&format!("fn {name}"));
            entry.label = "the entry point".to_owned();
            Fault::new(Cause::Validation, message)
                .at(place(later, ""))
                .at(entry)
                .note("a host knows both by their names: rename one of them")
        }
    }
}

/// `module` with all overrides at their defaults.
pub(crate) fn resolved<'a>(
    module: &'a Module,
    info: &'a ModuleInfo,
) -> Result<(Cow<'a, Module>, Cow<'a, ModuleInfo>), PipelineConstantError> {
    let constants = PipelineConstants::default();
    let is_nameless = |item: &naga::Override| item.name.is_none() && item.id.is_none();
    if !module.overrides.iter().any(|(_, item)| is_nameless(item)) {
        return process_overrides(module, info, None, &constants);
    }
    // Naga skips overrides without a name, and then takes one override for another.
    let mut named = module.clone();
    for (_, item) in named.overrides.iter_mut() {
        item.name.get_or_insert_with(|| "length".to_owned());
    }
    let (module, info) = process_overrides(&named, info, None, &constants)?;
    Ok((
        Cow::Owned(module.into_owned()),
        Cow::Owned(info.into_owned()),
    ))
}

/// Overrides that a host may set in a valid `module`, sorted by name.
pub(crate) fn reflect(
    module: &Module,
    info: &ModuleInfo,
    owner: impl Fn(Handle<naga::Override>) -> Option<(String, String)>,
) -> Vec<Override> {
    let mut overrides: Vec<_> = module
        .overrides
        .iter()
        .filter_map(|(handle, item)| {
            let (module_path, name) = owner(handle)?;
            let default = default(module, info, handle);
            Some(Override {
                name,
                id: item.id,
                module: module_path,
                ty: ty(module, item)?,
                default,
                derived: item.init.is_some_and(|init| is_derived(module, init)),
                spirv: match default {
                    Some(_) => InSpirv::FixedAtDefault,
                    None => InSpirv::NotWritten,
                },
            })
        })
        .collect();
    overrides.sort_by(|a, b| (&a.name, &a.module).cmp(&(&b.name, &b.module)));
    overrides
}

fn ty(module: &Module, item: &naga::Override) -> Option<OverrideType> {
    match module.types[item.ty].inner {
        TypeInner::Scalar(Scalar { kind, width }) => Some(match (kind, width) {
            (ScalarKind::Bool, _) => OverrideType::Bool,
            (ScalarKind::Float, 2) => OverrideType::F16,
            (ScalarKind::Sint, _) => OverrideType::I32,
            (ScalarKind::Uint, _) => OverrideType::U32,
            _ => OverrideType::F32,
        }),
        // The type of a valid override is always a scalar.
        _ => None,
    }
}

/// Whether a value with the initializer `init` depends on an override.
fn is_derived(module: &Module, init: Handle<Expression>) -> bool {
    let mut function = Function {
        expressions: module.global_expressions.clone(),
        ..Function::default()
    };
    let value = Some(init);
    function
        .body
        .push(Statement::Return { value }, Span::UNDEFINED);
    let mut alone = without_code(module);
    alone.entry_points.push(entry_point(function, None));
    naga::compact::compact(&mut alone, naga::compact::KeepUnused::No);
    !alone.overrides.is_empty()
}

/// Value of the override `handle` with all overrides at their defaults.
fn default(module: &Module, info: &ModuleInfo, handle: Handle<naga::Override>) -> Option<f64> {
    let mut function = Function::default();
    let local = LocalVariable {
        name: None,
        ty: module.overrides[handle].ty,
        init: None,
    };
    let local = function.local_variables.append(local, Span::UNDEFINED);
    let expressions = &mut function.expressions;
    let pointer = expressions.append(Expression::LocalVariable(local), Span::UNDEFINED);
    let value = expressions.append(Expression::Override(handle), Span::UNDEFINED);
    let store = Statement::Store { pointer, value };
    function.body.push(store, Span::UNDEFINED);
    let mut alone = without_code(module);
    alone.entry_points.push(entry_point(function, None));
    let (resolved, _) = resolved(&alone, info).ok()?;
    // The overrides that it is computed from remain as well, and come before it.
    let (_, last) = resolved.overrides.iter().last()?;
    match resolved.global_expressions[last.init?] {
        Expression::Literal(literal) => number(literal),
        Expression::ZeroValue(_) => Some(0.0),
        Expression::Constant(constant) => {
            let init = resolved.constants[constant].init;
            match resolved.global_expressions[init] {
                Expression::Literal(literal) => number(literal),
                _ => None,
            }
        }
        _ => None,
    }
}

fn number(literal: Literal) -> Option<f64> {
    Some(match literal {
        Literal::F32(value) => value.into(),
        Literal::F16(value) => value.into(),
        Literal::U32(value) => value.into(),
        Literal::I32(value) => value.into(),
        Literal::Bool(value) => f64::from(u8::from(value)),
        _ => return None,
    })
}

/// Workgroup size of `entry` along each axis with all overrides at their defaults; 0 where it depends on an
/// override without a default.
pub(crate) fn workgroup_size(module: &Module, info: &ModuleInfo, entry: &EntryPoint) -> [u32; 3] {
    let Some(overrides) = entry.workgroup_size_overrides else {
        return entry.workgroup_size;
    };
    let mut size = entry.workgroup_size;
    for (axis, size) in size.iter_mut().enumerate() {
        if overrides[axis].is_none() {
            continue;
        }
        let mut one = [None; 3];
        one[axis] = overrides[axis];
        let mut alone = without_code(module);
        alone
            .entry_points
            .push(entry_point(Function::default(), Some(one)));
        let constants = PipelineConstants::default();
        *size = process_overrides(&alone, info, None, &constants).map_or(0, |(resolved, _)| {
            resolved.entry_points[0].workgroup_size[axis]
        });
    }
    size
}

/// Parts of `module` that overrides and their values depend on.
fn without_code(module: &Module) -> Module {
    Module {
        types: module.types.clone(),
        special_types: module.special_types.clone(),
        constants: module.constants.clone(),
        overrides: module.overrides.clone(),
        global_expressions: module.global_expressions.clone(),
        ..Module::default()
    }
}

fn entry_point(
    function: Function,
    workgroup_size_overrides: Option<[Option<Handle<Expression>>; 3]>,
) -> EntryPoint {
    EntryPoint {
        name: "alone".to_owned(),
        stage: ShaderStage::Compute,
        early_depth_test: None,
        workgroup_size: [1; 3],
        workgroup_size_overrides,
        function,
        mesh_info: None,
        task_payload: None,
        incoming_ray_payload: None,
    }
}
