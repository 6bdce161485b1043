//! `enable` and `requires` directives: what a module asks for, and what of that naga is shown.

use std::ops::Range;

use wgsl_parse::lexer::Token;

use crate::source::Source;

/// What naga has without being asked, and refuses to be asked for.
const GIVEN: [&str; 2] = ["subgroups", "unrestricted_pointer_parameters"];

/// What a module asks for.
#[derive(Debug, Default)]
pub(crate) struct Extensions {
    /// The names in its `enable` directives, in their order.
    pub(crate) enabled: Vec<String>,
    /// What naga is not to see.
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
            // Both are keywords, so that nothing else is written so.
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
                    // With the comma after it, or else the one before.
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
