//! What stands in the room: sources, occluders, a receiver, and the points where light is measured.
//!
//! A [`Configuration`] is valid by construction. The exact side and the estimating side both read it and share nothing
//! else of what they do with it.

mod digest;
mod receiver;
mod validate;

use glam::DVec3;

use crate::geometry::{Shape, ShapeError};
use crate::radiometry::{Albedo, Exitance};

pub use digest::Digest;
pub use receiver::{Receiver, ReceiverShape};
pub use validate::ConfigurationError;

/// A Lambertian emitter. One-sided: a flat shape emits from its lit side, a sphere from its outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    shape: Shape,
    exitance: Exitance,
}

impl Source {
    /// - `exitance`: W/m², uniform over the shape, finite and ≥ 0
    pub fn new(shape: Shape, exitance: Exitance) -> Result<Source, ConfigurationError> {
        let said = exitance.watts_per_square_metre();
        if !(said.is_finite() && said >= 0.0) {
            return Err(ConfigurationError::Exitance { said });
        }
        if let Shape::Mesh(_) = shape {
            return Err(ConfigurationError::MeshSource);
        }
        Ok(Source { shape, exitance })
    }
    pub fn shape(&self) -> &Shape {
        &self.shape
    }
    /// W/m².
    pub fn exitance(&self) -> Exitance {
        self.exitance
    }
}

/// Where irradiance is asked for: a position and the unit normal of the surface element there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasurementPoint {
    position: DVec3,
    normal: DVec3,
    as_given: DVec3,
}

impl MeasurementPoint {
    /// - `position`: metres; `normal`: any length but zero
    pub fn new(position: DVec3, normal: DVec3) -> Result<MeasurementPoint, ShapeError> {
        Ok(MeasurementPoint {
            position: crate::geometry::finite_point("position", position)?,
            normal: crate::geometry::unit("normal", normal)?,
            as_given: normal,
        })
    }
    /// Metres.
    pub fn position(&self) -> DVec3 {
        self.position
    }
    /// Unit vector towards the receiving side.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }
    /// The normal to the digits it was given with, of any length: [`MeasurementPoint::normal`] is rounded.
    pub fn normal_as_given(&self) -> DVec3 {
        self.as_given
    }
}

/// How the measurement points lie, for whoever draws or bins them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrangement {
    /// In order along a line (or an arc, on a sphere).
    Line,
    /// Row by row over the receiver: `nu` columns (fastest), `nv` rows.
    Grid { nu: usize, nv: usize },
    /// Anywhere, in any pose.
    Scattered,
}

/// A room in which light can be measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    sources: Vec<Source>,
    occluders: Vec<Shape>,
    receiver: Option<Receiver>,
    points: Vec<MeasurementPoint>,
    arrangement: Arrangement,
}

impl Configuration {
    /// Every mistake that spans more than one part is reported, not only the first.
    ///
    /// - `sources`: at least one; each blocks the light of the others
    /// - `occluders`: block from both sides; spheres are solid
    /// - `points`: at least one, none exactly on a source or occluder
    pub fn new(
        sources: Vec<Source>,
        occluders: Vec<Shape>,
        receiver: Option<Receiver>,
        points: Vec<MeasurementPoint>,
        arrangement: Arrangement,
    ) -> Result<Configuration, Vec<ConfigurationError>> {
        let configuration = Configuration { sources, occluders, receiver, points, arrangement };
        let mistakes = validate::mistakes(&configuration);
        if mistakes.is_empty() { Ok(configuration) } else { Err(mistakes) }
    }

    pub fn sources(&self) -> &[Source] {
        &self.sources
    }
    pub fn occluders(&self) -> &[Shape] {
        &self.occluders
    }
    pub fn receiver(&self) -> Option<&Receiver> {
        self.receiver.as_ref()
    }
    pub fn points(&self) -> &[MeasurementPoint] {
        &self.points
    }
    pub fn arrangement(&self) -> Arrangement {
        self.arrangement
    }
    /// Share of light that the receiver sends back; `None` where the case names no receiver or no albedo.
    pub fn albedo(&self) -> Option<Albedo> {
        self.receiver.as_ref().and_then(Receiver::albedo)
    }
    /// A fingerprint of everything physical, and of nothing else: names, titles and study settings do not enter.
    pub fn digest(&self) -> Digest {
        Digest::of(self)
    }
}
