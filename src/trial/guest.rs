//! Estimates that somebody else made, judged: asked of a sampler or an estimator in this process, or brought from outside.

use std::time::Instant;

use super::accept::accept;
use super::correlation::correlations;
use super::judge::{self, Judged};
use super::lean::{Leaning, variances};
use super::measure::{CellSums, Prepared, measure_alone};
use super::outcome::{CaseOutcome, StrategyOutcome, Timing};
use super::plan::{CellPlan, most_replicates, pilot_replicates};
use super::ready::Ready;
use super::settings::Settings;
use super::shown::{efficiency, shown};
use crate::case::{Case, Replicates, Study};
use crate::configuration::{Configuration, MeasurementPoint};
use crate::errors::errors;
use crate::estimator::{Estimator, Guest, GuestFault, GuestPoints, Job, Scratch};
use crate::sampling::{Purpose, Strategy, StreamKey, Technique};

/// A pilot has no fewer replicates.
pub const FEWEST_PILOT_REPLICATES: u64 = 8;
/// Estimates, over all points, that an automatic plan asks of somebody outside for one sample count.
const MOST_ASKED: u64 = 1 << 22;

/// Who is judged, and on what terms.
#[derive(Clone, Debug)]
pub struct Invitation<'a> {
    /// What reports call them.
    pub name: &'a str,
    pub leaning: Leaning,
    /// What gives the same verdict again.
    pub reproduce: String,
}

errors! {
    /// Why there is no verdict.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum NotJudged {
        #[error("{case}: there is nothing to judge: no source with an area, or no point that looks at one")]
        NoDirectLight { case: String },
        #[error("{case}: {name} {fault}")]
        Fault { case: String, name: String, fault: GuestFault },
        #[error(
            "{case}: too few {what} ({said}); at least {least} are needed, of which the first quarter tells how they spread{otherwise}",
            least = 4 * FEWEST_PILOT_REPLICATES,
            otherwise = if *bound_would_do { " (or the statement that they spread no more than `random`, `--variance random`)" } else { "" }
        )]
        TooFew { case: String, what: &'static str, said: u64, bound_would_do: bool },
    }
}

/// Estimates that are wanted of somebody outside: `replicates` of all points, for each sample count.
#[derive(Clone, Debug)]
pub struct Asked<'a> {
    pub points: &'a [MeasurementPoint],
    pub cells: Vec<AskedCell>,
}

/// One sample count.
#[derive(Clone, Copy, Debug)]
pub struct AskedCell {
    pub samples: u64,
    pub replicates: u64,
    /// Replicate, then point (from 1) are absorbed below it.
    pub key: StreamKey,
}

/// How many replicates there are.
enum Supply {
    /// As many as are asked for, made in this process.
    Here,
    /// As many as are asked for, each a line to and fro.
    Outside,
    /// Of each cell so many for the pilot, and so many to be judged.
    Given(Vec<[u64; 2]>),
}

/// Takes one replicate: the index of its cell, and its estimates at all points, W/m².
pub type Take<'a> = dyn FnMut(usize, &[f64]) + 'a;

/// Judges an estimator, or points, that somebody brought into this process.
///
/// - `guest`: of the case's configuration
pub fn judge_guest(
    case: &Case,
    settings: &Settings,
    invitation: &Invitation,
    guest: &dyn Guest,
) -> Result<CaseOutcome, NotJudged> {
    let study = study(case, settings)?;
    let ready = Ready::new(case, &study, &by_area);
    let judging = Judging { ready: &ready, study, settings, invitation, shared: guest.shares_points() };
    judging.to_end(&Supply::Here, &mut |prepared, purpose, cells| {
        let prepared = Prepared { estimator: guest, ..*prepared };
        let measured = |(samples, replicates): &(u64, u64)| {
            measure_alone(&prepared, purpose, Strategy::Random, *samples, *replicates)
        };
        let sums = cells.iter().map(measured).collect();
        match guest.fault() {
            Some(fault) => Err(NotJudged::Fault { case: case.name.clone(), name: invitation.name.to_owned(), fault }),
            None => Ok(sums),
        }
    })
}

