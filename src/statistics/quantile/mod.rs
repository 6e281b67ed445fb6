//! Quantiles of the distributions that intervals are read from.

#[cfg(test)]
mod by_newton;
#[cfg_attr(not(feature = "studies"), path = "by_newton.rs")]
mod source;

pub(super) use source::{chi_square, normal, student};

#[cfg(test)]
mod tests {
    use super::*;

    /// What stands in for `statrs` in the slim build, where `statrs` is right: further out (Student's T of one degree of freedom
    /// at 1e-9, a chi-square variable of half a degree below 0.005) its search stops too early.
    #[test]
    fn both_ways_to_quantiles_agree() {
        for tail in [0.005, 0.025, 0.16, 0.3] {
            let near = |what: &str, freedom: f64, one: Option<f64>, other: Option<f64>, error: f64| {
                let (one, other) = (one.unwrap(), other.unwrap());
                assert!(((one - other) / other).abs() < error, "{what} {freedom} {tail}: {one} and {other}");
            };
            near("normal", 0.0, Some(normal(tail)), Some(by_newton::normal(tail)), 1e-10);
            for freedom in [1.0, 2.0, 2.5, 7.0, 31.0, 100.0, 1234.5, 9999.0] {
                near("student", freedom, student(freedom, tail), by_newton::student(freedom, tail), 1e-9);
            }
            for freedom in [1.0, 2.0, 3.7, 10.0, 99.5] {
                for p in [tail, 1.0 - tail] {
                    near("chi-square", freedom, chi_square(freedom, p), by_newton::chi_square(freedom, p), 2e-8);
                }
            }
        }
    }

    /// Closed forms: Student's T of one and of two degrees of freedom, a chi-square variable of two.
    #[test]
    fn closed_forms_come_out() {
        for p in [1e-9_f64, 1e-6, 0.01, 0.025, 0.2, 0.45] {
            let near = |one: Option<f64>, other: f64| {
                let one = one.unwrap();
                assert!((one - other).abs() < 1e-13 * other.abs(), "{p}: {one} and {other}");
            };
            near(by_newton::student(1.0, p), 1.0 / (std::f64::consts::PI * p).tan());
            near(by_newton::student(2.0, p), (1.0 - 2.0 * p) / (2.0 * p * (1.0 - p)).sqrt());
            near(by_newton::chi_square(2.0, p), -2.0 * (-p).ln_1p());
        }
    }
}
