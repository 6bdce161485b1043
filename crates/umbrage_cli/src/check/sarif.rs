//! SARIF 2.1.0 (<https://docs.oasis-open.org/sarif/sarif/v2.1.0/sarif-v2.1.0.html>), which services show beside the code.

use anyhow::{Context, Result};
use serde_json::{Map, Value, json};
use serde_sarif::sarif;

use super::report::{Finding, Level, Report};

pub(crate) fn log(report: &Report) -> Result<sarif::Sarif> {
    let mut names: Vec<_> = report.findings().map(|found| &*found.rule).collect();
    names.sort_unstable();
    names.dedup();
    let rules = names
        .iter()
        .map(|name| sarif::ReportingDescriptor::builder().id(*name).build());
    let tool = sarif::ToolComponent::builder()
        .name("umbrage")
        .version(env!("CARGO_PKG_VERSION"))
        .rules(rules.collect::<Vec<_>>())
        .build();
    let results = report.findings().map(|finding| {
        let rule = names.binary_search(&&*finding.rule);
        result(finding, rule.unwrap_or_default() as i64)
    });
    let results = results.collect::<Result<Vec<_>>>()?;
    let tool: sarif::Tool = sarif::Tool::builder().driver(tool).build();
    let run = sarif::Run::builder()
        .tool(tool)
        // Columns are counted in characters.
        .column_kind(json!("unicodeCodePoints"))
        .results(results)
        .build();
    Ok(sarif::Sarif::builder()
        .version(sarif::Version::V2_1_0.to_string())
        .schema(sarif::SCHEMA_URL)
        .runs(vec![run])
        .build())
}

fn result(finding: &Finding, rule: i64) -> Result<sarif::Result> {
    let level = match finding.level {
        Level::Error => sarif::ResultLevel::Error,
        Level::Warning => sarif::ResultLevel::Warning,
    };
    let mut properties = Map::new();
    properties.insert("cause".to_owned(), finding.cause.as_str().into());
    properties.insert("permutations".to_owned(), finding.permutations.into());
    properties.insert("keys".to_owned(), finding.keys.clone().into());
    let properties: sarif::PropertyBag = serde_json::from_value(Value::Object(properties))
        .context("the result cannot be written as SARIF")?;
    Ok(sarif::Result::builder()
        .rule_id(finding.rule.as_str())
        .rule_index(rule)
        .level(level)
        .message(sarif::Message::builder().text(finding.text()).build())
        .locations(location(finding).into_iter().collect::<Vec<_>>())
        .properties(properties)
        .build())
}

fn location(finding: &Finding) -> Option<sarif::Location> {
    let file = sarif::ArtifactLocation::builder()
        .uri(uri(&finding.path()?))
        .build();
    let mut region = sarif::Region::builder().build();
    region.start_line = finding.line.and_then(|line| i64::try_from(line).ok());
    region.start_column = finding.column.and_then(|at| i64::try_from(at).ok());
    let place = sarif::PhysicalLocation::builder()
        .artifact_location(file)
        .region(region)
        .build();
    let location = sarif::Location::builder().physical_location(place);
    Some(location.build())
}

/// `path` as a reference: relative where it is relative.
fn uri(path: &str) -> String {
    let bytes = path.bytes().map(|byte| match byte {
        b'/' | b'-' | b'_' | b'.' | b'~' => char::from(byte).to_string(),
        _ if byte.is_ascii_alphanumeric() => char::from(byte).to_string(),
        _ => format!("%{byte:02X}"),
    });
    let encoded: String = bytes.collect();
    match path.starts_with('/') {
        true => format!("file://{encoded}"),
        false => encoded,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_path_breaks_a_reference() {
        assert_eq!(uri("lib/my shader#1.wesl"), "lib/my%20shader%231.wesl");
        assert_eq!(uri("/tmp/ä.wesl"), "file:///tmp/%C3%A4.wesl");
    }
}
