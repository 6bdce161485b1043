//! Alignments that authors ask for: a struct is aligned as its members are, `@align` and all. Naga forgets that where
//! the struct is a member of another, and would lay the other out as no other implementation does.

use std::collections::BTreeMap;

use naga::{Module, Span, TypeInner};
use wgsl_parse::lexer::{Lexer, Token};

use super::Problem;

const ADVICE: &str = "write the alignment before this member, too";

/// Checks that structs lie as their members ask, in the module that naga parsed from `text`.
pub(super) fn check(module: &Module, text: &str) -> Result<(), Problem> {
    if !text.contains("align") {
        return Ok(());
    }
    let asked = asked(text);
    // By the types' numbers; what a type is made of comes before it.
    let mut alignments: Vec<u32> = Vec::with_capacity(module.types.len());
    for (_, ty) in module.types.iter() {
        let alignment = match &ty.inner {
            TypeInner::Array { base, .. } => alignments[base.index()],
            TypeInner::Struct { members, span } => {
                let name = ty.name.as_deref().unwrap_or_default();
                let (own, places) = asked.get(name).cloned().unwrap_or_default();
                let mut largest = own;
                for member in members {
                    let wanted = alignments[member.ty.index()];
                    largest = largest.max(wanted);
                    if wanted > 0 && (member.offset % wanted != 0 || span % wanted != 0) {
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

/// For each struct the largest alignment that a member asks for by a number, and where its members' names are.
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
                let number: Option<u32> = word(index + 3).trim_end_matches(['u', 'i']).parse().ok();
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
