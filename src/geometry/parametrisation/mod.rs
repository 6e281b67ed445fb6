//! Surfaces laid out on a map: from a point to (s, t) in the unit square and back, with the area of every texel.
//!
//! | surface | s | t | texels |
//! |---|---|---|---|
//! | rectangle | along `edge_u` | along `edge_v` | of equal area |
//! | triangle | affine: the vertices lie at the corners of a [`MapTriangle`] | | cut by its sides |
//! | disk | azimuth / 2π; wraps | (distance from the centre / radius)² | of equal area |
//! | sphere | longitude / 2π from a point of the equator, eastwards; wraps | angle from the south pole / π | smaller towards the poles |
//!
//! The sphere's is the map of the atlas (Glassner, *An Introduction to Ray Tracing*, 1989, §2.3): by angles, so that areas
//! are distorted by sin πt, which [`Parametrisation::density`] and [`Parametrisation::texel_area`] account for. A triangle
//! on half the square is sheared; on a map triangle [similar to it](MapTriangle::similar_to) nothing is distorted.
//!
//! Sines and arcs are those of the `libm` crate: an estimate that reads a map is the same on every platform.

mod finder;
mod grid;
mod isoline;
mod map_triangle;

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::shape::unit;
use super::{Disk, Frame, Rectangle, ShapeError, Sphere};

use crate::errors::errors;
pub use finder::TexelFinder;
pub use grid::{Texel, TexelGrid};
pub use isoline::Isoline;
pub use map_triangle::{MapTriangle, clipped};

/// A triangle whose height is below this share of its longest side has no map: its linear system has no digits left.
const FLAT: f64 = 1e-12;
/// The sine of the least angle between a sphere's north and its point of the equator.
const ALIGNED: f64 = 1e-9;

errors! {
    /// Why a surface cannot be laid out on a map.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum ParametrisationError {
        #[error(transparent)]
        Direction(#[from] ShapeError),
        #[error("{field} points along {axis}; it needs a part across it")]
        Aligned { field: &'static str, axis: &'static str },
        #[error("the triangle is degenerate: it is {height:.3e} m high over a longest side of {longest:.3e} m")]
        DegenerateTriangle { height: f64, longest: f64 },
        #[error("the map's triangle is degenerate: it covers {area:.3e} of the unit square")]
        DegenerateMap { area: f64 },
        #[error("corner {corner} of the map's triangle (counted from 0) is ({s}, {t}); it lies in the unit square")]
        OutsideMap { corner: usize, s: f64, t: f64 },
        #[error("a grid of {ns} × {nt} texels has none; both counts are from 1 to {max}", max = TexelGrid::MAX_SIDE)]
        NoTexels { ns: usize, nt: usize },
    }
}

/// A surface with a map.
///
/// ```
/// use etendue::geometry::{DVec3, Parametrisation, Sphere, TexelGrid};
///
/// let globe = Sphere::new(DVec3::ZERO, 2.0)?;
/// let map = Parametrisation::sphere(&globe, DVec3::Z, DVec3::X)?;
/// // A quarter of the way around from the point of the equator, half of the way up from the south pole.
/// let [s, t] = map.to_map(DVec3::new(0.0, 2.0, 0.0));
/// assert_eq!([s, t], [0.25, 0.5]);
/// // A texel at the equator is larger than one at a pole.
/// let grid = TexelGrid::new(8, 4)?;
/// let areas: Vec<f64> = grid.texels().map(|texel| map.texel_area(grid, texel)).collect();
/// assert!(areas[8] > 2.0 * areas[0]);
/// assert!((areas.iter().sum::<f64>() / globe.area() - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parametrisation {
    chart: Chart,
    area: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Chart {
    Rectangle(Affine),
    Triangle { plane: Affine, map: MapTriangle },
    Disk { center: DVec3, zero: DVec3, quarter: DVec3, radius: f64 },
    Sphere { center: DVec3, equator: DVec3, east: DVec3, north: DVec3, radius: f64 },
}

/// anchor + origin + a first + b second.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Affine {
    anchor: DVec3,
    origin: DVec3,
    first: DVec3,
    second: DVec3,
    /// first × second, and the square of its length.
    normal: DVec3,
    square: f64,
}

