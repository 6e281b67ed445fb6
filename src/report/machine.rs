//! Verdicts for programs: one JSON object, or JSON Lines.

use serde::Serialize;

use crate::statistics::Verdict;
use crate::trial::{CaseOutcome, JudgedProperty, RunOutcome};

/// Rises when a reader of an older output would misread a newer one.
const SCHEMA_VERSION: u32 = 1;

/// One verdict; numbers as in `verdicts.csv`.
#[derive(Serialize)]
struct Told<'a> {
    case: &'a str,
    strategy: &'a str,
    property: &'a str,
    verdict: &'static str,
    evidence: f64,
    threshold: f64,
    effect: f64,
    effect_low: f64,
    effect_high: f64,
    smallest_bias_mean: Option<f64>,
    smallest_bias_point: Option<f64>,
    words: &'a str,
    note: Option<&'a str>,
    reproduce: &'a str,
}

/// How many of each.
#[derive(Serialize)]
struct Summary {
    passed: usize,
    failed: usize,
    undecided: usize,
}

/// What stands around the verdicts.
#[derive(Serialize)]
struct Head<'a> {
    schema_version: u32,
    etendue_version: &'static str,
    seed: u64,
    command: &'a str,
    /// Folder of the report; null where none was written.
    report: Option<&'a str>,
    summary: Summary,
    /// Cases that were not finished, where the run was interrupted.
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    missing: &'a [String],
}

fn each(outcome: &RunOutcome) -> impl Iterator<Item = (&str, &str, &JudgedProperty)> {
    outcome.cases.iter().flat_map(of_case)
}

fn of_case(case: &CaseOutcome) -> impl Iterator<Item = (&str, &str, &JudgedProperty)> {
    case.verdicts().map(|(strategy, judged)| (case.name.as_str(), strategy, judged))
}

fn told<'a>((case, strategy, judged): (&'a str, &'a str, &'a JudgedProperty)) -> Told<'a> {
    Told {
        case,
        strategy,
        property: judged.property,
        verdict: judged.verdict.name(),
        evidence: judged.evidence,
        threshold: judged.threshold,
        effect: judged.effect,
        effect_low: judged.effect_low,
        effect_high: judged.effect_high,
        smallest_bias_mean: judged.smallest_bias_mean,
        smallest_bias_point: judged.smallest_bias_point,
        words: &judged.words,
        note: judged.note.as_deref(),
        reproduce: &judged.reproduce,
    }
}

fn head<'a>(outcome: &'a RunOutcome, report: Option<&'a str>) -> Head<'a> {
    let count = |verdict| each(outcome).filter(|(_, _, judged)| judged.verdict == verdict).count();
    Head {
        schema_version: SCHEMA_VERSION,
        etendue_version: env!("CARGO_PKG_VERSION"),
        seed: outcome.seed,
        command: &outcome.command,
        report,
        summary: Summary {
            passed: count(Verdict::Pass),
            failed: count(Verdict::Fail),
            undecided: count(Verdict::Undecided),
        },
        missing: &outcome.missing,
    }
}

/// One object: `summary` and what made it, then `verdicts`.
///
/// - `report`: the folder that the report was written to
pub fn verdicts_json(outcome: &RunOutcome, report: Option<&str>) -> String {
    #[derive(Serialize)]
    struct Whole<'a> {
        #[serde(flatten)]
        head: Head<'a>,
        verdicts: Vec<Told<'a>>,
    }
    let whole = Whole { head: head(outcome, report), verdicts: each(outcome).map(told).collect() };
    let mut text = serde_json::to_string_pretty(&whole).expect("texts and numbers serialise");
    text.push('\n');
    text
}

/// A line of JSON Lines says of what type it is.
#[derive(Serialize)]
struct Line<T: Serialize> {
    r#type: &'static str,
    #[serde(flatten)]
    content: T,
}

fn line<T: Serialize>(r#type: &'static str, content: T) -> String {
    let mut text = serde_json::to_string(&Line { r#type, content }).expect("texts and numbers serialise");
    text.push('\n');
    text
}

/// One line for each verdict of a case (`"type": "verdict"`).
pub fn case_json_lines(case: &CaseOutcome) -> String {
    of_case(case).map(|verdict| line("verdict", told(verdict))).collect()
}

/// The last line (`"type": "summary"`).
///
/// - `report`: the folder that the report was written to
pub fn summary_json_line(outcome: &RunOutcome, report: Option<&str>) -> String {
    line("summary", head(outcome, report))
}
