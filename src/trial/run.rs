//! Runs a study over cases: exact values, pilot, plan, measurement, judgement.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::accept::accept;
use super::correlation::correlations;
use super::desk::{Desk, Stage};
use super::indirect::indirect;
use super::judge::{self, Judged};
use super::keeper::Keeper;
use super::light::light;
use super::measure::{CellSums, Prepared, measure_unit, rays_of};
use super::mesh_rays::compare_hierarchies;
use super::onlooker::{Onlooker, Progress, Stopped, Tell};
use super::outcome::{CaseOutcome, Correlation, RunOutcome, StrategyOutcome, Timing};
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
    Run { cases, settings, make: &for_technique, keeper: None, tell }.outcome()
}

/// The same where somebody keeps the results of units: what was kept before is not made again, and what is made is kept.
/// The outcome is the same, bit for bit, but for times.
pub fn run_kept(
    cases: &[Case],
    settings: &Settings,
    keeper: &dyn Keeper,
    tell: &Tell,
) -> Result<RunOutcome, TrialError> {
    let run = Run { cases, settings, make: &for_technique, keeper: Some(keeper), tell };
    run.outcome()
}

/// Makes, of all units of a run, those that are the keeper's share, and judges nothing.
///
/// - returns whether all of them were made, rather than given up
pub fn run_share(cases: &[Case], settings: &Settings, keeper: &dyn Keeper, tell: &Tell) -> Result<bool, TrialError> {
    let run = Run { cases, settings, make: &for_technique, keeper: Some(keeper), tell };
    let mut all = true;
    for part in run.each(|index| {
        let done = run.case(index)?;
        if done.is_none() {
            // Heard by the next case.
            let _ = tell(Progress::Shared(&cases[index].name));
        }
        Ok(())
    }) {
        match part {
            Ok(()) => {}
            Err(TrialError::Stopped) => all = false,
            Err(error) => return Err(error),
        }
    }
    Ok(all)
}

/// Measures and judges every case with estimators of any make.
pub fn run_with(
    cases: &[Case],
    settings: &Settings,
    make: &Maker,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<RunOutcome, TrialError> {
    let tell = |told: Progress| {
        progress(told);
        ControlFlow::Continue(())
    };
    Run { cases, settings, make, keeper: None, tell: &tell }.outcome()
}

/// All that a run goes by.
struct Run<'a> {
    cases: &'a [Case],
    settings: &'a Settings,
    make: &'a Maker<'a>,
    keeper: Option<&'a dyn Keeper>,
    tell: &'a Tell<'a>,
}

