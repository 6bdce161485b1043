//! The trait.

use std::{collections::BTreeMap, fmt::Display};

use crate::{Aabb, Light, Setting, Settings, ShadowPlan, View};

/// A shadow algorithm, for any light and any view: how the crate page's three parties meet.
///
/// # Units and spaces
/// A [`Frame`] is in world space: metres, right-handed, y up, f64. The plan is in *camera-relative*
/// space (world axes, metres from [`View::position`]), which is what shaders see, so that f32 is as
/// exact a thousand kilometres from the origin as it is there: subtract the view's position in f64,
/// multiply matrices in f64, and cast last. Clip space is WebGPU's. Settings give lengths in texels or
/// metres, never in normalised depth.
pub trait ShadowMethod: Send + Sync {
    /// The method's name: its value on the shader library's axis `method`, and its name in scenes.
    fn name(&self) -> &str;

    /// The numbers that a scene may set.
    fn settings(&self) -> &[Setting];

    /// The axes of the shader library that belong to this method: what a scene may choose for it.
    fn axes(&self) -> &[&str];

    /// Whether the method can shadow `light`. Asked before a plan, so that a scene's fault is told
    /// when the scene is read and not in some later frame.
    fn supports(&self, light: &Light) -> Support;

    /// Whether it plans by what each pixel sees, with these values of its axes: [`Frame::seen`]. To know it, the frame
    /// is drawn up to its depths, and waited for.
    fn wants_seen_depths(&self, axes: &BTreeMap<String, String>) -> bool {
        let _ = axes;
        false
    }

    /// What to draw this frame. A pure function of `frame`: the same frame has the same plan, and
    /// nothing is remembered between frames.
    ///
    /// A plan leaves nothing undefined that its shader reads: each part of a texture is drawn or
    /// cleared by a pass of this plan, or the constants keep the shader away from it.
    ///
    /// # Errors
    /// [`PlanError::Unsupported`] where [`supports`](Self::supports) says no;
    /// [`PlanError::Invalid`] where [`Frame::validate`] finds a fault, or a setting or an axis of
    /// the method's is missing. Never because a scene is empty, tiny, huge or badly placed.
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
    /// The least and the greatest view depth that a pixel sees, metres, where the method
    /// [wants them](ShadowMethod::wants_seen_depths); the first is greater than the second where none sees anything.
    pub seen: Option<[f64; 2]>,
}

/// Bounds of what may cast and what may receive, world space.
#[derive(Clone, Copy, Debug, Default)]
pub struct Casters<'a> {
    /// Objects whose material casts.
    pub casters: &'a [Aabb],
    /// Objects that may be seen in the light.
    pub receivers: &'a [Aabb],
}

impl Frame<'_> {
    /// Checks the view, the light and the bounds: what every method wants before it plans.
    ///
    /// # Errors
    /// The first fault of [`View::validate`] or [`Light::validate`], or a box that is not finite.
    pub fn validate(&self) -> Result<(), PlanError> {
        self.view.validate()?;
        self.light.validate()?;
        let kinds = [
            ("caster", self.casters.casters),
            ("receiver", self.casters.receivers),
        ];
        for (kind, boxes) in kinds {
            for (i, aabb) in boxes.iter().enumerate() {
                if !aabb.is_finite() {
                    return Err(PlanError::Invalid {
                        what: format!("the box of {kind} {i}"),
                        value: format!("{} to {}", aabb.min, aabb.max),
                        expected: "finite, and its corners in order".to_owned(),
                    });
                }
            }
        }
        Ok(())
    }
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

impl PlanError {
    /// [`PlanError::Invalid`] unless `holds`: `what` (a lowercase fragment) is `value`, but must be
    /// `expected`.
    ///
    /// # Errors
    /// Where `holds` is false.
    pub fn check(
        holds: bool,
        what: &str,
        value: impl Display,
        expected: &str,
    ) -> Result<(), PlanError> {
        if holds {
            return Ok(());
        }
        Err(Self::Invalid {
            what: what.to_owned(),
            value: value.to_string(),
            expected: expected.to_owned(),
        })
    }
}
