//! The files of a report, as readers find them.

pub(super) mod rows;

use std::{collections::BTreeSet, fs};

use image::RgbImage;
use scraper::{Html, Selector};
use serde_json::Value;
use umbrage_render::Decision;

use super::{
    FORMAT, Pictures, Ratio, Report, ReportError, check_earlier,
    write::{render, write},
};
use rows::{fake_report, full_row, pictures_of, row};

const HOSTILE: &str = "</style><script>alert(1)</script>\"'&";

fn page_of(report: &Report) -> String {
    render(report, &pictures_of(report)).expect("a report").1
}

/// The page as a browser reads it; a fault that a browser would have to mend fails.
fn parsed(html: &str) -> Html {
    let page = Html::parse_document(html);
    assert_eq!(page.errors, Vec::<std::borrow::Cow<'static, str>>::new());
    page
}

fn texts(page: &Html, selector: &str) -> Vec<String> {
    page.select(&Selector::parse(selector).expect("a selector"))
        .map(|element| element.text().collect::<String>().trim().to_owned())
        .collect()
}

fn attributes(page: &Html, selector: &str, name: &str) -> Vec<String> {
    page.select(&Selector::parse(selector).expect("a selector"))
        .filter_map(|element| element.attr(name).map(str::to_owned))
        .collect()
}

#[test]
fn the_json_has_every_row_and_null_for_what_is_no_number() {
    let mut report = fake_report();
    report.rows[3].time_ratio = Ratio::default();
    report.rows[3].figures.rmse = f64::INFINITY;
    let (json, _) = render(&report, &pictures_of(&report)).expect("a report");
    let json: Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["format"], FORMAT);
    assert_eq!(json["adapter"], report.adapter);
    let rows = json["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), report.rows.len());
    for (json, row) in rows.iter().zip(&report.rows) {
        assert_eq!(json["scene"], row.scene);
        assert_eq!(json["config"], row.config);
        assert_eq!(json["memory_bytes"], row.memory_bytes);
        // The test's parser rounds in the last digit.
        let false_lit = json["false_lit"].as_f64().expect("a number");
        assert!((false_lit / row.figures.false_lit - 1.0).abs() < 1e-15);
    }
    assert_eq!(rows[3]["time_ratio"]["median"], Value::Null);
    assert_eq!(rows[3]["time_ratio"]["high"], Value::Null);
    assert_eq!(rows[3]["rmse"], Value::Null);
    assert_eq!(rows[3]["pareto"], Value::from(rows[3]["pareto"] == true));
    assert!(rows.iter().any(|row| row["pareto"] == true));
    assert!(rows.iter().any(|row| row["pareto"] == false));
}

#[test]
fn the_page_has_every_row_once_in_the_table_and_once_with_pictures() {
    let report = fake_report();
    let page = parsed(&page_of(&report));
    assert_eq!(texts(&page, "#figures tbody tr").len(), report.rows.len());
    let names: BTreeSet<_> = texts(&page, "#figures tbody th a").into_iter().collect();
    for row in &report.rows {
        assert!(names.contains(&row.config), "{}", row.config);
    }
    for index in 0..report.rows.len() {
        let pictures = attributes(&page, &format!("#row-{index} img"), "src");
        assert_eq!(
            pictures.len(),
            2,
            "the term and the difference of row {index}"
        );
        assert!(
            pictures
                .iter()
                .all(|src| src.starts_with("data:image/png;base64,"))
        );
        assert_eq!(
            attributes(&page, &format!("#row-{index} .truth"), "role"),
            ["img"]
        );
    }
    // Two plots a scene, with a point for each row.
    assert_eq!(texts(&page, "svg.plot").len(), 2 * report.scenes.len());
    assert_eq!(
        texts(&page, "svg.plot .pt title").len(),
        2 * report.rows.len()
    );
    // Rows off the front are folded up, the others are not.
    let open = texts(&page, "article.row").len();
    let mut marked = report.clone();
    marked.mark_pareto();
    assert_eq!(open, marked.rows.iter().filter(|row| row.pareto).count());
}

#[test]
fn links_lead_to_places_of_the_page() {
    let page = parsed(&page_of(&fake_report()));
    let ids: Vec<_> = attributes(&page, "[id]", "id");
    let places: BTreeSet<_> = ids.iter().collect();
    assert_eq!(places.len(), ids.len(), "an id stands twice");
    for link in attributes(&page, "a[href]", "href") {
        let place = link.strip_prefix('#').expect("a place of the page");
        assert!(places.contains(&place.to_owned()), "{link}");
    }
}

#[test]
fn names_from_outside_stay_text() {
    let mut report = fake_report();
    for row in &mut report.rows[..20] {
        row.scene = HOSTILE.to_owned();
        row.method = format!("{}{HOSTILE}", row.method);
        row.config = format!("{}{HOSTILE}", row.config);
    }
    report.scenes[0].name = HOSTILE.to_owned();
    report.adapter = HOSTILE.to_owned();
    report.command = HOSTILE.to_owned();
    report.isa_source = HOSTILE.to_owned();
    report.skipped[0].reason = HOSTILE.to_owned();
    report.scenes[0].left_out[0].feature = HOSTILE.to_owned();
    let html = page_of(&report);
    let page = parsed(&html);
    assert_eq!(texts(&page, "script").len(), 1, "the page's own script");
    assert_eq!(texts(&page, "style").len(), 1);
    assert!(!html.contains("<script>alert"));
    assert!(
        texts(&page, "h2")
            .iter()
            .any(|text| text.starts_with(HOSTILE))
    );
    assert!(texts(&page, ".facts dd").contains(&HOSTILE.to_owned()));
    assert!(texts(&page, ".reason").contains(&HOSTILE.to_owned()));
    let left_out = texts(&page, ".scene li");
    assert!(left_out[0].contains(HOSTILE), "{left_out:?}");
    let plain = "tree.glb: animations (2 places): the stored pose is drawn";
    assert_eq!(left_out[1..], [plain, plain]);
    // Nothing became an attribute either.
    assert!(attributes(&page, "[onclick], [onload], [onerror]", "class").is_empty());
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    let html = page_of(&fake_report());
    let bare = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for foreign in [
        "http:", "https:", "//www", "@import", "<link", "url(/", "url(h",
    ] {
        assert!(!bare.contains(foreign), "{foreign}");
    }
    let page = parsed(&html);
    for (element, attribute) in [
        ("script", "src"),
        ("iframe", "src"),
        ("object", "data"),
        ("image", "href"),
        ("use", "href"),
    ] {
        assert!(
            attributes(&page, element, attribute).is_empty(),
            "{element}"
        );
    }
}

#[test]
fn a_truth_that_rows_share_is_stored_once() {
    let report = fake_report();
    let html = page_of(&report);
    // One for each scene.
    assert_eq!(
        html.matches("{background-image:").count(),
        report.scenes.len()
    );
}

#[test]
fn the_same_report_is_the_same_bytes() {
    let report = fake_report();
    assert!(
        render(&report, &pictures_of(&report)).expect("a report")
            == render(&report, &pictures_of(&report)).expect("a report")
    );
}

#[test]
fn the_order_of_the_rows_changes_no_verdict() {
    let report = fake_report();
    let mut turned = report.clone();
    turned.rows.reverse();
    for selector in [
        ".card strong",
        ".card .because",
        ".ladder tbody tr",
        ".matrix tbody tr",
    ] {
        assert_eq!(
            texts(&parsed(&page_of(&report)), selector),
            texts(&parsed(&page_of(&turned)), selector),
            "{selector}"
        );
    }
}

#[test]
fn a_row_without_figures_is_shown_as_such() {
    let mut only = row("scene", "basic", "a");
    only.figures.false_lit = f64::NAN;
    only.time_ratio = Ratio::default();
    let report = Report {
        rows: vec![only],
        ..Report::default()
    };
    let page = parsed(&page_of(&report));
    assert_eq!(texts(&page, "svg.plot").len(), 0);
    assert!(texts(&page, ".warning")[0].contains("No configuration"));
    let cells = texts(&page, "#figures td.g-isa");
    assert!(cells.iter().all(|text| text == "–"), "{cells:?}");
    assert!(attributes(&page, "#figures td.g-isa", "data-v").is_empty());
}

#[test]
fn bad_pixels_are_seen() {
    let mut report = Report {
        rows: vec![row("scene", "basic", "a"), row("scene", "basic", "b")],
        ..Report::default()
    };
    report.rows[0].figures.bad_pixels = 7;
    let page = parsed(&page_of(&report));
    assert!(texts(&page, ".warning")[0].starts_with("1 configuration drew bad pixels"));
    assert_eq!(texts(&page, "#figures td.bad"), ["7"]);
    assert_eq!(texts(&page, ".card strong"), ["basic b"]);
}

#[test]
fn a_shaded_picture_is_shown_beside_the_others() {
    let report = Report {
        rows: vec![full_row()],
        ..Report::default()
    };
    let shaded = RgbImage::from_pixel(2, 1, image::Rgb([9, 8, 7]));
    let pictures = Pictures::new(
        &[Some(1.0); 2],
        &[1.0; 2],
        RgbImage::new(2, 1),
        Some(&shaded),
    );
    let (_, html) = render(&report, &[pictures.expect("pictures")]).expect("a report");
    assert_eq!(
        texts(&parsed(&html), "#row-0 figcaption"),
        ["shadow term", "truth", "difference", "shaded"]
    );
}

#[test]
fn decisions_are_in_the_table_and_among_the_pictures() {
    let report = Report {
        rows: vec![full_row(), row("scene", "basic", "plain")],
        ..Report::default()
    };
    let mut pictures = pictures_of(&report);
    let drawn = RgbImage::from_pixel(160, 90, image::Rgb(Decision::LitByPlane.color()));
    pictures[0] = pictures[0]
        .clone()
        .with_decisions(&drawn)
        .expect("of one size");
    let (json, html) = render(&report, &pictures).expect("a report");
    let json: Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["rows"][0]["decided"]["lit_by_plane"], 0.505);
    assert_eq!(json["rows"][1]["decided"], Value::Null);
    let page = parsed(&html);
    // 0.505 + 0.3675 and 0.0125 + 0.0325.
    let cells = texts(&page, "#figures td.g-cost");
    assert!(
        cells.contains(&"91.8 plane 87.2, depth 4.50".to_owned()),
        "{cells:?}"
    );
    // The row with the least error comes first.
    assert_eq!(
        texts(&page, "#figures td.g-decided"),
        [
            "–", "–", "–", "–", "–", "50.5", "1.25", "36.8", "3.25", "8.25"
        ]
    );
    assert_eq!(
        texts(&page, "#row-0 figcaption"),
        ["shadow term", "truth", "difference", "decisions"]
    );
    assert_eq!(texts(&page, "#row-1 figcaption").len(), 3);
    assert!(texts(&page, "#row-0 .fig").contains(&"91.8\u{202f}% decided at once".to_owned()));
    let colors = attributes(&page, ".legend .patch", "style");
    let [r, g, b] = Decision::LitByPlane.color();
    assert_eq!(colors.len(), Decision::ALL.len());
    assert!(
        colors.contains(&format!("background:rgb({r} {g} {b})")),
        "{colors:?}"
    );
    // Where nothing is decided, the colours need no key.
    let plain = parsed(&page_of(&report));
    assert!(attributes(&plain, ".legend .patch", "style").is_empty());
}

