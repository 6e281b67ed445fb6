//! A case as a scene of another renderer: what it can hold, and where the camera stands.
//!
//! [`mitsuba`] writes a scene that Mitsuba reads as it is; [`plain`] writes the case in numbers, for a script that builds the
//! scene of any other renderer from them.

mod mitsuba;
mod plain;

use glam::DVec3;
use thiserror::Error;

use super::manifest::{Manifest, Seeds};
use super::pixels::PixelGrid;
use crate::configuration::{Configuration, Contents, GlassShape, Lamp, MirrorShape, ReceiverShape, Source};
use crate::geometry::{Frame, Polygon, Rectangle, Shape, Sphere};
use crate::radiometry::Beam;
use crate::sampling::triangulated;
use crate::texture::{Lookup, Raster};

pub use mitsuba::mitsuba;
pub use plain::plain;

/// What an export is to look like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Columns and rows; else 32 along the longer edge, square ones.
    pub pixels: Option<[usize; 2]>,
    pub samples_per_pixel: u64,
}

/// A scene: files by name, and what its images will be.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// In the order in which they are to be written; `manifest.json` is the last.
    pub files: Vec<(String, Vec<u8>)>,
    /// `None` where the receiver is no rectangle, so that no image can be of it.
    pub manifest: Option<Manifest>,
}

/// What a scene of another renderer cannot hold.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Inexpressible {
    #[error("{what} {index} (counted from 0): {why}")]
    Thing { what: &'static str, index: usize, why: &'static str },
    #[error("the receiver is {kind}; a camera that sees nothing but the receiver needs a rectangle")]
    Receiver { kind: &'static str },
    #[error("there is no source with an area")]
    NoSource,
    #[error(
        "{role} {index} (a {kind}, counted from 0) {how}: the camera, which stands between the receiver and everything else, has no room"
    )]
    NoRoom { role: &'static str, index: usize, kind: &'static str, how: &'static str },
    #[error("{width} x {height} pixels; 1 to {} are accepted", PixelGrid::MOST_PIXELS)]
    Pixels { width: usize, height: usize },
    #[error("{said} samples a pixel; 1 to {most} are accepted", most = MOST_SAMPLES)]
    Samples { said: u64 },
}

/// Samples that a pixel of an exported scene has at most.
const MOST_SAMPLES: u64 = 1 << 30;
/// Neighbouring seeds of one renderer lead to streams that overlap; so far apart they do not.
const SEEDS: Seeds = Seeds { first: 1, spacing: 1_000_003 };

/// The receiver and the height of the camera above it, metres; everything that stands in the way, at once.
fn camera(configuration: &Configuration) -> Result<(Rectangle, f64), Vec<Inexpressible>> {
    let mut found = beyond_direct_light(configuration);
    let receiver = receiver(configuration).map_err(|kind| found.push(Inexpressible::Receiver { kind }));
    let height = receiver.map(|receiver| camera_height(configuration, &receiver).map(|height| (receiver, height)));
    match height {
        Ok(Ok(camera)) if found.is_empty() => return Ok(camera),
        Ok(Err(no_room)) => found.extend(no_room),
        _ => {}
    }
    Err(found)
}

/// A beam, a ball of glass and nothing else: what is told of caustics.
fn beam_and_ball(configuration: &Configuration) -> Option<(&Beam, &Sphere, f64)> {
    let Contents { sources, occluders, mirrors, diffuse, .. } = configuration.contents();
    let alone = sources.is_empty() && occluders.is_empty() && mirrors.is_empty() && diffuse.is_empty();
    match (alone.then_some(configuration.lamps())?, configuration.glass()) {
        ([Lamp::Beam(beam)], [glass]) => match glass.shape() {
            GlassShape::Sphere(ball) => Some((beam, ball, glass.ior())),
            _ => None,
        },
        _ => None,
    }
}

