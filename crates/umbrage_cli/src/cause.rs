//! The smallest choice of axes that triggers a fault.

use std::collections::{BTreeMap, BTreeSet};

/// What was checked: the value of every axis, and whether the fault was found with them.
pub(crate) struct Checked<'a> {
    /// The value of every axis.
    pub(crate) values: &'a BTreeMap<String, String>,
    /// Whether the fault was found.
    pub(crate) faulty: bool,
}

/// Axes with their values, both as numbers; the axes ascend.
type Choice = Vec<(usize, usize)>;

/// A set of subjects, 64 to a word.
type Subjects = Vec<u64>;

/// The smallest choice of axes that triggers a fault, among what was checked: the fewest axes with such
/// values that whatever has these values has the fault. Where no one choice covers all faulty subjects,
/// several, joined by “or”; where everything is faulty, `always`.
pub(crate) fn smallest_cause(checked: &[Checked<'_>]) -> String {
    let mut uncovered = subjects(checked.iter().map(|subject| subject.faulty));
    let clean = subjects(checked.iter().map(|subject| !subject.faulty));
    if is_empty(&clean) {
        return "always".to_owned();
    }
    let axes = distinguishing_axes(checked);
    let mut causes = Vec::new();
    let mut level = vec![Choice::new()];
    // Level by level: choices of one axis, of two, ... What triggers the fault, or has nothing to do
    // with it, is not refined.
    while !is_empty(&uncovered) && !level.is_empty() {
        let mut sufficient = Vec::new();
        let mut undecided = Vec::new();
        for choice in level.iter().flat_map(|choice| refined(choice, &axes)) {
            let has = having(&choice, &axes, checked.len());
            if count_both(&has, &uncovered) == 0 {
                continue;
            }
            let list = if count_both(&has, &clean) == 0 {
                &mut sufficient
            } else {
                &mut undecided
            };
            list.push(choice);
        }
        loop {
            let covers =
                |choice: &Choice| count_both(&having(choice, &axes, checked.len()), &uncovered);
            // Of equals the first, which `max_by_key` would pass over.
            let best = sufficient.iter().rev().max_by_key(|choice| covers(choice));
            let Some(best) = best.filter(|choice| covers(choice) > 0) else {
                break;
            };
            causes.push(described(best, &axes));
            let has = having(best, &axes, checked.len());
            uncovered
                .iter_mut()
                .zip(has)
                .for_each(|(uncovered, has)| *uncovered &= !has);
        }
        level = undecided;
    }
    causes.join(" or ")
}

/// An axis, and its values with the subjects that have each.
struct Axis {
    name: String,
    values: Vec<(String, Subjects)>,
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
        subjects(
            checked
                .iter()
                .map(|subject| subject.values.get(axis).is_some_and(|v| v == value)),
        )
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

/// `choice` with one more axis, after its last.
fn refined(choice: &Choice, axes: &[Axis]) -> Vec<Choice> {
    let first = choice.last().map_or(0, |(axis, _)| axis + 1);
    let mut refined = Vec::new();
    for (axis_index, axis) in axes.iter().enumerate().skip(first) {
        for value_index in 0..axis.values.len() {
            let mut longer = choice.clone();
            longer.push((axis_index, value_index));
            refined.push(longer);
        }
    }
    refined
}

/// The subjects, of `count`, that have all of `choice`.
fn having(choice: &Choice, axes: &[Axis], count: usize) -> Subjects {
    let mut all = vec![u64::MAX; count.div_ceil(64)];
    for (axis, value) in choice {
        all.iter_mut()
            .zip(&axes[*axis].values[*value].1)
            .for_each(|(all, has)| *all &= has);
    }
    all
}

fn subjects(members: impl Iterator<Item = bool>) -> Subjects {
    let mut subjects = Subjects::new();
    for (index, member) in members.enumerate() {
        if index % 64 == 0 {
            subjects.push(0);
        }
        if member {
            subjects[index / 64] |= 1 << (index % 64);
        }
    }
    subjects
}

fn is_empty(subjects: &Subjects) -> bool {
    subjects.iter().all(|word| *word == 0)
}

fn count_both(a: &Subjects, b: &Subjects) -> u32 {
    a.iter().zip(b).map(|(a, b)| (a & b).count_ones()).sum()
}

fn described(choice: &Choice, axes: &[Axis]) -> String {
    let part = |(axis, value): &(usize, usize)| {
        format!("{}={}", axes[*axis].name, axes[*axis].values[*value].0)
    };
    choice.iter().map(part).collect::<Vec<_>>().join(", ")
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
