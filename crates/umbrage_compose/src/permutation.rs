//! Permutations: linked, validated, and reflected.

use std::{borrow::Cow, sync::OnceLock};

use naga::{
    EntryPoint, GlobalVariable, Handle, Module, Statement, WithSpan,
    back::pipeline_constants::PipelineConstantError,
    valid::{
        Capabilities, EntryPointError, FunctionError, GlobalUse, ModuleInfo, ValidationError,
        ValidationFlags, Validator,
    },
};

use rustc_hash::FxHashSet;

use crate::{
    Cause, Error, Fault, Language, Library, Pass, ProjectedKey, Reflection, Target,
    diagnostics::{Places, Written},
    lacking,
    link::Origins,
    names::{Item, ItemNumber},
    overrides,
    reflect::reflect,
    rules::Subject,
    uniformity, wgsl, words,
};

/// A linked and validated shader.
#[derive(Debug)]
pub struct Permutation {
    /// The choices that it depends on: keys that cannot differ share it.
    pub key: ProjectedKey,
    /// The same of the further keys, where it is of [several](crate::Composer::compose_all).
    pub others: Vec<ProjectedKey>,
    /// How it is run, where its axes tell.
    pub pass: Option<Pass>,
    /// The shader, in naga's IR. The IR does not carry the diagnostic filters, without which a browser may refuse
    /// code that its author allowed: give a browser the text, [`Self::wgsl`].
    pub module: Module,
    /// Its demands on its host.
    pub reflection: Reflection,
    /// Warnings about the shader: breaches that the authors' diagnostic filters make less than an error, and rules
    /// that WGSL does not have.
    pub warnings: Vec<String>,
    pub(crate) written: Written,
    pub(crate) capabilities: Capabilities,
    /// Findings of naga's validator, once it was asked.
    pub(crate) info: OnceLock<ModuleInfo>,
}

/// Variables that each entry point uses, directly or not.
pub(crate) type Uses = Vec<FxHashSet<ItemNumber>>;

impl Permutation {
    pub(crate) fn new(
        library: &Library,
        target: &Target,
        key: ProjectedKey,
        root: usize,
        (module, origins): (Module, &Origins),
    ) -> Result<Self, Fault> {
        let subject = Subject {
            library,
            target,
            root,
            module: &module,
        };
        let constants = subject.check_before_validation()?;
        let info = validate(&module, target.capabilities())
            .map_err(|error| validation_fault(library, target, (root, &module), &error))?;
        let declared = |item: &Item| (library.source(item.module).path.clone(), item.name.clone());
        let settable = overrides::reflect(&module, &info, |handle| {
            origins.overrides.get(&handle).map(declared)
        });
        let owner = |variable| origins.owner(library, variable);
        let used =
            |entry: usize, variable| info.get_entry_point(entry)[variable] != GlobalUse::empty();
        let size = |entry: &EntryPoint| overrides::workgroup_size(&module, &info, entry);
        let reflection = reflect(&module, used, owner, settable, size);
        subject.check(&info, &reflection, &constants)?;
        let places = Places {
            library,
            filters: &origins.filters,
        };
        let mut told = places.idle_filters();
        told.extend(uniformity::check(&module, &places)?);
        let written = Written::new(&module, &places);
        if wgsl::is_doubtful(&module)
            && let Err(error) = wgsl::write(&module, &info, &written)
        {
            return Err(wgsl_fault(library, root, &reflection, &error));
        }
        Ok(Self {
            warnings: told.iter().map(ToString::to_string).collect(),
            pass: library.axes().pass(&key),
            key,
            others: Vec::new(),
            module,
            reflection,
            written,
            capabilities: target.capabilities(),
            info: OnceLock::from(info),
        })
    }

    /// A permutation that is known to be valid, and has no overrides. `uses` was known with it.
    pub(crate) fn of_valid(
        library: &Library,
        target: &Target,
        key: ProjectedKey,
        (module, origins): (Module, Origins),
        uses: &Uses,
    ) -> Self {
        let owners = origins.owners.iter();
        let numbers: Vec<_> = owners.map(|item| item.number(library)).collect();
        let used = |entry: usize, variable: Handle<GlobalVariable>| {
            uses[entry].contains(&numbers[variable.index()])
        };
        let owner = |variable| origins.owner(library, variable);
        let size = |entry: &EntryPoint| entry.workgroup_size;
        let places = Places {
            library,
            filters: &origins.filters,
        };
        Self {
            pass: library.axes().pass(&key),
            key,
            others: Vec::new(),
            reflection: reflect(&module, used, owner, Vec::new(), size),
            warnings: Vec::new(),
            written: Written::new(&module, &places),
            capabilities: target.capabilities(),
            info: OnceLock::new(),
            module,
        }
    }

