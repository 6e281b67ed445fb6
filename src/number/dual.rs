//! Numbers that carry their derivatives with respect to `N` parameters along (forward mode).

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Number;

/// value + Σ slopes[k] dp_k, over `f64` or over numbers that keep more digits.
///
/// Where a function has a corner or an infinite slope (a root of zero), the slope is taken as zero: there the shadow's
/// topology changes, and whoever asks is told that the derivative is one-sided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dual<const N: usize, T = f64> {
    pub value: T,
    pub slopes: [T; N],
}

impl<const N: usize, T: Number> Dual<N, T> {
    /// f(self), given f and f′ at its value.
    #[inline]
    fn chain(self, value: T, slope: T) -> Self {
        Dual { value, slopes: self.slopes.map(|s| s * slope) }
    }

    #[inline]
    fn combined(self, other: Self, value: T, a: T, b: T) -> Self {
        Dual { value, slopes: std::array::from_fn(|k| a * self.slopes[k] + b * other.slopes[k]) }
    }
}

/// 1/x, or zero where there is none.
#[inline]
fn share_of<T: Number>(x: T) -> T {
    if x.primal() > 0.0 { T::constant(1.0) / x } else { T::zero() }
}

impl<const N: usize, T: Number> Add for Dual<N, T> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Dual { value: self.value + other.value, slopes: std::array::from_fn(|k| self.slopes[k] + other.slopes[k]) }
    }
}

impl<const N: usize, T: Number> Sub for Dual<N, T> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Dual { value: self.value - other.value, slopes: std::array::from_fn(|k| self.slopes[k] - other.slopes[k]) }
    }
}

impl<const N: usize, T: Number> Neg for Dual<N, T> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Dual { value: -self.value, slopes: self.slopes.map(|s| -s) }
    }
}

impl<const N: usize, T: Number> Mul for Dual<N, T> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.combined(other, self.value * other.value, other.value, self.value)
    }
}

impl<const N: usize, T: Number> Div for Dual<N, T> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let share = T::constant(1.0) / other.value;
        self.combined(other, value, share, -value * share)
    }
}

impl<const N: usize, T: Number> Mul<f64> for Dual<N, T> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Dual { value: self.value * factor, slopes: self.slopes.map(|s| s * factor) }
    }
}

impl<const N: usize, T: Number> Add<f64> for Dual<N, T> {
    type Output = Self;
    #[inline]
    fn add(self, constant: f64) -> Self {
        Dual { value: self.value + constant, ..self }
    }
}

impl<const N: usize, T: Number> Number for Dual<N, T> {
    const NEWTON_STEPS: u32 = T::NEWTON_STEPS + 1;
    const CANCELS_FREELY: bool = T::CANCELS_FREELY;

    #[inline]
    fn constant(x: f64) -> Self {
        Dual { value: T::constant(x), slopes: [T::zero(); N] }
    }
    #[inline]
    fn primal(self) -> f64 {
        self.value.primal()
    }
    fn turn() -> Self {
        Dual { value: T::turn(), slopes: [T::zero(); N] }
    }
    #[inline]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, share_of(root) * 0.5)
    }
    #[inline]
    fn hypot(self, other: Self) -> Self {
        let value = self.value.hypot(other.value);
        let share = share_of(value);
        self.combined(other, value, self.value * share, other.value * share)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }
    #[inline]
    fn atan(self) -> Self {
        self.chain(self.value.atan(), share_of(self.value * self.value + 1.0))
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        let share = share_of(self.value * self.value + x.value * x.value);
        self.combined(x, self.value.atan2(x.value), x.value * share, -self.value * share)
    }
    #[inline]
    fn ln_1p(self) -> Self {
        self.chain(self.value.ln_1p(), T::constant(1.0) / (self.value + 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Every operation once.
    fn compound<T: Number>(x: T, y: T) -> T {
        let (sin, cos) = (x * y).sin_cos();
        let angle = sin.atan2(cos + x) + (y / x).atan();
        (angle * angle + 0.25).sqrt().hypot(x - y) * 3.0 + (-(x * 0.1)).ln_1p()
    }

    fn seeded<const N: usize>(value: f64, k: usize) -> Dual<N> {
        let mut dual = Dual::constant(value);
        dual.slopes[k] = 1.0;
        dual
    }

    #[test]
    fn slopes_are_limits_of_difference_quotients() {
        let (x, y) = (0.7, 1.3);
        let dual: Dual<2> = compound(seeded(x, 0), seeded(y, 1));
        assert_eq!(dual.value, compound(x, y));
        let extrapolated = |f: &dyn Fn(f64) -> f64| {
            let central = |h: f64| (f(h) - f(-h)) / (2.0 * h);
            (4.0 * central(5e-4) - central(1e-3)) / 3.0
        };
        assert_relative_eq!(dual.slopes[0], extrapolated(&|h| compound(x + h, y)), max_relative = 1e-11);
        assert_relative_eq!(dual.slopes[1], extrapolated(&|h| compound(x, y + h)), max_relative = 1e-11);
    }

    #[test]
    fn roots_of_nothing_have_no_slope_rather_than_none_that_is_a_number() {
        let nothing: Dual<1> = seeded(0.0, 0);
        for y in [nothing.sqrt(), nothing.hypot(nothing), nothing.atan2(nothing)] {
            assert_eq!(y.slopes, [0.0]);
        }
    }
}
