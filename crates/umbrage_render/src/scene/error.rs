//! Why a scene could not be loaded.

use std::{
    io,
    path::{Path, PathBuf},
};

/// Why a scene could not be loaded: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A file is missing or cannot be read.
    #[error("cannot read {}: {source}; check the path, which is taken from the folder of the file that names it", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file's name says nothing that can be loaded.
    #[error("{} is no scene: its name ends in none of .ron, .gltf and .glb", path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
    },
    /// A scene file cannot be read, is not RON or not a scene, or says what cannot be used.
    #[error(transparent)]
    File(#[from] umbrage_compose::Error),
    /// A model or a picture is well-formed, but what it says cannot be used.
    #[error("{}: {place}: {problem}; {remedy}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Where in it, such as `lights[1].range`.
        place: String,
        /// The problem.
        problem: String,
        /// Remedy.
        remedy: String,
    },
}

impl SceneError {
    pub(crate) fn invalid(
        path: &Path,
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Invalid {
            path: path.to_owned(),
            place: place.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }
}

pub(crate) fn read(path: &Path) -> Result<Vec<u8>, SceneError> {
    std::fs::read(path).map_err(|source| SceneError::Unreadable {
        path: path.to_owned(),
        source,
    })
}
