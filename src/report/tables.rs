//! The tables of a report: what stands in each column, and where it comes from.

use super::column::{Column, Field, Table};
use crate::oracle::Truth;
use crate::trial::{
    CaseOutcome, Cell, Correlation, JudgedProperty, Measured, Rate, RunOutcome, StrategyOutcome, Timing,
};

/// A column, written as one line: name, unit, meaning, value.
macro_rules! column {
    ($name:literal, $unit:literal, $meaning:literal, |$row:pat_param| $value:expr) => {
        Column { name: $name, unit: $unit, meaning: $meaning, value: |$row| Field::from($value) }
    };
}
pub(super) use column;

/// A row below a case: something that one strategy found.
pub(super) struct Of<'a, T> {
    pub case: &'a CaseOutcome,
    pub strategy: &'a StrategyOutcome,
    pub item: &'a T,
}

/// All that strategies found, in the order of the report.
pub(super) fn each<'a, T: 'a>(
    outcome: &'a RunOutcome,
    items: fn(&'a StrategyOutcome) -> &'a [T],
) -> impl Iterator<Item = Of<'a, T>> {
    outcome.cases.iter().flat_map(move |case| {
        case.strategies
            .iter()
            .flat_map(move |strategy| items(strategy).iter().map(move |item| Of { case, strategy, item }))
    })
}

/// One point of one cell.
pub(super) struct ConvergenceRow<'a> {
    case: &'a CaseOutcome,
    strategy: &'a StrategyOutcome,
    cell: &'a Cell,
    point: usize,
    truth: &'a Truth,
    measured: &'a Measured,
}

pub(super) fn convergence_rows(outcome: &RunOutcome) -> impl Iterator<Item = ConvergenceRow<'_>> {
    each(outcome, |s| &s.cells).flat_map(|Of { case, strategy, item: cell }| {
        let points = case.truths.iter().zip(&cell.points).enumerate();
        points.map(move |(point, (truth, measured))| ConvergenceRow { case, strategy, cell, point, truth, measured })
    })
}

pub(super) fn convergence<'a>() -> Table<ConvergenceRow<'a>> {
    Table {
        file: "convergence.csv",
        row: "one measurement point, under one strategy, with one sample count",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name: its file's path below the folder given, without `.toml`", |r| r
                .case
                .name
                .as_str()),
            column!(
                "strategy",
                "",
                "how points on the sources were chosen: `random`, `correlated`, `stratified`",
                |r| r.strategy.name()
            ),
            column!("point", "", "which measurement point, from 0, in the case's order", |r| r.point),
            column!("x_m", "m", "where the point is", |r| r.case.points[r.point].position().x),
            column!("y_m", "m", "where the point is", |r| r.case.points[r.point].position().y),
            column!("z_m", "m", "where the point is", |r| r.case.points[r.point].position().z),
            column!(
                "region",
                "",
                "`lit` (sees every source wholly), `penumbra`, `umbra`, `below_horizon`, or `edge` where \
                the exact side cannot tell within its bound",
                |r| r.truth.region.name()
            ),
            column!("samples", "", "points on each source that one estimate uses, N", |r| r.cell.samples),
            column!("replicates", "", "independent estimates that were made", |r| r.cell.replicates),
            column!("exact_irradiance_W_m2", "W/m²", "the exact value", |r| r
                .truth
                .irradiance
                .watts_per_square_metre()),
            column!("exact_bound_W_m2", "W/m²", "the exact value is off by no more than this", |r| r
                .truth
                .bound
                .watts_per_square_metre()),
            column!("mean_irradiance_W_m2", "W/m²", "mean of the estimates over the replicates", |r| r
                .measured
                .mean),
            column!("bias_W_m2", "W/m²", "that mean less the exact value", |r| r.measured.bias),
            column!("bias_std_error_W_m2", "W/m²", "standard error of the bias", |r| r.measured.bias_std_error),
            column!(
                "variance_W2_m4",
                "W²/m⁴",
                "variance of one estimate, over the replicates (divisor n − 1)",
                |r| r.measured.variance
            ),
            column!(
                "variance_low",
                "W²/m⁴",
                "lower end of the variance's 95 % interval; empty where fewer than thirty rays of the rarer kind (that arrive, or that are blocked) are expected",
                |r| r.measured.variance_interval.map(|interval| interval.low)
            ),
            column!("variance_high", "W²/m⁴", "upper end of the same", |r| r
                .measured
                .variance_interval
                .map(|interval| interval.high)),
            column!(
                "predicted_variance_W2_m4",
                "W²/m⁴",
                "variance of one estimate as the exact side predicts it; empty \
                where it is not predicted",
                |r| r.measured.predicted_variance
            ),
            column!("mse_W2_m4", "W²/m⁴", "mean squared error of one estimate against the exact value", |r| r
                .measured
                .mse),
        ],
        more: &[],
    }
}