/// Judges sets of points that were made before: each is one replicate, shared by all shading points and sources.
///
/// - `sets`: as many points in each
pub fn judge_sets(
    case: &Case,
    settings: &Settings,
    invitation: &Invitation,
    sets: &[Vec<[f64; 2]>],
) -> Result<CaseOutcome, NotJudged> {
    let mut study = study(case, settings)?;
    study.samples = vec![sets.first().map_or(1, |set| set.len() as u64)];
    let given = split(&case.name, "sets", invitation.leaning, sets.len() as u64)?;
    study.replicates = Replicates::Fixed(given[1]);
    let ready = Ready::new(case, &study, &by_area);
    let (pilot, judged) = sets.split_at(given[0] as usize);
    let room = &case.configuration;
    let judging = Judging { ready: &ready, study, settings, invitation, shared: true };
    judging.to_end(&Supply::Given(vec![given]), &mut |prepared, purpose, cells| {
        let sets = if purpose == Purpose::Pilot { pilot } else { judged };
        let points = GuestPoints::of_sets(room, sets);
        let prepared = Prepared { estimator: &points, ..*prepared };
        let measured = |(samples, replicates): &(u64, u64)| {
            measure_alone(&prepared, purpose, Strategy::Random, *samples, *replicates)
        };
        let sums = cells.iter().map(measured).collect();
        let fault = points.fault();
        fault.map_or(Ok(sums), |fault| {
            Err(NotJudged::Fault { case: case.name.clone(), name: invitation.name.to_owned(), fault })
        })
    })
}

/// Judges estimates that are asked of somebody outside: for the pilot, where one is leant on, then for the judgement.
///
/// - `answer`: gives all replicates of each cell in their order
pub fn judge_answers<E: From<NotJudged>>(
    case: &Case,
    settings: &Settings,
    invitation: &Invitation,
    answer: &mut dyn FnMut(Purpose, &Asked, &mut Take) -> Result<(), E>,
) -> Result<CaseOutcome, E> {
    let study = study(case, settings)?;
    let ready = Ready::new(case, &study, &by_area);
    let judging = Judging { ready: &ready, study, settings, invitation, shared: false };
    judging.to_end(&Supply::Outside, &mut |prepared, purpose, cells| {
        let mut sums = empty(prepared, cells);
        answer(purpose, &asked(prepared, purpose, cells), &mut |cell, row| sums[cell].add(prepared, row))?;
        Ok(sums)
    })
}

/// Judges estimates that were made before: the first quarter of the replicates is the pilot, where one is leant on.
///
/// - `given`: for each sample count, ascending, `[replicate][point]`, W/m²
pub fn judge_given(
    case: &Case,
    settings: &Settings,
    invitation: &Invitation,
    given: &[(u64, Vec<Vec<f64>>)],
) -> Result<CaseOutcome, NotJudged> {
    let mut study = study(case, settings)?;
    study.samples = given.iter().map(|(samples, _)| *samples).collect();
    let counts: Vec<[u64; 2]> = given
        .iter()
        .map(|(_, rows)| split(&case.name, "replicates", invitation.leaning, rows.len() as u64))
        .collect::<Result<_, _>>()?;
    study.replicates = Replicates::Fixed(2);
    let ready = Ready::new(case, &study, &by_area);
    let judging = Judging { ready: &ready, study, settings, invitation, shared: false };
    judging.to_end(&Supply::Given(counts.clone()), &mut |prepared, purpose, cells| {
        let mut sums = empty(prepared, cells);
        for ((sums, (_, rows)), [pilot, _]) in sums.iter_mut().zip(given).zip(&counts) {
            let (pilot, judged) = rows.split_at(*pilot as usize);
            let rows = if purpose == Purpose::Pilot { pilot } else { judged };
            rows.iter().for_each(|row| sums.add(prepared, row));
        }
        Ok(sums)
    })
}

