//! The gate: how much a stranger should believe that a stated mean is wrong.
//!
//! **Statement.** n independent observations Xᵢ share a mean μ that lies in [low, high], and each has variance at most v
//! about it. Nothing else: no bound, no symmetry, no normality; v may be an upper bound.
//!
//! **Capital.** A bettor starts with 1 and plays games that are not in his favour while the statement holds. For every
//! real y, exp(y − y²/6) ≤ 1 + y + y²/3 (Delyon 2009). With d = X − μ and any real λ the right side at y = λd has mean at
//! most 1 + λ²v/3 ≤ exp(λ²v/3), so that
//!
//! ```text
//! K(λ; μ) = Π exp(λ dᵢ − λ² (dᵢ² + 2v) / 6) = exp(λ Σd − λ² (Σd² + 2nv) / 6)                       (a)
//! ```
//!
//! has factors of mean at most 1: a supermartingale from 1, which ever reaches 1/α with probability at most α (Ville
//! 1939), whenever one looks. It needs only the sums of d and d².
//!
//! **Interval.** μ is not known, but inf K(λ; μ) over [low, high] is at most the K of the true μ. In μ, ln K is a concave
//! parabola (−λ²n/6 before μ²), so its infimum is the smaller of its values at the two ends: exact, no search. (λ > 0
//! is held by `high` unless the mean is more than 3/λ beyond it; then by `low`.)
//!
//! **Rounding** is no evidence. Sums carry an error (`SUM_ERROR`), and the capital is the least over it.
//!
//! **Bets.** Averages of such capitals are such capitals, with any fixed weights, whatever their dependence:
//! - ten *near* bets λ√(v·planned) = ±6·2ʲ, j = −1..=3, share 9/10: shifts of a few standard errors, the threshold's own;
//! - twenty *far* bets λ√v = ±4⁻ᵏ, k = 1..=10, share 8/100. In (a) a factor is largest at λd = 3 and below 1 past 6: a near
//!   bet is blind to shifts beyond some 2√n standard deviations (a wrong value of a precise estimator!). These are not;
//! - one *spread* bet, share 2/100, for whatever is farther: (1 + y + y²/3)/(1 + λ²v/3) averaged over ±λ is
//!   (1 + y²/3)/(1 + λ²v/3), and Π(1 + a) ≥ 1 + Σa for a ≥ 0, so with λ²v/3 = 1/planned
//!
//! ```text
//! K = (1 + Σd² / (v·planned)) / (1 + 1/planned)ⁿ                                                    (b)
//! ```
//!
//!   lies below a supermartingale; its infimum over μ is at the μ nearest the mean observed.
//!
//! **Cost.** Against a normal test at α = 1e-6, which catches 7.2 standard errors with probability 0.99, this one needs
//! 8.0 to 8.2 from 256 observations on, 9.7 at 32 (`smallest_shift`; simulated in the tests): an eighth more error bar buys
//! every distribution and every stop. Below some 20 observations no moderate shift is enough: a factor of (a) is at most
//! exp(1.5). The total absence of hits is seen where some 25 are expected.
//!
//! **Batches.** Products of capitals on independent data are capitals: bet by bet (`Capital::times`), so that a small bias
//! seen by many batches adds up. Capitals on dependent data are averaged (`ln_average`).
//!
//! **Limits.** A variance that was stated too small makes the capital grow as a shifted mean does: judge the variance by
//! its own statement first. A mean that differs between observations, each within the interval, is not covered: the
//! statement is about one mean per batch (batches that are multiplied may differ).
//!
//! Sources: B. Delyon, Exponential inequalities for sums of weakly dependent variables, Electron. J. Probab. 14, 2009;
//! S. R. Howard, A. Ramdas, J. McAuliffe, J. Sekhon, Time-uniform, nonparametric, nonasymptotic confidence sequences,
//! Ann. Statist. 49, 2021 (its finite-variance case); J. Ville, Étude critique de la notion de collectif, 1939. The far
//! and spread bets are derived above.

