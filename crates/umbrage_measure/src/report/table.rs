//! The table of all figures.

mod columns;

use maud::{Markup, html};

use super::{
    Report, Row,
    format::{MISSING, bytes, percent, time, whole},
    names::Names,
    pareto::memory,
    plot::swatch,
};
use columns::{Column, GROUPS, count};

/// The table of all rows, by scenes; in each the front first, then by error. `order` has the rows'
/// numbers in the report by scenes.
pub(super) fn table(report: &Report, scenes: &[(&str, Vec<usize>)], names: &Names) -> Markup {
    html! {
        div.controls {
            label.js hidden { "Scene "
                select #scene-filter {
                    option value="" { "all scenes" }
                    @for (index, (scene, _)) in scenes.iter().enumerate() {
                        option value=(index) { (scene) }
                    }
                }
            }
            label { input #only-front type="checkbox"; " Pareto front only" }
            fieldset {
                legend { "Columns" }
                @for group in GROUPS {
                    label {
                        input id={ "show-" (group.id) } type="checkbox" checked[group.shown]; " "
                        (group.title)
                    }
                }
            }
        }
        div.scroll tabindex="0" role="region" aria-label="All figures" {
            table #figures {
                thead { (head()) }
                tbody {
                    @for (number, (_, rows)) in scenes.iter().enumerate() {
                        @for index in in_order(report, rows) {
                            @if let Some(row) = report.rows.get(index) { (line(row, index, number, names)) }
                        }
                    }
                }
            }
        }
    }
}

fn head() -> Markup {
    html! {
        tr.groups {
            th colspan="4" scope="colgroup" { "Configuration" }
            @for group in GROUPS {
                th class={ "first g-" (group.id) } colspan=(group.columns.len()) scope="colgroup" { (group.title) }
            }
        }
        tr {
            @for title in ["scene", "method", "config", "path"] {
                th.name.key[title == "config"] scope="col" { button type="button" { (title) } }
            }
            @for group in GROUPS {
                @for (index, column) in group.columns.iter().enumerate() {
                    th class={ @if index == 0 { "first " } "g-" (group.id) } scope="col"
                        title={ (column.about) " (" (column.name) ")" } {
                        button type="button" { (column.title)
                            @if !column.unit.is_empty() { " " small { (column.unit) } }
                        }
                    }
                }
            }
        }
    }
}

fn in_order(report: &Report, rows: &[usize]) -> Vec<usize> {
    let mut order = rows.to_vec();
    order.sort_by(|a, b| match (report.rows.get(*a), report.rows.get(*b)) {
        (Some(a), Some(b)) => b
            .pareto
            .cmp(&a.pareto)
            // NaN is above all numbers, whatever its sign bit.
            .then(key(a.error()).total_cmp(&key(b.error())))
            .then(a.memory_bytes.cmp(&b.memory_bytes)),
        _ => a.cmp(b),
    });
    order
}

fn key(value: f64) -> f64 {
    if value.is_nan() { f64::INFINITY } else { value }
}

fn line(row: &Row, index: usize, scene: usize, names: &Names) -> Markup {
    html! {
        tr.front[row.pareto] data-scene=(scene) {
            td.name { (row.scene) }
            td.name { (swatch(names, &row.method)) (row.method) }
            th.name.key scope="row" {
                a href={ "#row-" (index) } { (row.config) }
                @if row.pareto { span.star title="on the Pareto front" { " ★" } }
            }
            td.name { (row.path) }
            @for group in GROUPS {
                @for (place, column) in group.columns.iter().enumerate() {
                    (cell(row, column, group.id, place == 0))
                }
            }
        }
    }
}

fn cell(row: &Row, column: &Column, group: &str, first: bool) -> Markup {
    let value = (column.value)(row).filter(|value| value.is_finite());
    let bad = column.name == "bad_pixels" && value != Some(0.0);
    html! {
        td class={ @if first { "first " } @if bad { "bad " } "g-" (group) }
            data-v=[value.map(|value| value.to_string())] {
            @match value {
                Some(value) => { ((column.show)(value)) }
                None => { (MISSING) }
            }
            @if let Some(beside) = column.beside.and_then(|beside| beside(row)) {
                " " small { (beside) }
            }
        }
    }
}

/// A row's key figures, for where its pictures stand.
pub(super) fn key_figures(row: &Row) -> Markup {
    html! {
        span.fig { b { (percent(row.error())) } " error" }
        span.fig { (percent(row.figures.false_lit)) " false lit" }
        span.fig { (percent(row.figures.false_shadow)) " false shadow" }
        span.fig { (time(&row.time_ratio)) " time" }
        span.fig { (bytes(memory(row))) }
        @if let Some(decided) = row.decided {
            span.fig { (percent(decided.at_once())) " decided at once" }
        }
        @if row.figures.bad_pixels > 0 {
            span.fig.bad { (whole(count(row.figures.bad_pixels))) " bad pixels" }
        }
    }
}
