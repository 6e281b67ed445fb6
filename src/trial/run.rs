//! Runs a study over cases: exact values, pilot, plan, measurement, judgement.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

use thiserror::Error;

use super::accept::accept;
use super::correlation::correlations;
use super::indirect::indirect;
use super::judge::{self, Judged};
use super::light::light;
use super::measure::{CellSums, Prepared, measure};
use super::mesh_rays::compare_hierarchies;
use super::onlooker::{Onlooker, Progress, Stopped, Tell};
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
    /// Whoever looked on wanted no more of a case.
    #[error("stopped")]
    Stopped,
}

impl From<Stopped> for TrialError {
    fn from(_: Stopped) -> TrialError {
        TrialError::Stopped
    }
}

/// Measures and judges every case with the built-in estimators.
pub fn run(
    cases: &[Case],
    settings: &Settings,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<RunOutcome, TrialError> {
    run_with(cases, settings, &for_technique, progress)
}

/// The same as long as the onlooker wants it: once it breaks, no case is begun, those under way are given up between two
/// units of work, and the outcome has the cases that were finished before.
pub fn run_while(cases: &[Case], settings: &Settings, tell: &Tell) -> Result<RunOutcome, TrialError> {
    run_all(cases, settings, &for_technique, tell)
}

/// Measures and judges every case with estimators of any make.
pub fn run_with(
    cases: &[Case],
    settings: &Settings,
    make: &Maker,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<RunOutcome, TrialError> {
    run_all(cases, settings, make, &|told| {
        progress(told);
        ControlFlow::Continue(())
    })
}

fn run_all(cases: &[Case], settings: &Settings, make: &Maker, tell: &Tell) -> Result<RunOutcome, TrialError> {
    let selectors: Vec<&str> = cases.iter().map(|case| case.selector.as_str()).collect();
    let places: Vec<usize> = (0..cases.len()).collect();
    let outcomes = threads::side_by_side(&places, |index| {
        let case = &cases[*index];
        if tell(Progress::Begun(&case.name)).is_break() {
            return Err(TrialError::Stopped);
        }
        let outcome = run_case(case, settings, make, tell)?;
        // Whoever breaks here is heard by the next case: this one is whole.
        let _ = tell(Progress::Done { index: *index, outcome: &outcome });
        Ok(outcome)
    });
    let mut whole = RunOutcome::new(settings.seed, settings.command(&selectors, None));
    for (case, outcome) in cases.iter().zip(outcomes) {
        match outcome {
            Ok(outcome) => whole.cases.push(outcome),
            Err(TrialError::Stopped) => whole.missing.push(case.name.clone()),
            Err(error) => return Err(error),
        }
    }
    Ok(whole)
}

fn run_case(case: &Case, settings: &Settings, make: &Maker, tell: &Tell) -> Result<CaseOutcome, TrialError> {
    let study = settings.study(&case.study);
    let onlooker = Onlooker::new(&case.name, tell);
    let mut outcome = if case.measures_direct_light() {
        // First, while nothing else holds a mesh's hierarchy: two at a time would be the most memory that a run takes.
        let meshes = compare_hierarchies(case, settings.seed)?;
        let ready = Ready::new_while(case, &study, make, &|| onlooker.goes_on())?;
        from_ready(&ready, &study, settings, None, meshes, &onlooker)?
    } else {
        unmeasured(case)
    };
    let reproduce = settings.command(&[&case.selector], None);
    let quick = settings.effort == Effort::Quick;
    outcome.light = light(case, settings.seed, quick, study.smallest_bias, &reproduce, &onlooker)?;
    outcome.paths = indirect(case, settings.seed, quick, study.smallest_bias, &reproduce, &onlooker)?;
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
    onlooker: &Onlooker,
) -> Result<CaseOutcome, Stopped> {
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
            run_strategy(&prepared, study, *strategy, reproduce, onlooker)
        })
        .collect::<Result<_, Stopped>>()?;
    Ok(ready.outcome(strategies, meshes))
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
///
/// - `planned`, `traced`: told the rays of pilots; where they err, all is given up
pub(super) fn plans<E: Send + Sync>(
    prepared: &Prepared,
    study: &Study,
    strategy: Strategy,
    planned: &dyn Fn(u64) -> Result<(), E>,
    traced: &(dyn Fn(u64) -> Result<(), E> + Sync),
) -> Result<Plans, E> {
    let mut plans = Plans { cells: Vec::new(), pilot_rays: 0, pilot_seconds: 0.0 };
    for (index, samples) in study.samples.iter().enumerate() {
        let prediction = prepared.predictions.cell(strategy, study, index, &prepared.contrasts.weights);
        if prediction.is_complete() {
            plans.cells.push(CellPlan::new(prepared, study, *samples, prediction, None));
            continue;
        }
        if let Some(bounds) = prepared.predictions.at_most(strategy, *samples, &prepared.contrasts.weights) {
            plans.cells.push(CellPlan::new(prepared, study, *samples, prediction, Some(bounds)));
            continue;
        }
        let replicates = pilot_replicates(*samples);
        let rays = rays_of(prepared, *samples, replicates);
        planned(rays)?;
        let pilot = measure(prepared, Purpose::Pilot, strategy, *samples, replicates, traced)?;
        plans.pilot_rays += rays;
        plans.pilot_seconds += pilot.seconds;
        let measured = CellPlan::piloted(prepared, strategy.technique(), &pilot);
        plans.cells.push(CellPlan::new(prepared, study, *samples, prediction, Some(measured)));
    }
    Ok(plans)
}

fn run_strategy(
    prepared: &Prepared,
    study: &Study,
    strategy: Strategy,
    reproduce: String,
    onlooker: &Onlooker,
) -> Result<StrategyOutcome, Stopped> {
    let (planned, traced) = (|rays| onlooker.planned(rays), |rays| onlooker.traced(rays));
    let Plans { cells: plans, pilot_rays, pilot_seconds } = plans(prepared, study, strategy, &planned, &traced)?;
    for plan in &plans {
        onlooker.planned(rays_of(prepared, plan.samples, plan.replicates))?;
    }
    let cells: Vec<CellSums> = plans
        .iter()
        .map(|plan| measure(prepared, Purpose::Measurement, strategy, plan.samples, plan.replicates, &traced))
        .collect::<Result<_, Stopped>>()?;
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
    Ok(StrategyOutcome {
        strategy,
        guest: None,
        rates: rates(prepared, strategy, &cells, &plans),
        correlations: correlations(prepared, strategy, &cells, &plans),
        verdicts,
        cells: cells.iter().zip(&plans).map(|(cell, plan)| shown(cell, plan)).collect(),
        timings,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

    use super::*;
    use crate::case::Replicates;
    use crate::trial::Overrides;

    /// Two cases on one thread, one after the other, as long as the onlooker wants it.
    fn two(replicates: u64, tell: &Tell) -> RunOutcome {
        let cases = ["penumbra/eclipse", "penumbra/half-plane"].map(|name| Case::shipped(name).unwrap());
        let overrides = Overrides {
            samples: Some(vec![4]),
            replicates: Some(Replicates::Fixed(replicates)),
            ..Overrides::default()
        };
        let settings = Settings { seed: 1, effort: Effort::Standard, overrides };
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        alone.install(|| run_while(&cases, &settings, tell)).unwrap()
    }

    fn names(outcome: &RunOutcome) -> Vec<&str> {
        outcome.cases.iter().map(|case| case.name.as_str()).collect()
    }

    #[test]
    fn a_run_that_is_ended_has_the_cases_that_were_finished() {
        let whole = two(64, &|_| ControlFlow::Continue(()));
        assert_eq!(names(&whole), ["penumbra/eclipse", "penumbra/half-plane"]);
        assert!(whole.missing.is_empty());
        let done = AtomicBool::new(false);
        let cut = two(64, &|told| {
            done.fetch_or(matches!(told, Progress::Done { .. }), Ordering::Relaxed);
            if done.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(
            (names(&cut), &cut.missing[..]),
            (vec!["penumbra/eclipse"], &["penumbra/half-plane".to_owned()][..])
        );
        assert!(cut.cases[0].verdicts().eq(whole.cases[0].verdicts()), "what is finished is what it would have been");
    }

    #[test]
    fn a_case_is_given_up_between_two_units_of_work() {
        // Years, were it not given up.
        let traced = AtomicU64::new(0);
        let cut = two(1 << 50, &|told| {
            if let Progress::Traced { rays: 1.., .. } = told {
                traced.fetch_add(1, Ordering::Relaxed);
            }
            if traced.load(Ordering::Relaxed) > 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!((names(&cut).len(), cut.missing.len()), (0, 2));
        assert_eq!(traced.load(Ordering::Relaxed), 3, "nothing more was done");
    }
}
