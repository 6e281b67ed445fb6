//! A case made ready: exact values, predictions, contrasts and estimators, once for all strategies.

use std::collections::BTreeMap;
use std::time::Instant;

use super::correlation;
use super::desk::{Alone, Desk, Portion, Stage};
use super::measure::{Contrasts, Prepared};
use super::outcome::{CaseOutcome, StrategyOutcome, Timing};
use super::predict::Predictions;
use super::reach::{full, grazing};
use crate::case::{Case, Study};
use crate::configuration::{Configuration, Digest};
use crate::estimator::Estimator;
use crate::oracle::{Oracle, Truth};
use crate::sampling::{Strategy, Technique};

/// Makes the estimator that is judged, for one configuration and technique.
pub type Maker<'a> = dyn Fn(&Configuration, Technique) -> Box<dyn Estimator> + 'a + Sync;

pub(super) struct Ready<'a> {
    pub case: &'a Case,
    digest: Digest,
    pub truths: Vec<Truth>,
    exact: Vec<f64>,
    full: Vec<f64>,
    grazing: Vec<f64>,
    contrasts: Contrasts,
    predictions: Predictions,
    estimators: BTreeMap<Technique, Box<dyn Estimator>>,
    pub timings: Vec<Timing>,
}

impl<'a> Ready<'a> {
    /// - `make`: the estimators that are judged, one for each technique of the study's strategies
    pub fn new(case: &'a Case, study: &Study, make: &Maker) -> Ready<'a> {
        let Ok(ready) = Ready::at(case, study, make, &Alone);
        ready.expect("nobody else has a part of it")
    }

    /// - `desk`: asked between points; has exact values and predictions
    /// - `None`: they are somebody else's
    pub fn at<D: Desk>(case: &'a Case, study: &Study, make: &Maker, desk: &D) -> Result<Option<Ready<'a>>, D::End> {
        let configuration = &case.configuration;
        let oracle = Oracle::new(configuration);
        let points = configuration.points();
        let fits = |(truths, full): &(Vec<Truth>, Vec<f64>)| [truths.len(), full.len()] == [points.len(); 2];
        let exact = desk.unit(Portion::whole(Stage::Exact), 0, fits, || {
            let start = Instant::now();
            let truth = |point| desk.traced(0).map(|()| oracle.at(point));
            let truths: Vec<Truth> = points.iter().map(truth).collect::<Result<_, D::End>>()?;
            let seconds = start.elapsed().as_secs_f64();
            let full = full(configuration, &oracle, &truths);
            Ok(((truths, full), seconds))
        })?;
        let Some(((truths, full), seconds)) = exact else { return Ok(None) };
        let timing = |stage, seconds| Timing { stage, rays: points.len() as u64, seconds, efficiency: None };
        let mut timings = vec![timing("exact", seconds)];
        let exact: Vec<f64> = truths.iter().map(|truth| truth.irradiance.watts_per_square_metre()).collect();
        let contrasts = Contrasts::new(&exact);
        let grazing = points.iter().zip(&truths).map(|(point, truth)| grazing(configuration, point, truth));
        let grazing = grazing.collect();
        let pairs = correlation::pairs(configuration);
        let fits = |asked: &Predictions| asked.fits(points.len(), study, &contrasts.weights, &pairs);
        let predictions = desk.unit(Portion::whole(Stage::Predictions), 0, fits, || {
            let start = Instant::now();
            let asked = Predictions::at(&oracle, configuration, study, &contrasts.weights, &pairs, desk)?;
            Ok((asked, start.elapsed().as_secs_f64()))
        })?;
        let Some((predictions, seconds)) = predictions else { return Ok(None) };
        timings.push(timing("predict", seconds));
        let mut estimators: BTreeMap<Technique, Box<dyn Estimator>> = BTreeMap::new();
        for strategy in &study.strategies {
            estimators.entry(strategy.technique()).or_insert_with_key(|technique| make(configuration, *technique));
        }
        Ok(Some(Ready {
            case,
            digest: configuration.digest(),
            truths,
            exact,
            full,
            grazing,
            contrasts,
            predictions,
            estimators,
            timings,
        }))
    }

    /// What was found of the case.
    pub fn outcome(&self, strategies: Vec<StrategyOutcome>, timings: Vec<Timing>) -> CaseOutcome {
        let case = self.case;
        CaseOutcome {
            name: case.name.clone(),
            title: case.title.clone(),
            digest: self.digest,
            arrangement: case.configuration.arrangement(),
            #[cfg(feature = "studies")]
            figures: case.configuration.figures(),
            albedos: case.configuration.albedos(),
            points: case.configuration.points().to_vec(),
            truths: self.truths.clone(),
            strategies,
            light: None,
            paths: None,
            timings: self.timings.iter().cloned().chain(timings).collect(),
        }
    }

    /// - `strategy`: one of the study's
    pub fn prepared(&self, seed: u64, strategy: Strategy) -> Prepared<'_> {
        Prepared {
            case: self.case,
            seed,
            digest: self.digest,
            truths: &self.truths,
            exact: &self.exact,
            full: &self.full,
            grazing: &self.grazing,
            estimator: &*self.estimators[&strategy.technique()],
            contrasts: &self.contrasts,
            predictions: &self.predictions,
        }
    }
}
