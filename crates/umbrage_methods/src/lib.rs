//! The shadow methods, one file each, and their registry.
//!
//! To add one here: a file in this folder with the method, a WESL module of the same name under
//! `methods/` in the shader library, the name on the axis `method`, and a line in [`registry`]. From
//! a crate of your own, register it yourself; nothing here is special.

pub mod basic;
pub mod basic_twin;
pub mod esm;
mod esm_twin;
pub mod hpsm;
mod job;
mod maps;
pub mod midpoint;
pub mod pssm;
pub mod pssm_twin;
mod slope;
mod twin_filter;

use umbrage_shadow::{Registry, RegistryError};

/// All methods of this crate.
///
/// # Errors
/// Never, as long as no two methods here share a name; a test says so.
pub fn registry() -> Result<Registry, RegistryError> {
    let mut registry = Registry::new();
    registry.register(basic::Basic)?;
    registry.register(pssm::Pssm)?;
    Ok(registry)
}
