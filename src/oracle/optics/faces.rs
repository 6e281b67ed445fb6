//! Shares of the power that smooth faces of glass send back and let through, one face after another.
//!
//! A path that stays in one plane of incidence keeps its s light s and its p light p: the shares of each are multiplied face
//! by face and the two averaged at the end. Averaging at every face (as if the light lost its polarisation on the way) is what
//! most renderers do; the two differ by a few tenths of a percent through a ball of glass.

use super::{OpticsError, glass};
use crate::radiometry::Fresnel;

/// What becomes of each polarisation: shares of its own power, in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polarised {
    /// Of light whose field is perpendicular to the plane of incidence.
    pub s: f64,
    /// Of light whose field lies in it.
    pub p: f64,
}

impl Polarised {
    /// Of light that arrives unpolarised.
    pub fn mean(self) -> f64 {
        0.5 * (self.s + self.p)
    }
    /// Both after one another, in one plane of incidence.
    pub fn then(self, next: Polarised) -> Polarised {
        Polarised { s: self.s * next.s, p: self.p * next.p }
    }
    fn map(self, f: impl Fn(f64) -> f64) -> Polarised {
        Polarised { s: f(self.s), p: f(self.p) }
    }
    fn power(self, exponent: u32) -> Polarised {
        self.map(|x| x.powi(exponent as i32))
    }
}

/// How losses at several faces are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// Each polarisation by itself, averaged at the end: what happens in one plane of incidence.
    PerPolarisation,
    /// Unpolarised before every face: what most renderers compute.
    EachFaceUnpolarised,
    /// Faces that let everything through (or mirror everything): geometry alone.
    None,
}

impl Loss {
    /// The share that two passages let through, given what each lets through.
    pub(super) fn through(self, first: Polarised, second: Polarised) -> f64 {
        match self {
            Loss::PerPolarisation => first.then(second).mean(),
            Loss::EachFaceUnpolarised => first.mean() * second.mean(),
            Loss::None => 1.0,
        }
    }
}

/// What one face lets through, and what it sends back.
///
/// - `index` n: of the far side relative to the near one, finite, > 0; `cosine` of incidence: in [0, 1]
/// - error: as of [`Fresnel::at`]
pub fn face(index: f64, cosine: f64) -> Result<[Polarised; 2], OpticsError> {
    let face = Fresnel::at(index, cosine)?;
    Ok([
        Polarised { s: face.transmittance_s, p: face.transmittance_p },
        Polarised { s: face.reflectance_s, p: face.reflectance_p },
    ])
}

/// What a slab of clear glass lets through and sends back after `echoes` passes to and fro.
///
/// The light that leaves after 2k reflections inside, of each polarisation:
///
/// ```text
/// through:  T² R^{2k}          back:  R for k = 0, then T² R^{2k − 1}
/// ```
///
/// - `index` n: 1 ≤ n ≤ 10³; `cosine` of incidence in air: in [0, 1]
/// - returns [through, back] of that order alone; summed over all orders they are those of [`slab`]
/// - error: relative, a few 2⁻⁵³ times (2k + 1)
/// - source: reciprocity (a face lets through the same share either way) and the path
pub fn slab_order(index: f64, cosine: f64, echoes: u32) -> Result<[Polarised; 2], OpticsError> {
    let [through, back] = face(glass(index)?, cosine)?;
    let twice = through.power(2);
    let back_now = if echoes == 0 { back } else { twice.then(back.power(2 * echoes - 1)) };
    Ok([twice.then(back.power(2 * echoes)), back_now])
}

/// What a slab of clear glass lets through and sends back, all echoes counted.
///
/// Of each polarisation `(1 − R)/(1 + R)` and `2R/(1 + R)`, which add up to one.
///
/// - `index` n: 1 ≤ n ≤ 10³; `cosine` of incidence in air: in [0, 1]
/// - returns [through, back]
/// - error: relative, a few 2⁻⁵³
/// - source: the geometric series of [`slab_order`]
pub fn slab(index: f64, cosine: f64) -> Result<[Polarised; 2], OpticsError> {
    let [through, back] = face(glass(index)?, cosine)?;
    let sum = back.map(|r| 1.0 / (1.0 + r));
    Ok([through.then(sum), back.map(|r| 2.0 * r).then(sum)])
}

