//! What tests of shadows are held against.

pub mod headless;
pub mod pictures;
pub mod twins;