/// What is asked of somebody outside where nobody plans: for questions that are answered later.
pub fn questions<'a>(case: &'a Case, settings: &Settings) -> Result<Asked<'a>, NotJudged> {
    let study = study(case, settings)?;
    let replicates = match study.replicates {
        Replicates::Fixed(replicates) => replicates,
        Replicates::Auto => 4 * FEWEST_PILOT_REPLICATES,
    };
    let cells = study.samples.iter().map(|samples| {
        let key = cell_key(case, settings.seed, Purpose::Measurement, *samples);
        AskedCell { samples: *samples, replicates, key }
    });
    Ok(Asked { points: case.configuration.points(), cells: cells.collect() })
}

/// Stands for points by area where none are drawn: a guest's plan counts their rays.
struct Counted {
    sources: u64,
}

impl Estimator for Counted {
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        self.sources * samples
    }

    fn estimate(&self, _: &Job, _: &mut Scratch, estimates: &mut [f64]) {
        estimates.fill(f64::NAN);
    }
}

fn by_area(configuration: &Configuration, _: Technique) -> Box<dyn Estimator> {
    Box::new(Counted { sources: configuration.sources().len() as u64 })
}

fn study(case: &Case, settings: &Settings) -> Result<Study, NotJudged> {
    if !case.measures_direct_light() {
        return Err(NotJudged::NoDirectLight { case: case.name.clone() });
    }
    let study = settings.study(&case.study);
    Ok(Study { strategies: vec![Strategy::Random], ..study })
}

/// A pilot and what is judged, of replicates that are there.
fn split(case: &str, what: &'static str, leaning: Leaning, replicates: u64) -> Result<[u64; 2], NotJudged> {
    let too_few =
        |bound_would_do| NotJudged::TooFew { case: case.to_owned(), what, said: replicates, bound_would_do };
    match leaning {
        Leaning::Pilot if replicates / 4 < FEWEST_PILOT_REPLICATES => Err(too_few(replicates > 1)),
        Leaning::Pilot => Ok([replicates / 4, replicates - replicates / 4]),
        Leaning::Random if replicates < 2 => Err(too_few(false)),
        Leaning::Random => Ok([0, replicates]),
    }
}

fn cell_key(case: &Case, seed: u64, purpose: Purpose, samples: u64) -> StreamKey {
    StreamKey::cell(seed, case.configuration.digest().key(), purpose, Strategy::Random, samples)
}

fn asked<'a>(prepared: &Prepared<'a>, purpose: Purpose, cells: &[(u64, u64)]) -> Asked<'a> {
    let cells = cells.iter().map(|(samples, replicates)| AskedCell {
        samples: *samples,
        replicates: *replicates,
        key: cell_key(prepared.case, prepared.seed, purpose, *samples),
    });
    Asked { points: prepared.case.configuration.points(), cells: cells.collect() }
}

fn empty(prepared: &Prepared, cells: &[(u64, u64)]) -> Vec<CellSums> {
    cells.iter().map(|(samples, replicates)| CellSums::new(prepared, *samples, *replicates)).collect()
}

/// One guest before one case.
struct Judging<'a> {
    ready: &'a Ready<'a>,
    study: Study,
    settings: &'a Settings,
    invitation: &'a Invitation<'a>,
    shared: bool,
}

/// What gives the sums of cells, each so many replicates with so many samples.
type Ask<'a, E> = dyn FnMut(&Prepared, Purpose, &[(u64, u64)]) -> Result<Vec<CellSums>, E> + 'a;

