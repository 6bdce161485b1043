//! Renders shadowed scenes through wgpu: a test bed on top of [`umbrage_wgpu`], which executes plans for any engine.
//!
//! A [`Scene`] is plain data in f64, loaded from a scene file or a glTF model. A [`Renderer`] turns
//! it into a [`Rendered`] picture, or into [what] else a pixel is asked for: the bare shadow term of
//! each light, the texture fetches that it takes, or the triangle that is seen. A shaded picture comes
//! about so:
//!
//! 1. The objects that the camera may see are found, and for each light those of them that it may reach.
//! 2. For each light that has a shadow method, the method plans, and the plan is executed: casters
//!    into shadow maps.
//! 3. A base pass lays down depth and ambient light; then one illumination pass a light adds up, or
//!    [one for all](Path::ForwardAll). In the [mask path](Path::Mask) each light's shadow term is found before, in a pass over the picture.
//!
//! The shaders for that are chosen object by object: a permutation is composed when an object
//! that needs it first lies in the region of a light, and never before. Layouts of bind groups,
//! uniform blocks and vertex inputs come from what the linker says of the permutation; the renderer
//! knows bindings by name alone. It knows no shadow method either: those come from a registry.
//!
//! Positions on the device are relative to the camera, whose own position stays in f64. The camera's
//! depth is reversed: 1 near, 0 far. Both sides of a triangle are seen and lit.
//!
//! Its cost is in the [`Report`]. Pipelines, meshes, textures, shadow maps and bind groups are kept from one
//! picture to the next, and let go with their scene. An engine's loop [draws](Renderer::draw) into its own texture, and waits
//! for nothing.
//!
//! [what]: What
//!
//! ```no_run
//! use std::sync::Arc;
//! use umbrage_compose::{Composer, Library, Target};
//! use umbrage_render::{Gpu, RenderOptions, Renderer, Scene};
//!
//! let library = Library::new([umbrage_shader_lib::package()?])?;
//! let composer = Arc::new(Composer::new(library, Target::default()));
//! let methods = umbrage_methods::registry()?;
//! let mut renderer = Renderer::new(Arc::new(Gpu::new()?), composer, methods);
//!
//! let scene = Scene::load("examples/scenes/bunny_sun.ron")?;
//! let rendered = renderer.render(&scene, &RenderOptions::default())?;
//! rendered.save_png("bunny.png")?;
//! for used in &rendered.report.permutations {
//!     println!("{} for {}: {:?}", used.key, used.object, used.source);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod gpu;
mod normals;
mod picture;
mod renderer;
mod scene;

pub use error::RenderError;
pub use gpu::{Gpu, GpuError};
pub use picture::{Decision, PassTime, PermutationUse, Picture, Rendered, Report};
pub use renderer::{MOST_SHAFT_STEPS, Meanwhile, Path, RenderOptions, Renderer, StandIn, What};
pub use scene::{
    Camera, Image, LeftOut, Level, Material, Medium, Mesh, Object, Scene, SceneError, SceneLight,
    Staging, Texture, Wrap,
};
pub use umbrage_wgpu::{CheckedShadow, PackError, Shadow, ShadowError, pack, pack_buffer};
