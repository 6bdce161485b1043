//! The columns of the table: every figure, in the unit that people read it in.

use crate::report::{
    Row, Spread,
    format::{doubt, number, whole},
    pareto::memory,
};

/// A group of columns, shown and hidden together.
pub(super) struct Group {
    /// The class of its cells, and what its checkbox is called by.
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    /// Whether it is shown before anyone chooses.
    pub(super) shown: bool,
    pub(super) columns: &'static [Column],
}

/// A figure.
pub(super) struct Column {
    /// As in `report.json`.
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    pub(super) unit: &'static str,
    /// Meaning, in a few words.
    pub(super) about: &'static str,
    /// The figure, in the column's unit.
    pub(super) value: fn(&Row) -> Option<f64>,
    pub(super) show: fn(f64) -> String,
    /// Second figure beside it, small.
    pub(super) beside: Option<fn(&Row) -> Option<String>>,
}

/// A column with nothing beside its figure.
const fn column(
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    about: &'static str,
    value: fn(&Row) -> Option<f64>,
    show: fn(f64) -> String,
) -> Column {
    Column {
        name,
        title,
        unit,
        about,
        value,
        show,
        beside: None,
    }
}

/// A share, in percent: of the figures, or of another part of the row.
macro_rules! share {
    ($name:ident, $title:literal, $about:literal) => {
        share!($name, $title, $about, |row: &Row| Some(row.figures.$name))
    };
    ($name:ident, $title:literal, $about:literal, $of:expr) => {
        column(
            stringify!($name),
            $title,
            "%",
            $about,
            |row| $of(row).map(|share: f64| share * 100.0),
            number,
        )
    };
}

/// A figure that may be missing, times a factor.
macro_rules! maybe {
    ($name:ident, $factor:literal, $title:literal, $unit:literal, $about:literal) => {
        column(
            stringify!($name),
            $title,
            $unit,
            $about,
            |row| row.figures.$name.map(|value| value * $factor),
            number,
        )
    };
}

/// A figure of the compiler's.
macro_rules! isa {
    ($name:ident, $title:literal, $unit:literal, $about:literal) => {
        column(
            stringify!($name),
            $title,
            $unit,
            $about,
            |row| row.isa.as_ref().map(|isa| count(isa.$name)),
            whole,
        )
    };
}

/// Times in milliseconds.
macro_rules! spread {
    ($name:ident, $title:literal, $about:literal) => {
        Column {
            beside: Some(|row| Some(range(row.$name))),
            ..column(
                stringify!($name),
                $title,
                "ms",
                $about,
                |row| Some(row.$name.median),
                number,
            )
        }
    };
}

/// A share of how receivers were decided, in percent.
macro_rules! decided {
    ($name:ident, $title:literal, $about:literal) => {
        share!($name, $title, $about, |row: &Row| row
            .decided
            .map(|decided| decided.$name))
    };
}

fn range(Spread { min, max, .. }: Spread) -> String {
    format!("{}–{}", number(min), number(max))
}

pub(super) fn count(value: u64) -> f64 {
    value as f64
}

