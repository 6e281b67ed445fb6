//! Least squares: how a quantity falls with another, with the error of saying so.
//!
//! The equations are solved by Householder reflections in double width (106 bits), so that the digits lost to a badly
//! conditioned problem are digits nobody sees: the eleven certified linear sets of NIST (Filip's tenth-degree polynomial,
//! condition 1e15, among them) come out with what rounding their data to `f64` allows.
//!
//! With y = X β + noise, W = 1 / variance of the noise (up to a factor) and √W X = Q R,
//!
//! ```text
//! β = R⁻¹ Qᵀ √W y,    cov β = s² R⁻¹ R⁻ᵀ
//! ```
//!
//! where s² is 1 if the variances are known, else what the residuals say, Σ w r² / (n − p). Sources: G. Golub, Numerische
//! Mathematik 7, 1965 (reflections); any text on regression for the covariance.

use super::interval::{Interval, normal_quantile, student_quantile};
use crate::number::Wide;

/// What is known of the noise in y beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise<'a> {
    /// The same everywhere, estimated from the residuals.
    Equal,
    /// Known up to one factor: weights are inverse variances times anything. Estimated from the residuals.
    Relative { weights: &'a [f64] },
    /// The variance of each y. Standard errors follow from it and not from the residuals.
    Known { variances: &'a [f64] },
}

/// Why nothing was fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    #[error("{found} values where {expected} observations call for as many")]
    LengthsDiffer { expected: usize, found: usize },
    #[error("{observations} observations cannot determine {coefficients} coefficients")]
    TooFew { observations: usize, coefficients: usize },
    #[error("observation {observation} (from 0) is not a finite number")]
    NotFinite { observation: usize },
    #[error("the weight or variance of observation {observation} (from 0) is not greater than zero")]
    NoWeight { observation: usize },
    #[error("column {column} (from 0) is a combination of those before it")]
    Dependent { column: usize },
}

/// Coefficients with their errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// In the order of the columns.
    pub coefficients: Vec<f64>,
    /// `None` where the noise is to be estimated and no observation is left over to do it.
    pub std_errors: Option<Vec<f64>>,
    /// Σ w r²: a chi-square variable with `degrees_of_freedom` where the variances are known and the model is right.
    pub sum_of_squares: f64,
    /// Observations less coefficients.
    pub degrees_of_freedom: usize,
    variances_are_known: bool,
}

impl Fit {
    /// Square root of Σ w r² / degrees of freedom. `None` where none are left.
    pub fn residual_std_deviation(&self) -> Option<f64> {
        (self.degrees_of_freedom > 0).then(|| (self.sum_of_squares / self.degrees_of_freedom as f64).sqrt())
    }

    /// The interval that covers a coefficient with probability `level`: normal where variances are known, else Student's.
    /// `None` without standard errors, for a coefficient that there is not, or a level outside (0, 1).
    pub fn interval(&self, coefficient: usize, level: f64) -> Option<Interval> {
        let centre = *self.coefficients.get(coefficient)?;
        let std_error = *self.std_errors.as_ref()?.get(coefficient)?;
        let quantile = if self.variances_are_known {
            normal_quantile(level)?
        } else {
            student_quantile(level, self.degrees_of_freedom as f64)?
        };
        Some(Interval { low: centre - quantile * std_error, high: centre + quantile * std_error })
    }
}

/// The combination of `columns` nearest to `y`, in the sense of weighted least squares. An intercept is a column of ones.
///
/// - `columns`: one for each coefficient, each as long as `y`
/// - error: below 1e-14 relative to the exact solution while the condition number of the scaled columns is below 1e15 and
///   squares neither overflow nor underflow
pub fn fit(columns: &[&[f64]], y: &[f64], noise: Noise) -> Result<Fit, FitError> {
    for column in columns {
        check(column, y.len())?;
    }
    fit_wide(columns.iter().map(|column| column.iter().map(|&x| Wide::from(x)).collect()).collect(), y, noise)
}

/// y = β₀ + β₁ x + … of that degree, powers formed in double width.
pub fn fit_polynomial(x: &[f64], y: &[f64], degree: usize, noise: Noise) -> Result<Fit, FitError> {
    check(x, y.len())?;
    let mut columns = vec![vec![Wide::from(1.0); x.len()]];
    for power in 1..=degree {
        columns.push(columns[power - 1].iter().zip(x).map(|(&before, &x)| before * Wide::from(x)).collect());
    }
    fit_wide(columns, y, noise)
}

