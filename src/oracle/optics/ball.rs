//! A ball of glass in a beam.

use super::faces::{self, Loss, Polarised};
use super::fan::Fan;
use super::spherical::{half_tangent, of_half_tangent};
use crate::number::{Number, Wide};

/// A ball of radius R and index n around the origin, in a beam along −z, seen on the plane z = −q, q ≥ R, after one passage.
/// With sin i = n sin r and the deviation δ = 2 (i − r)
///
/// ```text
/// ρ = (R sin i − q sin δ)/cos δ,   flux = R² sin² i/2,   δ < π/2
/// ```
///
/// The parameter u is tan(i/2).
#[derive(Clone, Copy, Debug)]
pub(super) struct GlassBall {
    pub radius: f64,
    pub index: f64,
    pub distance: f64,
    pub beam_radius: f64,
    pub loss: Loss,
}

/// What the face lets through and sends back at a cosine in air; constructors have seen to the index.
pub(super) fn glass_face(index: f64, cosine: f64) -> [Polarised; 2] {
    faces::face(index, cosine.clamp(0.0, 1.0)).unwrap_or([Polarised { s: f64::NAN, p: f64::NAN }; 2])
}

impl Fan for GlassBall {
    fn landing<T: Number>(&self, u: T) -> T {
        let (sin_i, cos_i) = of_half_tangent(u);
        let sin_r = sin_i / T::constant(self.index);
        let cos_r = ((T::constant(1.0) - sin_r) * (sin_r + 1.0)).sqrt();
        let (sin_half, cos_half) = (sin_i * cos_r - cos_i * sin_r, cos_i * cos_r + sin_i * sin_r);
        let (sin, cos) = (sin_half * cos_half * 2.0, T::constant(1.0) - sin_half * sin_half * 2.0);
        (sin_i * self.radius - sin * self.distance) / cos
    }
    fn flux<T: Number>(&self, u: T) -> T {
        let (sin, _) = of_half_tangent(u);
        let r = sin * self.radius;
        r * r * 0.5
    }
    fn share(&self, u: f64) -> f64 {
        if self.is_lossless() {
            return 1.0;
        }
        let [through, _] = glass_face(self.index, of_half_tangent(u).1);
        self.loss.through(through, through)
    }
    fn is_lossless(&self) -> bool {
        self.loss == Loss::None
    }
    /// The beam's rim, or the ray that is turned by a right angle, where tan i = n/(n − √2).
    fn last(&self) -> Wide {
        let rim = half_tangent(self.beam_radius, self.radius);
        let n = Wide::from(self.index);
        let over = n - Wide::from(2.0).sqrt();
        if over.narrow() <= 0.0 {
            return rim;
        }
        let level = n / (over + (over.square() + n.square()).sqrt());
        // Just short of it: the ray itself never lands.
        let short = level * Wide::difference(1.0, 2.0_f64.powi(-80));
        if (short - rim).narrow() < 0.0 { short } else { rim }
    }
    fn size(&self) -> f64 {
        self.radius
    }
}
