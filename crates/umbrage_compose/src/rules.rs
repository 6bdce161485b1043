//! Rules of WebGPU and WGSL that naga does not check, one file each.
//!
//! Each rule is a function that takes the linked module and returns the first fault, at its author's place. Dawn is
//! the oracle: the tests compare every verdict with its own (`tests/dawn`).

mod abstracts;
mod aliases;
mod alignment;
mod constants;
mod flow;
mod limits;
mod math;
mod stages;
mod value;
mod varyings;

use std::fmt;

use naga::{EntryPoint, Function, GlobalVariable, Handle, Module, Span, valid::ModuleInfo};

use crate::{Cause, Fault, Library, Reflection, Target, target::Limit};

pub(crate) use constants::Constants;

/// A fault in a module's text.
pub(crate) struct Problem {
    pub(crate) span: Span,
    pub(crate) message: String,
    pub(crate) advice: &'static str,
}

/// Checks the rules that `module` must keep by itself, whatever it is linked with. `text` is the text that naga
/// parsed it from.
pub(crate) fn check_text(module: &Module, text: &str) -> Result<(), Problem> {
    let constants = Constants::new(module)?;
    for function in functions(module) {
        flow::check(function)?;
        constants.check(function)?;
        abstracts::check(function, text)?;
    }
    alignment::check(module, text)?;
    aliases::check(module)
}

/// Number of the locations that a vertex stage gives something at, counted from 0 to the last.
pub(crate) fn locations_given(module: &Module, entry: &EntryPoint) -> u64 {
    let given = varyings::outputs(module, entry);
    let last = given.located.last_key_value();
    last.map_or(0, |(location, _)| u64::from(*location) + 1)
}

/// All functions, entry points last.
fn functions(module: &Module) -> impl Iterator<Item = &Function> {
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    let functions = module.functions.iter().map(|(_, function)| function);
    functions.chain(entries)
}

/// A linked module to check, and all that the rules need to know about it.
pub(crate) struct Subject<'a> {
    pub(crate) library: &'a Library,
    pub(crate) target: &'a Target,
    /// The module that declares the entry points.
    pub(crate) root: usize,
    pub(crate) module: &'a Module,
}

impl<'a> Subject<'a> {
    /// Checks the limits that naga's validator would enforce without naming them.
    pub(crate) fn check_before_validation(&self) -> Result<Constants<'a>, Fault> {
        let constants = Constants::new(self.module).map_err(|problem| self.fault(problem))?;
        limits::workgroup_sizes(self, &constants)?;
        Ok(constants)
    }

    /// Checks a valid module, with its `info`, `reflection` and `constants`.
    pub(crate) fn check(
        &self,
        info: &ModuleInfo,
        reflection: &Reflection,
        constants: &Constants<'a>,
    ) -> Result<(), Fault> {
        // Check again, now that calls lead into other modules.
        aliases::check(self.module).map_err(|problem| self.fault(problem))?;
        stages::check(self, info)?;
        varyings::check(self)?;
        limits::check(self, info, reflection, constants)
    }

    fn fault(&self, problem: Problem) -> Fault {
        self.at(problem.span, problem.message).note(problem.advice)
    }

    /// Fault at `span` of the linked module.
    fn at(&self, span: Span, message: impl Into<String>) -> Fault {
        let fault = Fault::new(Cause::Validation, message);
        let place = span.to_range().filter(|range| !range.is_empty());
        match place.and_then(|range| Some((self.library.locate(range.start)?, range.len()))) {
            Some(((module, start), length)) => {
                fault.at(self.library.source(module).place(start..start + length))
            }
            None => fault.at(self.library.source(self.root).place(0..0)),
        }
    }

    /// Fault of the entry point `entry`, at the word `word` in its module, or else at the entry point's name.
    fn at_entry(&self, entry: &EntryPoint, word: &str, message: impl Into<String>) -> Fault {
        let source = self.library.source(self.root);
        let mut place = source.find(word);
        if place.range.is_empty() {
            place = source.find(&entry.name);
        }
        Fault::new(Cause::Validation, message).at(place)
    }

    /// Fault of the variable `handle`, at its name.
    fn at_variable(&self, handle: Handle<GlobalVariable>, message: impl Into<String>) -> Fault {
        let span = self.module.global_variables.get_span(handle);
        let name = self.module.global_variables[handle].name.as_deref();
        let module = span
            .to_range()
            .and_then(|range| self.library.locate(range.start));
        match module {
            Some((module, _)) => {
                let place = self.library.source(module).find(name.unwrap_or(""));
                Fault::new(Cause::Validation, message).at(place)
            }
            None => self.at(span, message),
        }
    }

    /// Checks that the number `found` is within `limit`; `what` describes it.
    fn limit(&self, limit: Limit, found: u64, what: fmt::Arguments<'_>) -> Result<(), String> {
        let most = self.target.limit(limit);
        if found <= most {
            return Ok(());
        }
        Err(format!(
            "{found} {what}, but `{}` of the target `{}` is {most}",
            limit.name(),
            self.target
        ))
    }
}
