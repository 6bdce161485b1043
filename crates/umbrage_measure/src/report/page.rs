//! `report.html`: one page, for a reader who wants to choose.
//!
//! Written with `maud`: its markup is checked when compiled, and it escapes whatever comes from outside.

mod overview;
mod scene;

use std::collections::BTreeMap;

use base64::{Engine, engine::general_purpose::STANDARD};
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{
    FALSE_LIT, FALSE_SHADOW, LEFT_OUT, NO_NUMBER, Pictures, Report, ReportError, Row, names::Names,
    table::table,
};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Nothing is loaded from anywhere, even if a browser or a name should try.
const POLICY: &str =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// Characters that pictures may take, so that the page is sent and opened in a moment.
const PICTURES: usize = 3_000_000;

/// Data that the parts of the page share.
struct Page<'a> {
    report: &'a Report,
    pictures: &'a [Pictures],
    names: Names,
    /// Each scene's rows, by their numbers in the report.
    scenes: Vec<(&'a str, Vec<usize>)>,
    /// The true pictures, each once, with the number of its class.
    truths: BTreeMap<&'a [u8], usize>,
    /// Pictures that are shown of each row.
    shown: Vec<Shown>,
}

/// Pictures of a row that the page has room for.
#[derive(Clone, Copy, Default)]
struct Shown {
    /// Where it is wrong.
    difference: bool,
    /// All others.
    others: bool,
}

/// The page, with `pictures` for each row. The front is marked.
pub(super) fn page(report: &Report, pictures: &[Pictures]) -> Result<String, ReportError> {
    let mut truths = BTreeMap::new();
    for pictures in pictures {
        let number = truths.len();
        truths.entry(pictures.truth.as_slice()).or_insert(number);
    }
    let page = Page {
        report,
        pictures,
        names: Names::of(report),
        scenes: by_scene(report),
        shown: shown(report, pictures, truths.keys().map(|png| png.len()).sum()),
        truths,
    };
    let scenes: Vec<Markup> = (0..page.scenes.len())
        .map(|number| page.scene(number))
        .collect::<Result<_, _>>()?;
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "Shadow methods: error against cost" }
                style { (PreEscaped(STYLE)) (PreEscaped(page.picture_styles())) }
            }
            body {
                (page.header())
                main {
                    (page.overview())
                    @for scene in scenes { (scene) }
                    section #all-figures {
                        h2 { "All figures" }
                        p.note.js hidden { "Click a header to sort; again to turn the order round. ★ marks the Pareto front." }
                        p.note.nojs { "In each scene the Pareto front (★) comes first, then the rows by error." }
                        (table(report, &page.scenes, &page.names))
                    }
                    @for number in 0..page.scenes.len() { (page.gallery(number)) }
                    (page.skipped())
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string())
}

/// Pictures that there is room for beside truths of so many bytes: first where the front is wrong, then its other pictures, then where
/// the rest is wrong.
fn shown(report: &Report, pictures: &[Pictures], truths: usize) -> Vec<Shown> {
    // Base64 makes four characters of three bytes.
    let mut room = (PICTURES * 3 / 4).saturating_sub(truths);
    let mut take = |bytes: usize| {
        let fits = bytes <= room;
        room -= if fits { bytes } else { 0 };
        fits
    };
    let mut shown = vec![Shown::default(); pictures.len()];
    let rows = || report.rows.iter().zip(pictures).enumerate();
    for (index, (_, pictures)) in rows().filter(|(_, (row, _))| row.pareto) {
        shown[index].difference = take(pictures.difference.len());
    }
    for (index, (_, pictures)) in rows().filter(|(_, (row, _))| row.pareto) {
        let others = [
            Some(&pictures.rendered),
            pictures.shaded.as_ref(),
            pictures.decisions.as_ref(),
        ];
        shown[index].others = take(others.into_iter().flatten().map(Vec::len).sum());
    }
    for (index, (_, pictures)) in rows().filter(|(_, (row, _))| !row.pareto) {
        shown[index].difference = take(pictures.difference.len());
    }
    shown
}

