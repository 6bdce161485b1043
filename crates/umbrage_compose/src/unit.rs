//! Units: modules as naga parsed them, each by itself, ready to be copied from.

use std::{collections::BTreeSet, ops::Range, sync::Arc};

use naga::{
    AddressSpace, Block, Expression, Function, GlobalVariable, Handle, Module, Span, Statement,
};
use rustc_hash::FxHashMap;
use umbrage_hints::did_you_mean;

use crate::{
    Cause, Fault, Library,
    diagnostics::Filters,
    names::{Item, ItemNumber},
    prepare::Prepared,
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
    /// What each function is: one of the module's own, or another's.
    pub(crate) functions: FxHashMap<Handle<Function>, Item>,
    /// What each variable is.
    pub(crate) globals: FxHashMap<Handle<GlobalVariable>, Item>,
    /// What each named constant is.
    pub(crate) constants: FxHashMap<Handle<naga::Constant>, Item>,
    /// Item that each named override came from.
    pub(crate) overrides: FxHashMap<Handle<naga::Override>, Item>,
    /// The module's own functions.
    pub(crate) own_functions: FxHashMap<String, Handle<Function>>,
    /// The module's own variables.
    pub(crate) own_globals: FxHashMap<String, Handle<GlobalVariable>>,
    /// The name that each type has where it is declared; the number is the type's index.
    pub(crate) type_names: Vec<Option<String>>,
    /// What each function does, by its index.
    pub(crate) facts: Vec<Facts>,
    /// What each entry point does.
    pub(crate) entry_facts: Vec<Facts>,
    /// The author's part of the text that naga parsed.
    pub(crate) own: Range<usize>,
    /// The module's diagnostic filters.
    pub(crate) filters: Arc<Filters>,
}

/// What a function does, as far as it matters for leaving things out.
#[derive(Debug, Default)]
pub(crate) struct Facts {
    /// The functions that it calls; whether the result is left unused.
    pub(crate) calls: BTreeSet<(Handle<Function>, bool)>,
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
    prepared: &Prepared,
) -> Result<Unit, Refusal> {
    let mut parsed = naga::front::wgsl::parse_str(&prepared.text)
        .map_err(|error| parse_fault(library, module, prepared, &error))?;
    let source = library.source(module);
    let functions = parsed.functions.iter_mut().map(|(_, function)| function);
    let entries = parsed.entry_points.iter_mut();
    for function in functions.chain(entries.map(|entry| &mut entry.function)) {
        if function.result.is_some() {
            drop_added_returns(&mut function.body);
        }
    }
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
    let item = |name: &Option<String>| {
        let name = name.clone().unwrap_or_default();
        prepared
            .stubs
            .items
            .get(&name)
            .cloned()
            .unwrap_or(Item { module, name })
    };
    let functions: FxHashMap<_, _> = parsed
        .functions
        .iter()
        .map(|(handle, f)| (handle, item(&f.name)))
        .collect();
    let globals: FxHashMap<_, _> = parsed
        .global_variables
        .iter()
        .map(|(handle, g)| (handle, item(&g.name)))
        .collect();
    let overrides = parsed
        .overrides
        .iter()
        .filter(|(_, o)| o.name.is_some())
        .map(|(handle, o)| (handle, item(&o.name)))
        .collect();
    let constants = parsed
        .constants
        .iter()
        .filter(|(_, constant)| constant.name.is_some())
        .map(|(handle, constant)| (handle, item(&constant.name)))
        .collect();
    let called: Vec<_> = (parsed.functions.iter())
        .map(|(handle, _)| functions[&handle].number(library))
        .collect();
    let own = |stub: &Option<String>| {
        stub.as_ref()
            .is_some_and(|name| !prepared.stubs.items.contains_key(name))
    };
    let type_names = parsed
        .types
        .iter()
        .map(|(_, ty)| match ty.inner {
            naga::TypeInner::Struct { .. } => ty.name.as_ref().map(|_| item(&ty.name).name),
            // An alias's name tells one `vec3f` from another, which are the same.
            _ => None,
        })
        .collect();
    let mut unit = Unit {
        by_number: (parsed.functions.iter().zip(&called))
            .filter(|((_, f), _)| own(&f.name))
            .map(|((handle, _), called)| (called.1, handle))
            .collect(),
        called,
        own_functions: parsed
            .functions
            .iter()
            .filter(|(_, f)| own(&f.name))
            .filter_map(|(handle, f)| Some((f.name.clone()?, handle)))
            .collect(),
        own_globals: parsed
            .global_variables
            .iter()
            .filter(|(_, g)| own(&g.name))
            .filter_map(|(handle, g)| Some((g.name.clone()?, handle)))
            .collect(),
        facts: Vec::new(),
        entry_facts: Vec::new(),
        own: prepared.own.clone(),
        filters: prepared.filters.clone(),
        module: parsed,
        functions,
        globals,
        constants,
        overrides,
        type_names,
    };
    let number = |global| unit.globals[&global].number(library);
    let functions = unit.module.functions.iter();
    let function_facts = functions.map(|(_, f)| facts(&unit.module, f, &number));
    let entries = unit.module.entry_points.iter();
    let entry_facts = entries.map(|e| facts(&unit.module, &e.function, &number));
    (unit.facts, unit.entry_facts) = (function_facts.collect(), entry_facts.collect());
    for (_, function) in unit.module.functions.iter_mut() {
        shift_function(function, source.base, &prepared.own);
    }
    for entry in &mut unit.module.entry_points {
        shift_function(&mut entry.function, source.base, &prepared.own);
    }
    Ok(unit)
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
