//! Linking: what is reachable from a module's roots, copied from the units into one module.
//!
//! Functions keep their expressions' numbers, so copying one is a clone in which only the handles
//! that lead outside are put right.

use std::{
    cell::{OnceCell, RefCell},
    sync::Arc,
};

use naga::{
    Arena, Block, Constant, EntryPoint, Expression, Function, GlobalVariable, Handle, Module,
    Override, Statement, Type, TypeInner,
};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::{
    Cause, Fault, Library, bindings,
    diagnostics::Filters,
    instances::{self, Call},
    interface,
    library::Request,
    names::Item,
    overrides,
    reach::{DEEPEST_CALLS, FunctionId, Program, Reach, reach},
    unit::{Unit, private_roots},
};

/// What to start from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Roots {
    /// The root module's entry points.
    EntryPoints,
    /// All that the root module declares.
    Declarations,
}

/// The declarations that a linked module's parts came from.
#[derive(Debug)]
pub(crate) struct Origins {
    pub(crate) owners: FxHashMap<Handle<GlobalVariable>, Item>,
    pub(crate) functions: FxHashMap<Handle<Function>, FunctionId>,
    pub(crate) overrides: FxHashMap<Handle<Override>, Item>,
    /// Diagnostic filters of each module that something was copied from.
    pub(crate) filters: FxHashMap<usize, Arc<Filters>>,
}

/// The units of the modules in hand.
pub(crate) trait Units {
    fn unit(&self, module: usize) -> Result<Arc<Unit>, Fault>;
}

/// Links what `request` asks for.
pub(crate) fn link(
    library: &Library,
    request: &Request,
    units: &dyn Units,
    roots: Roots,
) -> Result<(Module, Origins), Fault> {
    let targets = Targets {
        library,
        request,
        units,
        taken: vec![OnceCell::new(); library.sources().len()],
        known: RefCell::default(),
        checked: RefCell::default(),
    };
    let reach = reach(&targets, request.root, roots)?;
    let linker = Linker {
        targets,
        reach,
        roots,
        out: Module::default(),
        maps: FxHashMap::default(),
        functions: FxHashMap::default(),
        under_way: Vec::new(),
        globals: FxHashMap::default(),
        constants: FxHashMap::default(),
        overrides: FxHashMap::default(),
        own_names: FxHashSet::default(),
    };
    linker.link()
}

/// Finds what calls lead to, through the interfaces' bindings.
pub(crate) struct Targets<'a> {
    pub(crate) library: &'a Library,
    pub(crate) request: &'a Request,
    pub(crate) units: &'a dyn Units,
    /// The units that were asked for.
    taken: Vec<OnceCell<Arc<Unit>>>,
    known: RefCell<FxHashMap<FunctionId, FunctionId>>,
    checked: RefCell<FxHashSet<usize>>,
}

impl Program for Targets<'_> {
    fn library(&self) -> &Library {
        self.library
    }

    fn unit(&self, module: usize) -> Result<&Arc<Unit>, Fault> {
        match self.taken[module].get() {
            Some(unit) => Ok(unit),
            None => {
                let unit = self.units.unit(module)?;
                Ok(self.taken[module].get_or_init(|| unit))
            }
        }
    }

    fn target(&self, called: FunctionId) -> Result<FunctionId, Fault> {
        if let Some(target) = self.known.borrow().get(&called) {
            return Ok(*target);
        }
        let unit = self.unit(called.0)?;
        let item = &unit.functions[&called.1];
        let target = if item.module == called.0 {
            called
        } else {
            let module = self.implementation(called.0, item)?;
            let other = self.unit(module)?;
            match other.own_functions.get(&item.name) {
                Some(handle) => (module, *handle),
                None => return Err(self.not_callable(called.0, module, item)),
            }
        };
        self.known.borrow_mut().insert(called, target);
        Ok(target)
    }
}

