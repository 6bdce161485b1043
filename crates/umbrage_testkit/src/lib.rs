//! Oracles and tools for tests of shadows.

pub mod headless;
pub mod pictures;
pub mod twins;
