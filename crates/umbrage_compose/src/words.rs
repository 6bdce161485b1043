//! Translation of naga's errors into WGSL's words: naga's own types, flags and numbers mean nothing to an author.

use std::error::Error;

use naga::{
    Handle, Module, Type, TypeInner,
    common::{DiagnosticDebug, wgsl::TryToWgsl as _},
    valid::{
        CallError, ComposeError, ConstExpressionError, EntryPointError, ExpressionError,
        FunctionError, GlobalVariableError, LocalVariableError, TypeError, ValidationError,
        VaryingError,
    },
};

/// Message of the innermost cause of `error`, and the declarations that it lies in, innermost first.
pub(crate) fn said(error: &ValidationError, module: &Module) -> (String, Vec<String>) {
    let mut contexts = Vec::new();
    let mut last: &(dyn Error + 'static) = error;
    while let Some(source) = last.source() {
        contexts.extend(context(last));
        last = source;
    }
    contexts.reverse();
    let message = own_words(last, module).unwrap_or_else(|| plain(&last.to_string()));
    (message, contexts)
}

/// Declaration that `error` lies in, where `error` says no more than that.
fn context(error: &(dyn Error + 'static)) -> Option<String> {
    let named =
        |what: &str, name: &str| (!name.is_empty()).then(|| format!("in the {what} `{name}`"));
    match error.downcast_ref::<ValidationError>() {
        Some(ValidationError::EntryPoint { name, .. }) => named("entry point", name),
        Some(ValidationError::Function { name, .. }) => named("function", name),
        Some(ValidationError::GlobalVariable { name, .. }) => named("variable", name),
        Some(ValidationError::Constant { name, .. }) => named("constant", name),
        Some(ValidationError::Override { name, .. }) => named("override", name),
        Some(ValidationError::Type { name, .. }) => named("type", name),
        Some(_) => None,
        None => match error.downcast_ref::<EntryPointError>() {
            Some(EntryPointError::Argument(index, _)) => {
                Some(format!("in parameter {}", index + 1))
            }
            Some(_) => None,
            None => {
                let text = error.to_string();
                // An error that names a thing only by its number tells the author nothing.
                (without_handles(&text) == text).then(|| plain(&text))
            }
        },
    }
}

/// Message of our own for errors that naga words badly, or whose types it does not name.
fn own_words(error: &(dyn Error + 'static), module: &Module) -> Option<String> {
    // Some errors only pass on another error.
    match error.downcast_ref::<EntryPointError>() {
        Some(EntryPointError::Result(inner)) => return own_words(inner, module),
        Some(EntryPointError::Function(inner)) => return own_words(inner, module),
        _ => {}
    }
    if let Some(ConstExpressionError::Compose(inner)) = error.downcast_ref() {
        return compose_words(inner, module);
    }
    let ty = |handle: &Handle<Type>| type_name(*handle, module);
    let inner = |inner: &TypeInner| format!("{:?}", DiagnosticDebug((inner, &module.types)));
    if let Some(error) = error.downcast_ref::<ExpressionError>() {
        return Some(match error {
            ExpressionError::InvalidBinaryOperandTypes {
                op,
                lhs_type,
                rhs_type,
                ..
            } => format!(
                "`{}` cannot work with `{}` and `{}`",
                naga::back::binary_operation_str(*op),
                inner(lhs_type),
                inner(rhs_type)
            ),
            ExpressionError::SelectValuesTypeMismatch { accept, reject } => format!(
                "`select` must choose between two values of one type, not `{}` and `{}`",
                inner(reject),
                inner(accept)
            ),
            ExpressionError::SelectConditionNotABool { actual } => format!(
                "the condition of `select` must be of `bool`, or of a vector of them, not `{}`",
                inner(actual)
            ),
            ExpressionError::ShiftAmountTooLarge { lhs_type, .. } => {
                format!(
                    "`{}` is shifted by as many bits as it has, or more",
                    inner(lhs_type)
                )
            }
            ExpressionError::IndexOutOfBounds(_, index) => {
                format!("index {index} is out of bounds")
            }
            ExpressionError::InvalidZeroValue(handle) => {
                format!("`{}` cannot be constructed", ty(handle))
            }
            ExpressionError::InvalidArgumentType(function, index, _) => format!(
                "argument {} of `{}` is of a type that it does not take",
                index + 1,
                function.to_wgsl_for_diagnostics()
            ),
            ExpressionError::WrongArgumentCount(function) => {
                format!(
                    "`{}` takes another number of arguments",
                    function.to_wgsl_for_diagnostics()
                )
            }
            ExpressionError::InvalidCastArgument => {
                "a value of this type cannot be converted to that type".to_owned()
            }
            ExpressionError::ExpectedImageType(_) => "a texture is expected here".to_owned(),
            ExpressionError::ExpectedSamplerType(_) => "a sampler is expected here".to_owned(),
            ExpressionError::ComparisonSamplingMismatch { sampler, .. } => match sampler {
                true => {
                    "a comparison sampler goes with depth textures and `textureSampleCompare` alone"
                }
                false => "`textureSampleCompare` takes a depth texture and a comparison sampler",
            }
            .to_owned(),
            ExpressionError::InvalidImageCoordinateType(..) => {
                "the coordinate does not fit the texture's dimension".to_owned()
            }
            ExpressionError::InvalidWorkGroupUniformLoadResultType(handle) => format!(
                "`workgroupUniformLoad` cannot give a `{}`: it is not constructible",
                ty(handle)
            ),
            ExpressionError::Compose(error) => return compose_words(error, module),
            _ => return None,
        });
    }
    if let Some(error) = error.downcast_ref::<ComposeError>() {
        return compose_words(error, module);
    }
    if let Some(error) = error.downcast_ref::<FunctionError>() {
        return Some(match error {
            FunctionError::InvalidReturnType { expected_ty, .. } => match expected_ty {
                Some(handle) => format!("the function must return a `{}`", ty(handle)),
                None => "the function returns nothing, so no value may be given".to_owned(),
            },
            FunctionError::InvalidStoreTypes { .. } => {
                "the value is of another type than what it is assigned to".to_owned()
            }
            FunctionError::InvalidStorePointer(_) => "this cannot be assigned to".to_owned(),
            FunctionError::InvalidStoreValue {
                actual_ty,
                expected_ty,
                ..
            } => format!(
                "the texture holds `{}`, and a `{}` is stored",
                inner(expected_ty),
                inner(actual_ty)
            ),
            FunctionError::InvalidStoreTexture { actual_ty, .. } => {
                format!(
                    "a storage texture is expected, not a `{}`",
                    inner(actual_ty)
                )
            }
            FunctionError::NonUniformControlFlow(..) => {
                "this must be called in uniform control flow".to_owned()
            }
            FunctionError::InvalidArgumentPointerSpace { name, space, .. } => format!(
                "the parameter `{name}` is a pointer into the address space `{}`, which a function cannot take",
                naga::common::wgsl::address_space_str(*space)
                    .0
                    .unwrap_or("handle")
            ),
            _ => return None,
        });
    }
    if let Some(error) = error.downcast_ref::<CallError>() {
        return match error {
            CallError::ArgumentType {
                index, required, ..
            } => Some(format!(
                "argument {} must be a `{}`",
                index + 1,
                ty(required)
            )),
            _ => None,
        };
    }
    if let Some(error) = error.downcast_ref::<LocalVariableError>() {
        return match error {
            LocalVariableError::InvalidType(handle) => Some(format!(
                "a `{}` cannot be kept in a local variable",
                ty(handle)
            )),
            _ => None,
        };
    }
    if let Some(error) = error.downcast_ref::<VaryingError>() {
        return Some(match error {
            VaryingError::InvalidType(handle) => {
                format!("a `{}` cannot go in or out of a stage here", ty(handle))
            }
            VaryingError::NotIOShareableType(handle) => format!(
                "a `{}` cannot go in or out of a stage: numbers and vectors of them alone can",
                ty(handle)
            ),
            VaryingError::InvalidBuiltInType(builtin, found) => format!(
                "`@builtin({})` cannot be of the type `{}`",
                builtin.to_wgsl_for_diagnostics(),
                inner(found)
            ),
            VaryingError::InvalidBuiltInStage(builtin) => format!(
                "`@builtin({})` is not to be had in this stage, or not in this direction",
                builtin.to_wgsl_for_diagnostics()
            ),
            VaryingError::DuplicateBuiltIn(builtin) => {
                format!(
                    "`@builtin({})` stands twice",
                    builtin.to_wgsl_for_diagnostics()
                )
            }
            VaryingError::MemberMissingBinding(_) => {
                "a member of the struct has neither `@location` nor `@builtin`".to_owned()
            }
            VaryingError::BlendSrcOutputTypeMismatch {
                blend_src_0_type,
                blend_src_1_type,
            } => format!(
                "both `@blend_src` must be of one type, not `{}` and `{}`",
                ty(blend_src_0_type),
                ty(blend_src_1_type)
            ),
            _ => return None,
        });
    }
    if let Some(error) = error.downcast_ref::<GlobalVariableError>() {
        return match error {
            GlobalVariableError::InvalidBindingArray(handle) => {
                Some(format!("no `binding_array` holds `{}`", ty(handle)))
            }
            _ => None,
        };
    }
    if let Some(error) = error.downcast_ref::<TypeError>() {
        return Some(match error {
            TypeError::InvalidAtomicWidth(kind, width) => {
                let scalar = naga::Scalar {
                    kind: *kind,
                    width: *width,
                };
                format!("there is no `atomic<{}>`", scalar.to_wgsl_for_diagnostics())
            }
            TypeError::InvalidData(handle) => format!("a `{}` is no data", ty(handle)),
            TypeError::InvalidArrayBaseType(handle) => format!("no array holds `{}`", ty(handle)),
            TypeError::InvalidPointerBase(handle) => {
                format!("no pointer leads to a `{}`", ty(handle))
            }
            TypeError::InvalidDynamicArray(name, _) => format!(
                "the member `{name}` has no fixed size; only the last of a storage buffer may have none"
            ),
            TypeError::InvalidArraySize(_) => "an array's size must be above 0".to_owned(),
            _ => return None,
        });
    }
    None
}

fn compose_words(error: &ComposeError, module: &Module) -> Option<String> {
    Some(match error {
        ComposeError::Type(handle) => {
            format!("a `{}` cannot be constructed", type_name(*handle, module))
        }
        ComposeError::ComponentCount { given, expected } => {
            format!("{expected} components are expected, and {given} are given")
        }
        ComposeError::ComponentType { index } => {
            format!("component {} is of another type than expected", index + 1)
        }
    })
}

fn type_name(handle: Handle<Type>, module: &Module) -> String {
    format!("{:?}", DiagnosticDebug((handle, &module.types)))
}

/// Naga's words without the names of its own types and without its numbers.
pub(crate) fn plain(text: &str) -> String {
    let text = without_handles(text).replace(" Some()", "");
    // `Type flags TypeFlags(A | B) do not meet the required TypeFlags(A | C)`: the type lacks C.
    if let Some((found, required)) = text.split_once(" do not meet the required TypeFlags(") {
        let found: Vec<_> = found.split(['(', ')', '|', ' ']).collect();
        let required = required.trim_end_matches(')').split(" | ");
        let lacking: Vec<_> = (required.filter(|flag| !found.contains(flag)))
            .map(|flag| match flag {
                "DATA" => "data",
                "SIZED" => "of a fixed size",
                "COPY" => "copied by value",
                "IO_SHAREABLE" => "what goes in or out of a stage",
                "HOST_SHAREABLE" => "what a host can share, as numbers are and `bool` is not",
                "ARGUMENT" => "passed to functions",
                "CONSTRUCTIBLE" => "constructible",
                "CREATION_RESOLVED" => "of a size that is known when the pipeline is made",
                _ => "of the right kind",
            })
            .collect();
        return format!(
            "the type will not do here: it is not {}",
            lacking.join(", ")
        );
    }
    lowered(&text)
}

/// A message of naga's front end, which quotes the text, without the names of naga's types and without its numbers.
pub(crate) fn plain_of_front(text: &str) -> String {
    // "Cannot cast scalar components of expression `[3] Literal(F32(1.0))` to type `u32`": the place already shows
    // the expression.
    if let Some((_, to)) = text.split_once("` to type `")
        && text.starts_with("Cannot cast")
    {
        return format!("this cannot be converted to `{to}");
    }
    // Naga's label of a place of which the message says all.
    if text == "see msg" {
        return String::new();
    }
    lowered(&without_handles(&unwrapped(text)))
}

/// `text` without the type name around a value, as in `AbstractInt(300)`.
fn unwrapped(text: &str) -> String {
    let unwrap = || {
        let (before, quoted) = text.split_once("`Abstract")?;
        let (_, rest) = quoted.split_once('(')?;
        let (value, after) = rest.split_once(")`")?;
        Some(format!("{before}`{value}`{after}"))
    };
    unwrap().unwrap_or_else(|| text.to_owned())
}

/// `text` without handles such as `[3]`, naga's numbers for things, which mean nothing to an author, and with
/// members and arguments counted from 1, where naga counts from 0.
fn without_handles(text: &str) -> String {
    let mut out = String::new();
    for (index, part) in text.split('`').enumerate() {
        if index > 0 {
            out.push('`');
        }
        // Quoted parts are the author's own words.
        match index % 2 {
            0 => without_handles_in(part, &mut out),
            _ => out.push_str(part),
        }
    }
    out
}

fn without_handles_in(mut rest: &str, out: &mut String) {
    while let Some(start) = rest.find('[') {
        let Some(length) = rest[start..].find(']') else {
            break;
        };
        let before = &rest[..start];
        let number = rest[start + 1..start + length].parse::<u64>();
        match number {
            Ok(number) if before.ends_with(|c: char| c.is_alphanumeric()) => {
                out.push_str(&format!("{before} {}", number.saturating_add(1)));
            }
            Ok(_) => {
                out.push_str(before.trim_end());
                // A preposition needs a noun after it.
                let preposition = ["of", "from", "to", "in", "with", "like", "for", "as"];
                if (preposition.iter()).any(|word| out.ends_with(&format!(" {word}"))) {
                    out.push_str(" this");
                }
            }
            Err(_) => out.push_str(&rest[..=start + length]),
        }
        rest = &rest[start + length + 1..];
    }
    out.push_str(rest);
}

/// `text` with a lower-case beginning, and with naga's enumerations as WGSL would write them. Outside of quotes, a
/// capitalised word belongs to an enumeration, and so does the bracketed part after it.
fn lowered(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(next) = rest.chars().next() {
        let quote_ends = match next {
            '`' | '"' => rest[1..].find(next),
            '\'' if out.is_empty() || out.ends_with(' ') => rest[1..].find('\''),
            _ => None,
        };
        if let Some(length) = quote_ends {
            out.push_str(&rest[..length + 2]);
            rest = &rest[length + 2..];
            continue;
        }
        let length = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'))
            .unwrap_or(rest.len());
        let word = &rest[..length];
        if length == 0 {
            out.push(next);
            rest = &rest[next.len_utf8()..];
        } else if next.is_uppercase() && !is_abbreviation(word) && !out.ends_with(". ") {
            rest = &rest[length..];
            let (word, within) = enumerated(word, &mut rest);
            out.push_str(&within.unwrap_or(word));
        } else {
            out.push_str(word);
            rest = &rest[length..];
        }
    }
    out
}

/// WGSL's form of an enumeration's word, and its arguments in words; removes these arguments from `rest`.
fn enumerated(word: &str, rest: &mut &str) -> (String, Option<String>) {
    let simple = word.rsplit("::").next().unwrap_or(word);
    let name = snake(simple);
    if let Some(fields) = (rest.strip_prefix(" { ")).and_then(|fields| fields.split_once(" }")) {
        *rest = fields.1;
        return (name, None);
    }
    if let Some(length) = (rest.strip_prefix('(')).and_then(|_| closing(rest)) {
        let within = &rest[1..length];
        *rest = &rest[length + 1..];
        let words: Vec<_> = within.split(" | ").map(|word| snake(word.trim())).collect();
        let words: Vec<_> = words.into_iter().filter(|word| !word.is_empty()).collect();
        return (name, (!words.is_empty()).then(|| words.join(", ")));
    }
    (name, None)
}

/// Index of the bracket that closes the one at the start of `text`.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0usize;
    for (at, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' if depth == 1 => return Some(at),
            ')' => depth -= 1,
            _ => {}
        }
    }
    None
}

/// `word` in snake case: `work_group` for `WorkGroup`; a flag in capitals, such as `HOST_SHAREABLE`, in lower case.
fn snake(word: &str) -> String {
    let mut out = String::new();
    let mut last_is_lower = false;
    for c in word.chars() {
        if c.is_uppercase() && last_is_lower {
            out.push('_');
        }
        last_is_lower = c.is_lowercase() || c.is_ascii_digit();
        out.extend(c.to_lowercase());
    }
    out
}

/// Whether `word` is an abbreviation: `ID`, `NaN`, `RHS`.
fn is_abbreviation(word: &str) -> bool {
    word.len() < 4 && word.chars().filter(|c| c.is_uppercase()).count() > 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn naga_s_own_forms_are_told_plainly() {
        for (said, told) in [
            ("Float literal is NaN", "float literal is NaN"),
            (
                "Loading of [12] can't be done",
                "loading of this can't be done",
            ),
            (
                "Structure member[0] at 4 overlaps",
                "structure member 1 at 4 overlaps",
            ),
            ("Field 'Some' can't be sized", "field 'Some' can't be sized"),
            (
                "Type isn't compatible with address space Storage { access: StorageAccess(LOAD | STORE) }",
                "type isn't compatible with address space storage",
            ),
            (
                "Global variable [2] is used incorrectly as GlobalUse(READ | WRITE)",
                "global variable is used incorrectly as read, write",
            ),
            (
                "The attribute \"blend_src\" is not valid for stage Vertex",
                "the attribute \"blend_src\" is not valid for stage vertex",
            ),
            (
                "Operator Exchange { compare: Some([3]) } is not",
                "operator exchange is not",
            ),
            ("address space WorkGroup", "address space work_group"),
            (
                "The `return` expression Some([3]) does not match",
                "the `return` expression does not match",
            ),
        ] {
            assert_eq!(plain(said), told);
        }
    }
}
