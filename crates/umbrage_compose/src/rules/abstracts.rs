//! Integers too large for an `i32`. In WGSL, one declared without a type becomes an `i32`; naga takes the first
//! type that has room for it.

use naga::{Expression, Function, Literal};

use super::Problem;

/// Checks the declarations without a type in `function`; `text` is the text that naga parsed.
pub(super) fn check(function: &Function, text: &str) -> Result<(), Problem> {
    for (handle, expression) in function.expressions.iter() {
        let value: f64 = match *expression {
            Expression::Literal(Literal::U32(value)) if value > i32::MAX as u32 => value.into(),
            Expression::Literal(Literal::F32(value)) if value.abs() > i32::MAX as f32 => {
                value.into()
            }
            _ => continue,
        };
        let span = function.expressions.get_span(handle);
        let Some(written) = span.to_range().and_then(|range| text.get(range)) else {
            continue;
        };
        let before = &text[..span.to_range().map_or(0, |range| range.start)];
        if is_whole(written) && takes_any_type(before) {
            return Err(Problem {
                span,
                message: format!("{value} is no `i32`, which a whole number without a type is"),
                advice: "write `u` behind it for a `u32`, or give what is declared its type",
            });
        }
    }
    Ok(())
}

/// Whether `written` consists only of integers without a type suffix. The right side of a shift is not looked at,
/// as it has a type of its own.
fn is_whole(written: &str) -> bool {
    let shifted = written.split("<<").next().unwrap_or("");
    let words = shifted.split(|c: char| !c.is_alphanumeric() && c != '_' && c != '.');
    let words = words.filter(|word| !word.is_empty());
    // For a call, naga's span covers only the function's name.
    let mut numbers = 0;
    let whole = words.into_iter().all(|word| {
        numbers += 1;
        word.bytes().all(|byte| byte.is_ascii_digit())
    });
    whole && numbers > 0
}

/// Whether `before` ends at the `=` of a declaration without a type.
fn takes_any_type(before: &str) -> bool {
    let before = before.trim_end_matches(|c: char| c.is_whitespace() || c == '(' || c == '-');
    let Some(before) = before.strip_suffix('=') else {
        return false;
    };
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let before = before.trim_end();
    let name = before.trim_end_matches(part);
    let word = name.trim_end();
    // `_ = 1;` declares nothing, but accepts any type as well.
    before.ends_with('_') && !word.ends_with(part)
        || (name.len() < before.len()
            && word.len() < name.len()
            && ["let", "var", "const"]
                .iter()
                .any(|kind| word.ends_with(kind)))
}
