//! WGSL text of a module, for hosts that take WGSL.
//!
//! Naga's writer does most of the work. Its gaps are filled here:
//!
//! - *Names.* A host finds entry points, overrides, bindings and members by the names that their authors gave. The
//!   writer changes a name that ends in a digit or in `_`, that has a character beyond ASCII, or that something
//!   else in the module has, and there is no option against that. So it is given a module in which every name is a
//!   *mark* (`marks`): a word that the writer leaves unchanged, and that is unlike any word of its own. The text
//!   that it writes shows which of WGSL's own words it uses. Only then does every mark get a name (`naming`): names
//!   that hosts know are kept, and so are others wherever nothing else there has the same name. No name is ever
//!   searched for in the text.
//! - *Expressions of overrides.* At module scope the writer can write only values. Such an expression is put into a
//!   function made for it (a *teller*), where the writer can write it, and taken from that function's text.
//! - *Lengths of arrays* that are overrides: a number stands for each until the text is written.
//! - *Diagnostic filters*, and the extension `subgroups`, which naga's IR does not record (`diagnostics`).
//! - *Layouts.* The writer leaves out `@size` and `@align`. Every member that is followed by more room than it
//!   needs gets a `@size`, which fixes all offsets.

mod marks;
mod naming;
mod text;

use std::borrow::Cow;

use naga::{
    Module, PredeclaredType, Span,
    back::wgsl::{WriterFlags, write_string},
    keywords::wgsl::BUILTIN_IDENTIFIERS,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

use crate::diagnostics::{Written, uses_subgroups};

use self::{
    marks::{Length, Marked, Scope, Size},
    text::{Line, Piece, Text},
};

/// Reasons why a module cannot be written as WGSL.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// A name that a host knows cannot be kept.
    #[error("a host knows `{0}` by this name, by which the linked shader needs WGSL's own `{0}`")]
    Host(String),
    /// A variable without an initializer has a type that has no name in WGSL.
    #[error(
        "`{0}` is a `var` of what `atomicCompareExchangeWeak` gives, which has no name: use `let`"
    )]
    Nameless(String, Span),
    #[error("{0}")]
    Naga(String),
}

/// Whether `module` must be printed to find out whether it can be written as WGSL: it may use a type that has no
/// name in WGSL, or a host may know a part of it by one of WGSL's own names.
pub(crate) fn is_doubtful(module: &Module) -> bool {
    let mut predeclared = module.special_types.predeclared_types.keys();
    let nameless =
        |ty: &PredeclaredType| matches!(ty, PredeclaredType::AtomicCompareExchangeWeakResult(_));
    let entries = module.entry_points.iter().map(|entry| &entry.name);
    let overrides = module.overrides.iter();
    let overrides = overrides.filter(|(_, item)| item.id.is_none());
    let mut names = entries.chain(overrides.filter_map(|(_, item)| item.name.as_ref()));
    predeclared.any(nameless) || names.any(|name| BUILTIN_IDENTIFIERS.contains(&name.as_str()))
}

/// The valid `module` as WGSL, with the diagnostic filters `written`.
pub(crate) fn write(
    module: &Module,
    info: &ModuleInfo,
    written: &Written,
) -> Result<String, Error> {
    let text = written.annotate(&write_module(module, info)?);
    Ok(match uses_subgroups(module) {
        true => format!("enable subgroups;\n{text}"),
        false => text,
    })
}

fn write_module(module: &Module, info: &ModuleInfo) -> Result<String, Error> {
    let naga = |error: &dyn std::error::Error| Error::Naga(error.to_string());
    let mut marked = Marked::new(module).map_err(|error| naga(&error))?;
    if let Some((variable, span)) = marked.undeclarable.take() {
        return Err(Error::Nameless(variable, span));
    }
    let info = if marked.has_tellers() {
        // The module is known to be valid: only the types of the tellers' expressions are needed.
        Validator::new(ValidationFlags::empty(), Capabilities::all())
            .validate(&marked.module)
            .map(Cow::Owned)
            .map_err(|error| naga(error.as_inner()))?
    } else {
        Cow::Borrowed(info)
    };
    marked.put_numbers_for_lengths();
    let written =
        write_string(&marked.module, &info, WriterFlags::empty()).map_err(|error| naga(&error))?;
    let text = Text::read(&written, &mut marked);
    let names = naming::choose(&marked, &text).map_err(Error::Host)?;
    let printer = Printer {
        marked: &marked,
        text: &text,
        names,
        out: String::with_capacity(written.len()),
    };
    Ok(printer.print())
}

