//! Runs a study over cases: exact values, pilot, plan, measurement, judgement.

use std::collections::BTreeMap;
use std::time::Instant;

use thiserror::Error;

use super::accept::accept;
use super::correlation::correlations;
use super::indirect::indirect;
use super::judge::{self, Judged};
use super::light::light;
use super::measure::{CellSums, Prepared, measure};
use super::mesh_rays::compare_hierarchies;
use super::outcome::{CaseOutcome, RunOutcome, StrategyOutcome, Timing};
use super::plan::{CellPlan, pilot_replicates};
use super::rates::rates;
use super::ready::{Maker, Ready};
use super::settings::{Effort, Settings};
use super::shown::{efficiency, shown};
use super::spread;
use crate::case::{Case, Study};
use crate::estimator::{Estimator, for_technique};
use crate::geometry::DVec3;
use crate::sampling::{Purpose, Strategy, Technique};
use crate::threads;

/// What a run tells while it goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress<'a> {
    /// A case begins; its name. Several may be under way at a time.
    Begun(&'a str),
    /// A cell of a case was planned to cost this many more shadow rays.
    Planned { case: &'a str, rays: u64 },
    /// This many shadow rays of a case were traced.
    Traced { case: &'a str, rays: u64 },
    /// A case is done.
    Done(&'a str),
}

/// Why a run ended without an outcome.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrialError {
    /// A hierarchy and brute force disagreed on a shadow ray: a fault of this program.
    #[error("{case}: the hierarchy over mesh {mesh} and brute force disagree on a shadow ray from {from} to {to}")]
    HierarchyDisagrees { case: String, mesh: usize, from: DVec3, to: DVec3 },
    /// The shadow cache changed what is blocked: a fault of this program.
    #[error("{case}: mesh {mesh} blocks other shadow rays from point {point} with its cache than without")]
    CacheDisagrees { case: String, mesh: usize, point: usize },
    /// What the silhouette tells is not what rays tell: a fault of this program.
    #[error("{case}: mesh {mesh} blocks other shadow rays from point {point} by its silhouette than ray by ray")]
    SilhouetteDisagrees { case: String, mesh: usize, point: usize },
    /// The system gives no thread to work on.
    #[error("the system gives no thread to work on")]
    NoThread,
}

/// Measures and judges every case with the built-in estimators.
pub fn run(
    cases: &[Case],
    settings: &Settings,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<RunOutcome, TrialError> {
    run_with(cases, settings, &for_technique, progress)
}

/// Measures and judges every case with estimators of any make.
pub fn run_with(
    cases: &[Case],
    settings: &Settings,
    make: &Maker,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<RunOutcome, TrialError> {
    let selectors: Vec<&str> = cases.iter().map(|case| case.selector.as_str()).collect();
    let outcomes = threads::side_by_side(cases, |case| {
        progress(Progress::Begun(&case.name));
        let outcome = run_case(case, settings, make, progress);
        progress(Progress::Done(&case.name));
        outcome
    });
    let cases = outcomes.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok(RunOutcome { seed: settings.seed, command: settings.command(&selectors, None), cases })
}

fn run_case(
    case: &Case,
    settings: &Settings,
    make: &Maker,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<CaseOutcome, TrialError> {
    let study = settings.study(&case.study);
    let mut outcome = if case.measures_direct_light() {
        // First, while nothing else holds a mesh's hierarchy: two at a time would be the most memory that a run takes.
        let meshes = compare_hierarchies(case, settings.seed)?;
        from_ready(&Ready::new(case, &study, make), &study, settings, None, meshes, progress)
    } else {
        unmeasured(case)
    };
    let reproduce = settings.command(&[&case.selector], None);
    let quick = settings.effort == Effort::Quick;
    outcome.light = light(case, settings.seed, quick, study.smallest_bias, &reproduce);
    outcome.paths = indirect(case, settings.seed, quick, study.smallest_bias, &reproduce);
    Ok(outcome)
}

/// A case in which no light comes straight from a surface to a point: lamps alone, or nothing to measure.
pub(super) fn unmeasured(case: &Case) -> CaseOutcome {
    CaseOutcome {
        name: case.name.clone(),
        title: case.title.clone(),
        digest: case.configuration.digest(),
        arrangement: case.configuration.arrangement(),
        figures: case.configuration.figures(),
        albedos: case.configuration.albedos(),
        points: Vec::new(),
        truths: Vec::new(),
        strategies: Vec::new(),
        light: None,
        paths: None,
        timings: Vec::new(),
    }
}

/// Measures and judges a case that was made ready for this study.
///
/// - `estimators`: instead of those that the case was made ready with, one for each technique
/// - `meshes`: what [`compare_hierarchies`] found
pub(super) fn from_ready(
    ready: &Ready,
    study: &Study,
    settings: &Settings,
    estimators: Option<&BTreeMap<Technique, Box<dyn Estimator>>>,
    meshes: Vec<Timing>,
    progress: &(dyn Fn(Progress) + Sync),
) -> CaseOutcome {
    let case = ready.case;
    let strategies = study
        .strategies
        .iter()
        .map(|strategy| {
            let mut prepared = ready.prepared(settings.seed, *strategy);
            if let Some(estimators) = estimators {
                prepared.estimator = &*estimators[&strategy.technique()];
            }
            let reproduce = settings.command(&[&case.selector], Some(*strategy));
            run_strategy(&prepared, study, *strategy, reproduce, progress)
        })
        .collect();
    ready.outcome(strategies, meshes)
}

/// Shadow rays of a cell.
pub(super) fn rays_of(prepared: &Prepared, samples: u64, replicates: u64) -> u64 {
    prepared.estimator.rays_per_estimate(samples) * prepared.exact.len() as u64 * replicates
}

/// The plans of all cells, and what pilots cost.
pub(super) struct Plans {
    pub cells: Vec<CellPlan>,
    pub pilot_rays: u64,
    pub pilot_seconds: f64,
}

/// Plans every cell, by prediction where there is one and by a pilot elsewhere.
pub(super) fn plans(
    prepared: &Prepared,
    study: &Study,
    strategy: Strategy,
    progress: &(dyn Fn(Progress) + Sync),
) -> Plans {
    let case = prepared.case.name.as_str();
    let traced = |rays: u64| progress(Progress::Traced { case, rays });
    let mut plans = Plans { cells: Vec::new(), pilot_rays: 0, pilot_seconds: 0.0 };
    for (index, samples) in study.samples.iter().enumerate() {
        let prediction = prepared.predictions.cell(strategy, study, index, &prepared.contrasts.weights);
        if prediction.is_complete() {
            plans.cells.push(CellPlan::new(prepared, study, strategy.technique(), *samples, prediction, None));
            continue;
        }
        let replicates = pilot_replicates(*samples);
        let rays = rays_of(prepared, *samples, replicates);
        progress(Progress::Planned { case, rays });
        let pilot = measure(prepared, Purpose::Pilot, strategy, *samples, replicates, &traced);
        plans.pilot_rays += rays;
        plans.pilot_seconds += pilot.seconds;
        plans.cells.push(CellPlan::new(prepared, study, strategy.technique(), *samples, prediction, Some(&pilot)));
    }
    plans
}

fn run_strategy(
    prepared: &Prepared,
    study: &Study,
    strategy: Strategy,
    reproduce: String,
    progress: &(dyn Fn(Progress) + Sync),
) -> StrategyOutcome {
    let case = prepared.case.name.as_str();
    let traced = |rays: u64| progress(Progress::Traced { case, rays });
    let Plans { cells: plans, pilot_rays, pilot_seconds } = plans(prepared, study, strategy, progress);
    for plan in &plans {
        progress(Progress::Planned { case, rays: rays_of(prepared, plan.samples, plan.replicates) });
    }
    let cells: Vec<CellSums> = plans
        .iter()
        .map(|plan| measure(prepared, Purpose::Measurement, strategy, plan.samples, plan.replicates, &traced))
        .collect();
    let rays = plans.iter().map(|plan| rays_of(prepared, plan.samples, plan.replicates)).sum();
    let pilot = Timing { stage: "pilot", rays: pilot_rays, seconds: pilot_seconds, efficiency: None };
    let mut timings: Vec<Timing> = (pilot_rays > 0)
        .then_some(pilot)
        .into_iter()
        .chain([Timing {
            stage: "measure",
            rays,
            seconds: cells.iter().map(|cell| cell.seconds).sum(),
            efficiency: cells.last().and_then(|cell| efficiency(cell, prepared.exact.len())),
        }])
        .collect();
    let start = Instant::now();
    let mut verdicts =
        vec![judge::bias(prepared, study, Judged::strategy(strategy, study, reproduce.clone()), &cells, &plans)];
    verdicts.extend(spread::variance(prepared, study, strategy, &cells, &plans, &reproduce));
    verdicts.extend(spread::covariance(prepared, study, strategy, &cells, &plans, &reproduce));
    accept(&mut verdicts, Some(strategy), &study.accepted);
    timings.push(Timing {
        stage: "judge",
        rays: plans.iter().map(|plan| plan.replicates * prepared.exact.len() as u64).sum(),
        seconds: start.elapsed().as_secs_f64(),
        efficiency: None,
    });
    StrategyOutcome {
        strategy,
        guest: None,
        rates: rates(prepared, strategy, &cells, &plans),
        correlations: correlations(prepared, strategy, &cells, &plans),
        verdicts,
        cells: cells.iter().zip(&plans).map(|(cell, plan)| shown(cell, plan)).collect(),
        timings,
    }
}