/// What leaves a ball of clear glass after a number of reflections inside, of each polarisation: `(1 − R)² Rᵏ`.
///
/// All angles at the inner face are alike, so that R is the same at each. k = 0: light that has only passed; k = 1: the first
/// rainbow. With what is reflected at once, R, the sum over all k is one.
///
/// - `index` n: 1 ≤ n ≤ 10³; `cosine` of incidence in air: in [0, 1]
/// - error: relative, a few 2⁻⁵³ times (k + 2)
/// - source: the path; a ball's chords are all alike
pub fn ball_order(index: f64, cosine: f64, reflections_inside: u32) -> Result<Polarised, OpticsError> {
    let [through, back] = face(glass(index)?, cosine)?;
    Ok(through.power(2).then(back.power(reflections_inside)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_slab_is_the_sum_of_its_orders(n in 1.0..4.0, c in 0.05..=1.0) {
            let [through, back] = slab(n, c).unwrap();
            let sum = |i: usize, f: fn(Polarised) -> f64| -> f64 {
                (0..400).map(|k| f(slab_order(n, c, k).unwrap()[i])).sum()
            };
            assert_abs_diff_eq!(through.s, sum(0, |x| x.s), epsilon = 1e-13);
            assert_abs_diff_eq!(through.p, sum(0, |x| x.p), epsilon = 1e-13);
            assert_abs_diff_eq!(back.s, sum(1, |x| x.s), epsilon = 1e-13);
            assert_abs_diff_eq!(back.p, sum(1, |x| x.p), epsilon = 1e-13);
            assert_abs_diff_eq!(through.s + back.s, 1.0, epsilon = 1e-14);
            assert_abs_diff_eq!(through.p + back.p, 1.0, epsilon = 1e-14);
        }

        #[test]
        fn a_ball_loses_nothing(n in 1.0..4.0, c in 0.2..=1.0) {
            let [_, back] = face(n, c).unwrap();
            let sum: f64 = (0..400).map(|k| ball_order(n, c, k).unwrap().s).sum();
            assert_abs_diff_eq!(back.s + sum, 1.0, epsilon = 1e-13);
            let sum: f64 = (0..400).map(|k| ball_order(n, c, k).unwrap().p).sum();
            assert_abs_diff_eq!(back.p + sum, 1.0, epsilon = 1e-13);
        }
    }

    /// Glass at normal incidence, by hand: R = 0.04, so that a window lets 0.96/1.04 through.
    #[test]
    fn a_window_pane() {
        let [through, back] = slab(1.5, 1.0).unwrap();
        assert_relative_eq!(through.mean(), 0.96 / 1.04, max_relative = 1e-15);
        assert_relative_eq!(back.mean(), 0.08 / 1.04, max_relative = 1e-14);
    }

    /// At Brewster's angle all of p passes and less of s: two faces let more through than their means make one think.
    #[test]
    fn polarisations_are_not_to_be_averaged_between_faces() {
        let n = 1.5_f64;
        let brewster = 1.0 / (1.0 + n * n).sqrt();
        let [through, _] = face(n, brewster).unwrap();
        assert_relative_eq!(through.p, 1.0, max_relative = 1e-14);
        let apart = Loss::PerPolarisation.through(through, through);
        let mixed = Loss::EachFaceUnpolarised.through(through, through);
        // (s² + 1)/2 − ((s + 1)/2)² = ((1 − s)/2)²
        assert_relative_eq!(apart - mixed, (0.5 * (1.0 - through.s)).powi(2), max_relative = 1e-12);
        assert!(apart - mixed > 5e-3);
    }

    #[test]
    fn what_is_no_glass_is_refused() {
        for n in [0.9, f64::NAN, f64::INFINITY, -1.5] {
            assert!(matches!(slab(n, 0.5), Err(OpticsError::Index { .. })));
            assert!(ball_order(n, 0.5, 1).is_err());
        }
        assert!(slab(1.5, 1.1).is_err() && face(1.5, f64::NAN).is_err());
    }
}
