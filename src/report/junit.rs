//! Verdicts as tests, for whatever shows the results of tests.

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use crate::statistics::Verdict;
use crate::trial::RunOutcome;

/// JUnit: a suite for each case, a test for each strategy and property. What failed is a failure; what is undecided an error,
/// or skipped where that is allowed.
pub fn verdicts_junit(outcome: &RunOutcome, allow_undecided: bool) -> String {
    let mut report = Report::new("etendue");
    for case in &outcome.cases {
        let mut suite = TestSuite::new(case.name.as_str());
        for (strategy, judged) in case.verdicts() {
            let with_words = |mut status: TestCaseStatus| {
                status.set_message(judged.words.as_str());
                status.set_type(judged.verdict.name());
                status.set_description(format!("reproduce: {}", judged.reproduce));
                status
            };
            let status = match judged.verdict {
                Verdict::Pass => TestCaseStatus::success(),
                Verdict::Fail => with_words(TestCaseStatus::non_success(NonSuccessKind::Failure)),
                Verdict::Undecided if allow_undecided => with_words(TestCaseStatus::skipped()),
                Verdict::Undecided => with_words(TestCaseStatus::non_success(NonSuccessKind::Error)),
            };
            let mut test = TestCase::new(format!("{strategy} {}", judged.property), status);
            test.set_classname(case.name.as_str());
            if judged.verdict == Verdict::Pass {
                test.set_system_out(judged.words.as_str());
            }
            suite.add_test_case(test);
        }
        report.add_test_suite(suite);
    }
    report.to_string().expect("texts are XML")
}
