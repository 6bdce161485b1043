//! Targets: what a device offers.

mod limits;
mod table;

use std::{collections::BTreeMap, fmt};

use naga::valid::Capabilities;

pub use limits::Limit;

/// What permutations are validated against.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    name: String,
    capabilities: Capabilities,
    /// Limits that differ from WebGPU's.
    limits: BTreeMap<Limit, u64>,
    vertex_writes: bool,
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
        Self::new("webgpu", capabilities)
    }

    /// A custom device: `name` identifies it, and `capabilities` are naga's. Its limits are WebGPU's defaults,
    /// which every device offers, until others are set.
    pub fn new(name: impl Into<String>, capabilities: Capabilities) -> Self {
        Self {
            name: name.into(),
            capabilities,
            limits: BTreeMap::new(),
            vertex_writes: false,
        }
    }

    /// The same device with `value` for `limit`.
    #[must_use]
    pub fn with_limit(mut self, limit: Limit, value: u64) -> Self {
        self.limits.insert(limit, value);
        self
    }

    /// The same device, with vertex stages that may write to storage buffers and textures.
    #[must_use]
    pub fn with_vertex_writes(mut self) -> Self {
        self.vertex_writes = true;
        self
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What naga validates against.
    pub fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    /// The value of `limit`.
    pub fn limit(&self, limit: Limit) -> u64 {
        let given = self.limits.get(&limit).copied();
        given.unwrap_or_else(|| limit.webgpu())
    }

    /// Whether vertex stages may write to storage buffers and textures.
    pub fn has_vertex_writes(&self) -> bool {
        self.vertex_writes
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}
