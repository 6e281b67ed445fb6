//! In place of `statrs` without the feature `studies`: distribution functions by series and continued fractions, their
//! inverses by Newton's method between bounds. They agree to 1e-9 (tests).

use std::f64::consts::{FRAC_1_SQRT_2, LN_2, PI};

/// Terms of a series or fraction, at most: hundreds suffice up to 10⁴ degrees of freedom.
const MOST_TERMS: usize = 10_000;

/// What a standard normal variable is above with probability `tail`, 0 < tail < ½.
pub(in crate::statistics) fn normal(tail: f64) -> f64 {
    let density = |z: f64| (-0.5 * z * z).exp() / (2.0 * PI).sqrt();
    solve(|z| (tail - 0.5 * libm::erfc(z * FRAC_1_SQRT_2), density(z)))
}

/// What Student's T is above with probability `tail`, 0 < tail < ½.
pub(in crate::statistics) fn student(freedom: f64, tail: f64) -> Option<f64> {
    let half = 0.5 * freedom;
    let ln_scale = libm::lgamma(half + 0.5) - libm::lgamma(half) - 0.5 * (freedom * PI).ln();
    let density = |t: f64| (ln_scale - (half + 0.5) * (t * t / freedom).ln_1p()).exp();
    let above = |t: f64| 0.5 * incomplete_beta(half, 0.5, freedom / (freedom + t * t), t * t / (freedom + t * t));
    (freedom > 0.0).then(|| solve(|t| (tail - above(t), density(t))))
}

/// What a chi-square variable is below with probability p, 0 < p < 1.
pub(in crate::statistics) fn chi_square(freedom: f64, p: f64) -> Option<f64> {
    let half = 0.5 * freedom;
    let ln_scale = -half * LN_2 - libm::lgamma(half);
    let density = |x: f64| (ln_scale + (half - 1.0) * x.ln() - 0.5 * x).exp();
    (freedom > 0.0).then(|| solve(|x| (excess(half, 0.5 * x, p), density(x))))
}

/// The positive x at which a function that rises is 0, from its value and slope; by logarithms, so that it may be of any size.
fn solve(of: impl Fn(f64) -> (f64, f64)) -> f64 {
    let (mut low, mut high) = (-700.0_f64, 700.0_f64);
    let mut at = 0.0_f64;
    for _ in 0..200 {
        let x = at.exp();
        let (value, slope) = of(x);
        if value == 0.0 {
            return x;
        }
        if value > 0.0 {
            high = at
        } else {
            low = at
        }
        let step = value / (slope * x);
        let next = at - step;
        if step.abs() < 1e-15 {
            return next.exp();
        }
        at = if next > low && next < high { next } else { 0.5 * (low + high) };
        if high - low < 1e-15 * (1.0 + at.abs()) {
            break;
        }
    }
    at.exp()
}

/// P(a, x) − p, with P the regularised lower incomplete gamma function, by the tail that keeps its digits.
///
/// Source: NIST Digital Library of Mathematical Functions 8.11.4 (series), 8.9.2 (fraction).
fn excess(a: f64, x: f64, p: f64) -> f64 {
    let front = (a * x.ln() - x - libm::lgamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for k in 1..MOST_TERMS {
            term *= x / (a + k as f64);
            sum += term;
            if term < sum * 1e-17 {
                break;
            }
        }
        return front * sum - p;
    }
    let term = |k: usize| (-(k as f64) * (k as f64 - a), x + 2.0 * k as f64 + 1.0 - a);
    (1.0 - p) - front / fraction(x + 1.0 - a, term)
}

/// I_x(a, b), the regularised incomplete beta function, of x and y = 1 − x.
///
/// Source: NIST Digital Library of Mathematical Functions 8.17.22.
fn incomplete_beta(a: f64, b: f64, x: f64, y: f64) -> f64 {
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, y, x);
    }
    let ln_beta = libm::lgamma(a) + libm::lgamma(b) - libm::lgamma(a + b);
    let front = (a * x.ln() + b * y.ln() - ln_beta).exp() / a;
    let term = |k: usize| {
        let m = (k / 2) as f64;
        let numerator = if k.is_multiple_of(2) {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        };
        (numerator, 1.0)
    };
    front / fraction(1.0, term)
}

/// b₀ + a₁/(b₁ + a₂/(b₂ + …)), by Lentz's method (Thompson & Barnett 1986).
///
/// - `term`: (aₖ, bₖ), k from 1
fn fraction(first: f64, term: impl Fn(usize) -> (f64, f64)) -> f64 {
    let away = |x: f64| if x == 0.0 { 1e-300 } else { x };
    let mut value = away(first);
    let (mut c, mut d) = (value, 0.0);
    for k in 1..MOST_TERMS {
        let (a, b) = term(k);
        c = away(b + a / c);
        d = 1.0 / away(b + a * d);
        value *= c * d;
        if (c * d - 1.0).abs() < 1e-16 {
            break;
        }
    }
    value
}