/// A straight line with its errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    pub slope: f64,
    /// y at x = 0.
    pub intercept: f64,
    /// `None` where the noise is to be estimated from two points.
    pub slope_std_error: Option<f64>,
    pub intercept_std_error: Option<f64>,
    fit: Fit,
}

impl Line {
    /// The line through points (x, y). Two points or more, not all at one x.
    pub fn through(x: &[f64], y: &[f64], noise: Noise) -> Result<Line, FitError> {
        let fit = fit_polynomial(x, y, 1, noise)?;
        let std_error = |k: usize| fit.std_errors.as_ref().map(|errors| errors[k]);
        Ok(Line {
            slope: fit.coefficients[1],
            intercept: fit.coefficients[0],
            slope_std_error: std_error(1),
            intercept_std_error: std_error(0),
            fit,
        })
    }

    pub fn at(&self, x: f64) -> f64 {
        self.intercept + self.slope * x
    }

    /// Covers the slope with probability `level`.
    pub fn slope_interval(&self, level: f64) -> Option<Interval> {
        self.fit.interval(1, level)
    }

    pub fn intercept_interval(&self, level: f64) -> Option<Interval> {
        self.fit.interval(0, level)
    }

    /// Σ w r² and its degrees of freedom: how far the points are from any line.
    pub fn lack_of_fit(&self) -> (f64, usize) {
        (self.fit.sum_of_squares, self.fit.degrees_of_freedom)
    }
}

fn check(values: &[f64], expected: usize) -> Result<(), FitError> {
    if values.len() != expected {
        return Err(FitError::LengthsDiffer { expected, found: values.len() });
    }
    match values.iter().position(|value| !value.is_finite()) {
        Some(observation) => Err(FitError::NotFinite { observation }),
        None => Ok(()),
    }
}

/// √w of each observation.
fn row_scales(n: usize, noise: Noise) -> Result<Vec<Wide>, FitError> {
    let (given, inverse) = match noise {
        Noise::Equal => return Ok(vec![Wide::from(1.0); n]),
        Noise::Relative { weights } => (weights, false),
        Noise::Known { variances } => (variances, true),
    };
    check(given, n)?;
    if let Some(observation) = given.iter().position(|&value| value <= 0.0) {
        return Err(FitError::NoWeight { observation });
    }
    let root = |&value: &f64| Wide::from(value).sqrt();
    Ok(given.iter().map(|value| if inverse { Wide::from(1.0) / root(value) } else { root(value) }).collect())
}

fn fit_wide(mut columns: Vec<Vec<Wide>>, y: &[f64], noise: Noise) -> Result<Fit, FitError> {
    let (n, p) = (y.len(), columns.len());
    check(y, n)?;
    let scales = row_scales(n, noise)?;
    if n < p || p == 0 {
        return Err(FitError::TooFew { observations: n, coefficients: p });
    }
    let mut right: Vec<Wide> = y.iter().zip(&scales).map(|(&y, &scale)| Wide::from(y) * scale).collect();
    for column in &mut columns {
        column.iter_mut().zip(&scales).for_each(|(x, &scale)| *x = *x * scale);
    }
    triangularise(&mut columns, &mut right)?;

    let sum_of_squares = norm_squared(&right[p..]);
    let degrees_of_freedom = n - p;
    let variances_are_known = matches!(noise, Noise::Known { .. });
    let scale = match (variances_are_known, degrees_of_freedom) {
        (true, _) => Some(Wide::from(1.0)),
        (false, 0) => None,
        (false, left) => Some((sum_of_squares / Wide::from(left as f64)).sqrt()),
    };
    let inverse_rows = inverse_row_norms(&columns);
    Ok(Fit {
        coefficients: solve(&columns, &right[..p]).into_iter().map(Wide::narrow).collect(),
        std_errors: scale.map(|scale| inverse_rows.into_iter().map(|norm| (norm * scale).narrow()).collect()),
        sum_of_squares: sum_of_squares.narrow(),
        degrees_of_freedom,
        variances_are_known,
    })
}

