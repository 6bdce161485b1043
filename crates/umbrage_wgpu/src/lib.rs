//! Executes shadow plans on anybody's wgpu device, in anybody's command encoder, with anybody's meshes.
//!
//! An engine has a light, a view, and casters. It asks an [`Executor`] for the light's [shadow](Executor::shadow): the chosen
//! parts plan, the plan's passes are recorded into the engine's encoder, the engine drawing its own casters where it is
//! asked to ([`Host::draw`]), and the engine gets the [`ShadowResources`] that its own shaders bind by name. Nothing here
//! knows scenes, files, pictures or cameras, and nothing waits.
//!
//! # Maps that stand
//! A mip level of a layer of a texture, or a buffer, is filled again only where that would change it: where one of the
//! passes into it is described otherwise than the last time, draws other casters or casters of another
//! [revision](Identity), or reads what is filled again, or the camera's depth in another revision.
//! So a frame in which nothing moved draws no map, whatever the method; no method knows. Where only casters differ, no more
//! is drawn again than they may reach ([`Run::Repaired`]). A caster that changes and does not say so is found by an
//! [audit](Executor::audit).
//!
//! # Frames
//! An engine calls [`Executor::begin_frame`] once a frame, when the frame before is submitted. What it binds for its own
//! shaders it may have from the same [`Binder`], which keeps blocks and bind groups.
//!
//! # Shaders of passes
//! A pass names its shader by a value of the shader library's axis `pass`, whose module has the entry points: one vertex and
//! at most one fragment stage, or one compute stage, of any names. It reads by name, whatever the numbers of groups:
//!
//! | pass | what its shader may read |
//! | --- | --- |
//! | casters | the uniform block `frame` with `view_proj` (world, relative to the camera, to clip space), and further uniform blocks in its group, with the pass's constants; all other groups, and vertices, are the engine's: ours are in `package::passes::caster` |
//! | full-screen, compute | textures, samplers and storage buffers of the plan, under the names that [`Reads`](umbrage_shadow::Reads) gives them; uniform blocks with its constants, and the block `light` |
//! | the engine's own | textures, samplers, buffers and constants of the [`ShadowResources`] |
//!
//! A full-screen pass draws three vertices of one triangle, by their numbers. A compute pass stores to what it `writes`.
//! Textures are bound whole, or by a [layer or a mip level](umbrage_shadow::Source). What a pass reads has contents, or an
//! earlier pass filled it, and no pass reads what it writes. A pass without casters may also read the camera's depth, where the [job](Job::camera_depth) gives it.
//!
//! # Questions
//! A plan may end in a question: what buffers hold that its passes write. The light has no shadow then, but
//! [`Executed::question`]. The engine submits, maps [`Question::buffer`] for reading, hands the bytes to
//! [`Question::answer`], and asks for the same light's shadow again, with the answers in
//! [`Frame::answers`](umbrage_shadow::Frame::answers). When, is its choice:
//!
//! - *In the same frame*: it submits, waits, and asks again into another encoder. Several lights' questions go in one
//!   submission.
//! - *A frame later*: it asks twice in each frame, first without answers, which records the question of this frame, and then
//!   with the answers of the frame before, where there are any, which gives a shadow. Nothing waits, and shadows are planned by
//!   what was seen a frame ago. Passes that both plans have are run once.
//!
//! # An engine's own shaders
//! An engine composes a permutation for a surface and a light's [choices](CheckedShadow::choices), or one for a surface and
//! several lights ([`Composer::compose_all`](umbrage_compose::Composer::compose_all)), and binds the lights' resources by
//! name with its [`Binder`]. `examples/own_renderer` is such an engine, with two lights in one shader, in 150 lines.
//!
//! # Frames that do not wait for shaders
//! A pipeline is made on first need, which holds up the frame. Where that must not be, an engine says what is
//! [wanted](Wanted) and asks [`Executor::prepare`] whether it is [ready](Readiness); while it is not, workers compose and
//! compile it, and the engine draws what it has chosen instead: nothing, or another permutation that reads the same maps, such
//! as one with a narrower filter. [`Executor::begin_frame`] takes in what was made, so that all passes of a frame agree on what
//! is ready. What waits, and what is kept, is bounded: [`Executor::backlog`] tells what there was no room for. Passes of plans
//! are waited for.
//!
//! # Encoders that are not submitted
//! A recorded pass counts as drawn. Where an encoder is dropped, [forget](Executor::forget) the light. Of a device that is
//! lost, wgpu tells the engine's error handler, here as elsewhere; another device has another executor. Encoders must be of
//! the executor's device: wgpu has no way to ask one whose it is, and panics itself where it is another's.

mod ahead;
mod area;
mod asked;
mod audit;
mod bind;
mod check;
pub mod device;
mod error;
mod execute;
mod host;
mod kept;
mod pack;
mod program;
mod question;
mod record;
mod resources;
mod shadow;
mod sides;
mod targets;
mod touches;
mod workers;

pub use ahead::{Backlog, Readiness, Wanted};
pub use audit::Audit;
pub use bind::{Binder, Gpu, Groups, Resource};
pub use error::{Error, TooLarge};
pub use execute::{CameraDepth, Executed, Executor, Job, Run};
pub use host::{Drawn, Draws, Host, Identity, Prepared, Times};
pub use pack::{PackError, pack, pack_buffer};
pub use program::{
    ColorState, Computation, DrawState, MAX, Pipeline, Program, STORED, Unfiltered, Vertices,
    blend_state, reads_facing, vertices_read,
};
pub use question::Question;
pub use resources::{ShadowResources, size, unfiltered};
pub use shadow::{CheckedShadow, Shadow, ShadowError, check_value};
pub use sides::Sides;
