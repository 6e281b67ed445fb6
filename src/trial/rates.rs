//! How variance falls with the number of samples.

use super::measure::{BATCHES, CellSums, Prepared};
use super::outcome::{Rate, RatePoint};
use crate::configuration::Source;
use crate::oracle::Region;
use crate::sampling::{Strategy, Surface};
use crate::statistics::slope::{Line, Noise};

const LEVEL: f64 = 0.95;
/// Two-sided 95 % of a normal distribution.
const Z_95: f64 = 1.959_963_984_540_054;

/// One rate for all points that light reaches, and one for each region with at least two of them.
pub(super) fn rates(prepared: &Prepared, strategy: Strategy, cells: &[CellSums]) -> Vec<Rate> {
    let reached = |p: &usize| prepared.exact[*p] > 0.0;
    let all: Vec<usize> = (0..prepared.exact.len()).filter(reached).collect();
    let mut rates = Vec::from_iter(rate(prepared, strategy, cells, None, &all));
    for region in [Region::Lit, Region::Penumbra] {
        let points: Vec<usize> = all.iter().copied().filter(|p| prepared.truths[*p].region == region).collect();
        if points.len() >= 2 {
            rates.extend(rate(prepared, strategy, cells, Some(region), &points));
        }
    }
    rates
}

/// `None` where fewer than two sample counts have a variance.
fn rate(
    prepared: &Prepared,
    strategy: Strategy,
    cells: &[CellSums],
    region: Option<Region>,
    points: &[usize],
) -> Option<Rate> {
    let mut curve = Vec::new();
    let (mut x, mut y, mut noise) = (Vec::new(), Vec::new(), Vec::new());
    for cell in cells {
        let mean_over_points =
            |value: &dyn Fn(usize) -> f64| points.iter().map(|p| value(*p)).sum::<f64>() / points.len() as f64;
        let value = mean_over_points(&|p| cell.points[p].variance().unwrap_or(0.0));
        if value <= 0.0 || cell.batches.len() < 2 {
            continue;
        }
        // Points of one replicate may err together; batches of replicates do not.
        let batches: Vec<f64> = cell.batches.iter().map(|batch| mean_over_points(&|p| batch[p])).collect();
        let middle = batches.iter().sum::<f64>() / batches.len() as f64;
        let spread = batches.iter().map(|b| (b - middle) * (b - middle)).sum::<f64>() / (batches.len() - 1) as f64;
        let relative = (spread / batches.len() as f64).sqrt() / middle;
        // Intervals of a positive quantity, on the logarithmic scale.
        let factor = (Z_95 * relative).exp();
        curve.push(RatePoint { samples: cell.samples, value, low: value / factor, high: value * factor });
        x.push((cell.samples as f64).ln());
        y.push(value.ln());
        // Batches that agree to the last digit (a variance known without noise) still leave rounding.
        noise.push((relative * relative).max(1e-24));
    }
    let line = Line::through(&x, &y, Noise::Known { variances: &noise }).ok()?;
    let interval = line.slope_interval(LEVEL)?;
    Some(Rate {
        quantity: "variance",
        region,
        slope: line.slope,
        slope_low: interval.low,
        slope_high: interval.high,
        intercept: line.intercept,
        expected_slope: asymptote(prepared, strategy, points),
        verdict: None,
        points: curve,
    })
}

/// The slope that theory gives for large N: −1 for independent points; for one jittered point per stratum −2 where the
/// integrand is smooth over the unit square and −3/2 where it jumps along a line (Mitchell, SIGGRAPH 1996): where a shadow's
/// edge cuts the source, or where the square is torn to cover it.
fn asymptote(prepared: &Prepared, strategy: Strategy, points: &[usize]) -> f64 {
    match strategy {
        Strategy::Random
        | Strategy::Correlated
        | Strategy::SolidAngle
        | Strategy::Cosine
        | Strategy::MisBalance
        | Strategy::MisPower => -1.0,
        Strategy::Stratified if points.iter().any(|p| prepared.truths[*p].shadow_edge) => -1.5,
        Strategy::Stratified if prepared.case.configuration.sources().iter().any(tears) => -1.5,
        Strategy::Stratified => -2.0,
    }
}

fn tears(source: &Source) -> bool {
    Surface::new(source.shape()).is_some_and(|surface| surface.is_torn())
}

/// Batches must exist for the smallest plan.
const _: () = assert!(BATCHES >= 2);
