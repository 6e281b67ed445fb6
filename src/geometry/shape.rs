//! The shapes a case may contain, valid by construction.
//!
//! A shape's lit side is the side its unit normal points to. Constructors refuse what has no area, no direction or
//! no meaning, so that nothing below has to ask again.

use glam::DVec3;

use super::{Frame, Mesh, Polygon};
use crate::errors::errors;

/// Relative tolerance for "perpendicular" edges of a rectangle: case files are written in decimals.
const PERPENDICULAR_TOLERANCE: f64 = 1e-9;

errors! {
    /// Why a shape was refused. Each variant names the case-file key at fault.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum ShapeError {
        #[error("{field} holds {said}; every coordinate is a finite number")]
        NotFinite { field: &'static str, said: f64 },
        #[error("{field} is {said}; it is greater than zero (metres)")]
        NotPositive { field: &'static str, said: f64 },
        #[error("{field} is the zero vector; it needs a direction")]
        NoDirection { field: &'static str },
        #[error(
            "the edges are not perpendicular: the cosine of their angle is {cosine:.3e}; at most {PERPENDICULAR_TOLERANCE:e} is accepted (use a polygon for a parallelogram)"
        )]
        NotPerpendicular { cosine: f64 },
        #[error("{said} vertices; a polygon has at least 3")]
        TooFewVertices { said: usize },
        #[error("vertices {first} and {second} (counted from 0) are the same point; each vertex is listed once")]
        RepeatedVertex { first: usize, second: usize },
        #[error(
            "vertex {vertex} (counted from 0) lies {distance:.3e} m off the plane of the others; at most {allowed:.1e} m (1e-12 of the size) is accepted"
        )]
        NotPlanar { vertex: usize, distance: f64, allowed: f64 },
        #[error(
            "the edge from vertex {first} and the edge from vertex {second} (counted from 0) meet; the outline may not cross or touch itself"
        )]
        SelfCrossing { first: usize, second: usize },
        #[error("the vertices enclose no area")]
        NoArea,
        #[error("triangle {triangle} (counted from 0) names vertex {said}, but there are {vertices} vertices")]
        NoSuchVertex { triangle: usize, said: usize, vertices: usize },
        #[error("the mesh has no triangle with an area")]
        NoTriangles,
        #[error("{field} is {said}; at most {most} (metres) is accepted, where the sphere is widest")]
        TooWide { field: &'static str, said: f64, most: f64 },
        #[error("{field} points along the axis; it needs a part across it")]
        AlongAxis { field: &'static str },
        #[error("{field} is {said}; it is a share, greater than 0 and at most 1")]
        NotAShare { field: &'static str, said: f64 },
    }
}

impl ShapeError {
    /// The case-file key that the error is about, when it is about a single one.
    pub fn field(&self) -> Option<&'static str> {
        match self {
            Self::NotFinite { field, .. }
            | Self::NotPositive { field, .. }
            | Self::NoDirection { field }
            | Self::TooWide { field, .. }
            | Self::AlongAxis { field }
            | Self::NotAShare { field, .. } => Some(field),
            Self::NotPerpendicular { .. } => Some("edge_v"),
            Self::TooFewVertices { .. }
            | Self::RepeatedVertex { .. }
            | Self::NotPlanar { .. }
            | Self::SelfCrossing { .. }
            | Self::NoArea => Some("vertices"),
            Self::NoSuchVertex { .. } | Self::NoTriangles => Some("file"),
        }
    }
}

/// A finite point or vector, or the error that names its field.
pub(crate) fn finite(field: &'static str, v: DVec3) -> Result<DVec3, ShapeError> {
    match v.to_array().into_iter().find(|c| !c.is_finite()) {
        Some(said) => Err(ShapeError::NotFinite { field, said }),
        None => Ok(v),
    }
}

/// A finite length greater than zero, or the error that names its field.
pub(crate) fn positive(field: &'static str, length: f64) -> Result<f64, ShapeError> {
    if !length.is_finite() {
        Err(ShapeError::NotFinite { field, said: length })
    } else if length <= 0.0 {
        Err(ShapeError::NotPositive { field, said: length })
    } else {
        Ok(length)
    }
}

/// The unit vector along `v`. Scaled before it is squared, so that no finite length overflows or underflows.
pub(crate) fn unit(field: &'static str, v: DVec3) -> Result<DVec3, ShapeError> {
    let v = finite(field, v)?;
    let largest = v.abs().max_element();
    if largest == 0.0 {
        return Err(ShapeError::NoDirection { field });
    }
    Ok((v / largest).normalize())
}

