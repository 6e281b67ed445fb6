//! Tables of a calibration, and what of them fits on a terminal.

use std::path::{Path, PathBuf};

use super::ReportError;
use super::column::{Column, Field, Table};
use super::folder::{self, write_whole};
use super::tables::column;
use crate::calibration::{AlarmRow, Calibration, CoverageRow, ENOUGH_RAYS, LEAST_COVERAGE, PowerRow};

/// Makes sure, before the work, that the tables can be written.
pub fn claim_calibration(dir: &Path) -> Result<(), ReportError> {
    folder::claim_files(dir, &[ALARMS, COVERAGE, POWER, SUMMARY])
}

/// Writes `false_alarms.csv`, `coverage.csv`, `power.csv` and `summary.txt` into a folder, which is made if need be. The same
/// calibration gives the same bytes.
pub fn write_calibration(dir: &Path, calibration: &Calibration) -> Result<Vec<PathBuf>, ReportError> {
    std::fs::create_dir_all(dir).map_err(|source| ReportError::Folder { path: dir.to_owned(), source })?;
    let contents = [
        (ALARMS, filled(alarms(), &calibration.alarms)?),
        (COVERAGE, filled(coverage(), &calibration.coverage)?),
        (POWER, filled(power(), &calibration.power)?),
        (SUMMARY, calibration_table(calibration).into_bytes()),
    ];
    contents.iter().map(|(name, content)| write_whole(dir, name, content)).collect()
}

const ALARMS: &str = "false_alarms.csv";
const COVERAGE: &str = "coverage.csv";
const POWER: &str = "power.csv";
const SUMMARY: &str = "summary.txt";

fn filled<'a, R>(table: Table<&'a R>, rows: &'a [R]) -> Result<Vec<u8>, ReportError> {
    let mut content = Vec::new();
    table.write(rows, &mut content)?;
    Ok(content)
}

fn alarms<'a>() -> Table<&'a AlarmRow> {
    Table {
        file: ALARMS,
        row: "one level of one judged property, over null runs of correct estimators",
        case: |r| r.case.as_deref().unwrap_or("all"),
        columns: vec![
            column!("property", "", "what was judged", |r| r.property),
            column!("case", "", "the small room, or `all` of them", |r| r.case.as_deref().unwrap_or("all")),
            column!("level", "", "α: the largest rate that the gate claims", |r| r.level),
            column!("runs", "", "verdicts on correct estimators, each from a seed of its own", |r| r.runs),
            column!("alarms", "", "verdicts whose capital reached 1/α", |r| r.alarms),
            column!("rate", "", "alarms in a run", |r| r.rate),
            column!(
                "upper_limit",
                "",
                "the rate is below this with 95 % confidence (Clopper and Pearson, one-sided)",
                |r| r.upper_limit
            ),
            column!("largest_evidence", "", "log10 of the largest capital of all the runs", |r| r.largest_evidence),
            column!(
                "verdict",
                "",
                "`pass`: the limit is at or below the level; `fail`: so many alarms would come in less than 1 of 20 calibrations of a gate that keeps the level; else `undecided`",
                |r| r.verdict.name()
            ),
        ],
        more: &[],
    }
}

fn coverage<'a>() -> Table<&'a CoverageRow> {
    Table {
        file: COVERAGE,
        row: "one kind of printed interval under one strategy (over all rooms), or in one small room (over all strategies)",
        case: |r| r.case.as_deref().unwrap_or("all"),
        columns: vec![
            column!(
                "interval",
                "",
                "`variance` of a point at one N, `mean_variance` over the points at one N, `slope`, `correlation`, `bias` of the mean over the points at one N, `effect` of the verdict on the bias",
                |r| r.interval
            ),
            column!("case", "", "the small room, or `all`", |r| r.case.as_deref().unwrap_or("all")),
            column!("strategy", "", "the strategy's name, or `all`", |r| r.strategy.unwrap_or("all")),
            column!("rays", "", "`enough`, or `few` where fewer than 30 are expected to arrive", |r| rays(r)),
            column!("places", "", "points, regions, separations and N that were asked, each in every run", |r| r
                .places),
            column!("runs", "", "runs, each from a seed of its own", |r| r.runs),
            column!("nominal", "", "what the interval claims", |r| r.nominal),
            column!("printed", "", "intervals that were printed", |r| r.printed),
            column!("missing", "", "places and runs without one", |r| r.missing),
            column!("covered", "", "of those, how many held the true value", |r| r.covered),
            column!("coverage", "", "the share that held it; empty where none was printed", |r| r.coverage),
            column!(
                "coverage_low",
                "",
                "its 95 % limits (Clopper and Pearson), as though the places of one run all held it or all did not",
                |r| r.low
            ),
            column!("coverage_high", "", "the upper one", |r| r.high),
            column!("worst", "", "the lowest share at any one place", |r| r.worst),
            column!("worst_place", "", "that place", |r| r.worst_place.as_str()),
            column!(
                "verdict",
                "",
                "`pass`: 0.93 or more by the lower limit; `fail`: less by the upper limit, or at the worst place by its 99.9 % limit; `not_judged` where few rays arrive or nothing was printed",
                |r| r.verdict.map_or("not_judged", |verdict| verdict.name())
            ),
        ],
        more: &[],
    }
}

