//! From variances to the replicates that a verdict needs.
//!
//! Where the exact side predicts the variance, it plans and judges. Elsewhere a pilot does, which draws from streams of its
//! own, so what it says is independent of what is judged; its variances are taken on the high side: by two standard errors,
//! and, where a shadow's edge crosses the source or directions must find it, by what a part of it too small to have been
//! hit could add.

use super::lean::Variances;
use super::measure::{BATCHES, CellSums, Prepared};
use super::predict::{CellPrediction, Tolerated};
use super::reach::peak;
use crate::case::{Replicates, Study};
use crate::oracle::Region;
use crate::sampling::Technique;
use crate::statistics::PowerSums;
use crate::statistics::evidence::{replicates_for, smallest_shift};

/// Shadow rays that one cell may cost before `auto` stops and says undecided.
const MOST_RAYS: u64 = 1 << 30;
/// Fewest replicates of an automatic plan: enough for a variance and a correlation; more where samples are few, so that the
/// variance is judged too.
pub(super) const FEWEST_REPLICATES: u64 = 128;
const FEWEST_SAMPLES: u64 = 16_384;
/// Share of the sources' light ([`super::reach::full`]) from which on a point must be able to see the `point` bias.
const WELL_LIT: f64 = 0.1;
/// A sample that may bring this many times the irradiance need not have shown in a pilot.
const SPIKE: f64 = 1e3;
/// An event that had this expected count in the pilot would have been missed with probability e⁻¹².
const UNSEEN_COUNT: f64 = 12.0;

/// One cell's variances and replicates.
#[derive(Clone, Debug)]
pub(super) struct CellPlan {
    pub samples: u64,
    pub replicates: u64,
    /// Upper value of the variance of one estimate at each point, W²/m⁴.
    pub point_variances: Vec<f64>,
    /// The same for the mean and each contrast, W²/m⁴.
    pub contrast_variances: Vec<f64>,
    /// What the exact side predicts.
    pub prediction: CellPrediction,
}

/// Relative biases that would have been caught with 99 % probability.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmallestBiases {
    /// Of the mean over the points; `None` where no light is due.
    pub mean: Option<f64>,
    /// At the worst of the well-lit points; `None` where there is none.
    pub point: Option<f64>,
}

/// Pilot replicates of a cell with N samples.
pub(super) fn pilot_replicates(samples: u64) -> u64 {
    (8192 / samples).max(128)
}

/// Capitals that a verdict averages: each point, the mean and each contrast, at each sample count and pooled.
pub(super) fn components(prepared: &Prepared, study: &Study) -> usize {
    (prepared.exact.len() + prepared.contrasts.weights.len()) * (study.samples.len() + 1)
}

impl CellPlan {
    /// - `otherwise`: upper variances of points and contrasts, where not everything is predicted
    pub fn new(
        prepared: &Prepared,
        study: &Study,
        samples: u64,
        prediction: CellPrediction,
        otherwise: Option<(Vec<f64>, Vec<f64>)>,
    ) -> CellPlan {
        let predicted: Option<Vec<f64>> =
            prediction.points.iter().map(|point| point.map(|spread| spread.upper_variance())).collect();
        let contrasts =
            prediction.contrasts.as_ref().map(|list| list.iter().map(Tolerated::upper_variance).collect());
        let (point_variances, contrast_variances) = otherwise.unwrap_or_default();
        let mut plan = CellPlan {
            samples,
            replicates: 0,
            point_variances: predicted.unwrap_or(point_variances),
            contrast_variances: contrasts.unwrap_or(contrast_variances),
            prediction,
        };
        plan.replicates = match study.replicates {
            Replicates::Fixed(n) => n,
            Replicates::Auto => plan.automatic(prepared, study, most_replicates(prepared, samples)),
        };
        plan
    }

    /// Of a guest: variances as [`super::lean`] finds them, nothing predicted.
    ///
    /// - `most`: replicates that an automatic plan may ask for
    /// - `given`: where they are there already
    pub fn leaning(
        prepared: &Prepared,
        study: &Study,
        samples: u64,
        most: u64,
        given: Option<u64>,
        variances: Variances,
    ) -> CellPlan {
        let Variances { points, contrasts, alike } = variances;
        let prediction = CellPrediction { points: vec![None; prepared.exact.len()], alike, contrasts: None };
        let mut plan =
            CellPlan { samples, replicates: 0, point_variances: points, contrast_variances: contrasts, prediction };
        plan.replicates = match (given, study.replicates) {
            (Some(n), _) | (None, Replicates::Fixed(n)) => n,
            (None, Replicates::Auto) => plan.automatic(prepared, study, most),
        };
        plan
    }

    /// Upper variances of points and contrasts from a pilot.
    pub fn piloted(prepared: &Prepared, technique: Technique, pilot: &CellSums) -> (Vec<f64>, Vec<f64>) {
        let configuration = &prepared.case.configuration;
        let n = pilot.samples as f64;
        let seen = pilot.replicates as f64;
        // What could hide from the pilot at each point.
        let unseen: Vec<f64> = configuration
            .points()
            .iter()
            .zip(prepared.truths)
            .map(|(point, truth)| {
                // Directions that must find a source jump at its own outline, too.
                let seeks = !matches!(technique, Technique::Area);
                let peak = peak(configuration, point, technique);
                // So near a source that most of its light comes from less of it than a pilot may hit.
                let spike = peak > SPIKE * truth.irradiance.watts_per_square_metre();
                let cut = seeks || spike || truth.shadow_edge || truth.region == Region::Edge;
                let part = peak / n;
                if cut { part * part * UNSEEN_COUNT / seen } else { 0.0 }
            })
            .collect();
        let point_variances: Vec<f64> = (0..prepared.exact.len())
            .map(|p| {
                let ceiling = peak(configuration, &configuration.points()[p], technique) * prepared.exact[p] / n;
                // A mean of N independent terms of at most `peak` has no more than this variance, whatever the pilot saw.
                (upper_variance(&pilot.points[p]) + unseen[p]).min(ceiling)
            })
            .collect();
        let contrast_variances = pilot
            .contrasts
            .iter()
            .zip(&prepared.contrasts.weights)
            .map(|(sums, weights)| {
                let hidden: f64 = weights.iter().zip(&unseen).map(|(w, v)| w * w * v).sum();
                upper_variance(sums) + hidden
            })
            .collect();
        (point_variances, contrast_variances)
    }

