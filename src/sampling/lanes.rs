//! Eight xoshiro256++ generators side by side.
//!
//! Source: Blackman & Vigna, *Scrambled Linear Pseudorandom Number Generators*, ACM TOMS 47(4), 2021. The state words
//! of the eight lanes lie next to each other, so that one step is eight independent streams in vector registers.

use super::seed::{StreamKey, mix, mix_again};

/// Generators side by side.
pub const LANES: usize = 8;

/// 2⁶⁴ / φ, odd: SplitMix64's step.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Eight streams of one key.
#[derive(Clone, Debug)]
pub struct Lanes {
    state: [[u64; LANES]; 4],
}

impl Lanes {
    /// The lanes of a key.
    ///
    /// - `used`: lanes that will be read (an estimate of N < 8 samples reads N); the rest stay unseeded and are never
    ///   looked at.
    pub fn new(key: StreamKey, used: usize) -> Lanes {
        let mut lanes = Lanes { state: [[0; LANES]; 4] };
        for lane in 0..used.min(LANES) {
            lanes.seed(lane, key, lane);
        }
        lanes
    }

    /// Lanes of several keys side by side: lane l is lane l mod `width` of key l / `width`, as [`Lanes::new`] seeds it.
    /// Missing keys leave their lanes unseeded.
    ///
    /// - `width`: 1, 2, 4 or 8
    #[inline(always)]
    pub fn side_by_side(keys: &[StreamKey], width: usize) -> Lanes {
        let mut lanes = Lanes { state: [[0; LANES]; 4] };
        for (index, key) in keys.iter().enumerate().take(LANES / width) {
            for lane in 0..width {
                lanes.seed(index * width + lane, *key, lane);
            }
        }
        lanes
    }

    /// Puts lane `stream` of a key at place `lane`.
    #[inline(always)]
    fn seed(&mut self, lane: usize, key: StreamKey, stream: usize) {
        for (word, row) in self.state.iter_mut().enumerate() {
            let step = STEP.wrapping_mul((2 * stream + word % 2 + 1) as u64);
            row[lane] =
                if word < 2 { mix(key.first.wrapping_add(step)) } else { mix_again(key.second.wrapping_add(step)) };
        }
    }

    /// The next word of each lane.
    #[inline(always)]
    pub fn next_words(&mut self) -> [u64; LANES] {
        let [s0, s1, s2, s3] = &mut self.state;
        let mut result = [0; LANES];
        for l in 0..LANES {
            result[l] = s0[l].wrapping_add(s3[l]).rotate_left(23).wrapping_add(s0[l]);
            let t = s1[l] << 17;
            s2[l] ^= s0[l];
            s3[l] ^= s1[l];
            s1[l] ^= s2[l];
            s0[l] ^= s3[l];
            s2[l] ^= t;
            s3[l] = s3[l].rotate_left(45);
        }
        result
    }

    /// The next number of each lane, uniform on the 2⁵² multiples of 2⁻⁵² in [0, 1).
    ///
    /// The upper bits become the fraction of a double in [1, 2): exact, and vectorisable on every instruction set,
    /// unlike the conversion of a 64-bit integer.
    #[inline(always)]
    pub fn next_units(&mut self) -> [f64; LANES] {
        self.next_words().map(|word| f64::from_bits((word >> 12) | 0x3ff0_0000_0000_0000) - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn each_lane_is_the_published_generator() {
        let mut lanes = Lanes::new(StreamKey::root(42), LANES);
        let mut witnesses: Vec<_> = (0..LANES)
            .map(|lane| {
                let bytes: Vec<u8> = lanes.state.iter().flat_map(|row| row[lane].to_le_bytes()).collect();
                Xoshiro256PlusPlus::from_seed(bytes.try_into().unwrap())
            })
            .collect();
        for _ in 0..1000 {
            let words = lanes.next_words();
            for (word, witness) in words.iter().zip(&mut witnesses) {
                assert_eq!(*word, witness.next_u64());
            }
        }
    }

    #[test]
    fn units_fill_the_interval_evenly() {
        let mut lanes = Lanes::new(StreamKey::root(7), LANES);
        let mut counts = [[0_u32; 16]; LANES];
        for _ in 0..16_000 {
            for (lane, u) in lanes.next_units().into_iter().enumerate() {
                assert!((0.0..1.0).contains(&u));
                counts[lane][(u * 16.0) as usize] += 1;
            }
        }
        // 128 counts of mean 1000 and standard deviation 31: seven of them are one false alarm in 10⁹.
        assert!(counts.iter().flatten().all(|c| c.abs_diff(1000) < 220), "{counts:?}");
    }

    #[test]
    fn neighbouring_keys_give_unrelated_first_draws() {
        let root = StreamKey::root(3);
        let n = 40_000;
        let first = |k: u64| Lanes::new(root.with(k), 1).next_units()[0] - 0.5;
        let product: f64 = (0..n).map(|k| first(k) * first(k + 1)).sum::<f64>() / n as f64;
        // Standard deviation of the mean product: 1/(12 √n).
        assert!(product.abs() < 6.5 / (12.0 * (n as f64).sqrt()), "{product}");
    }
}