fn rays(row: &CoverageRow) -> &'static str {
    if row.enough_rays { "enough" } else { "few" }
}

fn power<'a>() -> Table<&'a PowerRow> {
    Table {
        file: POWER,
        row: "one study in which biases were planted, relative to the exact value",
        case: |r| &r.case,
        columns: vec![
            column!("case", "", "the small room", |r| r.case.as_str()),
            column!("strategy", "", "the strategy's name", |r| r.strategy),
            column!(
                "subject",
                "",
                "`mean`: every point shifted in proportion to its value; `point`: the worst well-lit one alone",
                |r| r.subject.name()
            ),
            column!("planted", "", "`scaled`: estimates times a factor; `added`: a constant on top of them", |r| r
                .planted
                .name()),
            column!("samples", "", "the only N of the study", |r| r.samples),
            column!("replicates", "", "independent estimates that were made", |r| r.replicates),
            column!("std_error", "", "relative standard error of what is shifted", |r| r.std_error),
            column!("predicted", "", "relative bias that the verdicts promised to catch with 99 %, median", |r| r
                .predicted),
            column!(
                "measured",
                "",
                "relative bias that 99 of 100 runs caught; empty beyond twice the promise",
                |r| r.measured
            ),
            column!("measured_low", "", "its 95 % limits, by order statistics", |r| r.measured_low),
            column!("measured_high", "", "the upper one; empty where the runs are too few for one", |r| r
                .measured_high),
            column!(
                "normal",
                "",
                "what a normal test of this one mean would catch with 99 % at the same level",
                |r| r.normal
            ),
            column!("runs", "", "runs, each from a seed of its own", |r| r.runs),
            column!("caught", "", "runs that caught what their own verdict promised", |r| r.caught),
            column!("share", "", "their share", |r| r.share),
            column!("share_low", "", "its 95 % limits (Clopper and Pearson)", |r| r.low),
            column!("share_high", "", "the upper one", |r| r.high),
            column!("verdict", "", "`fail`: 99 % is refuted (one-sided, 99.9 %); else `pass`", |r| r.verdict.name()),
        ],
        more: &[],
    }
}

/// The text of `reports/reference/calibration/README.md`: what the tables mean and how they are made.
pub fn calibration_reference() -> String {
    let head = "\
# The gate, measured

Does a verdict keep what it claims? `etendue calibrate --out reports/reference/calibration` (release build, some ten minutes) makes
three tables: false alarms over runs of correct estimators, coverage of every printed interval, and power; what of them
fits on a screen is in [`summary.txt`](summary.txt). `--runs N` sets the null runs, `--seed` the base of all seeds; the same command gives the same bytes on any number of threads.

`faults.csv` is the fourth: estimators that are wrong in one known way, and which verdicts found out.
`CALIBRATION_SEEDS=100 cargo test --release planted_faults` writes it anew; without the variable, `cargo test` checks
two seeds of each fault and writes nothing. The faults live in `tests/suite/calibration/` only.

*(This page is written by the code that writes the tables: `cargo test --lib write_the_calibration_reference -- --ignored`.)*
";
    let faults = "\
## `faults.csv`

One row is one planted fault.

| column | unit | meaning |
|---|---|---|
| `fault` |  | its name in `tests/suite/calibration/faults.rs` |
| `what` |  | what is wrong |
| `case`, `strategy`, `samples` |  | where it was planted |
| `mean_shift` |  | relative shift of the mean over the points, at the N where it is largest (mean over the seeds) |
| `point_shift` |  | relative shift at the worst point that a tenth or more of the light reaches, the same way |
| `variance_factor` |  | variance over that of a correct estimator, where it is farthest from 1 |
| `mean_variance_factor` |  | the same of the variance of the mean over the points, which knows how points go together |
| `due` |  | whether it must be caught: mean by 3 %, a lit point by 30 %, or either variance by 20 % (factor 1.2, or 0.8) |
| `expected` |  | the verdicts of which one is to catch it |
| `seeds` |  | runs, each from a seed of its own |
| `caught` |  | runs in which an expected verdict failed |
| `by` |  | every verdict that failed, with how many runs |
| `result` |  | `caught` (in every run); else `not due` for its size, `not judged yet` (no expected verdict exists), or `missed` |
";
    [head.to_owned(), alarms().described(), coverage().described(), power().described(), faults.to_owned()].join("\n")
}

