//! Numbers of twice the width of `f64`, for sums and fits that must not cancel.
//!
//! A `Wide` is an unevaluated sum high + low with |low| ≤ ½ ulp(high): about 106 bits. Sums, products and quotients have
//! a relative error below 2⁻¹⁰⁰ while nothing overflows or underflows (a sum: relative to its result, since both halves
//! are added with their errors). It is built on error-free transformations: Knuth's two-sum (TAOCP 2, 4.2.2, theorem B)
//! and the product whose error a fused multiply-add returns.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// high + low, not rounded to one `f64`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wide {
    high: f64,
    low: f64,
}

impl Wide {
    pub const ZERO: Wide = Wide { high: 0.0, low: 0.0 };
    #[cfg(test)]
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

    #[cfg(test)]
    pub fn abs(self) -> Wide {
        if self.high < 0.0 { -self } else { self }
    }

    /// a + b where |a| ≥ |b|, or a is zero: one test less than `sum`.
    #[inline]
    fn ordered_sum(a: f64, b: f64) -> Wide {
        let high = a + b;
        Wide { high, low: b - (high - a) }
    }
}

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