    /// Its key, or keys.
    pub fn keys(&self) -> impl Iterator<Item = &ProjectedKey> {
        std::iter::once(&self.key).chain(&self.others)
    }

    /// Findings of naga's validator. A permutation of parts that were found valid before is not validated until
    /// this is asked for: its text and its SPIR-V are written by it.
    ///
    /// # Errors
    /// None, but for a defect of the composer's.
    pub fn info(&self) -> Result<&ModuleInfo, Error> {
        if let Some(info) = self.info.get() {
            return Ok(info);
        }
        let info = validate(&self.module, self.capabilities).map_err(|error| {
            let message = format!("not valid, though all its parts are: {}", error.as_inner());
            Fault::new(Cause::Validation, message).key(&self.key)
        })?;
        Ok(self.info.get_or_init(|| info))
    }

    /// The shader as WGSL. Entry points, overrides and structs' members have their authors' names, and so does
    /// everything else that a host or an author may look for, unless two of them have the same name.
    ///
    /// # Errors
    /// Where naga cannot say it in WGSL.
    pub fn wgsl(&self) -> Result<String, Error> {
        wgsl::write(&self.module, self.info()?, &self.written)
            .map_err(|error| self.unwritable("WGSL", &error))
    }

    /// The shader as SPIR-V, all entry points in one module, clip space as WebGPU has it. Overrides become
    /// constants at their defaults: naga writes no specialisation constants.
    ///
    /// # Errors
    /// Code that naga cannot express in SPIR-V; an override without a default, or with an invalid default.
    pub fn spirv(&self) -> Result<Vec<u32>, Error> {
        // Wgpu flips the viewport, not the shader; an engine that takes the words does the same.
        let mut options = naga::back::spv::Options::default();
        options
            .flags
            .remove(naga::back::spv::WriterFlags::ADJUST_COORDINATE_SPACE);
        options.flags.remove(naga::back::spv::WriterFlags::DEBUG);
        let (module, info) = self.at_defaults(Language::Spirv)?;
        naga::back::spv::write_vec(&module, &info, &options, None)
            .map_err(|error| self.unwritable("SPIR-V", &error))
    }

    /// The shader with all overrides at their defaults, to be written in `language`.
    pub(crate) fn at_defaults(
        &self,
        language: Language,
    ) -> Result<(Cow<'_, Module>, Cow<'_, ModuleInfo>), Error> {
        overrides::resolved(&self.module, self.info()?)
            .map_err(|error| self.unresolved(language, &error))
    }

    /// Error for overrides whose defaults do not make a valid shader.
    fn unresolved(&self, language: Language, error: &PipelineConstantError) -> Error {
        let language = match language {
            Language::Spirv => "SPIR-V",
            Language::Wgsl => "WGSL",
            Language::Msl => "MSL",
            Language::Hlsl => "HLSL",
            Language::Glsl => "GLSL",
        };
        let without = self.reflection.overrides.iter();
        let without: Vec<_> = without
            .filter(|item| item.default.is_none() && !item.derived)
            .map(|item| format!("`{}` (of `{}`)", item.name, item.module))
            .collect();
        let message = match without.as_slice() {
            [] => format!("cannot be said in {language} with overrides at their defaults: {error}"),
            names => format!(
                "cannot be said in {language}: no default for {}",
                names.join(", ")
            ),
        };
        Fault::new(Cause::Validation, message)
            .key(&self.key)
            .note(format!("{language} has overrides at their defaults: give each one a valid default, or take the WGSL, which keeps them"))
            .into()
    }

    pub(crate) fn unwritable(&self, language: &str, error: &dyn std::error::Error) -> Error {
        Fault::new(
            Cause::Validation,
            format!(
                "cannot be said in {language}: {}",
                words::plain(&error.to_string())
            ),
        )
        .key(&self.key)
        .into()
    }
}

/// Fault for a declaration that WGSL cannot express, at its place.
fn wgsl_fault(
    library: &Library,
    root: usize,
    reflection: &Reflection,
    error: &wgsl::Error,
) -> Fault {
    let fault = Fault::new(Cause::Validation, error.to_string());
    match error {
        wgsl::Error::Host(name) => {
            let mut overrides = reflection.overrides.iter();
            let declared = overrides.find(|item| item.name == *name);
            let module = declared.and_then(|item| library.module(&item.module));
            let source = library.source(module.unwrap_or(root));
            fault
                .at(source.find(name))
                .note("rename it: in one shader a name has one meaning")
        }
        wgsl::Error::Nameless(_, span) => {
            let place = span
                .to_range()
                .and_then(|range| Some((library.locate(range.start)?, range.len())));
            match place {
                Some(((module, start), length)) => {
                    fault.at(library.source(module).place(start..start + length))
                }
                None => fault.at(library.source(root).place(0..0)),
            }
        }
        wgsl::Error::Naga(_) => fault.at(library.source(root).place(0..0)),
    }
}

