//! What the exact side says of the spread of estimates before any is made.

use std::collections::BTreeMap;

use super::desk::Desk;
use super::techniques::of_technique;
use crate::case::Study;
use crate::configuration::{Configuration, MeasurementPoint};
use crate::oracle::Oracle;
use crate::oracle::variance::{RELATIVE_ERROR, Spread};
use crate::sampling::{PointSet, Strategy, Technique};
use crate::threads;

/// Strata that are integrated one by one, on each source. Of more (some seconds for each point) it is said instead that their
/// estimate varies no more than that of as many independent points, which holds for strata of equal area.
pub(super) const MOST_STRATA: u64 = 1 << 22;

/// Predicted spreads of one case, for all strategies of a study.
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Predictions {
    /// [point]: one sample on each source, uniform by area.
    area: Vec<Option<Spread>>,
    /// [point]: one draw of another technique.
    others: BTreeMap<Technique, Vec<Option<Spread>>>,
    /// [point]: one for each sample count of the study up to [`MOST_STRATA`], one sample in each stratum.
    strata: Vec<Option<Vec<Spread>>>,
    shared: Option<SharedSpreads>,
}

/// Of one sample on each source that all points share.
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
struct SharedSpreads {
    contrasts: Vec<Tolerated>,
    /// [pair of `pairs`]: correlation.
    correlations: Vec<f64>,
}

/// A spread, and how far off its variance may be, W²/m⁴.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Tolerated {
    pub spread: Spread,
    pub error: f64,
}

impl Tolerated {
    fn new(spread: Spread) -> Tolerated {
        Tolerated { spread, error: RELATIVE_ERROR * spread.variance }
    }

    /// The most that the variance may be, W²/m⁴.
    pub fn upper_variance(&self) -> f64 {
        self.spread.variance + self.error
    }
}

/// Of one cell: a strategy and a sample count.
#[derive(Clone, Debug)]
pub(super) struct CellPrediction {
    /// [point]; `None` where it is not predicted.
    pub points: Vec<Option<Tolerated>>,
    /// [point]: the same, or where it is not predicted that of independent points: what is rare there is rare here.
    pub alike: Vec<Option<Spread>>,
    /// [contrast]; `None` unless all points are predicted.
    pub contrasts: Option<Vec<Tolerated>>,
}

impl CellPrediction {
    /// Whether nothing is left for a pilot to tell.
    pub fn is_complete(&self) -> bool {
        self.contrasts.is_some() && self.points.iter().all(Option::is_some)
    }
}

impl Predictions {
    /// - `weights`: `[contrast][point]`
    /// - `pairs`: of points, whose errors' correlation is asked for
    #[cfg(feature = "studies")]
    pub fn new(
        oracle: &Oracle,
        configuration: &Configuration,
        study: &Study,
        weights: &[Vec<f64>],
        pairs: &[(usize, usize)],
    ) -> Predictions {
        let Ok(found) = Predictions::at(oracle, configuration, study, weights, pairs, &super::desk::Alone);
        found
    }

    /// - `desk`: asked between points; where it errs, they are given up
    pub fn at<D: Desk>(
        oracle: &Oracle,
        configuration: &Configuration,
        study: &Study,
        weights: &[Vec<f64>],
        pairs: &[(usize, usize)],
        desk: &D,
    ) -> Result<Predictions, D::End> {
        let points = configuration.points();
        let asks =
            |set: PointSet| study.strategies.iter().any(|s| s.technique() == Technique::Area && s.point_set() == set);
        let by_area = |point: &MeasurementPoint| {
            (0..configuration.sources().len()).try_fold(Spread::default(), |sum, source| {
                Some(sum.plus(oracle.area_moments(source, point)?.spread()))
            })
        };
        let area = of_each(points, desk, by_area)?;
        let techniques = study.strategies.iter().map(|strategy| strategy.technique());
        let others: BTreeMap<Technique, Vec<Option<Spread>>> = techniques
            .filter(|technique| *technique != Technique::Area)
            .map(|technique| {
                let of_point = |point: &MeasurementPoint| of_technique(oracle, configuration, technique, point);
                Ok((technique, of_each(points, desk, of_point)?))
            })
            .collect::<Result<_, D::End>>()?;
        let few: Vec<u64> = study.samples.iter().copied().filter(|n| *n <= MOST_STRATA).collect();
        let strata = if asks(PointSet::Stratified) {
            of_each(points, desk, |point| oracle.strata_spreads(point, &few, &strata))?
        } else {
            vec![None; points.len()]
        };
        let shares = study.strategies.iter().any(|strategy| strategy.shares_points());
        let shared = shares.then(|| oracle.shared_samples(points, weights, pairs)).flatten();
        // The lattice that they are taken on may miss what a point right before a source gets from next to nothing of it.
        let shared = shared.filter(|shared| {
            let known = area.iter().zip(&shared.variances).map(|(own, found)| own.map_or(*found, |own| own.variance));
            known.map(f64::sqrt).sum::<f64>() <= 2.0 * shared.variances.iter().map(|v| v.max(0.0).sqrt()).sum::<f64>()
        });
        let shared = shared.map(|shared| {
            let contrasts = shared.sums.iter().zip(&shared.sum_errors);
            let correlation = |((i, j), covariance): (&(usize, usize), &f64)| {
                let scale = (shared.variances[*i] * shared.variances[*j]).sqrt();
                if scale > 0.0 { (covariance / scale).clamp(-1.0, 1.0) } else { 0.0 }
            };
            SharedSpreads {
                contrasts: contrasts.map(|(spread, error)| Tolerated { spread: *spread, error: *error }).collect(),
                correlations: pairs.iter().zip(&shared.covariances).map(correlation).collect(),
            }
        });
        Ok(Predictions { area, others, strata, shared })
    }

