//! Exitance that varies over a rectangle as a polynomial of second degree.

use glam::DVec3;

use crate::geometry::Rectangle;

/// Exitance over a rectangle: e00 + e10 s + e01 t + e20 s² + e11 s t + e02 t².
///
/// s and t are metres from the rectangle's centre along its unit edges `edge_u` and `edge_v`. Nothing keeps it from being
/// negative somewhere; a polynomial that stands for a real source is not.
///
/// ```
/// use etendue::configuration::MeasurementPoint;
/// use etendue::geometry::{DVec3, Rectangle};
/// use etendue::oracle::ExitancePolynomial;
///
/// let panel = Rectangle::new(DVec3::Z, DVec3::Y, DVec3::X)?; // one metre above, faces down
/// let bulge = ExitancePolynomial { e00: 1.0, e20: -2.0, e02: -2.0, ..Default::default() };
/// assert!((bulge.flux(&panel).watts() - (1.0 - 4.0 / 12.0)).abs() < 1e-15);
///
/// let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z)?;
/// let truth = bulge.irradiance(&panel, &point);
/// // Against the middle of the panel alone, which is what is brightest.
/// assert!(truth.irradiance.watts_per_square_metre() > 0.0);
/// assert!(truth.irradiance.watts_per_square_metre() < truth.form_factor.ratio());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExitancePolynomial {
    /// W/m².
    pub e00: f64,
    /// W/m³.
    pub e10: f64,
    /// W/m³.
    pub e01: f64,
    /// W/m⁴.
    pub e20: f64,
    /// W/m⁴.
    pub e11: f64,
    /// W/m⁴.
    pub e02: f64,
}

impl ExitancePolynomial {
    /// W/m² at `s`, `t` metres from the centre.
    pub fn value(&self, s: f64, t: f64) -> f64 {
        self.e00 + s * (self.e10 + self.e20 * s + self.e11 * t) + t * (self.e01 + self.e02 * t)
    }

    /// W/m² at a position (metres) on a rectangle; beside its plane, that of the nearest point in it.
    pub fn value_at(&self, rectangle: &Rectangle, position: DVec3) -> f64 {
        let [s, t] = Edges::new(rectangle).metres(position - rectangle.center());
        self.value(s, t)
    }

    /// Mean over a rectangle with edges a and b, W/m²: e00 + e20 a²/12 + e02 b²/12.
    pub fn mean(&self, rectangle: &Rectangle) -> f64 {
        let square = |edge: DVec3| edge.length_squared() / 12.0;
        self.e00 + self.e20 * square(rectangle.edge_u()) + self.e02 * square(rectangle.edge_v())
    }

    /// The least and the greatest value on a rectangle: at a corner, where the slope along an edge is nought, or where both
    /// slopes are.
    pub fn range(&self, rectangle: &Rectangle) -> [f64; 2] {
        let (a, b) = (0.5 * rectangle.edge_u().length(), 0.5 * rectangle.edge_v().length());
        let mut places = vec![[-a, -b], [a, -b], [a, b], [-a, b]];
        // 2 e20 s + e10 + e11 t = 0 along an edge of one t, and likewise of one s.
        places.extend([-b, b].map(|t| [-(self.e10 + self.e11 * t) / (2.0 * self.e20), t]));
        places.extend([-a, a].map(|s| [s, -(self.e01 + self.e11 * s) / (2.0 * self.e02)]));
        let determinant = 4.0 * self.e20 * self.e02 - self.e11 * self.e11;
        places.push([
            (self.e11 * self.e01 - 2.0 * self.e02 * self.e10) / determinant,
            (self.e11 * self.e10 - 2.0 * self.e20 * self.e01) / determinant,
        ]);
        // Not a number where there is no such place.
        let within = places.into_iter().filter(|[s, t]| s.abs() <= a && t.abs() <= b);
        within.map(|[s, t]| self.value(s, t)).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            // A NaN is neither least nor greatest, but must not be lost.
            if value.is_nan() { [value, value] } else { [low.min(value), high.max(value)] }
        })
    }
}

/// A rectangle's unit edges, prepared for many places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edges {
    u: DVec3,
    v: DVec3,
    /// Edges may be off the right angle by rounding: u·v, and 1 less its square.
    cosine: f64,
    square: f64,
}

impl Edges {
    pub fn new(rectangle: &Rectangle) -> Edges {
        let (u, v) = (rectangle.edge_u().normalize(), rectangle.edge_v().normalize());
        let cosine = u.dot(v);
        Edges { u, v, cosine, square: 1.0 - cosine * cosine }
    }

    /// Metres from the centre along either edge, of an offset from the centre; beside the plane, of the nearest point in it.
    #[inline]
    pub fn metres(&self, offset: DVec3) -> [f64; 2] {
        let (along_u, along_v) = (offset.dot(self.u), offset.dot(self.v));
        [(along_u - self.cosine * along_v) / self.square, (along_v - self.cosine * along_u) / self.square]
    }
}
