//! Result of a check, from which every format is written.

use std::path::{Component, Path, PathBuf};

use serde::Serialize;
use umbrage::compose::{Fault, Location};

/// All that a check found; the output of `--format json`.
#[derive(Serialize)]
pub(crate) struct Report {
    /// How many legal keys are meant, at most 2^64 - 1.
    pub(crate) keys: u64,
    /// How many distinct permutations they make; one that manifests of the same packages and target share
    /// counts once.
    pub(crate) permutations: usize,
    /// How many keys failed, at most 2^64 - 1.
    pub(crate) failed: u64,
    /// Errors, each once.
    pub(crate) faults: Vec<Finding>,
    /// Findings of lints, each once; those of a denied lint are errors.
    pub(crate) lints: Vec<Finding>,
    /// Warnings with their source lines: harmless, but worth telling.
    pub(crate) warnings: Vec<String>,
}

/// One fault or finding of a lint, however many permutations it was found in.
#[derive(Serialize)]
pub(crate) struct Finding {
    /// The rule that it breaks: a kind of fault, a lint's name, or `budget`.
    pub(crate) rule: String,
    pub(crate) level: Level,
    pub(crate) file: Option<String>,
    pub(crate) line: Option<usize>,
    pub(crate) column: Option<usize>,
    pub(crate) message: String,
    /// Remedies.
    pub(crate) notes: Vec<String>,
    /// How many keys have it, at most 2^64 - 1.
    pub(crate) failed: u64,
    /// How many checked permutations have it.
    pub(crate) permutations: usize,
    /// The keys; where they are very many, the first, one for each permutation.
    pub(crate) keys: Vec<String>,
    /// The smallest choice of axes that triggers it.
    pub(crate) cause: String,
    /// The finding with its source lines, for a person.
    #[serde(skip)]
    pub(crate) rendered: String,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Level {
    Warning,
    Error,
}

impl Level {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

impl Report {
    /// Faults and lints.
    pub(crate) fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.faults.iter().chain(&self.lints)
    }

    /// Whether something is wrong, and not only worth telling.
    pub(crate) fn is_faulty(&self) -> bool {
        self.findings().any(|finding| finding.level == Level::Error)
    }

    /// Counts in a line.
    pub(crate) fn summary(&self) -> String {
        let lints = match self.lints.len() {
            0 => String::new(),
            count => format!(", {count} findings of lints"),
        };
        format!(
            "{} keys, {} permutations, {} keys failed with {} faults{lints}",
            self.keys,
            self.permutations,
            self.failed,
            self.faults.len(),
        )
    }
}

impl Finding {
    /// Finding of `fault`, for the rule `rule`.
    pub(crate) fn of(fault: &Fault, rule: String, level: Level) -> Self {
        let location = fault.location();
        Self {
            rule,
            level,
            file: location.map(|at| at.file.clone()),
            line: location.map(|at: &Location| at.line),
            column: location.map(|at| at.column),
            message: fault.message.clone(),
            notes: fault.notes.clone(),
            failed: 0,
            permutations: 0,
            keys: fault.keys.iter().map(ToString::to_string).collect(),
            cause: String::new(),
            rendered: fault.to_string(),
        }
    }

    /// When it is triggered, and how often it was found.
    pub(crate) fn when(&self) -> String {
        let times = match self.permutations {
            0 => String::new(),
            1 => format!(", in 1 permutation of {} keys", self.failed),
            many => format!(", in {many} permutations of {} keys", self.failed),
        };
        match self.cause.as_str() {
            // Parts of permutations that lints look at are shared, and a budget names its permutation itself.
            "" => String::new(),
            cause => format!("fails when {cause}{times}"),
        }
    }

    /// The finding with its source lines, and when it is triggered.
    pub(crate) fn for_a_person(&self) -> String {
        match self.when().as_str() {
            "" => self.rendered.clone(),
            when => format!("{}  = {when}\n", self.rendered),
        }
    }

    /// Message, remedies, and when it is triggered, without source lines.
    pub(crate) fn text(&self) -> String {
        let mut lines = vec![self.message.clone()];
        lines.extend(self.notes.iter().cloned());
        lines.push(self.when());
        lines.retain(|line| !line.is_empty());
        lines.join("\n")
    }

    /// The file as one below the current folder, with slashes, where it lies there: services that show findings beside the
    /// lines look for it in the repository.
    pub(crate) fn path(&self) -> Option<String> {
        let here = std::env::current_dir().unwrap_or_default();
        self.file.as_deref().map(|file| below(&here, file))
    }
}

fn below(here: &Path, file: &str) -> String {
    let mut path = PathBuf::new();
    for part in Path::new(file).components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(path.components().next_back(), Some(Component::Normal(_))) =>
            {
                path.pop();
            }
            other => path.push(other),
        }
    }
    let path = path.strip_prefix(here).unwrap_or(&path);
    path.display().to_string().replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_named_as_the_repository_has_it() {
        let here = Path::new("/home/me/shaders");
        for (file, expected) in [
            ("permutations/../lib/a.wesl", "lib/a.wesl"),
            ("./lib/a.wesl", "lib/a.wesl"),
            ("/home/me/shaders/x/../lib/a.wesl", "lib/a.wesl"),
            ("/home/you/a.wesl", "/home/you/a.wesl"),
            ("../lib/a.wesl", "../lib/a.wesl"),
            ("lib/../../a.wesl", "../a.wesl"),
        ] {
            assert_eq!(below(here, file), expected, "{file}");
        }
    }
}