/// A flat disk, lit on the side of its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    center: DVec3,
    normal: DVec3,
    as_given: DVec3,
    radius: f64,
}

impl Disk {
    /// - `center`: metres; `normal`: any length but zero; `radius`: metres, > 0
    pub fn new(center: DVec3, normal: DVec3, radius: f64) -> Result<Disk, ShapeError> {
        Ok(Disk {
            center: finite("center", center)?,
            normal: unit("normal", normal)?,
            as_given: normal,
            radius: positive("radius", radius)?,
        })
    }
    /// Metres.
    pub fn center(&self) -> DVec3 {
        self.center
    }
    /// Unit vector towards the lit side.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }
    /// The normal to the digits it was given with, of any length: [`Disk::normal`] is rounded.
    pub fn normal_as_given(&self) -> DVec3 {
        self.as_given
    }
    /// Metres.
    pub fn radius(&self) -> f64 {
        self.radius
    }
    /// π R², square metres.
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.radius * self.radius
    }
}

/// A flat rectangle spanned by two full edges around its centre; lit side `edge_u × edge_v`.
///
/// Edges may be off the right angle by rounding (1e-9): everything here and below treats the shape as the
/// parallelogram that the two edges span, so that the same figure is meant everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    center: DVec3,
    edge_u: DVec3,
    edge_v: DVec3,
    normal: DVec3,
}

impl Rectangle {
    /// - `center`: metres; `edge_u`, `edge_v`: full edges in metres, perpendicular
    pub fn new(center: DVec3, edge_u: DVec3, edge_v: DVec3) -> Result<Rectangle, ShapeError> {
        let center = finite("center", center)?;
        let (u, v) = (unit("edge_u", edge_u)?, unit("edge_v", edge_v)?);
        let cosine = u.dot(v);
        if cosine.abs() > PERPENDICULAR_TOLERANCE {
            return Err(ShapeError::NotPerpendicular { cosine });
        }
        Ok(Rectangle { center, edge_u, edge_v, normal: u.cross(v).normalize() })
    }
    /// Metres.
    pub fn center(&self) -> DVec3 {
        self.center
    }
    /// Full edge, metres.
    pub fn edge_u(&self) -> DVec3 {
        self.edge_u
    }
    /// Full edge, metres.
    pub fn edge_v(&self) -> DVec3 {
        self.edge_v
    }
    /// Unit vector towards the lit side, along `edge_u × edge_v`.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }
    /// Square metres.
    pub fn area(&self) -> f64 {
        self.edge_u.cross(self.edge_v).length()
    }
    /// The corners, counter-clockwise seen from the lit side.
    pub fn corners(&self) -> [DVec3; 4] {
        let (u, v) = (self.edge_u * 0.5, self.edge_v * 0.5);
        [self.center - u - v, self.center + u - v, self.center + u + v, self.center - u + v]
    }
}

/// A sphere: as a source it emits from its whole surface, as an occluder it is a solid ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    center: DVec3,
    radius: f64,
}

impl Sphere {
    /// - `center`: metres; `radius`: metres, > 0
    pub fn new(center: DVec3, radius: f64) -> Result<Sphere, ShapeError> {
        Ok(Sphere { center: finite("center", center)?, radius: positive("radius", radius)? })
    }
    /// Metres.
    pub fn center(&self) -> DVec3 {
        self.center
    }
    /// Metres.
    pub fn radius(&self) -> f64 {
        self.radius
    }
    /// 4 π R², square metres.
    pub fn area(&self) -> f64 {
        4.0 * std::f64::consts::PI * self.radius * self.radius
    }
}

/// A flat triangle (a receiver shape); receiving side counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    vertices: [DVec3; 3],
    normal: DVec3,
}

impl Triangle {
    /// - `vertices`: metres, not on one line
    pub fn new(vertices: [DVec3; 3]) -> Result<Triangle, ShapeError> {
        let polygon = Polygon::new(vertices.to_vec())?;
        Ok(Triangle { vertices, normal: polygon.normal() })
    }
    /// Metres.
    pub fn vertices(&self) -> [DVec3; 3] {
        self.vertices
    }
    /// Unit vector towards the receiving side.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }
}

