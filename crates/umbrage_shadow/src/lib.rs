//! What a shadow method is, as plain data: no GPU, no shader, no scene format.
//!
//! (crate page: written last)

mod constants;
mod light;
mod method;
mod plan;
mod settings;
mod view;

pub use constants::{Constants, Value};
pub use light::{Light, LightKind};
pub use method::{Casters, Frame, PlanError, ShadowMethod, Support};
pub use plan::{
    CasterPass, DepthTest, Pass, SamplerDesc, ShadowPlan, TextureDesc, TextureShape, Viewport,
};
pub use settings::{Setting, Settings, SettingsError};
pub use view::{Aabb, Frustum, Projection, View};
