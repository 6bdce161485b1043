//! Shared parts of the tests of every permutation: a scene that a key chooses, an oracle for its shadow
//! term that uses nothing of the GPU, and Dawn, which says what WebGPU takes.

mod air;
mod colored;
mod dawn;
mod drawn;
mod maps;
mod oracle;
mod random;
mod stage;

pub use colored::{colored_package, registry};
pub use dawn::Dawn;
pub use drawn::{covering, of_each_depth, used};
pub use maps::{Maps, Place};
pub use oracle::{Oracle, Pixel};
pub use random::{Random, random_shader};
pub use stage::{Stage, stage};