    /// Whether these are predictions for so many points, and such a study.
    pub fn fits(&self, n_points: usize, study: &Study, weights: &[Vec<f64>], pairs: &[(usize, usize)]) -> bool {
        let few = study.samples.iter().filter(|n| **n <= MOST_STRATA).count();
        let techniques = study.strategies.iter().map(|strategy| strategy.technique());
        let others = techniques.filter(|technique| *technique != Technique::Area);
        let of_shared = |shared: &SharedSpreads| [shared.contrasts.len(), shared.correlations.len()];
        [self.area.len(), self.strata.len()] == [n_points; 2]
            && others.into_iter().all(|technique| self.others.contains_key(&technique))
            && self.others.values().all(|spreads| spreads.len() == n_points)
            && self.strata.iter().flatten().all(|spreads| spreads.len() == few)
            && self.shared.as_ref().is_none_or(|shared| of_shared(shared) == [weights.len(), pairs.len()])
    }

    /// What is predicted of a strategy at the study's `index`-th sample count.
    pub fn cell(&self, strategy: Strategy, study: &Study, index: usize, weights: &[Vec<f64>]) -> CellPrediction {
        let n = study.samples[index] as f64;
        let points: Vec<Option<Tolerated>> = match (strategy.technique(), strategy.point_set()) {
            (Technique::Area, PointSet::Independent) => {
                self.area.iter().map(|spread| Some(Tolerated::new((*spread)?.mean_of(n)))).collect()
            }
            (Technique::Area, PointSet::Stratified) => {
                let few = |n: &u64| *n <= MOST_STRATA;
                let before = study.samples[..index].iter().filter(|n| few(n)).count();
                let place = few(&study.samples[index]).then_some(before);
                self.strata.iter().map(|spreads| Some(Tolerated::new(spreads.as_ref()?[place?]))).collect()
            }
            (Technique::Area, _) => vec![None; self.area.len()],
            (technique, _) => {
                self.others[&technique].iter().map(|spread| Some(Tolerated::new((*spread)?.mean_of(n)))).collect()
            }
        };
        let contrasts = if strategy.shares_points() {
            self.shared.as_ref().map(|shared| {
                let of_mean = |c: &Tolerated| Tolerated { spread: c.spread.mean_of(n), error: c.error / n };
                shared.contrasts.iter().map(of_mean).collect()
            })
        } else {
            weights.iter().map(|row| fresh_sum(row, &points)).collect()
        };
        let independent = |p: usize| match strategy.technique() {
            Technique::Area => Some(self.area[p]?.mean_of(n)),
            _ => None,
        };
        let alike = points.iter().enumerate();
        let alike = alike.map(|(p, own)| own.map(|own| own.spread).or_else(|| independent(p))).collect();
        CellPrediction { points, alike, contrasts }
    }

    /// What is known of a cell that is not predicted without any pilot: an upper bound of the variance at each point, and of
    /// each contrast, W²/m⁴.
    ///
    /// - `weights`: `[contrast][point]`
    pub fn at_most(&self, strategy: Strategy, samples: u64, weights: &[Vec<f64>]) -> Option<(Vec<f64>, Vec<f64>)> {
        let is_refined = strategy.technique() == Technique::Area && strategy.point_set() == PointSet::Stratified;
        if !is_refined || strategy.shares_points() || samples <= MOST_STRATA {
            return None;
        }
        let n = samples as f64;
        let upper = |spread: &Option<Spread>| Some(Tolerated::new((*spread)?.mean_of(n)).upper_variance());
        let points: Vec<f64> = self.area.iter().map(upper).collect::<Option<_>>()?;
        let of_sum = |row: &Vec<f64>| row.iter().zip(&points).map(|(w, v)| w * w * v).sum();
        Some((points.clone(), weights.iter().map(of_sum).collect()))
    }

    /// Correlation of the errors at the pairs that were asked for; `None` where it is not predicted.
    pub fn correlations(&self, strategy: Strategy) -> Option<&[f64]> {
        if strategy.shares_points() { self.shared.as_ref().map(|shared| &shared.correlations[..]) } else { None }
    }
}

/// What is found at each point, unless that is given up.
fn of_each<R: Send + Sync, D: Desk>(
    points: &[MeasurementPoint],
    desk: &D,
    find: impl Fn(&MeasurementPoint) -> R + Sync,
) -> Result<Vec<R>, D::End> {
    threads::map(points, |point| desk.traced(0).map(|()| find(point))).into_iter().collect()
}

/// A weighted sum over points whose estimates are independent of one another.
fn fresh_sum(weights: &[f64], points: &[Option<Tolerated>]) -> Option<Tolerated> {
    weights.iter().zip(points).try_fold(Tolerated::new(Spread::default()), |sum, (w, point)| {
        let point = (*point)?;
        Some(Tolerated { spread: sum.spread.plus(point.spread.scaled(*w)), error: sum.error + w * w * point.error })
    })
}

/// The strata of N points as `[u₀, u₁, v₀, v₁]`: R = ⌊√N⌉ rows, row r with ⌊(r+1)N/R⌋ − ⌊rN/R⌋ of them, as high as its share.
pub(super) fn strata(n: u64) -> impl Iterator<Item = [f64; 4]> {
    let rows = ((n as f64).sqrt().round() as u64).max(1);
    let start = move |row: u64| (u128::from(row) * u128::from(n) / u128::from(rows)) as u64;
    (0..rows).flat_map(move |row| {
        let (first, end) = (start(row), start(row + 1));
        let share = move |k: u64| k as f64 / (end - first) as f64;
        let [bottom, top] = [first, end].map(|k| k as f64 / n as f64);
        (0..end - first).map(move |k| [share(k), share(k + 1), bottom, top])
    })
}