/// All columns but those that name a row.
pub(super) static GROUPS: &[Group] = &[
    Group {
        id: "error",
        title: "Error",
        shown: true,
        columns: &[
            column(
                "error",
                "error",
                "%",
                "false lit + false shadow: what the plots show",
                |row| Some(row.error() * 100.0),
                number,
            ),
            maybe!(
                error_of_shadow,
                100.0,
                "of shadow",
                "%",
                "the error as a share of what is in shadow in truth"
            ),
            maybe!(
                false_lit_of_shadow,
                100.0,
                "false lit of shadow",
                "%",
                "false lit as a share of what is in shadow in truth"
            ),
            share!(false_lit, "false lit", "lit, but should be in shadow"),
            share!(false_shadow, "false shadow", "in shadow, but should be lit"),
            column(
                "rmse",
                "RMSE",
                "",
                "root of the mean squared error of the shadow term",
                |row| Some(row.figures.rmse),
                number,
            ),
            column(
                "p99",
                "p99",
                "",
                "the error of the shadow term that 99 of 100 samples do not exceed",
                |row| Some(row.figures.p99),
                number,
            ),
            maybe!(flip, 1.0, "FLIP", "", "mean FLIP of the shaded picture"),
            maybe!(
                shimmer,
                100.0,
                "shimmer",
                "%",
                "samples that flip per frame under a small motion of the camera, less those that flip in truth"
            ),
            column(
                "bad_pixels",
                "bad pixels",
                "",
                "not a number, infinite, or outside 0..1: must be 0",
                |row| Some(count(row.figures.bad_pixels)),
                whole,
            ),
        ],
    },
    Group {
        id: "cause",
        title: "By cause",
        shown: false,
        columns: &[
            share!(acne, "acne", "the receiver shades itself"),
            share!(
                back_facing,
                "back-facing",
                "wrong on what is turned away from the light, where nobody sees it: not in the error"
            ),
            share!(
                peter_panning,
                "peter-panning",
                "a band of light where the caster touches the receiver"
            ),
            share!(leak, "light leak", "light behind a caster"),
            share!(beyond_range, "beyond range", "past the shadow distance"),
            share!(edge, "edge", "within a filter's reach of a true edge"),
        ],
    },
    Group {
        id: "edges",
        title: "Edge displacement",
        shown: true,
        columns: &[
            maybe!(
                edge_p50,
                1.0,
                "median",
                "px",
                "half of the edges are nearer"
            ),
            maybe!(edge_p95, 1.0, "p95", "px", "95 of 100 edges are nearer"),
            maybe!(edge_max, 1.0, "max", "px", "the farthest edge"),
        ],
    },
    Group {
        id: "alias",
        title: "Aliasing d / d_i",
        shown: false,
        columns: &[
            maybe!(
                alias_p95,
                1.0,
                "p95",
                "px/texel",
                "pixels that a shadow texel covers across"
            ),
            maybe!(
                alias_over_1,
                100.0,
                "over 1",
                "%",
                "samples where a texel covers more than a pixel"
            ),
            maybe!(
                alias_perspective_p95,
                1.0,
                "perspective p95",
                "px/texel",
                "the part that comes of distance"
            ),
            maybe!(
                alias_projection_p95,
                1.0,
                "projection p95",
                "px/texel",
                "the part that comes of slope"
            ),
        ],
    },
    Group {
        id: "cost",
        title: "Cost",
        shown: true,
        columns: &[
            Column {
                beside: Some(|row| doubt(&row.time_ratio)),
                ..column(
                    "time_ratio",
                    "time",
                    "× basic",
                    "casters and shading, relative to basic with one tap, drawn pair by pair: median, and its interval",
                    |row| row.time_ratio.is_told().then_some(row.time_ratio.median),
                    number,
                )
            },
            spread!(
                casters_ms,
                "casters",
                "time of the passes that make shadow maps: median, and the range"
            ),
            spread!(
                shading_ms,
                "shading",
                "time of the shading: median, and the range"
            ),
            spread!(
                frame_ms,
                "frame",
                "time of the whole frame by the clock on the wall: median, and the range"
            ),
            column(
                "memory_bytes",
                "memory",
                "MiB",
                "bytes in the method's textures",
                |row| Some(memory(row) / 1_048_576.0),
                number,
            ),
            column(
                "fetches_per_pixel",
                "fetches",
                "per px",
                "texture fetches of the shadow term, counted",
                |row| Some(row.fetches_per_pixel),
                number,
            ),
            column(
                "fetches_saved",
                "saved",
                "per px",
                "fetches fewer than of the same filter always run; below 0: bounds cost more than they spare",
                |row| row.decided?.fetches_saved,
                number,
            ),
            Column {
                beside: Some(|row| {
                    let [plane, depth] = row
                        .decided
                        .map(|d| [d.by_plane(), d.by_depth()])?
                        .map(|s| number(s * 100.0));
                    Some(format!("plane {plane}, depth {depth}"))
                }),
                ..column(
                    "decided",
                    "decided at once",
                    "%",
                    "receivers, of those that sample a map, whose shadow term was found without filtering: all, by planes, by the least and the greatest depth",
                    |row| row.decided.map(|decided| decided.at_once() * 100.0),
                    number,
                )
            },
            column(
                "texels",
                "texels",
                "",
                "in the method's textures",
                |row| Some(count(row.texels)),
                whole,
            ),
            column(
                "texels_written",
                "texels written",
                "",
                "that passes fill in one picture",
                |row| Some(count(row.texels_written)),
                whole,
            ),
            column(
                "triangles",
                "triangles",
                "",
                "of casters that passes draw in one picture",
                |row| Some(count(row.triangles)),
                whole,
            ),
            column(
                "vertices",
                "vertices",
                "",
                "of these triangles, each once a pass",
                |row| Some(count(row.vertices)),
                whole,
            ),
            column(
                "passes",
                "passes",
                "",
                "that make shadow maps",
                |row| Some(f64::from(row.passes)),
                whole,
            ),
            column(
                "draws",
                "draws",
                "",
                "in those passes",
                |row| Some(f64::from(row.draws)),
                whole,
            ),
        ],
    },
    Group {
        id: "decided",
        title: "Decided at once",
        shown: false,
        columns: &[
            decided!(
                lit_by_plane,
                "lit by plane",
                "before a plane that no depth around is before"
            ),
            decided!(lit_by_depth, "lit by depth", "no depth around is greater"),
            decided!(
                shadowed_by_plane,
                "shadowed by plane",
                "behind a plane that all depths around are before"
            ),
            decided!(
                shadowed_by_depth,
                "shadowed by depth",
                "all depths around are greater"
            ),
            decided!(filtered, "filtered", "left open, and filtered"),
        ],
    },
    Group {
        id: "isa",
        title: "GPU instructions",
        shown: true,
        columns: &[
            isa!(
                instructions,
                "instructions",
                "",
                "in the costliest fragment shader"
            ),
            isa!(vgprs, "VGPRs", "", "vector registers"),
            isa!(sgprs, "SGPRs", "", "scalar registers"),
            isa!(code_size, "code", "B", "bytes of machine code"),
            isa!(
                latency,
                "latency",
                "cycles",
                "from start to end, by the compiler's estimate"
            ),
            isa!(
                inverse_throughput,
                "inv. throughput",
                "cycles",
                "a wave's share when many are in flight, by the compiler's estimate"
            ),
        ],
    },
    Group {
        id: "samples",
        title: "Samples",
        shown: false,
        columns: &[
            column(
                "compared",
                "compared",
                "",
                "pixels in a light's reach, pooled over the lights",
                |row| Some(count(row.figures.compared)),
                whole,
            ),
            share!(
                in_shadow,
                "in shadow",
                "in shadow in truth, of what faces the light"
            ),
            column(
                "left_out",
                "left out",
                "",
                "the rasteriser saw another triangle than the ray",
                |row| Some(count(row.figures.left_out)),
                whole,
            ),
        ],
    },
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde_json::Value;

    use super::*;
    use crate::report::tests::rows::full_row;

    /// The columns against the serialised row, so that a new figure is missed by this test and not by the
    /// reader.
    #[test]
    fn every_figure_of_the_json_has_a_column_with_its_value() {
        let row = full_row();
        let mut figures: BTreeMap<String, f64> = BTreeMap::new();
        let Value::Object(json) = serde_json::to_value(&row).expect("JSON") else {
            panic!("a row is an object");
        };
        for (name, value) in json {
            match value {
                Value::Number(number) => {
                    figures.insert(name, number.as_f64().expect("a number"));
                }
                Value::Object(members) => {
                    for (member, value) in members {
                        match (name.as_str(), member.as_str()) {
                            ("isa", "family") | (_, "min" | "max" | "low" | "high" | "pairs") => {}
                            // Of `fetches_per_pixel`, their mean.
                            ("fetch_shares", _) => {}
                            (_, "median") => {
                                figures.insert(name.clone(), value.as_f64().expect("a number"));
                            }
                            _ => {
                                figures.insert(member, value.as_f64().expect("a number"));
                            }
                        }
                    }
                }
                _ => assert!(
                    ["scene", "method", "config", "path", "pareto", "time_pairs"]
                        .contains(&name.as_str()),
                    "{name} has no column"
                ),
            }
        }
        figures.insert("error".to_owned(), row.error());
        // All but what is filtered.
        figures.insert("decided".to_owned(), 0.9175);
        let mut values: Vec<f64> = figures.values().copied().collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        assert_eq!(values.len(), figures.len(), "the figures can be told apart");
        for column in GROUPS.iter().flat_map(|group| group.columns) {
            let expected = figures.remove(column.name).expect(column.name);
            let factor = match column.unit {
                "%" => 100.0,
                "MiB" => 1.0 / 1_048_576.0,
                _ => 1.0,
            };
            let found = (column.value)(&row).expect(column.name);
            assert!((found - expected * factor).abs() < 1e-9, "{}", column.name);
        }
        assert!(figures.is_empty(), "no column has {figures:?}");
    }
}
