//! The surface on which light is measured, and the points that a line or a grid puts on it.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;

use super::{ConfigurationError, MeasurementPoint};
use crate::geometry::{Disk, Frame, Polygon, Rectangle, Shape, Sphere, Triangle};
use crate::radiometry::Albedo;
use crate::texture::Texture;

/// How far a line's end may lie off the receiver, in units of the receiver's size.
const ON_RECEIVER: f64 = 1e-9;

/// A receiving surface's shape. Its receiving side is the one its normal points to; a sphere receives outside.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ReceiverShape {
    Rectangle(Rectangle),
    Disk(Disk),
    Triangle(Triangle),
    Sphere(Sphere),
}

impl ReceiverShape {
    /// The same surface as a shape of its own.
    pub fn as_shape(&self) -> Shape {
        match self {
            ReceiverShape::Rectangle(s) => Shape::Rectangle(*s),
            ReceiverShape::Disk(s) => Shape::Disk(*s),
            ReceiverShape::Sphere(s) => Shape::Sphere(*s),
            ReceiverShape::Triangle(s) => {
                Shape::Polygon(Polygon::new(s.vertices().to_vec()).expect("a triangle is a polygon"))
            }
        }
    }
    /// Lowest and highest coordinates of a box around it, metres.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.as_shape().bounds()
    }
}

/// A receiving surface. It blocks no light.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiver {
    shape: ReceiverShape,
    /// Over all of it, or the mean of its texture.
    albedo: Option<Albedo>,
    texture: Option<Arc<Texture>>,
}

impl Receiver {
    /// - `albedo`: in [0, 1], or `None` where radiosity is not asked for
    pub fn new(shape: ReceiverShape, albedo: Option<Albedo>) -> Result<Receiver, ConfigurationError> {
        match albedo.map(Albedo::ratio) {
            Some(said) if !(0.0..=1.0).contains(&said) => Err(ConfigurationError::Albedo { said }),
            _ => Ok(Receiver { shape, albedo, texture: None }),
        }
    }

    /// A receiver whose albedo varies over it.
    ///
    /// - `texture`: laid out on the same shape, in [0, 1] everywhere
    pub fn textured(shape: ReceiverShape, texture: Texture) -> Result<Receiver, ConfigurationError> {
        let [least, largest] = texture.range();
        for said in [least, largest] {
            if !(0.0..=1.0).contains(&said) {
                return Err(ConfigurationError::Albedo { said });
            }
        }
        let receiver = Receiver::new(shape, Some(Albedo::new(texture.mean().clamp(0.0, 1.0))))?;
        Ok(Receiver { texture: Some(Arc::new(texture)), ..receiver })
    }

    pub fn shape(&self) -> &ReceiverShape {
        &self.shape
    }
    /// Of a textured receiver, the mean over its surface.
    pub fn albedo(&self) -> Option<Albedo> {
        self.albedo
    }
    /// What its albedo is read from, where that varies.
    pub fn texture(&self) -> Option<&Arc<Texture>> {
        self.texture.as_ref()
    }
    /// At a point of its surface (metres).
    pub fn albedo_at(&self, point: DVec3) -> Option<Albedo> {
        self.texture.as_ref().map_or(self.albedo, |texture| Some(Albedo::new(texture.at(point).clamp(0.0, 1.0))))
    }

    /// `n ≥ 2` points from one end to the other, ends included, evenly spaced: along the straight segment on a flat
    /// receiver, along the shorter great-circle arc on a sphere. Both ends must lie on the receiver.
    pub fn line(&self, from: DVec3, to: DVec3, n: usize) -> Result<Vec<MeasurementPoint>, ConfigurationError> {
        for (end, point) in [("from", from), ("to", to)] {
            let (distance, size) = self.distance(point);
            if distance.is_nan() || distance > ON_RECEIVER * size {
                return Err(ConfigurationError::OffReceiver { end, distance });
            }
        }
        let share = |i: usize| if n > 1 { i as f64 / (n - 1) as f64 } else { 0.0 };
        let on_segment = |i: usize| from + (to - from) * share(i);
        match self.shape {
            ReceiverShape::Sphere(s) => {
                let (a, b) = ((from - s.center()).normalize(), (to - s.center()).normalize());
                let angle = a.cross(b).length().atan2(a.dot(b));
                if PI - angle < 1e-9 {
                    return Err(ConfigurationError::AmbiguousArc);
                }
                let across = (b - a * a.dot(b)).normalize_or_zero();
                Ok((0..n)
                    .map(|i| {
                        let (sin, cos) = (angle * share(i)).sin_cos();
                        self.element(s.center() + (a * cos + across * sin) * s.radius())
                    })
                    .collect())
            }
            _ => Ok((0..n).map(|i| self.element(on_segment(i))).collect()),
        }
    }

    /// The centres of `nu × nv` cells of equal area in the receiver's (s, t) coordinates, s fastest.
    ///
    /// - rectangle: s along `edge_u`, t along `edge_v`
    /// - disk: s around the axis, t outwards with radius R √t
    /// - triangle: with vertices p0, p1, p2 the point p0 + √t ((1−s)(p1−p0) + s (p2−p0))
    /// - sphere: s the longitude about z from x, t from south to north pole with height R (2t − 1)
    pub fn grid(&self, nu: usize, nv: usize) -> Vec<MeasurementPoint> {
        let cell = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        (0..nu * nv).map(|k| self.element(self.surface_point(cell(k % nu, nu), cell(k / nu, nv)))).collect()
    }

