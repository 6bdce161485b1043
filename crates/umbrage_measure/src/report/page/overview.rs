//! The page's part about all scenes: what to choose where one configuration must serve them all, and in each of them.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::{
    Page,
    scene::{card, has_shadow},
};
use crate::report::{
    Row,
    format::{bytes, percent, time},
    plot::swatch,
    verdict::{choices, in_all_scenes, in_scene},
};

/// Lines of the table of errors that are shown at once.
const SHOWN: usize = 10;

impl<'a> Page<'a> {
    /// The verdict, before all else.
    pub(super) fn overview(&self) -> Markup {
        let lines = self.lines();
        html! {
            section #all-scenes {
                h2 { "What to choose" }
                @if self.scenes.len() > 1 {
                    (self.for_all(&lines))
                    h3 { "For each scene" }
                }
                (self.for_each())
                @if self.scenes.len() > 1 {
                    h3 { "Errors in all scenes" }
                    p.note {
                        "Error of each configuration in each scene. " span.star { "★" } " on the Pareto front, "
                        span.near { "green" } " within twice the scene's least error; those on most fronts come first."
                    }
                    div.scroll tabindex="0" role="region" aria-label="Errors by scene" {
                        (self.matrix(lines.get(..SHOWN).unwrap_or(&lines)))
                    }
                    @if let Some(rest) = lines.get(SHOWN..).filter(|rest| !rest.is_empty()) {
                        details {
                            summary { (rest.len()) " more" }
                            div.scroll { (self.matrix(rest)) }
                        }
                    }
                }
            }
        }
    }

    /// Where one configuration must serve all scenes.
    fn for_all(&self, lines: &[Line<'a>]) -> Markup {
        let rows: Vec<_> = lines.iter().map(|line| line.rows.as_slice()).collect();
        let choices = choices(&in_all_scenes(&rows));
        html! {
            h3 { "If one configuration must serve all scenes" }
            p.note {
                "Error over the least of each scene, time and memory: the worst over the scenes."
            }
            @if choices.is_empty() {
                p.warning { "No configuration gave figures in all scenes." }
            } @else {
                div.choices {
                    @for (place, choice) in choices.iter().enumerate() {
                        @let error = html! { b { "≤ " (crate::report::format::times(choice.candidate.error)) } " the least error" };
                        (card(self, choice, place == 0, error))
                    }
                }
            }
        }
    }

    /// The first choice of each scene.
    fn for_each(&self) -> Markup {
        html! {
            div.scroll {
                table.plain.first-choices {
                    thead { tr {
                        @for title in ["scene", "choose", "error", "of the shadow", "time", "memory"] { th scope="col" { (title) } }
                    } }
                    tbody {
                        @for (number, (scene, _)) in self.scenes.iter().enumerate() {
                            @let rows = self.rows(number);
                            tr {
                                th scope="row" { a href={ "#scene-" (number) } { (scene) } }
                                @match choices(&in_scene(&rows)).first() {
                                    Some(choice) => {
                                        @let row = choice.candidate.row;
                                        td { a href={ "#row-" (self.index(row)) } { (swatch(&self.names, &row.method)) (self.names.row(row)) } }
                                        td { (percent(row.error())) }
                                        td {
                                            @match row.figures.error_of_shadow {
                                                Some(share) => { (percent(share)) }
                                                None => { @if has_shadow(&rows) { "–" } @else { "no shadow in truth" } }
                                            }
                                        }
                                        td { (time(&row.time_ratio)) }
                                        td { (bytes(choice.candidate.memory)) }
                                    }
                                    None => { td colspan="5" { "no configuration gave figures" } }
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    fn matrix(&self, lines: &[Line<'a>]) -> Markup {
        html! {
            table.matrix {
                thead { tr {
                    th scope="col" { "configuration" }
                    @for (number, (scene, _)) in self.scenes.iter().enumerate() {
                        th scope="col" { a href={ "#scene-" (number) } { (scene) } }
                    }
                    th scope="col" { "on fronts" }
                } }
                tbody {
                    @for line in lines {
                        tr {
                            th scope="row" { (line.name) }
                            @for (row, least) in line.rows.iter().zip(self.least()) {
                                @match row {
                                    Some(row) => {
                                        td.near[row.error() <= 2.0 * least] {
                                            a href={ "#row-" (self.index(row)) } { (percent(row.error())) }
                                            @if row.pareto { span.star { " ★" } } @else { span.star.none { " ★" } }
                                        }
                                    }
                                    None => { td { "" } }
                                }
                            }
                            td { (line.fronts()) " of " (line.rows.iter().flatten().count()) }
                        }
                    }
                }
            }
        }
    }

    /// The least error of each scene.
    fn least(&self) -> Vec<f64> {
        (0..self.scenes.len())
            .map(|scene| {
                let errors = self.rows(scene).into_iter().map(Row::error);
                errors.fold(f64::INFINITY, f64::min)
            })
            .collect()
    }

    /// A line a configuration: those on most fronts first, and of those the one whose worst error is least.
    fn lines(&self) -> Vec<Line<'a>> {
        let mut lines: BTreeMap<String, Line<'a>> = BTreeMap::new();
        for scene in 0..self.scenes.len() {
            for row in self.rows(scene) {
                let name = self.names.row(row);
                let line = lines.entry(name.clone()).or_insert_with(|| Line {
                    name,
                    rows: vec![None; self.scenes.len()],
                });
                if let Some(place) = line.rows.get_mut(scene) {
                    *place = Some(row);
                }
            }
        }
        let mut lines: Vec<_> = lines.into_values().collect();
        lines.sort_by(|a, b| {
            let fronts = b.fronts().cmp(&a.fronts());
            fronts.then(a.worst().total_cmp(&b.worst()))
        });
        lines
    }
}

/// A configuration across the scenes; none where it was not drawn.
struct Line<'a> {
    name: String,
    rows: Vec<Option<&'a Row>>,
}

impl Line<'_> {
    fn fronts(&self) -> usize {
        self.rows.iter().flatten().filter(|row| row.pareto).count()
    }

    fn worst(&self) -> f64 {
        let errors = self.rows.iter().flatten().map(|row| row.error());
        errors.fold(0.0, |worst, error| {
            // An unknown error may be the worst.
            if error.is_nan() {
                f64::INFINITY
            } else {
                error.max(worst)
            }
        })
    }
}
