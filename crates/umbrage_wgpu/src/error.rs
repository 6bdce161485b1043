use std::error::Error as StdError;

use umbrage_compose::{Binding, Key};
use umbrage_shadow::PlanError;

use crate::Job;

/// Why a shadow could not be had.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A permutation could not be composed.
    #[error(transparent)]
    Compose(#[from] umbrage_compose::Error),
    /// Something is larger than the device allows.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// A part could not plan.
    #[error("light `{light}`: {source}")]
    Plan {
        /// The light.
        light: String,
        /// Why.
        source: PlanError,
    },
    /// A part panicked.
    #[error(
        "light `{light}`: {parts} panicked while it planned: {said}; this is a fault of its parts: mend them, or choose \
         others"
    )]
    Panicked {
        /// The light.
        light: String,
        /// The method, with the depth source and the filter that it lets be chosen.
        parts: String,
        /// The panic's words.
        said: String,
    },
    /// A part needs what the device does not have.
    #[error(
        "light `{light}`, method `{method}`: what is chosen needs {features}, which the device does not have; choose \
         {instead}"
    )]
    Missing {
        /// The light.
        light: String,
        /// The method.
        method: String,
        /// Names of features, as WebGPU has them.
        features: String,
        /// The choice in its place.
        instead: String,
    },
    /// A plan asks for what cannot be done: a part is at fault.
    #[error(
        "light `{light}`: method `{method}` plans what cannot be done: {problem}; this is a fault of the method: mend it, \
         or choose another"
    )]
    BadPlan {
        /// The light.
        light: String,
        /// The method.
        method: String,
        /// The fault.
        problem: String,
    },
    /// A pass reads the camera's depth, and the job gives none.
    #[error(
        "light `{light}`, method `{method}`: the pass `{pass}` reads the camera's depth, which is not given; give it \
         (`Job::camera_depth`), or have the frame say that there is none (`Frame::camera_depth`)"
    )]
    NoDepth {
        /// The light.
        light: String,
        /// The method.
        method: String,
        /// The pass.
        pass: String,
    },
    /// The camera's depth is not as passes read it.
    #[error("light `{light}`: the camera's depth {problem}")]
    BadDepth {
        /// The light.
        light: String,
        /// The fault, and the remedy.
        problem: String,
    },
    /// A permutation reads what nobody gives it.
    #[error("permutation {key}, binding `{binding}` of {module}: {problem}")]
    Binding {
        /// The permutation.
        key: String,
        /// The binding.
        binding: String,
        /// The module that declares it.
        module: String,
        /// The fault.
        problem: String,
    },
    /// A permutation gives fewer colours than are drawn into.
    #[error(
        "permutation {key} gives no colour at location {location}, and {targets} colours are drawn into: have its fragment \
         stage give one for each"
    )]
    Colors {
        /// The permutation.
        key: String,
        /// The first location without a colour.
        location: u32,
        /// How many colours are drawn into.
        targets: usize,
    },
    /// A pipeline that was to be made ahead cannot be made.
    #[error("permutation {keys} cannot be made ahead of need: {said}")]
    Ahead {
        /// The permutation's keys.
        keys: String,
        /// Why, in the device's words, or a panic's.
        said: String,
    },
    /// A pass reads or gives what its plan does not.
    #[error("light `{light}`, method `{method}`: a pass of its plan: {source}")]
    Pass {
        /// The light.
        light: String,
        /// The method.
        method: String,
        /// Why.
        source: Box<Error>,
    },
    /// The engine could not draw its casters.
    #[error("light `{light}`: its casters cannot be drawn: {source}")]
    Casters {
        /// The light.
        light: String,
        /// Why.
        source: Box<dyn StdError + Send + Sync>,
    },
}

/// Something is larger than the device allows.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what} has {size}, but the device allows from 1 to {limit}; change its size")]
pub struct TooLarge {
    /// Its name.
    pub what: String,
    /// Its size, with the unit.
    pub size: String,
    /// The most allowed.
    pub limit: u64,
}

impl Error {
    /// The same, of a pass of the job's plan.
    pub(crate) fn in_pass(self, job: &Job<'_>) -> Self {
        match self {
            Self::Binding { .. } | Self::Colors { .. } => Self::Pass {
                light: job.name.to_owned(),
                method: job.shadow.method().name().to_owned(),
                source: Box::new(self),
            },
            // Its own words say what is wrong.
            other => other,
        }
    }

    /// A fault of a permutation's binding.
    pub fn binding(key: &Key, binding: &Binding, problem: impl ToString) -> Self {
        Self::Binding {
            key: key.to_string(),
            binding: binding.name.clone(),
            module: binding.module.clone(),
            problem: problem.to_string(),
        }
    }
}