/// The rows' numbers by scenes: first the scenes that the report lists, then others as the rows come.
fn by_scene(report: &Report) -> Vec<(&str, Vec<usize>)> {
    let listed = report.scenes.iter().map(|scene| scene.name.as_str());
    let mut scenes: Vec<(&str, Vec<usize>)> = Vec::new();
    for name in listed.chain(report.rows.iter().map(|row| row.scene.as_str())) {
        if !scenes.iter().any(|scene| scene.0 == name) {
            scenes.push((name, Vec::new()));
        }
    }
    for (index, row) in report.rows.iter().enumerate() {
        if let Some(scene) = scenes.iter_mut().find(|scene| scene.0 == row.scene) {
            scene.1.push(index);
        }
    }
    scenes.retain(|scene| !scene.1.is_empty());
    scenes
}

impl<'a> Page<'a> {
    /// The rows of a scene, as the report has them.
    fn rows(&self, scene: usize) -> Vec<&'a Row> {
        let indices = self.scenes.get(scene).map_or(&[][..], |scene| &scene.1);
        indices
            .iter()
            .filter_map(|index| self.report.rows.get(*index))
            .collect()
    }

    /// The place of `row` in the report, which its pictures are called by.
    fn index(&self, row: &Row) -> usize {
        let rows = self.report.rows.iter();
        rows.clone()
            .position(|other| std::ptr::eq(other, row))
            .unwrap_or(0)
    }

    fn header(&self) -> Markup {
        let report = self.report;
        html! {
            header {
                h1 { "Shadow methods: error against cost" }
                dl.facts {
                    div { dt { "drawn by" } dd { (report.adapter) } }
                    div { dt { "pictures" } dd { (report.width) " × " (report.height) } }
                    div { dt { "times" } dd { "medians of at most " (report.most_pairs) " pairs" } }
                    div { dt { "instructions" } dd { (report.isa_source) } }
                    @if !report.command.is_empty() { div { dt { "made by" } dd { code { (report.command) } } } }
                }
                p.lead {
                    b { "Error" } " is the share of samples that are lit but should be in shadow (" i { "false lit" }
                    ") or the reverse (" i { "false shadow" } "), against shadows by ray tracing. "
                    b { "Time" } " is relative to the method basic with one tap: ratios of pictures drawn one after the other, \
                    their median, and an interval that holds it in 95 of 100. Where two intervals overlap, \
                    nothing is ranked; where one is wider than half of itself, the machine was too busy. The "
                    b { "Pareto front" } " has what no other configuration beats for certain in both: everything off it costs \
                    more, or errs more, for nothing."
                }
                nav aria-label="Contents" {
                    @for (number, (scene, _)) in self.scenes.iter().enumerate() {
                        a href={ "#scene-" (number) } { (scene) }
                    }
                    a href="#all-figures" { "All figures" }
                    a href="#pictures-0" { "Pictures" }
                    @if !self.report.skipped.is_empty() { a href="#skipped" { "Not drawn" } }
                }
            }
        }
    }

    fn skipped(&self) -> Markup {
        html! {
            @if !self.report.skipped.is_empty() {
                section #skipped {
                    h2 { "Not drawn" }
                    div.scroll {
                        table.plain {
                            thead { tr { @for title in ["scene", "method", "config", "reason"] { th scope="col" { (title) } } } }
                            tbody {
                                @for skipped in &self.report.skipped {
                                    tr {
                                        td { (skipped.scene) } td { (skipped.method) } td { (skipped.config) }
                                        td.reason { (skipped.reason) }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    /// The true pictures as backgrounds, so that each is in the file once, however often it is shown; and
    /// the colours of the differences.
    fn picture_styles(&self) -> String {
        let hex = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
        let mut css = format!(
            ":root{{--false-lit:{};--false-shadow:{};--left-out:{};--no-number:{}}}\n",
            hex(FALSE_LIT),
            hex(FALSE_SHADOW),
            hex(LEFT_OUT),
            hex(NO_NUMBER)
        );
        for (png, number) in &self.truths {
            css.push_str(&format!(
                ".truth-{number}{{background-image:url(\"{}\")}}\n",
                data_url(png)
            ));
        }
        css
    }
}

fn data_url(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}
