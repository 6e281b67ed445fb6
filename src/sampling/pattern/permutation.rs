//! Random permutations of any length, in memory that does not grow with it.
//!
//! **Short ones are tables**, shuffled (Fisher & Yates): exactly uniform, and quick.
//!
//! **Long ones are computed point by point**, nothing stored: the swap-or-not shuffle (Hoang, Morris & Rogaway, *An Enciphering Scheme Based on a Card Shuffle*, CRYPTO 2012). Of
//! each round, a number K uniform below the length pairs x with K − x (modulo the length), and one coin for each pair says
//! whether its two change places. Each x leaves a round where it was with probability 1/2 + 1/(2L), and anywhere with
//! equal probability otherwise, so that after r rounds any one place is uniform to 2⁻ʳ in total variation. Whole permutations of up
//! to six are uniform to 1e-5 in total variation (computed from the chain itself: 3e-8, 4e-8, 8e-6, 4e-6, 4e-6 for lengths
//! 2 to 6), pairs of places nearer still. It works on every length as it is: no padding to a power of two, no walking of
//! cycles, no branch.

use super::super::seed::{mix, mix_again};
use super::Lanes;

/// 2⁻²⁴ = 6e-8 of a permutation is left as it was.
const ROUNDS: u64 = 24;
/// 2⁶⁴ / φ, odd.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Longest table, entries.
const LONGEST_TABLE: u64 = 1 << 14;

/// One permutation.
#[derive(Clone, Debug)]
pub(super) struct Permutation {
    length: u64,
    /// Empty where it is computed.
    table: Vec<u32>,
    source: Permutations,
}

impl Permutation {
    pub fn draw(length: u64, lanes: &mut Lanes) -> Permutation {
        let source = Permutations::draw(lanes);
        let table = if length <= LONGEST_TABLE { source.tables([length]) } else { Vec::new() };
        Permutation { length, table, source }
    }

    /// Replaces each index, below the length, by its place.
    #[inline(always)]
    pub fn permute(&self, index: &mut [u64]) {
        if self.table.is_empty() {
            self.source.permute(index, self.length);
        } else {
            index.iter_mut().for_each(|x| *x = u64::from(self.table[*x as usize]));
        }
    }
}

/// Many permutations, told apart by a number.
#[derive(Clone, Debug)]
pub(super) struct Family {
    /// One permutation after another; empty where they are computed.
    table: Vec<u32>,
    source: Permutations,
}

impl Family {
    /// - `lengths`: of the permutations; their sum is `total`
    pub fn draw(total: u64, lengths: impl IntoIterator<Item = u64>, lanes: &mut Lanes) -> Family {
        let source = Permutations::draw(lanes);
        let table = if total <= LONGEST_TABLE { source.tables(lengths) } else { Vec::new() };
        Family { table, source }
    }

    /// Replaces each index by its place in a permutation of its own; lengths and indices below 2³².
    ///
    /// - `length`: of that permutation
    /// - `before`: the lengths of all permutations before it, added up
    #[inline(always)]
    pub fn permute_each(&self, index: &mut [u64], length: &[u64], before: &[u64]) {
        if self.table.is_empty() {
            self.source.permute_each(index, length, before);
        } else {
            index.iter_mut().zip(before).for_each(|(x, before)| *x = u64::from(self.table[(before + *x) as usize]));
        }
    }
}

/// A source of permutations: as many as one likes, told apart by a number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Permutations {
    first: u64,
    second: u64,
}

impl Permutations {
    pub fn draw(lanes: &mut Lanes) -> Permutations {
        Permutations { first: lanes.next_words()[0], second: lanes.next_words()[0] }
    }

    /// Permutations of these lengths, one after another.
    fn tables(self, lengths: impl IntoIterator<Item = u64>) -> Vec<u32> {
        let mut tables = Vec::new();
        for length in lengths {
            let start = tables.len();
            for k in 0..length {
                let (word, _) = self.round(tables.len() as u64);
                let place = ((u128::from(word) * u128::from(k + 1)) >> 64) as usize;
                tables.push(k as u32);
                // Inside out: what was there moves to the end, and the new one takes its place.
                tables.swap(start + place, start + k as usize);
            }
        }
        tables
    }

    /// Replaces each index, below `length`, by its place in one permutation.
    #[inline(always)]
    fn permute(self, index: &mut [u64], length: u64) {
        for round in 0..ROUNDS {
            let (turn, coins) = self.round(round);
            // The high half of a product: uniform to length · 2⁻⁶⁴.
            let turn = ((turn as u128 * length as u128) >> 64) as u64;
            for x in index.iter_mut() {
                *x = swap_or_not(*x, turn, length, coins);
            }
        }
    }

    /// Replaces each index by its place in the permutation `which` of its own, both below 2³². The permutations share the
    /// turns K and not the coins.
    ///
    /// - `length`: one for each index, below 2³²; the same for all indices of one `which`
    #[inline(always)]
    fn permute_each(self, index: &mut [u64], length: &[u64], which: &[u64]) {
        for round in 0..ROUNDS {
            let (turn, coins) = self.round(round);
            let turn = turn >> 32;
            for ((x, length), which) in index.iter_mut().zip(length).zip(which) {
                let own = coins.wrapping_add((which << 32).wrapping_mul(STEP));
                *x = swap_or_not(*x, (turn * length) >> 32, *length, own);
            }
        }
    }

