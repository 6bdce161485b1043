//! Targets by their names in manifests and arguments.

use anyhow::{Context, Result, bail};
use umbrage::compose::Target;

/// All names.
pub(crate) const NAMES: [&str; 2] = ["webgpu", "vulkan"];

/// The target called `name`. Only `vulkan`, which is what this machine offers, asks for an adapter.
pub(crate) fn target(name: &str) -> Result<Target> {
    match name {
        "webgpu" => Ok(Target::webgpu()),
        "vulkan" => vulkan().context(
            "the target `vulkan` is this machine's Vulkan adapter, and there is none; install a driver, or \
             choose the target `webgpu`",
        ),
        _ => bail!("there is no target `{name}`; choose one of {}", NAMES.join(", ")),
    }
}

/// All that this machine's Vulkan adapter offers through wgpu.
fn vulkan() -> Result<Target, wgpu::RequestAdapterError> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::VULKAN,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let options = wgpu::RequestAdapterOptions::default();
    let adapter = pollster::block_on(instance.request_adapter(&options))?;
    let capabilities = wgpu::wgc::device::features_to_naga_capabilities(
        adapter.features(),
        adapter.get_downlevel_capabilities().flags,
    );
    Ok(Target::new("vulkan", capabilities))
}
