//! Rows that are worth having.

use std::collections::BTreeMap;

use super::Row;

/// Sets `pareto` of each row: whether it is on the front of error and time, or on that of error and
/// memory, among the rows of its scene.
pub(super) fn mark(rows: &mut [Row]) {
    let mut scenes: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (index, row) in rows.iter().enumerate() {
        scenes.entry(row.scene.clone()).or_default().push(index);
    }
    for indices in scenes.into_values() {
        let members: Vec<&Row> = indices.iter().filter_map(|i| rows.get(*i)).collect();
        let time = front(&points(&members, |row| row.time_ratio));
        let memory = front(&points(&members, memory));
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

/// A cost and the error for each row.
pub(super) fn points(rows: &[&Row], cost: impl Fn(&Row) -> f64) -> Vec<(f64, f64)> {
    rows.iter().map(|row| (cost(row), row.error())).collect()
}

/// For each point, whether no other is at once no greater and somewhere less. A figure that is not finite was not
/// measured: it is not on the front, and keeps no other off it. Equal points are on it together.
pub(super) fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let mut order: Vec<_> = points
        .iter()
        .enumerate()
        .filter(|(_, (x, y))| x.is_finite() && y.is_finite())
        // Adding 0 makes −0 a 0: the order below tells them apart.
        .map(|(index, (x, y))| (x + 0.0, y + 0.0, index))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut on_front = vec![false; points.len()];
    let mut least = (f64::NAN, f64::INFINITY);
    for (x, y, index) in order {
        if y < least.1 || (x, y) == least {
            least = (x, y);
            if let Some(mark) = on_front.get_mut(index) {
                *mark = true;
            }
        }
    }
    on_front
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The definition, word for word.
    fn by_definition(points: &[(f64, f64)]) -> Vec<bool> {
        let measured = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
        let beats = |a: &(f64, f64), b: &(f64, f64)| {
            measured(a) && a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1)
        };
        points
            .iter()
            .map(|point| measured(point) && !points.iter().any(|other| beats(other, point)))
            .collect()
    }

    /// Few values, so that there are many ties; and what is no number.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![
            8 => (0_i32..6).prop_map(f64::from),
            1 => Just(-0.0),
            1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY)],
            2 => 0.0..5.0,
        ]
    }

    proptest! {
        #[test]
        fn the_front_is_the_definition(
            points in prop::collection::vec((coordinate(), coordinate()), 0..24)
        ) {
            prop_assert_eq!(front(&points), by_definition(&points));
        }

        #[test]
        fn a_row_is_marked_where_it_is_on_either_front_of_its_scene(
            rows in prop::collection::vec((0_u8..3, coordinate(), coordinate(), 0_u64..6), 0..24)
        ) {
            let mut rows: Vec<Row> = rows
                .into_iter()
                .map(|(scene, error, time_ratio, memory_bytes)| {
                    let mut row = crate::report::tests::rows::row(&scene.to_string(), "basic", "a");
                    row.figures.false_lit = error;
                    row.figures.false_shadow = 0.0;
                    row.time_ratio = time_ratio;
                    row.memory_bytes = memory_bytes;
                    row
                })
                .collect();
            mark(&mut rows);
            for scene in ["0", "1", "2"] {
                let members: Vec<&Row> = rows.iter().filter(|row| row.scene == scene).collect();
                let time = by_definition(&points(&members, |row| row.time_ratio));
                let space = by_definition(&points(&members, memory));
                for ((row, time), space) in members.iter().zip(time).zip(space) {
                    prop_assert_eq!(row.pareto, time || space);
                }
            }
        }
    }

    #[test]
    fn equal_points_are_on_the_front_together() {
        let points = [(1.0, 2.0), (1.0, 2.0), (1.0, 3.0), (2.0, 2.0), (2.0, 1.0)];
        assert_eq!(front(&points), [true, true, false, false, true]);
    }
}
