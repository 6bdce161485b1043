//! JUnit's XML, which CI services show as tests: each finding is a test, and an error a failed one.

use anyhow::{Context, Result};
use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};

use super::report::{Finding, Level, Report};

pub(crate) fn document(report: &Report) -> Result<String> {
    let mut suite = TestSuite::new("umbrage check");
    if !report.is_faulty() {
        let mut all = TestCase::new("all permutations", TestCaseStatus::success());
        all.set_classname("umbrage");
        all.set_system_out(report.summary());
        suite.add_test_case(all);
    }
    suite.add_test_cases(report.findings().map(case));
    if !report.warnings.is_empty() {
        suite.set_system_out(report.warnings.join("\n"));
    }
    let mut all = quick_junit::Report::new("umbrage check");
    all.add_test_suite(suite);
    all.to_string()
        .context("the result cannot be written as XML")
}

fn case(finding: &Finding) -> TestCase {
    let place = match (finding.path(), finding.line, finding.column) {
        (Some(file), Some(line), Some(column)) => format!("{file}:{line}:{column}"),
        (Some(file), ..) => file,
        _ => finding.keys.first().cloned().unwrap_or_default(),
    };
    let text = finding.for_a_person();
    let status = match finding.level {
        Level::Error => {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_message(finding.message.as_str());
            status.set_type(finding.rule.as_str());
            status.set_description(text.as_str());
            status
        }
        Level::Warning => TestCaseStatus::success(),
    };
    let mut case = TestCase::new(format!("{place}: {}", finding.message), status);
    case.set_classname(format!("umbrage.{}", finding.rule));
    if finding.level == Level::Warning {
        case.set_system_out(text);
    }
    case
}
