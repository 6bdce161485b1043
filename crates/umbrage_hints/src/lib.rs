//! Hints for names that were not found: which known one may be meant.
//!
//! A crate of its own, so that crates which must not see each other say the same of the same slip.
//!
//! ```
//! use umbrage_hints::{did_you_mean, ending, nearest};
//!
//! let known = ["basic", "pssm"];
//! assert_eq!(nearest("basics", known), Some("basic"));
//! assert_eq!(did_you_mean("basics", known).as_deref(), Some("did you mean `basic`?"));
//! assert_eq!(
//!     format!("no method `basics`{}", ending("basics", known)),
//!     "no method `basics`; did you mean `basic`?"
//! );
//!
//! // Where no name is near, saying nothing helps most.
//! assert_eq!(nearest("voxels", known), None);
//! assert_eq!(ending("voxels", known), "");
//! ```

/// The name of `known` nearest to `name`, where one is near enough to be meant; the first in alphabetical order of
/// several that are equally near.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|known| (strsim::jaro_winkler(name, known), known))
        .filter(|(score, _)| *score > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(a.1)))
        .map(|(_, known)| known)
}

/// The question whether the [nearest] name was meant, where there is one.
pub fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    nearest(name, known).map(|near| format!("did you mean `{near}`?"))
}

/// The end of a message of one line that could not find `name`: [that question](did_you_mean) after a semicolon, or
/// nothing.
pub fn ending<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    did_you_mean(name, known).map_or_else(String::new, |question| format!("; {question}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equally_near_names_are_taken_in_alphabetical_order() {
        for known in [["map_b", "map_a"], ["map_a", "map_b"]] {
            assert_eq!(nearest("map_c", known), Some("map_a"));
        }
    }

    #[test]
    fn no_text_is_too_strange() {
        for name in ["", "`", "影", &"x".repeat(10_000)] {
            assert_eq!(
                nearest(name, ["", "basic"]).filter(|near| !near.is_empty()),
                None
            );
        }
    }
}
