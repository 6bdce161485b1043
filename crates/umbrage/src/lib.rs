//! Shader permutations and shadow methods for wgpu.
//!
//! A surface shader does not know its light, and a light does not know how its shadow is computed:
//! each asks the next through a small contract, and the last contract is one function,
//! `calc_shadow(position_ws) -> f32`. This page shows what follows for an engine developer: a shadow
//! method of your own, in a crate of your own, without touching anything here.
//!
//! | module | what it is for |
//! | --- | --- |
//! | [`compose`] | packages of WESL modules, axes and keys, linking, validation, caches |
//! | [`shadow`] | what shadows are made of, [methods](shadow::ShadowMethod), [depth sources](shadow::DepthSource) and [filters](shadow::Filter); lights, views, maps, plans: plain data |
//! | [`methods`] | the parts that come with Umbrage |
//! | [`execute`] | plans on a device, in an encoder, with meshes of your engine's own |
//! | [`render`] | scenes, and a test bed that renders them |
//!
//! # A method in two halves
//! Our method is a canopy: whatever lies below a height is in shadow. It draws no map, so that nothing
//! hides how the parts meet.
//!
//! **The shader half** implements `interface::shadow`: a function of the interface's name and signature.
//! Whatever it reads beyond its argument it declares; the numbers come from the Rust half, by name. Positions
//! are relative to the camera, so a height must be, too:
//!
//! ```wgsl
#![doc = include_str!("../tutorial/canopy.wesl")]
//! ```
//!
//! An `axes.ron` beside it gives the library's axis `method` one more value. `package` is the package
//! that the file lies in:
//!
//! ```ron
#![doc = include_str!("../tutorial/axes.ron")]
//! ```
//!
//! **The Rust half** says each frame what has to be drawn before that shader can run (here, nothing),
//! and what the shader reads. [`plan`](shadow::ShadowMethod::plan) is a pure function of plain data:
//! it is tested without a GPU.
//!
//! ```
//! use umbrage::{
//!     compose::{Composer, Error, Library, Package, Target},
//!     shadow::{Constants, Frame, Light, Part, PlanError, Setting, ShadowMethod, ShadowPlan, Support, Value},
//! };
//!
//! struct Canopy;
//!
//! const HEIGHT: Setting = Setting {
//!     name: "height",
//!     doc: "where the canopy hangs; metres above the world's origin",
//!     min: -1e6,
//!     max: 1e6,
//!     default: 0.5,
//!     whole: false,
//! };
//!
//! impl Part for Canopy {
//!     fn name(&self) -> &str {
//!         "canopy"
//!     }
//!     fn settings(&self) -> &[Setting] {
//!         &[HEIGHT]
//!     }
//! }
//!
//! impl ShadowMethod for Canopy {
//!     fn supports(&self, _: &Light) -> Support {
//!         Support::Yes
//!     }
//!     fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
//!         // Relative to the camera, and in f64 until it is.
//!         let height = frame.settings.get("height") - frame.view.position.y;
//!         let constants = Constants::new().with("height", Value::F32(height as f32));
//!         Ok(ShadowPlan { constants, ..ShadowPlan::default() })
//!     }
//! }
//!
//! /// Umbrage's shaders and ours: one library.
//! fn library() -> Result<Library, Error> {
//!     let files = [
//!         # /*
//!         ("canopy.wesl", include_str!("canopy.wesl")),
//!         ("axes.ron", include_str!("axes.ron")),
//!         # */
//!         # ("canopy.wesl", include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/tutorial/canopy.wesl"))),
//!         # ("axes.ron", include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/tutorial/axes.ron"))),
//!     ];
//!     let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
//!     let ours = Package::from_sources("canopy", "shaders", files)?;
//!     Library::new([umbrage::shader_package()?, ours])
//! }
//!
//! // A permutation is a value for each axis that is not to have its default.
//! let composer = Composer::new(library()?, Target::webgpu());
//! let choices = [("pass", "illumination"), ("light", "spot"), ("method", "canopy")];
//! let key = composer.library().key(choices)?;
//! let permutation = composer.compose(&key)?.permutation;
//! assert!(permutation.wgsl()?.contains("canopy"));
//!
//! // And a scene, drawn with it.
//! use std::sync::Arc;
//! use umbrage::render::{Gpu, RenderOptions, Renderer, Scene, Shadow};
//!
//! let mut registry = umbrage::methods::registry()?;
//! registry.methods.add(Canopy)?;
//! let mut renderer = Renderer::new(Arc::new(Gpu::new()?), Arc::new(composer), registry);
//! let scene = Scene::load("../../examples/scenes/bunny_sun.ron")?;
//! let options = RenderOptions {
//!     width: 64,
//!     height: 36,
//!     shadow: Shadow::new("canopy"),
//!     ..RenderOptions::default()
//! };
//! let rendered = renderer.render(&scene, &options)?;
//! assert!(rendered.report.permutations.iter().any(|used| used.key.get("method") == Some("canopy")));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! In a scene file a light chooses the method by its name, with its settings:
//! `shadow: (method: "canopy", settings: { "height": 0.8 })`.
//!
//! # Before you ship
//! - **Check every permutation**: `umbrage check --package DIR` validates all permutations of your package and of those that
//!   it names, without a GPU, and tells a fault once, in your file, with the smallest choice of axes that triggers it.
//! - **Take the command along**: ten lines give your crate all of `umbrage` with your parts in it (`umbrage_cli::main`), so
//!   that they are rendered, compared with the truth and held to the hard cases like ours.
//! - **Count what you fetch**: before each texture fetch of your method stands
//!   `@if(COUNT_FETCHES) count_fetch();`, imported from `umbrage::common::fetches`. A picture of
//!   [`What::Fetches`](render::What::Fetches) has the counts; a fetch without one is refused, by its line.
//! - **Test the plan**: it is data. Lights straight above, empty scenes and cameras far from the origin
//!   are worth a test each.
//! - **An axis or a setting?** What changes the shader is an axis, and costs a permutation; what ends in
//!   a constant or a size is a setting, and costs nothing.
//!
//! A method with maps to learn from is [`methods::methods::basic`]; `examples/vsm` is a filter of a crate of its own. How the
//! traits came to have their shape is told in [`shadow`].

/// Vectors and matrices, as all of Umbrage has them.
pub use glam;
/// The device, as all of Umbrage drives it.
pub use wgpu;
/// Formats, samplers and the like, as plans have them.
pub use wgpu_types;

pub use umbrage_compose as compose;
pub use umbrage_methods as methods;
pub use umbrage_render as render;
pub use umbrage_shader_lib::package as shader_package;
pub use umbrage_shadow as shadow;
pub use umbrage_wgpu as execute;

/// Umbrage's own shaders, as a library to compose from: nothing is read from disk.
///
/// # Errors
/// Where the embedded package does not fit together; the project's tests keep it from happening.
pub fn shader_library() -> Result<compose::Library, compose::Error> {
    compose::Library::new([shader_package()?])
}