impl Affine {
    fn new(anchor: DVec3, origin: DVec3, first: DVec3, second: DVec3) -> Affine {
        let normal = first.cross(second);
        Affine { anchor, origin, first, second, normal, square: normal.length_squared() }
    }

    /// From the anchor.
    fn offset(&self, a: f64, b: f64) -> DVec3 {
        self.origin + self.first * a + self.second * b
    }

    /// a and b by Cramer's rule, of the nearest point in the plane: with n = first × second and d the offset from the origin,
    /// a = (d × second)·n / n·n, b = (first × d)·n / n·n.
    #[inline]
    fn solve(&self, offset: DVec3) -> [f64; 2] {
        let offset = offset - self.origin;
        let (a, b) = (offset.cross(self.second).dot(self.normal), self.first.cross(offset).dot(self.normal));
        [a / self.square, b / self.square]
    }
}

impl Parametrisation {
    /// s runs along `edge_u`, t along `edge_v`, from the corner where both are least.
    pub fn rectangle(rectangle: &Rectangle) -> Parametrisation {
        let (first, second) = (rectangle.edge_u(), rectangle.edge_v());
        let origin = -first * 0.5 - second * 0.5;
        Parametrisation {
            chart: Chart::Rectangle(Affine::new(rectangle.center(), origin, first, second)),
            area: rectangle.area(),
        }
    }

    /// The vertices lie at the corners of `map`, and what is between them is laid out affinely.
    ///
    /// With p = p₀ + a (p₁ − p₀) + b (p₂ − p₀): (s, t) = q₀ + a (q₁ − q₀) + b (q₂ − q₀).
    ///
    /// - `vertices`: metres; an error where they lie on a line, to 1e-12 of the longest side
    pub fn triangle(vertices: [DVec3; 3], map: MapTriangle) -> Result<Parametrisation, ParametrisationError> {
        let area = triangle_area(vertices)?;
        let [p0, p1, p2] = vertices;
        let plane = Affine::new(p0, DVec3::ZERO, p1 - p0, p2 - p0);
        Ok(Parametrisation { chart: Chart::Triangle { plane, map }, area })
    }

    /// s is the azimuth over 2π, counter-clockwise seen from the lit side; t is the square of the distance from the centre
    /// over that of the radius, so that all texels have the same area.
    ///
    /// - `zero`: where the azimuth is nought, any length but zero, not along the normal; its part across the normal counts.
    ///   `None`: the tangent of [`Frame::around`] the normal (the x axis, for a normal along z)
    pub fn disk(disk: &Disk, zero: Option<DVec3>) -> Result<Parametrisation, ParametrisationError> {
        let zero = match zero {
            Some(zero) => across("zero", zero, "the normal", disk.normal())?,
            None => Frame::around(disk.normal()).tangent,
        };
        let quarter = disk.normal().cross(zero);
        let chart = Chart::Disk { center: disk.center(), zero, quarter, radius: disk.radius() };
        Ok(Parametrisation { chart, area: disk.area() })
    }

    /// s is the longitude over 2π, eastwards (counter-clockwise seen from above the north pole); t is the angle from the
    /// south pole over π. At the poles s is 0.
    ///
    /// - `north`: from the centre towards the north pole; `equator`: towards where the longitude is nought. Any length but
    ///   zero; of `equator` only the part across `north` counts, and it needs one
    pub fn sphere(sphere: &Sphere, north: DVec3, equator: DVec3) -> Result<Parametrisation, ParametrisationError> {
        let north = unit("north", north)?;
        let equator = across("equator", equator, "north", north)?;
        let east = north.cross(equator);
        let chart = Chart::Sphere { center: sphere.center(), equator, east, north, radius: sphere.radius() };
        Ok(Parametrisation { chart, area: sphere.area() })
    }

    /// Square metres.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Whether s = 1 is where s = 0 is.
    pub fn wraps(&self) -> bool {
        matches!(self.chart, Chart::Disk { .. } | Chart::Sphere { .. })
    }

    /// Whether all of the edge t = 0, and of the edge t = 1, is a single point of the surface: a disk's centre, a sphere's
    /// poles.
    pub fn poles(&self) -> [bool; 2] {
        match self.chart {
            Chart::Rectangle(_) | Chart::Triangle { .. } => [false, false],
            Chart::Disk { .. } => [true, false],
            Chart::Sphere { .. } => [true, true],
        }
    }

