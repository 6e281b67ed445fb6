//! Keys of random streams.
//!
//! Every draw comes from a stream keyed by what it is for: seed, configuration, purpose, strategy, samples, replicate,
//! point (unless points are shared) and source. Nothing else moves a number: renaming, adding or reordering cases,
//! threads and shards do not.

use super::Strategy;

/// Which of the independent runs over a case a draw belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Estimates the variance that plans and judges.
    Pilot,
    /// Is judged.
    Measurement,
}

/// A 128-bit hash of the parts absorbed so far.
///
/// Two 64-bit halves are mixed by different bijections, so that for a fixed prefix no two words collide in either half;
/// with 2⁴⁰ streams the chance that any two agree in all 128 bits is below 2⁻⁴⁸.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamKey {
    pub(super) first: u64,
    pub(super) second: u64,
}

impl StreamKey {
    /// The key that all streams of a seed start from.
    pub fn root(seed: u64) -> StreamKey {
        // Digits of π, so that seed 0 is no special state (Blowfish's first constants).
        StreamKey { first: 0x243f_6a88_85a3_08d3, second: 0x1319_8a2e_0370_7344 }.with(seed)
    }

    /// The key of everything below `word`.
    #[inline(always)]
    pub fn with(self, word: u64) -> StreamKey {
        StreamKey {
            first: mix(self.first.rotate_left(23).wrapping_add(word)),
            second: mix_again(self.second.rotate_left(41) ^ word),
        }
    }

    /// The family of streams for one cell of a study; replicate, point and source are absorbed below it.
    ///
    /// - `configuration`: [`crate::configuration::Digest::key`]
    /// - `samples`: points on each source
    pub fn cell(seed: u64, configuration: u64, purpose: Purpose, strategy: Strategy, samples: u64) -> StreamKey {
        StreamKey::root(seed).with(configuration).with(purpose as u64).with(strategy.stream_id()).with(samples)
    }
}

/// Stafford's variant 13 of the MurmurHash3 finaliser, as in SplitMix64 (Steele, Lea & Flood 2014).
#[inline(always)]
pub(super) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The MurmurHash3 finaliser itself (Appleby 2011).
#[inline(always)]
pub(super) fn mix_again(mut z: u64) -> u64 {
    z = (z ^ (z >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    z = (z ^ (z >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    z ^ (z >> 33)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn keys_differ_in_every_part() {
        let cell = |seed, case, purpose, strategy, samples| StreamKey::cell(seed, case, purpose, strategy, samples);
        let base = (1, 2, Purpose::Pilot, Strategy::Random, 4);
        let mut keys = HashSet::new();
        for key in [
            cell(base.0, base.1, base.2, base.3, base.4),
            cell(2, 2, base.2, base.3, base.4),
            cell(1, 1, base.2, base.3, base.4),
            cell(1, 2, Purpose::Measurement, base.3, base.4),
            cell(1, 2, base.2, Strategy::Stratified, base.4),
            cell(1, 2, base.2, base.3, 5),
        ] {
            for replicate in 0..100 {
                for point in 0..100 {
                    let key = key.with(replicate).with(point);
                    assert!(keys.insert((key.first, key.second)), "two streams share a key");
                }
            }
        }
    }
}
