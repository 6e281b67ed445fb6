//! Capital: what the bets on one statement have grown to.

use super::bets::{BETS, bets, ln_shares};
use super::{Observed, Statement, ln_of_sum};

/// Σ(x − pivot) is trusted to this times √(n Σ(x − pivot)²), which is at least Σ|x − pivot|, and Σ(x − pivot)² to twice
/// this times itself: the bound of `PowerSums`.
const SUM_ERROR: f64 = 1.0 / (1u64 << 44) as f64;

/// What the bets on one statement have grown to: natural logarithms, one for each bet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capital {
    ln: [f64; BETS],
}

impl Default for Capital {
    fn default() -> Capital {
        Capital::new()
    }
}

impl Capital {
    /// Before any observation: every bet at 1.
    pub fn new() -> Capital {
        Capital { ln: [0.0; BETS] }
    }

    /// What the observations make of it.
    ///
    /// - `planned`: observations that the whole product of batches is to hold, fixed before they are made; the bets are
    ///   tuned to it. More or fewer keep the guarantee and lose some power.
    /// - infinite where the statement makes the observations impossible: a variance of zero and a value outside the
    ///   interval, or values that are not numbers (or whose squares overflow). A variance of zero is never divided by.
    pub fn of(statement: &Statement, observed: &Observed, planned: u64) -> Capital {
        if observed.n == 0 || !statement.says_something() {
            return Capital::new();
        }
        // A variable with a variance is finite with probability 1.
        if !(observed.sum.is_finite() && observed.sum_of_squares.is_finite() && observed.pivot.is_finite()) {
            return Capital { ln: [f64::INFINITY; BETS] };
        }
        if statement.variance == 0.0 {
            let impossible = contradicts_constant(statement, observed);
            return Capital { ln: [if impossible { f64::INFINITY } else { 0.0 }; BETS] };
        }
        let (n, planned) = (observed.n as f64, planned.max(1) as f64);
        let ends =
            [statement.low, statement.high].map(|mean| Standardised::about(mean, statement.variance, observed));
        let mut ln = [0.0; BETS];
        for (ln, bet) in ln.iter_mut().zip(bets(planned)) {
            *ln = ends.iter().map(|end| end.ln_capital(bet, n)).fold(f64::INFINITY, f64::min);
        }
        let mean = observed.pivot + observed.sum / n;
        let nearest = mean.clamp(statement.low, statement.high);
        let squares = Standardised::about(nearest, statement.variance, observed).least_squares();
        ln[BETS - 1] = ln_spread(squares, n, planned);
        Capital { ln }
    }

    /// The product with the capital of independent observations, bet by bet.
    pub fn times(&mut self, other: &Capital) {
        for (a, b) in self.ln.iter_mut().zip(other.ln) {
            // Infinity was impossible under the statement: it stays, whatever another batch lost.
            *a = if *a == f64::INFINITY || b == f64::INFINITY { f64::INFINITY } else { *a + b };
        }
    }

    /// Natural logarithm of the whole capital, the weighted mean over the bets. May be infinite, is never NaN.
    pub fn ln(&self) -> f64 {
        if *self == Capital::new() {
            return 0.0; // which the rounding of the shares would miss
        }
        ln_of_sum(self.ln.iter().zip(ln_shares()).map(|(ln, share)| ln + share))
    }
}

/// Σd/√v and Σd²/v about one mean, with what rounding may have done to each.
pub(super) struct Standardised {
    pub sum: f64,
    pub sum_error: f64,
    pub squares: f64,
    pub squares_error: f64,
}

impl Standardised {
    fn about(mean: f64, variance: f64, observed: &Observed) -> Standardised {
        let scale = variance.sqrt();
        let Deviations { sum, sum_error, squares, squares_error } = Deviations::about(mean, observed);
        Standardised {
            sum: sum / scale,
            sum_error: sum_error / scale,
            squares: squares / scale / scale,
            squares_error: squares_error / scale / scale,
        }
    }

    /// Formula (a) at λ√v = `bet`, least over the rounding.
    pub fn ln_capital(&self, bet: f64, n: f64) -> f64 {
        let gain = bet * self.sum - bet.abs() * self.sum_error;
        let ln = gain - bet * bet * (self.squares + self.squares_error + 2.0 * n) / 6.0;
        // Overflow on both sides says nothing.
        if ln.is_nan() { f64::NEG_INFINITY } else { ln }
    }

    fn least_squares(&self) -> f64 {
        (self.squares - self.squares_error).max(0.0)
    }
}

/// Σ(x − mean) and Σ(x − mean)², with what rounding may have done to each.
struct Deviations {
    sum: f64,
    sum_error: f64,
    squares: f64,
    squares_error: f64,
}

impl Deviations {
    /// With h = mean − pivot: Σd = S₁ − n h, Σd² = S₂ − 2h S₁ + n h².
    fn about(mean: f64, observed: &Observed) -> Deviations {
        let (n, h) = (observed.n as f64, mean - observed.pivot);
        let (s1, s2) = (observed.sum, observed.sum_of_squares);
        let s1_error = SUM_ERROR * n.sqrt() * s2.sqrt();
        let moved = 8.0 * f64::EPSILON * n * h.abs();
        Deviations {
            sum: s1 - n * h,
            sum_error: s1_error + moved,
            squares: (s2 - 2.0 * h * s1 + n * h * h).max(0.0),
            squares_error: 2.0 * SUM_ERROR * s2 + 2.0 * h.abs() * (s1_error + moved + 2.0 * f64::EPSILON * s1.abs()),
        }
    }
}

/// Formula (b), with Σd²/v.
pub(super) fn ln_spread(squares: f64, n: f64, planned: f64) -> f64 {
    (squares / planned).ln_1p() - n * (1.0 / planned).ln_1p()
}

/// Whether no constant in [low, high] could have given these sums: the values' mean is outside, or they lie farther from
/// its middle than its ends do.
fn contradicts_constant(statement: &Statement, observed: &Observed) -> bool {
    let n = observed.n as f64;
    let above = Deviations::about(statement.high, observed);
    let below = Deviations::about(statement.low, observed);
    if above.sum > above.sum_error || below.sum < -below.sum_error {
        return true;
    }
    let middle = statement.low + 0.5 * (statement.high - statement.low);
    let half = (statement.high - middle).max(middle - statement.low);
    let spread = Deviations::about(middle, observed);
    spread.squares - spread.squares_error > n * half * half * (1.0 + 4.0 * f64::EPSILON)
}
