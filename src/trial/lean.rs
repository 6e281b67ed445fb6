//! What a verdict on somebody else's estimates leans on: nothing predicts how those spread.
//!
//! A pilot of its own, whose estimates are not judged, stands in; or a bound that somebody states, such as the variance of
//! `random`. Where the pilot is too small to tell (a sliver of visible source that it may not have hit, rare and large
//! contributions), what independent samples could have is taken instead: the larger of
//!
//! - the variance of N independent points by area, which the exact side knows;
//! - M E / N with the largest exitance M: no smaller than that of N directions, none of which brings more than M.
//!
//! A variance that is stated too small makes the test rasher, within limits: half of the true one raises the probability of a
//! false alarm from 10⁻⁶ to some 10⁻⁵, and none at all to some 10⁻³, since the test measures the spread along with the mean.

use super::measure::{CellSums, Prepared};
use super::plan::upper_variance;
use super::reach::peak;
use crate::case::Study;
use crate::oracle::Region;
use crate::oracle::variance::Spread;
use crate::sampling::{Strategy, Technique};
use crate::statistics::PowerSums;

/// Where the variances come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Leaning {
    /// A pilot run: estimates that are not judged tell how those spread that are.
    #[default]
    Pilot,
    /// Whoever is judged says so: no estimate varies more than that of as many independent points by area.
    Random,
}

impl Leaning {
    /// In a sentence, for people.
    pub(super) fn words(self, pilots: &[u64]) -> String {
        match self {
            Leaning::Pilot => {
                let (fewest, most) = (pilots.iter().min(), pilots.iter().max());
                let count = match (fewest, most) {
                    (Some(fewest), Some(most)) if fewest != most => format!("{fewest} to {most}"),
                    (fewest, _) => fewest.copied().unwrap_or(0).to_string(),
                };
                format!(
                    "the variance is not predicted: this leans on a pilot of {count} replicates that were not judged, \
                     taken two standard errors high"
                )
            }
            Leaning::Random => {
                "the variance is not predicted: this leans on the statement that it is no larger than that \
                                of `random` with as many samples"
                    .to_owned()
            }
        }
    }
}

/// Upper variances of one cell: at each point, and of each contrast, W²/m⁴; and the spreads of independent points.
pub(super) struct Variances {
    pub points: Vec<f64>,
    pub contrasts: Vec<f64>,
    pub alike: Vec<Option<Spread>>,
}

/// - `index`: of the sample count in the study
/// - `shared`: whether the points of a replicate may err together, by the same random numbers
/// - `pilot`: where it is leant on
pub(super) fn variances(
    prepared: &Prepared,
    study: &Study,
    index: usize,
    shared: bool,
    pilot: Option<&CellSums>,
) -> Variances {
    let weights = &prepared.contrasts.weights;
    let random = prepared.predictions.cell(Strategy::Random, study, index, weights);
    let alike = random.alike;
    let random = random.points.iter().enumerate().map(|(p, predicted)| {
        let ceiling = || {
            let point = &prepared.case.configuration.points()[p];
            let peak = peak(&prepared.case.configuration, point, Technique::Area);
            if prepared.exact[p] > 0.0 { peak * prepared.exact[p] / study.samples[index] as f64 } else { 0.0 }
        };
        predicted.map_or_else(ceiling, |predicted| predicted.upper_variance())
    });
    let random = random.collect::<Vec<f64>>();
    let Some(pilot) = pilot else {
        let contrasts = weights.iter().map(|row| of_sum(row, &random, shared)).collect();
        return Variances { points: random, contrasts, alike };
    };
    let largest = prepared.case.configuration.sources().iter().map(|source| source.largest_exitance());
    let largest = largest.map(|exitance| exitance.watts_per_square_metre()).fold(0.0, f64::max);
    let points: Vec<f64> = (0..prepared.exact.len())
        .map(|p| {
            let truth = &prepared.truths[p];
            let most = prepared.exact[p] + truth.bound.watts_per_square_metre();
            if most == 0.0 {
                // Where no light is due none may come: no spread excuses it.
                return 0.0;
            }
            let sums = &pilot.points[p];
            let uncut = truth.region == Region::Lit && !truth.shadow_edge;
            let tame = match sums.kurtosis() {
                None => uncut && sums.mean().is_some_and(|mean| mean != 0.0),
                Some(kurtosis) => (kurtosis - 3.0) * FEWEST_EVENTS <= sums.count() as f64,
            };
            let seen = upper(sums);
            if tame { seen } else { seen.max(random[p]).max(largest * most / study.samples[index] as f64) }
        })
        .collect();
    let unseen: Vec<f64> = points.iter().zip(&pilot.points).map(|(v, sums)| (v - upper(sums)).max(0.0)).collect();
    let contrasts = pilot.contrasts.iter().zip(weights);
    let contrasts = contrasts.map(|(sums, row)| {
        let (seen, unseen) = (upper(sums), of_sum(row, &unseen, shared));
        if shared { (seen.sqrt() + unseen.sqrt()).powi(2) } else { seen + unseen }
    });
    Variances { contrasts: contrasts.collect(), points, alike }
}

/// With fewer events of the rarer kind a pilot's variance is no more than a guess (as in `rare`).
const FEWEST_EVENTS: f64 = 30.0;

/// Of a weighted sum over points: independent ones, or in the worst case.
fn of_sum(weights: &[f64], variances: &[f64], shared: bool) -> f64 {
    let terms = weights.iter().zip(variances);
    if shared {
        terms.map(|(w, v)| w.abs() * v.sqrt()).sum::<f64>().powi(2)
    } else {
        terms.map(|(w, v)| w * w * v).sum()
    }
}

/// A pilot's variance on the high side: by two standard errors as measured, and as normal data have it, which a small
/// sample cannot hide (Wilson & Hilferty 1931: χ²/ν is about (1 − 2/9ν + z √(2/9ν))³).
fn upper(sums: &PowerSums) -> f64 {
    let freedom = sums.count().saturating_sub(1).max(1) as f64;
    let ninth = 2.0 / (9.0 * freedom);
    let least = (1.0 - ninth - 2.0 * ninth.sqrt()).max(0.1).powi(3);
    upper_variance(sums).max(sums.variance().unwrap_or(0.0) / least)
}

#[cfg(feature = "studies")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Draws;
    use crate::statistics::budget::{plausible, seed_of};

    #[test]
    fn a_pilot_is_taken_high() {
        // Sums of twelve uniforms have variance 1; below it should fall no more than some 2.5 %.
        let mut draws = Draws::new(seed_of("a_pilot_is_taken_high"));
        for count in [8, 32, 128] {
            let below = (0..4000).filter(|_| {
                let mut sums = PowerSums::about(6.0);
                (0..count).for_each(|_| sums.add((0..12).map(|_| draws.unit()).sum()));
                upper(&sums) < 1.0
            });
            assert!(plausible(below.count() as u64, 4000, 0.0, 0.026), "{count}");
        }
    }

    #[test]
    fn errors_that_go_together_are_allowed_for() {
        let (weights, variances) = ([0.5, -0.5], [4.0, 4.0]);
        assert_eq!(of_sum(&weights, &variances, false), 2.0);
        assert_eq!(of_sum(&weights, &variances, true), 4.0);
    }
}
