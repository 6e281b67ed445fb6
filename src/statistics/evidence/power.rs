//! Power: what would have been caught.

use super::bets::{LN_SHARE_FAR, LN_SHARE_SPREAD, bets, ln_shares};
use super::capital::{Standardised, ln_spread};
use super::{ALPHA, ln_of_sum};

/// The smallest shift of the mean that is caught with probability 99 %, and every larger one too.
///
/// - `variance` of one observation, n observations as planned; `components` capitals averaged of which one sees the shift
/// - the observed sum is taken as normal about the shift with the stated variance, and falls short of it by its 1 %
///   quantile, 2.33 standard errors; the mixture of bets must then reach 1/`ALPHA`
/// - infinite where variance is negative or not a number or nothing is observed; 0 where the variance is 0
/// - error: for normal data, and for rare hits with a shift that leaves their spread alone, 98.7 to 99.5 % are caught in the
///   simulations of the tests. A shift that brings its own spread (a share of hits of which only twenty are expected) takes
///   half as much again
pub fn smallest_shift(variance: f64, n: u64, components: usize) -> f64 {
    if n == 0 || !(variance >= 0.0 && variance.is_finite()) {
        return f64::INFINITY;
    }
    (variance / n as f64).sqrt() * shift_in_std_errors(n as f64, components)
}

/// The observations needed so that `smallest_shift` is at most `shift`; `u64::MAX` where no number is enough.
pub fn replicates_for(shift: f64, variance: f64, components: usize) -> u64 {
    if !(shift > 0.0 && variance >= 0.0 && variance.is_finite()) {
        return u64::MAX;
    }
    let most = (1u64 << 62) as f64;
    let enough = |n: u64| smallest_shift(variance, n, components) <= shift;
    // In standard errors the shift hardly depends on n, so this settles in a few rounds.
    let mut guess = most;
    for _ in 0..3 {
        guess = (variance * (shift_in_std_errors(guess, components) / shift).powi(2)).ceil().clamp(1.0, most);
    }
    // Few observations need more than that: the least number is found between one too few and one enough.
    let (mut low, mut high) = (guess as u64, guess as u64);
    let mut step = 1;
    while low > 0 && enough(low) {
        high = low;
        low = low.saturating_sub(step);
        step *= 2;
    }
    while !enough(high) {
        if high as f64 >= most {
            return u64::MAX;
        }
        low = high;
        high += step;
        step *= 2;
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if enough(middle) { high = middle } else { low = middle }
    }
    high
}

/// z with P(Z < z) = 0.99.
const Z_99: f64 = 2.326_347_874_040_841;

/// The smallest shift in standard errors of n observations, for variances as stated.
fn shift_in_std_errors(n: f64, components: usize) -> f64 {
    let needed = -ALPHA.ln() + (components.max(1) as f64).ln();
    // A wide enough shift is caught by the spread bet: 1 + 1 + t²/n ≥ e / (share α) · components.
    let top = (n * (1.0 + needed - LN_SHARE_SPREAD).exp()).sqrt();
    // Far bets are a factor 4 apart, and one of them always earns 0.93 an observation. Where that is not enough, gaps are
    // left between them, and what is caught is sought from above.
    let dense = 0.9 * n >= needed - LN_SHARE_FAR;
    let surplus = |t: f64| ln_reached(t, n) - needed;
    let (mut missed, mut caught) = if dense { (1.0, (2.0 * needed).sqrt()) } else { (top, top) };
    if dense {
        while surplus(caught) < 0.0 {
            (missed, caught) = (caught, caught * 1.3);
        }
    } else {
        while surplus(missed) >= 0.0 {
            (missed, caught) = (missed / 1.1, missed);
        }
    }
    // False position, the stale end's weight halved (Dowell and Jarratt 1971).
    let (mut below, mut above) = (surplus(missed), surplus(caught));
    while caught - missed > 1e-9 * caught {
        let middle = (missed - below * (caught - missed) / (above - below)).clamp(missed, caught);
        let value = surplus(middle);
        if value >= 0.0 {
            let last = std::mem::replace(&mut caught, middle);
            (above, below) = (value, 0.5 * below);
            if value <= 1e-9 || last == middle {
                break;
            }
        } else {
            if missed == middle {
                break;
            }
            (missed, below, above) = (middle, value, 0.5 * above);
        }
    }
    caught + Z_99
}

/// What the bets make of a mean that is seen `t` standard errors off, with the variance as stated: natural logarithm. Bets on
/// the other side are worth nothing then.
fn ln_reached(t: f64, n: f64) -> f64 {
    let observed = Standardised { sum: t * n.sqrt(), sum_error: 0.0, squares: n + t * t, squares_error: 0.0 };
    let lines = bets(n).map(|bet| observed.ln_capital(bet, n)).chain([ln_spread(observed.squares, n, n)]);
    ln_of_sum(lines.zip(ln_shares()).map(|(ln, share)| ln + share))
}
