//! Filters: how shadow maps are sampled.

pub mod esm;
pub mod hpsm;
pub mod pcf;
mod width;

pub use width::Width;
