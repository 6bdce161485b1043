//! Excerpts of a text for a fault: whole lines around its place, and of a very long line only the part near it.

use std::ops::Range;

use codespan_reporting::files;

/// Lines with more characters than this are cut.
const LONGEST_LINE: usize = 240;
/// Number of characters of a cut line that are kept before the place, and after it.
const NEAR: usize = 80;
/// Mark in place of the part that is cut out.
const CUT: &str = "…";

/// Some lines of a file, numbered as they are in it.
pub(crate) struct Excerpt<'a> {
    file: &'a str,
    text: String,
    /// Where each line starts in `text`.
    starts: Vec<usize>,
    /// The number of the first line.
    first: usize,
    /// The place, in `text`.
    pub(crate) range: Range<usize>,
    /// The column of the place in the file's own line.
    pub(crate) column: usize,
}

impl<'a> Excerpt<'a> {
    /// Excerpt of `text` for `range`, both ends of which lie between characters.
    pub(crate) fn new(file: &'a str, text: &str, range: Range<usize>) -> Self {
        let start_of_line = text[..range.start].rfind('\n').map_or(0, |at| at + 1);
        let end_of_line = (text[range.end..].find('\n')).map_or(text.len(), |at| range.end + at);
        let mut excerpt = Self {
            file,
            text: String::new(),
            starts: Vec::new(),
            first: 1 + text[..start_of_line].matches('\n').count(),
            range: 0..0,
            column: 1 + text[start_of_line..range.start].chars().count(),
        };
        let mut at = start_of_line;
        for line in text[start_of_line..end_of_line].split('\n') {
            let within = |offset: usize| offset.checked_sub(at).filter(|at| *at <= line.len());
            excerpt.add(line, within(range.start), within(range.end));
            at += line.len() + 1;
        }
        excerpt
    }

    /// The number of the place's line.
    pub(crate) fn line(&self) -> usize {
        self.first
    }

    /// Takes in a line, in which the place may start and end.
    fn add(&mut self, line: &str, start: Option<usize>, end: Option<usize>) {
        self.starts.push(self.text.len());
        let kept = match (start, end) {
            _ if line.chars().nth(LONGEST_LINE).is_none() => 0..line.len(),
            (Some(start), Some(end)) if line[start..end].chars().nth(NEAR).is_none() => {
                before(line, start)..after(line, end)
            }
            (Some(near), _) | (None, Some(near)) => before(line, near)..after(line, near),
            (None, None) => 0..after(line, 0),
        };
        if kept.start > 0 {
            self.text.push_str(CUT);
        }
        let base = self.text.len();
        let moved = |at: usize| base + at.clamp(kept.start, kept.end) - kept.start;
        if let Some(start) = start {
            self.range.start = moved(start);
        }
        if let Some(end) = end {
            self.range.end = moved(end);
        }
        self.text.push_str(&line[kept.clone()]);
        if kept.end < line.len() {
            self.text.push_str(CUT);
        }
        self.text.push('\n');
    }
}

/// Offset of the character [`NEAR`] characters before `at`.
fn before(line: &str, at: usize) -> usize {
    let mut places = line[..at].char_indices().rev();
    places.nth(NEAR - 1).map_or(0, |(at, _)| at)
}

/// Offset of the character [`NEAR`] characters after `at`.
fn after(line: &str, at: usize) -> usize {
    let mut places = line[at..].char_indices();
    places.nth(NEAR).map_or(line.len(), |(far, _)| at + far)
}

