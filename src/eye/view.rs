//! What the pixels of a picture are: rays of a camera, or the elements of the receiver itself.

use std::f64::consts::TAU;

use super::camera::{Camera, CameraError, Projection, check_pixels};
use super::error::EyeError;
use crate::configuration::{Configuration, MeasurementPoint, ReceiverShape};
use crate::geometry::{DVec3, Frame};
use crate::light::Sight;

/// What the pixels of a picture are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// Rays into the room.
    Camera(Camera),
    /// The receiver alone.
    Receiver(ReceiverView),
}

impl View {
    /// The receiver of a room, so that each pixel is a piece of it and nothing stands before it.
    ///
    /// - `longest`: pixels along the longer side; the shorter has as many as keep pixels square, to rounding
    pub fn of_receiver(room: &Configuration, longest: usize) -> Result<View, EyeError> {
        let receiver = room.receiver().ok_or(EyeError::NoReceiver)?;
        let view = ReceiverView::new(*receiver.shape(), [1, 1])?;
        let [width, height] = view.extent();
        let side = |length: f64| ((longest as f64 * length / width.max(height)).round() as usize).max(1);
        Ok(View::Receiver(ReceiverView::new(*receiver.shape(), [side(width), side(height)])?))
    }

    /// Whether no pixel's ray starts inside of a ball or of glass.
    pub fn stands_free(&self, room: &Configuration) -> Result<(), EyeError> {
        let View::Camera(camera) = self else { return Ok(()) };
        let sight = Sight::new(room);
        let [width, height] = camera.pixels();
        // All rays of a perspective camera start at its eye.
        let n = match camera.projection() {
            Projection::Orthographic { .. } => width * height,
            Projection::Perspective { .. } => 1,
        };
        let starts = (0..n).map(|k| camera.ray((k % width) as f64 + 0.5, (k / width) as f64 + 0.5).0);
        match starts.into_iter().find_map(|from| sight.inside(from)) {
            Some((role, index)) => Err(EyeError::Inside { role, index }),
            None => Ok(()),
        }
    }

    /// The same view with other pixels.
    pub fn with_pixels(self, pixels: [usize; 2]) -> Result<View, CameraError> {
        match self {
            View::Camera(camera) => camera.with_pixels(pixels).map(View::Camera),
            View::Receiver(view) => ReceiverView::new(view.shape, pixels).map(View::Receiver),
        }
    }

    /// Width and height.
    pub fn pixels(&self) -> [usize; 2] {
        match self {
            View::Camera(camera) => camera.pixels(),
            View::Receiver(view) => view.pixels,
        }
    }
}

/// A receiver seen square on from its receiving side by an orthographic camera that stands on it: nothing is in between. A
/// sphere is unrolled onto the cylinder around it, by longitude and height, which keeps areas (Archimedes; Lambert 1772).
///
/// | receiver | to the right | upwards | picture |
/// |---|---|---|---|
/// | rectangle | `edge_u` | `edge_v` | all of it |
/// | disk | where its azimuth is nought | a quarter turn on | the square around it |
/// | triangle | from the first vertex to the second | across | the box around it |
/// | sphere | longitude about z, from x eastwards | z | all of it |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverView {
    shape: ReceiverShape,
    pixels: [usize; 2],
    /// The picture's lower left corner and its sides, of flat receivers; metres.
    corner: DVec3,
    right: DVec3,
    up: DVec3,
}

impl ReceiverView {
    /// - `pixels`: width and height
    pub fn new(shape: ReceiverShape, pixels: [usize; 2]) -> Result<ReceiverView, CameraError> {
        check_pixels(pixels)?;
        let (corner, right, up) = match &shape {
            ReceiverShape::Rectangle(s) => (s.center() - (s.edge_u() + s.edge_v()) * 0.5, s.edge_u(), s.edge_v()),
            ReceiverShape::Disk(s) => {
                let frame = Frame::around(s.normal());
                let (right, up) = (frame.tangent * (2.0 * s.radius()), frame.bitangent * (2.0 * s.radius()));
                (s.center() - (right + up) * 0.5, right, up)
            }
            ReceiverShape::Triangle(s) => {
                let [a, b, c] = s.vertices();
                let right = (b - a).normalize();
                let up = s.normal().cross(right);
                let (apex, height) = ((c - a).dot(right), (c - a).dot(up));
                let (low, high) = (apex.min(0.0), apex.max((b - a).length()));
                (a + right * low, right * (high - low), up * height)
            }
            ReceiverShape::Sphere(s) => (s.center(), DVec3::X * (TAU * s.radius()), DVec3::Z * (2.0 * s.radius())),
        };
        Ok(ReceiverView { shape, pixels, corner, right, up })
    }

