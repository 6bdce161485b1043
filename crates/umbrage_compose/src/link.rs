//! Linking: what is reachable from a module's roots, copied from the units into one module.
//!
//! Functions keep their expressions' numbers, so copying one is a clone in which only the handles
//! that lead outside are put right.

use std::{
    borrow::Cow,
    cell::{OnceCell, RefCell},
    sync::Arc,
};

use naga::{
    AddressSpace, Block, Constant, EntryPoint, Expression, Function, GlobalVariable, Handle,
    Module, Override, Statement, StorageAccess, Type, TypeInner,
};
use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};

use crate::{
    Cause, Fault, Library, bindings,
    bits::Bits,
    diagnostics::Filters,
    instances::{self, Call},
    interface,
    library::Request,
    names::Item,
    overrides,
    reach::{DEEPEST_CALLS, FunctionId, Program, Reach, Roots},
    reflect::Owner,
    several::Several,
    source::Source,
    unit::{Facts, Unit},
};

/// The declarations that a linked module's parts came from.
#[derive(Debug)]
pub(crate) struct Origins {
    /// By the variables' indices.
    pub(crate) owners: Vec<Item>,
    /// The variables' instances, where a shader is of several keys.
    pub(crate) instances: Vec<usize>,
    /// By the functions' indices.
    pub(crate) functions: Vec<FunctionId>,
    pub(crate) overrides: FxHashMap<Handle<Override>, Item>,
    /// Diagnostic filters of each module that something was copied from.
    pub(crate) filters: FxHashMap<usize, Arc<Filters>>,
}

impl Origins {
    /// Declaration of a variable.
    pub(crate) fn owner(
        &self,
        library: &Library,
        variable: Handle<GlobalVariable>,
    ) -> Option<Owner> {
        let item = self.owners.get(variable.index())?;
        Some(Owner {
            module: library.source(item.module).path.clone(),
            name: item.name.clone(),
            instance: *self.instances.get(variable.index())?,
        })
    }
}

/// The units of the modules in hand.
pub(crate) trait Units {
    fn unit(&self, module: usize) -> Result<Arc<Unit>, Fault>;
}

/// Links what is in `reach` of the root module of `targets`. Of what is known to be valid, it is not checked again
/// whether implementations share state.
pub(crate) fn link(
    targets: &Targets<'_>,
    reach: &Reach,
    roots: Roots,
    is_known: bool,
) -> Result<(Module, Origins), Fault> {
    let mut without = FxHashMap::default();
    for (&module, left_out) in &reach.left_out {
        let unit = targets.unit(module)?;
        let home = targets.module(module);
        without.insert(module, unit.without(targets.library, home, left_out));
    }
    let linker = Linker {
        targets,
        without,
        out: Module::default(),
        origins: Vec::new(),
        owners: Vec::new(),
        functions: with_room(),
        under_way: Vec::new(),
        types: Vec::new(),
        copies: Copies::default(),
        globals: FxHashMap::default(),
        constants: FxHashMap::default(),
        overrides: FxHashMap::default(),
        own_names: FxHashSet::default(),
    };
    linker.link(roots, is_known)
}

/// A map with room for the functions of a large shader: growing it bit by bit takes as long as filling it.
pub(crate) fn with_room<K, V>() -> FxHashMap<K, V> {
    FxHashMap::with_capacity_and_hasher(64, FxBuildHasher)
}

/// Finds what calls lead to, through the interfaces' bindings.
pub(crate) struct Targets<'a> {
    pub(crate) library: &'a Library,
    pub(crate) request: &'a Request,
    pub(crate) units: &'a dyn Units,
    /// The instances of a shader of several keys.
    several: Option<&'a Several>,
    /// The units that were looked at.
    taken: Vec<OnceCell<Arc<Unit>>>,
    /// Those of them that are part of the permutation.
    parts: RefCell<Bits>,
    /// Calls from module to module, and what they lead to.
    pub(crate) known: RefCell<FxHashMap<FunctionId, FunctionId>>,
    checked: RefCell<FxHashSet<usize>>,
}

