//! Shaders of the project's own parts on the CPU, in f64: oracles that their pictures are compared with.

mod basic;
mod esm;
mod filter;
mod midpoint;
mod pssm;
mod slope;

pub use basic::BasicTwin;
pub use midpoint::MidpointTwin;
pub use pssm::{Choice, PssmTwin};
