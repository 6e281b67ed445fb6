//! Numbers of twice the width of `f64`, for sums, fits and contours that must not cancel.
//!
//! A `Wide` is an unevaluated sum high + low with |low| ≤ ½ ulp(high): about 106 bits. Sums, products and quotients have
//! a relative error below 2⁻¹⁰⁰ while nothing overflows or underflows (a sum: relative to its result, since both halves
//! are added with their errors). It is built on error-free transformations: Knuth's two-sum (TAOCP 2, 4.2.2, theorem B)
//! and the product whose error a fused multiply-add returns.

use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::LazyLock;

use super::Number;

/// high + low, not rounded to one `f64`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Wide {
    high: f64,
    low: f64,
}

impl Wide {
    pub const ZERO: Wide = Wide { high: 0.0, low: 0.0 };
    pub const ONE: Wide = Wide { high: 1.0, low: 0.0 };

    /// a + b without error.
    #[inline]
    pub fn sum(a: f64, b: f64) -> Wide {
        let high = a + b;
        let part = high - a;
        Wide { high, low: (a - (high - part)) + (b - part) }
    }

    /// a − b without error.
    pub fn difference(a: f64, b: f64) -> Wide {
        Wide::sum(a, -b)
    }

    /// a · b without error, unless it overflows or its error underflows.
    pub fn product(a: f64, b: f64) -> Wide {
        let high = a * b;
        Wide { high, low: a.mul_add(b, -high) }
    }

    /// The nearest `f64`.
    #[inline]
    pub fn narrow(self) -> f64 {
        self.high + self.low
    }

    pub fn square(self) -> Wide {
        self * self
    }

    /// Square root; of zero and of negative rounding residues it is zero.
    pub fn sqrt(self) -> Wide {
        if self.high <= 0.0 {
            return Wide::ZERO;
        }
        // One Newton step from the f64 root doubles its digits.
        let root = self.high.sqrt();
        Wide::sum(root, (self - Wide::product(root, root)).high / (2.0 * root))
    }

    /// a + b where |a| ≥ |b|, or a is zero: one test less than `sum`.
    #[inline]
    fn ordered_sum(a: f64, b: f64) -> Wide {
        let high = a + b;
        Wide { high, low: b - (high - a) }
    }
}

impl Mul<f64> for Wide {
    type Output = Wide;
    fn mul(self, other: f64) -> Wide {
        let high = Wide::product(self.high, other);
        Wide::ordered_sum(high.high, high.low + self.low * other)
    }
}

impl Add<f64> for Wide {
    type Output = Wide;
    fn add(self, other: f64) -> Wide {
        let high = Wide::sum(self.high, other);
        Wide::ordered_sum(high.high, high.low + self.low)
    }
}

/// π/2 to 106 bits (high part: the nearest `f64`; low part: the nearest to the rest; from 3.243F6A88 85A308D3
/// 13198A2E 03707344 A4093822 299F31D0, π in hexadecimal).
const QUARTER: Wide = Wide { high: std::f64::consts::FRAC_PI_2, low: 6.123_233_995_736_766e-17 };

/// Terms of the series below: x²ᵏ/(2k)! for |x| ≤ π/64 falls under 2⁻¹¹⁰ at k = 10.
const TERMS: usize = 11;

/// (−1)ᵏ/(2k + 1)! and (−1)ᵏ/(2k)!, k = 0, 1, …
static SIN_COS_SERIES: LazyLock<[[Wide; 2]; TERMS]> = LazyLock::new(|| {
    let mut term = Wide::ONE;
    let mut next = 1.0;
    std::array::from_fn(|_| {
        let cos = term;
        let sin = cos / Wide::from(next);
        term = -sin / Wide::from(next + 1.0);
        next += 2.0;
        [sin, cos]
    })
});

/// 1/(2k + 1), k = 0, 1, …
static ATANH_SERIES: LazyLock<[Wide; 23]> =
    LazyLock::new(|| std::array::from_fn(|k| Wide::ONE / Wide::from((2 * k + 1) as f64)));

