//! `enable` and `requires` directives: the extensions that a module asks for, and the directives that naga must not
//! see.

use std::ops::Range;

use wgsl_parse::lexer::Token;

use crate::source::Source;

/// Extensions that naga offers without a directive, and whose directive it refuses.
const GIVEN: [&str; 2] = ["subgroups", "unrestricted_pointer_parameters"];

/// Extensions that a module asks for.
#[derive(Debug, Default)]
pub(crate) struct Extensions {
    /// The names in its `enable` directives, in their order.
    pub(crate) enabled: Vec<String>,
    /// Parts of the text to hide from naga.
    pub(crate) blanks: Vec<Range<usize>>,
}

impl Extensions {
    /// Reads the directives among `tokens`, outside of `blanks`.
    pub(crate) fn read(
        source: &Source,
        tokens: &[(Token, Range<usize>)],
        blanks: &[Range<usize>],
    ) -> Self {
        let word = |index: usize| {
            let range = tokens.get(index).map(|(_, range)| range.clone());
            range.map_or("", |range| &source.text[range])
        };
        let mut out = Self::default();
        for (index, (_, range)) in tokens.iter().enumerate() {
            // Both words are keywords, so they occur nowhere else.
            let enables = word(index) == "enable";
            let before = blanks.partition_point(|blank| blank.start <= range.start);
            let blank = before > 0 && range.start < blanks[before - 1].end;
            if blank || !(enables || word(index) == "requires") {
                continue;
            }
            let mut end = index + 1;
            let mut kept = 0;
            let mut given = Vec::new();
            while end < tokens.len() && word(end) != ";" {
                let name = word(end);
                if GIVEN.contains(&name) {
                    // Take the comma after the name with it, or else the comma before.
                    let next = &tokens[(end + 1).min(tokens.len() - 1)].1;
                    let range = match word(end + 1) {
                        "," => tokens[end].1.start..next.end,
                        _ if kept > 0 => tokens[end - 1].1.start..tokens[end].1.end,
                        _ => tokens[end].1.clone(),
                    };
                    given.push(range);
                } else if name != "," {
                    kept += 1;
                    if enables {
                        out.enabled.push(name.to_owned());
                    }
                }
                end += 1;
            }
            match kept {
                0 => {
                    let last = &tokens[end.min(tokens.len() - 1)].1;
                    out.blanks.push(range.start..last.end);
                }
                _ => out.blanks.extend(given),
            }
        }
        out
    }
}
