//! Cells of a light's maps that receivers in view read.

use std::{f64::consts::SQRT_2, ops::Range};

use glam::{DVec2, DVec3};

use crate::{Aabb, Extent, Frame, Map, Maps, PlanError, Side, Volume};

/// A square part of a map: a column and a row of them, from the upper left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// The map's number.
    pub map: u32,
    /// From the left.
    pub column: u32,
    /// From the top.
    pub row: u32,
}

impl Frame<'_> {
    /// The cells of `side` texels, of all that `maps` have, in which lies a texel that the filter reads for some receiver in view:
    /// by maps, then rows, then columns. All of them, where the air is a receiver.
    ///
    /// A filter that prepares a map needs to do so there alone. It relies on what a method promises: a receiver is looked up within
    /// √2 times the filter's reach of its own place in the map.
    ///
    /// # Errors
    /// The filter's.
    pub fn cells(&self, maps: &Maps, side: u32) -> Result<Vec<Cell>, PlanError> {
        let origin = self.view.position;
        let receivers = self.casters.receivers.iter();
        let receivers: Vec<_> = receivers.map(|aabb| aabb.translate(-origin)).collect();
        let mut cells = Vec::new();
        for (number, map) in (0..).zip(&maps.maps) {
            // The step aside, and the reach; a texel for rounding.
            let margin = (SQRT_2 + 1.0) * self.reach(number as usize)? + 1.0;
            let mut grid = Grid::new(map.tile.width, side, margin);
            if self.casters.air.is_some() {
                grid.mark_all();
            } else {
                self.mark(&mut grid, map, &receivers);
            }
            let marked = (0..).zip(grid.marked.chunks(grid.across));
            for (row, marks) in marked {
                let columns = (0..).zip(marks).filter(|(_, marked)| **marked);
                cells.extend(columns.map(|(column, _)| Cell {
                    map: number,
                    column,
                    row,
                }));
            }
        }
        Ok(cells)
    }

    /// Marks where `receivers` (relative to the camera) lie in a map, as far as they are in view.
    fn mark(&self, grid: &mut Grid, map: &Map, receivers: &[Aabb]) {
        let seen = match map.held {
            Some([near, far]) => self.view.part_relative(
                near * (1.0 - Extent::PADDING),
                far * (1.0 + Extent::PADDING),
            ),
            None => self.view.frustum_relative(),
        };
        let mut volume = Volume::new(&[&seen]);
        let mut points = Vec::new();
        for receiver in receivers {
            points.clear();
            let place = |point: DVec3| {
                let clip = map.view_proj * point.extend(1.0);
                let at = DVec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w);
                (clip.w > 0.0).then_some(at * f64::from(map.tile.width))
            };
            let corners;
            let vertices = match volume.side(receiver) {
                Side::Outside => continue,
                Side::Inside => {
                    corners = receiver.corners();
                    &corners[..]
                }
                Side::Across => volume.cut(receiver),
            };
            points.extend(vertices.iter().map_while(|vertex| place(*vertex)));
            // It reaches behind the light, where places mean nothing.
            if points.len() < vertices.len() {
                return grid.mark_all();
            }
            grid.mark_hull(&mut points);
        }
    }
}

/// Marks on a map's cells.
struct Grid {
    /// Cells along the map's side.
    across: usize,
    /// Texels along a cell.
    side: f64,
    /// Texels beside what is marked that are to be marked as well.
    margin: f64,
    /// By rows.
    marked: Vec<bool>,
    /// Room for a hull.
    around: Vec<DVec2>,
}

impl Grid {
    fn new(texels: u32, side: u32, margin: f64) -> Self {
        let across = texels.div_ceil(side) as usize;
        Self {
            across,
            side: f64::from(side),
            margin,
            marked: vec![false; across * across],
            around: Vec::new(),
        }
    }

    fn mark_all(&mut self) {
        self.marked.fill(true);
    }

    /// Marks the cells that the convex hull of `points` (texels) touches, and its margin.
    fn mark_hull(&mut self, points: &mut Vec<DVec2>) {
        let rows = bounds(points.iter().map(|point| point.y));
        let columns = bounds(points.iter().map(|point| point.x));
        let [rows, columns] = [rows, columns].map(|ends| self.touched(ends?));
        let Some((rows, columns)) = rows.zip(columns) else {
            return;
        };
        // Most receivers lie where others do: on a ground.
        let of = |row: usize| row * self.across + columns.start..row * self.across + columns.end;
        if rows
            .clone()
            .all(|row| self.marked[of(row)].iter().all(|marked| *marked))
        {
            return;
        }
        hull(points, &mut self.around);
        for row in rows {
            let top = row as f64 * self.side - self.margin;
            let band = [top, top + self.side + 2.0 * self.margin];
            let edges = points.iter().zip(points.iter().cycle().skip(1));
            let inside = edges.filter_map(|(a, b)| across(*a, *b, band));
            let columns = bounds(inside.flatten());
            let Some(columns) = columns.and_then(|ends| self.touched(ends)) else {
                continue;
            };
            let start = row * self.across;
            self.marked[start + columns.start..start + columns.end].fill(true);
        }
    }

    /// The columns or rows that what lies between two `ends` along the map's side touches with its margin; none beside the map.
    fn touched(&self, [low, high]: [f64; 2]) -> Option<Range<usize>> {
        let all = self.across as f64;
        let ends = [low - self.margin, high + self.margin];
        let [first, last] = ends.map(|end| (end / self.side).floor());
        // Numbers that are none touch nothing.
        (first < all && last >= 0.0)
            .then(|| first.max(0.0) as usize..last.min(all - 1.0) as usize + 1)
    }
}

/// The least and the greatest of numbers.
fn bounds(numbers: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    numbers
        .map(|number| [number; 2])
        .reduce(|[low, high], [a, b]| [low.min(a), high.max(b)])
}

/// Where a line begins and ends across a `band` of y.
fn across(a: DVec2, b: DVec2, [low, high]: [f64; 2]) -> Option<[f64; 2]> {
    let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
    if b.y < low || a.y > high {
        return None;
    }
    let at = |y: f64| {
        let share = (y - a.y) / (b.y - a.y);
        a.x + share.clamp(0.0, 1.0) * (b.x - a.x)
    };
    Some([
        if a.y < low { at(low) } else { a.x },
        if b.y > high { at(high) } else { b.x },
    ])
}

/// Leaves the corners of the convex hull of `points`, in order around it (Andrew 1979).
fn hull(points: &mut Vec<DVec2>, around: &mut Vec<DVec2>) {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return;
    }
    around.clear();
    let mut half = |points: &mut dyn Iterator<Item = DVec2>| {
        let start = around.len();
        for point in points {
            while let [.., a, b] = around[start..]
                && (b - a).perp_dot(point - b) <= 0.0
            {
                around.pop();
            }
            around.push(point);
        }
        // The next half begins with it.
        around.pop();
    };
    half(&mut points.iter().copied());
    half(&mut points.iter().rev().copied());
    std::mem::swap(points, around);
}
