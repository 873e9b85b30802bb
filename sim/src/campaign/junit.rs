//! Results as JUnit XML, which CI systems show test by test.

use std::time::Duration;

use quick_junit::{NonSuccessKind, Report, SerializeError, TestCase, TestCaseStatus, TestSuite};

use crate::campaign::{
    cases::{CaseResult, Replay, Results},
    report::first_outside,
    sweep::Recorded,
};

/// Writes results as JUnit XML: one suite for each scene, one test for each case. A missed expectation is a failure; a case that is
/// missing or could not run is an error.
pub fn to_junit(results: &Results) -> Result<String, SerializeError> {
    let mut report = Report::new("wherein");
    let mut scenes: Vec<&str> = results.cases.iter().map(|case| case.scene.as_str()).collect();
    scenes.dedup();
    for scene in scenes {
        let mut suite = TestSuite::new(scene);
        suite.add_test_cases(results.cases.iter().filter(|case| case.scene == scene).map(test_case));
        report.add_test_suite(suite);
    }
    report.to_string()
}

fn test_case(case: &CaseResult) -> TestCase {
    let mut test = TestCase::new(case.describe(false), status(case));
    test.set_classname(case.scene.clone());
    if let Some(wall_s) = case.timing().and_then(|timing| timing["wall_s"].as_f64()) {
        test.set_time(Duration::from_secs_f64(wall_s.max(0.0)));
    }
    test
}

fn status(case: &CaseResult) -> TestCaseStatus {
    match &case.recorded {
        Recorded::Done { .. } if case.passed() == Some(true) => TestCaseStatus::success(),
        Recorded::Done { .. } => not_passed(NonSuccessKind::Failure, case, &failure_message(case)),
        Recorded::Failed(reason) => not_passed(NonSuccessKind::Error, case, reason),
        Recorded::Missing => not_passed(NonSuccessKind::Error, case, "missing: the case has not run"),
    }
}

/// Returns time, axis, distance and cause of the first loss of the truth, at which the true pose was outside the estimate; if there was none, the
/// expectations that the case missed.
pub fn failure_message(case: &CaseResult) -> String {
    first_outside(case).unwrap_or_else(|| case.missed_expectations().join("; "))
}

/// Returns `message`, the missed expectations that the message does not mention, and the command that runs the case again.
pub fn failure_account(case: &CaseResult, message: &str) -> String {
    let missed = case.missed_expectations().into_iter().filter(|line| !message.contains(line)).map(str::to_owned);
    let replay = format!("replay: {}", Replay::of(case, "renders"));
    [message.to_owned()].into_iter().chain(missed).chain([replay]).collect::<Vec<_>>().join("\n")
}

fn not_passed(kind: NonSuccessKind, case: &CaseResult, message: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    status.set_message(message);
    status.set_type(if kind == NonSuccessKind::Failure { "expectation" } else { "not run" });
    status.set_description(failure_account(case, message) + "\n");
    status
}