/// What is more than shapes that shine evenly, or by fields, shapes that stand in the way, and a flat mirror.
fn beyond_direct_light(configuration: &Configuration) -> Vec<Inexpressible> {
    let mut found = Vec::new();
    let thing = |what, index, why| Inexpressible::Thing { what, index, why };
    for (i, source) in configuration.contents().sources.iter().enumerate() {
        if source.texture().is_some() && fields(source).is_none() {
            let why = "an exitance that varies over the source is exported of a rectangle with even texels only";
            found.push(thing("source", i, why));
        }
    }
    for (i, lamp) in configuration.lamps().iter().enumerate() {
        let what = match lamp {
            Lamp::Point(_) => "source.point",
            Lamp::Beam(_) => "source.beam",
        };
        found.push(thing(what, i, "a lamp without area is not exported"));
    }
    let unsupported = "only direct light, and light by one flat mirror, is exported";
    let mirrors = configuration.mirrors();
    let alone = mirrors.len() == 1;
    let refused = (0..mirrors.len()).filter(|i| !alone || flat_mirror(mirrors[*i].shape()).is_none());
    found.extend(refused.map(|i| thing("mirror", i, unsupported)));
    found.extend((0..configuration.glass().len()).map(|i| thing("glass", i, unsupported)));
    found.extend((0..configuration.diffuse().len()).map(|i| thing("diffuse surface", i, unsupported)));
    if configuration.contents().sources.is_empty() {
        found.push(Inexpressible::NoSource);
    }
    found
}

/// The exitances of a rectangle whose texels are even, W/m²: s along `edge_u`, t along `edge_v`, from the corner where both
/// begin.
fn fields(source: &Source) -> Option<&Raster> {
    let texels = source.texture()?.texels().filter(|texels| texels.lookup() == Lookup::Nearest)?;
    matches!(source.shape(), Shape::Rectangle(_)).then(|| texels.raster())
}

/// A mirror's outline, if it is flat.
fn flat_mirror(shape: &MirrorShape) -> Option<Shape> {
    match shape {
        MirrorShape::Rectangle(s) => Some(Shape::Rectangle(*s)),
        MirrorShape::Disk(s) => Some(Shape::Disk(*s)),
        MirrorShape::Polygon(s) => Some(Shape::Polygon(s.clone())),
        _ => None,
    }
}

/// The flat mirrors: outline and reflectance.
fn mirrors(configuration: &Configuration) -> Vec<(Shape, f64)> {
    let mirrors = configuration.mirrors().iter();
    mirrors.filter_map(|mirror| Some((flat_mirror(mirror.shape())?, mirror.reflectance()))).collect()
}

/// The receiver if it is a rectangle, else what it is.
fn receiver(configuration: &Configuration) -> Result<Rectangle, &'static str> {
    match configuration.receiver().map(|receiver| receiver.shape()) {
        Some(ReceiverShape::Rectangle(receiver)) => Ok(*receiver),
        Some(ReceiverShape::Disk(_)) => Err("a disk"),
        Some(ReceiverShape::Triangle(_)) => Err("a triangle"),
        Some(ReceiverShape::Sphere(_)) => Err("a sphere"),
        None => Err("not named (measured are points of their own)"),
    }
}

/// Half way between the receiver and what is lowest above it, metres.
fn camera_height(configuration: &Configuration, receiver: &Rectangle) -> Result<f64, Vec<Inexpressible>> {
    let mut found = Vec::new();
    let sources = configuration.sources().iter().map(|source| source.shape());
    let shapes = sources.enumerate().map(|(i, shape)| ("source", i, shape));
    let occluders = configuration.occluders().iter().enumerate().map(|(i, shape)| ("occluder", i, shape));
    let ball = beam_and_ball(configuration).map(|(_, ball, _)| Shape::Sphere(*ball));
    let ball = ball.iter().map(|shape| ("glass", 0, shape));
    let mirrors = mirrors(configuration);
    let mirrors = mirrors.iter().enumerate().map(|(i, (shape, _))| ("mirror", i, shape));
    let size = receiver.edge_u().length().max(receiver.edge_v().length());
    let mut lowest = f64::INFINITY;
    for (role, index, shape) in shapes.chain(occluders).chain(mirrors).chain(ball) {
        let Some([low, high]) = heights_above(shape, receiver) else { continue };
        if high < -CLEARANCE * size {
            continue; // Wholly behind the receiver: in nobody's way.
        }
        if low <= CLEARANCE * size {
            let how =
                if low < -CLEARANCE * size { "cuts through the receiver's plane" } else { "touches the receiver" };
            found.push(Inexpressible::NoRoom { role, index, kind: shape.kind(), how });
        }
        lowest = lowest.min(low);
    }
    match found.is_empty() {
        // With nothing above the receiver any height will do.
        true => Ok(if lowest.is_finite() { 0.5 * lowest } else { receiver.edge_u().length() }),
        false => Err(found),
    }
}

/// Nearer than this to the receiver, in units of its size, there is no room for single precision.
const CLEARANCE: f64 = 1e-4;

