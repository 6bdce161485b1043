//! Why a scene could not be rendered.

use std::{io, path::PathBuf};

use umbrage_compose::Cause;
use umbrage_shadow::PlanError;
use umbrage_wgpu::ShadowError;

use crate::{GpuError, What, renderer::MOST_SHAFT_STEPS};

/// Why a scene could not be rendered: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A picture of no pixels, or of more than the device can render.
    #[error(
        "a picture of {width} by {height} pixels cannot be rendered; each side must be from 1 to {limit}"
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// The longest side.
        limit: u32,
    },
    /// A texture to draw into that the picture does not fit, or a picture that is not shaded.
    #[error(
        "the texture to draw into has {} by {} pixels of {samples} samples, for {what:?} of {} by {} pixels; \
         give one of that size and of one sample, for `What::Shaded`",
        found[0], found[1], expected[0], expected[1]
    )]
    Target {
        /// The picture that was asked for.
        what: What,
        /// Its size.
        expected: [u32; 2],
        /// The texture's size.
        found: [u32; 2],
        /// The texture's samples.
        samples: u32,
    },
    /// No steps along a ray, or too many.
    #[error(
        "{steps} steps along a ray through the medium cannot be made; choose from 1 to {MOST_SHAFT_STEPS}"
    )]
    Steps {
        /// As asked for.
        steps: u32,
    },
    /// The device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A permutation could not be composed.
    #[error(transparent)]
    Compose(#[from] umbrage_compose::Error),
    /// A light's shadow is to be found by what there is not.
    #[error("light `{light}`: {source}; change what it or the options choose")]
    Shadow {
        /// The light.
        light: String,
        /// Why.
        source: ShadowError,
    },
    /// Choices for a light's shadow that the shader library does not have together.
    #[error("light `{light}`: {source}")]
    Excluded {
        /// The light.
        light: String,
        /// Why.
        source: umbrage_compose::Error,
    },
    /// A choice of an axis that does not exist, or that is not to be chosen there.
    #[error("{place} chooses `{axis}`, {problem}")]
    Axis {
        /// Place of the choice.
        place: String,
        /// The axis.
        axis: String,
        /// The problem.
        problem: String,
    },
    /// A method cannot shadow a light.
    #[error(
        "method `{method}` cannot shadow light `{light}`: {reason}; choose another method for it"
    )]
    Unsupported {
        /// The light.
        light: String,
        /// The method.
        method: String,
        /// Why.
        reason: String,
    },
    /// The scene's camera, a light or an object is described by numbers that cannot be drawn.
    #[error("{what}: {source}; change it in the scene")]
    Scene {
        /// The camera, or which light or object.
        what: String,
        /// The fault.
        source: PlanError,
    },
    /// A light's shadow could not be had, or a shader reads what nobody gives it.
    #[error(transparent)]
    Execute(#[from] umbrage_wgpu::Error),
    /// A mesh's arrays do not fit each other.
    #[error("the mesh of object `{object}` cannot be drawn: {problem}")]
    Mesh {
        /// The object.
        object: String,
        /// The problem.
        problem: String,
    },
    /// The picture cannot be written.
    #[error("cannot write {}: {source}; choose a folder that exists and may be written to", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl RenderError {
    /// Whether a shader uses more than the target allows a stage.
    pub(crate) fn is_limit(&self) -> bool {
        matches!(self, Self::Compose(error) if error.faults().iter().any(|f| f.cause == Cause::Limit))
    }
}
