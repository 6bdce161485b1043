//! Units: modules as naga parsed them, each by itself, ready to be copied from.

use std::{
    collections::BTreeSet,
    ops::Range,
    sync::{Arc, OnceLock, PoisonError, RwLock},
};

use naga::{
    AddressSpace, Block, Expression, Function, GlobalVariable, Handle, Module, Span, Statement,
    TypeInner,
    compact::{KeepUnused, compact},
};
use rustc_hash::FxHashMap;
use umbrage_hints::did_you_mean;

use crate::{
    Cause, Fault, Library,
    diagnostics::Filters,
    interface::{Signature, signature},
    names::{Item, ItemNumber},
    prepare::Prepared,
    reach::LeftOut,
    rules::check_text,
    stubs::JOINT,
    words,
};

/// A module as naga parsed it.
#[derive(Debug)]
pub(crate) struct Unit {
    pub(crate) module: Module,
    /// Each function by its index: its module, this one or another, and the number of its name there.
    pub(crate) called: Vec<ItemNumber>,
    /// The module's own functions, by the numbers of their names.
    pub(crate) by_number: FxHashMap<u32, Handle<Function>>,
    /// Each function's item, by its index: one of the module's own, or another's.
    pub(crate) functions: Vec<Item>,
    /// Each variable's item, by its index.
    pub(crate) globals: Vec<Item>,
    /// Each named constant's item.
    pub(crate) constants: FxHashMap<Handle<naga::Constant>, Item>,
    /// Item that each named override came from.
    pub(crate) overrides: FxHashMap<Handle<naga::Override>, Item>,
    /// The module's own functions.
    pub(crate) own_functions: FxHashMap<String, Handle<Function>>,
    /// The module's own variables.
    pub(crate) own_globals: FxHashMap<String, Handle<GlobalVariable>>,
    /// The name that each type has where it is declared; the number is the type's index.
    pub(crate) type_names: Vec<Option<String>>,
    /// Numbers of the types among the library's, by their indices; none where a type depends on an override.
    pub(crate) type_numbers: Vec<Option<usize>>,
    /// Other modules whose overrides it takes.
    pub(crate) overriding: BTreeSet<usize>,
    /// Types of the parameters and the result of each function in words, by its index.
    signatures: Vec<OnceLock<Signature>>,
    /// Effects of each function, by its index.
    pub(crate) facts: Vec<Facts>,
    /// Effects of each entry point.
    pub(crate) entry_facts: Vec<Facts>,
    /// Numbers of what its own variables are, as far as limits count it, by the numbers of their names.
    kinds: OnceLock<FxHashMap<u32, u32>>,
    /// The text that naga parsed.
    prepared: Arc<Prepared>,
    /// The unit without what has no effect.
    without: RwLock<FxHashMap<LeftOut, Arc<Unit>>>,
}

/// Effects of a function, as far as they matter for leaving things out.
#[derive(Debug, Default)]
pub(crate) struct Facts {
    /// The functions that it calls; whether the result is left unused.
    pub(crate) calls: BTreeSet<(Handle<Function>, bool)>,
    /// Other modules whose variables and overrides it names.
    pub(crate) names: BTreeSet<usize>,
    /// The private variables that it reads.
    pub(crate) reads: BTreeSet<ItemNumber>,
    /// The private variables that it writes.
    pub(crate) writes: BTreeSet<ItemNumber>,
    /// Whether it does anything else that is felt outside.
    pub(crate) acts: bool,
}

/// Why naga refused a module: the fault, and the module whose declaration is to blame, where that is
/// another one.
#[derive(Clone, Debug)]
pub(crate) struct Refusal {
    pub(crate) fault: Fault,
    pub(crate) blamed: Option<usize>,
}

/// Has naga parse `prepared`.
pub(crate) fn parse(
    library: &Library,
    module: usize,
    prepared: &Arc<Prepared>,
) -> Result<Unit, Refusal> {
    let mut parsed = naga::front::wgsl::parse_str(&prepared.text)
        .map_err(|error| parse_fault(library, module, prepared, &error))?;
    let source = library.source(module);
    for_each_function(&mut parsed, |function| {
        if function.result.is_some() {
            drop_added_returns(&mut function.body);
        }
    });
    check_text(&parsed, &prepared.text).map_err(|problem| {
        let span = shifted(problem.span, 0, &prepared.own).to_range();
        let place = source.place(span.unwrap_or(0..0));
        Refusal {
            fault: Fault::new(Cause::Validation, problem.message)
                .at(place)
                .note(problem.advice),
            blamed: None,
        }
    })?;
    for_each_function(&mut parsed, |function| {
        shift_function(function, source.base, &prepared.own);
    });
    Ok(Unit::new(library, module, parsed, prepared.clone()))
}