struct Printer<'a> {
    marked: &'a Marked,
    text: &'a Text<'a>,
    /// Names by mark.
    names: Vec<String>,
    out: String,
}

impl Printer<'_> {
    fn print(mut self) -> String {
        let lines = &self.text.lines;
        for (index, line) in lines.iter().enumerate() {
            let next = lines.get(index + 1).and_then(Line::subject);
            match next.and_then(|entry| self.marked.workgroup_sizes.get(&entry)) {
                Some(sizes) if line.raw.starts_with("@compute ") => self.workgroup_size(sizes),
                _ if line.in_struct => self.member(line),
                _ if line.raw.starts_with("    var ") => self.local(line),
                _ if self.is_length(line) => continue,
                _ => self.declaration(line),
            }
            self.out.push('\n');
        }
        self.out
    }

    /// Whether the line declares the override that naga made of an array's length, which is written in the array's
    /// type instead.
    fn is_length(&self, line: &Line<'_>) -> bool {
        let things = &self.marked.things;
        line.function.is_none()
            && line
                .subject()
                .is_some_and(|mark| things[mark].scope == Scope::Unsaid)
    }

    fn workgroup_size(&mut self, sizes: &[Size; 3]) {
        self.out.push_str("@compute @workgroup_size(");
        for (axis, size) in sizes.iter().enumerate() {
            self.out.push_str(if axis == 0 { "" } else { ", " });
            match size {
                Size::Number(number) => self.out.push_str(&number.to_string()),
                Size::Told(teller) => self.told(*teller),
            }
        }
        self.out.push_str(") ");
    }

    fn member(&mut self, line: &Line<'_>) {
        let room = line
            .subject()
            .and_then(|mark| self.marked.things[mark].room);
        if let Some(room) = room {
            self.out.push_str(&format!("    @size({room})"));
        }
        // The attribute replaces the indent, except for one space.
        let indent = if room.is_some() { 3 } else { 0 };
        self.pieces(&line.pieces, indent);
    }

    fn local(&mut self, line: &Line<'_>) {
        let variable = line.subject();
        match variable.and_then(|mark| Some((mark, self.marked.inferred.get(&mark)?))) {
            Some((mark, value)) => {
                let name = &self.names[mark];
                self.out.push_str(&format!("    var {name} = {value};"));
            }
            None => self.pieces(&line.pieces, 0),
        }
    }

    /// Prints a declaration, with the initializer of its override or variable where naga cannot write it.
    fn declaration(&mut self, line: &Line<'_>) {
        self.pieces(&line.pieces, 0);
        let subject = line.subject().filter(|_| line.function.is_none());
        if let Some(teller) = subject.and_then(|mark| self.marked.values.get(&mark)) {
            self.out.truncate(self.out.trim_end_matches(';').len());
            self.out.push_str(" = ");
            self.told(*teller);
            self.out.push(';');
        }
    }

    fn told(&mut self, teller: usize) {
        let text = self.text;
        if let Some(pieces) = text.told.get(&teller) {
            self.pieces(pieces, 0);
        }
    }

    /// Prints `pieces`, without the first `left_out` bytes of the first one.
    fn pieces(&mut self, pieces: &[Piece<'_>], mut left_out: usize) {
        for piece in pieces {
            match piece {
                Piece::Mark(mark) | Piece::Length(Length::Override(mark)) => {
                    self.out.push_str(&self.names[*mark]);
                }
                Piece::Length(Length::Told(teller)) => self.told(*teller),
                Piece::Word(text) | Piece::Other(text) => self.out.push_str(&text[left_out..]),
            }
            left_out = 0;
        }
    }
}