fn norm_squared(values: &[Wide]) -> Wide {
    values.iter().fold(Wide::ZERO, |sum, value| sum + value.square())
}

fn dot(a: &[Wide], b: &[Wide]) -> Wide {
    a.iter().zip(b).fold(Wide::ZERO, |sum, (&a, &b)| sum + a * b)
}

/// Reflections that leave R in the upper triangle of `columns` (column-major) and Qᵀ y in `right`.
fn triangularise(columns: &mut [Vec<Wide>], right: &mut [Wide]) -> Result<(), FitError> {
    for k in 0..columns.len() {
        let whole = norm_squared(&columns[k]).sqrt();
        let below = norm_squared(&columns[k][k..]).sqrt();
        // What double width cannot tell from zero.
        if below.narrow() <= 1e-26 * whole.narrow() {
            return Err(FitError::Dependent { column: k });
        }
        // The reflection sends the column's tail to −sign · |tail| on the diagonal: no cancellation.
        let diagonal = if columns[k][k].narrow() > 0.0 { -below } else { below };
        let mut axis = columns[k][k..].to_vec();
        axis[0] = axis[0] - diagonal;
        let half = Wide::from(0.5) * norm_squared(&axis);
        let reflect = |tail: &mut [Wide]| {
            let factor = dot(&axis, tail) / half;
            tail.iter_mut().zip(&axis).for_each(|(x, &axis)| *x = *x - factor * axis);
        };
        columns[k + 1..].iter_mut().for_each(|column| reflect(&mut column[k..]));
        reflect(&mut right[k..]);
        columns[k][k] = diagonal;
        columns[k][k + 1..].fill(Wide::ZERO);
    }
    Ok(())
}

/// R β = right, from the last coefficient up.
fn solve(upper: &[Vec<Wide>], right: &[Wide]) -> Vec<Wide> {
    let mut solution = right.to_vec();
    for k in (0..right.len()).rev() {
        let known = (k + 1..right.len()).fold(Wide::ZERO, |sum, j| sum + upper[j][k] * solution[j]);
        solution[k] = (solution[k] - known) / upper[k][k];
    }
    solution
}

