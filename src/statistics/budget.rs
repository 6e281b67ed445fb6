//! One false-alarm budget for all tests that draw random numbers.
//!
//! A test that simulates takes its seed from its own name (`seed_of`), so that adding, renaming or reordering tests
//! changes no other test's numbers, and nobody can shop for a seed without renaming a law. And it may fail, over the choice
//! of that name, with probability at most `PER_TEST` where the code is right (`plausible`): a thousand such tests raise a
//! false alarm with probability at most `WHOLE_SUITE`.

use statrs::distribution::{Binomial, DiscreteCDF};

/// Probability, at most, that correct code fails one statistical test.
pub const PER_TEST: f64 = 1e-6;
/// Probability, at most, that correct code fails any of a thousand.
pub const WHOLE_SUITE: f64 = 1e-3;

/// The seed of the test of that name: FNV-1a over its bytes, finished by the mixer of SplitMix64, so that similar names give
/// unrelated seeds. Stable for ever.
pub fn seed_of(name: &str) -> u64 {
    let hash = name
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    let mixed = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// Whether `count` of `trials` independent successes can be had with some probability of success in [low, high]: false
/// where so extreme a count has probability below `PER_TEST` for all of them.
///
/// - `low`, `high` in [0, 1]; 0 as `low` or 1 as `high` leaves that side free
/// - error: exact binomial tails (statrs), about 1e-12 relative
pub fn plausible(count: u64, trials: u64, low: f64, high: f64) -> bool {
    let few_enough = count == 0
        || high >= 1.0
        || Binomial::new(high, trials).is_ok_and(|successes| successes.sf(count - 1) >= PER_TEST / 2.0);
    let many_enough =
        low <= 0.0 || Binomial::new(low, trials).is_ok_and(|successes| successes.cdf(count) >= PER_TEST / 2.0);
    few_enough && many_enough
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_is_its_name() {
        assert_ne!(seed_of("a"), seed_of("b"));
        // Changing this number changes the numbers of every statistical test.
        assert_eq!(seed_of("umbra_receives_nothing"), 0x4613_370e_0b43_3b77);
    }

    #[test]
    fn counts_are_refused_on_the_side_where_they_are_extreme() {
        assert!(plausible(500, 1000, 0.5, 0.5));
        assert!(plausible(572, 1000, 0.5, 0.5) && !plausible(590, 1000, 0.5, 0.5));
        assert!(plausible(428, 1000, 0.5, 0.5) && !plausible(410, 1000, 0.5, 0.5));
        assert!(plausible(1000, 1000, 0.9, 1.0) && !plausible(850, 1000, 0.9, 1.0));
        assert!(plausible(0, 1000, 0.0, 0.1) && !plausible(160, 1000, 0.0, 0.1));
        assert!(!plausible(1, 1000, 0.0, 0.0) && plausible(0, 1000, 0.0, 0.0));
    }
}
