//! Mistakes that no single shape can see.

use glam::DVec3;

use super::Contents;
use crate::errors::errors;
use crate::geometry::{Frame, Polygon, Shape};
use crate::radiometry::{BRIGHTEST, FAINTEST};
use crate::texture::TextureError;

/// A point this near to a surface, in units of the coordinates at hand, is on it: its distance is rounding.
const ON_SURFACE: f64 = 8.0 * f64::EPSILON;
/// What the brightest source must be able to bring, W/m²: the fourth power of a thousandth of it, over many samples, is
/// still a number.
const FAINTEST_ARRIVING: f64 = 1e-60;

errors! {
    /// Why a configuration was refused.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum ConfigurationError {
        #[error("exitance is {said} W/m²; it is a finite number, zero or greater")]
        Exitance { said: f64 },
        #[error("exitance is {said:e} W/m²; where it is not zero it lies from {:e} to {:e}, or squares of variances are no numbers", FAINTEST, BRIGHTEST)]
        ExitanceOutOfRange { said: f64 },
        #[error("albedo is {said}; it lies between 0 and 1")]
        Albedo { said: f64 },
        #[error(transparent)]
        Texture(TextureError),
        #[error("a mesh cannot be a source; sources are disk, rectangle, polygon or sphere")]
        MeshSource,
        #[error("the case has no source; it needs at least one [[source.SHAPE]]")]
        NoSource,
        #[error("reflectance is {said}; it lies between 0 and 1")]
        Reflectance { said: f64 },
        #[error("ior is {said}; an index of refraction is finite, 1 or greater")]
        Ior { said: f64 },
        #[error("inward is true of a flat shape; only a sphere can be an enclosure")]
        InwardFlat,
        #[error(
            "transmittance is {said} beside an albedo of {albedo}; shares are zero or greater, both together at most 1, and the albedo of a shade is below 1"
        )]
        Transmittance { said: f64, albedo: f64 },
        #[error("only a sphere with inward = true that emits nothing lets light through")]
        NoShade,
        #[error(
            "glass {first} and glass {second} (counted from 0, in the order of the file) cut into each other; pieces of glass stand apart"
        )]
        GlassOverlap { first: usize, second: usize },
        #[error("{role} {index} (counted from 0) reaches out of the enclosure; whatever there is lies inside of it")]
        OutsideEnclosure {
            /// `source`, `occluder`, `mirror`, `glass`, `diffuse`, `receiver` or `measurement point`.
            role: &'static str,
            index: usize,
        },
        #[error(
            "{role} {index} (a {kind}, counted from 0) may stand between measurement point {point}{others} and source {source_index}: what a {kind} leaves visible of a source has no closed form; measure elsewhere, or light it by a lamp (source.point, source.beam)",
            others = if *others > 0 { format!(" (and {others} more)") } else { String::new() }
        )]
        CurvedBefore {
            /// The first such point.
            point: usize,
            /// Further points behind the same optic.
            others: usize,
            /// `mirror` or `glass`.
            role: &'static str,
            index: usize,
            kind: &'static str,
            source_index: usize,
        },
        #[error("there is nothing to measure; [measure] needs a line, a grid or at least one [[measure.point]]")]
        NothingToMeasure,
        #[error(
            "measurement point {point}{others} lies exactly on {role} {index} (a {kind}); all counted from 0: the irradiance there is undefined",
            others = if *others > 0 { format!(" (and {others} more)") } else { String::new() }
        )]
        PointOnSurface {
            /// The first such point.
            point: usize,
            /// Further points on the same surface.
            others: usize,
            /// `source`, `occluder`, `mirror`, `glass` or `diffuse`.
            role: &'static str,
            index: usize,
            kind: &'static str,
        },
        #[error(
            "at measurement point {point}{others} (counted from 0) no source brings more than {said:e} W/m², were nothing in the way; above zero it is {FAINTEST_ARRIVING:e} or more, or squares of variances are no numbers",
            others = if *others > 0 { format!(" (and {others} more)") } else { String::new() }
        )]
        TooFaint {
            /// The first such point.
            point: usize,
            /// Further such points.
            others: usize,
            /// W/m².
            said: f64,
        },
        #[error("the line's end `{end}` lies {distance:.3e} m off the receiver; a line runs on the receiver")]
        OffReceiver { end: &'static str, distance: f64 },
        #[error("the line's ends are opposite points of the sphere; no shorter arc joins them")]
        AmbiguousArc,
    }
}

