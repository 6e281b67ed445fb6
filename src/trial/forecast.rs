//! What a run would cost and could see, before anything is spent on it.

use super::measure::measure;
use super::ready::Ready;
use super::run::{plans, rays_of};
use super::settings::Settings;
use crate::case::Case;
use crate::estimator::for_technique;
use crate::sampling::{Purpose, Strategy};

/// Shadow rays that one cell is timed by.
const TIMED_RAYS: u64 = 50_000;

/// One case under one strategy, as planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    pub case: String,
    pub strategy: Strategy,
    /// (samples, replicates) of each cell, ascending.
    pub cells: Vec<(u64, u64)>,
    /// Shadow rays in all.
    pub rays: u64,
    /// CPU seconds, from a short trial of each cell on this machine.
    pub seconds: f64,
    /// Relative biases that would be caught with 99 % probability: in the mean, and at the worst point that a tenth of the
    /// light reaches; `None` where no light is due.
    pub smallest_bias_mean: Option<f64>,
    pub smallest_bias_point: Option<f64>,
    /// Whether these are as small as the study asks.
    pub suffices: bool,
    /// Whether the exact side predicts all variances; else a pilot run stands in.
    pub predicted: bool,
}

/// Plans every case, and times it.
pub fn forecast(cases: &[Case], settings: &Settings) -> Vec<Forecast> {
    let mut forecasts = Vec::new();
    for case in cases.iter().filter(|case| case.measures_direct_light()) {
        let study = settings.study(&case.study);
        let ready = Ready::new(case, &study, &for_technique);
        for strategy in &study.strategies {
            let prepared = ready.prepared(settings.seed, *strategy);
            let plans = plans(&prepared, &study, *strategy, &|_| {});
            let (mut rays, mut seconds) = (plans.pilot_rays, plans.pilot_seconds);
            for plan in &plans.cells {
                let once = rays_of(&prepared, plan.samples, 1);
                let replicates = (TIMED_RAYS / once).clamp(1, plan.replicates);
                let trial = measure(&prepared, Purpose::Pilot, *strategy, plan.samples, replicates, &|_| {});
                rays += once * plan.replicates;
                seconds += trial.seconds * plan.replicates as f64 / replicates as f64;
            }
            let biases: Vec<_> = plans.cells.iter().map(|plan| plan.smallest_biases(&prepared, &study)).collect();
            let mean = biases.iter().filter_map(|biases| biases.mean).reduce(f64::max);
            let point = biases.iter().filter_map(|biases| biases.point).reduce(f64::max);
            let within = |found: Option<f64>, asked: f64| found.is_none_or(|found| found <= asked * (1.0 + 1e-9));
            forecasts.push(Forecast {
                case: case.name.clone(),
                strategy: *strategy,
                cells: plans.cells.iter().map(|plan| (plan.samples, plan.replicates)).collect(),
                rays,
                seconds,
                smallest_bias_mean: mean,
                smallest_bias_point: point,
                suffices: within(mean, study.smallest_bias.mean) && within(point, study.smallest_bias.point),
                predicted: plans.pilot_rays == 0,
            });
        }
    }
    forecasts
}
