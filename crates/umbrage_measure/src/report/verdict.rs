//! The configuration to choose, worked out from the figures.

use super::{
    Row,
    pareto::{Extent, front, memory, points},
};

/// How much more error than the least one accepts for speed or memory.
const NEAR: f64 = 2.0;

/// A row worth choosing, and what for.
pub(super) struct Choice<'a> {
    pub(super) row: &'a Row,
    /// Virtues that it has.
    pub(super) because: Vec<&'static str>,
    /// How many others of no more than that error may be as fast, as far as the times tell; 0 where it was not chosen by time.
    pub(super) as_fast: usize,
}

/// Rows whose error is known, and in which every sample is a shadow term.
pub(super) fn usable<'a>(rows: &[&'a Row]) -> Vec<&'a Row> {
    rows.iter()
        .copied()
        .filter(|row| row.error().is_finite() && row.figures.bad_pixels == 0)
        .collect()
}

/// The rows of one scene to choose from, the one to begin with first: the fastest within twice the least
/// error, where times tell. None where no row is usable.
pub(super) fn choices<'a>(rows: &[&'a Row]) -> Vec<Choice<'a>> {
    let usable = usable(rows);
    let Some(best) = least(&usable, [Row::error, memory]) else {
        return Vec::new();
    };
    let near: Vec<&Row> = usable
        .iter()
        .copied()
        .filter(|row| row.error() <= NEAR * best.error())
        .collect();
    let [fastest, smallest] = if best.error() == 0.0 {
        ["fastest without error", "least memory without error"]
    } else {
        [
            "fastest within twice the least error",
            "least memory within twice the least error",
        ]
    };
    let as_fast = fastest_of(&near);
    let found = [
        (fastest, least(&as_fast, [Row::error, memory])),
        (smallest, least(&near, [memory, Row::error])),
        ("least error", Some(best)),
    ];
    let mut choices: Vec<Choice<'a>> = Vec::new();
    for (why, row) in found {
        let Some(row) = row else { continue };
        // Of equals the one that is named already.
        let is_equal = |choice: &&mut Choice<'_>| {
            let figures = |row: &Row| (row.error(), row.memory_bytes);
            figures(choice.row) == figures(row)
        };
        match choices.iter_mut().find(is_equal) {
            Some(choice) => choice.because.push(why),
            None => choices.push(Choice {
                row,
                because: vec![why],
                as_fast: match why == fastest {
                    true => as_fast.len() - 1,
                    false => 0,
                },
            }),
        }
    }
    choices
}

/// The rows of `rows` that may be the fastest: whose time is not told apart from the least median. Which of them was a little
/// ahead is noise.
fn fastest_of<'a>(rows: &[&'a Row]) -> Vec<&'a Row> {
    let told = rows.iter().copied().filter(|row| row.time_ratio.is_told());
    let median = |row: &Row| row.time_ratio.median;
    let fastest = told.clone().min_by(|a, b| median(a).total_cmp(&median(b)));
    told.filter(|row| fastest.is_some_and(|fastest| row.time_ratio.overlaps(&fastest.time_ratio)))
        .collect()
}

/// The least error for each budget: usable rows, the cheapest first, of which each is for certain dearer than the one before, and
/// errs less.
pub(super) fn ladder<'a>(rows: &[&'a Row], cost: fn(&Row) -> Extent) -> Vec<&'a Row> {
    let usable = usable(rows);
    let marks = front(&points(&usable, cost));
    let mut on_front: Vec<&Row> = usable
        .into_iter()
        .zip(marks)
        .filter_map(|(row, on_front)| on_front.then_some(row))
        .collect();
    // From the least error up; of equal errors the cheapest first.
    on_front.sort_by(|a, b| {
        let error = a.error().total_cmp(&b.error());
        let costs = cost(a).high.total_cmp(&cost(b).high);
        error.then(costs).then_with(|| by_name(a, b))
    });
    let mut steps: Vec<&Row> = Vec::new();
    for row in on_front {
        let cheaper = |last: &&Row| cost(row).high < cost(last).low;
        let is_equal = |last: &&Row| cost(row) == cost(last) && row.error() == last.error();
        if steps
            .last()
            .is_none_or(|last| cheaper(last) || is_equal(last))
        {
            steps.push(row);
        }
    }
    steps.reverse();
    steps
}