/// All of them.
pub(super) fn mistakes(room: &Contents) -> Vec<ConfigurationError> {
    let mut found = Vec::new();
    let emits = room.diffuse.iter().any(|surface| surface.exitance().watts_per_square_metre() > 0.0);
    if room.sources.is_empty() && room.lamps.is_empty() && !emits {
        found.push(ConfigurationError::NoSource);
    }
    let is_traced =
        !(room.lamps.is_empty() && room.mirrors.is_empty() && room.glass.is_empty() && room.diffuse.is_empty());
    let lands = room.receiver.is_some() || !room.diffuse.is_empty();
    if room.points.is_empty() && !(is_traced && lands) {
        found.push(ConfigurationError::NothingToMeasure);
    }
    let sources = room.sources.iter().map(super::Source::shape).enumerate().map(|(i, s)| ("source", i, s.clone()));
    let occluders = room.occluders.iter().enumerate().map(|(i, s)| ("occluder", i, s.clone()));
    for (role, index, shape) in sources.chain(occluders).chain(surfaces_of_optics(room)) {
        let probe = SurfaceProbe::new(&shape);
        let points = room.points.iter().enumerate();
        let mut touching = points.filter(|(_, at)| probe.touches(at.position())).map(|(point, _)| point);
        if let Some(point) = touching.next() {
            let others = touching.count();
            found.push(ConfigurationError::PointOnSurface { point, others, role, index, kind: shape.kind() });
        }
    }
    found.extend(too_faint(room));
    for second in 1..room.glass.len() {
        let overlap = (0..second).find(|first| room.glass[*first].shape().overlaps(room.glass[second].shape()));
        found.extend(overlap.map(|first| ConfigurationError::GlassOverlap { first, second }));
    }
    outside_enclosures(room, &mut found);
    curved_before_sources(room, &mut found);
    found
}

/// Points so far from all sources, for their size, that no spread of estimates there could be told.
fn too_faint(room: &Contents) -> Option<ConfigurationError> {
    let sources = room.sources.iter().map(|source| (source.largest_exitance(), source.shape().clone()));
    let diffuse = room.diffuse.iter().map(|surface| (surface.exitance(), surface.as_shape()));
    let emitters = sources
        .chain(diffuse)
        .map(|(exitance, shape)| (exitance.watts_per_square_metre() * shape.area(), ball_around(&shape)));
    let emitters: Vec<(f64, (DVec3, f64))> = emitters.filter(|(power, _)| *power > 0.0).collect();
    let most = |at: DVec3| {
        let of = |(power, (center, radius)): &(f64, (DVec3, f64))| {
            let distance = (*center - at).length().max(*radius);
            power / std::f64::consts::PI / distance / distance
        };
        emitters.iter().map(of).fold(0.0, f64::max)
    };
    let faint = |(point, at): (usize, &super::MeasurementPoint)| {
        let said = most(at.position());
        (!emitters.is_empty() && said < FAINTEST_ARRIVING).then_some((point, said))
    };
    let mut faint = room.points.iter().enumerate().filter_map(faint);
    let (point, said) = faint.next()?;
    Some(ConfigurationError::TooFaint { point, others: faint.count(), said })
}

