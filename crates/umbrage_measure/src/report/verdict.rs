//! The configuration to choose, worked out from the figures.

use super::{
    Ratio, Row,
    pareto::{Extent, front, memory, points},
};

/// How much more error than the least one accepts for speed or memory.
const NEAR: f64 = 2.0;

/// A configuration to choose or not: a row, in its own scene; or in all scenes, with its worst figures.
#[derive(Clone, Copy)]
pub(super) struct Candidate<'a> {
    /// The row, or one of the configuration's rows.
    pub(super) row: &'a Row,
    /// The share of the samples that are wrong; in all scenes, over the least of each scene.
    pub(super) error: f64,
    pub(super) time: Ratio,
    pub(super) memory: f64,
}

/// A candidate worth choosing, and what for.
pub(super) struct Choice<'a> {
    pub(super) candidate: Candidate<'a>,
    /// Virtues that it has.
    pub(super) because: Vec<&'static str>,
    /// How many others of no more than twice the least error may be as fast, as far as the times tell; 0 where it was not chosen by
    /// time.
    pub(super) as_fast: usize,
}

/// Rows whose error is known, and in which every sample is a shadow term.
fn usable<'a>(rows: &[&'a Row]) -> Vec<&'a Row> {
    rows.iter()
        .copied()
        .filter(|row| row.error().is_finite() && row.figures.bad_pixels == 0)
        .collect()
}

/// The usable rows of one scene.
pub(super) fn in_scene<'a>(rows: &[&'a Row]) -> Vec<Candidate<'a>> {
    let usable = usable(rows).into_iter();
    usable
        .map(|row| Candidate {
            row,
            error: row.error(),
            time: row.time_ratio,
            memory: memory(row),
        })
        .collect()
}

/// The configurations that serve all scenes. Each line of `lines` is one configuration's rows, a scene each. Of those with a usable row
/// in every scene, the error is the worst multiple of the least error in a scene, where an error below one sample counts as
/// one; time and memory are the most.
pub(super) fn in_all_scenes<'a>(lines: &[&[Option<&'a Row>]]) -> Vec<Candidate<'a>> {
    let of_scene = |scene: usize| {
        let rows = lines.iter().filter_map(move |line| *line.get(scene)?);
        usable(&rows.collect::<Vec<_>>())
    };
    let floored = |row: &Row| row.error().max(1.0 / row.figures.compared.max(1) as f64);
    let scenes = lines.first().map_or(0, |line| line.len());
    let least: Vec<f64> = (0..scenes)
        .map(|scene| {
            of_scene(scene)
                .into_iter()
                .map(floored)
                .fold(f64::INFINITY, f64::min)
        })
        .collect();
    let candidate = |line: &&[Option<&'a Row>]| {
        let rows: Vec<&Row> = line.iter().copied().collect::<Option<_>>()?;
        let row = *rows.first()?;
        if usable(&rows).len() < rows.len() {
            return None;
        }
        let worst = |figure: &dyn Fn(&Row) -> f64| {
            rows.iter()
                .map(|row| figure(row))
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let multiples = rows
            .iter()
            .zip(&least)
            .map(|(row, least)| floored(row) / least);
        let all_told = rows.iter().all(|row| row.time_ratio.is_told());
        Some(Candidate {
            row,
            error: multiples.fold(0.0, f64::max),
            // The greatest of several medians lies between the greatest of the lower and of the upper ends.
            time: match all_told {
                true => Ratio {
                    median: worst(&|row| row.time_ratio.median),
                    low: worst(&|row| row.time_ratio.low),
                    high: worst(&|row| row.time_ratio.high),
                    pairs: rows
                        .iter()
                        .map(|row| row.time_ratio.pairs)
                        .min()
                        .unwrap_or(0),
                },
                false => Ratio::default(),
            },
            memory: worst(&memory),
        })
    };
    lines.iter().filter_map(candidate).collect()
}

