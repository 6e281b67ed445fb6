//! The numbers that closed forms are written over: one text gives values (`f64`), exact derivatives ([`Dual`]) and values
//! to twice the digits ([`Wide`]).
//!
//! Decisions (which branch, which side) are taken on [`Number::primal`], so that all three take the same ones.

mod dual;
mod eight;
mod gauss;
mod vector;
mod wide;

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

pub(crate) use dual::Dual;
pub(crate) use eight::{Eight, Lanewise, Machine, Registers, Work};
pub(crate) use gauss::{GAUSS_8, gauss_10};
pub(crate) use vector::Vector;
pub(crate) use wide::Wide;

/// A real number, perhaps with more attached to it.
pub(crate) trait Number:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
    + Add<f64, Output = Self>
{
    /// Newton steps that take a root known to the last bits of an `f64` to the last bits of this kind of number (for a
    /// dual: of its derivatives).
    const NEWTON_STEPS: u32;

    /// Whether a sum of great terms to a small result keeps all the digits that are asked for.
    const CANCELS_FREELY: bool = false;

    /// A number that depends on nothing.
    fn constant(x: f64) -> Self;
    /// Its value, rounded to `f64`.
    fn primal(self) -> f64;
    /// 2π.
    fn turn() -> Self;
    fn sqrt(self) -> Self;
    /// √(self² + other²), for sizes whose squares neither overflow nor underflow.
    fn hypot(self, other: Self) -> Self;
    fn sin_cos(self) -> (Self, Self);
    fn atan(self) -> Self;
    /// The angle of the point (`x`, self), in (−π, π].
    fn atan2(self, x: Self) -> Self;
    /// ln(1 + self).
    fn ln_1p(self) -> Self;

    fn zero() -> Self {
        Self::constant(0.0)
    }
    fn abs(self) -> Self {
        if self.primal() < 0.0 { -self } else { self }
    }
}

impl Number for f64 {
    const NEWTON_STEPS: u32 = 0;
    #[inline(always)]
    fn constant(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn primal(self) -> f64 {
        self
    }
    #[inline(always)]
    fn turn() -> f64 {
        std::f64::consts::TAU
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn hypot(self, other: f64) -> f64 {
        (self * self + other * other).sqrt()
    }
    #[inline(always)]
    fn sin_cos(self) -> (f64, f64) {
        f64::sin_cos(self)
    }
    #[inline(always)]
    fn atan(self) -> f64 {
        f64::atan(self)
    }
    #[inline(always)]
    fn atan2(self, x: f64) -> f64 {
        f64::atan2(self, x)
    }
    #[inline(always)]
    fn ln_1p(self) -> f64 {
        f64::ln_1p(self)
    }
}
