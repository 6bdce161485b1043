//! Error against a cost, as SVG. `plotters` draws the axes and the front; the points and their labels are
//! laid over it, so that each point has a tooltip and its method's colour in light and in dark.

mod labels;

use maud::{Markup, PreEscaped, html};
use plotters::prelude::*;

use super::{
    ReportError, Row,
    format::{self, bytes, percent, tick},
    names::{Names, Shape},
    pareto::{Extent, memory, time},
    scale::Scale,
    verdict::ladder,
};
use labels::{Mark, place_labels};

/// Units of the picture; the page scales it to its column.
const SIZE: (u32, u32) = (600, 400);

/// The colours that `plotters` writes into the lines. They stand for the page's own, which has a set for
/// light and one for dark: see `page.css`.
const GRID: RGBColor = RGBColor(1, 1, 1);
const AXIS: RGBColor = RGBColor(2, 2, 2);
const FRONT: RGBColor = RGBColor(3, 3, 3);

/// Cost of a row.
#[derive(Clone, Copy)]
pub(super) struct Cost {
    /// Label of the axis.
    pub(super) axis: &'static str,
    /// Name of the plot after "error against".
    pub(super) name: &'static str,
    /// Where a row's point stands.
    of: fn(&Row) -> f64,
    /// How far it may stand aside.
    pub(super) extent: fn(&Row) -> Extent,
    /// A row's cost as people read it.
    pub(super) show: fn(&Row) -> String,
    tick: fn(f64) -> String,
    scale: fn(&[f64]) -> Scale,
}

pub(super) const TIME: Cost = Cost {
    axis: "time, relative to basic with one tap",
    name: "time",
    of: |row| row.time_ratio.median,
    extent: time,
    show: |row| format::time(&row.time_ratio),
    tick: |value| format!("{} ×", tick(value)),
    scale: |values| Scale::for_times(values.iter().copied()),
};

pub(super) const MEMORY: Cost = Cost {
    axis: "memory of the shadow textures",
    name: "memory",
    of: memory,
    extent: |row| Extent::exactly(memory(row)),
    show: |row| bytes(memory(row)),
    tick: |value| bytes(value).replace(".00", "").replace(".0", ""),
    scale: |values| Scale::for_memory(values.iter().copied()),
};

/// A row's point in the picture.
struct Point<'a> {
    row: &'a Row,
    x: f64,
    y: f64,
    /// Left and right end of what its cost may be.
    extent: [f64; 2],
    on_front: bool,
}

/// Of a line in the picture.
type Corners = Vec<(f64, f64)>;

/// The plot of one scene's rows; none where no row has both figures.
pub(super) fn plot(
    scene: &str,
    rows: &[&Row],
    names: &Names,
    cost: Cost,
) -> Result<Option<Markup>, ReportError> {
    let measured: Vec<&Row> = rows
        .iter()
        .copied()
        .filter(|row| row.error().is_finite() && (cost.extent)(row).high.is_finite())
        .collect();
    if measured.is_empty() {
        return Ok(None);
    }
    let missing = rows.len() - measured.len();
    let mut axes = String::new();
    let (points, front) =
        draw_axes(&mut axes, &measured, cost).map_err(|error| ReportError::Plot {
            scene: scene.to_owned(),
            reason: error.to_string(),
        })?;
    let view = format!("0 0 {} {}", SIZE.0, SIZE.1);
    let title = format!("{scene}: error against {}", cost.name);
    Ok(Some(html! {
        svg.plot viewBox=(view) role="img" aria-label=(title) {
            // The axes are plotters' own element; names are not in it.
            (PreEscaped(axes))
            (overlay(&points, &front, names, cost))
        }
        @if missing > 0 {
            p.note { (missing) " of the configurations have no " (cost.name) " that tells anything, or no error, and no point." }
        }
    }))
}

/// Draws the axes and the front, and says where the points and the front's corners are.
fn draw_axes<'a>(
    svg: &mut String,
    rows: &[&'a Row],
    cost: Cost,
) -> Result<(Vec<Point<'a>>, Corners), Box<dyn std::error::Error>> {
    let pairs: Vec<_> = rows
        .iter()
        .map(|row| ((cost.of)(row), row.error()))
        .collect();
    let extents = rows.iter().map(|row| (cost.extent)(row));
    let ends: Vec<f64> = extents
        .flat_map(|extent| [extent.low, extent.high])
        .collect();
    let x_scale = (cost.scale)(&ends);
    let y_scale = Scale::for_errors(pairs.iter().map(|pair| pair.1));
    let log = |scale: Scale| if scale.is_log() { ", logarithmic" } else { "" };
    let text = |size: i32| ("sans-serif", size).into_font().color(&AXIS);

    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    let mut chart = ChartBuilder::on(&root)
        .margin(6)
        .margin_right(18)
        .x_label_area_size(52)
        .y_label_area_size(68)
        .build_cartesian_2d(x_scale, y_scale)?;
    chart
        .configure_mesh()
        .axis_style(AXIS)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .label_style(text(15))
        .axis_desc_style(text(16))
        .x_labels(8)
        .y_labels(8)
        .x_label_formatter(&|value| (cost.tick)(*value))
        .y_label_formatter(&|value| format!("{} %", tick(value * 100.0)))
        .x_desc(format!("{}{}", cost.axis, log(x_scale)))
        .y_desc(format!("error: false lit + false shadow{}", log(y_scale)))
        .draw()?;
    let steps = ladder(rows, cost.extent);
    let line = staircase(&steps, cost, &x_scale, &y_scale);
    chart.draw_series(LineSeries::new(line.iter().copied(), FRONT.stroke_width(2)))?;
    let place = |pair: &(f64, f64)| {
        let (x, y) = chart.backend_coord(pair);
        (f64::from(x), f64::from(y))
    };
    let front = line.iter().map(place).collect();
    let placed = rows
        .iter()
        .zip(pairs)
        .map(|(row, pair)| {
            let (x, y) = place(&pair);
            let Extent { low, high } = (cost.extent)(row);
            Point {
                row,
                x,
                y,
                extent: [low, high].map(|end| place(&(end, pair.1)).0),
                on_front: steps.iter().any(|step| std::ptr::eq(*step, *row)),
            }
        })
        .collect();
    root.present()?;
    drop(chart);
    drop(root);
    Ok((placed, front))
}

