//! What a run would cost and could see, before anything is spent on it.

use super::cost::median;
use super::desk::Alone;
use super::measure::{BATCHES, Prepared, rays_of, replicates_at_once, seconds_of};
use super::outcome::Timing;
use super::plan::{CellPlan, FEWEST_REPLICATES, pilot_replicates};
use super::ready::Ready;
use super::run::plans;
use super::settings::Settings;
use crate::case::{Case, Replicates};
use crate::estimator::for_technique;
use crate::sampling::{BLOCK, PointSet, Purpose, Strategy, Technique};
use crate::threads;

/// Shadow rays of one timing, about: some tenths of a millisecond.
const TIMED_RAYS: u64 = 50_000;
/// Timings of a cell, beside one that warms up.
const TIMINGS: u64 = 5;
/// Shadow rays from which on fewer timings do: what takes long is disturbed less.
const MANY_RAYS: u64 = 1_000_000;
/// Shadow rays of the longest timing, about: a tenth of a second.
const MOST_TIMED_RAYS: u64 = 1 << 24;

/// One case under one strategy, as planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    pub case: String,
    pub strategy: Strategy,
    /// (samples, replicates) of each cell, ascending.
    pub cells: Vec<(u64, u64)>,
    /// Shadow rays in all.
    pub rays: u64,
    /// Processor seconds of the stages `pilot` and `measure`, from short trials of each cell on this machine.
    pub seconds: f64,
    /// Relative biases that would be caught with 99 % probability: in the mean, and at the worst point that a tenth of the
    /// light reaches; `None` where no light is due.
    pub smallest_bias_mean: Option<f64>,
    pub smallest_bias_point: Option<f64>,
    /// Whether these are as small as the study asks.
    pub suffices: bool,
    /// Whether the exact side predicts all variances (those of very many strata it bounds); else a pilot run stands in.
    pub predicted: bool,
}

/// A cell and the processor seconds that it should take.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellCost {
    pub strategy: Strategy,
    pub samples: u64,
    pub rays: u64,
    pub seconds: f64,
}

/// Plans every case, and times it.
pub fn forecast(cases: &[Case], settings: &Settings) -> Vec<Forecast> {
    cases.iter().flat_map(|case| forecast_case(case, settings).0).collect()
}

/// One case, with the cost of each cell (its pilot included), and of the exact side.
pub(super) fn forecast_case(case: &Case, settings: &Settings) -> (Vec<Forecast>, Vec<CellCost>, f64) {
    if !case.measures_direct_light() {
        return (Vec::new(), Vec::new(), 0.0);
    }
    let study = settings.study(&case.study);
    let ready = Ready::new(case, &study, &for_technique);
    // Predictions are found on all threads.
    let threads = rayon::current_num_threads() as f64;
    let seconds_of = |timing: &Timing| timing.seconds * if timing.stage == "predict" { threads } else { 1.0 };
    let exact_seconds = ready.timings.iter().map(seconds_of).sum();
    let (mut forecasts, mut costs) = (Vec::new(), Vec::new());
    for strategy in &study.strategies {
        let prepared = ready.prepared(settings.seed, *strategy);
        let Ok(plans) = plans(&prepared, &study, *strategy, &Alone);
        let cells: Vec<CellPlan> = plans.cells.into_iter().flatten().collect();
        let of_pilot = plans.pilot_seconds / cells.len().max(1) as f64;
        let (mut rays, mut seconds) = (plans.pilot_rays, plans.pilot_seconds);
        for plan in &cells {
            let of_cell = CellCost {
                strategy: *strategy,
                samples: plan.samples,
                rays: rays_of(&prepared, plan.samples, plan.replicates),
                seconds: seconds_of_cell(&prepared, *strategy, plan),
            };
            rays += of_cell.rays;
            seconds += of_cell.seconds;
            costs.push(CellCost { seconds: of_cell.seconds + of_pilot, ..of_cell });
        }
        let biases: Vec<_> = cells.iter().map(|plan| plan.smallest_biases(&prepared, &study)).collect();
        let mean = biases.iter().filter_map(|biases| biases.mean).reduce(f64::max);
        let point = biases.iter().filter_map(|biases| biases.point).reduce(f64::max);
        let within = |found: Option<f64>, asked: f64| found.is_none_or(|found| found <= asked * (1.0 + 1e-9));
        forecasts.push(Forecast {
            case: case.name.clone(),
            strategy: *strategy,
            cells: cells.iter().map(|plan| (plan.samples, plan.replicates)).collect(),
            rays,
            seconds,
            smallest_bias_mean: mean,
            smallest_bias_point: point,
            suffices: within(mean, study.smallest_bias.mean) && within(point, study.smallest_bias.point),
            predicted: plans.pilot_rays == 0,
        });
    }
    (forecasts, costs, exact_seconds)
}

