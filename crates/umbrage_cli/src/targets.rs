//! Targets by their names in manifests and arguments.

use anyhow::{Context, Result, bail};
use umbrage::{compose::Target, render::Gpu};

/// All names.
pub(crate) const NAMES: [&str; 2] = ["webgpu", "vulkan"];

/// The target called `name`. Only `vulkan`, which is what this machine offers, asks for an adapter.
pub(crate) fn target(name: &str) -> Result<Target> {
    match name {
        "webgpu" => Ok(Target::webgpu()),
        "vulkan" => Gpu::vulkan_target().context(
            "the target `vulkan` is what this machine's adapter offers; `webgpu` needs none",
        ),
        _ => bail!(
            "there is no target `{name}`; choose one of {}",
            NAMES.join(", ")
        ),
    }
}
