//! Targets: what a device offers.

use std::fmt;

use naga::valid::Capabilities;

use crate::{
    Cause, Fault,
    reflect::{BindingKind, Reflection, Stage},
};

/// What permutations are validated against.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    name: String,
    capabilities: Capabilities,
}

impl Default for Target {
    fn default() -> Self {
        Self::webgpu()
    }
}

impl Target {
    /// What every WebGPU device offers: no optional feature, the default limits.
    pub fn webgpu() -> Self {
        // Cube arrays and per-sample shading are WebGPU's own, which naga counts as capabilities.
        let capabilities = Capabilities::CUBE_ARRAY_TEXTURES
            | Capabilities::MULTISAMPLED_SHADING
            | Capabilities::SHADER_FLOAT16_IN_FLOAT32;
        Self { name: "webgpu".to_owned(), capabilities }
    }

    /// A device of its own: `name` tells it from others, `capabilities` are what naga asks for. The
    /// limits are WebGPU's, which every device has at the least.
    pub fn new(name: impl Into<String>, capabilities: Capabilities) -> Self {
        Self { name: name.into(), capabilities }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What naga validates against.
    pub fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    /// Checks what naga does not: WebGPU's default limits.
    pub(crate) fn check(&self, reflection: &Reflection) -> Result<(), Fault> {
        let limit = |what: &str, found: u32, most: u32| {
            if found <= most {
                return Ok(());
            }
            let message = format!("{found} {what}, but the target `{}` has {most}", self.name);
            Err(Fault::new(Cause::Validation, message).note("use fewer, or pack them together"))
        };
        for binding in &reflection.bindings {
            let name = format!("{}::{}", binding.module, binding.name);
            limit(&format!("is the group of `{name}`; groups count from 0"), binding.group, 3)?;
            if let BindingKind::Uniform(layout) = &binding.kind {
                limit(&format!("bytes in the uniform buffer `{name}`"), layout.size, 65_536)?;
            }
        }
        for stage in [Stage::Vertex, Stage::Fragment, Stage::Compute] {
            let count = |kind: fn(&BindingKind) -> bool| {
                let used = reflection.bindings.iter().filter(|b| b.stages.contains(&stage));
                used.filter(|binding| kind(&binding.kind)).count() as u32
            };
            let place = format!("{stage:?} stage").to_lowercase();
            let textures = count(|kind| matches!(kind, BindingKind::Texture { .. }));
            limit(&format!("textures in the {place}"), textures, 16)?;
            let samplers = count(|kind| matches!(kind, BindingKind::Sampler { .. }));
            limit(&format!("samplers in the {place}"), samplers, 16)?;
            let uniforms = count(|kind| matches!(kind, BindingKind::Uniform(_)));
            limit(&format!("uniform buffers in the {place}"), uniforms, 12)?;
            let storage = count(|kind| matches!(kind, BindingKind::Storage { .. }));
            limit(&format!("storage buffers in the {place}"), storage, 8)?;
            let written = count(|kind| matches!(kind, BindingKind::StorageTexture { .. }));
            limit(&format!("storage textures in the {place}"), written, 4)?;
        }
        for entry in &reflection.entry_points {
            limit(&format!("vertex inputs of `{}`", entry.name), entry.inputs.len() as u32, 16)?;
        }
        Ok(())
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}