/// Any surface that can emit or block light.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    Disk(Disk),
    Rectangle(Rectangle),
    Polygon(Polygon),
    Sphere(Sphere),
    Mesh(Mesh),
}

impl Shape {
    /// The name a case file uses.
    pub fn kind(&self) -> &'static str {
        match self {
            Shape::Disk(_) => "disk",
            Shape::Rectangle(_) => "rectangle",
            Shape::Polygon(_) => "polygon",
            Shape::Sphere(_) => "sphere",
            Shape::Mesh(_) => "mesh",
        }
    }

    /// Square metres.
    pub fn area(&self) -> f64 {
        match self {
            Shape::Disk(s) => s.area(),
            Shape::Rectangle(s) => s.area(),
            Shape::Polygon(s) => s.area(),
            Shape::Sphere(s) => s.area(),
            Shape::Mesh(s) => s.area(),
        }
    }

    /// A few points whose convex hull holds the shape, metres; of a flat shape, in its plane.
    pub fn hull(&self) -> Vec<DVec3> {
        match self {
            Shape::Disk(s) => {
                let frame = Frame::around(s.normal());
                let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
                corners.map(|(x, y)| s.center() + (frame.tangent * x + frame.bitangent * y) * s.radius()).to_vec()
            }
            Shape::Rectangle(s) => s.corners().to_vec(),
            Shape::Polygon(s) => s.vertices().to_vec(),
            Shape::Sphere(_) => box_corners(self.bounds()).to_vec(),
            Shape::Mesh(s) => s.vertices().to_vec(),
        }
    }

    /// Corners of an axis-aligned box that holds the shape, metres.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        fn of_points<'a>(points: impl IntoIterator<Item = &'a DVec3>) -> (DVec3, DVec3) {
            points
                .into_iter()
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
        }
        match self {
            Shape::Disk(s) => {
                let reach = (DVec3::ONE - s.normal() * s.normal()).max(DVec3::ZERO).map(f64::sqrt) * s.radius();
                (s.center() - reach, s.center() + reach)
            }
            Shape::Rectangle(s) => of_points(&s.corners()),
            Shape::Polygon(s) => of_points(s.vertices()),
            Shape::Sphere(s) => (s.center() - s.radius(), s.center() + s.radius()),
            Shape::Mesh(s) => of_points(s.vertices()),
        }
    }
}

/// The eight corners of an axis-aligned box, given two opposite ones.
pub fn box_corners((low, high): (DVec3, DVec3)) -> [DVec3; 8] {
    std::array::from_fn(|k| {
        DVec3::new([low.x, high.x][k & 1], [low.y, high.y][k >> 1 & 1], [low.z, high.z][k >> 2 & 1])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_shapes_are_refused_by_the_name_of_their_field() {
        let o = DVec3::ZERO;
        assert_eq!(Disk::new(o, DVec3::Z, -0.3), Err(ShapeError::NotPositive { field: "radius", said: -0.3 }));
        assert_eq!(Disk::new(o, o, 1.0), Err(ShapeError::NoDirection { field: "normal" }));
        assert!(matches!(
            Sphere::new(DVec3::new(f64::NAN, 0.0, 0.0), 1.0),
            Err(ShapeError::NotFinite { field: "center", .. })
        ));
        assert!(matches!(
            Rectangle::new(o, DVec3::X, DVec3::new(0.1, 1.0, 0.0)),
            Err(ShapeError::NotPerpendicular { .. })
        ));
        assert!(matches!(Rectangle::new(o, o, DVec3::Y), Err(ShapeError::NoDirection { field: "edge_u" })));
    }

    #[test]
    fn a_normal_of_any_finite_length_is_normalised() {
        for scale in [1e-300, 1.0, 1e300] {
            let disk = Disk::new(DVec3::ZERO, DVec3::new(0.0, 3.0, 4.0) * scale, 1.0).unwrap();
            approx::assert_abs_diff_eq!(disk.normal().y, 0.6, epsilon = 1e-15);
        }
    }

    #[test]
    fn a_disk_bound_touches_its_rim() {
        let tilted = Disk::new(DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0), 2.0).unwrap();
        let (low, high) = Shape::Disk(tilted).bounds();
        approx::assert_abs_diff_eq!(high.y, 2.0, epsilon = 1e-14);
        approx::assert_abs_diff_eq!(low.x, -2.0_f64.sqrt(), epsilon = 1e-14);
    }
}
