//! Division by the w of a projected place: it is 0 on the plane through the light or the camera, and below 0 behind it,
//! where the place is mirrored. Told where the function compares that w nowhere; a comparison in a caller is not seen.

use naga::{
    BinaryOperator, Expression, Function, Handle, TypeInner,
    valid::{FunctionInfo, ModuleInfo},
};

use super::{Lint, Linted, add};
use crate::{Permutation, diagnostics::Places};

pub(super) fn check(permutation: &Permutation, places: &Places<'_>, found: &mut Vec<Linted>) {
    let Ok(info) = permutation.info() else {
        return;
    };
    for (function, facts) in functions(permutation, info) {
        let is_matrix = |value: Handle<Expression>| {
            let ty = facts[value].ty.inner_with(&permutation.module.types);
            matches!(ty, TypeInner::Matrix { .. })
        };
        for (handle, expression) in function.expressions.iter() {
            let Expression::Binary {
                op: BinaryOperator::Divide,
                right,
                ..
            } = *expression
            else {
                continue;
            };
            let Some(place) = whose_w(function, right) else {
                continue;
            };
            let Expression::Binary {
                op: BinaryOperator::Multiply,
                left: matrix,
                ..
            } = function.expressions[place]
            else {
                continue;
            };
            if is_matrix(matrix) && !is_compared(function, place) {
                let span = function.expressions.get_span(handle);
                let message = "a division by the w of a projected place, which may be 0 or less";
                let advice = "compare the w with 0 first, as in `if !(place.w > 0.0) { return ...; }`; where it is \
                     known to be above 0, say so by `@diagnostic(off, umbrage.division_by_w)` on the function";
                add(
                    found,
                    Lint::DivisionByW,
                    places,
                    span,
                    (message.to_owned(), advice),
                );
            }
        }
    }
}

/// Functions and entry points, with naga's facts about them.
fn functions<'a>(
    permutation: &'a Permutation,
    info: &'a ModuleInfo,
) -> impl Iterator<Item = (&'a Function, &'a FunctionInfo)> {
    let functions = permutation.module.functions.iter();
    let functions = functions.map(|(handle, function)| (function, &info[handle]));
    let entries = permutation.module.entry_points.iter().enumerate();
    let entries = entries.map(|(index, entry)| (&entry.function, info.get_entry_point(index)));
    functions.chain(entries)
}

/// The vector whose w `value` is, alone or in each component.
fn whose_w(function: &Function, value: Handle<Expression>) -> Option<Handle<Expression>> {
    match function.expressions[value] {
        Expression::Splat { value, .. } => whose_w(function, value),
        Expression::AccessIndex { base, index: 3 } => Some(base),
        _ => None,
    }
}

fn is_compared(function: &Function, place: Handle<Expression>) -> bool {
    let mut expressions = function.expressions.iter();
    expressions.any(|(_, expression)| match *expression {
        Expression::Binary {
            op:
                BinaryOperator::Less
                | BinaryOperator::LessEqual
                | BinaryOperator::Greater
                | BinaryOperator::GreaterEqual
                | BinaryOperator::Equal
                | BinaryOperator::NotEqual,
            left,
            right,
        } => [left, right]
            .into_iter()
            .any(|side| whose_w(function, side) == Some(place)),
        _ => false,
    })
}