pub(super) fn rate_rows(outcome: &RunOutcome) -> impl Iterator<Item = Of<'_, Rate>> {
    each(outcome, |s| &s.rates)
}

pub(super) fn rates<'a>() -> Table<Of<'a, Rate>> {
    Table {
        file: "rates.csv",
        row: "how one quantity falls with the sample count N, under one strategy, over the points of one region",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name.as_str()),
            column!("strategy", "", "the strategy's name", |r| r.strategy.name()),
            column!("quantity", "", "what falls: `variance` (the mean over the region's points)", |r| r
                .item
                .quantity),
            column!("region", "", "which points: `all` that light reaches, or those of one region", |r| r
                .item
                .region
                .map_or("all", |region| region.name())),
            column!("slope", "", "of log quantity over log N, fitted", |r| r.item.slope),
            column!("slope_low", "", "lower end of the slope's 95 % interval", |r| r.item.slope_low),
            column!("slope_high", "", "upper end of the slope's 95 % interval", |r| r.item.slope_high),
            column!(
                "expected_slope",
                "",
                "the same fit of the predicted variances over the same N; the asymptote (-1, -3/2, -2) where they are not predicted",
                |r| r.item.expected_slope
            ),
            column!(
                "verdict",
                "",
                "`fail` where the expected slope lies outside the interval that covers with probability 1 - 1e-6, `undecided` where the 95 % interval is wider than 0.5, else `pass`; `not_judged` where nothing is predicted",
                |r| r.item.verdict.map_or("not_judged", |verdict| verdict.name())
            ),
        ],
        more: &[],
    }
}

pub(super) fn correlation_rows(outcome: &RunOutcome) -> impl Iterator<Item = Of<'_, Correlation>> {
    each(outcome, |s| &s.correlations)
}

pub(super) fn correlation<'a>() -> Table<Of<'a, Correlation>> {
    Table {
        file: "correlation.csv",
        row: "how the errors of points at one separation go together, under one strategy, with one sample count",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name.as_str()),
            column!("strategy", "", "the strategy's name", |r| r.strategy.name()),
            column!("samples", "", "points on each source that one estimate uses, N", |r| r.item.samples),
            column!("separation_m", "m", "distance between the two points of a pair", |r| r.item.separation),
            column!("correlation", "", "of the two points' errors over the replicates, in [−1, 1]", |r| r
                .item
                .correlation),
            column!("low", "", "lower end of the correlation's 95 % interval", |r| r.item.low),
            column!("high", "", "upper end of the correlation's 95 % interval", |r| r.item.high),
            column!(
                "predicted",
                "",
                "the correlation as the exact side predicts it; empty where it is not predicted",
                |r| r.item.predicted
            ),
        ],
        more: &[],
    }
}

/// One verdict.
pub(super) struct VerdictRow<'a> {
    case: &'a CaseOutcome,
    strategy: &'a str,
    item: &'a JudgedProperty,
}

pub(super) fn verdict_rows(outcome: &RunOutcome) -> impl Iterator<Item = VerdictRow<'_>> {
    outcome
        .cases
        .iter()
        .flat_map(|case| case.verdicts().map(move |(strategy, item)| VerdictRow { case, strategy, item }))
}

