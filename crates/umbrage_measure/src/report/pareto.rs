//! Rows that are worth having.

use std::collections::BTreeMap;

use super::{Ratio, Row};

/// Sets `pareto` of each row: whether it is on the front of error and time, or on that of error and
/// memory, among the rows of its scene.
pub(super) fn mark(rows: &mut [Row]) {
    let mut scenes: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (index, row) in rows.iter().enumerate() {
        scenes.entry(row.scene.clone()).or_default().push(index);
    }
    for indices in scenes.into_values() {
        let members: Vec<&Row> = indices.iter().filter_map(|i| rows.get(*i)).collect();
        let time = front(&points(&members, time));
        let memory = front(&points(&members, |row| Extent::exactly(memory(row))));
        for ((index, time), memory) in indices.into_iter().zip(time).zip(memory) {
            if let Some(row) = rows.get_mut(index) {
                row.pareto = time || memory;
            }
        }
    }
}

/// Bytes, as a number beside others.
pub(super) fn memory(row: &Row) -> f64 {
    row.memory_bytes as f64
}

/// A cost, as far as it is known: it lies between two numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Extent {
    pub(super) fn exactly(value: f64) -> Self {
        Self {
            low: value,
            high: value,
        }
    }

    /// A cost that was not measured.
    const UNKNOWN: Self = Self {
        low: f64::NAN,
        high: f64::NAN,
    };
}

/// The time of a row; unknown where the machine was too busy to tell.
pub(super) fn time(row: &Row) -> Extent {
    let Ratio { low, high, .. } = row.time_ratio;
    match row.time_ratio.is_told() {
        true => Extent { low, high },
        false => Extent::UNKNOWN,
    }
}

/// A cost and the error for each row.
pub(super) fn points(rows: &[&Row], cost: impl Fn(&Row) -> Extent) -> Vec<(Extent, f64)> {
    rows.iter().map(|row| (cost(row), row.error())).collect()
}

/// For each point, whether no other beats it: costs for certain no more and errs no more, and does one of the two less. A figure that
/// is not finite was not measured: it is not on the front, and keeps no other off it. Equal points are on it together, as are
/// points whose costs are not told apart.
pub(super) fn front(points: &[(Extent, f64)]) -> Vec<bool> {
    let is_measured = |(cost, error): &(Extent, f64)| {
        cost.low.is_finite() && cost.high.is_finite() && error.is_finite()
    };
    let beats = |a: &(Extent, f64), b: &(Extent, f64)| {
        let no_worse = a.0.high <= b.0.low && a.1 <= b.1;
        no_worse && (a.0.high < b.0.low || a.1 < b.1)
    };
    let measured: Vec<_> = points.iter().filter(|point| is_measured(point)).collect();
    points
        .iter()
        .map(|point| is_measured(point) && !measured.iter().any(|other| beats(other, point)))
        .collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn exact(points: &[(f64, f64)]) -> Vec<bool> {
        let points: Vec<_> = points
            .iter()
            .map(|(x, y)| (Extent::exactly(*x), *y))
            .collect();
        front(&points)
    }

    #[test]
    fn equal_points_are_on_the_front_together() {
        let points = [(1.0, 2.0), (1.0, 2.0), (1.0, 3.0), (2.0, 2.0), (2.0, 1.0)];
        assert_eq!(exact(&points), [true, true, false, false, true]);
        // −0 is 0.
        assert_eq!(exact(&[(0.0, 1.0), (-0.0, 1.0)]), [true, true]);
    }

    #[test]
    fn no_point_is_kept_off_by_what_was_not_measured() {
        let points = [
            (f64::NAN, 0.0),
            (1.0, f64::NAN),
            (f64::NEG_INFINITY, 0.0),
            (1.0, 1.0),
        ];
        assert_eq!(exact(&points), [false, false, false, true]);
    }

    #[test]
    fn costs_that_overlap_beat_nothing() {
        let of = |low: f64, high: f64, error: f64| (Extent { low, high }, error);
        let points = [
            of(1.0, 1.2, 2.0),
            of(1.1, 1.4, 1.0),
            of(1.3, 1.5, 2.0),
            of(1.5, 1.6, 1.5),
        ];
        // The third is beaten by the first, for certain; the fourth by the second.
        assert_eq!(front(&points), [true, true, false, false]);
    }

    /// Few values, so that there are many ties.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![
            4 => (0_i32..6).prop_map(f64::from),
            1 => 0.0..5.0,
        ]
    }

    proptest! {
        /// A point off the front has something on it that is for certain no dearer and errs no more.
        #[test]
        fn each_point_off_the_front_is_beaten_by_one_on_it(
            points in prop::collection::vec((coordinate(), 0.0..2.0, coordinate()), 1..24)
        ) {
            let points: Vec<_> = points.into_iter()
                .map(|(low, wide, error)| (Extent { low, high: low + wide }, error))
                .collect();
            let marks = front(&points);
            prop_assert!(marks.contains(&true));
            for (point, _) in points.iter().zip(&marks).filter(|(_, on_front)| !**on_front) {
                let mut on_front = points.iter().zip(&marks).filter(|(_, on_front)| **on_front);
                prop_assert!(on_front.any(|(other, _)| other.0.high <= point.0.low && other.1 <= point.1));
            }
        }

        #[test]
        fn a_row_is_marked_where_it_is_on_either_front_of_its_scene(
            rows in prop::collection::vec((0_u8..3, coordinate(), coordinate(), 0_u64..6), 0..24)
        ) {
            let mut rows: Vec<Row> = rows
                .into_iter()
                .map(|(scene, error, time, memory_bytes)| {
                    let mut row = crate::report::tests::rows::row(&scene.to_string(), "basic", "a");
                    row.figures.false_lit = error;
                    row.time_ratio = Ratio::exactly(time + 1.0);
                    row.memory_bytes = memory_bytes;
                    row
                })
                .collect();
            mark(&mut rows);
            for scene in ["0", "1", "2"] {
                let members: Vec<&Row> = rows.iter().filter(|row| row.scene == scene).collect();
                let by_time = front(&points(&members, time));
                let by_memory = front(&points(&members, |row| Extent::exactly(memory(row))));
                for ((row, time), memory) in members.iter().zip(by_time).zip(by_memory) {
                    prop_assert_eq!(row.pareto, time || memory);
                }
            }
        }
    }
}