impl Unit {
    /// The unit of a `module`, parsed from the text `prepared` of the library's module `home`.
    fn new(library: &Library, home: usize, module: Module, prepared: Arc<Prepared>) -> Self {
        let stands_for = &prepared.stubs.items;
        let item = |name: &Option<String>| {
            let name = name.as_deref().unwrap_or("");
            stands_for.get(name).cloned().unwrap_or_else(|| Item {
                module: home,
                name: name.to_owned(),
            })
        };
        let own = |name: &Option<String>| {
            let name = name.as_ref();
            name.is_some_and(|name| !stands_for.contains_key(name))
        };
        let items = |names: &mut dyn Iterator<Item = &Option<String>>| -> Vec<Item> {
            names.map(item).collect()
        };
        let functions = items(&mut module.functions.iter().map(|(_, f)| &f.name));
        let globals = items(&mut module.global_variables.iter().map(|(_, g)| &g.name));
        let called: Vec<_> = functions.iter().map(|item| item.number(library)).collect();
        let own_functions: Vec<_> = (module.functions.iter())
            .filter(|(_, f)| own(&f.name))
            .collect();
        let own_globals = (module.global_variables.iter()).filter(|(_, g)| own(&g.name));
        let overrides = module.overrides.iter().filter(|(_, o)| o.name.is_some());
        let overrides: FxHashMap<_, _> = overrides
            .map(|(handle, o)| (handle, item(&o.name)))
            .collect();
        let constants = module.constants.iter().filter(|(_, c)| c.name.is_some());
        let type_names: Vec<_> = (module.types.iter())
            .map(|(_, ty)| match ty.inner {
                naga::TypeInner::Struct { .. } => ty.name.as_ref().map(|_| item(&ty.name).name),
                // An alias's name tells one `vec3f` from another, which are the same.
                _ => None,
            })
            .collect();
        let numbers: Vec<_> = globals.iter().map(|item| item.number(library)).collect();
        let number = |global: Handle<GlobalVariable>| numbers[global.index()];
        let facts = |function: &Function| {
            let expressions = function.expressions.iter();
            let named = expressions.filter_map(|(_, expression)| match expression {
                Expression::GlobalVariable(variable) => Some(&globals[variable.index()]),
                Expression::Override(item) => overrides.get(item),
                _ => None,
            });
            let others = named.map(|item| item.module).filter(|other| *other != home);
            Facts {
                names: others.collect(),
                ..facts(&module, function, &number)
            }
        };
        Self {
            by_number: (own_functions.iter())
                .map(|(handle, _)| (called[handle.index()].1, *handle))
                .collect(),
            own_functions: (own_functions.into_iter())
                .filter_map(|(handle, f)| Some((f.name.clone()?, handle)))
                .collect(),
            own_globals: own_globals
                .filter_map(|(handle, g)| Some((g.name.clone()?, handle)))
                .collect(),
            overriding: (overrides.values().map(|item| item.module))
                .filter(|other| *other != home)
                .collect(),
            constants: constants
                .map(|(handle, c)| (handle, item(&c.name)))
                .collect(),
            facts: module.functions.iter().map(|(_, f)| facts(f)).collect(),
            entry_facts: (module.entry_points.iter())
                .map(|entry| facts(&entry.function))
                .collect(),
            type_numbers: library.type_numbers(&module.types, &type_names),
            signatures: vec![OnceLock::new(); functions.len()],
            type_names,
            called,
            functions,
            globals,
            overrides,
            kinds: OnceLock::new(),
            without: RwLock::default(),
            module,
            prepared,
        }
    }

