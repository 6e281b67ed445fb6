//! The gate, measured: how often it cries wolf, whether the intervals it prints cover, and how small a bias it sees.
//!
//! Everything goes through the public door of [`crate::trial`], as a user's study does:
//!
//! - *null runs* of correct estimators over small rooms, skewed ones among them: how often does a verdict's evidence reach
//!   1/α, for α from 0.1 to 1e-4? At most with probability α, says the proof (`statistics::evidence`); here it is counted;
//! - *coverage*: in the same runs, how often does each printed 95 % interval hold the true value?
//! - *power*: the smallest planted bias that is caught in 99 of 100 runs, beside what the verdict had promised.
//!
//! Every run has its own seed, from the base seed, the room, the strategy and its number; results are gathered in that
//! order, so that any number of threads gives the same bytes.

mod alarms;
mod coverage;
mod null;
mod power;
mod rooms;

use crate::statistics::Verdict;
use crate::trial::TrialError;

pub use alarms::{AlarmRow, LEVELS};
pub use coverage::{CoverageRow, ENOUGH_RAYS, LEAST_COVERAGE};
pub use power::{CAUGHT, Planted, PowerRow, Subject};

/// How long to look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    pub seed: u64,
    /// Null runs, at least: one case under one strategy each. Rounded up to the same number for all of them.
    pub runs: u64,
    /// Runs for each row of the power table, of some eight estimates of a cell each.
    pub power_runs: u64,
}

impl Options {
    /// Where not one alarm was raised, that a level of 1e-4 is kept can be shown from 29,956 runs on.
    pub const STANDARD: Options = Options { seed: 1, runs: 56_000, power_runs: 400 };
    /// A look.
    pub const QUICK: Options = Options { seed: 1, runs: 2_000, power_runs: 20 };
}

/// What a calibration tells while it goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress<'a> {
    /// What is measured now.
    Stage(&'a str),
    /// As many runs will be made in all.
    Planned(u64),
    /// As many more are made.
    Done(u64),
}

/// What the gate was found to do.
#[derive(Clone, Debug)]
pub struct Calibration {
    pub options: Options,
    /// Null runs that were made.
    pub null_runs: u64,
    pub alarms: Vec<AlarmRow>,
    pub coverage: Vec<CoverageRow>,
    pub power: Vec<PowerRow>,
}

impl Calibration {
    /// Whether any figure misses its bar, for certain.
    pub fn fails(&self) -> bool {
        let alarms = self.alarms.iter().map(|row| row.verdict);
        let coverage = self.coverage.iter().filter_map(|row| row.verdict);
        let power = self.power.iter().map(|row| row.verdict);
        alarms.chain(coverage).chain(power).any(|verdict| verdict == Verdict::Fail)
    }
}

/// Measures the gate on the built-in estimators.
pub fn calibrate(options: &Options, progress: &(dyn Fn(Progress) + Sync)) -> Result<Calibration, TrialError> {
    let rooms = rooms::rooms();
    let (each, null_runs) = null::shares(&rooms, options.runs);
    progress(Progress::Planned(null_runs + power::runs(options.power_runs)));
    progress(Progress::Stage("null runs"));
    let null = null::measure(&rooms, options.seed, each, progress)?;
    progress(Progress::Stage("power"));
    let power = power::measure(&rooms, options.seed, options.power_runs, progress)?;
    Ok(Calibration { options: *options, null_runs, alarms: null.alarms, coverage: null.coverage, power })
}
