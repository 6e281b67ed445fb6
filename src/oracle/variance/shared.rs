//! Points that are shared: how the errors of several receivers move together.

use super::Spread;
use super::field::{Contribution, Field};
use crate::configuration::MeasurementPoint;
use crate::oracle::Oracle;
use crate::threads;

/// Places that stand for a source: a Fibonacci lattice, (i + ½)/N and {i F/N + ½/N} with N and F neighbours in Fibonacci's
/// sequence. What is seen through an edge along either side of the square is wrong by one place in N at most, through any
/// other edge by some N^(−3/4) of the whole.
const PLACES: u64 = 28_657;
const STEP: u64 = 17_711;
/// Relative error of means over the lattice of what an edge cuts, measured against `sample_moments` (tests).
const LATTICE_ERROR: f64 = 1e-3;
/// Places of one unit of work.
const CHUNK: u64 = 1024;
/// Weightings that are summed abreast: each sum keeps its order, and none waits for another.
const ABREAST: usize = 8;

/// How estimates at several points move together that use the same N places on each source.
#[derive(Clone, Debug, PartialEq)]
pub struct Shared {
    /// For each weighting, the spread of the weighted sum of one sample's contributions.
    pub sums: Vec<Spread>,
    /// For each weighting, how far off its variance may be, W²/m⁴.
    pub sum_errors: Vec<f64>,
    /// For each pair, the covariance of one sample's contributions, W²/m⁴.
    pub covariances: Vec<f64>,
    /// For each point, the variance of one sample's contribution on the same lattice, W²/m⁴.
    pub variances: Vec<f64>,
}

/// Sums over places, of one source.
#[derive(Clone)]
struct Tally {
    /// Σ Yᵠ of each weighting, of deviations from what is due.
    weighed: Vec<[f64; 4]>,
    /// Σ X and Σ X² of each point's deviations.
    points: Vec<[f64; 2]>,
    /// Σ Xᵢ Xⱼ of each pair's.
    pairs: Vec<f64>,
}

impl Oracle {
    /// Spreads and covariances of what one shared sample, uniform by area, brings to several points; all sources together,
    /// whose samples are independent of one another. Those of the mean of N samples are 1/N of it ([`Spread::mean_of`]).
    ///
    /// - `weights`: `[weighting][point]`
    /// - `pairs`: of indices of points
    /// - `None` as for `sample_moments`
    pub fn shared_samples(
        &self,
        points: &[MeasurementPoint],
        weights: &[Vec<f64>],
        pairs: &[(usize, usize)],
    ) -> Option<Shared> {
        let mut shared = Shared {
            sums: vec![Spread::default(); weights.len()],
            sum_errors: vec![0.0; weights.len()],
            covariances: vec![0.0; pairs.len()],
            variances: vec![0.0; points.len()],
        };
        let runs = Runs::of(pairs);
        for source in 0..self.sources.len() {
            let fields: Vec<Field> =
                points.iter().map(|point| Field::new(self, source, point)).collect::<Option<_>>()?;
            // Deviations, so that what hardly varies is not lost below the square of its mean.
            let due: Vec<f64> = points.iter().map(|point| self.due(source, point)).collect();
            let chunks: Vec<u64> = (0..PLACES.div_ceil(CHUNK)).collect();
            let tallies = threads::map(&chunks, |k| {
                tally(&fields, &due, weights, &runs, k * CHUNK..((k + 1) * CHUNK).min(PLACES))
            });
            let n = PLACES as f64;
            // Added in order: the same bits on any number of threads.
            let total = tallies.into_iter().reduce(Tally::plus).expect("there are places");
            let mean = |p: usize| total.points[p][0] / n;
            for ((spread, error), (sums, row)) in
                shared.sums.iter_mut().zip(&mut shared.sum_errors).zip(total.weighed.iter().zip(weights))
            {
                *spread = spread.plus(spread_of(sums.map(|sum| sum / n)));
                let size: f64 =
                    row.iter().zip(&total.points).map(|(w, [_, squares])| w.abs() * (squares / n).sqrt()).sum();
                *error += LATTICE_ERROR * size * size;
            }
            for (covariance, (sum, (i, j))) in shared.covariances.iter_mut().zip(total.pairs.iter().zip(pairs)) {
                *covariance += sum / n - mean(*i) * mean(*j);
            }
            for (p, variance) in shared.variances.iter_mut().enumerate() {
                *variance += total.points[p][1] / n - mean(p) * mean(p);
            }
        }
        Some(shared)
    }
}

