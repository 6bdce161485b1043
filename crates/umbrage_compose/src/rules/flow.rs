//! Loops without an exit, functions that end without returning a value, and `continue` that skips a declaration:
//! WGSL's behavior analysis (<https://www.w3.org/TR/WGSL/#behaviors>) and its rule for `continue`.

use std::{collections::BTreeSet, ops::BitOr};

use naga::{Block, Expression, Function, Handle, LocalVariable, Span, Statement};

use super::Problem;
use crate::uniformity::for_each_operand;

pub(super) fn check(function: &Function) -> Result<(), Problem> {
    let flow = Flow { function };
    let behavior = flow.block(&function.body)?;
    if function.result.is_some() && behavior.next {
        let name = function.name.as_deref().unwrap_or("");
        let last = function.body.span_iter().last();
        let span = last.map_or(Span::UNDEFINED, |(_, span)| *span);
        return Err(Problem {
            span,
            message: format!("`{name}` may end without a value"),
            advice: "end it with `return`; after `discard`, too, the rest is run",
        });
    }
    Ok(())
}

/// Places where execution may go on after a statement.
#[derive(Clone, Copy, Default)]
struct Behavior {
    /// The next statement.
    next: bool,
    /// After the innermost loop or switch around it.
    breaks: bool,
    /// The next iteration of the innermost loop around it.
    continues: bool,
    /// The end of the function.
    returns: bool,
}

impl BitOr for Behavior {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self {
            next: self.next | other.next,
            breaks: self.breaks | other.breaks,
            continues: self.continues | other.continues,
            returns: self.returns | other.returns,
        }
    }
}

impl Behavior {
    const NONE: Self = Self {
        next: false,
        breaks: false,
        continues: false,
        returns: false,
    };
    const NEXT: Self = Self {
        next: true,
        ..Self::NONE
    };

    /// Behavior of a statement that a `break` within it ends.
    fn after_breaks(self) -> Self {
        Self {
            next: self.next | self.breaks,
            breaks: false,
            ..self
        }
    }
}

struct Flow<'a> {
    function: &'a Function,
}