mod bets;
mod capital;
mod power;
#[cfg(feature = "studies")]
#[cfg(test)]
mod tests;

pub use capital::Capital;
pub use power::{replicates_for, smallest_shift};

use super::moments::PowerSums;

/// Probability, at most, that a true statement is ever refuted.
pub const ALPHA: f64 = 1e-6;
/// log₁₀ of the capital that refutes: −log₁₀ `ALPHA`.
pub const THRESHOLD_LOG10: f64 = 6.0;

/// The mean of the observations lies in [low, high]; the variance of each about it is at most `variance`.
///
/// Where a bound is NaN, low > high, or the variance is negative, infinite or NaN, nothing is stated and no observation is
/// evidence; `smallest_shift` is then infinite, so that nothing passes by it either.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statement {
    pub low: f64,
    pub high: f64,
    pub variance: f64,
}

impl Statement {
    /// The mean is `mean`, give or take `margin` ≥ 0.
    pub fn near(mean: f64, margin: f64, variance: f64) -> Statement {
        Statement { low: mean - margin, high: mean + margin, variance }
    }

    fn says_something(&self) -> bool {
        self.low <= self.high && self.low.is_finite() && self.high.is_finite() && self.is_variance_usable()
    }

    fn is_variance_usable(&self) -> bool {
        self.variance >= 0.0 && self.variance.is_finite()
    }
}

/// n observations through their sums about a pivot. The nearer the pivot is to the interval, the less is lost to rounding;
/// in it, nothing is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed {
    pub n: u64,
    pub pivot: f64,
    /// Σ(x − pivot).
    pub sum: f64,
    /// Σ(x − pivot)².
    pub sum_of_squares: f64,
}

impl Observed {
    /// The values themselves.
    pub fn values(sums: &PowerSums) -> Observed {
        Observed {
            n: sums.count(),
            pivot: sums.pivot(),
            sum: sums.sum_of_powers(1),
            sum_of_squares: sums.sum_of_powers(2),
        }
    }

    /// The squared deviations from the pivot, for a statement about a variance: where the pivot is the mean, their mean is
    /// the variance v and their variance is (fourth central moment) − v².
    pub fn squared_deviations(sums: &PowerSums) -> Observed {
        Observed { n: sums.count(), pivot: 0.0, sum: sums.sum_of_powers(2), sum_of_squares: sums.sum_of_powers(4) }
    }
}

/// Natural logarithm of the mean of capitals given by their natural logarithms. 0 where there are none.
///
/// An average of capitals is a capital whatever depends on whatever, so this joins points, means and contrasts of the same
/// data.
pub fn ln_average(components: impl IntoIterator<Item = f64>) -> f64 {
    let mut count = 0u64;
    let sum = ln_of_sum(components.into_iter().inspect(|_| count += 1));
    if count == 0 { 0.0 } else { sum - (count as f64).ln() }
}

/// log₁₀ of a capital for tables, where every field is a number: from its natural logarithm, held within ±300.
/// An impossible observation reads 300.
pub fn log10_capped(ln: f64) -> f64 {
    (ln / std::f64::consts::LN_10).clamp(-300.0, 300.0)
}

/// ln Σ exp(xᵢ) without overflow, in one pass.
fn ln_of_sum(terms: impl Iterator<Item = f64>) -> f64 {
    let (mut largest, mut sum) = (f64::NEG_INFINITY, 0.0);
    for term in terms {
        if term > largest {
            sum = if largest == f64::NEG_INFINITY { 1.0 } else { sum * (largest - term).exp() + 1.0 };
            largest = term;
        } else if term > f64::NEG_INFINITY && largest < f64::INFINITY {
            sum += (term - largest).exp();
        }
    }
    if sum == 0.0 || largest == f64::INFINITY { largest } else { largest + sum.ln() }
}