impl Program for Targets<'_> {
    fn library(&self) -> &Library {
        self.library
    }

    fn unit(&self, module: usize) -> Result<&Arc<Unit>, Fault> {
        let unit = self.look(module)?;
        self.parts.borrow_mut().insert(module);
        Ok(unit)
    }

    fn module(&self, number: usize) -> usize {
        self.several
            .map_or(number, |several| several.module(number))
    }

    fn target(&self, called: FunctionId) -> Result<FunctionId, Fault> {
        let unit = self.unit(called.0)?;
        let home = unit.called[called.1.index()].0 as usize;
        if home == self.module(called.0) {
            return Ok(called);
        }
        if let Some(target) = self.known.borrow().get(&called) {
            return Ok(*target);
        }
        let instance = self.several.map_or(0, |several| several.instance(called.0));
        let target = self.target_in(instance, called)?;
        self.known.borrow_mut().insert(called, target);
        Ok(target)
    }

    fn further(&self, called: FunctionId) -> Result<Vec<FunctionId>, Fault> {
        let Some(several) = self.several.filter(|several| several.calls_each(called.0)) else {
            return Ok(Vec::new());
        };
        let unit = self.unit(called.0)?;
        if unit.called[called.1.index()].0 as usize != several.each {
            return Ok(Vec::new());
        }
        if unit.module.functions[called.1].result.is_some() {
            return Err(self.with_result(called));
        }
        let instances = 1..several.requests.len();
        instances.map(|i| self.target_in(i, called)).collect()
    }
}

impl<'a> Targets<'a> {
    pub(crate) fn new(library: &'a Library, request: &'a Request, units: &'a dyn Units) -> Self {
        Self {
            library,
            request,
            units,
            several: None,
            taken: vec![OnceCell::new(); library.sources().len()],
            parts: RefCell::default(),
            known: RefCell::new(with_room()),
            checked: RefCell::default(),
        }
    }

    /// The same for a shader of several keys, of which `request` is the first's.
    pub(crate) fn of_several(self, several: &'a Several) -> Self {
        let modules = self.taken.len() * several.requests.len();
        Self {
            several: Some(several),
            taken: vec![OnceCell::new(); modules],
            ..self
        }
    }

    /// The number of the library's `module`, as the module numbered `from` sees it.
    pub(crate) fn number(&self, from: usize, module: usize) -> usize {
        let number = |several: &Several| several.number(several.instance(from), module);
        self.several.map_or(module, number)
    }