    /// A number for what its own variable is whose name has this number, as far as limits count it.
    pub(crate) fn kind(&self, library: &Library, name: u32) -> Option<u32> {
        let kinds = self.kinds.get_or_init(|| {
            let own = self.own_globals.iter();
            let numbered = own.map(|(name, handle)| {
                let variable = &self.module.global_variables[*handle];
                let kind = library.number(&kind(&self.module, variable));
                (library.number(name), kind)
            });
            numbered.collect()
        });
        kinds.get(&name).copied()
    }

    /// The author's part of the text that naga parsed.
    pub(crate) fn own(&self) -> &Range<usize> {
        &self.prepared.own
    }

    /// The module's diagnostic filters.
    pub(crate) fn filters(&self) -> &Arc<Filters> {
        &self.prepared.filters
    }

    /// Types of the function's parameters and result, in words that are the same in every unit.
    pub(crate) fn signature(&self, function: Handle<Function>) -> &Signature {
        let known = &self.signatures[function.index()];
        known.get_or_init(|| signature(self, function))
    }

    /// The unit of the library's module `home` without what has no effect, and without what was computed for that.
    /// Functions and variables keep their handles.
    pub(crate) fn without(&self, library: &Library, home: usize, left_out: &LeftOut) -> Arc<Self> {
        let known = self.without.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(unit) = known.get(left_out) {
            return unit.clone();
        }
        drop(known);
        let mut module = self.module.clone();
        for_each_function(&mut module, |function| {
            let dead: Vec<_> = private_roots(&self.module, function)
                .into_iter()
                .map(|root| {
                    root.is_some_and(|global| {
                        let number = self.globals[global.index()].number(library);
                        left_out.stores.contains(&number)
                    })
                })
                .collect();
            leave_out(&mut function.body, &dead, left_out);
        });
        compact(&mut module, KeepUnused::Yes);
        let mut unit = Self::new(library, home, module, self.prepared.clone());
        // Named things are looked at, and their faults told, whether they have an effect or not.
        let facts = unit.facts.iter_mut().zip(&self.facts);
        let entry_facts = unit.entry_facts.iter_mut().zip(&self.entry_facts);
        for (own, whole) in facts.chain(entry_facts) {
            own.names.clone_from(&whole.names);
        }
        let unit = Arc::new(unit);
        let mut known = self.without.write().unwrap_or_else(PoisonError::into_inner);
        known.entry(left_out.clone()).or_insert(unit).clone()
    }
}

/// The kind of `variable`, as far as limits count it.
fn kind(module: &Module, variable: &GlobalVariable) -> String {
    let inner = &module.types[variable.ty].inner;
    let class = match inner {
        TypeInner::Image { .. } | TypeInner::Sampler { .. } => format!("{inner:?}"),
        _ => inner.size(module.to_ctx()).to_string(),
    };
    let group = variable.binding.map(|binding| binding.group);
    format!("{:?} {class} {group:?}", variable.space)
}

/// Calls `visit` for each function of `module`, entry points last.
fn for_each_function(module: &mut Module, mut visit: impl FnMut(&mut Function)) {
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let entries = module.entry_points.iter_mut();
    functions
        .chain(entries.map(|entry| &mut entry.function))
        .for_each(&mut visit);
}

/// Takes what is `left_out` away: stores into the variables that the `dead` expressions lead to, and calls.
fn leave_out(block: &mut Block, dead: &[bool], left_out: &LeftOut) {
    let is_kept = |statement: &Statement| match statement {
        Statement::Store { pointer, .. } => !dead[pointer.index()],
        Statement::Call {
            function, result, ..
        } => result.is_some() || !left_out.calls.contains(function),
        _ => true,
    };
    if !block.iter().all(is_kept) {
        let whole = std::mem::take(block);
        for (statement, span) in whole.span_into_iter() {
            if is_kept(&statement) {
                block.push(statement, span);
            }
        }
    }
    for statement in block.iter_mut() {
        for_each_block(statement, &mut |inner| leave_out(inner, dead, left_out));
    }
}

/// `span` of a module's text, counted from the start of the library's.
pub(crate) fn shifted(span: Span, base: usize, own: &Range<usize>) -> Span {
    match span.to_range() {
        Some(range) if own.start <= range.start && range.end <= own.end => {
            let shift = |at: usize| (at - own.start + base) as u32;
            Span::new(shift(range.start), shift(range.end))
        }
        _ => Span::UNDEFINED,
    }
}

