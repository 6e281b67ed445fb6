//! The smallest bias that is caught, promised and measured.
//!
//! Each run of a row has its own seed; within it the planted bias is moved, over the same streams, to where the verdict
//! turns. The bias that 99 of 100 runs catch is then a quantile of those places, with limits that assume nothing about
//! their distribution.

use rayon::prelude::*;

use super::Progress;
use super::rooms::Room;
use crate::case::{Case, Replicates};
use crate::estimator::{Estimator, Job, Scratch, for_technique};
use crate::sampling::Strategy;
use crate::statistics::Verdict;
use crate::statistics::budget::seed_of;
use crate::statistics::evidence::ALPHA;
use crate::statistics::interval::normal_quantile;
use crate::statistics::proportion::{clopper_pearson, upper_limit};
use crate::trial::{
    CaseOutcome, Effort, JudgedProperty, Maker, Overrides, Repeated, Settings, StrategyOutcome, TrialError,
};

/// The share of runs in which what a verdict promises to catch must be caught.
pub const CAUGHT: f64 = 0.99;

/// Where a bias is planted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// At every point, in proportion to its exact value.
    Mean,
    /// At the worst of the well-lit points alone.
    Point,
}

impl Subject {
    /// As tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Subject::Mean => "mean",
            Subject::Point => "point",
        }
    }
}

/// How a bias is planted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planted {
    /// Estimates times a factor: the spread grows or shrinks with the value.
    Scaled,
    /// A constant on top of every estimate: the spread stays.
    Added,
}

impl Planted {
    /// As tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Planted::Scaled => "scaled",
            Planted::Added => "added",
        }
    }
}

/// One study in which biases were planted. Biases are relative to the exact value.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerRow {
    pub case: String,
    pub strategy: &'static str,
    pub subject: Subject,
    pub planted: Planted,
    /// The only N of the study.
    pub samples: u64,
    pub replicates: u64,
    /// Standard error of what the bias is planted in.
    pub std_error: f64,
    /// What the verdicts promised to catch with probability 99 %: the median over the runs.
    pub predicted: f64,
    /// What 99 of 100 runs caught, with 95 % limits. `None`: not found below twice the promise, or (upper limit) too few
    /// runs to tell.
    pub measured: Option<f64>,
    pub measured_low: Option<f64>,
    pub measured_high: Option<f64>,
    /// What a normal test of this one mean alone would catch with 99 % at the same level: 7.22 standard errors.
    pub normal: f64,
    pub runs: u64,
    /// Runs that caught what their own verdict had promised; share and 95 % limits.
    pub caught: u64,
    pub share: f64,
    pub low: f64,
    pub high: f64,
    /// Pass: nothing speaks against 99 %. Fail: the share's one-sided 99.9 % limit is below.
    pub verdict: Verdict,
}

/// Room, strategy, N, subject, how.
const STUDIES: &[(&str, Strategy, u64, Subject, Planted)] = &[
    ("one lit point", Strategy::Random, 1, Subject::Mean, Planted::Scaled),
    ("one lit point", Strategy::Stratified, 16, Subject::Mean, Planted::Scaled),
    ("tilted rectangle", Strategy::Correlated, 4, Subject::Mean, Planted::Scaled),
    ("two sources", Strategy::Random, 4, Subject::Mean, Planted::Scaled),
    ("sphere behind sphere", Strategy::Random, 16, Subject::Mean, Planted::Scaled),
    ("umbra to light", Strategy::Random, 1, Subject::Mean, Planted::Scaled),
    ("umbra to light", Strategy::Stratified, 16, Subject::Point, Planted::Scaled),
    ("half-plane", Strategy::Random, 1, Subject::Point, Planted::Scaled),
    ("half-plane", Strategy::Random, 1, Subject::Point, Planted::Added),
    ("antumbra", Strategy::Correlated, 16, Subject::Point, Planted::Scaled),
];
/// Replicates of each.
const REPLICATES: u64 = 1024;
/// The verdict turns between these parts of what it promised.
const BRACKET: (f64, f64) = (0.4, 2.0);
/// Halvings of the bracket: to 1.3 % of the promise.
const HALVINGS: u32 = 7;

/// Runs in all.
pub(super) fn runs(each: u64) -> u64 {
    STUDIES.len() as u64 * each
}

/// All studies, `each` runs for each.
pub(super) fn measure(
    rooms: &[Room],
    seed: u64,
    each: u64,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Vec<PowerRow>, TrialError> {
    STUDIES
        .iter()
        .map(|(name, strategy, samples, subject, planted)| {
            let room = rooms.iter().find(|room| room.case.name == *name).expect("a room of that name");
            let study = Plan {
                case: &room.case,
                strategy: *strategy,
                samples: *samples,
                subject: *subject,
                planted: *planted,
            };
            study.measure(seed, each, progress)
        })
        .collect()
}

struct Plan<'a> {
    case: &'a Case,
    strategy: Strategy,
    samples: u64,
    subject: Subject,
    planted: Planted,
}

