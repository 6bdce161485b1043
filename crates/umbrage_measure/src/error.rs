use umbrage_render::{RenderError, ShadowError};
use umbrage_shadow::RegistryError;

use crate::{figures::FigureError, report::ReportError, truth::TruthError};

/// Why methods could not be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// A method is asked for that is not registered.
    #[error(transparent)]
    Method(#[from] RegistryError),
    /// A part, an axis, a value or a setting that there is not.
    #[error(transparent)]
    Shadow(#[from] ShadowError),
    /// There is nothing to compare.
    #[error("there is nothing to compare: give at least one scene and one configuration")]
    Nothing,
    /// Two scenes have one name.
    #[error("two scenes are called `{name}`; rename one of the files")]
    SameName {
        /// The name.
        name: String,
    },
    /// A scene has no truth.
    #[error("scene `{scene}` cannot be traced: {source}")]
    Truth {
        /// The scene.
        scene: String,
        /// Why.
        source: TruthError,
    },
    /// A scene cannot be rendered.
    #[error("scene `{scene}` cannot be rendered with {what}: {source}")]
    Render {
        /// The scene.
        scene: String,
        /// The method and the configuration.
        what: String,
        /// Why.
        source: RenderError,
    },
    /// A rendering cannot be held against the truth.
    #[error(transparent)]
    Figures(#[from] FigureError),
    /// A picture of the report cannot be made.
    #[error(transparent)]
    Picture(#[from] ReportError),
    /// A hard case is in no table of limits.
    #[error("the hard case `{case}` has no limits; add it to limits.ron")]
    NoLimits {
        /// The case.
        case: &'static str,
    },
    /// A permutation cannot be composed, or a list of configurations is faulty.
    #[error(transparent)]
    Compose(#[from] umbrage_compose::Error),
}
