//! A paraboloid that mirrors a beam along its axis.

use super::fan::Fan;
use crate::number::{Number, Wide};

/// The mirror z = r²/4f under a beam along −z, seen on the plane z = z_p. All rays pass the focus; with s = r/2f
///
/// ```text
/// ρ = 2 (f − z_p) s/(1 − s²),   flux = r²/2 = 2 f² s²
/// ```
///
/// so that E/E₀ = (1 − s²)³/(κ² (1 + s²)), κ = |1 − z_p/f|. The parameter u is s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Paraboloid {
    pub focal_length: f64,
    pub plane: f64,
    pub beam_radius: f64,
}

impl Fan for Paraboloid {
    fn landing<T: Number>(&self, s: T) -> T {
        let beyond = T::constant(self.focal_length) - T::constant(self.plane);
        beyond * s * 2.0 / ((T::constant(1.0) - s) * (s + 1.0))
    }
    fn flux<T: Number>(&self, s: T) -> T {
        let radius = s * self.focal_length * 2.0;
        radius * radius * 0.5
    }
    fn share(&self, _: f64) -> f64 {
        1.0
    }
    fn is_lossless(&self) -> bool {
        true
    }
    /// The beam's rim, or the circle in which the plane cuts the mirror: from above it no light comes back to the plane.
    fn last(&self) -> Wide {
        let rim = Wide::from(self.beam_radius) / Wide::from(self.focal_length) * 0.5;
        let level = (Wide::from(self.plane) / Wide::from(self.focal_length)).sqrt();
        if (level - rim).narrow() < 0.0 { level } else { rim }
    }
    fn size(&self) -> f64 {
        self.focal_length
    }
}
