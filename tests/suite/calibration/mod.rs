//! The gate, measured in a minute: a few null runs through `etendue::calibration`, and every planted fault.
//!
//! `etendue calibrate` looks longer; `reports/reference/calibration/` holds what it found.

mod faults;
mod mixed;
mod plain;
mod planted_faults;
mod rooms;
mod wrapped;

use etendue::calibration::{Calibration, Options, calibrate};
use etendue::statistics::Verdict;
use etendue::statistics::budget::{plausible, seed_of};

fn calibrated(seed: u64) -> Calibration {
    calibrate(&Options { seed, runs: 840, power_runs: 4 }, &|_| ()).expect("a calibration")
}

/// A gate that keeps its level α raises so many alarms with a chance above 1e-6.
#[test]
fn false_alarms_stay_below_nominal() {
    let found = calibrated(seed_of("false_alarms_stay_below_nominal"));
    assert!(found.null_runs >= 840);
    assert!(found.alarms.iter().any(|row| row.property == "bias" && row.case.is_none()));
    for row in &found.alarms {
        assert!(plausible(row.alarms, row.runs, 0.0, row.level), "{row:?}");
        assert!(row.largest_evidence < 6.0, "{row:?}");
    }
    // Twenty runs a row say little of a coverage; over all rows of a kind with enough rays they say something. Places of
    // one run hang together, so they count as one.
    for interval in ["variance", "mean_variance", "slope", "correlation", "bias", "effect"] {
        let rows = || found.coverage.iter().filter(|row| row.interval == interval && row.enough_rays);
        let runs: u64 = rows().map(|row| row.runs).sum();
        let covered: f64 = rows().filter_map(|row| Some(row.coverage? * row.runs as f64)).sum();
        assert!(runs >= 600, "{interval}: {runs}");
        assert!(plausible(covered.round() as u64, runs, 0.93, 1.0), "{interval}: {covered} of {runs}");
    }
    for row in &found.power {
        assert!(row.caught >= 1 && row.normal < row.predicted, "{row:?}");
    }
}

#[test]
fn threads_move_no_number_of_a_calibration() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| calibrate(&Options { seed: 5, runs: 42, power_runs: 2 }, &|_| ()).expect("a calibration"))
    };
    let (one, four) = (on(1), on(4));
    assert_eq!(one.alarms, four.alarms);
    assert_eq!(one.coverage, four.coverage);
    assert_eq!(one.power, four.power);
    assert!(one.power.iter().all(|row| row.verdict != Verdict::Undecided));
}
