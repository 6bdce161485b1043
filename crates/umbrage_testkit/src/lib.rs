//! Oracles and tools for tests of shadows.

mod conformance;
pub mod headless;
pub mod pictures;
pub mod twins;

pub use conformance::{Broken, Held, conformance};
pub use umbrage_measure::cases::Limits;