/// The surfaces that points must not lie on, of optics and diffuse surfaces, as far as they are shapes that block.
fn surfaces_of_optics(room: &Contents) -> impl Iterator<Item = (&'static str, usize, Shape)> {
    let flat = |role: &'static str, index: usize, outline: Option<Vec<Shape>>| {
        outline.into_iter().flatten().map(move |shape| (role, index, shape))
    };
    let mirrors = room.mirrors.iter().enumerate().flat_map(move |(i, m)| flat("mirror", i, m.shape().outline()));
    let glass = room.glass.iter().enumerate().flat_map(move |(i, g)| flat("glass", i, g.shape().outline()));
    // Points on the inside of an enclosure are what enclosures are for.
    let diffuse = room.diffuse.iter().enumerate().filter(|(_, surface)| !surface.is_enclosure());
    mirrors.chain(glass).chain(diffuse.map(|(i, surface)| ("diffuse", i, surface.as_shape())))
}

/// A sphere that holds a shape: about the middle of its box.
fn ball_around(shape: &Shape) -> (DVec3, f64) {
    let (low, high) = shape.bounds();
    match shape {
        Shape::Sphere(s) => (s.center(), s.radius()),
        Shape::Disk(s) => (s.center(), s.radius()),
        _ => (low * 0.5 + high * 0.5, (high - low).length() * 0.5),
    }
}

/// Centres and radii, metres.
type Balls = Vec<(DVec3, f64)>;

/// Whatever reaches out of an enclosure.
fn outside_enclosures(room: &Contents, found: &mut Vec<ConfigurationError>) {
    for enclosure in room.diffuse.iter().filter(|surface| surface.is_enclosure()) {
        // A flat receiver's or a mesh's bounding sphere may be larger than the enclosure: then its corners decide.
        let mut balls: Vec<(&'static str, usize, Balls)> = Vec::new();
        let shapes = room.sources.iter().map(|source| source.shape()).enumerate().map(|(i, s)| ("source", i, s));
        let shapes = shapes.chain(room.occluders.iter().enumerate().map(|(i, s)| ("occluder", i, s)));
        balls.extend(shapes.map(|(role, i, shape)| (role, i, extremes(shape))));
        let others = room.diffuse.iter().enumerate().filter(|(_, other)| *other != enclosure);
        balls.extend(others.map(|(i, surface)| ("diffuse", i, extremes(&surface.as_shape()))));
        balls.extend(room.mirrors.iter().enumerate().map(|(i, m)| match m.shape().outline().as_deref() {
            Some([shape]) => ("mirror", i, extremes(shape)),
            _ => ("mirror", i, vec![m.shape().bounding_sphere()]),
        }));
        balls.extend(room.glass.iter().enumerate().map(|(i, g)| match g.shape().outline() {
            Some(shapes) => ("glass", i, shapes.iter().flat_map(extremes).collect()),
            None => ("glass", i, vec![g.shape().bounding_sphere()]),
        }));
        balls.extend(room.lamps.iter().enumerate().map(|(i, lamp)| match lamp {
            super::Lamp::Point(lamp) => ("lamp", i, vec![(lamp.position(), 0.0)]),
            super::Lamp::Beam(lamp) => ("lamp", i, vec![(lamp.center(), lamp.radius())]),
        }));
        balls
            .extend(room.points.iter().enumerate().map(|(i, p)| ("measurement point", i, vec![(p.position(), 0.0)])));
        let outside = balls.iter().filter(|(_, _, balls)| !balls.iter().all(|(c, r)| enclosure.encloses(*c, *r)));
        found.extend(outside.map(|(role, index, _)| ConfigurationError::OutsideEnclosure { role, index: *index }));
    }
}

/// Small spheres whose hull holds a shape: its corners, or one about it.
fn extremes(shape: &Shape) -> Balls {
    match shape {
        Shape::Rectangle(s) => s.corners().map(|corner| (corner, 0.0)).to_vec(),
        Shape::Polygon(s) => s.vertices().iter().map(|corner| (*corner, 0.0)).collect(),
        Shape::Mesh(s) => s.vertices().iter().map(|corner| (*corner, 0.0)).collect(),
        _ => vec![ball_around(shape)],
    }
}

/// Optics without an outline in closed form that may stand between a point and a source with area.
///
/// Decided by bounding spheres: too often rather than too seldom.
fn curved_before_sources(room: &Contents, found: &mut Vec<ConfigurationError>) {
    let mirrors = room.mirrors.iter().enumerate().filter(|(_, m)| m.shape().outline().is_none());
    let mirrors = mirrors.map(|(i, m)| ("mirror", i, m.shape().kind(), m.shape().bounding_sphere()));
    let glass = room.glass.iter().enumerate().filter(|(_, g)| g.shape().outline().is_none());
    let glass = glass.map(|(i, g)| ("glass", i, g.shape().kind(), g.shape().bounding_sphere()));
    let emitters: Vec<(DVec3, f64)> = room.sources.iter().map(|source| ball_around(source.shape())).collect();
    for (role, index, kind, ball) in mirrors.chain(glass) {
        for (source_index, emitter) in emitters.iter().enumerate() {
            let points = room.points.iter().enumerate();
            let mut behind =
                points.filter(|(_, at)| may_stand_between(at.position(), *emitter, ball)).map(|(point, _)| point);
            if let Some(point) = behind.next() {
                let others = behind.count();
                let error = ConfigurationError::CurvedBefore { point, others, role, index, kind, source_index };
                found.push(error);
                break;
            }
        }
    }
}

/// Whether a ball meets the hull of a point and another ball.
fn may_stand_between(point: DVec3, emitter: (DVec3, f64), ball: (DVec3, f64)) -> bool {
    // The hull is covered by spheres about the points of the axis whose radius grows from 0 to the emitter's.
    let axis = emitter.0 - point;
    let offset = ball.0 - point;
    let reach = |share: f64| (offset - axis * share).length() - emitter.1 * share - ball.1;
    // A convex function of the share: its least value by golden section, then a margin for what is left.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let (a, b) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
        if reach(a) < reach(b) { high = b } else { low = a }
    }
    let least = reach(0.5 * (low + high)).min(reach(0.0)).min(reach(1.0));
    least <= 1e-9 * (axis.length() + ball.1)
}

