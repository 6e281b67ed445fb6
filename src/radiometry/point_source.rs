//! A source without extent: all its power leaves one point, evenly in all directions.
//!
//! It is a limit, not a thing: its radiance would have no bound, and no exitance describes it. What it has is a power and
//! an intensity, and those suffice for every law below.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Flux, Intensity, Irradiance, RadiometryError, SolidAngle};
use crate::geometry::{finite_point, unit};

/// A point source of even intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointSource {
    position: DVec3,
    power: Flux,
}

impl PointSource {
    /// - `position`: metres, finite; `power`: W, finite, ≥ 0
    pub fn new(position: DVec3, power: Flux) -> Result<PointSource, RadiometryError> {
        let said = power.watts();
        if !(said.is_finite() && said >= 0.0) {
            return Err(RadiometryError::Power { said });
        }
        if !super::is_in_range(said) {
            return Err(RadiometryError::OutOfRange { what: "power", unit: "W", said });
        }
        Ok(PointSource { position: finite_point("position", position)?, power })
    }
    /// Metres.
    pub fn position(&self) -> DVec3 {
        self.position
    }
    /// W.
    pub fn power(&self) -> Flux {
        self.power
    }
    /// I = P/4π, W/sr.
    pub fn intensity(&self) -> Intensity {
        Intensity::new(self.power.watts() / (4.0 * PI))
    }

    /// Power through anything that fills a solid angle seen from the source, whatever its distance: I Ω.
    pub fn flux_into(&self, solid_angle: SolidAngle) -> Flux {
        self.intensity() * solid_angle
    }

    /// Irradiance on a surface element, nothing in between: I cosθ/r², zero where the element faces away.
    ///
    /// - `position`: metres, not the source's own; `normal`: any length but zero
    /// - returns W/m²
    /// - error: relative, below 8 · 2⁻⁵³ over cosθ
    /// - source: an element of area dA fills dω = cosθ dA/r²
    pub fn irradiance_at(&self, position: DVec3, normal: DVec3) -> Result<Irradiance, RadiometryError> {
        let (position, normal) = (finite_point("position", position)?, unit("normal", normal)?);
        let towards = self.position - position;
        let distance = towards.length();
        if distance == 0.0 {
            return Err(RadiometryError::AtSource);
        }
        let cosine = (towards / distance).dot(normal).max(0.0);
        Ok(Irradiance::new(self.intensity().watts_per_steradian() / distance / distance * cosine))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn irradiance_falls_with_the_square_and_the_cosine() {
        let lamp = PointSource::new(DVec3::Z, Flux::new(4.0 * PI)).unwrap();
        let at =
            |position: DVec3, normal: DVec3| lamp.irradiance_at(position, normal).unwrap().watts_per_square_metre();
        assert_relative_eq!(at(DVec3::ZERO, DVec3::Z * 7.0), 1.0, max_relative = 1e-15);
        assert_relative_eq!(at(DVec3::Z * -1.0, DVec3::Z), 0.25, max_relative = 1e-15);
        assert_relative_eq!(at(DVec3::ZERO, DVec3::new(0.0, 3.0, 4.0)), 0.8, max_relative = 1e-15);
        assert_eq!(at(DVec3::ZERO, DVec3::NEG_Z), 0.0);
    }

    #[test]
    fn what_is_no_source_or_no_place_is_refused() {
        for watts in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(PointSource::new(DVec3::Z, Flux::new(watts)), Err(RadiometryError::Power { .. })));
        }
        for watts in [5e-324, 1e-31, 1e31, f64::MAX] {
            assert!(matches!(PointSource::new(DVec3::Z, Flux::new(watts)), Err(RadiometryError::OutOfRange { .. })));
        }
        assert!([0.0, 1e-30, 1e30].iter().all(|watts| PointSource::new(DVec3::Z, Flux::new(*watts)).is_ok()));
        assert!(PointSource::new(DVec3::NAN, Flux::new(1.0)).is_err());
        let lamp = PointSource::new(DVec3::Z, Flux::new(1.0)).unwrap();
        assert_eq!(lamp.irradiance_at(DVec3::Z, DVec3::Z), Err(RadiometryError::AtSource));
        assert!(lamp.irradiance_at(DVec3::ZERO, DVec3::ZERO).is_err());
    }
}
