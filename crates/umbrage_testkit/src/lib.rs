//! What tests of shadows are held against.

pub mod twins;