/// The least and the greatest height over the receiver's plane, metres, of what may lie over the receiver; `None` of what
/// lies beside it.
fn heights_above(shape: &Shape, receiver: &Rectangle) -> Option<[f64; 2]> {
    let axes = [receiver.edge_u().normalize(), receiver.edge_v().normalize(), receiver.normal()];
    let [along_u, along_v, height] = axes.map(|axis| span(shape, axis, receiver.center()));
    let beside = |[low, high]: [f64; 2], edge: DVec3| low > 0.5 * edge.length() || high < -0.5 * edge.length();
    (!beside(along_u, receiver.edge_u()) && !beside(along_v, receiver.edge_v())).then_some(height)
}

/// The shape's extent along a unit vector, from a point.
fn span(shape: &Shape, axis: DVec3, from: DVec3) -> [f64; 2] {
    let of = |points: &mut dyn Iterator<Item = DVec3>| {
        points
            .map(|p| (p - from).dot(axis))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let around = |center: DVec3, reach: f64| {
        let middle = (center - from).dot(axis);
        [middle - reach, middle + reach]
    };
    match shape {
        Shape::Disk(s) => around(s.center(), s.radius() * (1.0 - s.normal().dot(axis).powi(2)).max(0.0).sqrt()),
        Shape::Sphere(s) => around(s.center(), s.radius()),
        Shape::Rectangle(s) => of(&mut s.corners().into_iter()),
        Shape::Polygon(s) => of(&mut s.vertices().iter().copied()),
        Shape::Mesh(s) => of(&mut s.vertices().iter().copied()),
    }
}

/// As many pixels as were ordered, or 32 along the longer edge.
fn grid(configuration: &Configuration, receiver: &Rectangle, order: &Order) -> Result<PixelGrid, Vec<Inexpressible>> {
    if !(1..=MOST_SAMPLES).contains(&order.samples_per_pixel) {
        return Err(vec![Inexpressible::Samples { said: order.samples_per_pixel }]);
    }
    let (u, v) = (receiver.edge_u().length(), receiver.edge_v().length());
    let usual = [u, v].map(|edge| (32.0 * edge / u.max(v)).round().max(1.0) as usize);
    let [width, height] = order.pixels.unwrap_or(usual);
    PixelGrid::of_receiver(configuration, [width, height]).ok_or(vec![Inexpressible::Pixels { width, height }])
}

/// Where the case names no albedo, or one of zero, or one that varies.
const USUAL_RHO: f64 = 0.5;

/// Reflectance of the receiver in the scene, above zero.
fn reflectance(configuration: &Configuration) -> f64 {
    let uniform = configuration.receiver().filter(|receiver| receiver.texture().is_none());
    let albedo = uniform.and_then(|receiver| receiver.albedo()).map(|albedo| albedo.ratio());
    albedo.filter(|albedo| *albedo > 0.0).unwrap_or(USUAL_RHO)
}

/// What the images of a scene will be.
fn manifest(configuration: &Configuration, name: &str, renderer: &str, pixels: PixelGrid, order: &Order) -> Manifest {
    let exitance: Vec<f64> =
        configuration.sources().iter().map(|source| source.exitance().watts_per_square_metre()).collect();
    Manifest {
        schema_version: Manifest::SCHEMA_VERSION,
        generator: format!("etendue {}", env!("CARGO_PKG_VERSION")),
        renderer: renderer.to_owned(),
        case: name.to_owned(),
        digest: configuration.digest().to_string(),
        units: Manifest::UNITS.to_owned(),
        radiance: exitance.iter().map(|m| m / std::f64::consts::PI).collect(),
        exitance,
        rho: reflectance(configuration),
        pixels,
        depth: Manifest::depth_of(configuration),
        filter: "box".to_owned(),
        first_sample_at_centre: false,
        component_format: "float32".to_owned(),
        channels: ["R", "G", "B"].map(str::to_owned).to_vec(),
        samples_per_pixel: order.samples_per_pixel,
        seeds: SEEDS,
        formula: Manifest::FORMULA.to_owned(),
    }
}

/// A polygon as triangles, which wind as it does.
fn triangles(polygon: &Polygon) -> Vec<[usize; 3]> {
    let frame = Frame::around(polygon.normal());
    let flat = polygon.vertices().iter().map(|v| [v.dot(frame.tangent), v.dot(frame.bitangent)]);
    triangulated(&flat.collect::<Vec<_>>())
}

/// A file of plain data.
fn json(value: &impl serde::Serialize) -> Vec<u8> {
    (serde_json::to_string_pretty(value).expect("plain data has a text") + "\n").into_bytes()
}
