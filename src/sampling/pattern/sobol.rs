//! Sobol's (0,2)-sequence in base 2, with nested uniform scrambling.
//!
//! Point i has the binary digits of i, least significant first, as the digits of u (van der Corput), and those of
//! Pascal's triangle modulo 2 times the digits of i as those of v (Sobol' 1967): each of its aligned runs of 2ᵐ points has
//! one point in every box of 2⁻ᵃ by 2⁻⁽ᵐ⁻ᵃ⁾.
//!
//! **Scrambling** (Owen 1995, without approximation): a digit is flipped by a coin that belongs to all digits before it.
//! The coins of six levels of that tree, 63 nodes, are bits of one word, a strong hash of the digits above. The first
//! ⌈log₂ N⌉ digits of N points are scrambled so; with these the points part ways in each dimension, and the digits behind are
//! independent coins for each point: the jitter. Dimensions, estimates and sources have words of their own. (Hashes that
//! permute a whole coordinate at once, after Laine & Karras 2011, approximate this and are told apart from it: Burley,
//! JCGT 9(4), 2020, mends some.)
//!
//! Coordinates are the 52-bit multiples of 2⁻⁵² in [0, 1), each exactly uniform; up to 2⁵² points the structure above is
//! theirs, later ones are uniform and no more.

use super::super::seed::{mix, mix_again};
use super::{LANES, Lanes, Squares, groups};

const BITS: u32 = 52;
/// Levels of the tree whose coins one word holds.
const LEVELS: u32 = 6;
/// 2⁶⁴ / φ, odd.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

#[derive(Clone, Debug)]
pub(super) struct Sobol {
    /// ⌈log₂ N⌉, at most 52.
    digits: u32,
    scrambles: [Scramble; 2],
    next: u64,
}

impl Sobol {
    pub fn new(n: u64, lanes: &mut Lanes) -> Sobol {
        let digits = (u64::BITS - (n.max(1) - 1).leading_zeros()).min(BITS);
        Sobol { digits, scrambles: [Scramble::draw(lanes), Scramble::draw(lanes)], next: 0 }
    }

    /// Puts the points in place of uniform ones, which become the digits behind the scrambled ones.
    #[inline(always)]
    pub fn jitter(&mut self, squares: &mut Squares, len: usize) {
        for group in 0..groups(len) {
            let index: [u64; LANES] = std::array::from_fn(|lane| self.next + (group * LANES + lane) as u64);
            self.scrambles[0].apply(index, self.digits, &mut squares.u[group]);
            self.scrambles[1].apply(index.map(pascal), self.digits, &mut squares.v[group]);
        }
        self.next += len as u64;
    }
}

/// Bit j of the result is the sum modulo 2 of the bits k of the index with C(k, j) odd, that is, with j's binary digits
/// among k's (Lucas): a sum over supersets, one digit of the bit's number at a time.
#[inline(always)]
fn pascal(index: u64) -> u64 {
    let mut bits = index;
    bits ^= (bits >> 1) & 0x5555_5555_5555_5555;
    bits ^= (bits >> 2) & 0x3333_3333_3333_3333;
    bits ^= (bits >> 4) & 0x0f0f_0f0f_0f0f_0f0f;
    bits ^= (bits >> 8) & 0x00ff_00ff_00ff_00ff;
    bits ^= (bits >> 16) & 0x0000_ffff_0000_ffff;
    bits ^ (bits >> 32)
}

/// The coins of one dimension.
#[derive(Clone, Copy, Debug)]
struct Scramble {
    first: u64,
    second: u64,
}

impl Scramble {
    fn draw(lanes: &mut Lanes) -> Scramble {
        Scramble { first: lanes.next_words()[0], second: lanes.next_words()[0] }
    }

    /// The coins of the six levels below a node.
    ///
    /// - `node`: the digits above, the first in the lowest bit, behind them a one
    #[inline(always)]
    fn coins(self, node: u64) -> u64 {
        mix(self.second ^ mix_again(self.first.wrapping_add(node.wrapping_mul(STEP))))
    }

