//! Directions uniform in the solid angle of a triangle, from 10⁻¹⁰⁰ sr to a hemisphere by one text.
//!
//! As in Arvo, *Stratified Sampling of Spherical Triangles*, SIGGRAPH 1995: with a, b, c the corners as unit vectors, u says
//! how much of the solid angle Ω lies on the near side of an arc from b to a point p of the edge a–c, and v how far along
//! that arc the direction lies. Arvo's formulas take differences of angles and cosines near one; below some 10⁻⁴ sr they
//! have no digits left, and renderers change the method there. Here every quantity that is small is computed as such:
//!
//! ```text
//! Ω = 2 atan2( a·(b × c), 1 + a·b + b·c + c·a )                                        (van Oosterom & Strackee 1983)
//! with S, K = sin, cos of uΩ/2, the angle A at a, and the side ab seen under an angle of 2s:
//! half of the arc a–p:   tan = S cos s / ( sin s (K sin A − S cos A) )
//! the angle a–b–p:       tan = S (K sin A − S cos A) / ( sin A (K² sin² s − S² cos² s) − S K cos A )
//! half of the arc b–d:   sin = √v |p − b|/2
//! ```
//!
//! The second line is `tan(Ω/2) = τ τ' sin A / (1 + τ τ' cos A)` (τ, τ' tangents of half the sides at A) solved for one side,
//! the third Arvo's eq. for the angle in half angles, the fourth his `z = 1 − v (1 − p·b)`. Edges come as they are, not as
//! differences of far corners.

use glam::DVec3;

use super::arc::sin_cos_eighth;

/// A triangle of directions, ready to draw from.
#[derive(Clone, Copy, Debug)]
pub struct SphericalTriangle {
    solid_angle: f64,
    /// Unit vectors to the first two corners.
    first: DVec3,
    second: DVec3,
    /// first − second, digits kept where the two are near.
    from_second: DVec3,
    /// Unit tangent at the first corner towards the third.
    to_third: DVec3,
    /// Unit tangent at the second corner towards the first, and the one at right angles on the third's side.
    to_first: DVec3,
    inward: DVec3,
    /// Of the angle at the first corner.
    sin_angle: f64,
    cos_angle: f64,
    /// Of half the side between the first two corners.
    sin_half_side: f64,
    cos_half_side: f64,
}

impl SphericalTriangle {
    /// - `first`: a corner relative to the eye; `to_second`, `to_third`: edges from it; any one unit of length
    ///
    /// A triangle whose plane holds the eye has no solid angle.
    pub fn new(first: DVec3, to_second: DVec3, to_third: DVec3) -> SphericalTriangle {
        let corners = [first, first + to_second, first + to_third];
        let [la, lb, lc] = corners.map(DVec3::length);
        let [a, b, c] = [corners[0] / la, corners[1] / lb, corners[2] / lc];
        let height = a.dot(to_second.cross(to_third));
        let below = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
        let solid_angle = 2.0 * libm::atan2(height.abs() / (lb * lc), below);
        // b − a, from the edge: lengths differ by its projection on the sum of both corners.
        let shortening = to_second.dot(corners[0] + corners[1]) / (la + lb);
        let from_second = -(to_second - a * shortening) / lb;
        let (second_off, third_off) = (to_second - a * a.dot(to_second), to_third - a * a.dot(to_third));
        let lengths = second_off.length() * third_off.length();
        let to_first = (b * b.dot(to_second) - to_second).normalize_or_zero();
        SphericalTriangle {
            solid_angle: if solid_angle.is_finite() { solid_angle } else { 0.0 },
            first: a,
            second: b,
            from_second,
            to_third: third_off.normalize_or_zero(),
            to_first,
            inward: b.cross(to_first) * -1.0_f64.copysign(height),
            sin_angle: height.abs() / lengths,
            cos_angle: second_off.dot(third_off) / lengths,
            sin_half_side: 0.5 * from_second.length(),
            cos_half_side: 0.5 * (a + b).length(),
        }
    }

    /// Steradians, in [0, 2π].
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// The direction of a point (u, v) of the unit square, a unit vector; of no meaning where there is no solid angle.
    ///
    /// - error: each coordinate relative to its largest terms, a few 2⁻⁵³; so a coordinate in which the whole triangle is
    ///   small keeps its digits
    #[inline(always)]
    pub fn direction(&self, u: f64, v: f64) -> DVec3 {
        // Of uΩ/8, then doubled twice.
        let (sin, cos) = sin_cos_eighth(u * (self.solid_angle / (2.0 * std::f64::consts::PI)));
        let (sin, cos) = (2.0 * sin * cos, 1.0 - 2.0 * sin * sin);
        let (sin, cos) = (2.0 * sin * cos, 1.0 - 2.0 * sin * sin);
        let part = (cos * self.sin_angle - sin * self.cos_angle).max(0.0);

        let (rise, run) = (sin * self.cos_half_side, self.sin_half_side * part);
        let over = 1.0 / (rise * rise + run * run).sqrt();
        let (sin_half, cos_half) = (rise * over, run * over);
        let from_first = (self.to_third * cos_half - self.first * sin_half) * (2.0 * sin_half);
        let chord = self.from_second + from_first;

        let (near, far) = (cos * self.sin_half_side, sin * self.cos_half_side);
        let (y, x) = (sin * part, self.sin_angle * ((near - far) * (near + far)) - sin * cos * self.cos_angle);
        let over = 1.0 / (x * x + y * y).sqrt();
        let tangent = self.to_first * (x * over) + self.inward * (y * over);

        let squared = (0.25 * v * chord.length_squared()).min(1.0);
        self.second * (1.0 - 2.0 * squared) + tangent * (2.0 * (squared * (1.0 - squared)).sqrt())
    }
}
