//! Runs of correct estimators.

use rayon::prelude::*;

use super::Progress;
use super::alarms::{self, AlarmRow, Alarms};
use super::coverage::{self, CoverageRow, Tally};
use super::rooms::Room;
use crate::estimator::for_technique;
use crate::sampling::Strategy;
use crate::statistics::budget::seed_of;
use crate::trial::{CaseOutcome, Effort, Overrides, Repeated, Settings, TrialError};

/// What the null runs came to.
pub(super) struct Null {
    pub alarms: Vec<AlarmRow>,
    pub coverage: Vec<CoverageRow>,
}

/// Runs for each room under each strategy, and in all.
pub(super) fn shares(rooms: &[Room], runs: u64) -> (u64, u64) {
    let groups = (rooms.len() * Strategy::ALL.len()) as u64;
    let each = runs.div_ceil(groups).max(1);
    (each, each * groups)
}

/// Each room under each strategy, `each` times. Outcomes of one room and strategy are held at a time.
pub(super) fn measure(
    rooms: &[Room],
    seed: u64,
    each: u64,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Null, TrialError> {
    let mut counted: Vec<Alarms> = Vec::new();
    let mut tallies: Vec<Tally> = Vec::new();
    for room in rooms {
        for strategy in Strategy::ALL {
            let overrides = Overrides { strategies: Some(vec![strategy]), ..Overrides::default() };
            let repeated = Repeated::new(&room.case, &Settings { seed, effort: Effort::Standard, overrides });
            let outcomes: Vec<CaseOutcome> = (0..each)
                .into_par_iter()
                .map(|run| {
                    let name = format!("calibration/null/{seed}/{}/{strategy}/{run}", room.case.name);
                    let outcome = repeated.run(seed_of(&name), &for_technique);
                    progress(Progress::Done(1));
                    outcome
                })
                .collect::<Result<_, _>>()?;
            for judged in outcomes.iter().flat_map(|outcome| &outcome.strategies).flat_map(|s| &s.verdicts) {
                let known = |alarms: &Alarms| alarms.property == judged.property && alarms.case == room.case.name;
                let at = counted.iter().position(known).unwrap_or_else(|| {
                    counted.push(Alarms::new(judged.property, &room.case.name));
                    counted.len() - 1
                });
                counted[at].add(judged.evidence);
            }
            tallies.extend(coverage::tallies(&room.case.name, room.arriving(strategy), &outcomes));
        }
    }
    Ok(Null { alarms: alarms::rows(&counted), coverage: coverage::rows(&tallies) })
}
