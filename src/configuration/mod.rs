//! What stands in the room: sources, occluders, a receiver, and the points where light is measured.
//!
//! A [`Configuration`] is valid by construction. The exact side and the estimating side both read it and share nothing
//! else of what they do with it.

mod digest;
mod receiver;
mod validate;

use std::sync::Arc;

use glam::DVec3;

use crate::geometry::{Shape, ShapeError};
use crate::radiometry::{Albedo, Exitance};
use crate::texture::{Texture, TextureError};

pub use digest::Digest;
pub use receiver::{Receiver, ReceiverShape};
pub use validate::ConfigurationError;

/// A Lambertian emitter. One-sided: a flat shape emits from its lit side, a sphere from its outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    shape: Shape,
    /// Over all of it, or the mean of its texture.
    exitance: Exitance,
    texture: Option<Arc<Texture>>,
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
        Ok(Source { shape, exitance, texture: None })
    }

    /// A source whose exitance varies over it.
    ///
    /// - `texture`: W/m², laid out on the same shape; some of it above zero
    pub fn textured(shape: Shape, texture: Texture) -> Result<Source, ConfigurationError> {
        let mean = texture.mean();
        if mean <= 0.0 {
            return Err(ConfigurationError::Texture(TextureError::Dark));
        }
        let source = Source::new(shape, Exitance::new(mean))?;
        Ok(Source { texture: Some(Arc::new(texture)), ..source })
    }

    pub fn shape(&self) -> &Shape {
        &self.shape
    }
    /// W/m²; of a textured source, the mean over its surface.
    pub fn exitance(&self) -> Exitance {
        self.exitance
    }
    /// What its exitance is read from, where that varies; W/m².
    pub fn texture(&self) -> Option<&Arc<Texture>> {
        self.texture.as_ref()
    }
    /// At a point of its surface (metres).
    pub fn exitance_at(&self, point: DVec3) -> Exitance {
        self.texture.as_ref().map_or(self.exitance, |texture| Exitance::new(texture.at(point)))
    }
    /// The most that it sends out anywhere, or somewhat more.
    pub fn largest_exitance(&self) -> Exitance {
        self.texture.as_ref().map_or(self.exitance, |texture| Exitance::new(texture.range()[1]))
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
    /// Share of light that the receiver sends back, on average over it; `None` where the case names no receiver or no albedo.
    pub fn albedo(&self) -> Option<Albedo> {
        self.receiver.as_ref().and_then(Receiver::albedo)
    }
    /// Share of light that the receiver sends back at each measurement point, read there if it is textured; `None` where the
    /// case names no receiver or no albedo.
    pub fn albedos(&self) -> Option<Vec<Albedo>> {
        let receiver = self.receiver.as_ref()?;
        self.points.iter().map(|point| receiver.albedo_at(point.position())).collect()
    }
    /// A fingerprint of everything physical, and of nothing else: names, titles and study settings do not enter.
    pub fn digest(&self) -> Digest {
        Digest::of(self)
    }
}
