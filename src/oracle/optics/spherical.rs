//! A spherical mirror under a beam along its axis.

use super::fan::Fan;
use crate::number::{Number, Wide};

/// The mirror of radius R with its vertex at z = 0 and its centre at z = R, under a beam along −z, seen on the plane
/// z = z_p. With r = R sin t and q = R − z_p
///
/// ```text
/// ρ = sin t (2 q cos t − R)/cos 2t,   flux = R² sin² t/2,   t < π/4
/// ```
///
/// The parameter u is tan(t/2), so that everything is rational.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphericalMirror {
    pub radius: f64,
    pub plane: f64,
    pub beam_radius: f64,
}

/// sin and cos of the angle whose half has the tangent u.
pub(super) fn of_half_tangent<T: Number>(u: T) -> (T, T) {
    let share = T::constant(1.0) / (u * u + 1.0);
    (u * share * 2.0, (T::constant(1.0) - u) * (u + 1.0) * share)
}

/// tan(t/2) of the angle with sin t = `part`/`whole`, part ≤ whole.
pub(super) fn half_tangent(part: f64, whole: f64) -> Wide {
    let cosine = (Wide::difference(whole, part) * Wide::sum(whole, part)).sqrt();
    Wide::from(part) / (cosine + Wide::from(whole))
}

impl Fan for SphericalMirror {
    fn landing<T: Number>(&self, u: T) -> T {
        let (sin, cos) = of_half_tangent(u);
        let above = T::constant(self.radius) - T::constant(self.plane);
        sin * (above * cos * 2.0 + -self.radius) / (T::constant(1.0) - sin * sin * 2.0)
    }
    fn flux<T: Number>(&self, u: T) -> T {
        let (sin, _) = of_half_tangent(u);
        let r = sin * self.radius;
        r * r * 0.5
    }
    fn share(&self, _: f64) -> f64 {
        1.0
    }
    fn is_lossless(&self) -> bool {
        true
    }
    /// The beam's rim, or the circle in which the plane cuts the mirror, where R (1 − cos t) = z_p: from above it no light
    /// comes back to the plane.
    fn last(&self) -> Wide {
        let rim = half_tangent(self.beam_radius, self.radius);
        let above = Wide::from(self.radius) * 2.0 - Wide::from(self.plane);
        if above.narrow() <= 0.0 {
            return rim;
        }
        let level = (Wide::from(self.plane) / above).sqrt();
        if (level - rim).narrow() < 0.0 { level } else { rim }
    }
    fn size(&self) -> f64 {
        self.radius
    }
}