impl Judging<'_> {
    fn to_end<E>(&self, supply: &Supply, ask: &mut Ask<E>) -> Result<CaseOutcome, E> {
        let Judging { ready, study, settings, invitation, shared } = self;
        let prepared = ready.prepared(settings.seed, Strategy::Random);
        let leaning = invitation.leaning;
        let pilot_cells: Vec<(u64, u64)> = study
            .samples
            .iter()
            .enumerate()
            .map(|(index, samples)| (*samples, self.pilot_replicates(supply, index, *samples)))
            .collect();
        let mut seconds = Vec::new();
        let mut timed = |ask: &mut Ask<E>, purpose, cells: &[(u64, u64)]| {
            let start = Instant::now();
            let sums = ask(&prepared, purpose, cells);
            seconds.push(start.elapsed().as_secs_f64());
            sums
        };
        let pilots = match leaning {
            Leaning::Pilot => Some(timed(ask, Purpose::Pilot, &pilot_cells)?),
            Leaning::Random => None,
        };
        let plan = |(index, samples): (usize, &u64)| {
            let pilot = pilots.as_ref().map(|pilots| &pilots[index]);
            let found = variances(&prepared, study, index, *shared, pilot);
            let n_points = prepared.exact.len() as u64;
            let most = most_replicates(&prepared, *samples);
            let most =
                if matches!(supply, Supply::Outside) { most.min((MOST_ASKED / n_points).max(1)) } else { most };
            let given = match supply {
                Supply::Here | Supply::Outside => None,
                Supply::Given(given) => Some(given[index][1]),
            };
            CellPlan::leaning(&prepared, study, *samples, most, given, found)
        };
        let plans: Vec<CellPlan> = study.samples.iter().enumerate().map(plan).collect();
        let planned: Vec<(u64, u64)> = plans.iter().map(|plan| (plan.samples, plan.replicates)).collect();
        let cells = timed(ask, Purpose::Measurement, &planned)?;
        let more = match supply {
            Supply::Here | Supply::Outside => Judged::more_of(study.replicates),
            Supply::Given(_) if leaning == Leaning::Random => "replicates would do",
            Supply::Given(_) => "replicates would do, and a third as many for the pilot",
        };
        let judged = Judged { name: invitation.name, reproduce: invitation.reproduce.clone(), more };
        let mut verdicts = vec![judge::bias(&prepared, study, judged, &cells, &plans)];
        accept(&mut verdicts, None, &study.accepted);
        let pilot_counts: Vec<u64> = pilot_cells.iter().map(|(_, replicates)| *replicates).collect();
        let lean = leaning.words(&pilot_counts);
        for verdict in &mut verdicts {
            verdict.note = Some(verdict.note.take().map_or(lean.clone(), |note| format!("{note}; {lean}")));
        }
        let rays =
            |cells: &[(u64, u64)]| -> u64 { cells.iter().map(|(n, r)| n * r * prepared.exact.len() as u64).sum() };
        let stages = [("pilot", rays(&pilot_cells)), ("measure", rays(&planned))];
        let stages = stages.into_iter().skip(usize::from(pilots.is_none())).zip(&seconds);
        let timings = stages.map(|((stage, rays), seconds)| Timing {
            stage,
            rays,
            seconds: *seconds,
            efficiency: cells.last().filter(|_| stage == "measure").and_then(|c| efficiency(c, prepared.exact.len())),
        });
        let strategy = StrategyOutcome {
            strategy: Strategy::Random,
            guest: Some(invitation.name.to_owned()),
            rates: Vec::new(),
            correlations: cells
                .iter()
                .zip(&plans)
                .filter(|_| !shared)
                .flat_map(|(cell, plan)| correlations(&prepared, Strategy::Random, cell, plan))
                .collect(),
            verdicts,
            cells: cells.iter().zip(&plans).map(|(cell, plan)| shown(cell, plan)).collect(),
            timings: timings.collect(),
        };
        Ok(ready.outcome(vec![strategy], Vec::new()))
    }

    fn pilot_replicates(&self, supply: &Supply, index: usize, samples: u64) -> u64 {
        match (supply, self.study.replicates) {
            (Supply::Given(given), _) => given[index][0],
            (_, Replicates::Auto) => pilot_replicates(samples),
            // No more than what is judged, or a pilot would be the larger part.
            (_, Replicates::Fixed(n)) => pilot_replicates(samples).min(n.max(4 * FEWEST_PILOT_REPLICATES)),
        }
    }
}
