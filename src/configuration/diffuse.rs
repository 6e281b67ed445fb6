//! Further diffuse surfaces: light lands on them, and they may emit of their own accord.

use glam::DVec3;

use super::{ConfigurationError, ReceiverShape};
use crate::geometry::Shape;
use crate::radiometry::{Albedo, Exitance};

/// A Lambertian surface. Its front (outside, for a sphere) receives and emits; its back is black. Opaque from both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseSurface {
    shape: ReceiverShape,
    albedo: Albedo,
    exitance: Exitance,
    inward: bool,
}

impl DiffuseSurface {
    /// - `albedo`: in [0, 1]; `exitance`: W/m², finite, ≥ 0
    /// - `inward`: a sphere receives and emits on its inside, and encloses all else
    pub fn new(
        shape: ReceiverShape,
        albedo: Albedo,
        exitance: Exitance,
        inward: bool,
    ) -> Result<DiffuseSurface, ConfigurationError> {
        if !(0.0..=1.0).contains(&albedo.ratio()) {
            return Err(ConfigurationError::Albedo { said: albedo.ratio() });
        }
        let said = exitance.watts_per_square_metre();
        if !(said.is_finite() && said >= 0.0) {
            return Err(ConfigurationError::Exitance { said });
        }
        if inward && !matches!(shape, ReceiverShape::Sphere(_)) {
            return Err(ConfigurationError::InwardFlat);
        }
        Ok(DiffuseSurface { shape, albedo, exitance, inward })
    }
    pub fn shape(&self) -> &ReceiverShape {
        &self.shape
    }
    /// Share of arriving power that is sent back.
    pub fn albedo(&self) -> Albedo {
        self.albedo
    }
    /// W/m².
    pub fn exitance(&self) -> Exitance {
        self.exitance
    }
    /// Whether it is an enclosure.
    pub fn is_inward(&self) -> bool {
        self.inward
    }
    /// The same surface as a shape that emits and blocks.
    pub fn as_shape(&self) -> Shape {
        self.shape.as_shape()
    }
    /// Whether a sphere lies within this enclosure; true of what is none.
    pub(super) fn encloses(&self, center: DVec3, radius: f64) -> bool {
        match &self.shape {
            ReceiverShape::Sphere(s) if self.inward => {
                (center - s.center()).length() + radius <= s.radius() * (1.0 + 1e-12)
            }
            _ => true,
        }
    }
}