/// √ of the diagonal of R⁻¹ R⁻ᵀ.
fn inverse_row_norms(upper: &[Vec<Wide>]) -> Vec<Wide> {
    let p = upper.len();
    let mut squares = vec![Wide::ZERO; p];
    for j in 0..p {
        let mut unit = vec![Wide::ZERO; p];
        unit[j] = Wide::from(1.0);
        let inverse_column = solve(upper, &unit);
        squares.iter_mut().zip(inverse_column).for_each(|(square, x)| *square = *square + x.square());
    }
    squares.into_iter().map(Wide::sqrt).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::budget::plausible;
    use crate::statistics::interval::chi_square_quantiles;
    use crate::statistics::simulated::Draws;

    const X: [f64; 5] = [0.0, 1.0, 2.0, 3.0, 7.0];

    #[test]
    fn points_on_a_line_give_the_line() {
        let y = X.map(|x| 3.0 - 2.0 * x);
        for noise in [Noise::Equal, Noise::Relative { weights: &[1.0, 5.0, 0.1, 2.0, 3.0] }] {
            let line = Line::through(&X, &y, noise).unwrap();
            assert_eq!((line.slope, line.intercept, line.at(10.0)), (-2.0, 3.0, -17.0));
            assert!(line.slope_std_error.unwrap() < 1e-25);
        }
    }

    #[test]
    fn known_variances_give_the_textbook_standard_errors() {
        let variances = [0.5, 1.0, 0.25, 2.0, 1.0];
        let y = [1.0, 0.5, 3.0, 2.0, 9.0];
        let line = Line::through(&X, &y, Noise::Known { variances: &variances }).unwrap();
        let weighted = |f: &dyn Fn(usize) -> f64| (0..5).map(|k| f(k) / variances[k]).sum::<f64>();
        let total = weighted(&|_| 1.0);
        let mean = weighted(&|k| X[k]) / total;
        let spread = weighted(&|k| (X[k] - mean).powi(2));
        let slope = weighted(&|k| (X[k] - mean) * y[k]) / spread;
        assert!((line.slope / slope - 1.0).abs() < 1e-14);
        assert!((line.slope_std_error.unwrap() * spread.sqrt() - 1.0).abs() < 1e-14);
        let at_zero = (1.0 / total + mean * mean / spread).sqrt();
        assert!((line.intercept_std_error.unwrap() / at_zero - 1.0).abs() < 1e-14);
        let interval = line.slope_interval(0.95).unwrap();
        assert!((interval.width() * spread.sqrt() / 2.0 - 1.959_963_984_540_054).abs() < 1e-12);
        // The scale of the weights does not move a line, nor its error where that comes from the residuals.
        let relative = |factor: f64| {
            let weights = variances.map(|variance| factor / variance);
            Line::through(&X, &y, Noise::Relative { weights: &weights }).unwrap()
        };
        let (one, many) = (relative(1.0), relative(1e6));
        assert!((one.slope - line.slope).abs() < 1e-14 && (many.slope - line.slope).abs() < 1e-14);
        assert!((one.slope_std_error.unwrap() / many.slope_std_error.unwrap() - 1.0).abs() < 1e-13);
    }

    #[test]
    fn intervals_of_the_slope_cover_what_they_claim() {
        let mut draws = Draws::named("intervals_of_the_slope_cover_what_they_claim");
        let variances = [0.1, 0.4, 0.2, 1.0, 0.05];
        let (_, limit) = chi_square_quantiles(0.9, 3.0).unwrap();
        let (runs, mut known, mut estimated, mut fits) = (4000, 0, 0, 0);
        for _ in 0..runs {
            let y: Vec<f64> = (0..5).map(|k| 1.0 - 2.0 * X[k] + f64::sqrt(variances[k]) * draws.normal()).collect();
            let line = Line::through(&X, &y, Noise::Known { variances: &variances }).unwrap();
            known += u64::from(line.slope_interval(0.95).unwrap().contains(-2.0));
            fits += u64::from(line.lack_of_fit().0 < limit);
            let weights = variances.map(|variance| 7.0 / variance);
            let line = Line::through(&X, &y, Noise::Relative { weights: &weights }).unwrap();
            estimated += u64::from(line.slope_interval(0.95).unwrap().contains(-2.0));
        }
        assert!(plausible(known, runs, 0.95, 0.95), "{known} of {runs}");
        assert!(plausible(estimated, runs, 0.95, 0.95), "{estimated} of {runs}");
        assert!(plausible(fits, runs, 0.95, 0.95), "{fits} of {runs} below the 95 % point of lack of fit");
    }

    #[test]
    fn two_points_have_a_line_and_no_error_of_it() {
        let line = Line::through(&[1.0, 2.0], &[5.0, 3.0], Noise::Equal).unwrap();
        assert_eq!((line.slope, line.slope_std_error, line.slope_interval(0.95)), (-2.0, None, None));
        let line = Line::through(&[1.0, 2.0], &[5.0, 3.0], Noise::Known { variances: &[0.5, 0.5] }).unwrap();
        assert_eq!(line.slope_std_error, Some(1.0));
    }

    #[test]
    fn what_cannot_be_fitted_is_said() {
        let through = |x: &[f64], y: &[f64], noise| Line::through(x, y, noise).unwrap_err();
        assert_eq!(through(&[1.0], &[1.0], Noise::Equal), FitError::TooFew { observations: 1, coefficients: 2 });
        assert_eq!(through(&[2.0; 3], &[1.0; 3], Noise::Equal), FitError::Dependent { column: 1 });
        assert_eq!(through(&[1.0, 2.0], &[1.0], Noise::Equal), FitError::LengthsDiffer { expected: 1, found: 2 });
        assert_eq!(
            through(&X, &[1.0, 2.0, f64::NAN, 4.0, 5.0], Noise::Equal),
            FitError::NotFinite { observation: 2 }
        );
        let variances = [1.0, 1.0, 1.0, 0.0, 1.0];
        assert_eq!(through(&X, &X, Noise::Known { variances: &variances }), FitError::NoWeight { observation: 3 });
        assert!(fit(&[], &X, Noise::Equal).is_err());
        // A third column that is the sum of two.
        let (a, b) = ([1.0; 5], X);
        let sum = X.map(|x| 1.0 + x);
        assert_eq!(fit(&[&a, &b, &sum], &X, Noise::Equal), Err(FitError::Dependent { column: 2 }));
    }
}