fn shift_function(function: &mut Function, base: usize, own: &Range<usize>) {
    let mut expressions = naga::Arena::new();
    for (_, expression, span) in function.expressions.drain() {
        expressions.append(expression, shifted(span, base, own));
    }
    function.expressions = expressions;
    let mut locals = naga::Arena::new();
    for (_, local, span) in function.local_variables.drain() {
        locals.append(local, shifted(span, base, own));
    }
    function.local_variables = locals;
    shift_block(&mut function.body, base, own);
}

/// Removes the `return` that naga adds at the end of a function that has none there. It returns no value. Where the
/// end is unreachable none is needed; where it is reachable, `rules::flow` reports the missing value.
fn drop_added_returns(block: &mut Block) {
    let last = block.span_iter().last();
    let added = last.is_some_and(|(statement, span)| {
        matches!(statement, Statement::Return { value: None }) && span.to_range().is_none()
    });
    if added {
        block.cull(block.len() - 1..);
    }
    if let Some(last) = block.last_mut() {
        for_each_block(last, &mut drop_added_returns);
    }
}

fn shift_block(block: &mut Block, base: usize, own: &Range<usize>) {
    for (statement, span) in block.span_iter_mut() {
        if let Some(span) = span {
            *span = shifted(*span, base, own);
        }
        for_each_block(statement, &mut |block| shift_block(block, base, own));
    }
}

/// Calls `visit` for each block within `statement`.
pub(crate) fn for_each_block(statement: &mut Statement, visit: &mut dyn FnMut(&mut Block)) {
    match statement {
        Statement::Block(block) => visit(block),
        Statement::If { accept, reject, .. } => {
            visit(accept);
            visit(reject);
        }
        Statement::Switch { cases, .. } => cases.iter_mut().for_each(|case| visit(&mut case.body)),
        Statement::Loop {
            body, continuing, ..
        } => {
            visit(body);
            visit(continuing);
        }
        _ => {}
    }
}

/// The private variable that `pointer` leads into, for each expression of `function`.
pub(crate) fn private_roots(
    module: &Module,
    function: &Function,
) -> Vec<Option<Handle<GlobalVariable>>> {
    let mut roots: Vec<Option<Handle<GlobalVariable>>> = Vec::new();
    for (_, expression) in function.expressions.iter() {
        let root = match expression {
            Expression::GlobalVariable(global)
                if module.global_variables[*global].space == AddressSpace::Private =>
            {
                Some(*global)
            }
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                roots.get(base.index()).copied().flatten()
            }
            _ => None,
        };
        roots.push(root);
    }
    roots
}

fn facts(
    module: &Module,
    function: &Function,
    number: &dyn Fn(Handle<GlobalVariable>) -> ItemNumber,
) -> Facts {
    let roots = private_roots(module, function).into_iter();
    let roots: Vec<_> = roots.map(|root| root.map(number)).collect();
    let mut facts = Facts::default();
    for (_, expression) in function.expressions.iter() {
        let pointer = match expression {
            Expression::Load { pointer } => Some(pointer),
            Expression::ArrayLength(pointer) => Some(pointer),
            _ => None,
        };
        if let Some(root) = pointer.and_then(|pointer| roots[pointer.index()]) {
            facts.reads.insert(root);
        }
    }
    block_facts(function, &roots, &function.body, &mut facts);
    facts
}

fn block_facts(
    function: &Function,
    roots: &[Option<ItemNumber>],
    block: &Block,
    facts: &mut Facts,
) {
    for statement in block.iter() {
        match statement {
            Statement::Emit(_)
            | Statement::Break
            | Statement::Continue
            | Statement::Return { .. } => {}
            Statement::Block(block) => block_facts(function, roots, block, facts),
            Statement::If { accept, reject, .. } => {
                block_facts(function, roots, accept, facts);
                block_facts(function, roots, reject, facts);
            }
            Statement::Switch { cases, .. } => {
                for case in cases {
                    block_facts(function, roots, &case.body, facts);
                }
            }
            Statement::Loop {
                body, continuing, ..
            } => {
                block_facts(function, roots, body, facts);
                block_facts(function, roots, continuing, facts);
            }
            Statement::Store { pointer, .. } => match roots[pointer.index()] {
                Some(root) => {
                    facts.writes.insert(root);
                }
                None => facts.acts |= !is_local(function, *pointer),
            },
            Statement::Call {
                function: callee,
                arguments,
                result,
            } => {
                facts.calls.insert((*callee, result.is_none()));
                for argument in arguments {
                    if let Some(root) = roots[argument.index()] {
                        facts.reads.insert(root);
                        facts.acts = true;
                    }
                }
            }
            _ => facts.acts = true,
        }
    }
}

