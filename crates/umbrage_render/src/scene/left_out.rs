//! Features of a model's file that its scene does not show.

use std::{fmt, path::Path};

/// Something that a model's file says and its scene leaves out.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct LeftOut {
    /// The file's name, without its folder.
    pub file: String,
    /// An extension or a property by glTF's name.
    pub feature: String,
    /// In how many places the file says it.
    pub places: usize,
    /// The replacement that is shown.
    pub instead: String,
}

impl LeftOut {
    /// A `feature` that the file at `path` has in so many places; none where it has it nowhere.
    pub(super) fn new(path: &Path, feature: &str, places: usize, instead: &str) -> Option<Self> {
        (places > 0).then(|| Self {
            file: path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            feature: feature.to_owned(),
            places,
            instead: instead.to_owned(),
        })
    }
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            file,
            feature,
            places,
            instead,
        } = self;
        let s = if *places == 1 { "" } else { "s" };
        write!(f, "{file}: {feature} ({places} place{s}): {instead}")
    }
}
