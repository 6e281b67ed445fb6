//! Sine and cosine of an eighth of a turn, in our own polynomials: the same bits on every platform, and in vectors.

use std::f64::consts::FRAC_PI_4;

use crate::number::Lanewise;

/// (sin(t π/4), cos(t π/4)).
///
/// - `t`: in [−1, 1]
/// - error: absolute, below 3 · 2⁻⁵³ for both (the Taylor remainders are below 2⁻⁵⁴ at the ends; the rest is rounding)
/// - source: Taylor series of sine to order 15 and cosine to order 16
#[inline(always)]
pub(super) fn sin_cos_eighth<T: Lanewise>(t: T) -> (T, T) {
    let x = t * FRAC_PI_4;
    let y = x * x;
    let sin = y * (-1.0 / 1_307_674_368_000.0) + 1.0 / 6_227_020_800.0;
    let sin = y * (y * (y * sin - 1.0 / 39_916_800.0) + 1.0 / 362_880.0) - 1.0 / 5040.0;
    let sin = y * (y * (y * sin + 1.0 / 120.0) - 1.0 / 6.0);
    let cos = y * (1.0 / 20_922_789_888_000.0) - 1.0 / 87_178_291_200.0;
    let cos = y * (y * (y * cos + 1.0 / 479_001_600.0) - 1.0 / 3_628_800.0) + 1.0 / 40_320.0;
    let cos = y * (y * (y * (y * cos - 1.0 / 720.0) + 1.0 / 24.0) - 0.5);
    (x + x * sin, cos + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_polynomials_agree_with_the_library() {
        for k in -100_000..=100_000 {
            let t = k as f64 / 100_000.0;
            let (sin, cos) = sin_cos_eighth(t);
            let (sin_witness, cos_witness) = (libm::sin(t * FRAC_PI_4), libm::cos(t * FRAC_PI_4));
            assert!((sin - sin_witness).abs() <= 3.0 * 2_f64.powi(-53), "sin at {t}");
            assert!((cos - cos_witness).abs() <= 3.0 * 2_f64.powi(-53), "cos at {t}");
        }
    }
}