impl Run<'_> {
    /// Something of every case, several at a time, in their order.
    fn each<T: Send + Sync>(&self, of: impl Fn(usize) -> Result<T, TrialError> + Sync) -> Vec<Result<T, TrialError>> {
        let places: Vec<usize> = (0..self.cases.len()).collect();
        threads::side_by_side(&places, |index| of(*index))
    }

    fn outcome(&self) -> Result<RunOutcome, TrialError> {
        let selectors: Vec<&str> = self.cases.iter().map(|case| case.selector.as_str()).collect();
        let outcomes = self.each(|index| {
            let outcome = self.case(index)?.ok_or(TrialError::Stopped)?;
            // Whoever breaks here is heard by the next case: this one is whole.
            let _ = (self.tell)(Progress::Done { index, outcome: &outcome });
            Ok(outcome)
        });
        // As far as any of them was let reach.
        let reach = self.cases.iter().map(|case| case.reach.words()).max().unwrap_or_default();
        let mut whole = RunOutcome::new(self.settings.seed, self.settings.command(&selectors, None) + reach);
        for (case, outcome) in self.cases.iter().zip(outcomes) {
            match outcome {
                Ok(outcome) => whole.cases.push(outcome),
                Err(TrialError::Stopped) => whole.missing.push(case.name.clone()),
                Err(error) => return Err(error),
            }
        }
        Ok(whole)
    }

    /// - `None`: some of it is somebody else's
    fn case(&self, index: usize) -> Result<Option<CaseOutcome>, TrialError> {
        let Run { settings, keeper, tell, .. } = self;
        let case = &self.cases[index];
        if tell(Progress::Begun(&case.name)).is_break() {
            return Err(TrialError::Stopped);
        }
        let study = settings.study(&case.study);
        let onlooker = Onlooker::new(&case.name, tell).with(*keeper, index);
        let measured = if !case.measures_direct_light() {
            Some(unmeasured(case))
        } else if onlooker.wants(Stage::Exact) {
            self.measured(case, &study, &onlooker)?
        } else {
            None
        };
        let reproduce = settings.command(&[&case.selector], None) + case.reach.words();
        let quick = settings.effort == Effort::Quick;
        let light = light(case, settings.seed, quick, study.smallest_bias, &reproduce, &onlooker)?;
        let paths = indirect(case, settings.seed, quick, study.smallest_bias, &reproduce, &onlooker)?;
        let shares = keeper.is_some_and(Keeper::shares);
        Ok(measured.filter(|_| !shares).map(|measured| CaseOutcome { light, paths, ..measured }))
    }

    fn measured(&self, case: &Case, study: &Study, onlooker: &Onlooker) -> Result<Option<CaseOutcome>, TrialError> {
        // First, while nothing else holds a mesh's hierarchy: two at a time would be the most memory that a run takes.
        let makes = self.keeper.is_none_or(Keeper::makes);
        let meshes = if makes { compare_hierarchies(case, self.settings.seed)? } else { Vec::new() };
        let Some(ready) = Ready::at(case, study, self.make, onlooker)? else { return Ok(None) };
        Ok(from_ready(&ready, study, self.settings, None, meshes, onlooker)?)
    }
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
/// - `None`: some of it is somebody else's
pub(super) fn from_ready(
    ready: &Ready,
    study: &Study,
    settings: &Settings,
    estimators: Option<&BTreeMap<Technique, Box<dyn Estimator>>>,
    meshes: Vec<Timing>,
    onlooker: &Onlooker,
) -> Result<Option<CaseOutcome>, Stopped> {
    let case = ready.case;
    let strategies: Vec<Option<StrategyOutcome>> = study
        .strategies
        .iter()
        .map(|strategy| {
            let mut prepared = ready.prepared(settings.seed, *strategy);
            if let Some(estimators) = estimators {
                prepared.estimator = &*estimators[&strategy.technique()];
            }
            let reproduce = settings.command(&[&case.selector], Some(*strategy)) + case.reach.words();
            run_strategy(&prepared, study, *strategy, reproduce, onlooker)
        })
        .collect::<Result<_, Stopped>>()?;
    let strategies: Option<Vec<StrategyOutcome>> = strategies.into_iter().collect();
    Ok(strategies.map(|strategies| ready.outcome(strategies, meshes)))
}

/// The plans of all cells, and what pilots cost.
pub(super) struct Plans {
    /// `None` in place of a cell that is somebody else's.
    pub cells: Vec<Option<CellPlan>>,
    pub pilot_rays: u64,
    pub pilot_seconds: f64,
}

