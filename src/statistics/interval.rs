//! Intervals that cover a true value with a stated probability.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use super::moments::PowerSums;

/// From `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    pub low: f64,
    pub high: f64,
}

impl Interval {
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    pub fn width(&self) -> f64 {
        self.high - self.low
    }
}

/// z with P(|Z| < z) = level for a standard normal Z. `None` unless 0 < level < 1.
pub fn normal_quantile(level: f64) -> Option<f64> {
    in_unit(level).then(|| -Normal::standard().inverse_cdf(0.5 * (1.0 - level)))
}

/// t with P(|T| < t) = level for Student's T. `None` unless 0 < level < 1 and there is a degree of freedom.
pub fn student_quantile(level: f64, degrees_of_freedom: f64) -> Option<f64> {
    let student = StudentsT::new(0.0, 1.0, degrees_of_freedom).ok()?;
    in_unit(level).then(|| -student.inverse_cdf(0.5 * (1.0 - level)))
}

fn in_unit(level: f64) -> bool {
    0.0 < level && level < 1.0
}

/// The mean, by Student's t with n − 1 degrees of freedom. `None` below two values.
///
/// - exact for normal data; for others right where the mean is nearly normal: some thirty hits or more
pub fn of_mean(sums: &PowerSums, level: f64) -> Option<Interval> {
    let (mean, std_error) = (sums.mean()?, sums.std_error()?);
    let reach = student_quantile(level, (sums.count() - 1) as f64)? * std_error;
    Some(Interval { low: mean - reach, high: mean + reach })
}
