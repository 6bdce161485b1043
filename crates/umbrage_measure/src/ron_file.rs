//! Files that people write, in RON.

use ron::extensions::Extensions;
use serde::de::DeserializeOwned;

/// A text is not RON, or not what it is to be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: {message}")]
pub struct RonError {
    /// The file.
    pub file: String,
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    /// What is wrong.
    pub message: String,
}

/// Reads `text`; `file` is what an error calls it.
pub(crate) fn parse<T: DeserializeOwned>(file: &str, text: &str) -> Result<T, RonError> {
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    options.from_str(text).map_err(|error| RonError {
        file: file.to_owned(),
        line: error.span.start.line,
        column: error.span.start.col,
        message: error.code.to_string(),
    })
}
