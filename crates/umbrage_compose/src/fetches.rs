//! Whether every texture fetch is counted, where an axis's value asks for it.
//!
//! Only the author can put the count where the fetch is, and an author forgets: a count that is too
//! low looks like any other. So the linked module is held to a rule that a glance can check as well: in
//! a run of statements that nothing branches in, each fetch has a call of the counting function
//! before it.

use naga::{Block, Expression, Function, Handle, Module, ShaderStage, Span, Statement};
use rustc_hash::FxHashSet;

use crate::{Cause, Fault, Library, axes::Counting};

/// Checks what the fragment stages of the linked `module` reach; `root` is their module.
pub(crate) fn check(
    library: &Library,
    root: usize,
    counting: &Counting,
    module: &Module,
) -> Result<(), Fault> {
    let home = |function: Handle<Function>| {
        let span = module.functions.get_span(function).to_range()?;
        Some(library.locate(span.start)?.0)
    };
    let counter = module.functions.iter().find(|(handle, function)| {
        home(*handle) == Some(counting.module) && function.name.as_ref() == Some(&counting.function)
    });
    let check = Check {
        library,
        counting,
        counter: counter.map(|(handle, _)| handle),
    };
    let mut seen = FxHashSet::default();
    let mut waiting = Vec::new();
    for entry in &module.entry_points {
        if entry.stage == ShaderStage::Fragment {
            check.function(root, &entry.function)?;
            waiting.extend(callees(&entry.function));
        }
    }
    while let Some(handle) = waiting.pop() {
        let at = home(handle).unwrap_or(root);
        if seen.insert(handle) && !counting.except.contains(&at) {
            let function = &module.functions[handle];
            check.function(at, function)?;
            waiting.extend(callees(function));
        }
    }
    Ok(())
}

struct Check<'a> {
    library: &'a Library,
    counting: &'a Counting,
    /// None where nothing calls it.
    counter: Option<Handle<Function>>,
}

impl Check<'_> {
    fn function(&self, module: usize, function: &Function) -> Result<(), Fault> {
        self.block(module, function, &function.body)
    }

    fn block(&self, module: usize, function: &Function, block: &Block) -> Result<(), Fault> {
        // Places of counts that are still without their fetches.
        let mut counted = Vec::new();
        for (statement, span) in block.span_iter() {
            match statement {
                Statement::Emit(range) => {
                    let fetches = range.clone().filter(|expression| {
                        let expression = &function.expressions[*expression];
                        matches!(
                            expression,
                            Expression::ImageSample { .. } | Expression::ImageLoad { .. }
                        )
                    });
                    for fetch in fetches {
                        if counted.pop().is_none() {
                            let span = function.expressions.get_span(fetch);
                            return Err(self.uncounted(module, span));
                        }
                    }
                }
                Statement::Call {
                    function: callee, ..
                } => {
                    if Some(*callee) == self.counter {
                        counted.push(*span);
                    }
                }
                // Computing, storing or calling between a count and its fetch does not part them.
                Statement::Store { .. }
                | Statement::ImageStore { .. }
                | Statement::Atomic { .. }
                | Statement::ImageAtomic { .. } => {}
                // After anything else, one of the two may come about without the other.
                _ => {
                    self.all_fetched(module, &counted)?;
                    counted.clear();
                }
            }
            for inner in blocks(statement) {
                self.block(module, function, inner)?;
            }
        }
        self.all_fetched(module, &counted)
    }

    fn all_fetched(&self, module: usize, counted: &[Span]) -> Result<(), Fault> {
        let Some(span) = counted.first() else {
            return Ok(());
        };
        let function = &self.counting.function;
        let message = format!(
            "`{}` counts a texture fetch that does not follow",
            self.library.source(module).path
        );
        Err(self.at(module, *span, message).note(format!(
            "write `{function}();` right before its fetch, with no branch between them"
        )))
    }

    fn uncounted(&self, module: usize, span: Span) -> Fault {
        let Counting {
            module: home,
            function,
            features,
            ..
        } = self.counting;
        let message = format!(
            "`{}` fetches from a texture without counting it",
            self.library.source(module).path
        );
        let condition = match features.as_slice() {
            [] => String::new(),
            features => format!("@if({}) ", features.join(" && ")),
        };
        let (home, user) = (self.library.source(*home), self.library.source(module));
        let path = match home.path.split_once("::") {
            Some((_, within)) if home.package == user.package => format!("package::{within}"),
            _ => home.path.clone(),
        };
        self.at(module, span, message)
            .note(format!(
                "write `{condition}{function}();` right before it, with no branch between them"
            ))
            .note(format!(
                "the function comes by `{condition}import {path}::{function};`"
            ))
    }

    fn at(&self, module: usize, span: Span, message: String) -> Fault {
        let fault = Fault::new(Cause::Validation, message);
        let place = span
            .to_range()
            .and_then(|range| Some((self.library.locate(range.start)?, range.len())));
        match place {
            Some(((module, start), length)) => {
                fault.at(self.library.source(module).place(start..start + length))
            }
            None => fault.at(self.library.source(module).place(0..0)),
        }
    }
}

/// The blocks within `statement`.
fn blocks(statement: &Statement) -> Vec<&Block> {
    match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        Statement::Loop {
            body, continuing, ..
        } => vec![body, continuing],
        _ => Vec::new(),
    }
}

/// The functions that `function` calls.
pub(crate) fn callees(function: &Function) -> Vec<Handle<Function>> {
    let mut callees = Vec::new();
    let mut waiting = vec![&function.body];
    while let Some(block) = waiting.pop() {
        for statement in block.iter() {
            if let Statement::Call { function, .. } = statement {
                callees.push(*function);
            }
            waiting.extend(blocks(statement));
        }
    }
    callees
}