    fn surface_point(&self, s: f64, t: f64) -> DVec3 {
        match self.shape {
            ReceiverShape::Rectangle(r) => r.center() + r.edge_u() * (s - 0.5) + r.edge_v() * (t - 0.5),
            ReceiverShape::Disk(d) => {
                let frame = Frame::around(d.normal());
                let (sin, cos) = (TAU * s).sin_cos();
                d.center() + (frame.tangent * cos + frame.bitangent * sin) * (d.radius() * t.sqrt())
            }
            ReceiverShape::Triangle(triangle) => {
                let [p0, p1, p2] = triangle.vertices();
                p0 + ((p1 - p0) * (1.0 - s) + (p2 - p0) * s) * t.sqrt()
            }
            ReceiverShape::Sphere(ball) => {
                let (sin, cos) = (TAU * s).sin_cos();
                let z = 2.0 * t - 1.0;
                let ring = ((1.0 - z) * (1.0 + z)).sqrt();
                ball.center() + DVec3::new(ring * cos, ring * sin, z) * ball.radius()
            }
        }
    }

    /// The surface element at a point of the receiver.
    fn element(&self, position: DVec3) -> MeasurementPoint {
        let normal = match self.shape {
            ReceiverShape::Rectangle(r) => r.normal(),
            ReceiverShape::Disk(d) => d.normal(),
            ReceiverShape::Triangle(t) => t.normal(),
            ReceiverShape::Sphere(s) => position - s.center(),
        };
        MeasurementPoint::new(position, normal).expect("a point of a valid receiver has a position and a normal")
    }

    /// Distance of a point from the receiver's surface, and the receiver's size, metres.
    fn distance(&self, point: DVec3) -> (f64, f64) {
        let beyond = |x: f64| (x.abs() - 1.0).max(0.0);
        match self.shape {
            ReceiverShape::Rectangle(r) => {
                let offset = point - r.center();
                let (u, v) = (r.edge_u() * 0.5, r.edge_v() * 0.5);
                let out_u = beyond(offset.dot(u) / u.length_squared()) * u.length();
                let out_v = beyond(offset.dot(v) / v.length_squared()) * v.length();
                let height = offset.dot(r.normal());
                (DVec3::new(out_u, out_v, height).length(), u.length().max(v.length()))
            }
            ReceiverShape::Disk(d) => {
                let offset = point - d.center();
                let height = offset.dot(d.normal());
                let out = ((offset - d.normal() * height).length() - d.radius()).max(0.0);
                (height.hypot(out), d.radius())
            }
            ReceiverShape::Triangle(t) => {
                let [a, b, c] = t.vertices();
                let size = (b - a).length().max((c - a).length());
                let outside = |from: DVec3, to: DVec3| {
                    let inward = t.normal().cross(to - from).normalize();
                    (-(point - from).dot(inward)).max(0.0)
                };
                let out = outside(a, b).max(outside(b, c)).max(outside(c, a));
                ((point - a).dot(t.normal()).hypot(out), size)
            }
            ReceiverShape::Sphere(s) => (((point - s.center()).length() - s.radius()).abs(), s.radius()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on(shape: ReceiverShape) -> Receiver {
        Receiver::new(shape, None).unwrap()
    }

    #[test]
    fn grid_points_lie_on_their_receiver() {
        let shapes = [
            ReceiverShape::Rectangle(Rectangle::new(DVec3::ONE, DVec3::X * 2.0, DVec3::Z).unwrap()),
            ReceiverShape::Disk(Disk::new(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0), 2.0).unwrap()),
            ReceiverShape::Triangle(Triangle::new([DVec3::ZERO, DVec3::X, DVec3::new(0.3, 2.0, 1.0)]).unwrap()),
            ReceiverShape::Sphere(Sphere::new(DVec3::ONE, 0.5).unwrap()),
        ];
        for shape in shapes {
            let receiver = on(shape);
            let points = receiver.grid(5, 4);
            assert_eq!(points.len(), 20);
            for p in points {
                let (distance, size) = receiver.distance(p.position());
                assert!(distance <= 1e-15 * (1.0 + size), "{shape:?}: {distance} m off");
                approx::assert_abs_diff_eq!(p.normal().length(), 1.0, epsilon = 4e-16);
            }
        }
    }

    #[test]
    fn a_line_on_a_sphere_is_an_arc_with_outward_normals() {
        let receiver = on(ReceiverShape::Sphere(Sphere::new(DVec3::ZERO, 2.0).unwrap()));
        let points = receiver.line(DVec3::X * 2.0, DVec3::Y * 2.0, 3).unwrap();
        approx::assert_abs_diff_eq!(points[1].position().x, 2.0_f64.sqrt(), epsilon = 1e-15);
        approx::assert_abs_diff_eq!(points[1].normal().y, 0.5_f64.sqrt(), epsilon = 1e-15);
        assert_eq!(
            receiver.line(DVec3::X * 2.0, DVec3::X * -2.0, 3),
            Err(ConfigurationError::AmbiguousArc),
            "opposite points have no shorter arc"
        );
    }

    #[test]
    fn a_line_off_the_receiver_is_refused() {
        let receiver = on(ReceiverShape::Rectangle(Rectangle::new(DVec3::ZERO, DVec3::X, DVec3::Y).unwrap()));
        assert!(receiver.line(DVec3::ZERO, DVec3::X * 0.5, 2).is_ok());
        for bad in [DVec3::X * 0.6, DVec3::Z * 0.1, DVec3::NAN] {
            assert!(matches!(
                receiver.line(DVec3::ZERO, bad, 2),
                Err(ConfigurationError::OffReceiver { end: "to", .. })
            ));
        }
    }
}
