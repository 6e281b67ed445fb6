//! Limits of a probability from a count.

use statrs::distribution::{Beta, ContinuousCDF};

use super::interval::Interval;

/// Clopper and Pearson's interval (Biometrika 26, 1934): the probabilities under which neither so many nor so few
/// successes have a chance below (1 − level)/2. Exact tails, so it covers with `level` at least, whatever the
/// probability.
///
/// - `count` in [0, trials]; need not be whole (a mean of dependent trials, counted as fewer)
/// - `None` where it is not, where nothing was tried, or for a level outside (0, 1)
/// - error: absolute, below 1e-9
pub fn clopper_pearson(count: f64, trials: f64, level: f64) -> Option<Interval> {
    let tail = 0.5 * (1.0 - level);
    Some(Interval { low: least(count, trials, tail)?, high: most(count, trials, tail)? })
}

/// The largest probability under which `count` successes or fewer still have the chance 1 − level: the one-sided upper
/// limit, 1 − (1 − level)^(1/n) where there was none.
///
/// - domain and error as [`clopper_pearson`]
pub fn upper_limit(count: f64, trials: f64, level: f64) -> Option<f64> {
    most(count, trials, 1.0 - level)
}

/// The smallest probability under which `count` successes or more still have the chance 1 − level.
///
/// - domain and error as [`clopper_pearson`]
pub fn lower_limit(count: f64, trials: f64, level: f64) -> Option<f64> {
    least(count, trials, 1.0 - level)
}

fn sound(count: f64, trials: f64, tail: f64) -> bool {
    trials > 0.0 && trials.is_finite() && (0.0..=trials).contains(&count) && 0.0 < tail && tail < 1.0
}

/// P(X ≥ count) = tail, where X ≥ count is the same event as a Beta(count, trials − count + 1) variable below p.
fn least(count: f64, trials: f64, tail: f64) -> Option<f64> {
    if !sound(count, trials, tail) {
        return None;
    }
    if count == 0.0 { Some(0.0) } else { quantile(count, trials - count + 1.0, tail) }
}

fn most(count: f64, trials: f64, tail: f64) -> Option<f64> {
    if !sound(count, trials, tail) {
        return None;
    }
    if count == trials { Some(1.0) } else { quantile(count + 1.0, trials - count, 1.0 - tail) }
}

/// By bisection: the distribution function is what is trusted.
fn quantile(a: f64, b: f64, probability: f64) -> Option<f64> {
    let beta = Beta::new(a, b).ok()?;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if beta.cdf(middle) < probability { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::simulated::Draws;
    use statrs::distribution::{Binomial, DiscreteCDF};

    #[test]
    fn no_success_leaves_the_root_of_the_level() {
        for n in [1.0, 10.0, 3000.0, 30_000.0] {
            let expected = 1.0 - 0.05_f64.powf(1.0 / n);
            assert!((upper_limit(0.0, n, 0.95).unwrap() - expected).abs() < 1e-9, "{n}");
            assert!((lower_limit(n, n, 0.95).unwrap() - (1.0 - expected)).abs() < 1e-9, "{n}");
            assert_eq!((lower_limit(0.0, n, 0.95), upper_limit(n, n, 0.95)), (Some(0.0), Some(1.0)));
        }
    }

    #[test]
    fn limits_are_where_the_binomial_tails_say() {
        for (count, trials) in [(1, 10), (7, 20), (950, 1000), (3, 30_000)] {
            let limits = clopper_pearson(count as f64, trials as f64, 0.95).unwrap();
            let few = Binomial::new(limits.high, trials).unwrap().cdf(count);
            let many = Binomial::new(limits.low, trials).unwrap().sf(count - 1);
            assert!((few - 0.025).abs() < 1e-5 && (many - 0.025).abs() < 1e-5, "{count} of {trials}: {few} {many}");
        }
        // Printed: 10 successes in 20 trials (Clopper and Pearson 1934, and any table since).
        let half = clopper_pearson(10.0, 20.0, 0.95).unwrap();
        assert!((half.low - 0.271_957).abs() < 1e-6 && (half.high - 0.728_043).abs() < 1e-6, "{half:?}");
    }

    #[test]
    fn the_interval_covers_at_least_what_it_claims() {
        let mut draws = Draws::named("clopper_pearson_covers");
        for p in [0.01, 0.3, 0.95] {
            let runs = 2000;
            let covered = (0..runs)
                .filter(|_| {
                    let count: f64 = (0..50).map(|_| draws.hit(p)).sum();
                    clopper_pearson(count, 50.0, 0.95).unwrap().contains(p)
                })
                .count();
            assert!(crate::statistics::budget::plausible(covered as u64, runs, 0.95, 1.0), "{p}: {covered}");
        }
    }

    #[test]
    fn what_is_no_count_has_no_limits() {
        for (count, trials) in [(-1.0, 5.0), (6.0, 5.0), (0.0, 0.0), (f64::NAN, 5.0), (1.0, f64::INFINITY)] {
            assert_eq!(clopper_pearson(count, trials, 0.95), None);
        }
        assert_eq!((clopper_pearson(1.0, 2.0, 1.0), upper_limit(1.0, 2.0, 0.0)), (None, None));
    }
}