/// Tells whether a point lies on a shape's surface, to rounding.
struct SurfaceProbe<'a> {
    shape: &'a Shape,
    bounds: (DVec3, DVec3),
}

impl SurfaceProbe<'_> {
    fn new(shape: &Shape) -> SurfaceProbe<'_> {
        SurfaceProbe { shape, bounds: shape.bounds() }
    }

    fn touches(&self, point: DVec3) -> bool {
        let (low, high) = self.bounds;
        let reach = ON_SURFACE * point.abs().max(low.abs()).max(high.abs()).max_element();
        if point.cmplt(low - reach).any() || point.cmpgt(high + reach).any() {
            return false;
        }
        match self.shape {
            Shape::Disk(s) => {
                let offset = point - s.center();
                let height = offset.dot(s.normal());
                height.abs() <= reach && (offset - s.normal() * height).length() <= s.radius() + reach
            }
            Shape::Rectangle(s) => in_convex_outline(point, &s.corners(), s.normal(), reach),
            Shape::Polygon(s) => on_polygon(point, s, reach),
            Shape::Sphere(s) => ((point - s.center()).length() - s.radius()).abs() <= reach,
            Shape::Mesh(s) => (0..s.triangles().len()).any(|t| {
                let corners = s.corners(t);
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
                in_convex_outline(point, &corners, normal, reach)
            }),
        }
    }
}

fn in_convex_outline(point: DVec3, outline: &[DVec3], normal: DVec3, reach: f64) -> bool {
    (point - outline[0]).dot(normal).abs() <= reach
        && (0..outline.len()).all(|i| {
            let (from, to) = (outline[i], outline[(i + 1) % outline.len()]);
            normal.cross(to - from).normalize_or_zero().dot(point - from) >= -reach
        })
}