/// Validates against what a target offers.
pub(crate) fn validate(
    module: &Module,
    capabilities: Capabilities,
) -> Result<ModuleInfo, WithSpan<ValidationError>> {
    // Naga's uniformity analysis differs from the specification's, which `uniformity` follows.
    let flags = ValidationFlags::all() - ValidationFlags::CONTROL_FLOW_UNIFORMITY;
    Validator::new(flags, capabilities).validate(module)
}

fn validation_fault(
    library: &Library,
    target: &Target,
    (root, module): (usize, &Module),
    error: &WithSpan<ValidationError>,
) -> Fault {
    let (said, contexts) = words::said(error.as_inner(), module);
    let lacking = lacking::told(lacking::lacking(module, target), target);
    let (message, advice) = lacking.unzip();
    let mut fault = Fault::new(Cause::Validation, message.unwrap_or(said));
    // A place that naga has words for says most; without one, the shortest place does.
    let mut spans: Vec<_> = error
        .spans()
        .filter_map(|(span, label)| Some((span.to_range()?, label.as_str())))
        .map(|(range, label)| {
            (
                range,
                if label.starts_with("naga::") {
                    ""
                } else {
                    label
                },
            )
        })
        .collect();
    spans.sort_by_key(|(range, label)| (label.is_empty(), range.len(), range.start));
    if let Some(range) = wrong_return(module, error.as_inner()).and_then(naga::Span::to_range) {
        spans = vec![(range, "")];
    }
    let worded = spans.iter().filter(|(_, label)| !label.is_empty()).count();
    for (range, label) in spans.iter().take(worded.max(1)) {
        if let Some((module, start)) = library.locate(range.start) {
            let source = library.source(module);
            let label = words::plain(label);
            fault = fault.at(source.place_labelled(start..start + range.len(), label));
        }
    }
    // Of some faults naga knows only in which declaration they are.
    if fault.locations.is_empty() {
        let span = match error.as_inner() {
            ValidationError::Function { handle, .. } => module.functions.get_span(*handle),
            ValidationError::GlobalVariable { handle, .. } => {
                module.global_variables.get_span(*handle)
            }
            ValidationError::Constant { handle, .. } => module.constants.get_span(*handle),
            ValidationError::Type { handle, .. } => module.types.get_span(*handle),
            _ => naga::Span::UNDEFINED,
        };
        fault = match span
            .to_range()
            .and_then(|range| Some((library.locate(range.start)?, range)))
        {
            Some(((at, start), range)) => {
                fault.at(library.source(at).place(start..start + range.len()))
            }
            None => {
                let name = match error.as_inner() {
                    ValidationError::EntryPoint { name, .. } => name.as_str(),
                    _ => "",
                };
                fault.at(library.source(root).find(name))
            }
        };
    }
    for note in advice.into_iter().chain(contexts) {
        fault = fault.note(note);
    }
    fault
}

/// The statement that returns a value of the wrong type: naga points at where the value came from.
fn wrong_return(module: &Module, error: &ValidationError) -> Option<naga::Span> {
    let (function, source) = match error {
        ValidationError::Function { handle, source, .. } => (&module.functions[*handle], source),
        ValidationError::EntryPoint {
            name,
            source: EntryPointError::Function(source),
            ..
        } => {
            let entry = module
                .entry_points
                .iter()
                .find(|entry| entry.name == *name)?;
            (&entry.function, source)
        }
        _ => return None,
    };
    let FunctionError::InvalidReturnType { expression, .. } = source else {
        return None;
    };
    let mut blocks = vec![&function.body];
    while let Some(block) = blocks.pop() {
        for (statement, span) in block.span_iter() {
            match statement {
                Statement::Return { value } if value == expression => return Some(*span),
                Statement::Block(block) => blocks.push(block),
                Statement::If { accept, reject, .. } => blocks.extend([accept, reject]),
                Statement::Switch { cases, .. } => {
                    blocks.extend(cases.iter().map(|case| &case.body))
                }
                Statement::Loop {
                    body, continuing, ..
                } => blocks.extend([body, continuing]),
                _ => {}
            }
        }
    }
    None
}
