//! Cameras without lenses: from a pixel to the ray that goes through it.

use crate::errors::errors;
use crate::geometry::DVec3;

/// How rays leave a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Side by side; `width` of the picture, metres.
    Orthographic { width: f64 },
    /// From one point; `fov`, the full angle across the picture's width, degrees.
    Perspective { fov: f64 },
}

errors! {
    /// Why there is no such camera.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum CameraError {
        #[error("{field} is not finite")]
        NotFinite { field: &'static str },
        #[error("the camera looks at the point where it stands")]
        NoDirection,
        #[error("up points along the line of sight; it needs a part across it")]
        Aligned,
        #[error("width is {said} m; it is greater than zero")]
        Width { said: f64 },
        #[error("fov is {said}°; it is greater than 0° and less than 180°")]
        Fov { said: f64 },
        #[error(
            "{width} × {height} pixels; each side has from 1 to {most_side}, and a picture at most {most}",
            most_side = Camera::MOST_SIDE,
            most = Camera::MOST_PIXELS
        )]
        Pixels { width: u64, height: u64 },
    }
}

impl CameraError {
    /// The key of a case file that the mistake is about.
    pub fn field(&self) -> &'static str {
        match self {
            CameraError::NotFinite { field } => field,
            CameraError::NoDirection => "look_at",
            CameraError::Aligned => "up",
            CameraError::Width { .. } => "width",
            CameraError::Fov { .. } => "fov",
            CameraError::Pixels { .. } => "pixels",
        }
    }
}

/// A camera: where it stands, where it looks, and its pixels.
///
/// ```
/// use etendue::eye::{Camera, Projection};
/// use etendue::geometry::DVec3;
///
/// let camera = Camera::new(Projection::Perspective { fov: 90.0 }, DVec3::Z, DVec3::ZERO, DVec3::Y, [200, 100])?;
/// // The right edge of the picture, half-way up: 45° aside.
/// let (from, direction) = camera.ray(200.0, 50.0);
/// assert_eq!(from, DVec3::Z);
/// assert!((direction - DVec3::new(0.5_f64.sqrt(), 0.0, -0.5_f64.sqrt())).length() < 1e-15);
/// # Ok::<(), etendue::eye::CameraError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    projection: Projection,
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    /// Width and height.
    pixels: [usize; 2],
}

impl Camera {
    /// Most pixels along one side.
    pub const MOST_SIDE: usize = 1 << 14;
    /// Most pixels of a picture.
    pub const MOST_PIXELS: usize = 1 << 22;
    /// The sine of the least angle between up and the line of sight.
    const ALIGNED: f64 = 1e-9;

    /// - `eye`: where it stands (orthographic: the middle of the plane that rays leave from), metres; `look_at`: a point on
    ///   the line of sight; `up`: what is upwards in the picture, any length but zero
    /// - `pixels`: width and height
    pub fn new(
        projection: Projection,
        eye: DVec3,
        look_at: DVec3,
        up: DVec3,
        pixels: [usize; 2],
    ) -> Result<Camera, CameraError> {
        for (field, vector) in [("eye", eye), ("look_at", look_at), ("up", up)] {
            if !vector.is_finite() {
                return Err(CameraError::NotFinite { field });
            }
        }
        match projection {
            Projection::Orthographic { width } if !(width > 0.0 && width.is_finite()) => {
                return Err(CameraError::Width { said: width });
            }
            Projection::Perspective { fov } if !(fov > 0.0 && fov < 180.0) => {
                return Err(CameraError::Fov { said: fov });
            }
            _ => {}
        }
        check_pixels(pixels)?;
        let forward = (look_at - eye).try_normalize().ok_or(CameraError::NoDirection)?;
        let up = up.try_normalize().ok_or(CameraError::Aligned)?;
        let across = forward.cross(up);
        if across.length() <= Camera::ALIGNED {
            return Err(CameraError::Aligned);
        }
        let right = across.normalize();
        Ok(Camera { projection, eye, forward, right, up: right.cross(forward), pixels })
    }

