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

/// Correlation of the errors against separation, for one cell: the mean over the pairs at that separation, with a
/// jackknife interval over the replicates on Fisher's scale. Points whose estimates never vary, or vary by events that are
/// too rare among the replicates that were kept, take no part.
pub(super) fn correlations(
    prepared: &Prepared,
    strategy: Strategy,
    cell: &CellSums,
    plan: &CellPlan,
) -> Vec<Correlation> {
    let n_points = prepared.exact.len();
    let rows = cell.kept.len() / n_points;
    if rows < 2 * GROUPS {
        return Vec::new();
    }
    let separations = separations(&prepared.case.configuration);
    let takes_part: Vec<bool> = (cell.points.iter().zip(&plan.prediction.alike).zip(prepared.exact))
        .map(|((sums, predicted), exact)| *exact > 0.0 && !is_rare(sums, *predicted, rows as u64))
        .collect();
    let predicted = predicted(prepared, strategy, &separations, &takes_part);
    let kept = Kept::new(&cell.kept, n_points);
    let found = |(separation, predicted): (&Separation, &Option<f64>)| {
        let (correlation, parts) = kept.correlation(separation, &takes_part)?;
        let interval = from_left_out(fisher(correlation), &parts, LEVEL)?;
        let (metres, predicted) = (separation.metres, *predicted);
        let (low, high) = (interval.low, interval.high);
        Some(Correlation { samples: cell.samples, separation: metres, correlation, low, high, predicted })
    };
    separations.iter().zip(&predicted).filter_map(found).collect()
}

/// Estimates less exact values of the replicates that were kept, and what is needed of them for each group left out.
struct Kept<'a> {
    n_points: usize,
    /// `[replicate][point]` of each group.
    groups: Vec<&'a [f64]>,
    /// All groups, then all but each one.
    selections: Vec<Selection>,
}

/// Sums over groups, at each point.
struct Selection {
    left_out: Option<usize>,
    /// Replicates.
    n: f64,
    sums: Vec<f64>,
    /// Sum of squared deviations from the mean; nought where that is but rounding.
    spreads: Vec<f64>,
}

impl<'a> Kept<'a> {
    fn new(kept: &'a [f64], n_points: usize) -> Kept<'a> {
        let rows = kept.len() / n_points;
        let edge = |g: usize| g * rows / GROUPS * n_points;
        let groups: Vec<&[f64]> = (0..GROUPS).map(|g| &kept[edge(g)..edge(g + 1)]).collect();
        // First and second moments of each group at each point.
        let single: Vec<Vec<[f64; 2]>> = groups.iter().map(|g| point_sums(g, n_points)).collect();
        let selection = |left_out: Option<usize>| {
            let chosen = || (0..GROUPS).filter(move |g| Some(*g) != left_out);
            let n = chosen().map(|g| groups[g].len() / n_points).sum::<usize>() as f64;
            let mut moments = vec![[0.0; 2]; n_points];
            for g in chosen() {
                moments.iter_mut().zip(&single[g]).for_each(|(sum, more)| (0..2).for_each(|k| sum[k] += more[k]));
            }
            let spread = |[s, q]: &[f64; 2]| {
                let spread = q - s * s / n;
                if spread > 1e-12 * q { spread } else { 0.0 }
            };
            let spreads = moments.iter().map(spread).collect();
            Selection { left_out, n, sums: moments.into_iter().map(|[s, _]| s).collect(), spreads }
        };
        let selections = std::iter::once(None).chain((0..GROUPS).map(Some)).map(selection).collect();
        Kept { n_points, groups, selections }
    }

    /// The mean correlation at a separation, and Fisher's transform of the same without each group; `None` where no pair
    /// varies, in all or without one.
    fn correlation(&self, separation: &Separation, takes_part: &[bool]) -> Option<(f64, Vec<f64>)> {
        let pairs = &separation.pairs;
        let products: Vec<Vec<f64>> = self.groups.iter().map(|group| self.products(group, pairs)).collect();
        let mut sums = vec![0.0; pairs.len()];
        let mut mean = |selection: &Selection| {
            sums.fill(0.0);
            for (_, products) in products.iter().enumerate().filter(|(g, _)| Some(*g) != selection.left_out) {
                sums.iter_mut().zip(products).for_each(|(sum, more)| *sum += more);
            }
            selection.mean_correlation(pairs, takes_part, &sums)
        };
        let correlation = mean(&self.selections[0])?;
        let parts: Option<Vec<f64>> = self.selections[1..].iter().map(|left| mean(left).map(fisher)).collect();
        Some((correlation, parts?))
    }

    /// Of each pair, the sum over replicates.
    fn products(&self, group: &[f64], pairs: &[(usize, usize)]) -> Vec<f64> {
        let mut sums = vec![0.0; pairs.len()];
        // Along a line neighbours in the list are neighbours in both points.
        let step = pairs.first().map_or(0, |(i, j)| j - i);
        let is_run = pairs.iter().enumerate().all(|(k, pair)| *pair == (k, k + step));
        for row in group.chunks_exact(self.n_points) {
            if is_run {
                let products = row.iter().zip(&row[step..]).map(|(a, b)| a * b);
                sums.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
            } else {
                sums.iter_mut().zip(pairs).for_each(|(sum, (i, j))| *sum += row[*i] * row[*j]);
            }
        }
        sums
    }
}

impl Selection {
    /// Mean over the pairs of their correlation coefficient; `None` where no pair varies.
    fn mean_correlation(&self, pairs: &[(usize, usize)], takes_part: &[bool], products: &[f64]) -> Option<f64> {
        let (mut total, mut count) = (0.0, 0_u32);
        let pairs = pairs.iter().zip(products);
        for ((i, j), product) in pairs.filter(|((i, j), _)| takes_part[*i] && takes_part[*j]) {
            let (v_i, v_j) = (self.spreads[*i], self.spreads[*j]);
            if v_i > 0.0 && v_j > 0.0 {
                total += (product - self.sums[*i] * self.sums[*j] / self.n) / (v_i * v_j).sqrt();
                count += 1;
            }
        }
        (count > 0).then(|| (total / f64::from(count)).clamp(-1.0, 1.0))
    }
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