    /// Width and height of what the picture shows, metres; of a sphere, of the cylinder around it.
    pub fn extent(&self) -> [f64; 2] {
        [self.right.length(), self.up.length()]
    }
    pub fn shape(&self) -> &ReceiverShape {
        &self.shape
    }
    /// Width and height.
    pub fn pixels(&self) -> [usize; 2] {
        self.pixels
    }

    /// The surface element at a place of the picture; `None` beside the receiver.
    ///
    /// - `x`, `y`: pixels from the upper left corner, to the right and downwards
    pub fn element(&self, x: f64, y: f64) -> Option<MeasurementPoint> {
        let [width, height] = self.pixels.map(|n| n as f64);
        let (a, b) = (x / width, 1.0 - y / height);
        let flat = self.corner + self.right * a + self.up * b;
        let (at, normal) = match &self.shape {
            ReceiverShape::Rectangle(s) => (flat, s.normal()),
            ReceiverShape::Disk(s) => ((flat - s.center()).length() < s.radius()).then_some((flat, s.normal()))?,
            ReceiverShape::Triangle(s) => {
                let [p, q, r] = s.vertices();
                let left_of = |from: DVec3, to: DVec3| (to - from).cross(flat - from).dot(s.normal()) >= 0.0;
                (left_of(p, q) && left_of(q, r) && left_of(r, p)).then_some((flat, s.normal()))?
            }
            ReceiverShape::Sphere(s) => {
                let (sin, cos) = libm::sincos(TAU * a);
                let z = 2.0 * b - 1.0;
                let ring = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
                let out = DVec3::new(ring * cos, ring * sin, z);
                (s.center() + out * s.radius(), out)
            }
        };
        MeasurementPoint::new(at, normal).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::Receiver;
    use crate::geometry::{Disk, Rectangle, Sphere, Triangle};

    fn shapes() -> [(ReceiverShape, f64); 4] {
        let triangle = [DVec3::ONE, DVec3::new(3.0, 1.0, 1.0), DVec3::new(0.5, 2.0, 1.5)];
        [
            // The share of the picture that the receiver fills.
            (ReceiverShape::Rectangle(Rectangle::new(DVec3::ONE, DVec3::X * 2.0, DVec3::Z).unwrap()), 1.0),
            (
                ReceiverShape::Disk(Disk::new(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0), 2.0).unwrap()),
                std::f64::consts::FRAC_PI_4,
            ),
            (ReceiverShape::Triangle(Triangle::new(triangle).unwrap()), 0.4),
            (ReceiverShape::Sphere(Sphere::new(DVec3::ONE, 0.5).unwrap()), 1.0),
        ]
    }

    #[test]
    fn pixels_cover_the_receiver_and_nothing_else() {
        for (shape, share) in shapes() {
            let view = ReceiverView::new(shape, [100, 80]).unwrap();
            let receiver = Receiver::new(shape, None).unwrap();
            let mut n = 0;
            for k in 0..8000 {
                let Some(element) = view.element((k % 100) as f64 + 0.5, (k / 100) as f64 + 0.5) else { continue };
                n += 1;
                assert!(receiver.line(element.position(), element.position(), 2).is_ok(), "{shape:?}");
                if let ReceiverShape::Sphere(s) = shape {
                    assert!(element.normal().dot(element.position() - s.center()) > 0.0);
                } else {
                    let same = receiver.grid(1, 1)[0].normal();
                    assert!(element.normal().dot(same) > 0.999_999, "{shape:?}");
                }
            }
            assert!((f64::from(n) / 8000.0 - share).abs() < 0.02, "{shape:?}: {n} of 8000");
        }
    }

    #[test]
    fn up_is_up_and_right_is_right() {
        let (shape, _) = shapes()[0];
        let view = ReceiverView::new(shape, [2, 2]).unwrap();
        let upper_left = view.element(0.5, 0.5).unwrap().position();
        assert_eq!(upper_left, DVec3::new(0.5, 1.0, 1.25));
    }
}