    /// The same camera with other pixels: the picture keeps its width in the room, its height follows.
    pub fn with_pixels(self, pixels: [usize; 2]) -> Result<Camera, CameraError> {
        check_pixels(pixels)?;
        Ok(Camera { pixels, ..self })
    }

    /// Width and height.
    pub fn pixels(&self) -> [usize; 2] {
        self.pixels
    }
    pub fn projection(&self) -> Projection {
        self.projection
    }
    /// Where it stands, metres.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// The ray through a place of the picture: where it starts, metres, and its direction, a unit vector.
    ///
    /// - `x`, `y`: pixels from the upper left corner, to the right and downwards; pixel i runs from i to i + 1
    pub fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let [width, height] = self.pixels.map(|n| n as f64);
        // From −½ to ½ over the width, upwards in the same unit.
        let (a, b) = (x / width - 0.5, (0.5 * height - y) / width);
        match self.projection {
            Projection::Orthographic { width } => {
                (self.eye + self.right * (a * width) + self.up * (b * width), self.forward)
            }
            Projection::Perspective { fov } => {
                let span = 2.0 * libm::tan(fov.to_radians() * 0.5);
                let direction = self.forward + self.right * (a * span) + self.up * (b * span);
                (self.eye, direction.normalize())
            }
        }
    }
}

/// Whether a picture may have these pixels.
pub(super) fn check_pixels([width, height]: [usize; 2]) -> Result<(), CameraError> {
    let side = 1..=Camera::MOST_SIDE;
    let fits = side.contains(&width) && side.contains(&height) && width * height <= Camera::MOST_PIXELS;
    if fits { Ok(()) } else { Err(CameraError::Pixels { width: width as u64, height: height as u64 }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORTHOGRAPHIC: Projection = Projection::Orthographic { width: 2.0 };

    #[test]
    fn an_orthographic_camera_sees_to_scale() {
        let camera = Camera::new(ORTHOGRAPHIC, DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y * 3.0, [4, 2]).unwrap();
        let (from, direction) = camera.ray(0.5, 0.5);
        assert_eq!(direction, -DVec3::Z);
        approx::assert_abs_diff_eq!(from.x, -0.75, epsilon = 1e-15);
        approx::assert_abs_diff_eq!(from.y, 0.25, epsilon = 1e-15);
        // Twice the pixels see the same.
        let finer = camera.with_pixels([8, 4]).unwrap();
        assert_eq!(finer.ray(1.0, 1.0), (from, direction));
    }

    #[test]
    fn what_is_no_camera_is_refused() {
        let make = |projection, eye: DVec3, look_at: DVec3, up: DVec3, pixels| {
            Camera::new(projection, eye, look_at, up, pixels).unwrap_err()
        };
        let (eye, up) = (DVec3::Z, DVec3::Y);
        assert_eq!(make(ORTHOGRAPHIC, eye, eye, up, [4, 4]), CameraError::NoDirection);
        assert_eq!(make(ORTHOGRAPHIC, eye, DVec3::ZERO, eye, [4, 4]), CameraError::Aligned);
        assert_eq!(make(ORTHOGRAPHIC, eye, DVec3::ZERO, DVec3::ZERO, [4, 4]), CameraError::Aligned);
        for fov in [0.0, -1.0, 180.0, f64::NAN] {
            let error = make(Projection::Perspective { fov }, eye, DVec3::ZERO, up, [4, 4]);
            assert!(matches!(error, CameraError::Fov { .. }), "{fov}");
        }
        for width in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            let error = make(Projection::Orthographic { width }, eye, DVec3::ZERO, up, [4, 4]);
            assert!(matches!(error, CameraError::Width { .. }), "{width}");
        }
        for pixels in [[0, 4], [4, 0], [1 << 15, 1], [1 << 14, 1 << 14], [usize::MAX, usize::MAX]] {
            let error = make(ORTHOGRAPHIC, eye, DVec3::ZERO, up, pixels);
            assert!(matches!(error, CameraError::Pixels { .. }), "{pixels:?}");
        }
        let error = make(ORTHOGRAPHIC, DVec3::NAN, DVec3::ZERO, up, [4, 4]);
        assert_eq!(error, CameraError::NotFinite { field: "eye" });
    }
}