/// The front as a line: from the top down to the cheapest, then by steps to the end of the axis. A row
/// above and to the right of it is beaten.
fn staircase(steps: &[&Row], cost: Cost, x_scale: &Scale, y_scale: &Scale) -> Corners {
    use plotters::coord::ranged1d::Ranged;

    let mut line = Vec::new();
    let mut error = y_scale.range().end;
    for step in steps {
        let x = (cost.of)(step);
        line.push((x, error));
        error = step.error();
        line.push((x, error));
    }
    if !line.is_empty() {
        line.push((x_scale.range().end, error));
    }
    line
}

fn overlay(points: &[Point<'_>], front: &[(f64, f64)], names: &Names, cost: Cost) -> Markup {
    let mut order: Vec<&Point<'_>> = points.iter().collect();
    // The mark drawn last lies on top, and the one labelled first has the choice of places.
    order.sort_by_key(|point| point.on_front);
    let several = points.iter().any(|p| p.row.method != points[0].row.method);
    let marks: Vec<Mark> = order
        .iter()
        .rev()
        .map(|point| Mark {
            x: point.x,
            y: point.y,
            on_front: point.on_front,
            text: label(point.row, names, several),
        })
        .collect();
    html! {
        @for point in order {
            g class={ "pt " (names.class(&point.row.method)) @if point.on_front { " on" } } {
                title { (tooltip(point, names, cost)) }
                @let [from, to] = point.extent;
                @if to - from > 1.0 {
                    line.extent x1=(coord(from)) y1=(coord(point.y)) x2=(coord(to)) y2=(coord(point.y)) {}
                }
                (shape(names.shape(&point.row.method), point))
            }
        }
        @for label in place_labels(&marks, front, (f64::from(SIZE.0), f64::from(SIZE.1))) {
            @if let Some((x, y)) = label.leader {
                line.leader x1=(coord(label.mark.x)) y1=(coord(label.mark.y)) x2=(coord(x)) y2=(coord(y)) {}
            }
            text.label.on[label.mark.on_front] x=(coord(label.x)) y=(coord(label.y)) { (label.text) }
        }
    }
}

/// Label beside a point: the method only where there are several.
fn label(row: &Row, names: &Names, several: bool) -> String {
    let name = names.row(row);
    if several {
        return name;
    }
    let bare = name.strip_prefix(row.method.as_str()).unwrap_or(&name);
    bare.trim_start().to_owned()
}

fn tooltip(point: &Point<'_>, names: &Names, cost: Cost) -> String {
    let row = point.row;
    let mut text = format!(
        "{}\nerror {} ({} false lit, {} false shadow)\n{} {}",
        names.row(row),
        percent(row.error()),
        percent(row.figures.false_lit),
        percent(row.figures.false_shadow),
        cost.name,
        (cost.show)(row),
    );
    if point.on_front {
        text.push_str("\non the Pareto front");
    }
    text
}

fn shape(shape: Shape, point: &Point<'_>) -> Markup {
    let (x, y) = (point.x, point.y);
    let r = if point.on_front { 6.5 } else { 4.5 };
    let path = |corners: &[(f64, f64)]| {
        let corners: Vec<_> = corners
            .iter()
            .map(|(dx, dy)| format!("{},{}", coord(x + r * dx), coord(y + r * dy)))
            .collect();
        corners.join(" ")
    };
    match shape {
        Shape::Circle => html! { circle cx=(coord(x)) cy=(coord(y)) r=(r) {} },
        Shape::Square => {
            html! { polygon points=(path(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)])) {} }
        }
        Shape::Triangle => {
            html! { polygon points=(path(&[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)])) {} }
        }
        Shape::Diamond => {
            html! { polygon points=(path(&[(0.0, -1.3), (1.2, 0.0), (0.0, 1.3), (-1.2, 0.0)])) {} }
        }
    }
}

/// A tenth of a unit is finer than a screen.
fn coord(value: f64) -> String {
    format!("{value:.1}")
}

/// A point alone, for legends.
pub(super) fn swatch(names: &Names, method: &str) -> Markup {
    let point = Point {
        row: &Row::default(),
        x: 8.0,
        y: 8.0,
        extent: [8.0; 2],
        on_front: true,
    };
    html! {
        svg.swatch viewBox="0 0 16 16" aria-hidden="true" {
            g class={ "pt on " (names.class(method)) } { (shape(names.shape(method), &point)) }
        }
    }
}
