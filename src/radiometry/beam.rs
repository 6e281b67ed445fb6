//! Parallel light: a round beam of even irradiance.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Flux, Irradiance, RadiometryError};
use crate::geometry::{finite_point, positive, unit};

/// A collimated beam: light in one direction through a disk across it.
///
/// Like a point source it is a limit: all its rays have the same direction, so that its radiance has no bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    center: DVec3,
    direction: DVec3,
    radius: f64,
    irradiance: Irradiance,
}

impl Beam {
    /// - `center`: of the disk that the beam starts from, metres; `direction`: any length but zero
    /// - `radius`: metres, > 0; `irradiance`: on a surface across the beam, W/m², finite, ≥ 0
    pub fn new(
        center: DVec3,
        direction: DVec3,
        radius: f64,
        irradiance: Irradiance,
    ) -> Result<Beam, RadiometryError> {
        let said = irradiance.watts_per_square_metre();
        if !(said.is_finite() && said >= 0.0) {
            return Err(RadiometryError::Irradiance { said });
        }
        if !super::is_in_range(said) {
            return Err(RadiometryError::OutOfRange { what: "irradiance", unit: "W/m²", said });
        }
        Ok(Beam {
            center: finite_point("center", center)?,
            direction: unit("direction", direction)?,
            radius: positive("radius", radius)?,
            irradiance,
        })
    }
    /// Metres.
    pub fn center(&self) -> DVec3 {
        self.center
    }
    /// Unit vector that the light travels along.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }
    /// Metres.
    pub fn radius(&self) -> f64 {
        self.radius
    }
    /// On a surface across the beam, W/m².
    pub fn irradiance(&self) -> Irradiance {
        self.irradiance
    }
    /// E π R², W.
    pub fn power(&self) -> Flux {
        Flux::new(self.irradiance.watts_per_square_metre() * PI * self.radius * self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beam_carries_its_irradiance_times_its_section() {
        let beam = Beam::new(DVec3::ZERO, DVec3::Z * 7.0, 2.0, Irradiance::new(3.0)).unwrap();
        assert_eq!((beam.direction(), beam.power().watts()), (DVec3::Z, 12.0 * PI));
    }

    #[test]
    fn what_is_no_beam_is_refused() {
        let one = Irradiance::new(1.0);
        for said in [-1.0, f64::NAN, f64::INFINITY] {
            let found = Beam::new(DVec3::ZERO, DVec3::Z, 1.0, Irradiance::new(said));
            assert!(matches!(found, Err(RadiometryError::Irradiance { .. })));
            assert!(Beam::new(DVec3::ZERO, DVec3::Z, said, one).is_err());
        }
        assert!(Beam::new(DVec3::ZERO, DVec3::ZERO, 1.0, one).is_err());
        assert!(Beam::new(DVec3::NAN, DVec3::Z, 1.0, one).is_err());
    }
}
