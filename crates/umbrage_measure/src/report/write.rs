//! A report as files.

use std::{
    fs::{self, File},
    io::{self, Write},
    path::Path,
};

use serde::{Deserialize, Serialize};

use super::{Pictures, Report, ReportError, page::page};

/// Marks `report.json` as ours. The number goes up when the meaning of its members changes.
pub const FORMAT: &str = "umbrage report 2";

const JSON: &str = "report.json";
const HTML: &str = "report.html";

/// The files of a report.
pub const FILES: [&str; 2] = [JSON, HTML];

/// `report.json`.
#[derive(Serialize)]
struct Marked<'a> {
    format: &'static str,
    #[serde(flatten)]
    report: &'a Report,
}

/// Writes [`FILES`] into `folder`, with the front marked and `pictures[i]` for `report.rows[i]`. Numbers
/// that are not finite are null in the JSON: they were not measured.
///
/// Both are ready in memory before the first is written, and their bytes depend on the report alone. Yet a
/// full disk may leave a part of them: give a new, empty folder, and put it in its place when it is whole.
///
/// # Errors
/// [`ReportError`]: there is nothing to report, pictures are missing, or a file could not be written.
pub fn write(report: &Report, pictures: &[Pictures], folder: &Path) -> Result<(), ReportError> {
    let (json, html) = render(report, pictures)?;
    for (file, text) in [(JSON, json), (HTML, html)] {
        store(&folder.join(file), &text).map_err(|source| ReportError::Write { file, source })?;
    }
    Ok(())
}

/// The two files' texts.
pub(super) fn render(
    report: &Report,
    pictures: &[Pictures],
) -> Result<(String, String), ReportError> {
    if report.rows.is_empty() {
        return Err(ReportError::NoRows);
    }
    if pictures.len() != report.rows.len() {
        return Err(ReportError::Pictures {
            rows: report.rows.len(),
            pictures: pictures.len(),
        });
    }
    let mut report = report.clone();
    report.mark_pareto();
    let mut json = serde_json::to_string_pretty(&Marked {
        format: FORMAT,
        report: &report,
    })?;
    json.push('\n');
    Ok((json, page(&report, pictures)?))
}

/// On the disk when it returns: a report in memory alone is no reason to drop the one before.
fn store(path: &Path, text: &str) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()
}

/// Whether `folder` holds nothing but an earlier report, so that a new one may take its place.
///
/// # Errors
/// [`ReportError::Foreign`], which names what is not a report's, or says why the folder cannot be read.
pub fn check_earlier(folder: &Path) -> Result<(), ReportError> {
    #[derive(Deserialize)]
    struct Mark {
        format: String,
    }
    let unreadable = |error| ReportError::Foreign(format!("it cannot be read: {error}"));
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|name| FILES.contains(&name));
        // A link is none of ours either, wherever it leads.
        if !ours || !entry.file_type().map_err(unreadable)?.is_file() {
            let name = Path::new(&name).display();
            return Err(ReportError::Foreign(format!(
                "{name} is not a file of a report's"
            )));
        }
    }
    let text = fs::read(folder.join(JSON))
        .map_err(|error| ReportError::Foreign(format!("{JSON} cannot be read: {error}")))?;
    let mark: Mark = serde_json::from_slice(&text)
        .map_err(|error| ReportError::Foreign(format!("{JSON} is no report: {error}")))?;
    if mark.format != FORMAT {
        return Err(ReportError::Foreign(format!(
            "{JSON} has the format `{}`, not `{FORMAT}`",
            mark.format
        )));
    }
    Ok(())
}
