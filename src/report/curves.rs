//! The tables of what variance curves and biases are drawn from: means over points.

use super::column::{Column, Field, Table};
use super::tables::{Of, column, each};
use crate::trial::{Cell, Rate, RatePoint, RunOutcome};

/// One point of one curve.
pub(super) struct CurveRow<'a> {
    of: Of<'a, Rate>,
    point: RatePoint,
}

pub(super) fn curve_rows(outcome: &RunOutcome) -> impl Iterator<Item = CurveRow<'_>> {
    each(outcome, |s| &s.rates).flat_map(|Of { case, strategy, item }| {
        item.points.iter().map(move |point| CurveRow { of: Of { case, strategy, item }, point: *point })
    })
}

pub(super) fn curves<'a>() -> Table<CurveRow<'a>> {
    Table {
        file: "curves.csv",
        row: "one point of a variance curve: the mean over the points of one region, under one strategy, with one sample count; `rates.csv` holds the slopes fitted to them",
        case: |r| &r.of.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.of.case.name.as_str()),
            column!("strategy", "", "the strategy's name", |r| r.of.strategy.name()),
            column!("quantity", "", "what falls: `variance`", |r| r.of.item.quantity),
            column!("region", "", "which points: `all` that light reaches, or those of one region", |r| r
                .of
                .item
                .region
                .map_or("all", |region| region.name())),
            column!("samples", "", "points on each source that one estimate uses, N", |r| r.point.samples),
            column!("value_W2_m4", "W²/m⁴", "mean over the points of the variance of one estimate", |r| r
                .point
                .value),
            column!("low_W2_m4", "W²/m⁴", "lower end of its 95 % interval", |r| r.point.low),
            column!("high_W2_m4", "W²/m⁴", "upper end of the same", |r| r.point.high),
            column!("fitted_W2_m4", "W²/m⁴", "what the fitted line has there", |r| {
                (r.of.item.intercept + r.of.item.slope * (r.point.samples as f64).ln()).exp()
            }),
            column!("asymptotic_slope", "", "the slope that theory gives for large N", |r| r.of.item.asymptote),
        ],
        more: &[],
    }
}

pub(super) fn mean_rows(outcome: &RunOutcome) -> impl Iterator<Item = Of<'_, Cell>> {
    each(outcome, |s| &s.cells)
}

pub(super) fn means<'a>() -> Table<Of<'a, Cell>> {
    Table {
        file: "means.csv",
        row: "the mean over all points of a case, under one strategy, with one sample count",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name.as_str()),
            column!("strategy", "", "the strategy's name", |r| r.strategy.name()),
            column!("samples", "", "points on each source that one estimate uses, N", |r| r.item.samples),
            column!("replicates", "", "independent estimates that were made", |r| r.item.replicates),
            column!("exact_irradiance_W_m2", "W/m²", "the exact values' mean", |r| {
                let sum: f64 = r.case.truths.iter().map(|truth| truth.irradiance.watts_per_square_metre()).sum();
                sum / r.case.truths.len() as f64
            }),
            column!("bias_W_m2", "W/m²", "the estimates' mean less that", |r| r.item.mean_bias),
            column!(
                "bias_std_error_W_m2",
                "W/m²",
                "its standard error, over the replicates: points may err together",
                |r| r.item.mean_bias_std_error
            ),
        ],
        more: &[],
    }
}
