//! How variance falls with the number of samples.

use super::measure::{BATCHES, CellSums, Prepared};
use super::outcome::{Rate, RatePoint};
use super::plan::CellPlan;
use super::rare::is_rare_together;
use crate::oracle::Region;
use crate::oracle::variance::Spread;
use crate::sampling::{PointSet, Seams, Strategy, Surface};
use crate::statistics::Verdict;
use crate::statistics::evidence::ALPHA;
use crate::statistics::interval::{Interval, student_quantile};
use crate::statistics::slope::{Line, Noise};

const LEVEL: f64 = 0.95;
/// A slope's interval wider than this decides nothing: it tells −1 from −3/2 no more.
const WIDEST_SLOPE: f64 = 0.5;

/// One rate for all points that light reaches, and one for each region with at least two of them.
pub(super) fn rates(prepared: &Prepared, strategy: Strategy, cells: &[CellSums], plans: &[CellPlan]) -> Vec<Rate> {
    let reached = |p: &usize| prepared.exact[*p] > 0.0;
    let all: Vec<usize> = (0..prepared.exact.len()).filter(reached).collect();
    let mut rates = Vec::from_iter(rate(prepared, strategy, cells, plans, None, &all));
    for region in [Region::Lit, Region::Penumbra] {
        let points: Vec<usize> = all.iter().copied().filter(|p| prepared.truths[*p].region == region).collect();
        if points.len() >= 2 {
            rates.extend(rate(prepared, strategy, cells, plans, Some(region), &points));
        }
    }
    rates
}

/// `None` where fewer than two sample counts have a variance, and events enough to tell how sure it is.
fn rate(
    prepared: &Prepared,
    strategy: Strategy,
    cells: &[CellSums],
    plans: &[CellPlan],
    region: Option<Region>,
    points: &[usize],
) -> Option<Rate> {
    let mut curve = Vec::new();
    let (mut x, mut y, mut noise) = (Vec::new(), Vec::new(), Vec::new());
    let mut predicted = Some(Vec::new());
    for (cell, plan) in cells.iter().zip(plans) {
        let mean_over_points =
            |value: &dyn Fn(usize) -> f64| points.iter().map(|p| value(*p)).sum::<f64>() / points.len() as f64;
        let value = mean_over_points(&|p| cell.points[p].variance().unwrap_or(0.0));
        let spreads = points.iter().map(|p| (&cell.points[*p], plan.prediction.alike[*p]));
        let is_rare = is_rare_together(spreads, strategy.shares_points(), cell.replicates);
        if value <= 0.0 || cell.batches.len() < 2 || is_rare {
            continue;
        }
        // Points of one replicate may err together; batches of replicates do not.
        let batches: Vec<f64> = cell.batches.iter().map(|batch| mean_over_points(&|p| batch[p])).collect();
        let middle = batches.iter().sum::<f64>() / batches.len() as f64;
        let spread = batches.iter().map(|b| (b - middle) * (b - middle)).sum::<f64>() / (batches.len() - 1) as f64;
        let measured = spread / batches.len() as f64 / (middle * middle);
        // Heavy tails need not have shown in the batches; what is known of them counts.
        let known = if strategy.shares_points() { 0.0 } else { known_noise(points, plan) };
        let relative = measured.max(known).sqrt();
        // Intervals of a positive quantity, on the logarithmic scale.
        let factor = (student_quantile(LEVEL, freedom(cell))? * relative).exp();
        curve.push(RatePoint { samples: cell.samples, value, low: value / factor, high: value * factor });
        x.push((cell.samples as f64).ln());
        y.push(value.ln());
        let sum: Option<f64> = points.iter().map(|p| Some(plan.prediction.points[*p]?.spread.variance)).sum();
        match (&mut predicted, sum) {
            (Some(list), Some(sum)) if sum > 0.0 => list.push((sum / points.len() as f64).ln()),
            _ => predicted = None,
        }
        // Batches that agree to the last digit (a variance known without noise) still leave rounding.
        noise.push((relative * relative).max(1e-24));
    }
    let line = Line::through(&x, &y, Noise::Known { variances: &noise }).ok()?;
    let slope_error = line.slope_std_error?;
    // Each noise is itself measured, from the batches: Student's t of a single one, which is on the safe side for several.
    let least = cells.iter().map(freedom).reduce(f64::min)?;
    let around = |level: f64| {
        let reach = student_quantile(level, least)? * slope_error;
        Some(Interval { low: line.slope - reach, high: line.slope + reach })
    };
    let interval = around(LEVEL)?;
    // The same fit, with the same weights, of what is predicted: a finite range is not the asymptote.
    let expected = predicted
        .as_ref()
        .and_then(|y| Line::through(&x, y, Noise::Known { variances: &noise }).ok())
        .map(|line| line.slope);
    let asymptote = asymptote(prepared, strategy, points);
    let surely = around(1.0 - ALPHA)?;
    let verdict = expected.map(|expected| match surely.contains(expected) {
        false => Verdict::Fail,
        true if interval.width() <= WIDEST_SLOPE => Verdict::Pass,
        true => Verdict::Undecided,
    });
    Some(Rate {
        quantity: "variance",
        region,
        slope: line.slope,
        slope_low: interval.low,
        slope_high: interval.high,
        intercept: line.intercept,
        expected_slope: expected.unwrap_or(asymptote),
        asymptote,
        verdict,
        points: curve,
    })
}

