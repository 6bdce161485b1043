//! The project's own parts of shadows, one file each, and their registry.
//!
//! | kind | folder | parts |
//! | --- | --- | --- |
//! | shadow methods | [`methods`] | `basic`, `pssm` |
//! | depth sources | [`depths`] | `nearest`, `midpoint` and its kin |
//! | filters | [`filters`] | `pcf`, `hpsm` and its kin, `esm` and its kin |
//!
//! To add one here: a file in its kind's folder, a WESL module of the same name in the folder of that name in the
//! shader library, its name on the axis of its kind, and a line in [`registry`]. From a crate of your own, register it
//! yourself; nothing here is special.

pub mod depths;
pub mod filters;
pub mod methods;

use umbrage_shadow::{Registry, RegistryError};

use depths::{midpoint::Midpoint, nearest::Nearest};
use filters::{esm::Esm, hpsm::Hpsm, pcf::Pcf};
use methods::{basic::Basic, pssm::Pssm};

/// All parts of this crate.
///
/// # Errors
/// Never, as long as no two parts of a kind share a name here; a test says so.
pub fn registry() -> Result<Registry, RegistryError> {
    let mut registry = Registry::new();
    registry.methods.add(Basic)?;
    registry.methods.add(Pssm)?;
    registry.depths.add(Nearest)?;
    for midpoint in Midpoint::ALL {
        registry.depths.add(midpoint)?;
    }
    registry.filters.add(Pcf)?;
    for hpsm in Hpsm::ALL {
        registry.filters.add(hpsm)?;
    }
    for esm in Esm::ALL {
        registry.filters.add(esm)?;
    }
    Ok(registry)
}