    /// Scrambles digits, the first in the lowest bit, and puts them before those of `jitter`.
    #[inline(always)]
    fn apply(self, plain: [u64; LANES], digits: u32, jitter: &mut [f64; LANES]) {
        let mut scrambled = [0; LANES];
        let mut coins = [self.coins(1); LANES];
        // Place within six levels: 1 at their root, below it 2k and 2k + 1.
        let mut node = [1; LANES];
        for level in 0..digits {
            if level > 0 && level % LEVELS == 0 {
                for lane in 0..LANES {
                    coins[lane] = self.coins(1 << level | plain[lane] & ((1 << level) - 1));
                    node[lane] = 1;
                }
            }
            for lane in 0..LANES {
                let digit = plain[lane] >> level & 1;
                scrambled[lane] = scrambled[lane] << 1 | (digit ^ (coins[lane] >> node[lane] & 1));
                node[lane] = node[lane] << 1 | digit;
            }
        }
        for lane in 0..LANES {
            // A uniform number's 52 bits are the fraction of the double in [1, 2).
            let fraction = (1.0 + jitter[lane]).to_bits() & ((1 << BITS) - 1);
            let bits = scrambled[lane] << (BITS - digits) | fraction >> digits;
            jitter[lane] = f64::from_bits(bits | 0x3ff0_0000_0000_0000) - 1.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::StreamKey;
    use super::*;
    use crate::statistics::occupancy::Occupancy;

    /// Direction numbers of the second dimension by Sobol's recurrence for the polynomial x + 1: vₖ₊₁ = vₖ ⊕ vₖ/2.
    #[test]
    fn the_second_dimension_is_the_published_one() {
        let mut direction = 1_u64 << 63;
        for k in 0..64 {
            assert_eq!(pascal(1 << k).reverse_bits(), direction, "v{k}");
            direction ^= direction >> 1;
        }
        let of = |i: u64| pascal(i).reverse_bits() as f64 * 2_f64.powi(-64);
        assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(of), [0.0, 0.5, 0.75, 0.25, 0.625, 0.125, 0.375, 0.875]);
    }

    /// A scramble that walks the tree one digit at a time must give the same.
    #[test]
    fn each_coin_belongs_to_the_digits_before_it() {
        let scramble = Scramble::draw(&mut Lanes::new(StreamKey::root(8), 1));
        let digits = 20;
        let leading = |plain: u64| {
            let mut row = [0.0; LANES];
            scramble.apply([plain; LANES], digits, &mut row);
            (row[0] * 2_f64.powi(digits as i32)) as u64
        };
        for plain in (0..1_u64 << digits).step_by(977) {
            let own = leading(plain);
            for level in 0..digits {
                // Another digit at `level`, the same before it: the same before it, and another there.
                let other = leading(plain ^ 1 << level);
                assert_eq!((own ^ other) >> (digits - 1 - level), 1, "{plain} at level {level}");
            }
        }
    }

    /// Seven coins of both dimensions, above and below the border between two words: all 2⁷ outcomes alike.
    #[test]
    fn coins_are_fair_and_independent() {
        let mut seen = Occupancy::new(1 << 7);
        for replicate in 0..20_000 {
            let mut lanes = Lanes::new(StreamKey::root(21).with(replicate), 1);
            let scrambles = [Scramble::draw(&mut lanes), Scramble::draw(&mut lanes)];
            // The coin that a level flips, below the digits `above`.
            let coin = |axis: usize, level: u32, above: u64| {
                let mut row = [0.0; LANES];
                scrambles[axis].apply([above; LANES], level + 1, &mut row);
                (row[0] * 2_f64.powi(level as i32 + 1)) as usize & 1
            };
            let tossed = [(0, 0, 0), (0, 5, 3), (0, 6, 0), (0, 6, 1), (0, 6, 63), (1, 0, 0), (1, 6, 0)];
            let number = tossed.iter().fold(0, |bits, (axis, level, above)| bits << 1 | coin(*axis, *level, *above));
            seen.record(number);
        }
        assert!(!seen.is_refuted(), "{}", seen.ln_capital());
    }
}
