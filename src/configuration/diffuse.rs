//! Further diffuse surfaces: light lands on them, and they may emit of their own accord.

use glam::DVec3;

use super::{ConfigurationError, ReceiverShape};
use crate::geometry::Shape;
use crate::radiometry::{Albedo, Exitance, is_in_range};

/// A Lambertian surface. Its front (outside, for a sphere) receives and emits; its back is black. Opaque from both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseSurface {
    shape: ReceiverShape,
    albedo: Albedo,
    exitance: Exitance,
    inward: bool,
    transmittance: f64,
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
        if !is_in_range(said) {
            return Err(ConfigurationError::ExitanceOutOfRange { said });
        }
        if inward && !matches!(shape, ReceiverShape::Sphere(_)) {
            return Err(ConfigurationError::InwardFlat);
        }
        Ok(DiffuseSurface { shape, albedo, exitance, inward, transmittance: 0.0 })
    }
    /// A shade: a sphere that sends its albedo's share of what arrives inside back inside, and lets another share through,
    /// both diffusely. From outside to inside it lets the same share through; its outside sends nothing back.
    ///
    /// - `self`: inward, emits nothing
    /// - `transmittance`: in [0, 1], with the albedo at most 1, which the albedo alone is not; zero: it lets nothing through
    pub fn translucent(self, transmittance: f64) -> Result<DiffuseSurface, ConfigurationError> {
        if transmittance == 0.0 {
            return Ok(self);
        }
        let albedo = self.albedo.ratio();
        // Decimals that add up to one may do so but for rounding.
        let most = 1.0 - albedo + 4.0 * f64::EPSILON;
        if !(transmittance > 0.0 && transmittance <= most && albedo < 1.0) {
            return Err(ConfigurationError::Transmittance { said: transmittance, albedo });
        }
        if !self.inward || self.exitance.watts_per_square_metre() > 0.0 {
            return Err(ConfigurationError::NoShade);
        }
        Ok(DiffuseSurface { transmittance, ..self })
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
    /// Whether the inside is the diffuse side.
    pub fn is_inward(&self) -> bool {
        self.inward
    }
    /// Share of arriving power that is let through, diffusely; zero but for shades.
    pub fn transmittance(&self) -> f64 {
        self.transmittance
    }
    /// Whether all else lies inside.
    pub fn is_enclosure(&self) -> bool {
        self.inward && self.transmittance == 0.0
    }
    /// The same surface as a shape that emits and blocks.
    pub fn as_shape(&self) -> Shape {
        self.shape.as_shape()
    }
    /// Whether a sphere lies within this enclosure; true of what is none.
    pub(super) fn encloses(&self, center: DVec3, radius: f64) -> bool {
        match &self.shape {
            ReceiverShape::Sphere(s) if self.is_enclosure() => {
                (center - s.center()).length() + radius <= s.radius() * (1.0 + 1e-12)
            }
            _ => true,
        }
    }
}