/// What one seed showed.
struct Found {
    predicted: f64,
    squared_error: f64,
    /// The smallest bias caught; infinite beyond the bracket.
    turns: f64,
}

impl Plan<'_> {
    fn measure(&self, seed: u64, runs: u64, progress: &(dyn Fn(Progress) + Sync)) -> Result<PowerRow, TrialError> {
        let repeated = self.repeated();
        let found: Vec<Found> = (0..runs)
            .into_par_iter()
            .map(|run| {
                let found = self.one(&repeated, seed, run);
                progress(Progress::Done(1));
                found
            })
            .collect::<Result<_, _>>()?;
        let n = runs as f64;
        let std_error = (found.iter().map(|found| found.squared_error).sum::<f64>() / n).sqrt();
        let mut predicted: Vec<f64> = found.iter().map(|found| found.predicted).collect();
        predicted.sort_by(f64::total_cmp);
        let mut turns: Vec<f64> = found.iter().map(|found| found.turns).collect();
        turns.sort_by(f64::total_cmp);
        let (low, high) = around_quantile(runs, CAUGHT, 0.95);
        let at =
            |rank: Option<u64>| rank.and_then(|rank| turns.get(rank as usize)).copied().filter(|t| t.is_finite());
        let caught = found.iter().filter(|found| found.turns <= found.predicted).count() as u64;
        let limits = clopper_pearson(caught as f64, n, 0.95);
        let is_refuted = upper_limit(caught as f64, n, 0.999).is_some_and(|limit| limit < CAUGHT);
        let z = |level: f64| normal_quantile(level).unwrap_or(f64::NAN);
        Ok(PowerRow {
            case: self.case.name.clone(),
            strategy: self.strategy.name(),
            subject: self.subject,
            planted: self.planted,
            samples: self.samples,
            replicates: REPLICATES,
            std_error,
            predicted: predicted.get(predicted.len() / 2).copied().unwrap_or(f64::NAN),
            measured: at(Some(((CAUGHT * n).ceil() as u64).max(1) - 1)),
            measured_low: at(low),
            measured_high: at(high),
            // Two-sided at α; and one tail of 1 %.
            normal: (z(1.0 - ALPHA) + z(2.0 * CAUGHT - 1.0)) * std_error,
            runs,
            caught,
            share: caught as f64 / n,
            low: limits.map_or(0.0, |limits| limits.low),
            high: limits.map_or(1.0, |limits| limits.high),
            verdict: if is_refuted { Verdict::Fail } else { Verdict::Pass },
        })
    }

    fn one(&self, repeated: &Repeated, seed: u64, run: u64) -> Result<Found, TrialError> {
        let name = format!(
            "calibration/power/{seed}/{}/{}/{}/{}/{}/{run}",
            self.case.name,
            self.strategy,
            self.samples,
            self.subject.name(),
            self.planted.name()
        );
        let seed = seed_of(&name);
        let unshifted = repeated.run(seed, &for_technique)?;
        let exact: Vec<f64> =
            unshifted.truths.iter().map(|truth| truth.irradiance.watts_per_square_metre()).collect();
        let (predicted, point, squared_error) = self.promise(&unshifted, &exact);
        // Half the runs are shifted down.
        let sign = if run.is_multiple_of(2) { 1.0 } else { -1.0 };
        let is_caught = |part: f64| -> Result<bool, TrialError> {
            let shift = sign * part * predicted;
            let shifts: Vec<(f64, f64)> = (0..exact.len())
                .map(|p| match self.planted {
                    _ if point.is_some_and(|point| point != p) => (1.0, 0.0),
                    Planted::Scaled => (1.0 + shift, 0.0),
                    Planted::Added => (1.0, shift * exact[p]),
                })
                .collect();
            let make: &Maker = &|configuration, technique| {
                Box::new(Shifted { inner: for_technique(configuration, technique), shifts: shifts.clone() })
            };
            let outcome = repeated.run(seed, make)?;
            Ok(bias(&outcome).is_some_and(|judged| judged.verdict == Verdict::Fail))
        };
        let (mut missed, mut caught) = BRACKET;
        if !is_caught(caught)? {
            return Ok(Found { predicted, squared_error, turns: f64::INFINITY });
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (missed + caught);
            if is_caught(middle)? { caught = middle } else { missed = middle }
        }
        Ok(Found { predicted, squared_error, turns: caught * predicted })
    }

    fn repeated(&self) -> Repeated<'_> {
        let overrides = Overrides {
            strategies: Some(vec![self.strategy]),
            samples: Some(vec![self.samples]),
            replicates: Some(Replicates::Fixed(REPLICATES)),
            ..Overrides::default()
        };
        Repeated::new(self.case, &Settings { seed: 0, effort: Effort::Standard, overrides })
    }

    /// What the verdict promises, where, and the squared relative standard error there.
    fn promise(&self, outcome: &CaseOutcome, exact: &[f64]) -> (f64, Option<usize>, f64) {
        let judged = bias(outcome);
        let cell = &outcome.strategies[0].cells[0];
        match self.subject {
            Subject::Mean => {
                let mean = exact.iter().sum::<f64>() / exact.len() as f64;
                let error = cell.mean_bias_std_error / mean;
                (judged.and_then(|judged| judged.smallest_bias_mean).unwrap_or(f64::NAN), None, error * error)
            }
            Subject::Point => {
                let error = |p: usize| cell.points[p].bias_std_error / exact[p];
                let well_lit = |p: &usize| {
                    let all = outcome.truths[*p].unoccluded_irradiance.watts_per_square_metre();
                    exact[*p] > 0.0 && exact[*p] >= 0.1 * all
                };
                let worst = (0..exact.len()).filter(well_lit).max_by(|a, b| error(*a).total_cmp(&error(*b)));
                let worst = worst.expect("a room for this has a well-lit point");
                let predicted = judged.and_then(|judged| judged.smallest_bias_point).unwrap_or(f64::NAN);
                (predicted, Some(worst), error(worst) * error(worst))
            }
        }
    }
}