pub(super) fn verdicts<'a>() -> Table<VerdictRow<'a>> {
    Table {
        file: "verdicts.csv",
        row: "one verdict: one property of one strategy in one case",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name.as_str()),
            column!(
                "strategy",
                "",
                "the strategy's name; `light` for what was followed from the sources, `eye_paths` and `next_event` for paths from the points",
                |r| r.strategy
            ),
            column!(
                "property",
                "",
                "what was judged: `bias`, `variance` (squared errors against their prediction) or `covariance` (the same of the mean and of contrasts over the points); of light `energy` (the books) or `caustic` (rings against their exact flux); of paths `indirect` (what comes by mirrors, glass and diffuse surfaces)",
                |r| r.item.property
            ),
            column!("verdict", "", "`pass`, `fail` or `undecided`", |r| r.item.verdict.name()),
            column!(
                "evidence",
                "",
                "log10 of the test's capital; a correct estimator reaches x with probability at most \
                10⁻ˣ",
                |r| r.item.evidence
            ),
            column!("threshold", "", "log10 of the capital at which a verdict fails", |r| r.item.threshold),
            column!("effect", "", "relative deviation, of the mean over the points or of what failed worst", |r| r
                .item
                .effect),
            column!("effect_low", "", "lower end of the effect's 95 % interval", |r| r.item.effect_low),
            column!("effect_high", "", "upper end of the effect's 95 % interval", |r| r.item.effect_high),
            column!(
                "smallest_bias_mean",
                "",
                "relative bias of the mean over the points that would have been caught with \
                99 % probability; empty where no light is due",
                |r| r.item.smallest_bias_mean
            ),
            column!(
                "smallest_bias_point",
                "",
                "the same at the worst point that a tenth or more of the light reaches",
                |r| r.item.smallest_bias_point
            ),
            column!("reproduce", "", "the command line that gives the same verdict", |r| r.item.reproduce.as_str()),
        ],
        more: &[],
    }
}

/// One stage of one case; `strategy` is `None` for what belongs to no strategy.
pub(super) struct TimingRow<'a> {
    case: &'a CaseOutcome,
    strategy: Option<&'a StrategyOutcome>,
    timing: &'a Timing,
}

pub(super) fn timing_rows(outcome: &RunOutcome) -> impl Iterator<Item = TimingRow<'_>> {
    outcome.cases.iter().flat_map(|case| {
        let shared = case.timings.iter().map(move |timing| TimingRow { case, strategy: None, timing });
        let own = case.strategies.iter().flat_map(move |strategy| {
            strategy.timings.iter().map(move |timing| TimingRow { case, strategy: Some(strategy), timing })
        });
        let light = case.light.iter().map(move |light| TimingRow { case, strategy: None, timing: &light.timing });
        let paths = case.paths.iter().flat_map(|paths| &paths.timings);
        let paths = paths.map(move |timing| TimingRow { case, strategy: None, timing });
        shared.chain(own).chain(light).chain(paths)
    })
}

pub(super) fn timings<'a>() -> Table<TimingRow<'a>> {
    Table {
        file: "timings.csv",
        row: "one stage of the work; with `timings.html`, the page made from it, all that differs from run to run",
        case: |r| &r.case.name,
        columns: vec![
            column!("case", "", "the case's name", |r| r.case.name.as_str()),
            column!("strategy", "", "the strategy's name; empty for a stage that belongs to none", |r| r
                .strategy
                .map(|s| s.name())),
            column!("stage", "", "which part of the work", |r| r.timing.stage),
            column!("rays", "", "shadow rays, exact evaluations or estimates that it went through", |r| r
                .timing
                .rays),
            column!("seconds", "s", "processor time, summed over threads", |r| r.timing.seconds),
            column!("per_ray_ns", "ns", "processor time for one of them; empty where none was made", |r| {
                (r.timing.rays > 0).then(|| r.timing.seconds * 1e9 / r.timing.rays as f64)
            }),
            column!(
                "efficiency",
                "m⁴/(W² s)",
                "1 / (variance × time) of one estimate at the largest N, or of one path; of `caustic_by_map` and \
                `caustic_by_eye_paths`, of a picture with the map's texels, variance averaged over them; empty where nothing \
                is estimated or found",
                |r| r.timing.efficiency
            ),
        ],
        more: &[],
    }
}
