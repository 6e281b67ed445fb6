//! A lens, flat above and bulging below, in a beam.

use super::ball::glass_face;
use super::faces::Loss;
use super::fan::Fan;
use super::spherical::of_half_tangent;
use crate::number::{Number, Wide};

/// A plano-convex lens of radius of curvature R and index n, its flat face towards a beam along −z and the vertex of the other
/// at z = 0, seen on the plane z = −q. A ray at the distance h from the axis leaves at the height of the sag, at φ to the
/// face's normal inside and θ outside:
///
/// ```text
/// sin φ = h/R,  sin θ = n h/R,   sag = R (1 − cos φ),   ρ = h − (q + sag) tan(θ − φ),   flux = h²/2
/// ```
///
/// The parameter u is tan(θ/2); beyond θ = π/2 the light stays in the glass.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanoConvex {
    pub radius: f64,
    pub index: f64,
    pub distance: f64,
    pub beam_radius: f64,
    pub loss: Loss,
}

impl Fan for PlanoConvex {
    fn landing<T: Number>(&self, u: T) -> T {
        let (sin_out, cos_out) = of_half_tangent(u);
        let sin_in = sin_out / T::constant(self.index);
        let cos_in = ((T::constant(1.0) - sin_in) * (sin_in + 1.0)).sqrt();
        let deviation = (sin_out * cos_in - cos_out * sin_in) / (cos_out * cos_in + sin_out * sin_in);
        let sag = sin_in * sin_in / (cos_in + 1.0) * self.radius;
        sin_in * self.radius - (sag + self.distance) * deviation
    }
    fn flux<T: Number>(&self, u: T) -> T {
        let (sin, _) = of_half_tangent(u);
        let h = sin * self.radius / T::constant(self.index);
        h * h * 0.5
    }
    fn share(&self, u: f64) -> f64 {
        if self.is_lossless() {
            return 1.0;
        }
        // A face lets through the same share of a ray and of its reverse: that of the ray from outside has no cancellation. At
        // normal incidence both polarisations are alike, so that nothing hangs on how they are averaged.
        let [[flat, _], [curved, _]] = [1.0, of_half_tangent(u).1].map(|cosine| glass_face(self.index, cosine));
        flat.then(curved).mean()
    }
    fn is_lossless(&self) -> bool {
        self.loss == Loss::None
    }
    /// The beam's rim, or the ray that grazes the curved face.
    fn last(&self) -> Wide {
        // sin θ = n h/R; n h may need more digits than an f64 has.
        let sine = Wide::product(self.index, self.beam_radius) / Wide::from(self.radius);
        if (sine - Wide::ONE).narrow() >= 0.0 {
            return Wide::ONE;
        }
        sine / (((Wide::ONE - sine) * (Wide::ONE + sine)).sqrt() + Wide::ONE)
    }
    fn size(&self) -> f64 {
        self.radius
    }
}

#[cfg(test)]
mod tests {
    use super::super::spherical::half_tangent;
    use super::*;

    #[test]
    fn a_beam_as_wide_as_the_glass_lets_out_ends_at_grazing() {
        let lens =
            |beam_radius: f64| PlanoConvex { radius: 1.0, index: 1.5, distance: 1.0, beam_radius, loss: Loss::None };
        assert_eq!(lens(0.9).last().narrow(), 1.0);
        let narrow = lens(0.3).last().narrow();
        assert!((narrow - half_tangent(0.45, 1.0).narrow()).abs() < 1e-16);
    }
}
