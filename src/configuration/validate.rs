//! Mistakes that no single shape can see.

use glam::DVec3;
use thiserror::Error;

use super::Configuration;
use crate::geometry::{Frame, Polygon, Shape};
use crate::texture::TextureError;

/// A point this near to a surface, in units of the coordinates at hand, is on it: its distance is rounding.
const ON_SURFACE: f64 = 8.0 * f64::EPSILON;

/// Why a configuration was refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ConfigurationError {
    #[error("exitance is {said} W/m²; it is a finite number, zero or greater")]
    Exitance { said: f64 },
    #[error("albedo is {said}; it lies between 0 and 1")]
    Albedo { said: f64 },
    #[error(transparent)]
    Texture(TextureError),
    #[error("a mesh cannot be a source; sources are disk, rectangle, polygon or sphere")]
    MeshSource,
    #[error("the case has no source; it needs at least one [[source.SHAPE]]")]
    NoSource,
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
        /// `source` or `occluder`.
        role: &'static str,
        index: usize,
        kind: &'static str,
    },
    #[error("the line's end `{end}` lies {distance:.3e} m off the receiver; a line runs on the receiver")]
    OffReceiver { end: &'static str, distance: f64 },
    #[error("the line's ends are opposite points of the sphere; no shorter arc joins them")]
    AmbiguousArc,
}

/// All of them.
pub(super) fn mistakes(configuration: &Configuration) -> Vec<ConfigurationError> {
    let mut found = Vec::new();
    if configuration.sources.is_empty() {
        found.push(ConfigurationError::NoSource);
    }
    if configuration.points.is_empty() {
        found.push(ConfigurationError::NothingToMeasure);
    }
    let sources = configuration.sources.iter().map(super::Source::shape).enumerate().map(|(i, s)| ("source", i, s));
    let occluders = configuration.occluders.iter().enumerate().map(|(i, s)| ("occluder", i, s));
    for (role, index, shape) in sources.chain(occluders) {
        let probe = SurfaceProbe::new(shape);
        let points = configuration.points.iter().enumerate();
        let mut touching = points.filter(|(_, at)| probe.touches(at.position())).map(|(point, _)| point);
        if let Some(point) = touching.next() {
            let others = touching.count();
            found.push(ConfigurationError::PointOnSurface { point, others, role, index, kind: shape.kind() });
        }
    }
    found
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
    use crate::configuration::{Arrangement, MeasurementPoint, Source};
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
