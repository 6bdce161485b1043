//! Lints: what is valid, and yet likely not meant. One a file.
//!
//! An author turns one off where it does not hold by a filter, `@diagnostic(off, umbrage.division_by_w)`, on the function or,
//! as a directive, for the module.

mod division_by_w;
mod too_many_varyings;
mod unreachable_function;
mod unused_binding;

use naga::{Span, diagnostic_filter::Severity};

use crate::{
    Cause, Composer, Fault, Permutation, Target,
    diagnostics::{Filters, Places},
    error::Place,
};

macro_rules! lints {
    ($($(#[$doc:meta])* $lint:ident = $name:literal;)+) => {
        /// A lint, by the name that its findings, filters and arguments have.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Lint {
            $($(#[$doc])* $lint,)+
        }

        impl Lint {
            /// All lints.
            pub const ALL: &[Self] = &[$(Self::$lint),+];

            /// Its name.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$lint => $name,)+
                }
            }

            /// Its name as a diagnostic rule.
            fn rule(self) -> &'static str {
                match self {
                    $(Self::$lint => concat!("umbrage.", $name),)+
                }
            }
        }
    };
}

lints! {
    /// A division by the w of a matrix times a vector, which may be 0, in a function that does not compare it.
    DivisionByW = "division_by_w";
    /// More variables between stages than some target takes.
    TooManyVaryings = "too_many_varyings";
    /// A function of an interface that no permutation calls.
    UnreachableFunction = "unreachable_function";
    /// A binding that no permutation uses, of a module that some have.
    UnusedBinding = "unused_binding";
}

/// A lint, and what it found.
#[derive(Clone, Debug)]
pub struct Linted {
    /// The lint.
    pub lint: Lint,
    /// Its finding.
    pub fault: Fault,
}

/// Findings in a permutation that was composed for `target`.
pub(crate) fn of_permutation(
    permutation: &Permutation,
    places: &Places<'_>,
    (target, root): (&Target, usize),
) -> Vec<Linted> {
    let mut found = Vec::new();
    division_by_w::check(permutation, places, &mut found);
    too_many_varyings::check(permutation, places, (target, root), &mut found);
    found
}

/// Findings in the space that `composer` has checked as a whole.
pub(crate) fn of_space(composer: &Composer) -> Vec<Linted> {
    let mut found = Vec::new();
    unreachable_function::check(composer, &mut found);
    unused_binding::check(composer, &mut found);
    found
}

/// Adds a finding at `span`, where no filter turns it off.
fn add(
    found: &mut Vec<Linted>,
    lint: Lint,
    places: &Places<'_>,
    span: Span,
    (message, advice): (String, &str),
) {
    let Some(place) = places.place(span, String::new()) else {
        return;
    };
    if places.severity_of(lint.rule(), span) != Some(Severity::Off) {
        found.push(linted(lint, place, message, advice));
    }
}

/// Whether a filter turns `lint` off at `offset` of a module's text.
pub(crate) fn is_off(filters: &Filters, lint: Lint, offset: usize) -> bool {
    filters.severity(lint.rule(), offset) == Some(Severity::Off)
}

fn linted(lint: Lint, place: Place<'_>, message: String, advice: &str) -> Linted {
    let fault = Fault::new(Cause::Validation, message).at(place);
    Linted {
        lint,
        fault: fault.note(advice),
    }
}
