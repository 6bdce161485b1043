//! The smallest choice of axes that triggers a fault.

use std::collections::{BTreeMap, BTreeSet};

/// What was checked: the value of every axis, and whether the fault was found with them.
pub(crate) struct Checked<'a> {
    /// The value of every axis.
    pub(crate) values: &'a BTreeMap<String, String>,
    /// Whether the fault was found.
    pub(crate) faulty: bool,
}

/// A set of axes with their values, and the subjects that have them all.
#[derive(Clone)]
struct Choice {
    axes: Vec<usize>,
    values: Vec<usize>,
    has: Vec<bool>,
}

/// The smallest choice of axes that triggers a fault, among what was checked: the fewest axes with such
/// values that whatever has these values has the fault. Where no one choice covers all faulty subjects,
/// several, joined by “or”; where everything is faulty, `always`.
pub(crate) fn smallest_cause(checked: &[Checked<'_>]) -> String {
    if checked.iter().all(|subject| subject.faulty) {
        return "always".to_owned();
    }
    let axes = distinguishing_axes(checked);
    let mut uncovered: Vec<bool> = checked.iter().map(|subject| subject.faulty).collect();
    let mut causes = Vec::new();
    let mut level = vec![Choice {
        axes: Vec::new(),
        values: Vec::new(),
        has: vec![true; checked.len()],
    }];
    // Level by level: choices of one axis, of two, ... A choice that triggers the fault is not refined.
    while uncovered.contains(&true) && !level.is_empty() {
        let mut sufficient = Vec::new();
        let mut undecided = Vec::new();
        for choice in refined(&level, &axes) {
            let meets = |faulty| {
                checked
                    .iter()
                    .zip(&choice.has)
                    .any(|(subject, has)| *has && subject.faulty == faulty)
            };
            match (meets(true), meets(false)) {
                (true, false) => sufficient.push(choice),
                (true, true) => undecided.push(choice),
                (false, _) => {}
            }
        }
        while let Some(best) = widest(&sufficient, &uncovered) {
            for (uncovered, has) in uncovered.iter_mut().zip(&best.has) {
                *uncovered &= !has;
            }
            causes.push(described(best, &axes));
        }
        level = undecided;
    }
    causes.join(" or ")
}

/// An axis, and its values with the subjects that have each.
struct Axis {
    name: String,
    values: Vec<(String, Vec<bool>)>,
}

/// The axes that differ between subjects: no other can be part of a smallest choice.
fn distinguishing_axes(checked: &[Checked<'_>]) -> Vec<Axis> {
    let mut values: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for subject in checked {
        for (axis, value) in subject.values {
            values.entry(axis).or_default().insert(value);
        }
    }
    let has = |axis: &str, value: &str| {
        checked
            .iter()
            .map(|subject| subject.values.get(axis).is_some_and(|v| v == value))
            .collect()
    };
    values
        .into_iter()
        .filter(|(axis, values)| {
            values.len() > 1
                || checked
                    .iter()
                    .any(|subject| !subject.values.contains_key(*axis))
        })
        .map(|(axis, values)| Axis {
            name: axis.to_owned(),
            values: values
                .into_iter()
                .map(|value| (value.to_owned(), has(axis, value)))
                .collect(),
        })
        .collect()
}

/// Each choice of `level` with one more axis, after its last.
fn refined(level: &[Choice], axes: &[Axis]) -> Vec<Choice> {
    let mut refined = Vec::new();
    for choice in level {
        let first = choice.axes.last().map_or(0, |last| last + 1);
        for (axis_index, axis) in axes.iter().enumerate().skip(first) {
            for (value_index, (_, has)) in axis.values.iter().enumerate() {
                let mut longer = choice.clone();
                longer.axes.push(axis_index);
                longer.values.push(value_index);
                longer
                    .has
                    .iter_mut()
                    .zip(has)
                    .for_each(|(both, has)| *both &= has);
                refined.push(longer);
            }
        }
    }
    refined
}

/// The choice that most of `uncovered` have; of equals, the first.
fn widest<'a>(choices: &'a [Choice], uncovered: &[bool]) -> Option<&'a Choice> {
    let covers = |choice: &Choice| {
        choice
            .has
            .iter()
            .zip(uncovered)
            .filter(|(has, uncovered)| **has && **uncovered)
            .count()
    };
    let mut best = None;
    let mut most = 0;
    for choice in choices {
        let covered = covers(choice);
        if covered > most {
            most = covered;
            best = Some(choice);
        }
    }
    best
}