fn bias(outcome: &CaseOutcome) -> Option<&JudgedProperty> {
    let StrategyOutcome { verdicts, .. } = &outcome.strategies[0];
    verdicts.iter().find(|judged| judged.property == "bias")
}

/// Ranks, from 0, of the order statistics that hold a quantile between them with probability `level` (each tail by
/// itself): exact, from the binomial distribution. `None` where the sample is too small for one.
fn around_quantile(n: u64, quantile: f64, level: f64) -> (Option<u64>, Option<u64>) {
    let tail = 0.5 * (1.0 - level);
    // The value of rank r (from 0) is below the quantile unless r or fewer are: P(r or fewer) small makes it a lower
    // limit's complement. Both follow from the limits of a share.
    let is_low = |r: &u64| upper_limit(*r as f64, n as f64, 1.0 - tail).is_some_and(|p| p < quantile);
    let is_high = |r: &u64| {
        crate::statistics::proportion::lower_limit((*r + 1) as f64, n as f64, 1.0 - tail)
            .is_some_and(|p| p > quantile)
    };
    ((0..n).rev().find(is_low), (0..n).find(is_high))
}

/// A correct estimator whose estimates are shifted on their way out.
struct Shifted {
    inner: Box<dyn Estimator>,
    /// For each point a factor, and what is added after it, W/m².
    shifts: Vec<(f64, f64)>,
}

impl Estimator for Shifted {
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        self.inner.rays_per_estimate(samples)
    }

    fn estimate(&self, job: &Job, scratch: &mut Scratch, estimates: &mut [f64]) {
        self.inner.estimate(job, scratch, estimates);
        let replicates = (job.replicates.end - job.replicates.start) as usize;
        for (row, (factor, more)) in estimates.chunks_exact_mut(replicates.max(1)).zip(&self.shifts) {
            row.iter_mut().for_each(|estimate| *estimate = factor * *estimate + more);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_around_a_quantile_are_those_of_the_tables() {
        // The median of ten: second to ninth of ten, 97.9 % (Conover, Practical Nonparametric Statistics, table A3).
        assert_eq!(around_quantile(10, 0.5, 0.95), (Some(1), Some(8)));
        // 0.975 of 300 runs: the 99 % quantile may lie beyond the largest; of 400 it does not.
        assert_eq!(around_quantile(300, 0.99, 0.95).1, None);
        assert_eq!(around_quantile(400, 0.99, 0.95), (Some(391), Some(399)));
    }

    #[test]
    fn what_is_promised_is_caught() {
        let rooms = super::super::rooms::rooms();
        let room = rooms.iter().find(|room| room.case.name == "one lit point").unwrap();
        let study = Plan {
            case: &room.case,
            strategy: Strategy::Random,
            samples: 4,
            subject: Subject::Mean,
            planted: Planted::Scaled,
        };
        let row = study.measure(7, 8, &|_| ()).unwrap();
        // With 99 % each, three misses in eight have a chance below 1e-4; two below 3e-3.
        assert!(row.caught >= 6, "{row:?}");
        assert!(row.normal < row.predicted && row.predicted < 1.5 * row.normal, "{row:?}");
        let again = study.measure(7, 8, &|_| ()).unwrap();
        assert_eq!(row, again, "threads move nothing");
    }
}