/// Whether `pointer` leads into a local variable.
fn is_local(function: &Function, mut pointer: Handle<Expression>) -> bool {
    loop {
        match function.expressions[pointer] {
            Expression::LocalVariable(_) => return true,
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                pointer = base
            }
            _ => return false,
        }
    }
}

fn parse_fault(
    library: &Library,
    module: usize,
    prepared: &Prepared,
    error: &naga::front::wgsl::ParseError,
) -> Refusal {
    let source = library.source(module);
    let plain = |text: &str| words::plain_of_front(text).replace(JOINT, "::");
    let message = plain(error.message());
    let cause = match () {
        () if message.contains("recursive") || message.contains("cyclic") => Cause::Recursion,
        () => Cause::Type,
    };
    let mut fault = Fault::new(cause, message.clone());
    for (span, label) in error.labels() {
        if let Some(range) = span.to_range()
            && prepared.own.contains(&range.start)
        {
            let start = prepared.own.start;
            let range = range.start - start..range.end - start;
            fault = fault.at(source.place_labelled(range, plain(label)));
        }
    }
    // An import that resolves to nothing is reported at the import.
    let place = (error.labels().next()).and_then(|(span, _)| span.to_range());
    let word = place.clone().and_then(|range| prepared.text.get(range));
    if let (Some(unknown), Some(range)) = (word.and_then(|word| prepared.unknown.get(word)), place)
    {
        return Refusal {
            fault: unknown
                .clone()
                .at(source.place_labelled(range, "used here")),
            blamed: None,
        };
    }
    let mut blamed = None;
    if fault.locations.is_empty() {
        // The fault lies in a stand-in: what it stands for is to blame.
        let stub = error.labels().next().and_then(|(span, _)| span.to_range());
        let line = stub.and_then(|range| {
            let text = &prepared.text;
            let start = text[..range.start.min(text.len())]
                .rfind('\n')
                .map_or(0, |at| at + 1);
            text[start..].lines().next()
        });
        fault = fault.at(source.place(0..0));
        if let Some(line) = line.and_then(|line| line.strip_prefix("enable ")) {
            blamed = prepared.lent.get(line.trim_end_matches(';')).copied();
        } else if let Some(line) = line {
            let mut words = line.split(|c: char| c.is_whitespace() || "(:<>={;,".contains(c));
            blamed = words
                .find_map(|word| prepared.stubs.items.get(word))
                .map(|item| item.module);
            fault = fault.note(format!("in what it imports: {}", plain(line)));
        }
    }
    for note in error.notes() {
        fault = fault.note(plain(note));
    }
    let unknown = [
        "Not implemented as constant expression",
        "to a concrete type",
    ];
    if unknown.iter().any(|words| message.contains(words)) {
        fault = fault.note(
            "naga does not evaluate every function of constants: call it within a function, and give an argument a type, as in `1.0f`",
        );
    }
    // Naga names what it does not know; the nearest known name is most of the help.
    if let Some(unknown) = message
        .split('`')
        .nth(1)
        .filter(|_| message.contains("no definition"))
    {
        let known = prepared.known.iter().map(String::as_str);
        if let Some(hint) = did_you_mean(unknown, known) {
            fault = fault.note(hint);
        }
        let elsewhere = library.sources().iter().enumerate().find(|(index, other)| {
            *index != module
                && library.syntax(*index).is_ok_and(|syntax| {
                    let mut declarations = syntax.tree.global_declarations.iter();
                    declarations.any(|d| crate::names::declared(d).as_deref() == Some(unknown))
                        && !other.path.is_empty()
                })
        });
        if let Some((_, other)) = elsewhere {
            fault = fault.note(format!(
                "`{}` declares it: import it from there",
                other.path
            ));
        }
    }
    Refusal { fault, blamed }
}