impl Flow<'_> {
    fn block(&self, block: &Block) -> Result<Behavior, Problem> {
        let mut behavior = Behavior::NEXT;
        for (statement, span) in block.span_iter() {
            // Unreachable code is checked, too.
            let own = self.statement(statement, *span)?;
            if behavior.next {
                behavior.next = false;
                behavior = behavior | own;
            }
        }
        Ok(behavior)
    }

    fn statement(&self, statement: &Statement, span: Span) -> Result<Behavior, Problem> {
        Ok(match statement {
            Statement::Block(block) => self.block(block)?,
            Statement::If { accept, reject, .. } => self.block(accept)? | self.block(reject)?,
            Statement::Switch { cases, .. } => {
                let mut behavior = Behavior::NONE;
                for case in cases {
                    let own = self.block(&case.body)?;
                    // A case that falls through has the behavior of the next one.
                    if !case.fall_through {
                        behavior = behavior | own;
                    }
                }
                behavior.after_breaks()
            }
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => {
                let turn = self.block(body)?;
                let end = self.block(continuing)?;
                // If no path leads to the end of the loop's body, `break_if` is never evaluated.
                let ends = turn.next || turn.continues;
                let behavior = Behavior {
                    breaks: turn.breaks || (ends && break_if.is_some()),
                    next: false,
                    continues: false,
                    returns: turn.returns || (ends && end.returns),
                }
                .after_breaks();
                if !behavior.next && !behavior.returns {
                    return Err(Problem {
                        span,
                        message: "the loop has no exit".to_owned(),
                        advice: "give it a condition, or a `break` or `return` that can be reached; `discard` ends no loop",
                    });
                }
                self.passes_over_nothing(body, continuing, *break_if)?;
                behavior
            }
            Statement::Break => Behavior {
                breaks: true,
                ..Behavior::NONE
            },
            Statement::Continue => Behavior {
                continues: true,
                ..Behavior::NONE
            },
            Statement::Return { .. } => Behavior {
                returns: true,
                ..Behavior::NONE
            },
            _ => Behavior::NEXT,
        })
    }

    /// Checks that everything used in a loop's `continuing` block was declared on every path to it.
    fn passes_over_nothing(
        &self,
        body: &Block,
        continuing: &Block,
        break_if: Option<Handle<Expression>>,
    ) -> Result<(), Problem> {
        let Some((index, jump)) = body
            .span_iter()
            .enumerate()
            .find_map(|(index, (statement, span))| Some((index, continue_in(statement, *span)?)))
        else {
            return Ok(());
        };
        let declared = self.declared(body.span_iter().skip(index + 1));
        let mut used = break_if
            .into_iter()
            .filter_map(|expression| declared.name(self.function, expression))
            .next();
        self.for_each_use(continuing, &mut |expression| {
            if used.is_none() {
                used = declared.name(self.function, expression);
            }
        });
        match used {
            Some(name) => Err(Problem {
                span: jump,
                message: format!(
                    "a `continue` passes over the declaration of `{name}`, which the `continuing` block uses"
                ),
                advice: "declare it before the first `continue`, or before the loop",
            }),
            None => Ok(()),
        }
    }

    /// Declarations among `statements`.
    fn declared<'a>(
        &self,
        statements: impl Iterator<Item = (&'a Statement, &'a Span)>,
    ) -> Declared {
        let mut declared = Declared::default();
        for (statement, span) in statements {
            match statement {
                Statement::Emit(range) => declared.values.extend(range.clone()),
                Statement::Call {
                    result: Some(result),
                    ..
                } => {
                    declared.values.insert(*result);
                }
                // A variable declared in a loop is initialized by a store at its declaration.
                Statement::Store { pointer, .. } => {
                    if let Expression::LocalVariable(local) = self.function.expressions[*pointer]
                        && self.function.local_variables.get_span(local) == *span
                    {
                        declared.variables.insert(local);
                    }
                }
                _ => {}
            }
        }
        declared
    }

    /// Calls `visit` for each expression that a statement of `block` uses.
    fn for_each_use(&self, block: &Block, visit: &mut dyn FnMut(Handle<Expression>)) {
        for statement in block.iter() {
            match statement {
                Statement::Emit(range) => {
                    for expression in range.clone() {
                        let expression = &self.function.expressions[expression];
                        for_each_operand(expression, &mut |operand| visit(operand));
                    }
                }
                Statement::Store { pointer, value } => {
                    visit(*pointer);
                    visit(*value);
                }
                Statement::Call { arguments, .. } => {
                    arguments.iter().for_each(|argument| visit(*argument));
                }
                Statement::If {
                    condition,
                    accept,
                    reject,
                } => {
                    visit(*condition);
                    self.for_each_use(accept, visit);
                    self.for_each_use(reject, visit);
                }
                Statement::Switch { selector, cases } => {
                    visit(*selector);
                    for case in cases {
                        self.for_each_use(&case.body, visit);
                    }
                }
                Statement::Block(block) => self.for_each_use(block, visit),
                Statement::Loop {
                    body,
                    continuing,
                    break_if,
                } => {
                    self.for_each_use(body, visit);
                    self.for_each_use(continuing, visit);
                    break_if.iter().for_each(|condition| visit(*condition));
                }
                _ => {}
            }
        }
    }
}

/// Declarations: named values, and variables.
#[derive(Default)]
struct Declared {
    values: BTreeSet<Handle<Expression>>,
    variables: BTreeSet<Handle<LocalVariable>>,
}

impl Declared {
    /// Name of the value or variable `expression`, where it is among these.
    fn name(&self, function: &Function, expression: Handle<Expression>) -> Option<String> {
        if let Expression::LocalVariable(local) = function.expressions[expression] {
            let among = self.variables.contains(&local);
            return among.then(|| {
                function.local_variables[local]
                    .name
                    .clone()
                    .unwrap_or_default()
            });
        }
        let name = function.named_expressions.get(&expression);
        self.values
            .contains(&expression)
            .then(|| name.cloned().unwrap_or_default())
    }
}

/// Place of a `continue` in `statement` that continues the loop around `statement`.
fn continue_in(statement: &Statement, span: Span) -> Option<Span> {
    let within = |block: &Block| {
        let mut statements = block.span_iter();
        statements.find_map(|(statement, span)| continue_in(statement, *span))
    };
    match statement {
        Statement::Continue => Some(span),
        Statement::Block(block) => within(block),
        Statement::If { accept, reject, .. } => within(accept).or_else(|| within(reject)),
        Statement::Switch { cases, .. } => cases.iter().find_map(|case| within(&case.body)),
        _ => None,
    }
}
