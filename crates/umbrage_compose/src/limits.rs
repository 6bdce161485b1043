//! Limits on a module's text: what parsers, validators and drops of syntax trees, which recurse, can take
//! on a small thread's stack, and no shader comes near.

use std::ops::Range;

/// Brackets within brackets.
const DEEPEST_NESTING: usize = 200;
/// Templates that open within templates; the lexer's time doubles with each.
const DEEPEST_TEMPLATES: usize = 12;
/// Operators in a row, as in a + b + c, and prefixes before one operand.
const LONGEST_EXPRESSION: usize = 500;
/// `else` in a function.
const MOST_ALTERNATIVES: usize = 500;
/// `struct` in a module.
const MOST_STRUCTS: usize = 1000;
/// Digits of a number's exponent.
const LONGEST_EXPONENT: usize = 5;
/// Bytes that a member may ask for by `@size` or `@align`.
const LARGEST_MEMBER: u64 = 1 << 28;

/// Finds the part of `text` that is beyond a limit, and says which limit.
pub(crate) fn check(text: &str) -> Result<(), (String, Range<usize>)> {
    let mut scan = Scan::default();
    let bytes = text.as_bytes();
    let mut index = 0;
    while index < bytes.len() {
        if let Some(end) = comment_end(bytes, index) {
            index = end;
            continue;
        }
        let end = word_end(bytes, index);
        let problem = if end > index {
            scan.word(&text[index..end], &text[end..])
        } else {
            scan.symbol(bytes[index], bytes.get(index + 1).copied())
        };
        let end = end.max(index + 1);
        if let Some(problem) = problem {
            return Err((problem, index..end));
        }
        index = end;
    }
    Ok(())
}

#[derive(Default)]
struct Scan {
    nesting: usize,
    templates: usize,
    operators: usize,
    prefixes: usize,
    alternatives: usize,
    structs: usize,
    /// The last byte that is no space.
    last: u8,
}

impl Scan {
    fn word(&mut self, word: &str, rest: &str) -> Option<String> {
        let attribute = self.last == b'@';
        self.last = b'a';
        self.prefixes = 0;
        match word {
            "else" => self.alternatives += 1,
            "struct" => self.structs += 1,
            _ => {}
        }
        if self.alternatives > MOST_ALTERNATIVES {
            return Some(format!(
                "more than {MOST_ALTERNATIVES} `else` in a function"
            ));
        }
        if self.structs > MOST_STRUCTS {
            return Some(format!("more than {MOST_STRUCTS} structs in a module"));
        }
        if attribute && (word == "size" || word == "align") {
            let argument = rest
                .trim_start()
                .strip_prefix('(')
                .unwrap_or("")
                .trim_start();
            let digits = argument
                .split(|c: char| !c.is_ascii_digit())
                .next()
                .unwrap_or("");
            if !digits.is_empty()
                && digits
                    .parse()
                    .map_or(true, |bytes: u64| bytes > LARGEST_MEMBER)
            {
                return Some(format!("`@{word}` of more than {LARGEST_MEMBER} bytes"));
            }
        }
        // The exponent follows the last letter of a number, or a sign after it.
        if word.starts_with(|c: char| c.is_ascii_digit()) {
            let signed = word.ends_with(['e', 'E', 'p', 'P']) && rest.starts_with(['+', '-']);
            let exponent = match word.rfind(['e', 'E', 'p', 'P']) {
                Some(_) if signed => &rest[1..],
                Some(at) if !word.starts_with("0x") || word[at..].starts_with(['p', 'P']) => {
                    &word[at + 1..]
                }
                _ => "",
            };
            let digits = exponent.bytes().take_while(u8::is_ascii_digit).count();
            if digits > LONGEST_EXPONENT {
                return Some(format!(
                    "an exponent of more than {LONGEST_EXPONENT} digits"
                ));
            }
        }
        None
    }

    fn symbol(&mut self, byte: u8, next: Option<u8>) -> Option<String> {
        let last = self.last;
        if byte.is_ascii_whitespace() {
            return None;
        }
        self.last = byte;
        match byte {
            b'(' | b'[' | b'{' => self.nesting += 1,
            b')' | b']' | b'}' => self.nesting = self.nesting.saturating_sub(1),
            // Another template opens within the last where only names and numbers stand between.
            b'<' if last == b'a' => self.templates += 1,
            b'>' => self.templates = self.templates.saturating_sub(1),
            _ => {}
        }
        if !matches!(byte, b'<' | b'>' | b',' | b':') {
            self.templates = 0;
        }
        if self.nesting == 0 {
            self.alternatives = 0;
        }
        let after_operand = matches!(last, b'a' | b')' | b']');
        match byte {
            b';' | b'{' | b'}' | b',' => self.operators = 0,
            b'+' | b'-' | b'*' | b'/' | b'%' | b'&' | b'|' | b'^' if after_operand => {
                self.operators += 1;
            }
            b'.' if next.is_some_and(|c| c.is_ascii_alphabetic()) => self.operators += 1,
            b'!' | b'-' | b'~' | b'&' | b'*' => self.prefixes += 1,
            _ => {}
        }
        if after_operand || !matches!(byte, b'!' | b'-' | b'~' | b'&' | b'*') {
            self.prefixes = 0;
        }
        if self.nesting > DEEPEST_NESTING || self.prefixes > DEEPEST_NESTING {
            Some(format!("nested more than {DEEPEST_NESTING} deep"))
        } else if self.templates > DEEPEST_TEMPLATES {
            Some(format!(
                "templates nested more than {DEEPEST_TEMPLATES} deep"
            ))
        } else if self.operators > LONGEST_EXPRESSION {
            Some(format!(
                "an expression of more than {LONGEST_EXPRESSION} operators"
            ))
        } else {
            None
        }
    }
}

/// The end of the comment at `index`, if one starts there; block comments nest.
fn comment_end(bytes: &[u8], index: usize) -> Option<usize> {
    let rest = &bytes[index..];
    if rest.starts_with(b"//") {
        return Some(
            rest.iter()
                .position(|byte| *byte == b'\n')
                .map_or(bytes.len(), |at| index + at),
        );
    }
    if !rest.starts_with(b"/*") {
        return None;
    }
    let (mut depth, mut at) = (0usize, index);
    while at < bytes.len() {
        if bytes[at..].starts_with(b"/*") {
            depth += 1;
            at += 2;
        } else if bytes[at..].starts_with(b"*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return Some(at);
            }
        } else {
            at += 1;
        }
    }
    Some(bytes.len())
}

/// The end of the word or number at `index`; `index` where there is none.
fn word_end(bytes: &[u8], index: usize) -> usize {
    let number = bytes[index].is_ascii_digit();
    let part = |byte: &u8| {
        byte.is_ascii_alphanumeric()
            || *byte == b'_'
            || !byte.is_ascii()
            || (number && *byte == b'.')
    };
    index + bytes[index..].iter().take_while(|byte| part(byte)).count()
}
