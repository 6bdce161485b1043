//! Faults: what is wrong, where in the author's file, and what to do.

use std::fmt;

use codespan_reporting::{
    diagnostic::{Diagnostic, Label},
    term,
};

use crate::{
    Key,
    excerpt::{Excerpt, shortened},
};

/// Kind of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// A file is missing, unreadable, or not of its format.
    File,
    /// A manifest or a package's axes say something impossible.
    Manifest,
    /// A key names an axis or a value that does not exist, or leaves out one that has no default.
    Key,
    /// A module's text is not WESL.
    Syntax,
    /// An import names nothing.
    Import,
    /// An interface is unbound, or its implementation does not fit.
    Interface,
    /// A type or value is wrong: what naga's front end refuses.
    Type,
    /// Functions, constants or types lead back to themselves.
    Recursion,
    /// The linked permutation is not valid on the target.
    Validation,
    /// A stage uses more resources of a kind than the target allows.
    Limit,
}

impl Cause {
    /// The kind's name: what rules are told apart by in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Manifest => "manifest",
            Self::Key => "key",
            Self::Syntax => "syntax",
            Self::Import => "import",
            Self::Interface => "interface",
            Self::Type => "type",
            Self::Recursion => "recursion",
            Self::Validation => "validation",
            Self::Limit => "limit",
        }
    }
}

/// A place in an author's file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Location {
    /// The file, as it was named to the composer.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
    /// Note on the place; often empty.
    pub label: String,
}

/// One fault, rendered with the lines it speaks of.
///
/// The first location is the fault's own; others are what it conflicts with.
#[derive(Clone, Debug)]
pub struct Fault {
    /// Kind of fault.
    pub cause: Cause,
    /// Message, as a lowercase fragment.
    pub message: String,
    /// Where: the fault's own place first.
    pub locations: Vec<Location>,
    /// Remedies, and what else helps.
    pub notes: Vec<String>,
    /// The permutations in which it was found; one, until faults are gathered.
    pub keys: Vec<Key>,
    snippets: String,
}

/// A stretch of a source text, for building a [`Fault`].
pub(crate) struct Place<'a> {
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
    pub(crate) range: std::ops::Range<usize>,
    pub(crate) label: String,
}

impl Fault {
    pub(crate) fn new(cause: Cause, message: impl Into<String>) -> Self {
        Self {
            cause,
            message: shortened(message.into()),
            locations: Vec::new(),
            notes: Vec::new(),
            keys: Vec::new(),
            snippets: String::new(),
        }
    }

    pub(crate) fn at(mut self, place: Place<'_>) -> Self {
        let text = place.text;
        let end = floor_char(text, place.range.end);
        let start = floor_char(text, place.range.start.min(end));
        let excerpt = Excerpt::new(place.file, text, start..end);
        let said = shortened(place.label);
        self.locations.push(Location {
            file: place.file.to_owned(),
            line: excerpt.line(),
            column: excerpt.column,
            label: said.clone(),
        });
        let primary = self.locations.len() == 1;
        let label = if primary {
            Label::primary((), excerpt.range.clone())
        } else {
            Label::secondary((), excerpt.range.clone())
        };
        let message = if primary { self.message.as_str() } else { "" };
        let diagnostic = if primary {
            Diagnostic::error()
        } else {
            Diagnostic::note()
        }
        .with_message(message)
        .with_labels(vec![label.with_message(said)]);
        let config = term::Config::default();
        let mut rendered = String::new();
        if term::emit_to_string(&mut rendered, &config, &excerpt, &diagnostic).is_ok() {
            // The message stands once, in our own words, before all snippets.
            let body = rendered.split_once('\n').map_or("", |(_, body)| body);
            self.snippets.push_str(body.trim_end());
            self.snippets.push('\n');
        }
        self
    }

    pub(crate) fn in_file(mut self, file: impl Into<String>, line: usize, column: usize) -> Self {
        let file = file.into();
        self.snippets
            .push_str(&format!("  --> {file}:{line}:{column}\n"));
        self.locations.push(Location {
            file,
            line,
            column,
            label: String::new(),
        });
        self
    }

    /// Adds what to do about it, or what else helps.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(shortened(note.into()));
        self
    }

    pub(crate) fn key(mut self, key: &Key) -> Self {
        self.keys = vec![key.clone()];
        self
    }

    /// The fault's own place.
    pub fn location(&self) -> Option<&Location> {
        self.locations.first()
    }
}

fn floor_char(text: &str, index: usize) -> usize {
    let mut index = index.min(text.len());
    while !text.is_char_boundary(index) {
        index -= 1;
    }
    index
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.message)?;
        f.write_str(&self.snippets)?;
        for note in &self.notes {
            writeln!(f, "  = {note}")?;
        }
        match self.keys.as_slice() {
            [] => Ok(()),
            [key] => writeln!(f, "  = in the permutation {key}"),
            [key, rest @ ..] => {
                writeln!(f, "  = in the permutation {key} and {} more", rest.len())
            }
        }
    }
}

impl std::error::Error for Fault {}

/// One or more faults.
#[derive(Clone, Debug)]
pub struct Error(Vec<Fault>);

impl Error {
    /// The faults, one at the least.
    pub fn faults(&self) -> &[Fault] {
        &self.0
    }

    /// The faults, by value.
    pub fn into_faults(self) -> Vec<Fault> {
        self.0
    }

    pub(crate) fn all(faults: Vec<Fault>) -> Self {
        Self(faults)
    }
}

impl From<Fault> for Error {
    fn from(fault: Fault) -> Self {
        Self(vec![fault])
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{fault}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}
