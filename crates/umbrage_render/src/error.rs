//! Why a scene could not be rendered.

use std::{io, path::PathBuf};

use umbrage_shadow::PlanError;

use crate::{GpuError, renderer::MOST_SHAFT_STEPS, scene::ShadowError};

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
        /// Who chooses.
        place: String,
        /// The axis.
        axis: String,
        /// What is wrong with it.
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
        /// What is wrong.
        source: PlanError,
    },
    /// A method could not plan.
    #[error("light `{light}`: {source}")]
    Plan {
        /// The light.
        light: String,
        /// Why.
        source: PlanError,
    },
    /// A method needs what the device does not have.
    #[error(
        "light `{light}`, method `{method}`: what is chosen needs {features}, which {adapter} does not have; choose {instead}"
    )]
    Missing {
        /// The light.
        light: String,
        /// The method.
        method: String,
        /// The device.
        adapter: String,
        /// Names of features, as WebGPU has them.
        features: String,
        /// What to choose in its place.
        instead: String,
    },
    /// A method's plan asks for what cannot be done: the method is at fault.
    #[error(
        "method `{method}` plans what cannot be drawn: {problem}; this is a fault of the method"
    )]
    BadPlan {
        /// The method.
        method: String,
        /// What is wrong.
        problem: String,
    },
    /// A permutation reads what the renderer or a method does not give it.
    #[error("permutation {key}, binding `{binding}` of {module}: {problem}")]
    Binding {
        /// The permutation.
        key: String,
        /// The binding.
        binding: String,
        /// The module that declares it.
        module: String,
        /// What is wrong.
        problem: String,
    },
    /// A mesh's arrays do not fit each other.
    #[error("the mesh of object `{object}` cannot be drawn: {problem}")]
    Mesh {
        /// The object.
        object: String,
        /// What is wrong.
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
    pub(crate) fn binding(
        key: &umbrage_compose::Key,
        binding: &umbrage_compose::Binding,
        problem: impl ToString,
    ) -> Self {
        Self::Binding {
            key: key.to_string(),
            binding: binding.name.clone(),
            module: binding.module.clone(),
            problem: problem.to_string(),
        }
    }
}
