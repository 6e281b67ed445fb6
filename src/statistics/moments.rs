//! How many, how large, how spread: power sums that never cancel more than the data force them to.
//!
//! Everything is a sum of powers of deviations from a *pivot*, a number chosen beforehand near the mean (an exact value,
//! a pilot mean). Values are added in plain `f64` to a block of at most 256; full blocks go into totals of twice that
//! width. So the error of a power sum is that of one block: relative to Σ|x − pivot|ᵏ below 2⁻⁴⁴ for k ≤ 4 (255 additions
//! and k + 1 roundings of 2⁻⁵³ each), and does not grow with the number of values.
//!
//! Central moments are taken from the totals in double width. A pivot that lies c standard deviations from the mean
//! costs a factor 1 + c² in the relative error of the variance; within a few, nothing.
//!
//! Nothing is guarded against values whose fourth power overflows (beyond 1e77): moments that are not finite are `None`.

use crate::number::Wide;

/// Values per block.
const BLOCK: u32 = 256;

/// Sums of powers of x − pivot in plain `f64`: the inner loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
struct BlockSums {
    n: u32,
    powers: [f64; 4],
}

impl BlockSums {
    #[inline(always)]
    fn add(&mut self, deviation: f64) {
        let square = deviation * deviation;
        self.n += 1;
        self.powers[0] += deviation;
        self.powers[1] += square;
        self.powers[2] += square * deviation;
        self.powers[3] += square * square;
    }
}

/// Power sums of the deviations of n values from a pivot, up to the fourth.
///
/// The same values added in the same order, and the same parts merged in the same order, give the same bits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct PowerSums {
    pivot: f64,
    /// Values in `totals`.
    folded: u64,
    totals: [Wide; 4],
    block: BlockSums,
}

impl PowerSums {
    /// No values yet. `pivot`: finite, near the mean to come.
    pub fn about(pivot: f64) -> PowerSums {
        PowerSums { pivot, folded: 0, totals: [Wide::ZERO; 4], block: BlockSums::default() }
    }

    /// One more value, 2 to 4 ns; where values lie side by side, `extend` is faster.
    #[inline]
    pub fn add(&mut self, value: f64) {
        self.block.add(value - self.pivot);
        if self.block.n == BLOCK {
            self.fold();
        }
    }

    /// These values in their order, with the same bits as one by one.
    pub fn extend(&mut self, mut values: &[f64]) {
        while !values.is_empty() {
            let room = (BLOCK - self.block.n) as usize;
            let (now, later) = values.split_at(room.min(values.len()));
            // A copy that nobody else sees stays in registers.
            let mut block = self.block;
            now.iter().for_each(|&value| block.add(value - self.pivot));
            self.block = block;
            if self.block.n == BLOCK {
                self.fold();
            }
            values = later;
        }
    }

    /// One more value whose deviation is kept exactly: slower, for data sets rather than streams.
    fn add_exactly(&mut self, value: f64) {
        let deviation = Wide::difference(value, self.pivot);
        let square = deviation.square();
        let powers = [deviation, square, square * deviation, square.square()];
        self.totals = std::array::from_fn(|k| self.totals[k] + powers[k]);
        self.folded += 1;
    }

    #[inline(never)]
    fn fold(&mut self) {
        let block = std::mem::take(&mut self.block);
        self.totals = std::array::from_fn(|k| self.totals[k] + Wide::from(block.powers[k]));
        self.folded += u64::from(block.n);
    }

    /// The values of both. The order of merging matters in the last bits (of the double width), so keep to one.
    /// Sums about another pivot are moved to this one first.
    pub fn merge(&mut self, other: &PowerSums) {
        self.fold();
        let totals = other.totals_about(self.pivot);
        self.totals = std::array::from_fn(|k| self.totals[k] + totals[k]);
        self.folded += other.count();
    }

    pub fn count(&self) -> u64 {
        self.folded + u64::from(self.block.n)
    }

    pub fn pivot(&self) -> f64 {
        self.pivot
    }