    /// `item` with its module's number, as the module numbered `from` sees it.
    pub(crate) fn item<'i>(&self, from: usize, item: &'i Item) -> Cow<'i, Item> {
        match self.number(from, item.module) {
            module if module == item.module => Cow::Borrowed(item),
            module => Cow::Owned(Item {
                module,
                name: item.name.clone(),
            }),
        }
    }

    /// The address space of a variable. Blocks of further instances are in storage: of uniform ones, a stage has few, and
    /// Mesa 22 writes beyond its own memory where a branch reads the fourth.
    pub(crate) fn space(&self, number: usize, space: AddressSpace) -> AddressSpace {
        let further = self
            .several
            .is_some_and(|several| several.instance(number) > 0);
        match space {
            AddressSpace::Uniform if further => AddressSpace::Storage {
                access: StorageAccess::LOAD,
            },
            space => space,
        }
    }

    /// The number of a bind group that a module has as `group`.
    pub(crate) fn group(&self, number: usize, group: u32) -> u32 {
        self.library.group(self.module(number), group)
    }

    /// The source of the module with this number.
    pub(crate) fn source(&self, number: usize) -> &'a Source {
        self.library.source(self.module(number))
    }

    /// The function that `called` stands for in an instance.
    fn target_in(&self, instance: usize, called: FunctionId) -> Result<FunctionId, Fault> {
        let unit = self.unit(called.0)?;
        let name = unit.called[called.1.index()].1;
        let item = &unit.functions[called.1.index()];
        let request = match self.several {
            Some(several) => &several.requests[instance],
            None => self.request,
        };
        let module = self.implementation(request, called.0, item)?;
        let number = |several: &Several| several.number(instance, module);
        let number = self.several.map_or(module, number);
        match self.unit(number)?.by_number.get(&name) {
            Some(handle) => Ok((number, *handle)),
            None => Err(self.not_callable(called.0, module, item)),
        }
    }

    /// The unit of `module`, which is no part of the permutation for that alone.
    pub(crate) fn look(&self, module: usize) -> Result<&Arc<Unit>, Fault> {
        match self.taken[module].get() {
            Some(unit) => Ok(unit),
            None => {
                let unit = self.units.unit(module)?;
                Ok(self.taken[module].get_or_init(|| unit))
            }
        }
    }

    /// Calls from module to module that were followed, ordered by the calling module and the names that it calls by.
    fn calls(&self) -> Result<Vec<Call>, Fault> {
        let mut calls = Vec::new();
        for (&(module, called), &target) in self.known.borrow().iter() {
            let unit = self.unit(module)?;
            let item = &unit.functions[called.index()];
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
    fn implementation(
        &self,
        request: &Request,
        caller: usize,
        item: &Item,
    ) -> Result<usize, Fault> {
        if !self.library.is_interface(item.module) {
            return Ok(item.module);
        }
        match request.bindings.get(&item.module) {
            Some(&bound) => {
                // Each key of several makes a permutation by itself, which was checked.
                if bound != item.module
                    && self.several.is_none()
                    && self.checked.borrow_mut().insert(item.module)
                {
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
                let path = &self.library.source(item.module).path;
                let message = format!("nothing is bound to the interface `{path}`");
                Err(Fault::new(Cause::Interface, message)
                    .at(self.source(caller).find(&item.name))
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
            .at(self.source(caller).find(&item.name))
            .note("move what both need into a function of its own")
    }

    /// The fault of a call through the interface that each key has an implementation of, for what it gives back.
    fn with_result(&self, called: FunctionId) -> Fault {
        let name = self.look(called.0).map_or_else(
            |_| String::new(),
            |unit| unit.functions[called.1.index()].name.clone(),
        );
        let message = format!(
            "`{name}` is called once for each key of a shader of several, and gives something back"
        );
        Fault::new(Cause::Interface, message)
            .at(self.source(called.0).find(&name))
            .note("let it add to what a parameter points to: `sum: ptr<function, vec3f>`")
    }
}

/// Copies of what has no name of its own, or another name in each module that it is copied from.
#[derive(Default)]
pub(crate) struct Copies {
    /// Types without a number.
    pub(crate) types: FxHashMap<(usize, Handle<Type>), Handle<Type>>,
    pub(crate) constants: FxHashMap<(usize, Handle<Constant>), Handle<Constant>>,
    pub(crate) overrides: FxHashMap<(usize, Handle<Override>), Handle<Override>>,
    pub(crate) globals: FxHashMap<(usize, Handle<GlobalVariable>), Handle<GlobalVariable>>,
    pub(crate) expressions: FxHashMap<(usize, Handle<Expression>), Handle<Expression>>,
}

pub(crate) struct Linker<'a> {
    pub(crate) targets: &'a Targets<'a>,
    /// Units of which something is left out, as they are then.
    without: FxHashMap<usize, Arc<Unit>>,
    pub(crate) out: Module,
    /// Origins of the copied functions.
    origins: Vec<FunctionId>,
    /// Origins of the copied variables.
    pub(crate) owners: Vec<Item>,
    functions: FxHashMap<FunctionId, Handle<Function>>,
    /// The functions being copied, outermost first, for telling of recursion.
    under_way: Vec<FunctionId>,
    /// Copies of types by their numbers.
    pub(crate) types: Vec<Option<Handle<Type>>>,
    pub(crate) copies: Copies,
    pub(crate) globals: FxHashMap<Item, Handle<GlobalVariable>>,
    pub(crate) constants: FxHashMap<Item, Handle<Constant>>,
    pub(crate) overrides: FxHashMap<Item, Handle<Override>>,
    /// Names that are the root module's alone.
    own_names: FxHashSet<String>,
}

impl Linker<'_> {
    fn link(mut self, roots: Roots, is_known: bool) -> Result<(Module, Origins), Fault> {
        let targets = self.targets;
        let (library, root) = (targets.library, targets.request.root);
        let unit = self.unit(root)?;
        if roots == Roots::Declarations {
            self.declarations(root, &unit)?;
        }
        for (entry, facts) in unit.module.entry_points.iter().zip(&unit.entry_facts) {
            self.entry_point(root, &unit, (entry, facts))?;
        }
        let parts = targets.parts.borrow().clone();
        for module in parts.iter() {
            let unit = self.unit(module)?;
            for (kind, ty) in &unit.module.special_types.predeclared_types {
                let number = unit.type_numbers[ty.index()];
                let copied = number.and_then(|number| self.types.get(number).copied().flatten());
                if let Some(copied) = copied {
                    let predeclared = &mut self.out.special_types.predeclared_types;
                    predeclared.insert(kind.clone(), copied);
                }
            }
        }
        let overrides = self.overrides.into_iter();
        let overrides = overrides.map(|(item, handle)| (handle, item)).collect();
        overrides::check(library, root, &self.out, &overrides)?;
        if !is_known {
            let mut names = Vec::with_capacity(self.origins.len());
            for id in &self.origins {
                names.push(targets.unit(id.0)?.functions[id.1.index()].name.as_str());
            }
            instances::check(&instances::Origins {
                library,
                root,
                module: &self.out,
                functions: &self.origins,
                names: &names,
                variables: &self.owners,
                calls: &targets.calls()?,
            })?;
        }
        let mut filters = FxHashMap::default();
        for module in parts.iter() {
            let own = targets.unit(module)?.filters().clone();
            filters.insert(targets.module(module), own);
        }
        let several = targets.several;
        let instance = |item: &Item| several.map_or(0, |several| several.instance(item.module));
        let instances: Vec<_> = self.owners.iter().map(instance).collect();
        for item in &mut self.owners {
            item.module = targets.module(item.module);
        }
        bindings::allocate(library, &mut self.out, (&self.owners, &instances))?;
        let origins = Origins {
            owners: self.owners,
            instances,
            functions: self.origins,
            overrides,
            filters,
        };
        Ok((self.out, origins))
    }

    /// The unit of `module`, without what is left out of it.
    pub(crate) fn unit(&self, module: usize) -> Result<Arc<Unit>, Fault> {
        match self.without.get(&module) {
            Some(unit) => Ok(unit.clone()),
            None => self.targets.unit(module).cloned(),
        }
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
        (entry, facts): (&EntryPoint, &Facts),
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
        let function = self.body(root, unit, (&entry.function, facts))?;
        self.out.entry_points.push(EntryPoint {
            name: entry.name.clone(),
            stage: entry.stage,
            early_depth_test: entry.early_depth_test,
            workgroup_size: entry.workgroup_size,
            workgroup_size_overrides,
            function,
            mesh_info: None,
            task_payload: None,
            incoming_ray_payload: entry.incoming_ray_payload,
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
                .at(self.targets.source(id.0).place(0..0))
                .note("let functions of this module call fewer of each other"));
        }
        self.under_way.push(id);
        let unit = self.unit(id.0)?;
        let original = (&unit.module.functions[id.1], &unit.facts[id.1.index()]);
        let mut function = self.body(id.0, &unit, original)?;
        self.rename(id.0, &mut function.name);
        self.under_way.pop();
        let span = self.shifted(id.0, &unit, unit.module.functions.get_span(id.1));
        let handle = self.out.functions.append(function, span);
        self.functions.insert(id, handle);
        self.origins.push(id);
        Ok(handle)
    }

    /// Gives another name where the root module has `name` for itself.
    pub(crate) fn rename(&self, module: usize, name: &mut Option<String>) {
        let Some(name) = name
            .as_mut()
            .filter(|_| module != self.targets.request.root)
        else {
            return;
        };
        while self.own_names.contains(name) {
            let path = &self.targets.source(module).path;
            let last = path.rsplit("::").next().unwrap_or("");
            *name = format!("{last}_{name}");
        }
    }

    fn recursion(&self, start: usize) -> Fault {
        let mut fault = Fault::new(Cause::Recursion, "functions call each other in a circle");
        for id in &self.under_way[start..] {
            let Ok(unit) = self.targets.unit(id.0) else {
                continue;
            };
            let name = unit.module.functions[id.1].name.clone().unwrap_or_default();
            let source = self.targets.source(id.0);
            let mut place = source.find(&format!("fn {name}"));
            place.label = "calls the next, and the last the first".to_owned();
            fault = fault.at(place);
        }
        fault.note("WGSL has no recursion: let one of them do without the next")
    }

    /// A clone of `original` with its outside handles put right.
    fn body(
        &mut self,
        module: usize,
        unit: &Arc<Unit>,
        (original, facts): (&Function, &Facts),
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
        self.block(module, &mut function.body)?;
        for other in &facts.names {
            self.targets.unit(self.targets.number(module, *other))?;
        }
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

    /// Puts the calls of `block` right: its own, and then those of the blocks within it.
    fn block(&mut self, module: usize, block: &mut Block) -> Result<(), Fault> {
        let mut further = Vec::new();
        for (place, statement) in block.iter_mut().enumerate() {
            if let Statement::Call { function, .. } = statement {
                let called = (module, *function);
                *function = self.function(self.targets.target(called)?)?;
                for target in self.targets.further(called)? {
                    further.push((place, self.function(target)?));
                }
            }
        }
        // Each key's in turn, after the first one's.
        for (place, target) in further.into_iter().rev() {
            let (mut call, span) = match block.span_iter().nth(place) {
                Some((call, span)) => (call.clone(), *span),
                None => continue,
            };
            if let Statement::Call { function, .. } = &mut call {
                *function = target;
            }
            let mut next = Block::new();
            next.push(call, span);
            block.splice(place + 1..place + 1, next);
        }
        for statement in block.iter_mut() {
            let mut result = Ok(());
            crate::unit::for_each_block(statement, &mut |inner| {
                if result.is_ok() {
                    result = self.block(module, inner);
                }
            });
            result?;
        }
        Ok(())
    }
}
