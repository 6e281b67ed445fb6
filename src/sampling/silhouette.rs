//! Directions uniform in the solid angle in which a shape is seen, with the place where each meets it.
//!
//! A rectangle and a polygon are triangles, one chosen by solid angle, the direction then by [`SphericalTriangle`]. (For a
//! rectangle this is the distribution of Ureña, Fajardo & King 2013, whose map subtracts 2π from a sum of four angles.) A
//! sphere is its cone.
//!
//! A disk is seen as an elliptic cone, whose solid angle is an elliptic integral. Directions are drawn uniformly in the
//! rectangle around that ellipse instead, and those that miss the disk are told as misses: they bring nothing, and the mean
//! is right. Misses are few where the disk fills the sky, and 1 − π/4 ≈ 21 % where it is small.
//!
//! Everything is computed in a frame in which what is small is a coordinate, so that directions keep their digits from
//! grazing views to hemispheres and no other method is needed at either end.

use glam::DVec3;

use super::ears::triangulated;
use super::spherical::SphericalTriangle;
use super::warp::concentric;
use super::{BLOCK, LANES, Row, Squares, groups};
use crate::geometry::{Frame, Shape};

/// One block of directions, unit vectors.
#[derive(Clone, Debug)]
pub struct DirectionBlock {
    pub x: Row,
    pub y: Row,
    pub z: Row,
}

impl Default for DirectionBlock {
    fn default() -> DirectionBlock {
        let row = [[0.0; LANES]; BLOCK / LANES];
        DirectionBlock { x: row, y: row, z: row }
    }
}

impl DirectionBlock {
    /// One direction.
    #[inline(always)]
    pub fn direction(&self, group: usize, lane: usize) -> DVec3 {
        DVec3::new(self.x[group][lane], self.y[group][lane], self.z[group][lane])
    }

    #[inline(always)]
    pub(super) fn set(&mut self, group: usize, lane: usize, direction: DVec3) {
        (self.x[group][lane], self.y[group][lane], self.z[group][lane]) = direction.into();
    }
}

/// The lit side of a shape, as it is to be looked at from anywhere.
#[derive(Clone, Debug)]
pub struct Silhouette(Outline);

#[derive(Clone, Debug)]
enum Outline {
    /// Corners in the plane's own frame, relative to the anchor; triangles as indices.
    Polygon {
        anchor: DVec3,
        frame: Frame,
        corners: Vec<[f64; 2]>,
        triangles: Vec<[usize; 3]>,
    },
    Disk {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
    Sphere {
        center: DVec3,
        radius: f64,
    },
}

/// The directions in which one eye sees one shape.
#[derive(Clone, Debug, Default)]
pub struct View {
    solid_angle: f64,
    part: Part,
    /// Emptied and filled again for the next eye.
    triangles: Vec<SphericalTriangle>,
}

#[derive(Clone, Debug, Default)]
enum Part {
    #[default]
    Nothing,
    /// Triangles in `axes`, in a plane at `height` from the eye and facing `facing`.
    Flat { axes: Frame, facing: DVec3, height: f64, farthest: f64, ellipse: Option<[f64; 2]> },
    /// Of half-angle ϑ around `axes.normal`: `width` is sin(ϑ/2), `distance` that of the centre.
    Cone { axes: Frame, width: f64, distance: f64, tangent_squared: f64 },
}

impl Silhouette {
    /// `None` for a mesh.
    pub fn new(shape: &Shape) -> Option<Silhouette> {
        Some(Silhouette(match shape {
            Shape::Rectangle(s) => polygon(&s.corners(), s.normal()),
            Shape::Polygon(s) => polygon(s.vertices(), s.normal()),
            Shape::Disk(s) => Outline::Disk { center: s.center(), normal: s.normal(), radius: s.radius() },
            Shape::Sphere(s) => Outline::Sphere { center: s.center(), radius: s.radius() },
            _ => return None,
        }))
    }