fn on_polygon(point: DVec3, polygon: &Polygon, reach: f64) -> bool {
    let vertices = polygon.vertices();
    if (point - vertices[0]).dot(polygon.normal()).abs() > reach {
        return false;
    }
    let frame = Frame::around(polygon.normal());
    let flat: Vec<[f64; 2]> =
        vertices.iter().map(|v| [(*v - point).dot(frame.tangent), (*v - point).dot(frame.bitangent)]).collect();
    let mut inside = false;
    for i in 0..flat.len() {
        let (a, b) = (flat[i], flat[(i + 1) % flat.len()]);
        let edge = [b[0] - a[0], b[1] - a[1]];
        let along = -(a[0] * edge[0] + a[1] * edge[1]) / (edge[0] * edge[0] + edge[1] * edge[1]);
        let nearest = [a[0] + edge[0] * along.clamp(0.0, 1.0), a[1] + edge[1] * along.clamp(0.0, 1.0)];
        if nearest[0].hypot(nearest[1]) <= reach {
            return true;
        }
        if (a[1] > 0.0) != (b[1] > 0.0) && a[0] - a[1] * edge[0] / edge[1] > 0.0 {
            inside = !inside;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
    use crate::geometry::{Disk, Mesh, Rectangle, Sphere};
    use crate::radiometry::Exitance;

    fn touches(shape: Shape, point: [f64; 3]) -> bool {
        SurfaceProbe::new(&shape).touches(DVec3::from(point))
    }

    #[test]
    fn on_a_surface_is_told_from_beside_it() {
        let disk = || Shape::Disk(Disk::new(DVec3::Z, DVec3::Z, 1.0).unwrap());
        assert!(touches(disk(), [0.5, 0.5, 1.0]) && touches(disk(), [1.0, 0.0, 1.0]));
        assert!(!touches(disk(), [1.0 + 1e-12, 0.0, 1.0]) && !touches(disk(), [0.0, 0.0, 1.0 + 1e-12]));
        let ball = || Shape::Sphere(Sphere::new(DVec3::Z, 1.0).unwrap());
        assert!(touches(ball(), [0.0, 0.0, 0.0]) && !touches(ball(), [0.0, 0.0, 1.0]));
        let square = || Shape::Rectangle(Rectangle::new(DVec3::ZERO, DVec3::X, DVec3::Y).unwrap());
        assert!(touches(square(), [0.5, 0.1, 0.0]) && !touches(square(), [0.6, 0.1, 0.0]));
        let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let l = || Shape::Polygon(Polygon::new(l.iter().map(|p| DVec3::new(p[0], p[1], 0.0)).collect()).unwrap());
        assert!(touches(l(), [0.5, 1.5, 0.0]) && touches(l(), [1.0, 1.5, 0.0]) && !touches(l(), [1.5, 1.5, 0.0]));
        let mesh = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]).unwrap();
        assert!(touches(Shape::Mesh(mesh), [0.25, 0.25, 0.0]));
    }

    #[test]
    fn all_mistakes_are_reported_together() {
        let disk = Disk::new(DVec3::Z, -DVec3::Z, 1.0).unwrap();
        let source = Source::new(Shape::Disk(disk), Exitance::new(1.0)).unwrap();
        let on_it = MeasurementPoint::new(DVec3::Z, DVec3::Z).unwrap();
        let found =
            Configuration::new(vec![source], vec![Shape::Disk(disk)], None, vec![on_it], Arrangement::Scattered);
        assert_eq!(found.unwrap_err().len(), 2, "on the source and on the occluder");
        let found = Configuration::new(vec![], vec![], None, vec![], Arrangement::Scattered);
        assert_eq!(found.unwrap_err(), vec![ConfigurationError::NoSource, ConfigurationError::NothingToMeasure]);
    }
}