    /// Σ (x − pivot)ᵏ for k in 1..=4; 0 for other k.
    pub fn sum_of_powers(&self, k: usize) -> f64 {
        match k {
            1..=4 => self.totals()[k - 1].narrow(),
            _ => 0.0,
        }
    }

    /// `None` without values.
    pub fn mean(&self) -> Option<f64> {
        self.wide_deviation().and_then(|deviation| finite(deviation + Wide::from(self.pivot)))
    }

    /// Mean less pivot: the bias, where the pivot is the exact value. `None` without values.
    pub fn mean_deviation(&self) -> Option<f64> {
        self.wide_deviation().and_then(finite)
    }

    /// Mean of (x − pivot)²: the mean squared error, where the pivot is the exact value. `None` without values.
    pub fn mean_square_deviation(&self) -> Option<f64> {
        (self.count() > 0).then(|| self.totals()[1] / self.wide_count()).and_then(finite)
    }

    /// Sample variance (divisor n − 1), never negative. `None` below two values.
    pub fn variance(&self) -> Option<f64> {
        let n = self.count();
        (n > 1).then(|| self.central_sums()[0] / Wide::from((n - 1) as f64)).and_then(finite)
    }

    /// Square root of the variance, rounded once.
    pub fn std_deviation(&self) -> Option<f64> {
        let n = self.count();
        (n > 1).then(|| (self.central_sums()[0] / Wide::from((n - 1) as f64)).sqrt()).and_then(finite)
    }

    /// Estimated standard deviation of the mean. `None` below two values.
    pub fn std_error(&self) -> Option<f64> {
        self.variance().map(|variance| (variance / self.count() as f64).sqrt())
    }

    /// Σ (x − mean)³ / n. `None` without values.
    pub fn third_central_moment(&self) -> Option<f64> {
        (self.count() > 0).then(|| self.central_sums()[1] / self.wide_count()).and_then(finite)
    }

    /// Σ (x − mean)⁴ / n. `None` without values.
    pub fn fourth_central_moment(&self) -> Option<f64> {
        (self.count() > 0).then(|| self.central_sums()[2] / self.wide_count()).and_then(finite)
    }

    /// Fourth central moment over the squared second, both with divisor n: 3 for normal data, at least 1.
    /// `None` where all values are equal (to the rounding of the sums) or there are none.
    pub fn kurtosis(&self) -> Option<f64> {
        let [second, _, fourth] = self.central_sums();
        if self.count() == 0 || second.narrow() <= self.resolution() {
            return None;
        }
        finite(fourth * self.wide_count() / second.square()).map(|kurtosis| kurtosis.max(1.0))
    }

    /// Σ (x − mean)² below which the spread is rounding: the error of Σ (x − pivot)².
    fn resolution(&self) -> f64 {
        if self.block.n == 0 && self.folded == 0 { 0.0 } else { self.totals()[1].narrow() * 2f64.powi(-44) }
    }

    fn wide_count(&self) -> Wide {
        Wide::from(self.count() as f64)
    }

    fn totals(&self) -> [Wide; 4] {
        std::array::from_fn(|k| self.totals[k] + Wide::from(self.block.powers[k]))
    }

    /// Sums about another pivot: with h = pivot − other, Σ (d + h)ᵏ by the binomial theorem.
    fn totals_about(&self, pivot: f64) -> [Wide; 4] {
        if pivot == self.pivot {
            return self.totals();
        }
        let h = Wide::difference(self.pivot, pivot);
        let (n, [s1, s2, s3, s4]) = (self.wide_count(), self.totals());
        let c = |factor: f64| Wide::from(factor);
        let (h2, h3) = (h.square(), h.square() * h);
        [
            s1 + n * h,
            s2 + c(2.0) * h * s1 + n * h2,
            s3 + c(3.0) * h * s2 + c(3.0) * h2 * s1 + n * h3,
            s4 + c(4.0) * h * s3 + c(6.0) * h2 * s2 + c(4.0) * h3 * s1 + n * h2.square(),
        ]
    }

    fn wide_deviation(&self) -> Option<Wide> {
        (self.count() > 0).then(|| self.totals()[0] / self.wide_count())
    }

