use std::io;

/// Why a report cannot be written: what, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// No row.
    #[error(
        "there is nothing to report: no method drew any scene; name other methods, configurations or scenes"
    )]
    NoRows,
    /// Not one set of pictures a row.
    #[error(
        "the report has {rows} rows, but {pictures} sets of pictures; give each row its own, in the rows' order"
    )]
    Pictures {
        /// How many rows there are.
        rows: usize,
        /// How many sets of pictures.
        pictures: usize,
    },
    /// A picture without pixels, or not one number a pixel.
    #[error(
        "a picture of {width} × {height} pixels cannot be made of {found} {what}; give one a pixel, and at least \
         one pixel"
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Kind of item that there are too few or too many of.
        what: &'static str,
        /// How many there are.
        found: usize,
    },
    /// A picture that the encoder refuses.
    #[error("a picture cannot be stored as PNG: {0}")]
    Png(#[from] image::ImageError),
    /// A plot that cannot be drawn.
    #[error("the plot of scene `{scene}` cannot be drawn: {reason}")]
    Plot {
        /// The scene's name.
        scene: String,
        /// Why.
        reason: String,
    },
    /// Rows that are not JSON.
    #[error("the rows cannot be stored as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A file that could not be written.
    #[error("{file} could not be written: {source}; make room, or choose another folder")]
    Write {
        /// The file's name in the report's folder.
        file: &'static str,
        /// Why.
        source: io::Error,
    },
    /// A folder with something else than a report.
    #[error("{0}")]
    Foreign(String),
}
