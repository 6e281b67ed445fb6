//! Numbers that carry their derivatives with respect to `N` parameters along (forward mode).

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Number;

/// value + Σ slopes[k] dp_k.
///
/// Where a function has a corner or an infinite slope (a root of zero), the slope is taken as zero: there the shadow's
/// topology changes, and whoever asks is told that the derivative is one-sided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dual<const N: usize> {
    pub value: f64,
    pub slopes: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// A number whose slope with respect to parameter `k` is `slope`.
    pub fn seeded(value: f64, k: usize, slope: f64) -> Dual<N> {
        let mut dual = Dual::constant(value);
        dual.slopes[k] = slope;
        dual
    }

    /// f(self), given f and f′ at its value.
    #[inline]
    fn chain(self, value: f64, slope: f64) -> Dual<N> {
        Dual { value, slopes: self.slopes.map(|s| s * slope) }
    }

    #[inline]
    fn combined(self, other: Dual<N>, value: f64, a: f64, b: f64) -> Dual<N> {
        Dual { value, slopes: std::array::from_fn(|k| a * self.slopes[k] + b * other.slopes[k]) }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Dual { value: self.value + other.value, slopes: std::array::from_fn(|k| self.slopes[k] + other.slopes[k]) }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Dual { value: self.value - other.value, slopes: std::array::from_fn(|k| self.slopes[k] - other.slopes[k]) }
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Dual { value: -self.value, slopes: self.slopes.map(|s| -s) }
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.combined(other, self.value * other.value, other.value, self.value)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        let share = 1.0 / other.value;
        self.combined(other, value, share, -value * share)
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        self.chain(self.value * factor, factor)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn add(self, constant: f64) -> Self {
        Dual { value: self.value + constant, ..self }
    }
}

impl<const N: usize> Number for Dual<N> {
    const NEWTON_STEPS: u32 = 1;

    #[inline]
    fn constant(x: f64) -> Self {
        Dual { value: x, slopes: [0.0; N] }
    }
    #[inline]
    fn primal(self) -> f64 {
        self.value
    }
    fn turn() -> Self {
        Dual::constant(std::f64::consts::TAU)
    }
    #[inline]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, if root > 0.0 { 0.5 / root } else { 0.0 })
    }
    #[inline]
    fn hypot(self, other: Self) -> Self {
        let value = self.value.hypot(other.value);
        let share = if value > 0.0 { 1.0 / value } else { 0.0 };
        self.combined(other, value, self.value * share, other.value * share)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }
    #[inline]
    fn atan(self) -> Self {
        self.chain(self.value.atan(), 1.0 / (1.0 + self.value * self.value))
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        let square = self.value * self.value + x.value * x.value;
        let share = if square > 0.0 { 1.0 / square } else { 0.0 };
        self.combined(x, self.value.atan2(x.value), x.value * share, -self.value * share)
    }
    #[inline]
    fn ln_1p(self) -> Self {
        self.chain(self.value.ln_1p(), 1.0 / (1.0 + self.value))
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
        (angle.square() + 0.25).sqrt().hypot(x - y) * 3.0 + (-(x * 0.1)).ln_1p()
    }

    #[test]
    fn slopes_are_limits_of_difference_quotients() {
        let (x, y) = (0.7, 1.3);
        let dual: Dual<2> = compound(Dual::seeded(x, 0, 1.0), Dual::seeded(y, 1, 1.0));
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
        let nothing: Dual<1> = Dual::seeded(0.0, 0, 1.0);
        for y in [nothing.sqrt(), nothing.hypot(nothing), nothing.atan2(nothing)] {
            assert_eq!(y.slopes, [0.0]);
        }
    }
}
