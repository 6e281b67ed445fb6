//! Whether estimates vary by events that are too rare to say by how much.

use crate::oracle::variance::Spread;
use crate::statistics::PowerSums;

/// Events of the rarer kind (rays that arrive, or that are blocked) below which no interval is printed.
const FEWEST_EVENTS: f64 = 30.0;

/// With hits of probability p among N samples, R replicates have an excess kurtosis of (1/p + …)/N, and p N R hits: the
/// excess over R is one over the number of events, whichever kind is the rarer. It is taken as predicted; as measured
/// where nothing is.
///
/// - `sums`: of all replicates
/// - `replicates`: those that an interval is to be drawn from
pub(super) fn is_rare(sums: &PowerSums, predicted: Option<Spread>, replicates: u64) -> bool {
    is_rare_together(std::iter::once((sums, predicted)), false, replicates)
}

/// The same of the mean over several points: of the sum of their squared deviations.
///
/// - `points`: of each its sums, of all replicates, and its prediction
/// - `shared`: whether one event may hit all of them at once
pub(super) fn is_rare_together<'a>(
    points: impl Iterator<Item = (&'a PowerSums, Option<Spread>)>,
    shared: bool,
    replicates: u64,
) -> bool {
    let (mut variance, mut cumulants, mut roots) = (0.0, 0.0, 0.0);
    for (sums, predicted) in points {
        // Where it is predicted the sample has no say: to print only what happens to look tame would print what is too small.
        let spread = match predicted {
            Some(spread) if spread.variance > 0.0 => spread,
            _ => {
                let variance = sums.variance().unwrap_or(0.0);
                let excess = sums.kurtosis().map_or(0.0, |kurtosis| kurtosis - 3.0);
                Spread { variance, fourth_cumulant: excess * variance * variance }
            }
        };
        variance += spread.variance;
        cumulants += spread.fourth_cumulant;
        roots += spread.fourth_cumulant.max(0.0).sqrt();
    }
    let cumulant = if shared { roots * roots } else { cumulants };
    cumulant * FEWEST_EVENTS > variance * variance * replicates as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R replicates of one sample that arrives with probability p.
    fn hits(p: f64, replicates: u32) -> bool {
        let variance = p * (1.0 - p);
        let spread = Spread { variance, fourth_cumulant: variance * (1.0 - 6.0 * variance) };
        let mut sums = PowerSums::about(p);
        (0..replicates).for_each(|_| sums.add(0.0));
        is_rare(&sums, Some(spread), u64::from(replicates))
    }

    #[test]
    fn thirty_events_of_the_rarer_kind_are_enough() {
        assert!(hits(0.01, 2500) && !hits(0.01, 3500));
        assert!(hits(0.99, 2500) && !hits(0.99, 3500));
        assert!(!hits(0.5, 30));
    }

    #[test]
    fn where_nothing_is_predicted_the_sample_says_so() {
        let sums_of = |hits: u32| {
            let mut sums = PowerSums::about(0.0);
            (0..1000).for_each(|k| sums.add(f64::from(u8::from(k < hits))));
            sums
        };
        assert!(is_rare(&sums_of(5), None, 1000) && !is_rare(&sums_of(60), None, 1000));
    }
}