/// Shadow rays that a run of one case takes at least: what its points, strategies, samples and replicates come to, before
/// any variance is known.
pub fn least_rays(case: &Case, settings: &Settings) -> f64 {
    if !case.measures_direct_light() {
        return 0.0;
    }
    let study = settings.study(&case.study);
    let replicates = match study.replicates {
        Replicates::Fixed(replicates) => replicates,
        Replicates::Auto => FEWEST_REPLICATES,
    };
    let configuration = &case.configuration;
    let places = configuration.points().len() as f64 * configuration.sources().len() as f64;
    let of = |strategy: &Strategy| {
        let is_piloted = strategy.technique() == Technique::Area
            && !matches!(strategy.point_set(), PointSet::Independent | PointSet::Stratified);
        let pilots = |samples: u64| if is_piloted { pilot_replicates(samples) } else { 0 };
        let samples = study.samples.iter();
        samples.map(|n| *n as f64 * (replicates + pilots(*n)) as f64).sum::<f64>()
    };
    places * study.strategies.iter().map(of).sum::<f64>()
}

/// What a cell will take: the median of several timings, scaled to all its replicates.
fn seconds_of_cell(prepared: &Prepared, strategy: Strategy, plan: &CellPlan) -> f64 {
    // What takes seconds by itself is timed with fewer samples: of so many, each takes the same time.
    let mut samples = plan.samples;
    while rays_of(prepared, samples, 1) > MOST_TIMED_RAYS && samples > MOST_TIMED_RAYS / 1024 {
        samples /= 4;
    }
    let (plan, more) = (&CellPlan { samples, ..plan.clone() }, plan.samples as f64 / samples as f64);
    let once = rays_of(prepared, plan.samples, 1);
    let count = timed_replicates(plan, once, prepared.exact.len());
    let timings = if once * count > MANY_RAYS { 2 } else { TIMINGS };
    // On all threads at once, as in the run: they share the machine's caches and its power. Each timing has streams of its
    // own, so that no branch is learned by heart.
    let n_threads = rayon::current_num_threads() as u64;
    let rounds = timings.div_ceil(n_threads);
    let starts: Vec<u64> = (0..n_threads).collect();
    let of_threads = threads::map(&starts, |thread| {
        let first = thread * (rounds + 1) * count;
        let time = |round: u64| {
            let start = first + round * count;
            let replicates = start..start + count;
            seconds_of(prepared, Purpose::Pilot, strategy, plan.samples, replicates) / count as f64
        };
        // The first fills caches and tables.
        (0..=rounds).map(time).skip(1).collect::<Vec<f64>>()
    });
    more * scaled(of_threads.concat(), plan.replicates)
}

/// The median of times of one replicate, for so many.
fn scaled(of_one: Vec<f64>, replicates: u64) -> f64 {
    median(of_one).unwrap_or(0.0) * replicates as f64
}

/// Replicates that one timing takes: no more than a unit of the run has, and where samples are few in the portions in which
/// the run works on them, since they fill its registers only together.
fn timed_replicates(plan: &CellPlan, rays_of_one: u64, n_points: usize) -> u64 {
    let enough = (TIMED_RAYS / rays_of_one.max(1)).max(1);
    let portion = if plan.samples < BLOCK as u64 { replicates_at_once(n_points) } else { 1 };
    enough.next_multiple_of(portion).min(plan.replicates.div_ceil(BATCHES)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::predict::CellPrediction;

    fn plan(samples: u64, replicates: u64) -> CellPlan {
        CellPlan {
            samples,
            replicates,
            point_variances: Vec::new(),
            contrast_variances: Vec::new(),
            prediction: CellPrediction { points: Vec::new(), alike: Vec::new(), contrasts: None },
        }
    }

    #[test]
    fn a_disturbed_timing_moves_no_forecast() {
        assert_eq!(scaled(vec![2e-6, 2.1e-6, 9e-4, 1.9e-6, 2e-6], 1000), 2e-6 * 1000.0);
        assert_eq!(scaled(vec![], 1000), 0.0);
    }

    #[test]
    fn timings_are_worked_on_as_the_run_works() {
        // One sample at 65 points: a unit has 512 replicates, of which the run takes 256 at once.
        assert_eq!(timed_replicates(&plan(1, 16_384), 65, 65), 512);
        // A unit of the run is smaller than what a timing would like.
        assert_eq!(timed_replicates(&plan(1, 128), 1, 1), 4);
        // Many samples at many points: one replicate is long enough.
        assert_eq!(timed_replicates(&plan(1024, 128), 1024 * 600, 600), 1);
        assert_eq!(timed_replicates(&plan(1024, 1 << 20), 1024, 1), 48);
        // Never none.
        assert_eq!(timed_replicates(&plan(4, 2), 0, 1), 1);
    }
}
