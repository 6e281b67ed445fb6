//! Do the errors of neighbouring points move together?

use super::measure::{CellSums, Prepared};
use super::outcome::Correlation;
use super::plan::CellPlan;
use super::rare::is_rare;
use crate::configuration::{Arrangement, Configuration};
use crate::sampling::Strategy;
use crate::statistics::correlation::{fisher, from_left_out};

/// Groups of replicates for the delete-a-group jackknife.
const GROUPS: usize = 16;
const LEVEL: f64 = 0.95;
/// Separations of scattered points are gathered into this many bins.
const BINS: usize = 32;
/// Scattered points beyond this many are thinned evenly: pairs grow with the square.
const MOST_POINTS: usize = 128;

/// Pairs of points at one separation.
struct Separation {
    metres: f64,
    pairs: Vec<(usize, usize)>,
}

/// Correlation of the errors against separation, for each cell: the mean over the pairs at that separation, with a
/// jackknife interval over the replicates on Fisher's scale. Points whose estimates never vary, or vary by events that are
/// too rare among the replicates that were kept, take no part.
pub(super) fn correlations(
    prepared: &Prepared,
    strategy: Strategy,
    cells: &[CellSums],
    plans: &[CellPlan],
) -> Vec<Correlation> {
    let separations = separations(&prepared.case.configuration);
    let n_points = prepared.exact.len();
    let mut found = Vec::new();
    for (cell, plan) in cells.iter().zip(plans) {
        let rows = cell.kept.len() / n_points;
        if rows < 2 * GROUPS {
            continue;
        }
        let groups: Vec<&[f64]> = {
            let edge = |g: usize| g * rows / GROUPS * n_points;
            (0..GROUPS).map(|g| &cell.kept[edge(g)..edge(g + 1)]).collect()
        };
        let takes_part: Vec<bool> = (cell.points.iter().zip(&plan.prediction.alike).zip(prepared.exact))
            .map(|((sums, predicted), exact)| *exact > 0.0 && !is_rare(sums, *predicted, rows as u64))
            .collect();
        let predicted = predicted(prepared, strategy, &separations, &takes_part);
        // First and second moments of each group for each point, so that leaving a group out is a subtraction.
        let single: Vec<Vec<[f64; 2]>> = groups.iter().map(|g| point_sums(g, n_points)).collect();
        for (separation, predicted) in separations.iter().zip(&predicted) {
            let pair_sums: Vec<Vec<f64>> = groups
                .iter()
                .map(|group| {
                    separation
                        .pairs
                        .iter()
                        .map(|(i, j)| group.chunks_exact(n_points).map(|row| row[*i] * row[*j]).sum())
                        .collect()
                })
                .collect();
            let without = |left_out: Option<usize>| {
                let kept = || (0..GROUPS).filter(move |g| Some(*g) != left_out);
                let n: usize = kept().map(|g| groups[g].len() / n_points).sum();
                mean_correlation(
                    separation,
                    &takes_part,
                    n as f64,
                    &|p| kept().fold([0.0; 2], |sum, g| [sum[0] + single[g][p][0], sum[1] + single[g][p][1]]),
                    &|pair| kept().map(|g| pair_sums[g][pair]).sum(),
                )
            };
            let Some(correlation) = without(None) else { continue };
            let parts: Option<Vec<f64>> = (0..GROUPS).map(|g| without(Some(g)).map(fisher)).collect();
            let Some(parts) = parts else { continue };
            let Some(interval) = from_left_out(fisher(correlation), &parts, LEVEL) else { continue };
            found.push(Correlation {
                samples: cell.samples,
                separation: separation.metres,
                correlation,
                low: interval.low,
                high: interval.high,
                predicted: *predicted,
            });
        }
    }
    found
}

/// All pairs whose correlation is shown, in the order of their separations.
pub(super) fn pairs(configuration: &Configuration) -> Vec<(usize, usize)> {
    separations(configuration).into_iter().flat_map(|separation| separation.pairs).collect()
}