/// Plans every cell, by prediction where there is one and by a pilot elsewhere.
///
/// - `desk`: told the rays of pilots, and has them; where it errs, all is given up
pub(super) fn plans<D: Desk>(
    prepared: &Prepared,
    study: &Study,
    strategy: Strategy,
    desk: &D,
) -> Result<Plans, D::End> {
    let mut plans = Plans { cells: Vec::new(), pilot_rays: 0, pilot_seconds: 0.0 };
    let technique = strategy.technique();
    for (index, samples) in study.samples.iter().enumerate() {
        if !desk.wants(Stage::of_cell(Purpose::Measurement, strategy, *samples)) {
            plans.cells.push(None);
            continue;
        }
        let prediction = prepared.predictions.cell(strategy, study, index, &prepared.contrasts.weights);
        if prediction.is_complete() {
            plans.cells.push(Some(CellPlan::new(prepared, study, *samples, prediction, None)));
            continue;
        }
        if let Some(bounds) = prepared.predictions.at_most(strategy, *samples, &prepared.contrasts.weights) {
            plans.cells.push(Some(CellPlan::new(prepared, study, *samples, prediction, Some(bounds))));
            continue;
        }
        let counts = [*samples, pilot_replicates(*samples)];
        let rays = rays_of(prepared, counts[0], counts[1]);
        desk.planned(rays)?;
        let fits = |sums: &CellSums| sums.fits(prepared, counts);
        let pilot = measure_unit(prepared, Purpose::Pilot, strategy, counts, desk, fits, |sums| {
            let seconds = sums.seconds;
            (CellSums { kept: Vec::new(), ..sums }, seconds)
        })?;
        plans.pilot_rays += rays;
        plans.pilot_seconds += pilot.as_ref().map_or(0.0, |(_, seconds)| *seconds);
        let plan = |(pilot, _): (CellSums, f64)| {
            let measured = CellPlan::piloted(prepared, technique, &pilot);
            CellPlan::new(prepared, study, *samples, prediction, Some(measured))
        };
        plans.cells.push(pilot.map(plan));
    }
    Ok(plans)
}

/// A cell that is measured, with what takes its estimates one by one.
#[derive(Serialize, Deserialize)]
struct Finished {
    sums: CellSums,
    correlations: Vec<Correlation>,
}

/// - `None`: some of it is somebody else's
fn run_strategy(
    prepared: &Prepared,
    study: &Study,
    strategy: Strategy,
    reproduce: String,
    onlooker: &Onlooker,
) -> Result<Option<StrategyOutcome>, Stopped> {
    let Plans { cells: plans, pilot_rays, pilot_seconds } = plans(prepared, study, strategy, onlooker)?;
    for plan in plans.iter().flatten() {
        onlooker.planned(rays_of(prepared, plan.samples, plan.replicates))?;
    }
    let finished = |plan: &Option<CellPlan>| {
        let Some(plan) = plan else { return Ok(None) };
        let counts = [plan.samples, plan.replicates];
        let fits = |finished: &Finished| finished.sums.fits(prepared, counts);
        let finished = measure_unit(prepared, Purpose::Measurement, strategy, counts, onlooker, fits, |mut sums| {
            let correlations = correlations(prepared, strategy, &sums, plan);
            sums.kept = Vec::new();
            let seconds = sums.seconds;
            (Finished { sums, correlations }, seconds)
        })?;
        Ok(finished.map(|(finished, seconds)| Finished { sums: CellSums { seconds, ..finished.sums }, ..finished }))
    };
    let finished: Vec<Option<Finished>> = plans.iter().map(finished).collect::<Result<_, Stopped>>()?;
    let all = |plans: Vec<Option<CellPlan>>, finished: Vec<Option<Finished>>| {
        let plans: Vec<CellPlan> = plans.into_iter().collect::<Option<_>>()?;
        Some((plans, finished.into_iter().collect::<Option<Vec<Finished>>>()?))
    };
    let Some((plans, finished)) = all(plans, finished) else { return Ok(None) };
    let mut found = Vec::new();
    let mut cells: Vec<CellSums> = Vec::new();
    for Finished { sums, correlations } in finished {
        cells.push(sums);
        found.extend(correlations);
    }
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
    Ok(Some(StrategyOutcome {
        strategy,
        guest: None,
        rates: rates(prepared, strategy, &cells, &plans),
        correlations: found,
        verdicts,
        cells: cells.iter().zip(&plans).map(|(cell, plan)| shown(cell, plan)).collect(),
        timings,
    }))
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
