//! Naga's text, split into marks, words and the rest.

use std::collections::HashMap;

use super::marks::{Length, Marked, Scope};

/// The text of a marked module.
pub(super) struct Text<'a> {
    pub(super) lines: Vec<Line<'a>>,
    /// Pieces of each teller's expression, by the teller's mark.
    pub(super) told: HashMap<usize, Vec<Piece<'a>>>,
}

pub(super) struct Line<'a> {
    pub(super) raw: &'a str,
    pub(super) pieces: Vec<Piece<'a>>,
    /// Mark of the function that the line belongs to (as header or body).
    pub(super) function: Option<usize>,
    pub(super) in_struct: bool,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Piece<'a> {
    Mark(usize),
    /// A number that stands for an array's length.
    Length(Length),
    /// One of WGSL's own words, which keeps its meaning only where nothing else has the same name.
    Word(&'a str),
    /// Anything else: spaces, operators, numbers, and words whose meaning no declaration can change.
    Other(&'a str),
}

impl Line<'_> {
    /// First mark of the line; in a declaration, the mark of the thing declared.
    pub(super) fn subject(&self) -> Option<usize> {
        self.pieces.iter().find_map(|piece| match piece {
            Piece::Mark(mark) => Some(*mark),
            _ => None,
        })
    }
}

impl<'a> Text<'a> {
    /// Splits `written`. A name that naga made up within a function (`_e12`) gets a mark, too.
    pub(super) fn read(written: &'a str, marked: &mut Marked) -> Self {
        let mut text = Self {
            lines: Vec::new(),
            told: HashMap::new(),
        };
        let mut reader = Reader {
            marked,
            function: None,
            made: HashMap::new(),
        };
        let mut in_struct = false;
        // A teller is left out, and the empty line after it as well.
        let mut left_out = false;
        for raw in written.lines() {
            if let Some(rest) = raw.strip_prefix("fn ") {
                let name = rest.split('(').next().unwrap_or("");
                reader.function = Marked::number(name);
                reader.made.clear();
            }
            in_struct |= raw.starts_with("struct ");
            let teller = reader
                .function
                .filter(|mark| reader.marked.is_teller(*mark));
            if let Some(teller) = teller {
                let told = raw.strip_prefix("    return ");
                if let Some(told) = told.and_then(|told| told.strip_suffix(';')) {
                    text.told.insert(teller, reader.pieces(told));
                }
            } else if !(left_out && raw.is_empty()) {
                text.lines.push(Line {
                    raw,
                    pieces: reader.pieces(raw),
                    function: reader.function,
                    in_struct,
                });
            }
            left_out = teller.is_some();
            if raw == "}" {
                reader.function = None;
                in_struct = false;
            }
        }
        text
    }
}

struct Reader<'m> {
    marked: &'m mut Marked,
    function: Option<usize>,
    /// Marks of the names that naga made up in the function.
    made: HashMap<String, usize>,
}

impl Reader<'_> {
    fn pieces<'a>(&mut self, line: &'a str) -> Vec<Piece<'a>> {
        // Names of extensions have a name space of their own.
        if line.starts_with("enable ") {
            return vec![Piece::Other(line)];
        }
        let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let mut pieces = Vec::new();
        let mut at = 0;
        while at < line.len() {
            let rest = &line[at..];
            let length = match rest.find(|c| !part(c)) {
                Some(0) => {
                    let length = rest.find(part).unwrap_or(rest.len());
                    pieces.push(Piece::Other(&rest[..length]));
                    at += length;
                    continue;
                }
                Some(length) => length,
                None => rest.len(),
            };
            let word = &rest[..length];
            let (before, after) = (&line[..at], &rest[length..]);
            if before.ends_with('@') {
                // Name and arguments of an attribute: numbers, and names that no declaration can change.
                let end = match after.starts_with('(') {
                    true => after.find(')').map_or(rest.len(), |end| length + end),
                    false => length,
                };
                pieces.push(Piece::Other(&rest[..end]));
                at += end;
                continue;
            }
            pieces.push(self.piece(word, before.ends_with('.'), after.starts_with('>')));
            at += length;
        }
        pieces
    }

    fn piece<'a>(&mut self, word: &'a str, is_member: bool, ends_template: bool) -> Piece<'a> {
        if let Some(mark) = Marked::number(word) {
            return Piece::Mark(mark);
        }
        if word.starts_with(|c: char| c.is_ascii_digit()) {
            // A number without a suffix at the end of a template list is an array length.
            let length = word.parse().ok().filter(|_| ends_template);
            let length = length.and_then(|number: u32| self.marked.lengths.get(&number));
            return length.map_or(Piece::Other(word), |length| Piece::Length(*length));
        }
        if is_member {
            return Piece::Other(word);
        }
        let made = word.strip_prefix("_e");
        let made = made.filter(|number| number.bytes().all(|byte| byte.is_ascii_digit()));
        match (made, self.function) {
            (Some(_), Some(function)) => {
                let marked = &mut *self.marked;
                let mark = self.made.entry(word.to_owned());
                let mark = mark.or_insert_with(|| marked.mark(word, Scope::Function(function)));
                Piece::Mark(*mark)
            }
            _ => Piece::Word(word),
        }
    }
}