    /// Σ (x − mean)ᵏ for k = 2, 3, 4; even ones are never negative.
    fn central_sums(&self) -> [Wide; 3] {
        let Some(m) = self.wide_deviation() else { return [Wide::ZERO; 3] };
        let (n, [s1, s2, s3, s4]) = (self.wide_count(), self.totals());
        let c = |factor: f64| Wide::from(factor);
        let m2 = m.square();
        // Σ(d − m)ᵏ with s1 = n·m put in, so that one term less is left to cancel.
        let second = s2 - m * s1;
        let third = s3 - c(3.0) * m * s2 + c(2.0) * m2 * s1;
        let fourth = s4 - c(4.0) * m * s3 + c(6.0) * m2 * s2 - c(3.0) * n * m2.square();
        let floor = |x: Wide| if x.narrow() < 0.0 { Wide::ZERO } else { x };
        [floor(second), third, floor(fourth)]
    }
}

fn finite(x: Wide) -> Option<f64> {
    Some(x.narrow()).filter(|x| x.is_finite())
}

/// A data set in memory: moments to the last digit that the data allow, and how neighbours hang together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    sums: PowerSums,
    lag_1: Option<f64>,
}

impl Summary {
    /// Two passes: the mean in double width is the pivot of the second, whose deviations are exact.
    ///
    /// - error: that of rounding the data themselves to `f64`; mean, standard deviation and autocorrelation of the nine
    ///   certified univariate sets of NIST come out with the digits that exact arithmetic on the doubles gives
    pub fn of(values: &[f64]) -> Summary {
        let total = values.iter().fold(Wide::ZERO, |sum, &value| sum + Wide::from(value));
        let n = Wide::from(values.len() as f64);
        let mean = if values.is_empty() { Wide::ZERO } else { total / n };
        let mut sums = PowerSums::about(mean.narrow());
        values.iter().for_each(|&value| sums.add_exactly(value));

        let deviation = |value: f64| Wide::from(value) - mean;
        let squares = values.iter().fold(Wide::ZERO, |sum, &x| sum + deviation(x).square());
        let neighbours =
            values.windows(2).fold(Wide::ZERO, |sum, pair| sum + deviation(pair[0]) * deviation(pair[1]));
        // A constant list leaves the square of the rounding of its mean.
        let spread = values.iter().any(|&value| value != values[0]);
        Summary { sums, lag_1: if spread { finite(neighbours / squares) } else { None } }
    }

    /// Everything else: mean, variance, kurtosis, standard error.
    pub fn moments(&self) -> &PowerSums {
        &self.sums
    }

