//! What tests of shadows are held against.

pub mod pictures;
pub mod twins;
