//! Permutations: linked, validated, and reflected.

use naga::{Module, WithSpan, valid::{ModuleInfo, ValidationError, ValidationFlags, Validator}};

use crate::{
    Cause, Error, Fault, Key, Library, Reflection, Target, link::Linked, reflect::reflect,
};

/// A linked and validated shader.
#[derive(Debug)]
pub struct Permutation {
    /// The choices that it depends on: keys that cannot differ share it.
    pub key: Key,
    /// The shader, in naga's IR.
    pub module: Module,
    /// What naga's validator found out.
    pub info: ModuleInfo,
    /// What it asks of its host.
    pub reflection: Reflection,
}

impl Permutation {
    pub(crate) fn new(
        library: &Library,
        target: &Target,
        key: Key,
        linked: Linked,
    ) -> Result<Self, Fault> {
        let info = validate(&linked.module, target)
            .map_err(|error| validation_fault(library, target, &error))?;
        let reflection = reflect(&linked.module, &info, |handle| {
            let item = linked.owners.get(&handle)?;
            Some((library.source(item.module).path.clone(), item.name.clone()))
        });
        target.check(&reflection)?;
        Ok(Self { key, module: linked.module, info, reflection })
    }

    /// The shader as WGSL.
    ///
    /// # Errors
    /// Where naga cannot say it in WGSL.
    pub fn wgsl(&self) -> Result<String, Error> {
        let flags = naga::back::wgsl::WriterFlags::empty();
        naga::back::wgsl::write_string(&self.module, &self.info, flags)
            .map_err(|error| self.unwritable("WGSL", &error))
    }

    /// The shader as SPIR-V, all entry points in one module, clip space as WebGPU has it.
    ///
    /// # Errors
    /// Where naga cannot say it in SPIR-V.
    pub fn spirv(&self) -> Result<Vec<u32>, Error> {
        // Wgpu flips the viewport, not the shader; an engine that takes the words does the same.
        let mut options = naga::back::spv::Options::default();
        options.flags.remove(naga::back::spv::WriterFlags::ADJUST_COORDINATE_SPACE);
        options.flags.remove(naga::back::spv::WriterFlags::DEBUG);
        naga::back::spv::write_vec(&self.module, &self.info, &options, None)
            .map_err(|error| self.unwritable("SPIR-V", &error))
    }

    fn unwritable(&self, language: &str, error: &dyn std::error::Error) -> Error {
        Fault::new(Cause::Validation, format!("cannot be said in {language}: {error}"))
            .key(&self.key)
            .into()
    }
}

/// Validates against what `target` offers.
pub(crate) fn validate(
    module: &Module,
    target: &Target,
) -> Result<ModuleInfo, WithSpan<ValidationError>> {
    Validator::new(ValidationFlags::all(), target.capabilities()).validate(module)
}

fn validation_fault(
    library: &Library,
    target: &Target,
    error: &WithSpan<ValidationError>,
) -> Fault {
    // Naga's outermost error says in which function, the innermost says what is wrong.
    let mut chain = Vec::new();
    let mut next: Option<&dyn std::error::Error> = Some(error.as_inner());
    while let Some(error) = next {
        chain.push(error.to_string());
        next = error.source();
    }
    let message = chain.pop().unwrap_or_default();
    let mut fault = Fault::new(Cause::Validation, without_handles(&message));
    for (span, label) in error.spans() {
        if let Some(range) = span.to_range()
            && let Some((module, start)) = library.locate(range.start)
        {
            let source = library.source(module);
            let place = start..start + (range.end - range.start);
            fault = fault.at(source.place_labelled(place, without_handles(label)));
        }
    }
    for context in chain.iter().rev() {
        fault = fault.note(without_handles(context));
    }
    if message.to_lowercase().contains("capabilit") {
        fault = fault.note(format!("the target `{target}` does not offer it"));
    }
    fault
}

/// Naga numbers things by handles such as `[3]`, which mean nothing to an author.
fn without_handles(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(start) = rest.find('[') {
        let Some(length) = rest[start..].find(']') else { break };
        let inner = &rest[start + 1..start + length];
        let numeric = !inner.is_empty() && inner.bytes().all(|byte| byte.is_ascii_digit());
        out.push_str(rest[..start].trim_end_matches(if numeric { ' ' } else { '\0' }));
        if !numeric {
            out.push_str(&rest[start..=start + length]);
        }
        rest = &rest[start + length + 1..];
    }
    out.push_str(rest);
    out
}