impl<'a> files::Files<'a> for Excerpt<'_> {
    type FileId = ();
    type Name = &'a str;
    type Source = &'a str;

    fn name(&'a self, (): ()) -> Result<&'a str, files::Error> {
        Ok(self.file)
    }

    fn source(&'a self, (): ()) -> Result<&'a str, files::Error> {
        Ok(&self.text)
    }

    fn line_index(&'a self, (): (), byte: usize) -> Result<usize, files::Error> {
        Ok(self.starts.partition_point(|start| *start <= byte) - 1)
    }

    fn line_number(&'a self, (): (), line: usize) -> Result<usize, files::Error> {
        Ok(self.first + line)
    }

    fn column_number(&'a self, (): (), _: usize, _: usize) -> Result<usize, files::Error> {
        // Only asked for the start of the place.
        Ok(self.column)
    }

    fn line_range(&'a self, (): (), line: usize) -> Result<Range<usize>, files::Error> {
        let start = (self.starts.get(line)).ok_or(files::Error::LineTooLarge {
            given: line,
            max: self.starts.len(),
        })?;
        let next = self.starts.get(line + 1);
        Ok(*start..next.copied().unwrap_or(self.text.len()))
    }
}

/// `text`, with its middle cut out where it is too long for a person to read.
pub(crate) fn shortened(text: String) -> String {
    const FIRST: usize = 600;
    const LAST: usize = 60;
    if text.chars().nth(FIRST + LAST).is_none() {
        return text;
    }
    let first = (text.char_indices().nth(FIRST)).map_or(text.len(), |(at, _)| at);
    let last = (text.char_indices().nth_back(LAST)).map_or(0, |(at, _)| at);
    format!("{}{CUT}{}", &text[..first], &text[last..])
}

#[cfg(test)]
mod tests {
    use crate::{Cause, Fault, file::SourceText};

    /// The fault at the first `word` of `text`.
    fn told(text: &str, word: &str) -> (Fault, String) {
        let source = SourceText::new("a.wesl", text);
        let start = text.find(word).unwrap();
        let fault = Fault::new(Cause::Syntax, "wrong").at(source.place(start..start + word.len()));
        let said = fault.to_string();
        (fault, said)
    }

    #[test]
    fn short_lines_are_shown_whole() {
        let (_, said) = told("one\n\ttwo three\nfour", "three");
        assert_eq!(
            said,
            "wrong\n  ┌─ a.wesl:2:6\n  │\n2 │     two three\n  │         ^^^^^\n"
        );
    }

    #[test]
    fn a_long_line_is_cut_around_the_place() {
        for filler in ["x", "ß", "漢", "\t", "🦊"] {
            let long = filler.repeat(100_000);
            let (fault, said) = told(&format!("first\n{long} HERE {long}\nlast"), "HERE");
            let at = fault.location().unwrap();
            assert_eq!((at.line, at.column), (2, 100_002), "{filler}");
            assert!(said.contains("a.wesl:2:100002"), "{said}");
            assert!(said.len() < 3_000, "{filler}: {} bytes", said.len());
            assert!(said.contains(" HERE ") && said.contains("^^^^"), "{said}");
            assert!(said.contains('…'), "{said}");
        }
    }

    #[test]
    fn a_long_place_is_cut_itself() {
        let word = "y".repeat(50_000);
        let (fault, said) = told(&format!("a {word} b"), &word);
        assert_eq!(fault.location().map(|at| at.column), Some(3));
        assert!(said.len() < 1_000, "{} bytes", said.len());
        // The excerpt shows the first characters of the long line.
        assert!(said.contains("│ a yyyy"), "{said}");
    }

    #[test]
    fn a_place_of_many_lines_is_cut_at_both_ends() {
        let long = "z".repeat(50_000);
        let word = format!("BEGIN{long}\n{long}\nmiddle\n{long}END");
        let (fault, said) = told(&format!("{long}{word}{long}"), &word);
        assert_eq!(fault.location().map(|at| at.column), Some(50_001));
        assert!(said.len() < 3_000, "{} bytes", said.len());
        assert!(said.contains("BEGIN") && said.contains("END"), "{said}");
        assert!(said.contains("1 │") && said.contains("4 │"), "{said}");
    }

    #[test]
    fn the_end_of_a_text_has_a_place() {
        for text in ["", "\n", "a", "a\n", "a\r\nb\r\n"] {
            let source = SourceText::new("a.wesl", text);
            let fault = Fault::new(Cause::Syntax, "wrong").at(source.place(text.len()..text.len()));
            assert!(fault.to_string().contains("a.wesl:"), "{text:?}: {fault}");
        }
    }

    #[test]
    fn long_words_are_cut() {
        let fault = Fault::new(Cause::Type, "x".repeat(100_000)).note("é".repeat(100_000));
        assert!(fault.to_string().len() < 4_000);
    }
}
