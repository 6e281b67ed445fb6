//! The pair test: which stratum of one pair of dimensions meets which of the next must be uniform.
//!
//! A sampler of stratified pairs of dimensions has to draw, for each pair of dimensions anew, which stratum the k-th point
//! lies in. Where it does not, or draws from too few orders, each pair by itself looks perfect, and an integrand of both (a
//! place on the source and a direction after it) is estimated wrong, with every sample count.
//!
//! **Statement.** Of a sample drawn by lot from each replicate, the pair (stratum of its first two coordinates, stratum of
//! its last two) is any of the A·B pairs with equal probability. One sample a replicate, because the samples of one replicate
//! depend on one another and replicates do not; by lot, because the statement is about the set and not about its k-th point.

use super::Verdict;
use super::occupancy::{Occupancy, smallest_unevenness};

/// Strata of a square: a regular grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    pub columns: usize,
    pub rows: usize,
}

impl Grid {
    /// Strata.
    pub fn strata(self) -> usize {
        self.columns * self.rows
    }

    /// The stratum of a point, row by row; `None` outside [0, 1]². (1 belongs to the last one: rounding may reach it.)
    pub fn stratum(self, [u, v]: [f64; 2]) -> Option<usize> {
        let inside = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v) && self.strata() > 0;
        let part = |x: f64, count: usize| ((x * count as f64) as usize).min(count - 1);
        inside.then(|| part(v, self.rows) * self.columns + part(u, self.columns))
    }
}

/// What the pair test has seen.
#[derive(Clone, Debug)]
pub struct Meetings {
    /// Strata of the first pair of dimensions, of the second.
    pub strata: [Occupancy; 2],
    /// Pairs of strata, `[first][second]`, row-major.
    pub pairs: Occupancy,
    /// Replicates looked at.
    pub replicates: u64,
}

impl Meetings {
    /// `Fail` where the pairs are uneven: of a sampler whose pairs are uniform, with probability at most 1e-6. `Undecided`
    /// where too few replicates were made to see probabilities that are off by a root mean square of `unevenness` of
    /// themselves. Else `Pass`.
    ///
    /// A failure in which one of `strata` is refuted too is one of density and not of pairing.
    pub fn verdict(&self, unevenness: f64) -> Verdict {
        if self.pairs.is_refuted() {
            Verdict::Fail
        } else if smallest_unevenness(self.pairs.counts().len(), self.replicates) <= unevenness {
            Verdict::Pass
        } else {
            Verdict::Undecided
        }
    }
}

/// Runs the pair test.
///
/// - `first`, `second`: strata of the first two coordinates and of the last two; for single dimensions, grids of one row
///   or one column
/// - `seed`: of the lots, unrelated to the sampler's
/// - `points`: sets the four coordinates of each point of a replicate, given its number; replicates are independent
pub fn pairs(
    [first, second]: [Grid; 2],
    replicates: u64,
    seed: u64,
    mut points: impl FnMut(u64, &mut Vec<[f64; 4]>),
) -> Meetings {
    let strata = [first, second].map(|grid| Occupancy::new(grid.strata()));
    let mut meetings = Meetings { strata, pairs: Occupancy::new(first.strata() * second.strata()), replicates };
    let mut set = Vec::new();
    for replicate in 0..replicates {
        set.clear();
        points(replicate, &mut set);
        let Some([a, b, c, d]) = set.get(lot(seed, replicate, set.len())).copied() else { continue };
        let [a, b] = [first.stratum([a, b]), second.stratum([c, d])];
        // Outside the square is outside all categories.
        meetings.strata[0].record(a.unwrap_or(usize::MAX));
        meetings.strata[1].record(b.unwrap_or(usize::MAX));
        let pair = a.zip(b).map(|(a, b)| a * second.strata() + b);
        meetings.pairs.record(pair.unwrap_or(usize::MAX));
    }
    meetings
}

/// A number below `count` (0 where that is 0), uniform to count · 2⁻⁶⁴: SplitMix64's output for a state of its own.
fn lot(seed: u64, replicate: u64, count: usize) -> usize {
    let z = seed.wrapping_add(replicate.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (((z ^ (z >> 31)) as u128 * count as u128) >> 64) as usize
}

#[cfg(test)]
mod tests {
    use super::super::budget::seed_of;
    use super::super::simulated::Draws;
    use super::*;

    const GRID: Grid = Grid { columns: 4, rows: 4 };

    /// 4 × 4 strata in both pairs of dimensions; with probability `locked` the orders of the two are one.
    fn meetings(name: &str, locked: f64, replicates: u64) -> Meetings {
        let mut draws = Draws::named(name);
        pairs([GRID, GRID], replicates, seed_of("lots"), |_, set| {
            let shift = (16.0 * draws.uniform()) as usize;
            let other = if draws.hit(locked) == 1.0 { shift } else { (16.0 * draws.uniform()) as usize };
            for k in 0..16 {
                let [a, b] = [(k + shift) % 16, (k + other) % 16];
                let mut inside = |column: usize| (column as f64 + draws.uniform()) / 4.0;
                set.push([inside(a % 4), inside(a / 4), inside(b % 4), inside(b / 4)]);
            }
        })
    }

    #[test]
    fn free_orders_pass_and_locked_ones_fail() {
        let name = "free_orders_pass_and_locked_ones_fail";
        assert_eq!(meetings(name, 0.0, 20_000).verdict(0.15), Verdict::Pass);
        assert_eq!(meetings(name, 0.0, 20).verdict(0.15), Verdict::Undecided);
        for (locked, replicates) in [(1.0, 50), (0.1, 20_000), (0.05, 20_000)] {
            let seen = meetings(name, locked, replicates);
            assert_eq!(seen.verdict(0.15), Verdict::Fail, "{locked}: {}", seen.pairs.ln_capital());
            // Each pair of dimensions by itself is beyond reproach.
            assert!(seen.strata.iter().all(|strata| !strata.is_refuted()));
        }
    }

    #[test]
    fn a_wrong_density_shows_in_its_own_strata() {
        let mut draws = Draws::named("a_wrong_density_shows_in_its_own_strata");
        let seen = pairs([GRID, GRID], 2_000, 1, |_, set| {
            let [a, b, c, d] = std::array::from_fn(|_| draws.uniform());
            set.push([a.sqrt(), b, c, d]);
        });
        assert!(seen.strata[0].is_refuted() && !seen.strata[1].is_refuted());
        assert_eq!(seen.verdict(1.0), Verdict::Fail);
        let outside = pairs([GRID, GRID], 1, 1, |_, set| set.push([0.5, 0.5, 0.5, 1.5]));
        assert!(outside.strata[1].is_refuted() && outside.pairs.is_refuted());
        assert_eq!(pairs([GRID, GRID], 5, 1, |_, _| {}).pairs.counts().iter().sum::<u64>(), 0);
    }
}