#[test]
fn every_group_of_columns_can_be_hidden() {
    let html = page_of(&fake_report());
    for id in attributes(&parsed(&html), ".controls fieldset input", "id") {
        let group = id.strip_prefix("show-").expect("a group");
        let rule = format!("body:has(#show-{group}:not(:checked)) .g-{group}");
        assert!(html.contains(&rule), "{rule}");
    }
}

#[test]
fn nothing_to_report_and_missing_pictures_are_refused() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let error = write(&Report::default(), &[], folder.path()).expect_err("refused");
    assert!(matches!(error, ReportError::NoRows));
    assert!(error.to_string().contains("nothing to report"), "{error}");
    let error = write(&fake_report(), &[], folder.path()).expect_err("refused");
    assert!(error.to_string().contains("60 rows"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 0);
}

#[test]
fn only_a_report_is_taken_for_one() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let report = Report {
        rows: vec![row("scene", "basic", "a")],
        ..Report::default()
    };
    write(&report, &pictures_of(&report), folder.path()).expect("written");
    check_earlier(folder.path()).expect("a report");
    let json = folder.path().join("report.json");
    let text = fs::read_to_string(&json).expect("read");
    let refused = |part: &str| {
        let error = check_earlier(folder.path())
            .expect_err("refused")
            .to_string();
        assert!(error.contains(part), "{error}");
    };
    fs::write(folder.path().join("notes.txt"), "mine").expect("written");
    refused("notes.txt");
    fs::remove_file(folder.path().join("notes.txt")).expect("removed");
    for (other, part) in [
        ("{}".to_owned(), "no report"),
        (text.replace(FORMAT, "umbrage report 0"), "umbrage report 0"),
        (text[..text.len() / 2].to_owned(), "no report"),
    ] {
        fs::write(&json, other).expect("written");
        refused(part);
    }
    fs::remove_file(&json).expect("removed");
    refused("report.json");
    refused("cannot be read");
}

#[test]
#[ignore = "writes target/umbrage/report for people to look at"]
fn a_page_to_look_at() {
    let folder =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/umbrage/report");
    fs::create_dir_all(&folder).expect("a folder");
    let report = fake_report();
    write(&report, &pictures_of(&report), &folder).expect("written");
}
