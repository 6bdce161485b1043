//! Shadows as plain data, by the parts that make them: no GPU, no shader, no scene format.
//!
//! # The model
//! A *caster* throws shadow, a *receiver* shows it. A light asks one question of whatever computes
//! its shadow, the *shadow term* at a point: 1 where the light arrives, 0 in full shadow. Three kinds of part answer it:
//!
//! | part | does | its shader half implements | axis |
//! | --- | --- | --- | --- |
//! | [`ShadowMethod`] | fits maps to what is seen | `calc_shadow` of `package::interface::shadow` | `method` |
//! | [`DepthSource`] | fills them | `compare` of `package::interface::depths` | `depth` |
//! | [`Filter`] | samples them | `filter_map` of `package::interface::filter` | `filter` |
//!
//! A method may do all of it in a way of its own, as the one below. A part's two halves share a name: its value on the
//! axis of its kind in the shader library.
//!
//! Three parties meet in [`ShadowMethod::plan`]. The renderer knows the scene and brings a [`Frame`]:
//! the [`View`], the [`Light`], bounds of casters and receivers, and what the scene chose. The method answers with a
//! [`ShadowPlan`]: textures, samplers, passes, and the constants that its shader reads. What of it the depth source and
//! the filter add, they add in [`Frame::fill`], from the [`Maps`] that the method fitted. The shader reads textures, samplers
//! and constants by the names of their bindings, and nothing else ties the halves together. A [`Registry`] joins parts and
//! renderer; neither sees the other's crate.
//!
//! # Why the traits have their shape
//! - **A plan is data.** It is a pure function of the frame, so a method is tested without a GPU, a
//!   plan can be printed, compared and counted, and only one crate drives wgpu.
//! - **A plan is whole.** It names its textures every frame; the renderer keeps those that did not
//!   change. So a method has no life cycle: nothing to create, resize or drop.
//! - **Constants go by name.** A permutation that does not need a member has no room for it, and two
//!   permutations may lay the same members out differently. Only the linked shader knows, so only the
//!   renderer places bytes.
//! - **Settings are numbers, axes are choices.** A setting ends in constants and sizes: changing it
//!   costs a frame. An axis ends in another shader: changing it costs a permutation.
//! - **Boxes, not triangles.** Fitting a map needs bounds; what a method wants of triangles it asks for
//!   as a pass.
//!
//! # A tiny method
//! All that a directional light needs, with one map around everything:
//!
//! ```
//! use glam::DVec3;
//! use umbrage_shadow::*;
//! use wgpu_types::{FilterMode, TextureFormat};
//!
//! struct Whole;
//!
//! impl Part for Whole {
//!     fn name(&self) -> &str {
//!         "whole"
//!     }
//! }
//!
//! impl ShadowMethod for Whole {
//!     fn supports(&self, light: &Light) -> Support {
//!         match light.kind {
//!             LightKind::Directional { .. } => Support::Yes,
//!             _ => Support::No("only directional lights have one map".into()),
//!         }
//!     }
//!     fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
//!         frame.validate()?;
//!         let LightKind::Directional { direction } = frame.light.kind else {
//!             return Err(PlanError::Unsupported {
//!                 method: self.name().into(),
//!                 reason: "only directional lights have one map".into(),
//!             });
//!         };
//!         // Relative to the camera first, in f64: then nothing is far away.
//!         let boxes = frame.casters.casters.iter().chain(frame.casters.receivers);
//!         let corners: Vec<DVec3> =
//!             boxes.flat_map(|b| b.translate(-frame.view.position).corners()).collect();
//!         let lens = Lens::directional(direction);
//!         let places = || corners.iter().map(|p| lens.place(*p));
//!         let Some(rect) = Rect::from_points(places().map(|(xy, _)| xy)) else {
//!             return Ok(ShadowPlan::default());
//!         };
//!         let near = places().map(|(_, z)| z).fold(f64::INFINITY, f64::min) - 1.0;
//!         let far = places().map(|(_, z)| z).fold(f64::NEG_INFINITY, f64::max) + 1.0;
//!         let view_proj = lens.matrix(&rect, near, far).as_mat4();
//!         // Lenses' matrices give reversed depth.
//!         let order = DepthOrder::Reversed;
//!         Ok(ShadowPlan {
//!             textures: vec![TextureDesc {
//!                 empty: order.empty(),
//!                 ..TextureDesc::d2("whole_map", TextureFormat::Depth32Float, [1024; 2])
//!             }],
//!             samplers: vec![SamplerDesc {
//!                 name: "whole_sampler".into(),
//!                 filter: FilterMode::Linear,
//!                 compare: Some(order.nearer()),
//!             }],
//!             passes: vec![Pass::Casters(CasterPass {
//!                 shader: "caster".into(),
//!                 depth: Some(order.nearest("whole_map".into())),
//!                 colors: Vec::new(),
//!                 viewport: Viewport { x: 0, y: 0, width: 1024, height: 1024 },
//!                 cull: Cull::Hidden,
//!                 view_proj,
//!                 constants: Constants::new(),
//!                 casters: (0..frame.casters.casters.len()).collect(),
//!                 receivers: None,
//!             })],
//!             constants: Constants::new().with("view_proj", Value::Mat4(view_proj)),
//!             fetches_per_pixel: 1,
//!             // A bilinear fetch reads the texels whose middles are within one texel.
//!             filter_radius: 1.0,
//!             ..ShadowPlan::default()
//!         })
//!     }
//! }
//!
//! let mut registry = Registry::new();
//! registry.methods.add(Whole)?;
//! assert_eq!(registry.methods.get("whole")?.name(), "whole");
//! # Ok::<(), RegistryError>(())
//! ```
//!
//! [`Extent`] and [`Beam`] fit a map to less than everything: the receivers seen, and the casters
//! between them and the light. What a method would know of the GPU, such as what pixels see, it [asks](ShadowPlan::asks).

mod answers;
mod atlas;
mod bias;
mod bounds;
mod cells;
mod constants;
mod extent;
mod frame;
mod lens;
mod light;
mod maps;
mod number;
mod part;
mod plan;
mod registry;
mod settings;
mod splits;
mod view;
mod volume;

pub use answers::Answers;
pub use atlas::Atlas;
pub use bias::Bias;
pub use bounds::{Aabb, Frustum};
pub use cells::Cell;
pub use constants::{Constants, Value};
pub use extent::{Beam, Extent, Placed};
pub use frame::{Bounds, Casters, Frame, PlanError};
pub use lens::{Lens, Rect, light_basis};
pub use light::{Light, LightKind};
pub use maps::{DepthOrder, Map, MapRange, Maps};
pub use number::plain_number;
pub use part::{DepthSource, Filter, Part, ShadowMethod, Support};
pub use plan::{
    Blend, BufferContents, BufferDesc, CasterPass, ColorTarget, ComputePass, Contents, Cull,
    DepthTarget, MAX_QUESTIONS, MAX_REGIONS, Need, Pass, Reads, Region, SamplerDesc, ScreenPass,
    ShadowPlan, Slice, Source, TextureDesc, TextureShape, Viewport, Workgroups,
};
pub use registry::{Choice, Parts, Registry, RegistryError};
pub use settings::{Setting, Settings, SettingsError};
pub use splits::{MAX_SPLITS, split_depths};
pub use view::{Field, Projection, View, look_along};
pub use volume::{Side, Volume, overlap};
