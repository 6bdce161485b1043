//! Alignments that authors ask for. A struct takes the largest alignment of its members, `@align` included. Naga
//! loses that where the struct is itself a member of another, and would lay the outer struct out as no other
//! implementation does.

use std::collections::BTreeMap;

use naga::{ArraySize, Module, Span, TypeInner};
use wgsl_parse::lexer::{Lexer, Token};

use super::Problem;

const ADVICE: &str = "write the alignment before this member and the next one, too";

/// Checks that structs and arrays are laid out as their members ask, in the module that naga parsed from `text`.
/// Padding after a last member does not matter, as nothing follows it.
pub(super) fn check(module: &Module, text: &str) -> Result<(), Problem> {
    if !text.contains("align") {
        return Ok(());
    }
    let asked = asked(text);
    // Alignments by the types' indices. A type comes after the types that it is made of.
    let mut alignments: Vec<u32> = Vec::with_capacity(module.types.len());
    for (handle, ty) in module.types.iter() {
        let alignment = match &ty.inner {
            TypeInner::Array { base, stride, .. } => {
                let wanted = alignments[base.index()];
                if wanted > 0 && stride % wanted != 0 {
                    return Err(Problem {
                        span: module.types.get_span(handle),
                        message: format!(
                            "an array's elements are aligned to {wanted} by `@align` within their type, which is lost here"
                        ),
                        advice: "give the last member of the elements' type the `@size` that fills it up",
                    });
                }
                wanted
            }
            TypeInner::Struct { members, .. } => {
                let name = ty.name.as_deref().unwrap_or_default();
                let (own, places) = asked.get(name).cloned().unwrap_or_default();
                let mut largest = own;
                for (index, member) in members.iter().enumerate() {
                    let wanted = alignments[member.ty.index()];
                    largest = largest.max(wanted);
                    if wanted == 0 {
                        continue;
                    }
                    let size = module.types[member.ty].inner.size(module.to_ctx());
                    let end = size.checked_next_multiple_of(wanted);
                    let end = end.and_then(|size| member.offset.checked_add(size));
                    let next = members.get(index + 1);
                    if member.offset % wanted != 0
                        || next.is_some_and(|next| end.is_none_or(|end| next.offset < end))
                    {
                        let name = member.name.as_deref().unwrap_or_default();
                        let place = places.get(name).copied();
                        return Err(Problem {
                            span: place.unwrap_or(Span::UNDEFINED),
                            message: format!(
                                "`{name}` is aligned to {wanted} by `@align` within its type, which is lost here"
                            ),
                            advice: ADVICE,
                        });
                    }
                }
                largest
            }
            _ => 0,
        };
        alignments.push(alignment);
    }
    Ok(())
}

/// For each struct, the largest alignment that a member asks for, and the places of its members' names.
fn asked(text: &str) -> BTreeMap<&str, (u32, BTreeMap<&str, Span>)> {
    let tokens: Vec<_> = Lexer::new(text).flatten().collect();
    let word = |index: usize| {
        let token = tokens.get(index);
        token.map_or("", |(start, _, end)| &text[*start..*end])
    };
    let mut asked: BTreeMap<&str, (u32, BTreeMap<&str, Span>)> = BTreeMap::new();
    let mut current = None;
    for (index, (start, token, end)) in tokens.iter().enumerate() {
        match token {
            Token::KwStruct => current = Some(word(index + 1)),
            Token::SymBraceRight => current = None,
            Token::SymAttr if word(index + 1) == "align" && word(index + 2) == "(" => {
                let mut open = 0;
                let close = (index + 2..tokens.len()).find(|index| {
                    match word(*index) {
                        "(" => open += 1,
                        ")" => open -= 1,
                        _ => {}
                    }
                    open == 0
                });
                let said = close.map(|close| &text[tokens[index + 2].2..tokens[close].0]);
                let said = said.map(|said| said.trim().trim_end_matches(','));
                let number = said.and_then(|said| match said.parse() {
                    Ok(number) => Some(number),
                    Err(_) => evaluated(said, text, &tokens),
                });
                if let Some((name, number)) = current.zip(number) {
                    let largest = &mut asked.entry(name).or_default().0;
                    *largest = number.max(*largest);
                }
            }
            _ if word(index + 1) == ":" => {
                if let Some(name) = current {
                    let span = Span::new(*start as u32, *end as u32);
                    let members = &mut asked.entry(name).or_default().1;
                    members.insert(word(index), span);
                }
            }
            _ => {}
        }
    }
    asked
}

/// Value of the expression `said`, by naga, from the constants that `text` declares at module scope.
fn evaluated(said: &str, text: &str, tokens: &[(usize, Token, usize)]) -> Option<u32> {
    let (mut depth, mut start, mut constants) = (0u32, None, String::new());
    for (from, _, to) in tokens {
        match &text[*from..*to] {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "const" if depth == 0 => start = Some(*from),
            ";" => constants.extend(start.take().map(|start: usize| &text[start..*to])),
            _ => {}
        }
    }
    // An array's length is evaluated, and says so.
    let probe = format!("{constants} var<private> probe: array<u32, {said}>;");
    let module = naga::front::wgsl::parse_str(&probe).ok()?;
    module.types.iter().find_map(|(_, ty)| match ty.inner {
        TypeInner::Array {
            size: ArraySize::Constant(length),
            ..
        } => Some(length.get()),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> Option<String> {
        let module = naga::front::wgsl::parse_str(text).expect("WGSL");
        check(&module, text).err().map(|problem| problem.message)
    }

    #[test]
    fn what_lies_otherwise_than_its_members_ask_is_refused() {
        let inner = "struct I { @align(16) a: f32, b: f32 }";
        for (outer, lost) in [
            ("struct O { @align(16) i: I, @align(16) x: f32 } ", false),
            // After the last member comes only padding.
            ("struct O { i: I, }", false),
            ("struct O { i: array<I, 2>, x: f32 }", false),
            ("struct O { x: f32, i: I }", true),
            ("struct O { x: f32, i: array<I, 2> }", true),
            (
                "struct P { i: I, x: f32 } struct O { p: array<P, 2> }",
                true,
            ),
        ] {
            let text = format!("{inner} {outer} var<private> o: O;");
            assert_eq!(
                refused(&text).is_some(),
                lost,
                "{outer}: {:?}",
                refused(&text)
            );
            // A constant's name in place of the number makes no difference.
            for said in ["PAD", "0x10", "16,", "PAD * 2 / (1 + 1)", "4u << 2"] {
                let text = text.replacen("(16)", &format!("({said})"), 1);
                let text = format!("const PAD = 16; {text}");
                assert_eq!(refused(&text).is_some(), lost, "{said}, {outer}");
            }
        }
    }
}