    /// Σ (xᵢ − mean)(xᵢ₊₁ − mean) / Σ (xᵢ − mean)². `None` where all values are equal or there are fewer than two.
    pub fn lag_1_autocorrelation(&self) -> Option<f64> {
        self.lag_1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sums_of(values: &[f64], pivot: f64) -> PowerSums {
        let mut sums = PowerSums::about(pivot);
        values.iter().for_each(|&value| sums.add(value));
        sums
    }

    /// A fixed, irregular list in (0, 1): the golden ratio's multiples.
    fn irregular(n: u32) -> Vec<f64> {
        (1..=n).map(|k| (f64::from(k) * 0.618_033_988_749_894_9).fract().powi(2)).collect()
    }

    #[test]
    fn few_values_have_few_moments() {
        let none = PowerSums::about(1.0);
        assert_eq!((none.count(), none.mean(), none.variance(), none.kurtosis()), (0, None, None, None));
        assert_eq!((none.mean_square_deviation(), none.std_error(), none.third_central_moment()), (None, None, None));
        let one = sums_of(&[3.0], 1.0);
        assert_eq!((one.mean(), one.mean_deviation(), one.variance()), (Some(3.0), Some(2.0), None));
        assert_eq!((one.mean_square_deviation(), one.kurtosis()), (Some(4.0), None));
        assert_eq!(Summary::of(&[]).lag_1_autocorrelation(), None);
        assert_eq!(Summary::of(&[0.1, 0.1, 0.1]).lag_1_autocorrelation(), None);
    }

    #[test]
    fn known_moments_of_a_small_set() {
        // 1, 2, 3, 4, 10: mean 4; central powers sum to 50, 180, 1394.
        for pivot in [0.0, 4.0, -7.5] {
            let sums = sums_of(&[1.0, 2.0, 3.0, 4.0, 10.0], pivot);
            assert_eq!((sums.mean(), sums.variance()), (Some(4.0), Some(12.5)));
            assert_eq!(sums.third_central_moment(), Some(36.0));
            assert_eq!(sums.fourth_central_moment(), Some(1394.0 / 5.0));
            assert_eq!(sums.kurtosis(), Some(1394.0 * 5.0 / 2500.0));
            assert_eq!(sums.std_error(), Some(2.5f64.sqrt()));
        }
    }

    #[test]
    fn equal_values_have_no_variance_and_no_kurtosis() {
        let sums = sums_of(&[0.1; 1000], 0.1);
        assert_eq!((sums.variance(), sums.kurtosis()), (Some(0.0), None));
        // About another pivot the spread is rounding, and is not mistaken for a shape.
        let sums = sums_of(&[0.1; 1000], 0.0);
        assert!(sums.variance().unwrap() < 0.01 * 2f64.powi(-44));
        assert_eq!(sums.kurtosis(), None);
    }

    #[test]
    fn parts_merged_are_the_whole_and_one_order_gives_the_same_bits() {
        let values = irregular(5000);
        let whole = sums_of(&values, 0.3);
        let parts: Vec<PowerSums> = values.chunks(700).map(|part| sums_of(part, 0.3)).collect();
        let merged = |parts: &[PowerSums]| {
            parts.iter().fold(PowerSums::about(0.3), |mut sums, part| {
                sums.merge(part);
                sums
            })
        };
        assert_eq!(merged(&parts), merged(&parts.clone()));
        assert_eq!(merged(&parts).count(), 5000);
        // Other pivots too: the sums are moved, not mixed.
        let moved: Vec<PowerSums> = values.chunks(700).map(|part| sums_of(part, part[0])).collect();
        for sums in [merged(&parts), merged(&moved)] {
            for k in 1..=4 {
                let (a, b) = (sums.sum_of_powers(k), whole.sum_of_powers(k));
                assert!((a - b).abs() <= 5000.0 * 2f64.powi(-44), "power {k}: {a} {b}");
            }
        }
    }

    #[test]
    fn values_in_a_row_are_values_one_by_one() {
        let values = irregular(2000);
        let whole = sums_of(&values, 0.3);
        for parts in [1, 7, 256, 700] {
            let mut sums = PowerSums::about(0.3);
            values.chunks(parts).for_each(|part| sums.extend(part));
            assert_eq!(sums, whole);
        }
    }

    #[test]
    fn the_error_of_a_sum_stays_that_of_one_block() {
        let values = irregular(300_000);
        let exact = Summary::of(&values);
        let streamed = sums_of(&values, exact.moments().pivot());
        for k in 1..=4 {
            let size: f64 = values.iter().map(|x| (x - streamed.pivot()).abs().powi(k)).sum();
            let error = (streamed.sum_of_powers(k as usize) - exact.moments().sum_of_powers(k as usize)).abs();
            assert!(error <= size * 2f64.powi(-44), "power {k}: error {error:e} of {size:e}");
        }
        let relative = streamed.variance().unwrap() / exact.moments().variance().unwrap() - 1.0;
        assert!(relative.abs() < 1e-14, "{relative:e}");
    }

    #[test]
    fn numbers_beyond_the_range_give_no_moment_rather_than_nan() {
        let sums = sums_of(&[f64::NAN, 1.0], 0.0);
        assert_eq!((sums.mean(), sums.variance(), sums.kurtosis()), (None, None, None));
        let sums = sums_of(&[1e200, -1e200, 0.0], 0.0);
        assert_eq!(sums.kurtosis(), None);
    }
}
