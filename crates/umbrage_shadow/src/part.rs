//! The three kinds of part that make a shadow.

use crate::{Frame, Light, Maps, PlanError, Setting, ShadowPlan};

/// A part that makes a shadow: what a scene may choose of it.
pub trait Part: Send + Sync {
    /// The part's name: its value on the shader library's axis of its kind, `method`, `depth` or `filter`, and its
    /// name in scenes.
    fn name(&self) -> &str;

    /// The numbers that a scene may set.
    fn settings(&self) -> &[Setting] {
        &[]
    }

    /// The axes of the shader library that belong to this part: what a scene may choose for it. Several parts may share
    /// one.
    fn axes(&self) -> &[&str] {
        &[]
    }
}

/// Fits maps to what is seen, or finds a light's shadow in a way of its own: how the crate page's three parties meet.
///
/// # Units and spaces
/// A [`Frame`] is in world space: metres, right-handed, y up, f64. The plan is in *camera-relative*
/// space (world axes, metres from [`View::position`](crate::View::position)), which is what shaders see, so that f32 is as
/// exact a thousand kilometres from the origin as it is there: subtract the view's position in f64,
/// multiply matrices in f64, and cast last. Clip space is WebGPU's. Settings give lengths in texels or
/// metres, never in normalised depth.
///
/// # Its maps' depths and filter
/// A method with `depth` and `filter` among its [axes](Part::axes) has its maps filled by a [`DepthSource`] and sampled
/// by a [`Filter`] of anyone's: it hands [`Maps`] to [`Frame::fill`], and its shader calls `filter_map` of the interface
/// `package::interface::filter`. So it needs to know none of them.
pub trait ShadowMethod: Part {
    /// Whether the method can shadow `light`. Asked before a plan, so that a scene's fault is told
    /// when the scene is read and not in some later frame.
    fn supports(&self, light: &Light) -> Support;

    /// Textures, passes and constants for this frame. A pure function of `frame`: the same frame has the same plan, and
    /// nothing is remembered between frames. What a method would know of the GPU it [asks](ShadowPlan::asks), and is told in
    /// [`Frame::answers`].
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

/// Fills shadow maps: with the nearest depths, or with others that lie inside of what casts. Its shader half is the
/// function `compare` of the interface `package::interface::depths`.
pub trait DepthSource: Part {
    /// Whether the depths that it holds keep receivers from shading themselves, so that a receiver's own depth is
    /// compared as it is.
    fn holds_bias(&self) -> bool {
        false
    }

    /// Texture fetches of one comparison.
    fn fetches(&self) -> u32 {
        1
    }

    /// Adds to `plan` the textures that hold the depths of `maps`, the passes that fill them, and what comparing reads.
    ///
    /// # Errors
    /// [`PlanError::Invalid`] where an axis or a setting is not as it must be.
    fn fill(&self, frame: &Frame<'_>, maps: &Maps, plan: &mut ShadowPlan) -> Result<(), PlanError>;
}

/// Samples shadow maps: what share of the light passes about a receiver's place. Its shader half is the function
/// `filter_map` of the interface `package::interface::filter`.
pub trait Filter: Part {
    /// How far from a receiver's place in map `number` it reads, texels, a fetch's own blending included: within it, an edge may
    /// be blurred or displaced.
    ///
    /// # Errors
    /// [`PlanError::Invalid`] where an axis or a setting is not as it must be.
    fn reach(&self, frame: &Frame<'_>, number: usize) -> Result<f64, PlanError>;

    /// The most texture fetches that sampling map `number` once takes, where one comparison takes as many as
    /// the frame's depth source says.
    ///
    /// # Errors
    /// [`PlanError::Invalid`] where an axis or a setting is not as it must be.
    fn fetches(&self, frame: &Frame<'_>, number: usize) -> Result<u32, PlanError>;

    /// How far a receiver is to be moved towards the light, in texels of a map with `side` of them, where a scene chose
    /// `texels`. Less where the filter needs no bias.
    ///
    /// # Errors
    /// [`PlanError::Invalid`] where an axis or a setting is not as it must be.
    fn depth_bias(&self, frame: &Frame<'_>, texels: f64, side: u32) -> Result<f64, PlanError> {
        let _ = (frame, side);
        Ok(texels)
    }

    /// Adds to `plan` the passes that come after `maps` are filled, and what sampling reads beside them.
    ///
    /// # Errors
    /// [`PlanError::Invalid`] where an axis or a setting is not as it must be.
    fn prepare(
        &self,
        frame: &Frame<'_>,
        maps: &Maps,
        plan: &mut ShadowPlan,
    ) -> Result<(), PlanError> {
        let _ = (frame, maps, plan);
        Ok(())
    }
}