    /// The part of the map that the surface covers; `None` where that is all of it.
    pub fn map_triangle(&self) -> Option<&MapTriangle> {
        match &self.chart {
            Chart::Triangle { map, .. } => Some(map),
            _ => None,
        }
    }

    /// From a point of the surface (metres) to (s, t) in [0, 1]², where s wraps in [0, 1).
    ///
    /// A point beside the surface counts as the nearest one of the plane, or as the one in the same direction from the
    /// centre of a sphere; what then lies outside the map is moved to its edge.
    ///
    /// - error: some units in the last place of the coordinates over the size of the surface; s of a sphere or a disk more
    ///   by one over the share of the radius that the point is off the axis
    #[inline]
    pub fn to_map(&self, point: DVec3) -> [f64; 2] {
        self.to_map_from_anchor(point - self.anchor())
    }

    /// A point of the surface to which the others are given by offsets, metres: the centre of a rectangle, disk or sphere,
    /// the first vertex of a triangle. Far from the origin offsets keep digits that coordinates have lost.
    #[inline]
    pub fn anchor(&self) -> DVec3 {
        match &self.chart {
            Chart::Rectangle(plane) | Chart::Triangle { plane, .. } => plane.anchor,
            Chart::Disk { center, .. } | Chart::Sphere { center, .. } => *center,
        }
    }

    /// [`Parametrisation::to_map`] of a point given by its offset from the [anchor](Parametrisation::anchor), metres.
    #[inline]
    pub fn to_map_from_anchor(&self, offset: DVec3) -> [f64; 2] {
        let [s, t] = match &self.chart {
            Chart::Rectangle(plane) => plane.solve(offset),
            Chart::Triangle { plane, map } => map.at(plane.solve(offset)),
            Chart::Disk { zero, quarter, radius, .. } => {
                let offset = offset / *radius;
                let (x, y) = (offset.dot(*zero), offset.dot(*quarter));
                [turn_of(x, y), x * x + y * y]
            }
            Chart::Sphere { equator, east, north, .. } => {
                let (x, y, z) = (offset.dot(*equator), offset.dot(*east), offset.dot(*north));
                [turn_of(x, y), libm::atan2(libm::hypot(x, y), -z) / PI]
            }
        };
        // A NaN stays what it is: whoever passes one in gets one back, and no texel (`TexelGrid::texel` clamps).
        [s.clamp(0.0, 1.0), t.clamp(0.0, 1.0)]
    }

    /// From (s, t) to the point of the surface, metres.
    ///
    /// On a triangle (s, t) may lie outside the map's triangle: the point then lies beside it, in its plane.
    pub fn to_surface(&self, at: [f64; 2]) -> DVec3 {
        self.anchor() + self.offset(at)
    }

    /// [`Parametrisation::to_surface`] as an offset from the [anchor](Parametrisation::anchor), metres.
    pub fn offset(&self, [s, t]: [f64; 2]) -> DVec3 {
        match &self.chart {
            Chart::Rectangle(plane) => plane.offset(s, t),
            Chart::Triangle { plane, map } => {
                let [a, b] = map.solve([s, t]);
                plane.offset(a, b)
            }
            Chart::Disk { zero, quarter, radius, .. } => {
                let (sin, cos) = libm::sincos(TAU * s);
                (*zero * cos + *quarter * sin) * (radius * t.max(0.0).sqrt())
            }
            Chart::Sphere { equator, east, north, radius, .. } => {
                let (sin_s, cos_s) = libm::sincos(TAU * s);
                let (sin_t, cos_t) = libm::sincos(PI * t);
                ((*equator * cos_s + *east * sin_s) * sin_t - *north * cos_t) * *radius
            }
        }
    }

    /// dA / ds dt: square metres per area of the map. Outside a map triangle, too, what its plane has there.
    pub fn density(&self, [_, t]: [f64; 2]) -> f64 {
        match &self.chart {
            Chart::Rectangle(_) | Chart::Disk { .. } => self.area,
            Chart::Triangle { map, .. } => self.area / map.area(),
            Chart::Sphere { .. } => self.area * 0.5 * PI * libm::sin(PI * t.clamp(0.0, 1.0)),
        }
    }

