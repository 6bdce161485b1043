//! Annotations of GitHub's workflows: a line each, which GitHub shows beside the source line
//! (<https://docs.github.com/actions/reference/workflow-commands-for-github-actions>).

use super::report::{Finding, Level, Report};

pub(crate) fn annotations(report: &Report) -> String {
    let findings = report.findings().map(annotation);
    let warnings = report.warnings.iter();
    let warnings = warnings.map(|text| format!("::warning::{}\n", data(text.trim_end())));
    findings.chain(warnings).collect()
}

fn annotation(finding: &Finding) -> String {
    let mut properties = Vec::new();
    if let Some(file) = finding.path() {
        properties.push(format!("file={}", property(&file)));
    }
    let places = [("line", finding.line), ("col", finding.column)];
    let places = places
        .into_iter()
        .filter_map(|(name, at)| Some((name, at?)));
    properties.extend(places.map(|(name, at)| format!("{name}={at}")));
    properties.push(format!(
        "title={}",
        property(&format!("umbrage: {}", finding.rule))
    ));
    let command = match finding.level {
        Level::Error => "error",
        Level::Warning => "warning",
    };
    let properties = properties.join(",");
    format!("::{command} {properties}::{}\n", data(&finding.text()))
}

/// A message, in one line.
fn data(text: &str) -> String {
    text.replace('%', "%25")
        .replace('\r', "%0D")
        .replace('\n', "%0A")
}

/// A property's value, which a comma or a colon would end.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_ends_a_line_or_a_property() {
        assert_eq!(data("50%\r\nof: a, b"), "50%25%0D%0Aof: a, b");
        assert_eq!(property("a,b: 5%\n"), "a%2Cb%3A 5%25%0A");
    }
}