/// What a terminal shows: rates over all cases, the least coverage of each kind, and power.
pub fn calibration_table(calibration: &Calibration) -> String {
    let mut text = format!("False alarms of correct estimators, {} null runs\n", calibration.null_runs);
    text += "  property    level    alarms    runs  upper limit (95 %)\n";
    for row in calibration.alarms.iter().filter(|row| row.case.is_none()) {
        text += &format!(
            "  {:<10}{:>7}{:>10}{:>8}  {:<12.2e}{}\n",
            row.property, row.level, row.alarms, row.runs, row.upper_limit, row.verdict
        );
    }
    text += &format!("\nCoverage of printed 95 % intervals (at least {:.0} % is due)\n", 100.0 * LEAST_COVERAGE);
    text += &format!(
        "  interval       rays    printed   covered  least row  pass/undecided/fail  (few: below {ENOUGH_RAYS})\n"
    );
    let over_cases = || calibration.coverage.iter().filter(|row| row.case.is_none());
    let mut kinds: Vec<(&str, bool)> = over_cases().map(|row| (row.interval, row.enough_rays)).collect();
    kinds.dedup();
    for (interval, enough) in kinds {
        let of_it = || over_cases().filter(|r| (r.interval, r.enough_rays) == (interval, enough));
        let all = || calibration.coverage.iter().filter(|r| (r.interval, r.enough_rays) == (interval, enough));
        let (printed, covered) = of_it().fold((0, 0), |(p, c), row| (p + row.printed, c + row.covered));
        let least = all().filter_map(|row| row.coverage).fold(f64::INFINITY, f64::min);
        let of = |name: &str| all().filter(|row| row.verdict.is_some_and(|v| v.name() == name)).count();
        let share = if printed > 0 { 100.0 * covered as f64 / printed as f64 } else { 0.0 };
        let least = if least.is_finite() { format!("{:.1} %", 100.0 * least) } else { "-".to_owned() };
        text += &format!(
            "  {interval:<15}{:<7}{printed:>8}{share:>8.1} %{least:>11}{:>9}/{}/{}\n",
            if enough { "enough" } else { "few" },
            of("pass"),
            of("undecided"),
            of("fail")
        );
    }
    text += "\nPower: relative bias caught with 99 %\n";
    text += "  case                  strategy    subject planted      N  promised  measured    normal  caught as promised\n";
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    for row in &calibration.power {
        text += &format!(
            "  {:<22}{:<12}{:<8}{:<8}{:>6}{:>10}{:>10}{:>10}  {} of {} {}\n",
            row.case,
            row.strategy,
            row.subject.name(),
            row.planted.name(),
            row.samples,
            percent(row.predicted),
            row.measured.map_or("-".to_owned(), percent),
            percent(row.normal),
            row.caught,
            row.runs,
            row.verdict
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::{Options, calibrate};
    use std::fs;

    /// To write it anew: `cargo test --lib write_the_calibration_reference -- --ignored`.
    #[test]
    fn the_committed_calibration_reference_is_the_codes() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/reference/calibration/README.md");
        assert_eq!(
            fs::read_to_string(path).unwrap_or_default(),
            calibration_reference(),
            "write it anew with `cargo test --lib write_the_calibration_reference -- --ignored`"
        );
    }

    #[test]
    #[ignore = "writes reports/reference/calibration/README.md"]
    fn write_the_calibration_reference() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/reference/calibration");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("README.md"), calibration_reference()).unwrap();
    }

    #[test]
    fn every_row_is_written_and_the_words_name_every_table() {
        let calibration = calibrate(&Options { seed: 3, runs: 42, power_runs: 1 }, &|_| ()).unwrap();
        let dir = tempfile::tempdir().unwrap();
        claim_calibration(dir.path()).unwrap();
        let written = write_calibration(dir.path(), &calibration).unwrap();
        let lines = |k: usize| fs::read_to_string(&written[k]).unwrap().lines().count();
        assert_eq!(lines(0), calibration.alarms.len() + 1);
        assert_eq!(lines(1), calibration.coverage.len() + 1);
        assert_eq!(lines(2), calibration.power.len() + 1);
        let words = calibration_table(&calibration);
        assert!(words.contains("bias") && words.contains("correlation") && words.contains("antumbra"), "{words}");
    }
}