    /// As many as the smallest biases need.
    fn automatic(&self, prepared: &Prepared, study: &Study, most: u64) -> u64 {
        let m = components(prepared, study);
        let mut needed = FEWEST_REPLICATES.max(FEWEST_SAMPLES / self.samples);
        if let Some((value, margin)) = mean_of(prepared, study) {
            let shift = before_scaling(study.smallest_bias.mean) * value - margin;
            needed = needed.max(replicates_for(shift, self.contrast_variances[0], m));
        }
        // The replicates grow with variance/shift²: the point where this is largest decides.
        let points = well_lit(prepared, study)
            .map(|(p, value, margin)| {
                (before_scaling(study.smallest_bias.point) * value - margin, self.point_variances[p])
            })
            .max_by(|a, b| relative_variance(*a).total_cmp(&relative_variance(*b)));
        if let Some((shift, variance)) = points {
            needed = needed.max(replicates_for(shift, variance, m));
        }
        needed.min(most).next_multiple_of(BATCHES)
    }

    /// The relative biases that would have been caught with 99 % probability, of the mean over the points and at the
    /// worst of the well-lit points.
    pub fn smallest_biases(&self, prepared: &Prepared, study: &Study) -> SmallestBiases {
        let m = components(prepared, study);
        // In units of the standard deviation of one estimate.
        let shift = smallest_shift(1.0, self.replicates, m);
        let seen = |variance: f64| if variance.is_finite() { shift * variance.sqrt() } else { f64::INFINITY };
        let mean = mean_of(prepared, study)
            .map(|(value, margin)| (seen(self.contrast_variances[0]) + margin) / value)
            .map(scaled);
        let point = well_lit(prepared, study)
            .map(|(p, value, margin)| (seen(self.point_variances[p]) + margin) / value)
            .map(scaled)
            .reduce(f64::max);
        SmallestBiases { mean, point }
    }
}

/// Replicates that a cell's rays allow.
pub(super) fn most_replicates(prepared: &Prepared, samples: u64) -> u64 {
    let rays = prepared.estimator.rays_per_estimate(samples) * prepared.exact.len() as u64;
    (MOST_RAYS / rays.max(1)).max(FEWEST_REPLICATES)
}

/// Variance over the square of the shift to be seen; infinite where none can be.
fn relative_variance((shift, variance): (f64, f64)) -> f64 {
    if shift > 0.0 { variance / (shift * shift) } else { f64::INFINITY }
}

/// A bias that scales each estimate by 1 + s scales its spread, too: where a plain shift of s₀ would be caught, this
/// takes s with s = s₀ (1 + s). From nine tenths on, where nothing is promised any more, a number stands for "more": 10 s₀.
fn scaled(shift: f64) -> f64 {
    shift / (1.0 - shift.min(0.9))
}

/// The plain shift that must be caught for a scaling to be.
fn before_scaling(scaling: f64) -> f64 {
    scaling / (1.0 + scaling)
}

/// Exact mean over the points and the half-width within which no deviation counts, W/m².
fn mean_of(prepared: &Prepared, study: &Study) -> Option<(f64, f64)> {
    let value = prepared.contrasts.exact[0];
    (value > 0.0).then(|| (value, margin(prepared, study, &prepared.contrasts.weights[0])))
}

/// Half-width of the exact interval of a weighted sum: stated bounds, rounding of the estimates, tolerance.
pub(super) fn margin(prepared: &Prepared, study: &Study, weights: &[f64]) -> f64 {
    weights.iter().enumerate().map(|(p, w)| w.abs() * point_margin(prepared, p, study)).sum()
}

/// The same for one point.
pub(super) fn point_margin(prepared: &Prepared, p: usize, study: &Study) -> f64 {
    // An estimate is a sum of positive terms, each off by a few roundings.
    const ROUNDING: f64 = 16.0 * f64::EPSILON;
    let value = prepared.exact[p];
    let bound = prepared.truths[p].bound.watts_per_square_metre();
    bound + ROUNDING * (value + prepared.grazing[p]) + study.tolerance * value
}

/// Points that a tenth or more of the light reaches: index, exact value, half-width, W/m².
fn well_lit<'a>(prepared: &'a Prepared, study: &'a Study) -> impl Iterator<Item = (usize, f64, f64)> + 'a {
    prepared.truths.iter().enumerate().filter_map(move |(p, truth)| {
        let value = truth.irradiance.watts_per_square_metre();
        let lit = value > 0.0 && value >= WELL_LIT * prepared.full[p];
        lit.then(|| (p, value, point_margin(prepared, p, study)))
    })
}

/// A pilot's variance plus two of its standard errors.
pub(super) fn upper_variance(sums: &PowerSums) -> f64 {
    let variance = sums.variance().unwrap_or(0.0);
    let spread = sums.kurtosis().map_or(0.0, |kurtosis| ((kurtosis - 1.0) / sums.count() as f64).sqrt());
    variance * (1.0 + 2.0 * spread)
}
