//! What reports show of a cell.

use super::measure::CellSums;
use super::outcome::{Cell, Measured};
use super::plan::CellPlan;
use super::predict::CellPrediction;
use super::rare::is_rare;
use crate::statistics::interval;

const LEVEL: f64 = 0.95;

/// 1 / (variance × time) of one estimate, variance averaged over the points.
pub(super) fn efficiency(cell: &CellSums, n_points: usize) -> Option<f64> {
    let variance = cell.points.iter().filter_map(|sums| sums.variance()).sum::<f64>() / n_points as f64;
    let time = cell.seconds / (cell.replicates as f64 * n_points as f64);
    (variance * time > 0.0).then(|| 1.0 / (variance * time))
}

/// What reports show of a cell.
pub(super) fn shown(cell: &CellSums, plan: &CellPlan) -> Cell {
    let CellPrediction { points, alike, .. } = &plan.prediction;
    let points = cell.points.iter().zip(points).zip(alike).map(|((sums, predicted), alike)| {
        let variance = sums.variance().unwrap_or(0.0);
        let kurtosis = predicted.map_or(1.0, |predicted| predicted.spread.kurtosis());
        Measured {
            mean: sums.mean().unwrap_or(0.0),
            bias: sums.mean_deviation().unwrap_or(0.0),
            bias_std_error: sums.std_error().unwrap_or(0.0),
            variance,
            variance_interval: interval::of_variance_with(sums, kurtosis, LEVEL)
                .filter(|_| !is_rare(sums, *alike, cell.replicates)),
            predicted_variance: predicted.map(|predicted| predicted.spread.variance),
            mse: sums.mean_square_deviation().unwrap_or(0.0),
        }
    });
    Cell {
        samples: cell.samples,
        replicates: cell.replicates,
        seconds: cell.seconds,
        points: points.collect(),
        mean_bias: cell.contrasts[0].mean_deviation().unwrap_or(0.0),
        mean_bias_std_error: cell.contrasts[0].std_error().unwrap_or(0.0),
    }
}
