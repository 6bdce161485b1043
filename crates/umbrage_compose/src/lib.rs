//! Links WGSL permutations from WESL modules in naga's IR.

mod error;
mod key;
mod reflect;

pub use error::{Cause, Error, Fault, Location};
pub use key::Key;
pub use reflect::*;
