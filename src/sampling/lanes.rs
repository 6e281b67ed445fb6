//! Eight xoshiro256++ generators side by side.
//!
//! Source: Blackman & Vigna, *Scrambled Linear Pseudorandom Number Generators*, ACM TOMS 47(4), 2021. The state words
//! of the eight lanes lie next to each other, so that one step is eight independent streams in vector registers.

use super::seed::{StreamKey, mix, mix_again};
use crate::number::{Machine, Registers, Work};

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
    #[inline(always)]
    pub fn new(key: StreamKey, used: usize) -> Lanes {
        if used >= LANES {
            return Lanes::seeded([key.first; LANES], [key.second; LANES], LANES);
        }
        let mut lanes = Lanes { state: [[0; LANES]; 4] };
        for (word, row) in lanes.state.iter_mut().enumerate() {
            for (lane, state) in row[..used].iter_mut().enumerate() {
                *state = seed(word, key.first, key.second, lane);
            }
        }
        lanes
    }

    /// As [`Lanes::new`], in the registers of a machine.
    pub(crate) fn new_on(machine: Machine, key: StreamKey, used: usize) -> Lanes {
        machine.run(Seeding { key, used })
    }

    /// Lanes of several keys side by side: lane l is lane l mod `width` of key l / `width`, as [`Lanes::new`] seeds it.
    /// Of missing keys the lanes mean nothing.
    ///
    /// - `keys`: one at least; `below`: words that each key takes in first; `width`: 1, 2, 4 or 8
    #[inline(always)]
    pub fn side_by_side(keys: &[StreamKey], below: [u64; 2], width: usize) -> Lanes {
        let (mut first, mut second) = ([0; LANES], [0; LANES]);
        for lane in 0..LANES {
            let key = keys[(lane / width).min(keys.len() - 1)];
            (first[lane], second[lane]) = (key.first, key.second);
        }
        for word in below {
            for lane in 0..LANES {
                let key = StreamKey { first: first[lane], second: second[lane] }.with(word);
                (first[lane], second[lane]) = (key.first, key.second);
            }
        }
        Lanes::seeded(first, second, width)
    }

    /// All lanes at once, which is what vector registers like; lane l is lane l mod `width` of its key.
    #[inline(always)]
    fn seeded(first: [u64; LANES], second: [u64; LANES], width: usize) -> Lanes {
        let mut lanes = Lanes { state: [[0; LANES]; 4] };
        for (word, row) in lanes.state.iter_mut().enumerate() {
            for lane in 0..LANES {
                row[lane] = seed(word, first[lane], second[lane], lane % width);
            }
        }
        lanes
    }

    /// The state of the first lane of a key, for [`step`].
    pub(super) fn first(key: StreamKey) -> [u64; 4] {
        std::array::from_fn(|word| seed(word, key.first, key.second, 0))
    }

    /// The next word of each lane.
    #[inline(always)]
    pub fn next_words(&mut self) -> [u64; LANES] {
        let [s0, s1, s2, s3] = &mut self.state;
        let mut result = [0; LANES];
        for l in 0..LANES {
            let (word, next) = step([s0[l], s1[l], s2[l], s3[l]]);
            result[l] = word;
            [s0[l], s1[l], s2[l], s3[l]] = next;
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

/// One generator's next word, and its state after that.
#[inline(always)]
pub(super) fn step([s0, s1, s2, s3]: [u64; 4]) -> (u64, [u64; 4]) {
    let word = s0.wrapping_add(s3).rotate_left(23).wrapping_add(s0);
    let (two, three) = (s2 ^ s0, s3 ^ s1);
    (word, [s0 ^ three, s1 ^ two, two ^ (s1 << 17), three.rotate_left(45)])
}

/// A word of the state of a key's lane.
#[inline(always)]
fn seed(word: usize, first: u64, second: u64, lane: usize) -> u64 {
    let step = STEP.wrapping_mul((2 * lane + word % 2 + 1) as u64);
    if word < 2 { mix(first.wrapping_add(step)) } else { mix_again(second.wrapping_add(step)) }
}

/// See [`Lanes::new_on`].
struct Seeding {
    key: StreamKey,
    used: usize,
}

impl Work for Seeding {
    type Output = Lanes;

    #[inline(always)]
    fn run<R: Registers>(self, _: R) -> Lanes {
        Lanes::new(self.key, self.used)
    }
}

#[cfg(feature = "studies")]
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
