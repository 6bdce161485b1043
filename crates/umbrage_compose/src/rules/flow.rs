//! Loops without an exit, and functions that end without a value: WGSL's analysis of behaviours
//! (<https://www.w3.org/TR/WGSL/#behaviors>).

use std::ops::BitOr;

use naga::{Block, Function, Span, Statement};

use super::Subject;
use crate::Fault;

pub(super) fn check(subject: &Subject<'_>, function: &Function) -> Result<(), Fault> {
    let behavior = of_block(subject, &function.body)?;
    if function.result.is_some() && behavior.next {
        let name = function.name.as_deref().unwrap_or("");
        let last = function.body.span_iter().last();
        let span = last.map_or(Span::UNDEFINED, |(_, span)| *span);
        return Err(subject
            .at(span, format!("`{name}` may end without a value"))
            .note("end it with `return`; after `discard`, too, the rest is run"));
    }
    Ok(())
}

/// What may come after a statement.
#[derive(Clone, Copy, Default)]
struct Behavior {
    /// The next statement.
    next: bool,
    /// What comes after the loop or switch around it.
    breaks: bool,
    /// The next turn of the loop around it.
    continues: bool,
    /// The end of the function.
    returns: bool,
}

const NEXT: Behavior = Behavior {
    next: true,
    breaks: false,
    continues: false,
    returns: false,
};

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
        ..NEXT
    };

    /// Where a `break` within ends it.
    fn after_breaks(self) -> Self {
        Self {
            next: self.next | self.breaks,
            breaks: false,
            ..self
        }
    }
}

fn of_block(subject: &Subject<'_>, block: &Block) -> Result<Behavior, Fault> {
    let mut behavior = NEXT;
    for (statement, span) in block.span_iter() {
        // What cannot be reached must be sound, too.
        let own = of_statement(subject, statement, *span)?;
        if behavior.next {
            behavior = Behavior {
                next: false,
                ..behavior
            } | own;
        }
    }
    Ok(behavior)
}

fn of_statement(
    subject: &Subject<'_>,
    statement: &Statement,
    span: Span,
) -> Result<Behavior, Fault> {
    Ok(match statement {
        Statement::Block(block) => of_block(subject, block)?,
        Statement::If { accept, reject, .. } => {
            of_block(subject, accept)? | of_block(subject, reject)?
        }
        Statement::Switch { cases, .. } => {
            let mut behavior = Behavior::NONE;
            for case in cases {
                // What falls through has the behavior of the next.
                let own = of_block(subject, &case.body)?;
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
            let both = of_block(subject, body)? | of_block(subject, continuing)?;
            let behavior = Behavior {
                breaks: both.breaks | break_if.is_some(),
                next: false,
                continues: false,
                ..both
            }
            .after_breaks();
            if !behavior.next && !behavior.returns {
                return Err(subject.at(span, "the loop has no exit").note(
                    "give it a condition, or a `break` or `return` that can be reached; `discard` ends no loop",
                ));
            }
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
        // Naga ends a function with one, that its author did not write, which gives no value.
        Statement::Return { value: None } if span.to_range().is_none() => NEXT,
        Statement::Return { .. } => Behavior {
            returns: true,
            ..Behavior::NONE
        },
        _ => NEXT,
    })
}
