//! Names of rows, and how methods are told apart.

use std::collections::BTreeSet;

use super::{Report, Row};

/// How many colours the page has for methods.
const COLOURS: usize = 8;

/// How a point of a plot looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Circle,
    Square,
    Triangle,
    Diamond,
}

/// The names in a report.
pub(super) struct Names {
    /// Sorted.
    methods: Vec<String>,
    /// Whether the path is needed to tell rows apart.
    paths: bool,
}

impl Names {
    pub(super) fn of(report: &Report) -> Self {
        let methods: BTreeSet<_> = report.rows.iter().map(|row| &row.method).collect();
        let paths: BTreeSet<_> = report.rows.iter().map(|row| &row.path).collect();
        Self {
            methods: methods.into_iter().cloned().collect(),
            paths: paths.len() > 1,
        }
    }

    pub(super) fn methods(&self) -> &[String] {
        &self.methods
    }

    /// Name of a row among those of its scene.
    pub(super) fn row(&self, row: &Row) -> String {
        let mut name = format!("{} {}", row.method, row.config);
        if self.paths {
            name = format!("{name} · {}", row.path);
        }
        name
    }

    /// The class that gives a method its colour.
    pub(super) fn class(&self, method: &str) -> String {
        format!("m{}", self.index(method) % COLOURS)
    }

    /// A method's shape: with the colour, it tells 32 methods apart, and four without seeing colours.
    pub(super) fn shape(&self, method: &str) -> Shape {
        let index = self.index(method);
        match (index + index / COLOURS) % 4 {
            0 => Shape::Circle,
            1 => Shape::Square,
            2 => Shape::Triangle,
            _ => Shape::Diamond,
        }
    }

    fn index(&self, method: &str) -> usize {
        self.methods
            .binary_search_by(|name| name.as_str().cmp(method))
            .unwrap_or(0)
    }
}