/// sin and cos of an angle of at most π/64 in size, by their series.
fn small_sin_cos(x: Wide) -> (Wide, Wide) {
    let square = x.square();
    let (mut sin, mut cos) = (Wide::ZERO, Wide::ZERO);
    // Horner's rule from the last term inwards.
    for [sin_term, cos_term] in SIN_COS_SERIES.iter().rev() {
        sin = *sin_term + square * sin;
        cos = *cos_term + square * cos;
    }
    (x * sin, cos)
}

impl Number for Wide {
    const NEWTON_STEPS: u32 = 2;
    const CANCELS_FREELY: bool = true;

    fn constant(x: f64) -> Wide {
        Wide::from(x)
    }
    fn primal(self) -> f64 {
        self.narrow()
    }
    fn turn() -> Wide {
        QUARTER * 4.0
    }
    fn sqrt(self) -> Wide {
        Wide::sqrt(self)
    }
    fn hypot(self, other: Wide) -> Wide {
        (self.square() + other.square()).sqrt()
    }
    /// Relative to one, below 2⁻⁹⁸ for angles of a few turns.
    fn sin_cos(self) -> (Wide, Wide) {
        let quarters = (self.high / QUARTER.high).round();
        let rest = self - QUARTER * quarters;
        // Four doublings from the series' range.
        let (mut sin, mut cos) = small_sin_cos(rest * 0.0625);
        for _ in 0..4 {
            (sin, cos) = (sin * cos * 2.0, Wide::ONE - sin.square() * 2.0);
        }
        match quarters.rem_euclid(4.0) as u32 {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }
    fn atan(self) -> Wide {
        self.atan2(Wide::ONE)
    }
    /// One Newton step on the angle: with φ₀ the angle to the digits of an `f64`, φ = φ₀ + asin((y cos φ₀ − x sin φ₀)/r).
    fn atan2(self, x: Wide) -> Wide {
        let near = self.high.atan2(x.high);
        let size = self.hypot(x);
        if size.high == 0.0 {
            return Wide::from(near);
        }
        let (sin, cos) = Wide::from(near).sin_cos();
        let off = (self * cos - x * sin) / size;
        // asin δ = δ + δ³/6, and δ⁵ lies below the last bit.
        Wide::from(near) + off + off * off.square() * (1.0 / 6.0)
    }
    /// By the series of atanh.
    fn ln_1p(self) -> Wide {
        // 1 + x = 2^e m with m in [√½, √2]; ln m = 2 atanh((m − 1)/(m + 1)).
        let one_and = self + Wide::ONE;
        let e = (one_and.high / std::f64::consts::FRAC_1_SQRT_2).log2().floor();
        let (top, bottom) = if e == 0.0 {
            (self, self + Wide::from(2.0))
        } else {
            let m = one_and * (-e).exp2();
            (m - Wide::ONE, m + Wide::ONE)
        };
        let t = top / bottom;
        let square = t.square();
        // |t| ≤ 0.172: t^2k falls under 2⁻¹¹⁰ at k = 22.
        let mut sum = Wide::ZERO;
        for term in ATANH_SERIES.iter().rev() {
            sum = sum * square + *term;
        }
        t * sum * 2.0 + LN_2 * e
    }
}

/// ln 2 to 106 bits (0.B17217F7 D1CF79AB C9E3B398 03F2F6AF in hexadecimal).
const LN_2: Wide = Wide { high: std::f64::consts::LN_2, low: 2.319_046_813_846_299_6e-17 };

impl From<f64> for Wide {
    #[inline]
    fn from(x: f64) -> Wide {
        Wide { high: x, low: 0.0 }
    }
}

impl Neg for Wide {
    type Output = Wide;
    fn neg(self) -> Wide {
        Wide { high: -self.high, low: -self.low }
    }
}

impl Add for Wide {
    type Output = Wide;
    #[inline]
    fn add(self, other: Wide) -> Wide {
        let (high, low) = (Wide::sum(self.high, other.high), Wide::sum(self.low, other.low));
        let first = Wide::ordered_sum(high.high, high.low + low.high);
        Wide::ordered_sum(first.high, first.low + low.low)
    }
}

impl Sub for Wide {
    type Output = Wide;
    fn sub(self, other: Wide) -> Wide {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Wide;
    fn mul(self, other: Wide) -> Wide {
        let high = Wide::product(self.high, other.high);
        Wide::ordered_sum(high.high, high.low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Wide {
    type Output = Wide;
    fn div(self, other: Wide) -> Wide {
        // Long division: each digit is a f64 quotient of what is left.
        let first = self.high / other.high;
        let left = self - other * Wide::from(first);
        let second = left.high / other.high;
        let third = (left - other * Wide::from(second)).high / other.high;
        Wide::ordered_sum(first, second) + Wide::from(third)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A few units of 2⁻¹⁰⁰.
    const LAST_DIGITS: f64 = 1.0 / (1u128 << 98) as f64;

    fn agree(a: Wide, b: Wide, scale: f64) {
        let off = (a - b).narrow().abs();
        assert!(off <= LAST_DIGITS * scale, "{a:?} and {b:?} differ by {off:e}");
    }

    #[test]
    fn angles_undo_sines() {
        for k in -60..=60 {
            let x = Wide::from(f64::from(k)) / Wide::from(11.0);
            let (sin, cos) = x.sin_cos();
            agree(sin.square() + cos.square(), Wide::ONE, 4.0);
            let turns = (x.narrow() / std::f64::consts::TAU).round();
            agree(sin.atan2(cos), x - Wide::turn() * turns, 16.0);
            let (twice, _) = (x * 2.0).sin_cos();
            agree(twice, sin * cos * 2.0, 16.0);
        }
        // Machin (1706): π/4 = 4 atan(1/5) − atan(1/239).
        let share = |n: f64| (Wide::ONE / Wide::from(n)).atan();
        agree((share(5.0) * 4.0 - share(239.0)) * 8.0, Wide::turn(), 8.0);
    }

    #[test]
    fn logarithms_turn_products_into_sums() {
        for (a, b) in [(0.1, 0.3), (1e-9, 2e-9), (-0.4, 3.0), (7.0, 1e5), (-0.9, -0.5)] {
            let (a, b) = (Wide::from(a), Wide::from(b));
            let sum = a.ln_1p() + b.ln_1p();
            agree((a + b + a * b).ln_1p(), sum, 8.0 * sum.narrow().abs().max(1e-9));
            assert!((a.ln_1p().narrow() / a.narrow().ln_1p() - 1.0).abs() < 1e-15);
        }
        agree(Wide::ONE.ln_1p(), LN_2, 1.0);
    }

    #[test]
    fn what_f64_drops_is_kept() {
        let sum = Wide::from(1.0) + Wide::from(2f64.powi(-90)) - Wide::from(1.0);
        assert_eq!(sum.narrow(), 2f64.powi(-90));
        let (a, b) = (1.0 + 2f64.powi(-52), 1.0 - 2f64.powi(-53));
        // (1 + 2⁻⁵²)(1 − 2⁻⁵³) = 1 + 2⁻⁵³ − 2⁻¹⁰⁵
        let error = Wide::product(a, b) - Wide::ONE - Wide::from(2f64.powi(-53));
        assert_eq!(error.narrow(), -2f64.powi(-105));
    }

    #[test]
    fn quotient_and_root_undo_product_and_square() {
        for k in 1..200 {
            let x = Wide::from(f64::from(k)) / Wide::from(7.0);
            let back = x * Wide::from(7.0) - Wide::from(f64::from(k));
            assert!(back.abs().narrow() <= f64::from(k) * 2f64.powi(-100), "{k}: {back:?}");
            let root = x.square().sqrt() - x;
            assert!(root.abs().narrow() <= x.narrow() * 2f64.powi(-100), "{k}: {root:?}");
        }
        assert_eq!(Wide::ZERO.sqrt(), Wide::ZERO);
    }
}
