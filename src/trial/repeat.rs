//! One case from many seeds: exact values and predictions are found once.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use super::mesh_rays::compare_hierarchies;
use super::onlooker::Onlooker;
use super::outcome::CaseOutcome;
use super::ready::{Maker, Ready};
use super::run::{TrialError, from_ready};
use super::settings::Settings;
use crate::case::{Case, Study};
use crate::estimator::{Estimator, for_technique};
use crate::sampling::Technique;

/// A case made ready, to be run again and again.
pub struct Repeated<'a> {
    ready: Ready<'a>,
    study: Study,
    settings: Settings,
}

impl<'a> Repeated<'a> {
    /// - `settings`: for all runs; their seed is each run's own
    pub fn new(case: &'a Case, settings: &Settings) -> Repeated<'a> {
        let study = settings.study(&case.study);
        Repeated { ready: Ready::new(case, &study, &for_technique), study, settings: settings.clone() }
    }

    /// What [`super::run_with`] makes of the case from this seed, with these estimators.
    pub fn run(&self, seed: u64, make: &Maker) -> Result<CaseOutcome, TrialError> {
        let mut estimators: BTreeMap<Technique, Box<dyn Estimator>> = BTreeMap::new();
        for strategy in &self.study.strategies {
            let configuration = &self.ready.case.configuration;
            estimators.entry(strategy.technique()).or_insert_with_key(|technique| make(configuration, *technique));
        }
        let settings = Settings { seed, ..self.settings.clone() };
        let meshes = compare_hierarchies(self.ready.case, seed)?;
        let onlooker = Onlooker::new(&self.ready.case.name, &|_| ControlFlow::Continue(()));
        let outcome = from_ready(&self.ready, &self.study, &settings, Some(&estimators), meshes, &onlooker)?;
        Ok(outcome.expect("nobody else has a part of it"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{Replicates, shipped};
    use crate::trial::{Effort, Overrides, run};

    #[test]
    fn a_repeated_run_is_a_run() {
        let case = shipped().find(|case| case.name() == "penumbra/two-shadows").unwrap().read().unwrap();
        let overrides =
            Overrides { samples: Some(vec![1, 4]), replicates: Some(Replicates::Fixed(64)), ..Overrides::default() };
        let settings = |seed| Settings { seed, effort: Effort::Standard, overrides: overrides.clone() };
        let repeated = Repeated::new(&case, &settings(1));
        for seed in [5, 6] {
            let again = repeated.run(seed, &for_technique).unwrap();
            let alone = run(std::slice::from_ref(&case), &settings(seed), &|_| ()).unwrap().cases.remove(0);
            for (a, b) in again.strategies.iter().zip(&alone.strategies) {
                assert_eq!((&a.verdicts, &a.rates, &a.correlations), (&b.verdicts, &b.rates, &b.correlations));
                assert!(a.cells.iter().zip(&b.cells).all(|(a, b)| a.points == b.points));
            }
        }
    }
}
