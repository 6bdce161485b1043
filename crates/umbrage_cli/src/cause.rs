//! The smallest choice of axes that triggers a fault.

/// An axis and its values.
pub(crate) type Axis = (String, Vec<String>);

/// A checked permutation: a bit for each value of each axis, in their order, 64 to a word: whether some of its keys may
/// have it; and whether it has the fault.
pub(crate) type Checked = (Vec<u64>, bool);

/// Axes with their values, both as numbers; the axes ascend.
type Choice = Vec<(usize, usize)>;

/// A set of permutations, 64 to a word.
type Subjects = Vec<u64>;

/// The smallest choice of `axes` that triggers a fault, among the checked permutations: the fewest axes and values such
/// that every permutation that may have these values has the fault. Among equally small choices that explain as many
/// faults, the first axes win. Where no one choice covers all faulty permutations, several, joined by “or”; where
/// everything is faulty, `always`.
pub(crate) fn smallest_cause(axes: &[Axis], mut checked: Vec<Checked>) -> String {
    // Permutations that agree on all axes count once.
    checked.sort_unstable();
    checked.dedup();
    let mut uncovered = subjects(checked.iter().map(|(_, faulty)| *faulty));
    let clean = subjects(checked.iter().map(|(_, faulty)| !faulty));
    if is_empty(&clean) {
        return "always".to_owned();
    }
    let axes = distinguishing_axes(axes, &checked);
    if checked.len() > EXACT {
        return minimal_causes(&axes, uncovered, &clean);
    }
    let mut causes = Vec::new();
    let mut level = vec![Choice::new()];
    // Level by level: choices of one axis, of two, ... A set that triggers the fault, or has nothing to
    // do with it, is not refined.
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

/// Most permutations among which the smallest causes are searched for: the search takes as long as they are many, for
/// each of thousands of choices.
const EXACT: usize = 1 << 14;

/// Most causes that are told of very many permutations.
const TOLD: usize = 8;

/// Causes from which no axis can be left out: from all choices of the first faulty permutation that is not yet covered,
/// axes are dropped while no clean permutation has the rest, the last axes first.
fn minimal_causes(axes: &[Column], mut uncovered: Subjects, clean: &Subjects) -> String {
    let count = clean.len() * 64;
    let mut causes = Vec::new();
    while let Some(word) = uncovered.iter().position(|word| *word != 0) {
        if causes.len() == TOLD {
            causes.push("other choices".to_owned());
            break;
        }
        let (bit, mut cause) = (uncovered[word].trailing_zeros(), Choice::new());
        for (index, axis) in axes.iter().enumerate() {
            let has = |(_, column): &(String, Subjects)| column[word] >> bit & 1 == 1;
            let mut own = (0..).zip(&axis.values).filter(|(_, value)| has(value));
            // Where it may have several values, the axis has nothing to do with it.
            if let (Some((value, _)), None) = (own.next(), own.next()) {
                cause.push((index, value));
            }
        }
        for place in (0..cause.len()).rev() {
            let mut less = cause.clone();
            less.remove(place);
            if count_both(&having(&less, axes, count), clean) == 0 {
                cause = less;
            }
        }
        causes.push(described(&cause, axes));
        let has = having(&cause, axes, count);
        let covered = uncovered.iter_mut().zip(has);
        covered.for_each(|(uncovered, has)| *uncovered &= !has);
        // Whatever else there is, the permutation itself is covered.
        uncovered[word] &= !(1 << bit);
    }
    causes.join(" or ")
}

/// An axis, and its values with the permutations that may have each.
struct Column {
    name: String,
    values: Vec<(String, Subjects)>,
}

/// Axes whose values differ between permutations: no other axis can be part of a smallest choice.
fn distinguishing_axes(axes: &[Axis], checked: &[Checked]) -> Vec<Column> {
    let count = axes.iter().map(|(_, values)| values.len()).sum();
    let mut columns = vec![vec![0; checked.len().div_ceil(64)]; count];
    for (row, (words, _)) in checked.iter().enumerate() {
        for (index, word) in words.iter().enumerate() {
            let mut rest = *word;
            while rest != 0 {
                columns[index * 64 + rest.trailing_zeros() as usize][row / 64] |= 1 << (row % 64);
                rest &= rest - 1;
            }
        }
    }
    let all = subjects(checked.iter().map(|_| true));
    let mut columns = columns.into_iter();
    let mut distinguishing = Vec::new();
    for (name, values) in axes {
        let columns: Vec<_> = columns.by_ref().take(values.len()).collect();
        if columns
            .iter()
            .any(|column| *column != all && !is_empty(column))
        {
            distinguishing.push(Column {
                name: name.clone(),
                values: values.iter().cloned().zip(columns).collect(),
            });
        }
    }
    distinguishing
}

/// `choice` with one more axis, after its last.
fn refined(choice: &Choice, axes: &[Column]) -> Vec<Choice> {
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
fn having(choice: &Choice, axes: &[Column], count: usize) -> Subjects {
    let mut all = vec![u64::MAX; count.div_ceil(64)];
    for (axis, value) in choice {
        all.iter_mut()
            .zip(&axes[*axis].values[*value].1)
            .for_each(|(all, has)| *all &= has);
    }
    all
}

pub(crate) fn subjects(members: impl Iterator<Item = bool>) -> Subjects {
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

fn described(choice: &Choice, axes: &[Column]) -> String {
    let part = |(axis, value): &(usize, usize)| {
        format!("{}={}", axes[*axis].name, axes[*axis].values[*value].0)
    };
    let mut parts: Vec<_> = choice.iter().map(part).collect();
    parts.sort();
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::*;

    type Values = BTreeMap<&'static str, &'static str>;

    /// The cause among `subjects`, with the axes in the order of their names.
    fn cause_among(subjects: &[Values], faulty: impl Fn(&Values) -> bool) -> String {
        let names: BTreeSet<_> = subjects.iter().flat_map(BTreeMap::keys).copied().collect();
        let axes = names.into_iter().map(|axis| {
            let values: BTreeSet<_> = subjects.iter().filter_map(|s| s.get(axis)).collect();
            let values = values.into_iter().map(|value| (*value).to_owned());
            (axis.to_owned(), values.collect())
        });
        let axes: Vec<Axis> = axes.collect();
        let checked = subjects.iter().map(|subject| {
            let has = axes.iter().flat_map(|(axis, values)| {
                let own = subject.get(axis.as_str());
                values.iter().map(move |value| own == Some(&value.as_str()))
            });
            (super::subjects(has), faulty(subject))
        });
        smallest_cause(&axes, checked.collect())
    }

    /// The cause over a product of axes, where `faulty` says which subjects fail.
    fn cause(axes: &[(&'static str, &[&'static str])], faulty: impl Fn(&Values) -> bool) -> String {
        let mut subjects = vec![Values::new()];
        for (axis, values) in axes {
            let longer = subjects.iter().flat_map(|subject| {
                values.iter().map(|value| {
                    let mut subject = subject.clone();
                    subject.insert(axis, value);
                    subject
                })
            });
            subjects = longer.collect();
        }
        cause_among(&subjects, faulty)
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
        let spot = |cookie, light| Values::from([("cookie", cookie), ("light", light)]);
        let subjects = [
            spot("off", "point"),
            spot("off", "spot"),
            spot("on", "spot"),
        ];
        let found = cause_among(&subjects, |values| values["cookie"] == "on");
        assert_eq!(found, "cookie=on");
    }

    #[test]
    fn an_axis_that_only_some_have() {
        let subjects = [Values::from([("blur", "9")]), Values::new()];
        let found = cause_among(&subjects, |values| values.contains_key("blur"));
        assert_eq!(found, "blur=9");
    }

    /// Among very many permutations too.
    #[test]
    fn a_cause_among_many_is_found() {
        let digits: Vec<String> = (0..10).map(|digit| digit.to_string()).collect();
        let axes: Vec<Axis> = (0..5).map(|n| (format!("a{n}"), digits.clone())).collect();
        let faulty = |number: usize| number / 10 % 10 == 3 && number / 1000 % 10 == 7;
        let checked = (0..100_000).map(|number: usize| {
            let has = (0..5).flat_map(|axis| {
                let digit = number / 10usize.pow(axis) % 10;
                (0..10).map(move |value| value == digit)
            });
            (subjects(has), faulty(number))
        });
        let checked: Vec<_> = checked.collect();
        assert!(checked.len() > EXACT);
        assert_eq!(smallest_cause(&axes, checked), "a1=3, a3=7");
    }

    #[test]
    fn the_first_of_equal_axes_is_told() {
        // A pass with a draw of its own has no method.
        let method = || {
            (
                "method".to_owned(),
                vec!["basic".to_owned(), "none".to_owned()],
            )
        };
        let pass = || ("pass".to_owned(), vec!["lit".to_owned(), "own".to_owned()]);
        let checked = vec![(vec![0b1010], true), (vec![0b0101], false)];
        assert_eq!(
            smallest_cause(&[method(), pass()], checked.clone()),
            "method=none"
        );
        assert_eq!(smallest_cause(&[pass(), method()], checked), "pass=own");
    }
}