    /// The share of the surface's area below a t, in [0, 1]; not for triangles, whose texels are no product of intervals
    /// (`None`).
    pub fn share_below(&self, t: f64) -> Option<f64> {
        match &self.chart {
            Chart::Rectangle(_) | Chart::Disk { .. } => Some(t),
            Chart::Sphere { .. } => {
                let sin = libm::sin(0.5 * PI * t);
                Some(sin * sin)
            }
            Chart::Triangle { .. } => None,
        }
    }

    /// The t below which a share of the surface's area lies: the inverse of [`Parametrisation::share_below`].
    pub fn t_of_share(&self, share: f64) -> Option<f64> {
        match &self.chart {
            Chart::Rectangle(_) | Chart::Disk { .. } => Some(share),
            // From the nearer pole, for the digits.
            Chart::Sphere { .. } if share > 0.5 => Some(1.0 - libm::asin((1.0 - share).max(0.0).sqrt()) * 2.0 / PI),
            Chart::Sphere { .. } => Some(libm::asin(share.max(0.0).sqrt()) * 2.0 / PI),
            Chart::Triangle { .. } => None,
        }
    }

    /// The exact area of the part of the surface that one texel of a grid covers, square metres. The texels of a grid cover
    /// the surface once.
    ///
    /// ```text
    /// rectangle, disk   A / (ns nt)
    /// sphere            A / ns · sin(π (2j + 1) / 2nt) sin(π / 2nt)      (R² Δlongitude Δheight)
    /// triangle          A · |texel ∩ map triangle| / |map triangle|
    /// ```
    ///
    /// - error: a few units in the last place; where a map triangle's side cuts the texel, of the whole texel
    pub fn texel_area(&self, grid: TexelGrid, texel: Texel) -> f64 {
        let (ns, nt) = (grid.ns() as f64, grid.nt() as f64);
        match &self.chart {
            Chart::Rectangle(_) | Chart::Disk { .. } => self.area / (ns * nt),
            Chart::Sphere { .. } => {
                // Counted from the nearer pole, for the digits.
                let row = texel.j.min(grid.nt() - 1 - texel.j) as f64;
                let half = 0.5 * PI / nt;
                self.area / ns * libm::sin(half * (2.0 * row + 1.0)) * libm::sin(half)
            }
            Chart::Triangle { map, .. } => self.area * (map.texel_share(grid, texel) / map.area()),
        }
    }
}

/// Square metres, or why there is no triangle.
fn triangle_area([p0, p1, p2]: [DVec3; 3]) -> Result<f64, ParametrisationError> {
    for vertex in [p0, p1, p2] {
        super::finite_point("vertices", vertex)?;
    }
    let longest = (p1 - p0).length().max((p2 - p1).length()).max((p0 - p2).length());
    // Scaled, so that nothing overflows or underflows.
    let twice = if longest > 0.0 { ((p1 - p0) / longest).cross((p2 - p0) / longest).length() } else { 0.0 };
    // NaN, of sides beyond the largest number, is degenerate too.
    if !(twice > FLAT && longest.is_finite()) {
        return Err(ParametrisationError::DegenerateTriangle { height: twice * longest, longest });
    }
    Ok(0.5 * twice * longest * longest)
}

/// The unit vector along the part of `v` that is perpendicular to a unit `axis`.
fn across(field: &'static str, v: DVec3, name: &'static str, axis: DVec3) -> Result<DVec3, ParametrisationError> {
    let v = unit(field, v)?;
    let part = v - axis * v.dot(axis);
    if part.length() < ALIGNED {
        return Err(ParametrisationError::Aligned { field, axis: name });
    }
    let part = part.normalize();
    // Once more, for the digits that a small part lacks.
    Ok((part - axis * part.dot(axis)).normalize())
}

/// The angle of (x, y) in turns, in [0, 1).
fn turn_of(x: f64, y: f64) -> f64 {
    let turn = libm::atan2(y, x) / TAU;
    let turn = if turn < 0.0 { turn + 1.0 } else { turn };
    // A hair below nought rounds to a whole turn.
    if turn < 1.0 { turn + 0.0 } else { 0.0 }
}

#[cfg(test)]
mod tests;
