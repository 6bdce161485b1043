//! The trait.

use std::collections::BTreeMap;

use crate::{Aabb, Light, Setting, Settings, ShadowPlan, View};

/// A shadow algorithm.
pub trait ShadowMethod: Send + Sync {
    /// The method's name: its value on the shader library's axis `method`, and its name in scenes.
    fn name(&self) -> &str;

    /// The numbers that a scene may set.
    fn settings(&self) -> &[Setting];

    /// The axes of the shader library that belong to this method: what a scene may choose for it.
    fn axes(&self) -> &[&str];

    /// Whether the method can shadow `light`.
    fn supports(&self, light: &Light) -> Support;

    /// What to draw this frame. A pure function of `frame`.
    ///
    /// # Errors
    /// Where the frame asks for what the method cannot do.
    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError>;
}

/// Whether a method can shadow a light.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Support {
    /// It can.
    Yes,
    /// It cannot, for this reason (a lowercase fragment).
    No(String),
}

/// What a method plans for: one light in one view.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The camera.
    pub view: &'a View,
    /// The light.
    pub light: &'a Light,
    /// What may cast and what may receive.
    pub casters: Casters<'a>,
    /// The method's settings, checked.
    pub settings: &'a Settings,
    /// The value of each of the method's axes.
    pub axes: &'a BTreeMap<String, String>,
}

/// Bounds of what may cast and what may receive, world space.
#[derive(Clone, Copy, Debug, Default)]
pub struct Casters<'a> {
    /// Objects whose material casts.
    pub casters: &'a [Aabb],
    /// Objects that may be seen in the light.
    pub receivers: &'a [Aabb],
}

/// Why a method could not plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The method does not support the light.
    #[error("method `{method}` cannot shadow this light: {reason}")]
    Unsupported {
        /// The method.
        method: String,
        /// Why.
        reason: String,
    },
    /// A number in the frame is not finite, or out of its range.
    #[error("{what} is {value}, but must be {expected}")]
    Invalid {
        /// Which number.
        what: String,
        /// As found.
        value: String,
        /// What is asked for.
        expected: String,
    },
}
