//! Whether categories that should be equally likely are: points in boxes of equal area, strata that meet strata.
//!
//! **Statement.** Each of n draws, whatever the earlier ones were, falls into each of C categories with probability 1/C.
//!
//! **Capital.** Before each draw a bettor stakes on category c the share (n_c + a) / (n + Ca), with n_c the count so far, and
//! is paid C to one:
//!
//! ```text
//! K = Π  C (n_c + a) / (n + C a)
//! ```
//!
//! While the statement holds, each factor has mean Σ (1/C) · C (n_c + a)/(n + Ca) = 1, so K reaches 1/α with probability at most
//! α, at whatever moment one looks (Ville 1939). No count needs to be large, no distribution is approximated. (K is the Bayes
//! factor of a Dirichlet prior; a large a seeks small departures in many counts, a small one large departures.) The capital
//! used is the mean over a = 4ʲ, j = −1..=8.
//!
//! **Power.** Where probabilities are off by a root mean square δ of themselves, r = n δ²/C, and a bet with a ≈ 1/δ²: ln K has
//! mean (C/2)(r − ln(1 + r)) and variance C (r/(1 + r))² (1 + 2r)/2, counts taken as normal (`smallest_unevenness`).

use super::evidence::{THRESHOLD_LOG10, ln_average};
use std::f64::consts::LN_10;

const BETS: usize = 10;

/// Counts of draws by category, and the capital they have made.
#[derive(Clone, Debug)]
pub struct Occupancy {
    counts: Vec<u64>,
    total: u64,
    ln: [f64; BETS],
}

impl Occupancy {
    /// - `categories`: how many
    pub fn new(categories: usize) -> Occupancy {
        Occupancy { counts: vec![0; categories], total: 0, ln: [0.0; BETS] }
    }

    /// One more draw. One outside the categories was impossible under the statement: the capital is infinite from then on.
    pub fn record(&mut self, category: usize) {
        let categories = self.counts.len() as f64;
        let Some(count) = self.counts.get_mut(category) else {
            self.ln = [f64::INFINITY; BETS];
            return;
        };
        for (ln, a) in self.ln.iter_mut().zip(bets()) {
            *ln += (categories * (*count as f64 + a) / (self.total as f64 + categories * a)).ln();
        }
        *count += 1;
        self.total += 1;
    }

    /// Draws in each category.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Natural logarithm of the capital.
    ///
    /// - error: absolute, below n · 2⁻⁵⁰ by rounding
    pub fn ln_capital(&self) -> f64 {
        ln_average(self.ln)
    }

    /// Whether the statement is refuted, which happens to a true one with probability at most 1e-6.
    pub fn is_refuted(&self) -> bool {
        self.ln_capital() >= THRESHOLD_LOG10 * LN_10
    }
}

fn bets() -> impl Iterator<Item = f64> {
    (0..BETS as i32).map(|j| 4_f64.powi(j - 1))
}

/// The smallest departure that n draws refute with probability 0.99: the root mean square of p·C − 1 over the categories.
///
/// - infinite without draws; where fewer than about one draw a category is had, only a rough guide
/// - error: about 10 % (simulated in the tests); a factor 4 between bets, and counts taken as normal
pub fn smallest_unevenness(categories: usize, draws: u64) -> f64 {
    let c = categories as f64;
    // Of ten bets one is near enough; 2.33 standard deviations are 99 % of a normal distribution.
    let needed = THRESHOLD_LOG10 * LN_10 + (BETS as f64).ln();
    let surplus = |r: f64| {
        let spread = (c * (1.0 + 2.0 * r) / 2.0).sqrt() * r / (1.0 + r);
        0.5 * c * (r - r.ln_1p()) - 2.33 * spread - needed
    };
    let (mut low, mut high) = (0.0, 1e6);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if surplus(middle) < 0.0 { low = middle } else { high = middle }
    }
    (high * c / draws as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::budget::plausible;
    use super::super::simulated::Draws;
    use super::*;

    fn die(draws: &mut Draws, shares: &[f64], n: u64) -> Occupancy {
        let mut occupancy = Occupancy::new(shares.len());
        for _ in 0..n {
            let mut left = draws.uniform();
            let category = shares.iter().position(|share| {
                left -= share;
                left < 0.0
            });
            occupancy.record(category.unwrap_or(shares.len() - 1));
        }
        occupancy
    }

    #[test]
    fn the_capital_is_the_bayes_factor() {
        // Counts 2 and 1 of three: 3! / (2! 1!) orders apart, a = 1 gives 2³ · B(3, 2) = 8 · 1/12.
        let mut occupancy = Occupancy::new(2);
        [0, 1, 0].into_iter().for_each(|category| occupancy.record(category));
        approx::assert_relative_eq!(occupancy.ln[1].exp(), 8.0 / 12.0, max_relative = 1e-14);
        assert_eq!(occupancy.counts(), [2, 1]);
        occupancy.record(2);
        assert!(occupancy.is_refuted(), "a third side of a coin");
    }

    #[test]
    fn a_fair_die_earns_nothing() {
        let mut draws = Draws::named("a_fair_die_earns_nothing");
        for (sides, n) in [(2, 20), (16, 4_000), (256, 20_000), (500, 100)] {
            let capitals: Vec<f64> = (0..300)
                .map(|_| die(&mut draws, &vec![1.0 / f64::from(sides); sides as usize], n).ln_capital())
                .collect();
            // Markov: at most one in ten reaches ten.
            let reached = capitals.iter().filter(|ln| **ln >= 10_f64.ln()).count();
            assert!(plausible(reached as u64, 300, 0.0, 0.1), "{sides} sides: {reached} of 300");
            assert!(capitals.iter().all(|ln| *ln < THRESHOLD_LOG10 * LN_10));
        }
    }

    #[test]
    fn the_smallest_unevenness_is_seen_and_a_third_of_it_is_not() {
        let mut draws = Draws::named("the_smallest_unevenness_is_seen_and_a_third_of_it_is_not");
        for (sides, n) in [(16_usize, 4_000), (256, 20_000)] {
            let refuted = |draws: &mut Draws, delta: f64| {
                let share = |side: usize| (1.0 + if side.is_multiple_of(2) { delta } else { -delta }) / sides as f64;
                let shares: Vec<f64> = (0..sides).map(share).collect();
                (0..200).filter(|_| die(draws, &shares, n).is_refuted()).count() as u64
            };
            let delta = smallest_unevenness(sides, n);
            let seen = refuted(&mut draws, 1.1 * delta);
            assert!(plausible(seen, 200, 0.99, 1.0), "{sides} sides, {delta}: {seen} of 200");
            let seen = refuted(&mut draws, delta / 3.0);
            assert!(plausible(seen, 200, 0.0, 0.01), "{sides} sides, {delta} / 3: {seen} of 200");
        }
        assert_eq!(smallest_unevenness(4, 0), f64::INFINITY);
    }
}
