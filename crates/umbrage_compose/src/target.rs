//! Targets: what a device offers.

use std::fmt;

use naga::valid::Capabilities;

use crate::{
    Cause, Fault, Library,
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
        Self {
            name: "webgpu".to_owned(),
            capabilities,
        }
    }

    /// A device of its own: `name` tells it from others, `capabilities` are what naga asks for. The
    /// limits are WebGPU's, which every device has at the least.
    pub fn new(name: impl Into<String>, capabilities: Capabilities) -> Self {
        Self {
            name: name.into(),
            capabilities,
        }
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
    pub(crate) fn check(&self, library: &Library, reflection: &Reflection) -> Result<(), Fault> {
        for binding in &reflection.bindings {
            let at = |fault: Fault| match library.module(&binding.module) {
                Some(module) => fault.at(library.source(module).find(&binding.name)),
                None => fault,
            };
            self.limit("bind groups are needed", binding.group + 1, 4)
                .map_err(at)?;
            if let BindingKind::Uniform(layout) = &binding.kind {
                self.limit("bytes are in a uniform buffer", layout.size, 65_536)
                    .map_err(at)?;
            }
        }
        for stage in [Stage::Vertex, Stage::Fragment, Stage::Compute] {
            self.check_stage(library, reflection, stage)?;
        }
        for entry in &reflection.entry_points {
            let what = format!("vertex inputs are read by `{}`", entry.name);
            self.limit(&what, entry.inputs.len() as u32, 16)?;
        }
        Ok(())
    }

    fn check_stage(
        &self,
        library: &Library,
        reflection: &Reflection,
        stage: Stage,
    ) -> Result<(), Fault> {
        type IsKind = fn(&BindingKind) -> bool;
        let kinds: [(&str, u32, IsKind); 5] = [
            ("textures are read", 16, |kind| {
                matches!(kind, BindingKind::Texture { .. })
            }),
            ("samplers are used", 16, |kind| {
                matches!(kind, BindingKind::Sampler { .. })
            }),
            ("uniform buffers are read", 12, |kind| {
                matches!(kind, BindingKind::Uniform(_))
            }),
            ("storage buffers are used", 8, |kind| {
                matches!(kind, BindingKind::Storage { .. })
            }),
            ("storage textures are used", 4, |kind| {
                matches!(kind, BindingKind::StorageTexture { .. })
            }),
        ];
        for (what, most, kind) in kinds {
            let used = reflection
                .bindings
                .iter()
                .filter(|binding| binding.stages.contains(&stage));
            let used: Vec<_> = used.filter(|binding| kind(&binding.kind)).collect();
            let what = format!(
                "{what} in the {} stage",
                format!("{stage:?}").to_lowercase()
            );
            self.limit(&what, used.len() as u32, most)
                .map_err(|fault| {
                    let last = used
                        .last()
                        .and_then(|last| Some((library.module(&last.module)?, last)));
                    match last {
                        Some((module, last)) => fault.at(library.source(module).find(&last.name)),
                        None => fault,
                    }
                })?;
        }
        Ok(())
    }

    fn limit(&self, what: &str, found: u32, most: u32) -> Result<(), Fault> {
        if found <= most {
            return Ok(());
        }
        let message = format!("{found} {what}, but the target `{}` has {most}", self.name);
        Err(Fault::new(Cause::Validation, message).note("use fewer, or pack them together"))
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}
