//! Links WGSL permutations from WESL modules in naga's IR.

mod axes;
mod bindings;
mod cache;
mod composer;
mod copy;
mod error;
mod features;
mod interface;
mod key;
mod library;
mod link;
mod link_file;
mod manifest;
mod names;
mod package;
mod permutation;
mod prepare;
mod project;
mod reach;
mod reflect;
mod ron_text;
mod source;
mod stubs;
mod target;
mod translate;
mod unit;
mod wgsl;

pub use axes::{Axes, Axis};
pub use cache::NAGA_VERSION;
pub use composer::{Composed, Composer, Source};
pub use error::{Cause, Error, Fault, Location};
pub use key::Key;
pub use library::Library;
pub use link_file::link_file;
pub use manifest::Manifest;
pub use package::Package;
pub use permutation::Permutation;
pub use reflect::{
    Binding, BindingKind, EntryPoint, Layout, Member, MemberType, Reflection, Scalar, Stage,
    TextureDimension, TextureSample, VertexInput,
};
pub use target::Target;