/// The row with the least first number, among equals the least second; at last the first by name, so that the order of the rows
/// makes no difference.
fn least<'a>(rows: &[&'a Row], keys: [fn(&Row) -> f64; 2]) -> Option<&'a Row> {
    rows.iter().copied().min_by(|a, b| {
        keys.iter()
            .map(|key| (key(a) + 0.0).total_cmp(&(key(b) + 0.0)))
            .find(|order| order.is_ne())
            .unwrap_or_else(|| by_name(a, b))
    })
}

fn by_name(a: &Row, b: &Row) -> std::cmp::Ordering {
    let name = |row: &'_ Row| (row.method.clone(), row.config.clone(), row.path);
    name(a).cmp(&name(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Ratio, pareto::time, tests::rows::measured};

    fn named<'a>(choices: &[Choice<'a>]) -> Vec<(&'a str, usize)> {
        choices
            .iter()
            .map(|c| (c.row.config.as_str(), c.because.len()))
            .collect()
    }

    #[test]
    fn the_choices_are_what_they_are_called() {
        let rows = [
            measured("exact", 0.010, 9.0, 900),
            measured("quick", 0.019, 2.0, 500),
            measured("small", 0.020, 3.0, 100),
            measured("coarse", 0.021, 1.0, 50),
        ];
        let rows: Vec<&Row> = rows.iter().collect();
        let found = choices(&rows);
        assert_eq!(named(&found), [("quick", 1), ("small", 1), ("exact", 1)]);
        assert_eq!(found[0].because, ["fastest within twice the least error"]);
        assert_eq!(
            found[1].because,
            ["least memory within twice the least error"]
        );
        assert_eq!(found[2].because, ["least error"]);
    }

    #[test]
    fn one_row_with_all_virtues_is_named_once() {
        let rows = [
            measured("best", 0.0, 1.0, 50),
            measured("as good, slower", 0.0, 1.5, 50),
            measured("worse", 0.001, 0.5, 10),
        ];
        let rows: Vec<&Row> = rows.iter().collect();
        let found = choices(&rows);
        assert_eq!(named(&found), [("best", 3)]);
        assert_eq!(found[0].because[0], "fastest without error");
    }

    #[test]
    fn what_is_broken_or_unmeasured_is_not_proposed() {
        let mut bad = measured("bad", 0.001, 0.5, 10);
        bad.figures.bad_pixels = 1;
        let rows = [
            bad,
            measured("unknown", f64::NAN, 0.5, 10),
            measured("untimed", 0.010, f64::NAN, 20),
            measured("timed", 0.015, 4.0, 30),
        ];
        let all: Vec<&Row> = rows.iter().collect();
        assert_eq!(named(&choices(&all)), [("timed", 1), ("untimed", 2)]);
        assert!(choices(&all[..2]).is_empty());
        let steps: Vec<_> = ladder(&all, time)
            .iter()
            .map(|r| r.config.clone())
            .collect();
        assert_eq!(steps, ["timed"]);
    }

    #[test]
    fn a_ladder_costs_more_at_each_step_and_errs_less() {
        let rows = [
            measured("c", 0.01, 3.0, 1),
            measured("a", 0.03, 1.0, 1),
            measured("wasteful", 0.02, 4.0, 1),
            measured("b", 0.02, 2.0, 1),
        ];
        let rows: Vec<&Row> = rows.iter().collect();
        let steps: Vec<_> = ladder(&rows, time)
            .iter()
            .map(|r| r.config.as_str())
            .collect();
        assert_eq!(steps, ["a", "b", "c"]);
        let by_memory = ladder(&rows, |row| Extent::exactly(memory(row)));
        assert_eq!(by_memory.len(), 1);
    }

    fn between(config: &str, error: f64, low: f64, high: f64) -> Row {
        let mut row = measured(config, error, 1.0, 100);
        row.time_ratio = Ratio {
            median: 0.5 * (low + high),
            low,
            high,
            pairs: 20,
        };
        row
    }

    #[test]
    fn of_what_may_be_as_fast_the_least_error_is_chosen() {
        let rows = [
            between("ahead by chance", 0.019, 0.95, 1.05),
            between("as fast", 0.012, 0.97, 1.10),
            between("slower", 0.010, 1.20, 1.25),
            // Nothing is known of its time, whatever its median.
            between("too noisy", 0.011, 0.30, 0.90),
        ];
        let rows: Vec<&Row> = rows.iter().collect();
        let found = choices(&rows);
        assert_eq!(
            (found[0].row.config.as_str(), found[0].as_fast),
            ("as fast", 1)
        );
        let steps: Vec<_> = ladder(&rows, time)
            .iter()
            .map(|r| r.config.as_str())
            .collect();
        assert_eq!(steps, ["as fast", "slower"]);
    }
}
