//! What the tests of every permutation share: a scene that a key chooses, and an oracle for its shadow
//! term that uses nothing of the GPU.

mod air;
mod colored;
mod maps;
mod oracle;
mod stage;

pub use colored::{colored_package, registry};
pub use maps::{Maps, Place};
pub use oracle::{Oracle, Pixel};
pub use stage::{Stage, stage};
