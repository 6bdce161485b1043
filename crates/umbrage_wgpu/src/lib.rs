//! Executes shadow plans on anybody's wgpu device, in anybody's command encoder, with anybody's meshes.
//!
//! An engine has a light, a view, and casters. It asks an [`Executor`] for the light's [shadow](Executor::shadow): the chosen
//! parts plan, the plan's passes are recorded into the engine's encoder, the engine drawing its own casters where it is
//! asked to ([`Host::draw`]), and the engine gets the [`ShadowResources`] that its own shaders bind by name. Nothing here
//! knows scenes, files, pictures or cameras, and nothing waits.
//!
//! # What is not drawn again
//! A texture is filled again only where that would change it: where one of the passes into it is described otherwise than
//! the last time, draws other casters or casters of another [revision](Identity), or reads a texture that is filled again.
//! So a frame in which nothing moved draws no map, whatever the method; no method knows.
//!
//! What was recorded counts as drawn. Where an encoder is dropped, or the device is lost, [forget](Executor::forget) it.

mod bind;
pub mod device;
mod error;
mod execute;
mod host;
mod pack;
mod program;
mod record;
mod resources;
mod shadow;

pub use bind::{Gpu, Resource};
pub use error::{Error, TooLarge};
pub use execute::{Executed, Executor, Job, Run};
pub use host::{Draws, Host, Identity, Prepared, Times};
pub use pack::{PackError, pack, pack_buffer};
pub use program::{
    ADD, ColorState, Computation, DrawState, MAX, MULTIPLY, Pipeline, Program, STORED, reads_facing,
};
pub use resources::{ShadowResources, size, unfiltered};
pub use shadow::{CheckedShadow, Shadow, ShadowError, check_value};