    /// What an eye sees of it: nothing from behind a flat shape, from its plane, or from inside a sphere.
    ///
    /// - `eye`: metres
    pub fn seen_from(&self, eye: DVec3, view: &mut View) {
        view.triangles.clear();
        view.part = Part::Nothing;
        match &self.0 {
            Outline::Polygon { anchor, frame, corners, triangles } => {
                let offset = eye - *anchor;
                let height = offset.dot(frame.normal);
                let foot = [offset.dot(frame.tangent), offset.dot(frame.bitangent)];
                let flat = |k: usize| DVec3::new(corners[k][0], corners[k][1], 0.0);
                let corner = |k: usize| DVec3::new(corners[k][0] - foot[0], corners[k][1] - foot[1], -height);
                if height > 0.0 {
                    let parts = triangles.iter().map(|[a, b, c]| {
                        SphericalTriangle::new(corner(*a), flat(*b) - flat(*a), flat(*c) - flat(*a))
                    });
                    view.triangles.extend(parts);
                    let farthest = (0..corners.len()).map(|k| corner(k).length()).fold(0.0, f64::max);
                    view.part = Part::Flat { axes: *frame, facing: DVec3::Z, height, farthest, ellipse: None };
                }
            }
            Outline::Disk { center, normal, radius } => {
                let across = *center - eye;
                let height = -across.dot(*normal);
                if height > 0.0 {
                    let (part, triangles) = disk(across, *normal, *radius, height);
                    view.triangles.extend(triangles);
                    view.part = part;
                }
            }
            Outline::Sphere { center, radius } => {
                let across = *center - eye;
                let distance = across.length();
                let gap = distance - radius;
                if gap > 0.0 {
                    let tangent_squared = gap * (distance + radius);
                    let sine = radius / distance;
                    let cosine = tangent_squared.sqrt() / distance;
                    let width = sine / (2.0 * (1.0 + cosine)).sqrt();
                    let axes = Frame::around(across / distance);
                    view.part = Part::Cone { axes, width, distance, tangent_squared };
                }
            }
        }
        view.triangles.retain(|triangle| triangle.solid_angle() > 0.0);
        if view.triangles.is_empty() && matches!(view.part, Part::Flat { .. }) {
            view.part = Part::Nothing;
        }
        view.solid_angle = match view.part {
            Part::Nothing => 0.0,
            Part::Flat { .. } => view.triangles.iter().map(SphericalTriangle::solid_angle).sum(),
            Part::Cone { width, .. } => 4.0 * std::f64::consts::PI * width * width,
        };
    }
}

fn polygon(vertices: &[DVec3], normal: DVec3) -> Outline {
    let anchor = vertices[0];
    let frame = Frame::around(normal);
    let corners: Vec<[f64; 2]> =
        vertices.iter().map(|v| [(*v - anchor).dot(frame.tangent), (*v - anchor).dot(frame.bitangent)]).collect();
    let triangles = triangulated(&corners);
    Outline::Polygon { anchor, frame, corners, triangles }
}

/// The rectangle around the elliptic cone in which a disk is seen.
///
/// With h the height over the disk's plane, r₀ the distance from its axis, a its radius, E = h² + r₀² − a² and
/// Λ = 2 a² h²/(√(E² + 4 a² h²) + E), the cone's axis is h r₀ along the disk's plane by h² + Λ towards it, and its semi-axes
/// at unit distance are Λ/(a h) in the plane of both axes and √Λ/h across. (The eigenvectors of the cone's quadratic form;
/// see [`crate::geometry::solid_angle::disk`].)
fn disk(across: DVec3, normal: DVec3, radius: f64, height: f64) -> (Part, [SphericalTriangle; 2]) {
    // In units of the radius.
    let h = height / radius;
    let aside = across + normal * height;
    let r0 = aside.length() / radius;
    let outward = if r0 > 0.0 { aside / (r0 * radius) } else { Frame::around(normal).tangent };
    let product = hypotenuse(h, r0 - 1.0) * hypotenuse(h, r0 + 1.0);
    let excess = h * h + (r0 - 1.0) * (r0 + 1.0);
    // Λ/h², without the difference of near-equal numbers.
    let lambda = if excess > 0.0 { 2.0 / (product + excess) } else { 0.5 * (product - excess) / (h * h) };
    let (semi_along, semi_across) = (lambda * h, lambda.sqrt());
    // Along the disk's plane and towards it, divided by h.
    let (along, down) = (r0, h * (1.0 + lambda));
    let over = 1.0 / hypotenuse(along, down);
    let (along, down) = (along * over, down * over);
    let axis = outward * along - normal * down;
    let tangent = outward * down + normal * along;
    let axes = Frame { tangent, bitangent: axis.cross(tangent), normal: axis };
    let corner = |x: f64, y: f64| DVec3::new(x * semi_along, y * semi_across, 1.0);
    let (wide, high) = (DVec3::X * (2.0 * semi_along), DVec3::Y * (2.0 * semi_across));
    let triangles = [
        SphericalTriangle::new(corner(-1.0, -1.0), wide, high),
        SphericalTriangle::new(corner(1.0, 1.0), -wide, -high),
    ];
    let facing = DVec3::new(along, 0.0, -down);
    let farthest = radius * hypotenuse(h, r0 + 1.0);
    (Part::Flat { axes, facing, height, farthest, ellipse: Some([1.0 / semi_along, 1.0 / semi_across]) }, triangles)
}

/// √(x² + y²) by the square root alone: the same bits on every platform.
fn hypotenuse(x: f64, y: f64) -> f64 {
    let (small, large) = (x.abs().min(y.abs()), x.abs().max(y.abs()));
    let ratio = if large > 0.0 { small / large } else { 0.0 };
    large * (1.0 + ratio * ratio).sqrt()
}

impl View {
    /// Of the directions drawn from, steradians: the shape's own, for a disk that of the rectangle around it.
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// Directions of the first `len` points of a block (rounded up to whole lanes), and how far each is from the shape.
    ///
    /// - `distances`: metres; zero for a direction that misses
    #[inline(always)]
    pub fn draw(&self, squares: &Squares, len: usize, directions: &mut DirectionBlock, distances: &mut Row) {
        match &self.part {
            Part::Nothing => distances[..groups(len)].fill([0.0; LANES]),
            Part::Flat { axes, facing, height, farthest, ellipse } => {
                for g in 0..groups(len) {
                    for l in 0..LANES {
                        let d = self.among_triangles(squares.u[g][l], squares.v[g][l]);
                        let inside = ellipse.is_none_or(|[along, across]| {
                            let (x, y) = (d.x * along, d.y * across);
                            x * x + y * y <= d.z * d.z
                        });
                        // In the plane to rounding, the quotient may be anything.
                        let distance = height / -d.dot(*facing);
                        let distance = if distance > 0.0 { distance.max(*height).min(*farthest) } else { *farthest };
                        distances[g][l] = if inside { distance } else { 0.0 };
                        directions.set(g, l, axes.tangent * d.x + axes.bitangent * d.y + axes.normal * d.z);
                    }
                }
            }
            Part::Cone { axes, width, distance, tangent_squared } => {
                for g in 0..groups(len) {
                    for l in 0..LANES {
                        // Equal areas of the unit disk are equal solid angles of the cone (Lambert).
                        let (x, y) = concentric(squares.u[g][l], squares.v[g][l]);
                        let (widest, squared) = (width * width, x * x + y * y);
                        let cosine = 1.0 - 2.0 * widest * squared;
                        let sine = 2.0 * width * (1.0 - widest * squared).sqrt();
                        // sin²ϑ − sin²θ, that the direction is inside the silhouette by.
                        let inside = 4.0 * widest * (1.0 - squared) * (1.0 - widest * (1.0 + squared));
                        let reach = distance * (cosine + inside.max(0.0).sqrt());
                        distances[g][l] = tangent_squared / reach;
                        directions.set(
                            g,
                            l,
                            axes.tangent * (x * sine) + axes.bitangent * (y * sine) + axes.normal * cosine,
                        );
                    }
                }
            }
        }
    }

    /// u first chooses among the triangles, then what is left of it lies in the chosen one.
    #[inline(always)]
    fn among_triangles(&self, u: f64, v: f64) -> DVec3 {
        let mut left = u * self.solid_angle;
        let last = self.triangles.len() - 1;
        let mut chosen = &self.triangles[last];
        for triangle in &self.triangles[..last] {
            if left < triangle.solid_angle() {
                chosen = triangle;
                break;
            }
            left -= triangle.solid_angle();
        }
        chosen.direction((left / chosen.solid_angle()).clamp(0.0, 1.0), v)
    }
}