/// What the exact side predicts for each separation: the mean over the pairs whose both points take part; zero where points
/// are fresh.
fn predicted(
    prepared: &Prepared,
    strategy: Strategy,
    separations: &[Separation],
    takes_part: &[bool],
) -> Vec<Option<f64>> {
    let correlations = prepared.predictions.correlations(strategy);
    let mut rest = correlations.unwrap_or_default();
    separations
        .iter()
        .map(|separation| {
            if !strategy.shares_points() {
                return Some(0.0);
            }
            correlations?;
            let (own, others) = rest.split_at(separation.pairs.len());
            rest = others;
            let both = separation.pairs.iter().zip(own).filter(|((i, j), _)| takes_part[*i] && takes_part[*j]);
            let (sum, count) = both.fold((0.0, 0_u32), |(sum, count), (_, c)| (sum + c, count + 1));
            (count > 0).then(|| sum / f64::from(count))
        })
        .collect()
}

fn point_sums(rows: &[f64], n_points: usize) -> Vec<[f64; 2]> {
    let mut sums = vec![[0.0; 2]; n_points];
    for row in rows.chunks_exact(n_points) {
        for (sum, x) in sums.iter_mut().zip(row) {
            sum[0] += x;
            sum[1] += x * x;
        }
    }
    sums
}

/// Mean over the pairs of their correlation coefficient; `None` where no pair varies.
fn mean_correlation(
    separation: &Separation,
    takes_part: &[bool],
    n: f64,
    sums: &dyn Fn(usize) -> [f64; 2],
    products: &dyn Fn(usize) -> f64,
) -> Option<f64> {
    let (mut total, mut count) = (0.0, 0_u32);
    let pairs = separation.pairs.iter().enumerate();
    for (pair, (i, j)) in pairs.filter(|(_, (i, j))| takes_part[*i] && takes_part[*j]) {
        let ([s_i, q_i], [s_j, q_j]) = (sums(*i), sums(*j));
        let (v_i, v_j) = (q_i - s_i * s_i / n, q_j - s_j * s_j / n);
        if v_i > 1e-12 * q_i && v_j > 1e-12 * q_j {
            total += (products(pair) - s_i * s_j / n) / (v_i * v_j).sqrt();
            count += 1;
        }
    }
    (count > 0).then(|| (total / f64::from(count)).clamp(-1.0, 1.0))
}

/// Along a line: every multiple of the spacing. Else: pairs gathered by distance.
fn separations(configuration: &Configuration) -> Vec<Separation> {
    let points = configuration.points();
    let between = |i: usize, j: usize| (points[i].position() - points[j].position()).length();
    if configuration.arrangement() == Arrangement::Line {
        return (1..points.len())
            .map(|k| {
                let pairs: Vec<_> = (0..points.len() - k).map(|i| (i, i + k)).collect();
                let metres = pairs.iter().map(|(i, j)| between(*i, *j)).sum::<f64>() / pairs.len() as f64;
                Separation { metres, pairs }
            })
            .collect();
    }
    let step = points.len().div_ceil(MOST_POINTS).max(1);
    let mut pairs: Vec<(f64, (usize, usize))> = Vec::new();
    for i in (0..points.len()).step_by(step) {
        pairs.extend((i + step..points.len()).step_by(step).map(|j| (between(i, j), (i, j))));
    }
    let longest = pairs.iter().map(|(d, _)| *d).fold(0.0, f64::max);
    let mut bins: Vec<Vec<(f64, (usize, usize))>> = vec![Vec::new(); BINS];
    for pair in pairs {
        let share = if longest > 0.0 { pair.0 / longest } else { 0.0 };
        bins[((share * BINS as f64) as usize).min(BINS - 1)].push(pair);
    }
    bins.into_iter()
        .filter(|bin| !bin.is_empty())
        .map(|bin| Separation {
            metres: bin.iter().map(|(d, _)| d).sum::<f64>() / bin.len() as f64,
            pairs: bin.into_iter().map(|(_, pair)| pair).collect(),
        })
        .collect()
}