/// Relative variance, as predicted, of the mean over fresh points of their measured variances; 0 where nothing is.
fn known_noise(points: &[usize], plan: &CellPlan) -> f64 {
    let spreads: Option<Vec<Spread>> = points.iter().map(|p| plan.prediction.alike[*p]).collect();
    let spreads = spreads.unwrap_or_default();
    let total: f64 = spreads.iter().map(|spread| spread.variance).sum();
    // A squared deviation has the variance E d⁴ − v².
    let squares = |spread: &Spread| spread.variance * spread.variance * (spread.kurtosis() - 1.0);
    let noise: f64 = spreads.iter().map(squares).sum();
    if total > 0.0 { noise / (total * total) / plan.replicates as f64 } else { 0.0 }
}

/// Degrees of freedom of a cell's noise.
fn freedom(cell: &CellSums) -> f64 {
    (cell.batches.len() - 1).max(1) as f64
}

/// The slope that theory gives for large N, by what the integrand is over the unit square:
///
/// | point set | smooth | creased | torn | jumps along a line | source |
/// |---|---|---|---|---|---|
/// | independent, Latin hypercube | −1 | −1 | −1 | −1 | Stein 1987: only a sum of functions of u and of v falls faster |
/// | uniform jitter | −1 | −1 | −1 | −1 | the whole grid errs with its shift: by the mean slope, or by a row along an edge |
/// | stratified, multi-jittered | −2 | −2 | −2 | −3/2 | Mitchell, SIGGRAPH 1996 |
/// | Sobol', Owen-scrambled | −3 | −5/2 | −2 | −3/2 | Owen, Ann. Statist. 25, 1997, but a logarithm; He & Wang, Math. Comp. 84, 2015 |
///
/// Creased and torn: [`Seams`] of the map from the square to a source, of N = 4ᵏ ≤ 1024 strata that are then compact parts of
/// it. (Creases along diagonals, crossed by 2ᵃ of the 4ᵃ boxes of side 2⁻ᵃ, have mixed differences of 2⁻ᵃ there: a variance of
/// 2ᵃ 4⁻ᵃ 4⁻ᵃ / N, with N = 4ᵃ.) It jumps along a line where a shadow's edge cuts the source.
fn asymptote(prepared: &Prepared, strategy: Strategy, points: &[usize]) -> f64 {
    let cut = points.iter().any(|p| prepared.truths[*p].shadow_edge);
    let sources = prepared.case.configuration.sources().iter();
    let seams = sources.filter_map(|source| Surface::new(source.shape())).map(|surface| surface.seams()).max();
    match strategy.point_set() {
        PointSet::Independent | PointSet::LatinHypercube | PointSet::UniformJitter => -1.0,
        PointSet::Stratified | PointSet::MultiJittered | PointSet::Sobol if cut => -1.5,
        PointSet::Stratified | PointSet::MultiJittered => -2.0,
        PointSet::Sobol => match seams {
            None | Some(Seams::None) => -3.0,
            Some(Seams::Creased) => -2.5,
            Some(Seams::Torn) => -2.0,
        },
    }
}

/// Batches must exist for the smallest plan.
const _: () = assert!(BATCHES >= 2);
