//! What stands in the room: sources, occluders, a receiver, and the points where light is measured.
//!
//! A [`Configuration`] is valid by construction. The exact side and the estimating side both read it and share nothing
//! else of what they do with it.

mod diffuse;
mod digest;
#[cfg(feature = "studies")]
mod figure;
mod optic;
mod receiver;
mod sha256;
mod validate;

use std::sync::Arc;

use glam::DVec3;

use crate::geometry::{Shape, ShapeError};
use crate::radiometry::{Albedo, Beam, Exitance, PointSource, is_in_range};
use crate::texture::{Texture, TextureError};

pub use diffuse::DiffuseSurface;
pub use digest::Digest;
#[cfg(feature = "studies")]
pub use figure::{Figure, Role, Stroke};
pub use optic::{Glass, GlassShape, Mirror, MirrorShape};
pub use receiver::{Receiver, ReceiverShape};
#[cfg(feature = "studies")]
pub(crate) use sha256::Sha256;
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
        if !is_in_range(said) {
            return Err(ConfigurationError::ExitanceOutOfRange { said });
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

/// A source without area, of which no area estimator and no form factor speaks: only rays from the light.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Lamp {
    Point(PointSource),
    Beam(Beam),
}

impl Lamp {
    /// W.
    pub fn power(&self) -> f64 {
        match self {
            Lamp::Point(lamp) => lamp.power().watts(),
            Lamp::Beam(lamp) => lamp.power().watts(),
        }
    }
}

/// All that can stand in a room, before it is looked over as a whole. Every field may be empty by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// Each blocks the light of the others.
    pub sources: Vec<Source>,
    pub lamps: Vec<Lamp>,
    /// Block from both sides; spheres are solid.
    pub occluders: Vec<Shape>,
    /// Block direct light, as glass does, and send it on.
    pub mirrors: Vec<Mirror>,
    /// No two may share any space.
    pub glass: Vec<Glass>,
    pub diffuse: Vec<DiffuseSurface>,
    /// Blocks nothing; light that arrives on its receiving side stops there, and passes from behind.
    pub receiver: Option<Receiver>,
    /// None exactly on a source, an occluder, or an optic. May be empty where rays from the light are followed to a
    /// receiver or a diffuse surface: where there is a lamp, an optic, or a diffuse surface.
    pub points: Vec<MeasurementPoint>,
    pub arrangement: Arrangement,
}

impl Default for Contents {
    fn default() -> Contents {
        Contents {
            sources: Vec::new(),
            lamps: Vec::new(),
            occluders: Vec::new(),
            mirrors: Vec::new(),
            glass: Vec::new(),
            diffuse: Vec::new(),
            receiver: None,
            points: Vec::new(),
            arrangement: Arrangement::Scattered,
        }
    }
}

/// A room in which light can be measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    contents: Contents,
    /// [`Contents::sources`], then the diffuse surfaces that emit outwards.
    sources: Vec<Source>,
    /// What blocks direct light besides the sources; see [`Configuration::blockers`].
    blockers: Vec<Shape>,
}

impl Configuration {
    /// A room without lamps, optics or diffuse surfaces. Every mistake that spans more than one part is reported, not only
    /// the first.
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
        Configuration::of(Contents { sources, occluders, receiver, points, arrangement, ..Contents::default() })
    }

    /// A room with anything in it. Every mistake that spans more than one part is reported, not only the first.
    pub fn of(contents: Contents) -> Result<Configuration, Vec<ConfigurationError>> {
        let mistakes = validate::mistakes(&contents);
        if !mistakes.is_empty() {
            return Err(mistakes);
        }
        let emits = |surface: &&DiffuseSurface| surface.exitance().watts_per_square_metre() > 0.0;
        let outward = || contents.diffuse.iter().filter(|surface| !surface.is_enclosure());
        let of_diffuse = outward().filter(emits).map(|surface| Source {
            shape: surface.as_shape(),
            exitance: surface.exitance(),
            texture: None,
        });
        let sources = contents.sources.iter().cloned().chain(of_diffuse).collect();
        let mut blockers = contents.occluders.clone();
        blockers.extend(contents.mirrors.iter().filter_map(|mirror| mirror.shape().outline()).flatten());
        blockers.extend(contents.glass.iter().filter_map(|glass| glass.shape().outline()).flatten());
        blockers.extend(outward().filter(|surface| !emits(surface)).map(DiffuseSurface::as_shape));
        Ok(Configuration { contents, sources, blockers })
    }

    /// Surfaces that emit: the sources, then the diffuse surfaces that emit outwards.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }
    /// Sources without area.
    pub fn lamps(&self) -> &[Lamp] {
        &self.contents.lamps
    }
    pub fn occluders(&self) -> &[Shape] {
        &self.contents.occluders
    }
    pub fn mirrors(&self) -> &[Mirror] {
        &self.contents.mirrors
    }
    pub fn glass(&self) -> &[Glass] {
        &self.contents.glass
    }
    pub fn diffuse(&self) -> &[DiffuseSurface] {
        &self.contents.diffuse
    }
    /// Everything that was put into the room.
    pub fn contents(&self) -> &Contents {
        &self.contents
    }
    /// What stops direct light besides the sources, in this order: occluders, then by their outlines mirrors, glass, and
    /// diffuse surfaces that do not emit.
    ///
    /// A lens and the curved mirrors that are no whole sphere have no outline in closed form. They are left out here, and a
    /// configuration in which one may stand between a measurement point and a source with area is refused
    /// ([`ConfigurationError::CurvedBefore`]).
    pub fn blockers(&self) -> &[Shape] {
        &self.blockers
    }
    pub fn receiver(&self) -> Option<&Receiver> {
        self.contents.receiver.as_ref()
    }
    pub fn points(&self) -> &[MeasurementPoint] {
        &self.contents.points
    }
    pub fn arrangement(&self) -> Arrangement {
        self.contents.arrangement
    }
    /// Share of light that the receiver sends back, on average over it; `None` where the case names no receiver or no albedo.
    pub fn albedo(&self) -> Option<Albedo> {
        self.receiver().and_then(Receiver::albedo)
    }
    /// Whether any light is bent: then direct light is not all there is.
    pub fn has_optics(&self) -> bool {
        !self.contents.mirrors.is_empty() || !self.contents.glass.is_empty()
    }
    /// Share of light that the receiver sends back at each measurement point, read there if it is textured; `None` where the
    /// case names no receiver or no albedo.
    pub fn albedos(&self) -> Option<Vec<Albedo>> {
        let receiver = self.receiver()?;
        self.points().iter().map(|point| receiver.albedo_at(point.position())).collect()
    }
    /// Everything in the room as lines, for a drawing of it.
    #[cfg(feature = "studies")]
    pub fn figures(&self) -> Vec<Figure> {
        figure::figures(self)
    }
    /// A fingerprint of everything physical, and of nothing else: names, titles and study settings do not enter.
    pub fn digest(&self) -> Digest {
        Digest::of(self)
    }
}
