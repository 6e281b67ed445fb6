//! Laws of growth, fitted: a power of x, and a start with a part in proportion to x or to its logarithm.

use crate::statistics::Line;
use crate::statistics::slope::Noise;

/// How a cost is expected to grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// a + b x.
    Linear,
    /// a + b ln x.
    Logarithmic,
}

impl Law {
    /// What b is multiplied by.
    fn along(self, x: f64) -> f64 {
        match self {
            Law::Linear => x,
            Law::Logarithmic => x.ln(),
        }
    }
}

/// seconds = factor · x^exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// Seconds at x = 1.
    pub factor: f64,
    pub exponent: f64,
    /// Of the exponent, as the scatter about the line has it; `None` of two points.
    pub std_error: Option<f64>,
    /// Root mean square of what the law is off, relative to what was measured.
    pub off: f64,
}

impl PowerLaw {
    /// Seconds at x > 0.
    pub fn at(&self, x: f64) -> f64 {
        self.factor * x.powf(self.exponent)
    }
}

/// seconds = start + step · x, or start + step · ln x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    pub law: Law,
    /// Seconds where x, or its logarithm, is nothing.
    pub start: f64,
    /// Seconds for each x, or each factor of e.
    pub step: f64,
    /// As [`PowerLaw::off`].
    pub off: f64,
}

impl Affine {
    /// Seconds at x; x > 0 where the law has its logarithm.
    pub fn at(&self, x: f64) -> f64 {
        self.start + self.step * self.law.along(x)
    }
}

/// Two laws of two numbers each through the same points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fits {
    pub power: Option<PowerLaw>,
    pub affine: Option<Affine>,
}

impl Fits {
    /// Least squares of relative deviations: of the logarithms for the power, with weights 1/seconds² for the other.
    ///
    /// - `pairs`: x and seconds, both > 0; two different x or more, else nothing is fitted
    pub fn of(pairs: &[(f64, f64)], law: Law) -> Fits {
        if pairs.iter().any(|(x, y)| !(*x > 0.0 && *y > 0.0)) {
            return Fits { power: None, affine: None };
        }
        let off = |at: &dyn Fn(f64) -> f64| {
            let squares: f64 = pairs.iter().map(|(x, y)| (at(*x) / y - 1.0).powi(2)).sum();
            (squares / pairs.len() as f64).sqrt()
        };
        let (x, y): (Vec<f64>, Vec<f64>) = pairs.iter().map(|(x, y)| (x.ln(), y.ln())).unzip();
        let power = Line::through(&x, &y, Noise::Equal).ok().map(|line| {
            let law = PowerLaw {
                factor: line.intercept.exp(),
                exponent: line.slope,
                std_error: line.slope_std_error,
                off: 0.0,
            };
            PowerLaw { off: off(&|x| law.at(x)), ..law }
        });
        let (x, y): (Vec<f64>, Vec<f64>) = pairs.iter().map(|(x, y)| (law.along(*x), *y)).unzip();
        let weights: Vec<f64> = y.iter().map(|y| 1.0 / (y * y)).collect();
        let affine = Line::through(&x, &y, Noise::Relative { weights: &weights }).ok().map(|line| {
            let fitted = Affine { law, start: line.intercept, step: line.slope, off: 0.0 };
            Affine { off: off(&|x| fitted.at(x)), ..fitted }
        });
        Fits { power, affine }
    }

    /// Whether the power is nearer to what was measured; `None` where one of them is missing, or what they are off by is the
    /// same to a tenth.
    pub fn power_is_nearer(&self) -> Option<bool> {
        let (power, affine) = (self.power?.off, self.affine?.off);
        let told_apart = (power - affine).abs() > 0.1 * power.max(affine);
        told_apart.then_some(power < affine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::simulated::Draws;

    const X: [f64; 7] = [1.0, 4.0, 16.0, 64.0, 256.0, 1024.0, 4096.0];

    fn pairs(of: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        X.map(|x| (x, of(x))).to_vec()
    }

    #[test]
    fn known_laws_come_back() {
        for exponent in [0.3, 1.0, 1.7] {
            let fits = Fits::of(&pairs(|x| 2e-8 * x.powf(exponent)), Law::Linear);
            let power = fits.power.unwrap();
            assert!((power.exponent - exponent).abs() < 1e-12 && power.off < 1e-12, "{power:?}");
            assert!((power.factor / 2e-8 - 1.0).abs() < 1e-12 && power.std_error.unwrap() < 1e-12);
            // A power of one is a line, too.
            if exponent != 1.0 {
                assert_eq!(fits.power_is_nearer(), Some(true));
            }
        }
        for law in [Law::Linear, Law::Logarithmic] {
            let fits = Fits::of(&pairs(|x| 5e-8 + 3e-9 * law.along(x)), law);
            let affine = fits.affine.unwrap();
            assert!((affine.start / 5e-8 - 1.0).abs() < 1e-11 && (affine.step / 3e-9 - 1.0).abs() < 1e-11);
            assert!(affine.off < 1e-11);
            assert_eq!(fits.power_is_nearer(), Some(false));
        }
    }

    /// Scatter of 5 % about N^0.8: the standard error is what exponents scatter by.
    #[test]
    fn the_standard_error_is_what_exponents_scatter_by() {
        let mut draws = Draws::named("the_standard_error_is_what_exponents_scatter_by");
        let runs = 2000;
        let (mut squares, mut told) = (0.0, 0.0);
        for _ in 0..runs {
            let noisy = X.map(|x| (x, 1e-8 * x.powf(0.8) * (0.05 * draws.normal()).exp()));
            let power = Fits::of(&noisy, Law::Linear).power.unwrap();
            squares += (power.exponent - 0.8).powi(2);
            told += power.std_error.unwrap().powi(2);
        }
        // Each sum scatters by √(2/2000) = 3.2 %, the second by √(2/(5·2000)): eight of both together.
        assert!((squares / told).ln().abs() < 8.0 * 0.035, "{squares} {told}");
    }

    #[test]
    fn nothing_is_fitted_to_too_little() {
        for few in [&[][..], &[(1.0, 1.0)], &[(2.0, 1.0), (2.0, 3.0)], &[(1.0, 0.0), (2.0, 1.0)]] {
            assert_eq!(Fits::of(few, Law::Linear), Fits { power: None, affine: None });
        }
    }
}
