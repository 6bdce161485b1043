//! Aliased pointer arguments: where two of them lead to one variable, a function may not write through one and use
//! the other (<https://www.w3.org/TR/WGSL/#alias-analysis>).

use std::collections::BTreeSet;

use naga::{
    AtomicFunction, Block, Expression, Function, GlobalVariable, Handle, LocalVariable, Module,
    Span, Statement,
};

use super::{Problem, functions};

pub(super) fn check(module: &Module) -> Result<(), Problem> {
    let takes_pointer = |function: &Function| {
        let mut arguments = function.arguments.iter();
        arguments.any(|argument| module.types[argument.ty].inner.pointer_space().is_some())
    };
    if !module.functions.iter().any(|(_, f)| takes_pointer(f)) {
        return Ok(());
    }
    // Callees come before their callers.
    let mut known = Vec::new();
    for function in functions(module) {
        let mut walk = Walk {
            module,
            function,
            roots: roots(function),
            known: &known,
            uses: Uses::default(),
        };
        walk.expressions();
        walk.block(&function.body)?;
        known.push(walk.uses);
    }
    Ok(())
}

/// Root of a pointer: the variable or argument that it leads into.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Root {
    Argument(u32),
    Global(Handle<GlobalVariable>),
    Local(Handle<LocalVariable>),
}

/// Reads and writes of a function through pointers, its own and those of the functions that it calls.
#[derive(Default)]
struct Uses {
    reads: BTreeSet<Root>,
    writes: BTreeSet<Root>,
}

impl Uses {
    fn touches(&self, root: &Root) -> bool {
        self.reads.contains(root) || self.writes.contains(root)
    }
}

/// Root of each expression that is a pointer.
fn roots(function: &Function) -> Vec<Option<Root>> {
    let mut roots = Vec::with_capacity(function.expressions.len());
    for (_, expression) in function.expressions.iter() {
        let root = match *expression {
            Expression::FunctionArgument(index) => Some(Root::Argument(index)),
            Expression::GlobalVariable(global) => Some(Root::Global(global)),
            Expression::LocalVariable(local) => Some(Root::Local(local)),
            // An access to a value looks the same as one through a pointer, but values have no root.
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                roots[base.index()]
            }
            _ => None,
        };
        roots.push(root);
    }
    roots
}

struct Walk<'a> {
    module: &'a Module,
    function: &'a Function,
    roots: Vec<Option<Root>>,
    known: &'a [Uses],
    uses: Uses,
}

impl Walk<'_> {
    fn root(&self, pointer: Handle<Expression>) -> Option<Root> {
        self.roots[pointer.index()]
    }

    fn expressions(&mut self) {
        for (_, expression) in self.function.expressions.iter() {
            if let Expression::Load { pointer } = expression {
                self.uses.reads.extend(self.root(*pointer));
            }
        }
    }

    fn block(&mut self, block: &Block) -> Result<(), Problem> {
        for (statement, span) in block.span_iter() {
            match statement {
                Statement::Block(block) => self.block(block)?,
                Statement::If { accept, reject, .. } => {
                    self.block(accept)?;
                    self.block(reject)?;
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        self.block(&case.body)?;
                    }
                }
                Statement::Loop {
                    body, continuing, ..
                } => {
                    self.block(body)?;
                    self.block(continuing)?;
                }
                Statement::Store { pointer, .. } => self.uses.writes.extend(self.root(*pointer)),
                Statement::Atomic { pointer, fun, .. } => {
                    let root = self.root(*pointer);
                    self.uses.writes.extend(root);
                    if !matches!(fun, AtomicFunction::Exchange { compare: None }) {
                        self.uses.reads.extend(root);
                    }
                }
                Statement::WorkGroupUniformLoad { pointer, .. } => {
                    self.uses.reads.extend(self.root(*pointer));
                }
                Statement::Call {
                    function,
                    arguments,
                    ..
                } => self.call(*function, arguments, *span)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn call(
        &mut self,
        callee: Handle<Function>,
        arguments: &[Handle<Expression>],
        span: Span,
    ) -> Result<(), Problem> {
        let Some(uses) = self.known.get(callee.index()) else {
            return Ok(());
        };
        let pointers = arguments
            .iter()
            .zip(0..)
            .filter_map(|(argument, index)| Some((Root::Argument(index), self.root(*argument)?)));
        let pointers: Vec<_> = pointers.collect();
        for (place, (parameter, root)) in pointers.iter().enumerate() {
            let written = uses.writes.contains(parameter);
            if !uses.touches(parameter) {
                continue;
            }
            for (other, other_root) in &pointers[..place] {
                if root == other_root
                    && uses.touches(other)
                    && (written || uses.writes.contains(other))
                {
                    return Err(self.aliased(callee, *root, span, |name, variable| {
                        format!(
                            "two arguments of `{name}` point into `{variable}`, and it writes through one of them"
                        )
                    }));
                }
            }
            let by_name = matches!(root, Root::Global(_))
                && (uses.writes.contains(root) || (written && uses.reads.contains(root)));
            if by_name {
                return Err(self.aliased(callee, *root, span, |name, variable| {
                    format!(
                        "an argument of `{name}` points into `{variable}`, which it uses by name as well, and it writes by one of the two"
                    )
                }));
            }
        }
        for (parameter, root) in pointers {
            self.uses
                .reads
                .extend(uses.reads.contains(&parameter).then_some(root));
            self.uses
                .writes
                .extend(uses.writes.contains(&parameter).then_some(root));
        }
        let global = |root: &&Root| matches!(root, Root::Global(_));
        self.uses.reads.extend(uses.reads.iter().filter(global));
        self.uses.writes.extend(uses.writes.iter().filter(global));
        Ok(())
    }

    fn aliased(
        &self,
        callee: Handle<Function>,
        root: Root,
        span: Span,
        message: impl Fn(&str, &str) -> String,
    ) -> Problem {
        let module = self.module;
        let name = match root {
            Root::Argument(index) => &self.function.arguments[index as usize].name,
            Root::Global(global) => &module.global_variables[global].name,
            Root::Local(local) => &self.function.local_variables[local].name,
        };
        let callee = module.functions[callee].name.as_deref().unwrap_or("");
        Problem {
            span,
            message: message(callee, name.as_deref().unwrap_or("")),
            advice: "pass a copy of it, made by `var`, or let the function take it by one way alone",
        }
    }
}
