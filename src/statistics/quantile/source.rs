//! By `statrs`.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal, StudentsT};

/// What a standard normal variable is above with probability `tail`, 0 < tail < ½.
pub(in crate::statistics) fn normal(tail: f64) -> f64 {
    -Normal::standard().inverse_cdf(tail)
}

/// What Student's T is above with probability `tail`, 0 < tail < ½.
pub(in crate::statistics) fn student(freedom: f64, tail: f64) -> Option<f64> {
    Some(-StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(tail))
}

/// What a chi-square variable is below with probability p, 0 < p < 1.
pub(in crate::statistics) fn chi_square(freedom: f64, p: f64) -> Option<f64> {
    Some(ChiSquared::new(freedom).ok()?.inverse_cdf(p))
}