/// Pairs of points, in runs of neighbours: (i, j), (i + 1, j + 1), … whose products are taken several at a time.
struct Runs {
    /// The first pair of each, and how many.
    runs: Vec<(usize, usize, usize)>,
    n_pairs: usize,
}

impl Runs {
    fn of(pairs: &[(usize, usize)]) -> Runs {
        let mut runs: Vec<(usize, usize, usize)> = Vec::new();
        for (i, j) in pairs {
            match runs.last_mut() {
                Some((first, second, length)) if (*first + *length, *second + *length) == (*i, *j) => *length += 1,
                _ => runs.push((*i, *j, 1)),
            }
        }
        Runs { runs, n_pairs: pairs.len() }
    }

    /// Adds the product of either value of each pair to its sum.
    fn add_products(&self, values: &[f64], sums: &mut [f64]) {
        let mut rest = sums;
        for (i, j, length) in &self.runs {
            let (own, others) = rest.split_at_mut(*length);
            rest = others;
            let products = values[*i..i + length].iter().zip(&values[*j..j + length]).map(|(a, b)| a * b);
            own.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
        }
    }
}

/// From moments about a place near the mean.
fn spread_of([m1, m2, m3, m4]: [f64; 4]) -> Spread {
    let variance = (m2 - m1 * m1).max(0.0);
    let fourth = (m4 - 4.0 * m3 * m1 + 6.0 * m2 * m1 * m1 - 3.0 * m1 * m1 * m1 * m1).max(variance * variance);
    Spread { variance, fourth_cumulant: fourth - 3.0 * variance * variance }
}

/// - `due`: the mean at each point, W/m²
fn tally(fields: &[Field], due: &[f64], weights: &[Vec<f64>], runs: &Runs, places: std::ops::Range<u64>) -> Tally {
    let mut tally = Tally {
        weighed: vec![[0.0; 4]; weights.len()],
        points: vec![[0.0; 2]; fields.len()],
        pairs: vec![0.0; runs.n_pairs],
    };
    let abreast: Vec<Vec<[f64; ABREAST]>> = weights
        .chunks(ABREAST)
        .map(|some| {
            (0..fields.len()).map(|p| std::array::from_fn(|k| some.get(k).map_or(0.0, |row| row[p]))).collect()
        })
        .collect();
    let mut values = vec![0.0; fields.len()];
    for i in places {
        let u = (i as f64 + 0.5) / PLACES as f64;
        let v = ((i * STEP % PLACES) as f64 + 0.5) / PLACES as f64;
        let place = fields[0].place(u, v);
        let exitance = fields[0].exitance_at(&place);
        for (((value, field), due), [sum, squares]) in values.iter_mut().zip(fields).zip(due).zip(&mut tally.points) {
            *value = -due;
            if field.is_dark() {
                continue;
            }
            let (direction, landing) = field.of(&place, exitance);
            let brought = Contribution::by_area(&landing).value;
            if brought > 0.0 && field.margin(direction) > 0.0 {
                *value += brought;
            }
            *sum += *value;
            *squares += *value * *value;
        }
        for (sums, rows) in tally.weighed.chunks_mut(ABREAST).zip(&abreast) {
            let mut combined = [0.0; ABREAST];
            for (row, value) in rows.iter().zip(&values) {
                for k in 0..ABREAST {
                    combined[k] += row[k] * value;
                }
            }
            for (sums, y) in sums.iter_mut().zip(combined) {
                let mut power = 1.0;
                for sum in sums {
                    power *= y;
                    *sum += power;
                }
            }
        }
        runs.add_products(&values, &mut tally.pairs);
    }
    tally
}

impl Tally {
    fn plus(mut self, other: Tally) -> Tally {
        for (sums, more) in self.weighed.iter_mut().zip(&other.weighed) {
            sums.iter_mut().zip(more).for_each(|(sum, x)| *sum += x);
        }
        for (sums, more) in self.points.iter_mut().zip(&other.points) {
            sums.iter_mut().zip(more).for_each(|(sum, x)| *sum += x);
        }
        self.pairs.iter_mut().zip(&other.pairs).for_each(|(sum, x)| *sum += x);
        self
    }
}