impl Targets<'_> {
    /// Calls from module to module that were followed, ordered by the calling module and the names that it calls by.
    fn calls(&self) -> Result<Vec<Call>, Fault> {
        let mut calls = Vec::new();
        for (&(module, called), &target) in self.known.borrow().iter() {
            if target.0 == module {
                continue;
            }
            let unit = self.unit(module)?;
            let item = &unit.functions[&called];
            let name = unit.module.functions[called].name.clone();
            let name = name.unwrap_or_default();
            calls.push(Call {
                module,
                alias: instances::alias(self.library, &name, item),
                name,
                by_interface: item.module != target.0,
                target,
            });
        }
        calls.sort_by(|a, b| (a.module, &a.name).cmp(&(b.module, &b.name)));
        Ok(calls)
    }

    /// The module that has `item`'s body: of an interface's function, the one that is bound.
    fn implementation(&self, caller: usize, item: &Item) -> Result<usize, Fault> {
        let source = self.library.source(item.module);
        if !source.is_interface() {
            return Ok(item.module);
        }
        match self.request.bindings.get(&item.module) {
            Some(&bound) => {
                if bound != item.module && self.checked.borrow_mut().insert(item.module) {
                    let (contract, implementation) = (self.unit(item.module)?, self.unit(bound)?);
                    interface::check(
                        self.library,
                        (item.module, contract),
                        (bound, implementation),
                    )?;
                }
                Ok(bound)
            }
            None => {
                let message = format!("nothing is bound to the interface `{}`", source.path);
                Err(Fault::new(Cause::Interface, message)
                    .at(self.library.source(caller).find(&item.name))
                    .note("bind a module that implements it; bind the interface to itself for its null object"))
            }
        }
    }

    fn not_callable(&self, caller: usize, module: usize, item: &Item) -> Fault {
        let path = &self.library.source(module).path;
        let message = format!(
            "`{path}::{}` is an entry point, which nothing may call",
            item.name
        );
        Fault::new(Cause::Type, message)
            .at(self.library.source(caller).find(&item.name))
            .note("move what both need into a function of its own")
    }
}

/// What of a unit has been copied.
#[derive(Default)]
pub(crate) struct Maps {
    pub(crate) types: Vec<Option<Handle<Type>>>,
    pub(crate) constants: FxHashMap<Handle<Constant>, Handle<Constant>>,
    pub(crate) overrides: FxHashMap<Handle<Override>, Handle<Override>>,
    pub(crate) expressions: FxHashMap<Handle<Expression>, Handle<Expression>>,
}

pub(crate) struct Linker<'a> {
    pub(crate) targets: Targets<'a>,
    reach: Reach,
    roots: Roots,
    pub(crate) out: Module,
    pub(crate) maps: FxHashMap<usize, Maps>,
    functions: FxHashMap<FunctionId, Handle<Function>>,
    /// The functions being copied, outermost first, for telling of recursion.
    under_way: Vec<FunctionId>,
    pub(crate) globals: FxHashMap<Item, Handle<GlobalVariable>>,
    pub(crate) constants: FxHashMap<Item, Handle<Constant>>,
    pub(crate) overrides: FxHashMap<Item, Handle<Override>>,
    /// Names that are the root module's alone.
    own_names: FxHashSet<String>,
}