    /// Words for the turn and the coins of a round.
    #[inline(always)]
    fn round(self, round: u64) -> (u64, u64) {
        let step = STEP.wrapping_mul(round + 1);
        (mix(self.first.wrapping_add(step)), mix_again(self.second.wrapping_add(step)))
    }
}

#[inline(always)]
fn swap_or_not(x: u64, turn: u64, length: u64, coins: u64) -> u64 {
    let other = if x <= turn { turn - x } else { turn + length - x };
    let coin = mix(coins.wrapping_add(x.max(other).wrapping_mul(STEP)));
    if coin >> 63 == 1 { other } else { x }
}

#[cfg(test)]
mod tests {
    use super::super::StreamKey;
    use super::*;
    use crate::statistics::budget::plausible;

    #[test]
    fn tables_hold_each_place_once_and_each_order_equally_often() {
        let mut counts = std::collections::HashMap::new();
        let runs = 24_000_u64;
        for seed in 0..runs {
            let tables = drawn(seed).tables([3, 4]);
            let mut sorted = tables.clone();
            sorted[..3].sort_unstable();
            sorted[3..].sort_unstable();
            assert_eq!(sorted, [0, 1, 2, 0, 1, 2, 3]);
            *counts.entry(tables[3..].to_vec()).or_insert(0_u64) += 1;
        }
        assert_eq!(counts.len(), 24);
        for (order, count) in counts {
            assert!(plausible(count, runs, 1.0 / 24.0, 1.0 / 24.0), "{order:?}: {count} of {runs}");
        }
    }

    fn drawn(seed: u64) -> Permutations {
        Permutations::draw(&mut Lanes::new(StreamKey::root(seed), 1))
    }

    #[test]
    fn every_place_is_taken_once() {
        for length in [1_u64, 2, 3, 5, 8, 31, 100, 1024, 4099] {
            let mut places: Vec<u64> = (0..length).collect();
            drawn(length).permute(&mut places, length);
            places.sort_unstable();
            assert!(places.into_iter().eq(0..length));
        }
        // A family, of two lengths at once.
        let rows: Vec<(u64, u64)> = (0..40).map(|which| (which, 7 + which % 2)).collect();
        let all: Vec<[u64; 3]> = rows.iter().flat_map(|(which, l)| (0..*l).map(|x| [x, *l, *which])).collect();
        let [mut index, length, which] = [0, 1, 2].map(|k| all.iter().map(|row| row[k]).collect::<Vec<u64>>());
        drawn(1).permute_each(&mut index, &length, &which);
        for (row, l) in rows {
            let mut places: Vec<u64> = (0..index.len()).filter(|i| which[*i] == row).map(|i| index[i]).collect();
            places.sort_unstable();
            assert!(places.into_iter().eq(0..l));
        }
    }

    #[test]
    fn long_permutations_stay_inside_and_go_back() {
        // No table could hold this one. Distinct indices keep distinct places.
        let length = (1 << 52) - 3;
        let mut places: Vec<u64> = (0..1000).map(|k| k * 4_503_599_627_370).collect();
        drawn(3).permute(&mut places, length);
        assert!(places.iter().all(|x| *x < length));
        let distinct: std::collections::HashSet<u64> = places.iter().copied().collect();
        assert_eq!(distinct.len(), places.len());
    }

    /// The chain itself, with ideal coins: total variation from the uniform distribution over all permutations of `n`.
    fn distance_after(rounds: u64, n: usize) -> f64 {
        let mut all: Vec<Vec<usize>> = vec![vec![]];
        for _ in 0..n {
            all = all
                .iter()
                .flat_map(|p| {
                    (0..n).filter(|x| !p.contains(x)).map(|x| [p.as_slice(), &[x]].concat()).collect::<Vec<_>>()
                })
                .collect();
        }
        let place: std::collections::HashMap<Vec<usize>, usize> =
            all.iter().cloned().enumerate().map(|(i, p)| (p, i)).collect();
        let mut share = vec![0.0; all.len()];
        share[0] = 1.0;
        for _ in 0..rounds {
            let mut next = vec![0.0; all.len()];
            for turn in 0..n {
                for coins in 0..1_u32 << n {
                    let weight = 1.0 / n as f64 / f64::from(1_u32 << n);
                    for (from, p) in all.iter().enumerate() {
                        let moved = p.iter().map(|x| {
                            let other = (turn + n - x) % n;
                            if coins >> (*x).max(other) & 1 == 1 { other } else { *x }
                        });
                        next[place[&moved.collect::<Vec<_>>()]] += weight * share[from];
                    }
                }
            }
            share = next;
        }
        0.5 * share.iter().map(|s| (s - 1.0 / all.len() as f64).abs()).sum::<f64>()
    }

    #[test]
    fn whole_short_permutations_are_uniform() {
        for n in 2..=5 {
            let distance = distance_after(ROUNDS, n);
            assert!(distance < 1e-5, "length {n}: {distance}");
        }
    }
}
