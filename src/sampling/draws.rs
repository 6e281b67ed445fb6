//! Random numbers for whoever is judged: nothing of any random-number crate shows.

use super::seed::{StreamKey, mix, mix_again};

/// 2⁶⁴ / φ, odd: SplitMix64's step.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// A stream of random numbers that belongs to one estimate: one xoshiro256++ (Blackman & Vigna, ACM TOMS 47(4), 2021).
///
/// A sampler that brings a generator of its own seeds it with [`Draws::next_u64`]; then its estimates are as independent,
/// and as repeatable, as the streams are.
#[derive(Clone, Debug)]
pub struct Draws {
    state: [u64; 4],
}

impl Draws {
    /// The stream of a seed, for trials outside of the judge.
    pub fn new(seed: u64) -> Draws {
        Draws::of(StreamKey::root(seed))
    }

    /// The stream of a key.
    pub fn of(key: StreamKey) -> Draws {
        let step = |k: u64| STEP.wrapping_mul(k);
        let first = [1, 2].map(|k| mix(key.first.wrapping_add(step(k))));
        let second = [1, 2].map(|k| mix_again(key.second.wrapping_add(step(k))));
        Draws { state: [first[0], first[1], second[0], second[1]] }
    }

    /// The next 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        let [s0, s1, s2, s3] = &mut self.state;
        let word = s0.wrapping_add(*s3).rotate_left(23).wrapping_add(*s0);
        let t = *s1 << 17;
        *s2 ^= *s0;
        *s3 ^= *s1;
        *s1 ^= *s2;
        *s0 ^= *s3;
        *s2 ^= t;
        *s3 = s3.rotate_left(45);
        word
    }

    /// The next number, uniform on the 2⁵³ multiples of 2⁻⁵³ in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// The next whole number below `n`, each as likely to 2⁻⁶⁴ `n` (Lemire 2019, without the rejection); 0 for n = 0.
    pub fn below(&mut self, n: u64) -> u64 {
        ((u128::from(self.next_u64()) * u128::from(n)) >> 64) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    #[test]
    fn it_is_the_published_generator() {
        let mut draws = Draws::new(42);
        let bytes: Vec<u8> = draws.state.iter().flat_map(|word| word.to_le_bytes()).collect();
        let mut witness = Xoshiro256PlusPlus::from_seed(bytes.try_into().unwrap());
        for _ in 0..1000 {
            assert_eq!(draws.next_u64(), witness.next_u64());
        }
    }

    #[test]
    fn numbers_stay_in_their_range_and_reach_its_ends() {
        let mut draws = Draws::new(7);
        let mut counts = [0_u32; 10];
        for _ in 0..20_000 {
            assert!((0.0..1.0).contains(&draws.unit()));
            counts[draws.below(10) as usize] += 1;
        }
        // Mean 2000, standard deviation 42.
        assert!(counts.iter().all(|count| count.abs_diff(2000) < 300), "{counts:?}");
        assert_eq!(draws.below(0), 0);
    }
}
