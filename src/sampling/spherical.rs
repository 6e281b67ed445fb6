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
        let (second_off, third_off) = (across(a, to_second), across(a, to_third));
        let lengths = second_off.length() * third_off.length();
        let to_first = across(b, -to_second).normalize_or_zero();
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
    ///   small keeps its digits. For a triangle that the eye nearly touches, times its size over the eye's height
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

/// The part of an edge at right angles to a unit vector. Twice is enough: what the first subtraction leaves along the vector,
/// where the two are nearly parallel, the second takes away.
fn across(unit: DVec3, edge: DVec3) -> DVec3 {
    let once = edge - unit * unit.dot(edge);
    once - unit * unit.dot(once)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::solid_angle;

    /// First corner and the two edges from it, seen from the origin.
    fn triangles() -> Vec<[DVec3; 3]> {
        let v = DVec3::new;
        vec![
            // An octant; less; obtuse; small; smaller than any renderer's threshold.
            [v(1.0, 0.0, 0.0), v(-1.0, 1.0, 0.0), v(-1.0, 0.0, 1.0)],
            [v(-0.3, -0.2, -1.0), v(1.0, 0.1, 0.0), v(0.2, 0.8, 0.0)],
            [v(-0.3, -0.2, -0.5), v(3.0, 0.0, 0.0), v(-1.0, 0.2, 0.0)],
            [v(0.4, -0.2, -1.0), v(1e-2, 0.0, 0.0), v(3e-3, 1e-2, 0.0)],
            [v(0.4, -0.2, -1.0), v(1e-5, 0.0, 0.0), v(3e-6, 1e-5, 0.0)],
            [v(0.4, -0.2, -1.0), v(1e-7, 0.0, 0.0), v(3e-8, 1e-7, 0.0)],
            // Nearly all directions below: the eye close over the middle.
            [v(-1.0, -1.0, -1e-2), v(2.0, 0.0, 0.0), v(1.0, 2.0, 0.0)],
            [v(-1.0, -1.0, -1e-7), v(2.0, 0.0, 0.0), v(1.0, 2.0, 0.0)],
            // Grazed from beside, from beside an edge's line, and under a corner.
            [v(1.0, -0.5, -1e-8), v(1.0, 0.0, 0.0), v(0.2, 1.0, 0.0)],
            [v(1.0, 0.0, -1e-6), v(1.0, 0.0, 0.0), v(0.2, 1.0, 0.0)],
            [v(0.0, 0.0, -1e-6), v(1.0, 0.0, 0.0), v(0.2, 1.0, 0.0)],
            // A sliver of a millionth of a millionth by one.
            [v(-0.5, 0.0, -1.0), v(1.0, 0.0, 0.0), v(0.3, 1e-12, 0.0)],
        ]
    }

    /// Every renaming of the corners.
    fn turned([a, b, c]: [DVec3; 3]) -> [[DVec3; 3]; 6] {
        [[a, b, c], [a, c, b], [a + b, c - b, -b], [a + b, -b, c - b], [a + c, -c, b - c], [a + c, b - c, -c]]
    }

    #[test]
    fn the_solid_angle_is_that_of_geometry() {
        for [a, b, c] in triangles().into_iter().flat_map(turned) {
            let found = SphericalTriangle::new(a, b, c).solid_angle();
            let expected = solid_angle::triangle(DVec3::ZERO, [a, a + b, a + c]).unwrap();
            // The witness takes the corners, whose sums have lost digits of the sliver's edges; grazed edges lose, too.
            approx::assert_relative_eq!(found, expected, max_relative = 1e-9);
        }
    }

    #[test]
    fn equal_parts_of_the_square_get_equal_solid_angles() {
        let n = 64;
        for (index, [a, b, c]) in triangles().into_iter().enumerate() {
            for [a, b, c] in turned([a, b, c]) {
                let triangle = SphericalTriangle::new(a, b, c);
                let at =
                    |i: u32, j: u32| triangle.direction(f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let mut off = 0;
                for j in 0..n {
                    for i in 0..n {
                        let (p, q, r, s) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                        let half = |q: DVec3, r: DVec3| SphericalTriangle::new(p, q - p, r - p).solid_angle();
                        let cell = (half(q, r) + half(r, s)) / triangle.solid_angle() * f64::from(n * n);
                        off += u32::from((cell - 1.0).abs() > 0.03);
                    }
                }
                // Near the hemisphere the square's first columns are bent around two corners: no cell there is a triangle pair.
                let bent = if [6, 7].contains(&index) { 2 * n } else { 0 };
                assert!(off <= bent, "triangle {index}, {a} {b} {c}: {off} of {} cells", n * n);
            }
        }
    }

    #[test]
    fn the_square_ends_where_the_triangle_ends() {
        for [a, b, c] in triangles().into_iter().flat_map(turned) {
            let triangle = SphericalTriangle::new(a, b, c);
            let size = b.length().max(c.length()).min(1.0);
            for (u, v, corner) in [(0.0, 1.0, a), (0.5, 0.0, a + b), (1.0, 1.0, a + c)] {
                let off = (triangle.direction(u, v) - corner.normalize()).length();
                // Where the eye is 10⁻⁷ over the middle, roundings of the arcs are magnified 10⁷ times.
                assert!(off < 1e-8 * size + 4e-16, "{a} {b} {c}: {off}");
            }
            for k in 0..100 {
                let (u, v) = (f64::from(k) / 99.0, f64::from(k * 37 % 100) / 99.0);
                approx::assert_relative_eq!(triangle.direction(u, v).length(), 1.0, max_relative = 1e-14);
            }
        }
    }

    #[test]
    fn a_triangle_in_the_plane_of_the_eye_has_no_solid_angle() {
        assert_eq!(SphericalTriangle::new(DVec3::X, DVec3::X, DVec3::new(0.5, 1.0, 0.0)).solid_angle(), 0.0);
        assert_eq!(SphericalTriangle::new(DVec3::X, DVec3::Y, DVec3::Y).solid_angle(), 0.0);
    }
}