fn described(choice: &Choice, axes: &[Axis]) -> String {
    let parts: Vec<_> = choice
        .axes
        .iter()
        .zip(&choice.values)
        .map(|(axis, value)| format!("{}={}", axes[*axis].name, axes[*axis].values[*value].0))
        .collect();
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cause over a product of axes, where `faulty` says which subjects fail.
    fn cause(
        axes: &[(&str, &[&str])],
        faulty: impl Fn(&BTreeMap<String, String>) -> bool,
    ) -> String {
        let mut subjects = vec![BTreeMap::new()];
        for (axis, values) in axes {
            subjects = subjects
                .iter()
                .flat_map(|subject: &BTreeMap<String, String>| {
                    values.iter().map(|value| {
                        let mut subject = subject.clone();
                        subject.insert((*axis).to_owned(), (*value).to_owned());
                        subject
                    })
                })
                .collect();
        }
        let checked: Vec<_> = subjects
            .iter()
            .map(|values| Checked {
                values,
                faulty: faulty(values),
            })
            .collect();
        smallest_cause(&checked)
    }

    const AXES: [(&str, &[&str]); 4] = [
        ("light", &["directional", "point", "spot"]),
        ("method", &["basic", "none", "vsm"]),
        ("pass", &["illumination"]),
        ("pcf", &["1", "3", "5"]),
    ];

    #[test]
    fn two_axes_together() {
        let found = cause(&AXES, |values| {
            values["method"] == "vsm" && values["light"] == "point"
        });
        assert_eq!(found, "light=point, method=vsm");
    }

    #[test]
    fn one_axis() {
        assert_eq!(cause(&AXES, |values| values["pcf"] == "3"), "pcf=3");
    }

    #[test]
    fn everything() {
        assert_eq!(cause(&AXES, |_| true), "always");
        assert_eq!(cause(&[("pass", &["base"])], |_| true), "always");
    }

    #[test]
    fn either_of_two() {
        let found = cause(&AXES, |values| {
            values["light"] != "directional" && values["pcf"] == "5"
        });
        assert_eq!(found, "light=point, pcf=5 or light=spot, pcf=5");
        let found = cause(&AXES, |values| values["light"] != "spot");
        assert_eq!(found, "light=directional or light=point");
    }

    #[test]
    fn a_rule_that_implies_an_axis_is_used() {
        let spot = |cookie: &str, light: &str| {
            BTreeMap::from([
                ("cookie".to_owned(), cookie.to_owned()),
                ("light".to_owned(), light.to_owned()),
            ])
        };
        let subjects = [
            spot("off", "point"),
            spot("off", "spot"),
            spot("on", "spot"),
        ];
        let checked: Vec<_> = subjects
            .iter()
            .map(|values| Checked {
                values,
                faulty: values["cookie"] == "on",
            })
            .collect();
        assert_eq!(smallest_cause(&checked), "cookie=on");
    }

    #[test]
    fn an_axis_that_only_some_have() {
        let with = BTreeMap::from([("blur".to_owned(), "9".to_owned())]);
        let without = BTreeMap::new();
        let checked = [
            Checked {
                values: &with,
                faulty: true,
            },
            Checked {
                values: &without,
                faulty: false,
            },
        ];
        assert_eq!(smallest_cause(&checked), "blur=9");
    }
}
