//! Links WGSL permutations from WESL modules, in naga's IR.
//!
//! # The model
//! A [`Package`] is a folder of *modules*: WGSL files with WESL's imports and conditions
//! (<https://wesl-lang.dev>). A module in the folder `interface` is a contract: others call its functions,
//! and a *binding* says which module's bodies they get. A package's `axes.ron` names the choices: an
//! [`Axis`] has values, and a value asks the linker for a root module, for bindings, and for features. A
//! value may *need* a capability that a value of another axis *provides*; combinations that lack one are illegal. A
//! [`Key`] is a legal value for each axis, a [`Manifest`] says which keys exist, and a [`Composer`] turns a key
//! into a [`Permutation`]: the module that is left when everything else is left out.
//!
//! ```
//! use umbrage_compose::{Composer, Library, Package, Target};
//!
//! # fn main() -> Result<(), umbrage_compose::Error> {
//! let files = [
//!     ("axes.ron", r#"(axes: {
//!         "pass": (values: { "flat": (root: "package::flat") }),
//!         "glow": (default: "off", values: {
//!             "off": (bind: { "package::interface::glow": "package::interface::glow" }),
//!             "on": (bind: { "package::interface::glow": "package::glow" }),
//!         }),
//!     })"#),
//!     ("interface/glow.wesl", "fn glow(at: vec2f) -> f32 { return 0.0; }"),
//!     ("glow.wesl", "fn glow(at: vec2f) -> f32 { return length(at) * 0.01; }"),
//!     ("flat.wesl", "
//!         import package::interface::glow::glow;
//!         @fragment fn fs_flat(@builtin(position) at: vec4f) -> @location(0) vec4f {
//!             return vec4f(glow(at.xy));
//!         }
//!     "),
//! ];
//! let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
//! let library = Library::new([Package::from_sources("demo", "demo", files)?])?;
//! let key = library.key([("pass", "flat"), ("glow", "on")])?;
//!
//! let composer = Composer::new(library, Target::webgpu());
//! let composed = composer.compose(&key)?;
//! assert!(composed.permutation.wgsl()?.contains("length"));
//! # Ok(())
//! # }
//! ```
//!
//! # How it links
//! 1. A module is parsed by `wgsl-parse`. Under some features, what is disabled is *blanked out* with
//!    spaces, imports too, and `::` in written paths becomes `·`, which takes as many bytes: every byte
//!    that stays keeps its place, so every span that naga gives is one in the author's file.
//! 2. After the author's text come stand-ins for what it takes from others: a function's signature with
//!    a zero result, copies of types, constants and resources. Naga parses that, once for each text.
//! 3. To link a key, the root's entry points and what they reach are copied into one module. A function
//!    keeps its expressions' numbers, so a copy is a clone in which only handles that lead outside it
//!    are put right. Calls of stand-ins lead to the real functions, through the bindings.
//! 4. Binding numbers are the authors' where they are free, and otherwise the least free ones, in the
//!    order of the modules' paths: the same for everyone, always.
//! 5. Naga validates the module against the target. Rules of our own (`rules`) check what naga does not: aliases,
//!    flow, constants, stages, limits. Uniformity is decided by WGSL's specification (`uniformity`). Diagnostic
//!    filters hold where their authors wrote them, and are printed again. A function that was found valid is not
//!    checked again where its callees look the same to it (`checker`).
//!
//! Before any of that, a key is *projected*: following imports and bindings from the root notes each
//! feature that is looked up and each binding that is needed, and choices that none of these depend on
//! are put at their defaults. Keys of one projection are one permutation.
//!
//! # Names that a host can rely on
//! In a permutation's [WGSL](Permutation::wgsl), entry points, overrides and structs' members keep their authors'
//! names, and resources have the names given in the [`Reflection`]. Overrides stay overrides, including those
//! computed from other overrides; in [SPIR-V](Permutation::spirv) they are constants at their defaults. It is a
//! fault where two different overrides have the same name or number, and where two implementations of an interface
//! side by side would share a resource.
//!
//! # Counted fetches
//! A pixel's cost is best counted where it is spent. A value of an axis may ask that a function be
//! called before each texture fetch:
//! ```ron
//! "fetch_count": (
//!     root: "package::flat",
//!     features: ["COUNT_FETCHES"],
//!     count_fetches: (call: "package::fetches::count_fetch", except: ["package::material"]),
//! )
//! ```
//! In what its fragment stages reach, outside the modules excepted, each fetch is then paired with a
//! call before it in the same run of plain statements; one that is not is a fault, at its own place.
//!
//! # Several keys in one shader
//! A pass that adds up lights names an interface with `each`:
//! ```ron
//! "illumination": (root: "package::illumination", each: "package::interface::lit", bind: { … })
//! ```
//! [`Composer::compose_all`] makes one shader of several keys: a call through that interface, such as
//! `add_light(point, &sum);`, calls the implementation of each key in turn. Each has bindings, features and resources of
//! its own, told apart by [`Binding::instance`]; what the pass reaches otherwise is there once.
//!
//! # Faults
//! Every fault says what is wrong, where (file, line, column, source line), and what to do; and in which
//! permutation. See [`Fault`].
#![doc = ""]
#![doc = include_str!("../support.md")]

mod axes;
mod bindings;
mod bits;
mod cache;
mod capabilities;
mod checker;
mod composer;
mod copy;
mod cover;
mod diagnostics;
mod error;
mod excerpt;
mod explain;
mod extensions;
mod features;
mod fetches;
mod file;
mod instances;
mod interface;
mod key;
mod lacking;
mod library;
mod limits;
mod link;
mod link_file;
mod lints;
mod manifest;
mod names;
mod outputs;
mod overrides;
mod pack;
mod package;
mod parts;
mod pass;
mod permutation;
mod prepare;
mod project;
mod reach;
pub mod record;
mod reflect;
mod ron_text;
mod rules;
mod several;
mod source;
mod space;
mod store;
mod stubs;
mod target;
mod translate;
mod uniformity;
mod unit;
mod wgsl;
mod when;
mod whole;
mod words;

pub use axes::{Axes, Axis};
pub use cache::NAGA_VERSION;
pub use composer::{Checked, Composed, Composer, Nearness, Source};
pub use error::{Cause, Error, Fault, Location};
pub use explain::{Explanation, Feature, Reason};
pub use key::{Key, ProjectedKey};
pub use library::Library;
pub use link_file::link_file;
pub use lints::{Lint, Linted};
pub use manifest::Manifest;
pub use outputs::{Language, Output};
pub use overrides::{InSpirv, Override, OverrideType};
pub use pack::{Filled, Header, Pack, PackWriter, Row};
pub use package::Package;
pub use pass::{Blend, Depth, Factor, Over, Pass, Purpose};
pub use permutation::Permutation;
pub use reflect::{
    Binding, BindingKind, EntryPoint, Layout, Member, MemberType, Reflection, Scalar, Stage,
    TextureDimension, TextureSample, VertexInput,
};
pub use ron_text::RonFile;
pub use space::{Selection, ValueId, Variant, Variants};
pub use store::{Kind, Look, Store};
pub use target::{Limit, Target};
pub use when::When;
pub use whole::{sweep_beside, write_whole};