impl Linker<'_> {
    fn link(mut self) -> Result<(Module, Origins), Fault> {
        let root = self.targets.request.root;
        let unit = self.targets.unit(root)?.clone();
        if self.roots == Roots::Declarations {
            self.declarations(root, &unit)?;
        }
        for entry in &unit.module.entry_points {
            self.entry_point(root, &unit, entry)?;
        }
        for (module, maps) in &self.maps {
            let unit = self.targets.unit(*module)?;
            for (kind, handle) in &unit.module.special_types.predeclared_types {
                if let Some(copied) = maps.types.get(handle.index()).copied().flatten() {
                    self.out
                        .special_types
                        .predeclared_types
                        .insert(kind.clone(), copied);
                }
            }
        }
        let functions = places(&self.functions, &self.out.functions);
        let globals = places(&self.globals, &self.out.global_variables);
        let overrides = places(&self.overrides, &self.out.overrides);
        if self.reach.left_out {
            // What stores and calls left behind would be computed for nothing.
            naga::compact::compact(&mut self.out, naga::compact::KeepUnused::No);
        }
        let library = self.targets.library;
        let overrides = owners(overrides, &self.out.overrides);
        overrides::check(library, root, &self.out, &overrides)?;
        let functions = owners(functions, &self.out.functions);
        let owners = owners(globals, &self.out.global_variables);
        let mut names = FxHashMap::default();
        for id in functions.values() {
            let unit = self.targets.unit(id.0)?;
            names.insert(*id, unit.functions[&id.1].name.clone());
        }
        instances::check(&instances::Origins {
            library,
            root,
            module: &self.out,
            functions: &functions,
            names: &names,
            variables: &owners,
            calls: &self.targets.calls()?,
        })?;
        bindings::allocate(library, &mut self.out, &owners)?;
        let taken = self.targets.taken.into_iter().enumerate();
        let filters =
            taken.filter_map(|(module, unit)| Some((module, unit.into_inner()?.filters.clone())));
        let origins = Origins {
            owners,
            functions,
            overrides,
            filters: filters.collect(),
        };
        Ok((self.out, origins))
    }

    fn declarations(&mut self, root: usize, unit: &Arc<Unit>) -> Result<(), Fault> {
        let own_items = unit.constants.values().chain(unit.overrides.values());
        let own_items = own_items.filter(|item| item.module == root);
        self.own_names
            .extend(own_items.map(|item| item.name.clone()));
        self.own_names.extend(unit.own_functions.keys().cloned());
        self.own_names.extend(unit.own_globals.keys().cloned());
        let entries = unit.module.entry_points.iter();
        self.own_names
            .extend(entries.map(|entry| entry.name.clone()));
        let own = |name: &Option<String>| {
            name.as_ref()
                .is_some_and(|name| !name.contains(crate::stubs::JOINT))
        };
        for (handle, ty) in unit.module.types.iter() {
            if matches!(ty.inner, TypeInner::Struct { .. }) && own(&ty.name) {
                self.ty(root, unit, handle)?;
            }
        }
        for (handle, constant) in unit.module.constants.iter() {
            if own(&constant.name) {
                self.constant(root, unit, handle)?;
            }
        }
        for handle in unit
            .overrides
            .keys()
            .copied()
            .collect::<std::collections::BTreeSet<_>>()
        {
            if unit.overrides[&handle].module == root {
                self.override_(root, unit, handle)?;
            }
        }
        let mut globals: Vec<_> = unit.own_globals.values().copied().collect();
        globals.sort();
        for handle in globals {
            self.global(root, unit, handle)?;
        }
        let mut functions: Vec<_> = unit.own_functions.values().copied().collect();
        functions.sort();
        for handle in functions {
            self.function((root, handle))?;
        }
        Ok(())
    }

    fn entry_point(
        &mut self,
        root: usize,
        unit: &Arc<Unit>,
        entry: &EntryPoint,
    ) -> Result<(), Fault> {
        let workgroup_size_overrides = match entry.workgroup_size_overrides {
            Some(sizes) => {
                let mut copied = [None; 3];
                for (copied, size) in copied.iter_mut().zip(sizes) {
                    *copied = match size {
                        Some(size) => Some(self.expression(root, unit, size)?),
                        None => None,
                    };
                }
                Some(copied)
            }
            None => None,
        };
        if entry.mesh_info.is_some() || entry.task_payload.is_some() {
            let message = format!(
                "`{}` is a mesh or task stage, which no target has",
                entry.name
            );
            return Err(Fault::new(Cause::Validation, message).at(self
                .targets
                .library
                .source(root)
                .find(&entry.name)));
        }
        let function = self.body(root, unit, &entry.function)?;
        self.out.entry_points.push(EntryPoint {
            function,
            workgroup_size_overrides,
            ..entry.clone()
        });
        Ok(())
    }

    /// The copy of the function `id`.
    fn function(&mut self, id: FunctionId) -> Result<Handle<Function>, Fault> {
        if let Some(done) = self.functions.get(&id) {
            return Ok(*done);
        }
        if let Some(start) = self.under_way.iter().position(|known| *known == id) {
            return Err(self.recursion(start));
        }
        if self.under_way.len() > DEEPEST_CALLS {
            let message = format!("calls nest more than {DEEPEST_CALLS} deep");
            return Err(Fault::new(Cause::Recursion, message)
                .at(self.targets.library.source(id.0).place(0..0))
                .note("let functions of this module call fewer of each other"));
        }
        self.under_way.push(id);
        let unit = self.targets.unit(id.0)?.clone();
        let original = &unit.module.functions[id.1];
        let mut function = self.body(id.0, &unit, original)?;
        function.name = self.free_name(id.0, &function.name);
        self.under_way.pop();
        let span = self.shifted(id.0, unit.module.functions.get_span(id.1));
        let handle = self.out.functions.append(function, span);
        self.functions.insert(id, handle);
        Ok(handle)
    }

    /// `name`, or another where the root module has it for itself.
    pub(crate) fn free_name(&self, module: usize, name: &Option<String>) -> Option<String> {
        let mut name = name.clone()?;
        let path = &self.targets.library.source(module).path;
        let last = path.rsplit("::").next().unwrap_or("");
        while module != self.targets.request.root && self.own_names.contains(&name) {
            name = format!("{last}_{name}");
        }
        Some(name)
    }

    fn recursion(&self, start: usize) -> Fault {
        let mut fault = Fault::new(Cause::Recursion, "functions call each other in a circle");
        for id in &self.under_way[start..] {
            let Ok(unit) = self.targets.unit(id.0) else {
                continue;
            };
            let name = unit.module.functions[id.1].name.clone().unwrap_or_default();
            let source = self.targets.library.source(id.0);
            let mut place = source.find(&format!("fn {name}"));
            place.label = "calls the next, and the last the first".to_owned();
            fault = fault.at(place);
        }
        fault.note("WGSL has no recursion: let one of them do without the next")
    }

    /// A clone of `original` with its outside handles put right, and without what is dead.
    fn body(
        &mut self,
        module: usize,
        unit: &Arc<Unit>,
        original: &Function,
    ) -> Result<Function, Fault> {
        let mut function = original.clone();
        for argument in &mut function.arguments {
            argument.ty = self.ty(module, unit, argument.ty)?;
        }
        if let Some(result) = &mut function.result {
            result.ty = self.ty(module, unit, result.ty)?;
        }
        for (_, local) in function.local_variables.iter_mut() {
            local.ty = self.ty(module, unit, local.ty)?;
        }
        let roots = private_roots(&unit.module, original);
        let dead: Vec<_> = roots
            .iter()
            .map(|root| {
                root.is_some_and(|global| {
                    let number = unit.globals[&global].number(self.targets.library);
                    !self.reach.reads.contains(&number)
                })
            })
            .collect();
        self.block(module, &dead, &mut function.body)?;
        for (_, expression) in function.expressions.iter_mut() {
            self.outside(module, unit, expression)?;
        }
        Ok(function)
    }

    /// Puts `expression`'s handles that lead outside its function right.
    pub(crate) fn outside(
        &mut self,
        module: usize,
        unit: &Arc<Unit>,
        expression: &mut Expression,
    ) -> Result<(), Fault> {
        match expression {
            Expression::Constant(constant) => *constant = self.constant(module, unit, *constant)?,
            Expression::Override(item) => *item = self.override_(module, unit, *item)?,
            Expression::GlobalVariable(global) => *global = self.global(module, unit, *global)?,
            Expression::ZeroValue(ty)
            | Expression::Compose { ty, .. }
            | Expression::AtomicResult { ty, .. }
            | Expression::WorkGroupUniformLoadResult { ty }
            | Expression::SubgroupOperationResult { ty } => *ty = self.ty(module, unit, *ty)?,
            Expression::CallResult(function) => {
                let target = self.targets.target((module, *function))?;
                *function = self.function(target)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Puts the calls of `block` right, and leaves out what has no effect: `dead` tells the
    /// expressions that lead into variables which nothing reads.
    fn block(&mut self, module: usize, dead: &[bool], block: &mut Block) -> Result<(), Fault> {
        let mut kept = Vec::new();
        for index in 0..block.len() {
            let keep = match &mut block[index] {
                Statement::Store { pointer, .. } => !dead[pointer.index()],
                Statement::Call {
                    function, result, ..
                } => {
                    let target = self.targets.target((module, *function))?;
                    let keep = result.is_some() || !self.reach.idle.contains(&target);
                    if keep {
                        *function = self.function(target)?;
                    }
                    keep
                }
                _ => true,
            };
            kept.push(keep);
        }
        if kept.contains(&false) {
            let whole = std::mem::take(block);
            for ((statement, span), keep) in whole.span_into_iter().zip(kept) {
                if keep {
                    block.push(statement, span);
                }
            }
        }
        for statement in block.iter_mut() {
            let mut result = Ok(());
            crate::unit::for_each_block(statement, &mut |inner| {
                if result.is_ok() {
                    result = self.block(module, dead, inner);
                }
            });
            result?;
        }
        Ok(())
    }
}

/// Place of each item's copy. It still identifies the copy after compaction has renumbered `copies`.
fn places<K: Clone, T>(items: &FxHashMap<K, Handle<T>>, copies: &Arena<T>) -> FxHashMap<Place, K> {
    let items = items.iter();
    items
        .filter_map(|(item, handle)| Some((copies.get_span(*handle).to_range()?, item.clone())))
        .collect()
}

/// The item that each of `copies` came from.
fn owners<K, T>(mut places: FxHashMap<Place, K>, copies: &Arena<T>) -> FxHashMap<Handle<T>, K> {
    let copies = copies
        .iter()
        .map(|(handle, _)| (handle, copies.get_span(handle)));
    copies
        .filter_map(|(handle, span)| Some((handle, places.remove(&span.to_range()?)?)))
        .collect()
}

/// A range in the concatenated texts of the library.
type Place = std::ops::Range<usize>;
