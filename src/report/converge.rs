//! A witness that was judged by convergence: its levels and points as tables, the verdict as JSON and JUnit.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::ReportError;
use super::column::Table;
use super::folder::{claim_files, write_whole};
use super::images::{column, document, junit, verdict_json, verdict_lines, word};
use crate::statistics::Verdict;
use crate::trial::{ConvergenceOutcome, Level};

/// Files of a report on convergence.
const FILES: [&str; 4] = ["levels.csv", "limits.csv", "verdict.json", "junit.xml"];

/// Writes the whole report. Returns the files written.
pub fn write_convergence(dir: &Path, outcome: &ConvergenceOutcome) -> Result<Vec<PathBuf>, ReportError> {
    claim_files(dir, &FILES)?;
    let (mut of_levels, mut of_points) = (Vec::new(), Vec::new());
    levels().write(outcome.levels.iter().map(|level| (outcome, level)), &mut of_levels)?;
    points().write((0..outcome.points.len()).map(|p| (outcome, p)), &mut of_points)?;
    let verdicts = std::slice::from_ref(&outcome.verdict);
    let contents = [
        of_levels,
        of_points,
        json_of(outcome).into_bytes(),
        junit(&outcome.case, &outcome.name, verdicts).into_bytes(),
    ];
    FILES.iter().zip(&contents).map(|(name, content)| write_whole(dir, name, content)).collect()
}

type LevelRow<'a> = (&'a ConvergenceOutcome, &'a Level);
type PointRow<'a> = (&'a ConvergenceOutcome, usize);

pub(super) fn levels<'a>() -> Table<LevelRow<'a>> {
    Table {
        file: "levels.csv",
        row: "one effort of a witness without randomness (`etendue verify CASE estimates.csv --converging`)",
        columns: vec![
            column("case", "", "name of the case", |(o, _): &LevelRow| o.case.as_str().into()),
            column("judged", "", "what reports call the judged", |(o, _)| o.name.as_str().into()),
            column("effort", "", "what its column `samples` counts", |(_, l)| l.effort.into()),
            column("mean_deviation", "", "relative deviation of the mean over the points", |(_, l)| l.mean.into()),
            column(
                "worst_deviation",
                "",
                "largest deviation of a point, relative to what is due there or to a tenth of the unoccluded light",
                |(_, l)| l.worst.into(),
            ),
            column("worst_point", "", "that point, counted from 0", |(_, l)| l.worst_point.into()),
            column("mean_change", "", "size of the mean's change since the last effort, relative", |(_, l)| {
                l.change_mean.into()
            }),
            column("worst_change", "", "largest change of a point", |(_, l)| l.change_worst.into()),
        ],
        more: &[],
        case: |(o, _)| &o.case,
    }
}

pub(super) fn points<'a>() -> Table<PointRow<'a>> {
    Table {
        file: "limits.csv",
        row: "one point, as the largest effort has it",
        columns: vec![
            column("case", "", "name of the case", |(o, _): &PointRow| o.case.as_str().into()),
            column("judged", "", "what reports call the judged", |(o, _)| o.name.as_str().into()),
            column("point", "", "counted from 0", |(_, p)| (*p).into()),
            column("exact_irradiance_W_m2", "W/m²", "what is due", |(o, p)| o.points[*p][1].into()),
            column("estimate_W_m2", "W/m²", "at the largest effort, mean over replicates", |(o, p)| {
                o.points[*p][0].into()
            }),
        ],
        more: &[],
        case: |(o, _)| &o.case,
    }
}

fn json_of(outcome: &ConvergenceOutcome) -> String {
    let known = |x: f64| x.is_finite().then_some(x);
    document(&json!({
        "schema_version": 1,
        "case": outcome.case,
        "judged": outcome.name,
        "verdict": word(Some(outcome.verdict.verdict)),
        "efforts": outcome.levels.iter().map(|level| level.effort).collect::<Vec<_>>(),
        "rate": outcome.rate,
        "left": { "mean": known(outcome.left[0]), "worst_point": known(outcome.left[1]) },
        "verdicts": [verdict_json(&outcome.verdict)],
    }))
}

/// What the terminal is told.
pub fn convergence_table(outcome: &ConvergenceOutcome, report: &Path) -> String {
    let mut text = format!("{}: {}, by convergence\n\n", outcome.case, outcome.name);
    text += &format!("  {:>10}  {:>11}  {:>11}  {:>5}  {:>12}\n", "effort", "mean", "worst", "point", "last change");
    for level in &outcome.levels {
        let change = level.change_worst.map_or("-".to_owned(), |change| format!("{:.4} %", 100.0 * change));
        text += &format!(
            "  {:>10}  {:>+9.4} %  {:>+9.4} %  {:>5}  {change:>12}\n",
            level.effort,
            100.0 * level.mean,
            100.0 * level.worst,
            level.worst_point
        );
    }
    text.push('\n');
    text += &verdict_lines(&outcome.verdict);
    if outcome.verdict.verdict == Verdict::Fail {
        text += &format!("again      {}\n", outcome.verdict.reproduce);
    }
    text + &format!("report     {}\n", report.display())
}