/// The candidates to choose, the one to begin with first: the fastest within twice the least
/// error, where times tell. None where there is no candidate.
pub(super) fn choices<'a>(candidates: &[Candidate<'a>]) -> Vec<Choice<'a>> {
    let error = |candidate: &Candidate<'_>| candidate.error;
    let memory = |candidate: &Candidate<'_>| candidate.memory;
    let Some(best) = least(candidates, [error, memory]) else {
        return Vec::new();
    };
    let near = candidates.iter().copied();
    let near: Vec<_> = near
        .filter(|candidate| candidate.error <= NEAR * best.error)
        .collect();
    let [fastest, smallest] = if best.error == 0.0 {
        ["fastest without error", "least memory without error"]
    } else {
        [
            "fastest within twice the least error",
            "least memory within twice the least error",
        ]
    };
    let as_fast = fastest_of(&near);
    let found = [
        (fastest, least(&as_fast, [error, memory])),
        (smallest, least(&near, [memory, error])),
        ("least error", Some(best)),
    ];
    let mut choices: Vec<Choice<'a>> = Vec::new();
    for (why, candidate) in found {
        let Some(candidate) = candidate else { continue };
        // Of equals the one that is named already.
        let is_equal = |choice: &&mut Choice<'_>| {
            (choice.candidate.error, choice.candidate.memory) == (candidate.error, candidate.memory)
        };
        match choices.iter_mut().find(is_equal) {
            Some(choice) => choice.because.push(why),
            None => choices.push(Choice {
                candidate,
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

/// The candidates that may be the fastest: whose time is not told apart from the least median. Which of them was a little
/// ahead is noise.
fn fastest_of<'a>(candidates: &[Candidate<'a>]) -> Vec<Candidate<'a>> {
    let told = candidates
        .iter()
        .copied()
        .filter(|candidate| candidate.time.is_told());
    let fastest = told
        .clone()
        .min_by(|a, b| a.time.median.total_cmp(&b.time.median));
    told.filter(|candidate| fastest.is_some_and(|fastest| candidate.time.overlaps(&fastest.time)))
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

/// The candidate with the least first number, among equals the least second; at last the first by name, so that their order
/// makes no difference.
fn least<'a>(
    candidates: &[Candidate<'a>],
    keys: [fn(&Candidate<'_>) -> f64; 2],
) -> Option<Candidate<'a>> {
    candidates.iter().copied().min_by(|a, b| {
        keys.iter()
            .map(|key| (key(a) + 0.0).total_cmp(&(key(b) + 0.0)))
            .find(|order| order.is_ne())
            .unwrap_or_else(|| by_name(a.row, b.row))
    })
}

fn by_name(a: &Row, b: &Row) -> std::cmp::Ordering {
    let name = |row: &'_ Row| (row.method.clone(), row.config.clone(), row.path);
    name(a).cmp(&name(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{pareto::time, tests::rows::measured};

    fn named<'a>(choices: &[Choice<'a>]) -> Vec<(&'a str, usize)> {
        choices
            .iter()
            .map(|c| (c.candidate.row.config.as_str(), c.because.len()))
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
        let found = choices(&in_scene(&rows));
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
        let found = choices(&in_scene(&rows));
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
        assert_eq!(
            named(&choices(&in_scene(&all))),
            [("timed", 1), ("untimed", 2)]
        );
        assert!(choices(&in_scene(&all[..2])).is_empty());
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
        let found = choices(&in_scene(&rows));
        assert_eq!(
            (found[0].candidate.row.config.as_str(), found[0].as_fast),
            ("as fast", 1)
        );
        let steps: Vec<_> = ladder(&rows, time)
            .iter()
            .map(|r| r.config.as_str())
            .collect();
        assert_eq!(steps, ["as fast", "slower"]);
    }

    /// One is best in the first scene and worst in the second; another is near the least error in both.
    #[test]
    fn one_for_all_scenes_is_judged_by_its_worst() {
        let mut rows = [
            measured("first", 0.010, 1.0, 100),
            measured("first", 0.080, 1.0, 100),
            measured("both", 0.015, 1.5, 200),
            measured("both", 0.022, 2.5, 400),
            measured("second", 0.050, 1.0, 100),
            measured("second", 0.020, 1.0, 100),
            measured("bad", 0.010, 0.5, 10),
            measured("bad", 0.020, 0.5, 10),
        ];
        for row in &mut rows {
            row.figures.compared = 10_000;
        }
        rows[7].figures.bad_pixels = 1;
        let mut only = measured("only in one", 0.001, 1.0, 1);
        only.figures.compared = 10_000;
        let mut lines: Vec<Vec<Option<&Row>>> = rows
            .chunks(2)
            .map(|pair| pair.iter().map(Some).collect())
            .collect();
        lines.push(vec![None, Some(&only)]);
        let lines: Vec<_> = lines.iter().map(Vec::as_slice).collect();
        // A configuration drawn in one scene alone sets the mark there, but serves nobody.
        let multiples = |lines: &[&[Option<&Row>]]| -> Vec<_> {
            let found = in_all_scenes(lines).into_iter();
            found
                .map(|c| (c.row.config.clone(), (100.0 * c.error).round()))
                .collect()
        };
        assert_eq!(
            multiples(&lines[..4]),
            [
                ("first".to_owned(), 400.0),
                ("both".to_owned(), 150.0),
                ("second".to_owned(), 500.0)
            ]
        );
        assert_eq!(multiples(&lines)[1], ("both".to_owned(), 2200.0));
        let found = choices(&in_all_scenes(&lines[..4]));
        assert_eq!(named(&found), [("both", 3)]);
        let both = found[0].candidate;
        assert_eq!((both.time.median, both.memory), (2.5, 400.0));
        // Where nothing is wrong, a sample more is.
        let mut none = [measured("a", 0.0, 1.0, 1), measured("b", 2e-4, 1.0, 1)];
        for row in &mut none {
            row.figures.compared = 10_000;
        }
        let lines = [&[Some(&none[0])][..], &[Some(&none[1])]];
        assert_eq!(multiples(&lines)[1], ("b".to_owned(), 200.0));
        assert!(in_all_scenes(&[]).is_empty());
    }
}
