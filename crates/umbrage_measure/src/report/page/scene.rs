//! The page's part about one scene.

use maud::{Markup, html};
use umbrage_render::Decision;

use super::{Page, data_url};
use crate::report::{
    Pictures, ReportError, Row,
    format::{bytes, percent, time, whole},
    pareto::memory,
    plot::{Cost, MEMORY, TIME, plot, swatch},
    table::key_figures,
    verdict::{Choice, choices, ladder},
};

impl Page<'_> {
    /// The verdict, and the plots that it can be seen in.
    pub(super) fn scene(&self, number: usize) -> Result<Markup, ReportError> {
        let name = self.scenes.get(number).map_or("", |scene| scene.0);
        let rows = self.rows(number);
        let time = plot(name, &rows, &self.names, TIME)?;
        let memory = plot(name, &rows, &self.names, MEMORY)?;
        Ok(html! {
            section.scene id={ "scene-" (number) } {
                h2 { (name) " " small { (self.about(name, rows.len())) } }
                (self.left_out(name))
                (self.verdict(&rows))
                (self.legend(&rows))
                div.plots {
                    (self.figure(&rows, TIME, time))
                    (self.figure(&rows, MEMORY, memory))
                }
            }
        })
    }

    fn left_out(&self, scene: &str) -> Markup {
        let info = self.report.scenes.iter().find(|info| info.name == scene);
        let left_out = info.map_or(&[][..], |info| &info.left_out);
        html! {
            @if !left_out.is_empty() {
                details {
                    summary { "Left out of the models: " (left_out.len()) }
                    ul { @for left_out in left_out { li { (left_out) } } }
                }
            }
        }
    }

    fn about(&self, scene: &str, rows: usize) -> String {
        let mut about = String::new();
        if let Some(info) = self.report.scenes.iter().find(|info| info.name == scene) {
            about = format!(
                "{} · {} · ",
                counted(info.lights, "light"),
                counted(info.triangles, "triangle")
            );
        }
        about + &counted(rows, "configuration")
    }

    fn verdict(&self, rows: &[&Row]) -> Markup {
        let choices = choices(rows);
        let bad = rows.iter().filter(|row| row.figures.bad_pixels > 0).count();
        html! {
            @if choices.is_empty() {
                p.warning { "No configuration gave figures to choose by." }
            } @else {
                div.choices {
                    @for (place, choice) in choices.iter().enumerate() { (self.card(choice, place == 0)) }
                }
            }
            @if bad > 0 {
                p.warning {
                    (counted(bad, "configuration")) " drew bad pixels (no number, or outside 0..1) and "
                    @if bad == 1 { "is" } @else { "are" } " not proposed."
                }
            }
        }
    }

    fn card(&self, choice: &Choice<'_>, first: bool) -> Markup {
        let row = choice.row;
        html! {
            a.card.first[first] href={ "#row-" (self.index(row)) } {
                @if first { span.badge { "Choose" } }
                span.because { (capital(&choice.because.join("; "))) }
                strong { (swatch(&self.names, &row.method)) (self.names.row(row)) }
                span.figures {
                    span { b { (percent(row.error())) } " error" }
                    span { b { (time(&row.time_ratio)) } " time" }
                    span { b { (bytes(memory(row))) } " memory" }
                }
                @if choice.as_fast > 0 {
                    span.split { (counted(choice.as_fast, "other")) " may be as fast" }
                }
                span.split { (percent(row.figures.false_lit)) " false lit, " (percent(row.figures.false_shadow)) " false shadow" }
            }
        }
    }

    fn legend(&self, rows: &[&Row]) -> Markup {
        let shown = |method: &&String| rows.iter().any(|row| row.method == **method);
        html! {
            p.legend {
                @for method in self.names.methods().iter().filter(shown) {
                    span { (swatch(&self.names, method)) (method) }
                }
                span { span.front-line {} "Pareto front" }
            }
        }
    }

    fn figure(&self, rows: &[&Row], cost: Cost, plot: Option<Markup>) -> Markup {
        let steps = ladder(rows, cost.extent);
        html! {
            figure {
                figcaption { "Error against " (cost.name) }
                @match plot {
                    Some(plot) => div.frame { (plot) },
                    None => p.warning { "No configuration has both an error and a " (cost.name) "." },
                }
                @if !steps.is_empty() {
                    table.ladder {
                        caption { "Least error for a given " (cost.name) }
                        thead { tr { th scope="col" { "from" } th scope="col" { "error" } th.name scope="col" { "configuration" } } }
                        tbody {
                            @for row in steps {
                                tr {
                                    td { ((cost.show)(row)) }
                                    td { (percent(row.error())) }
                                    td.name { a href={ "#row-" (self.index(row)) } { (self.names.row(row)) } }
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    /// Each row's pictures; those off the front are folded up.
    pub(super) fn gallery(&self, number: usize) -> Markup {
        let Some((name, indices)) = self.scenes.get(number) else {
            return html! {};
        };
        let (front, rest): (Vec<_>, Vec<_>) = indices
            .iter()
            .filter_map(|index| {
                Some((
                    *index,
                    self.report.rows.get(*index)?,
                    self.pictures.get(*index)?,
                ))
            })
            .partition(|(_, row, _)| row.pareto);
        html! {
            section.gallery id={ "pictures-" (number) } {
                h2 { "Pictures: " (name) }
                p.legend {
                    span { span.patch.lit {} "false lit" }
                    span { span.patch.shadow {} "false shadow" }
                    span { span.patch.out {} "left out: the rasteriser saw another triangle" }
                    span { span.patch.bad {} "bad pixel" }
                    span.js hidden { "Click a picture to enlarge it." }
                }
                @if front.iter().chain(&rest).any(|(.., pictures)| pictures.decisions.is_some()) { (decisions()) }
                @for (index, row, pictures) in front {
                    article.row id={ "row-" (index) } {
                        h3 { (self.title(row)) }
                        (self.pictures(row, pictures))
                    }
                }
                @for (index, row, pictures) in rest {
                    details.row id={ "row-" (index) } {
                        summary { (self.title(row)) }
                        (self.pictures(row, pictures))
                    }
                }
            }
        }
    }

    fn title(&self, row: &Row) -> Markup {
        html! {
            span.title { (swatch(&self.names, &row.method)) (self.names.row(row)) @if row.pareto { span.star { " ★" } } }
            " " (key_figures(row))
        }
    }

    fn pictures(&self, row: &Row, pictures: &Pictures) -> Markup {
        let name = self.names.row(row);
        let (width, height) = pictures.size;
        let ratio = format!("aspect-ratio:{width}/{height}");
        let truth = self
            .truths
            .get(pictures.truth.as_slice())
            .copied()
            .unwrap_or(0);
        let picture = |what: &str, png: &[u8]| {
            html! {
                figure {
                    img src=(data_url(png)) width=(width) height=(height) decoding="async" loading="lazy"
                        alt={ (what) " of " (name) };
                    figcaption { (what) }
                }
            }
        };
        html! {
            div.pictures {
                (picture("shadow term", &pictures.rendered))
                figure {
                    div class={ "truth truth-" (truth) } style=(ratio) role="img" aria-label="true shadow term" {}
                    figcaption { "truth" }
                }
                (picture("difference", &pictures.difference))
                @if let Some(shaded) = &pictures.shaded { (picture("shaded", shaded)) }
                @if let Some(decisions) = &pictures.decisions { (picture("decisions", decisions)) }
            }
        }
    }
}

/// Meaning of the colours of decisions.
fn decisions() -> Markup {
    let colors = [
        (Decision::LitByPlane, "lit by a plane"),
        (Decision::LitByDepth, "lit by depth"),
        (Decision::ShadowedByPlane, "shadowed by a plane"),
        (Decision::ShadowedByDepth, "shadowed by depth"),
        (Decision::Filtered, "filtered"),
        (Decision::Unsampled, "no map sampled"),
    ];
    html! {
        p.legend {
            "Decisions, the mean over the lights:"
            @for (decision, title) in colors {
                @let [r, g, b] = decision.color();
                span { span.patch style={ "background:rgb(" (r) " " (g) " " (b) ")" } {} (title) }
            }
        }
    }
}

/// `1 light`, `2 lights`.
fn counted(count: usize, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {what}{plural}", whole(count as f64))
}

/// With a capital letter.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(char::to_uppercase);
    first.into_iter().flatten().chain(letters).collect()
}
