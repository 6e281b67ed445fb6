//! Solid angles of shapes, in steradians: how much of the directions around an eye a shape fills.
//!
//! Both sides of a flat shape count alike, and an eye in its plane but beside it sees nothing of it. No form here
//! subtracts near-equal numbers, so that a small or far shape keeps its digits.

use std::f64::consts::PI;

use glam::DVec3;

use super::shape::{ShapeError, finite, positive};
use super::{Disk, Polygon, Rectangle, Sphere};

/// Solid angle of a triangle.
///
/// With a, b, c the corners relative to the eye:
///
/// ```text
/// tan(Ω/2) = |a·(b × c)| / ( |a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b| )
/// ```
///
/// - `eye`, `corners`: metres; a triangle without area fills nothing
/// - returns sr in [0, 2π]
/// - error: relative, a few 2⁻⁵³ times what the triple product loses: 1/sin of the angle between the triangle's plane and
///   the direction from its first corner to the eye
/// - source: van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30, 1983, eq. 8
pub fn triangle(eye: DVec3, corners: [DVec3; 3]) -> Result<f64, ShapeError> {
    let eye = finite("eye", eye)?;
    for corner in corners {
        finite("vertices", corner)?;
    }
    Ok(signed_triangle(corners.map(|corner| corner - eye)).abs())
}

/// Positive where a, b, c run clockwise seen from the eye.
fn signed_triangle([a, b, c]: [DVec3; 3]) -> f64 {
    // Of the unit vectors: nothing overflows.
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let (ua, ub, uc) = (a / la, b / lb, c / lc);
    // Of the edges, not of the corners, whose products agree to many digits where the triangle is small.
    let triple = ua.dot(((b - a) / lb).cross((c - a) / lc));
    let below = 1.0 + ua.dot(ub) + ub.dot(uc) + uc.dot(ua);
    if triple == 0.0 { 0.0 } else { 2.0 * triple.atan2(below) }
}

/// Solid angle of a simple planar polygon, convex or not: the signed sum over the triangles of a fan.
///
/// - `eye`: metres; in the polygon's plane it sees nothing
/// - returns sr in [0, 2π]
/// - error: relative, a few 2⁻⁵³ times that of the height over the plane for a convex polygon; for a concave one times the
///   sum of the fan's triangles over their signed sum, too
/// - source: [`triangle`]
pub fn polygon(eye: DVec3, polygon: &Polygon) -> Result<f64, ShapeError> {
    let eye = finite("eye", eye)?;
    Ok(fan(polygon.vertices().iter().map(|vertex| *vertex - eye)))
}

fn fan(corners: impl IntoIterator<Item = DVec3>) -> f64 {
    let corners: Vec<DVec3> = corners.into_iter().collect();
    let triangles = corners[1..].windows(2).map(|pair| signed_triangle([corners[0], pair[0], pair[1]]));
    triangles.sum::<f64>().abs()
}

/// Solid angle of a rectangle in any pose: two triangles.
///
/// - `eye`: metres; in the rectangle's plane it sees nothing
/// - returns sr in [0, 2π]
/// - error: relative, a few 2⁻⁵³ times that of the height over the plane
/// - source: [`triangle`]; second witness: signed sums of [`rectangle_over_corner`]
pub fn rectangle(eye: DVec3, rectangle: &Rectangle) -> Result<f64, ShapeError> {
    let eye = finite("eye", eye)?;
    Ok(fan(rectangle.corners().map(|corner| corner - eye)))
}

/// Solid angle of a rectangle whose one corner is the foot of the eye.
///
/// ```text
/// tan Ω = a b / ( h √(h² + a² + b²) )
/// ```
///
/// - `side_u` a, `side_v` b, `height` h: metres, finite, > 0
/// - returns sr in (0, π/2)
/// - error: relative, below 8 · 2⁻⁵³
/// - source: integral of h/(h² + x² + y²)^{3/2} over the rectangle
pub fn rectangle_over_corner(side_u: f64, side_v: f64, height: f64) -> Result<f64, ShapeError> {
    let (a, b, h) = (positive("side_u", side_u)?, positive("side_v", side_v)?, positive("height", height)?);
    let (short, long) = (a.min(b), a.max(b));
    // Divided by the longer side, so that no product overflows.
    Ok(short.atan2(h * (h / long).hypot((short / long).hypot(1.0))))
}

/// Solid angle of a disk in any pose.
///
/// On the axis, at the height h over a disk of radius a, with S = √(h² + a²): `Ω = 2π a²/(S (S + h))`.
///
/// Off the axis the disk fills an elliptic cone. With r₀ the distance from the axis, S₁ and S₂ = √(h² + (r₀ ∓ a)²) the
/// nearest and the farthest distance to the rim and E = h² + r₀² − a², the cone's semi-axes at unit distance are
///
/// ```text
/// A = Λ/(a h), B = √Λ/h,    Λ = (S₁S₂ − E)/2 = 2 a² h²/(S₁S₂ + E)
/// ```
///
/// Around the cone's axis, Ω = ∫ (1 − cos ϑ(φ)) dφ; the substitution tan φ = (B/A) tan ψ, then cot ψ = eᵘ, leaves
///
/// ```text
/// Ω = 2 A B ∫ du / ( cosh u · s (1 + s) ),   s² = 1 + (A² eᵘ + B² e⁻ᵘ)/(2 cosh u),   over all u
/// ```
///
/// All terms are positive, and the integrand is analytic for |Im u| < π/2 whatever A and B are: the trapezoidal sum of step
/// 1/4 is off by no more than e^{−4π²} ≈ 10⁻¹⁷ of it. (The form with elliptic integrals, Paxton 1959, is exact too but
/// subtracts near-equal numbers when Ω is small.)
///
/// - `eye`: metres; in the disk's plane it sees nothing
/// - returns sr in [0, 2π]
/// - error: relative, a few 2⁻⁵³ times that of the height over the plane and of the distance to the rim
/// - source: derived above; second witness: Paxton, Rev. Sci. Instrum. 30, 1959, with Carlson's integrals
pub fn disk(eye: DVec3, disk: &Disk) -> Result<f64, ShapeError> {
    let across = disk.center() - finite("eye", eye)?;
    let along = across.dot(disk.normal());
    // Lengths in units of the radius: nothing overflows.
    let height = (along / disk.radius()).abs();
    let offset = (across - disk.normal() * along).length() / disk.radius();
    if height == 0.0 {
        return Ok(0.0);
    }
    if offset == 0.0 {
        let slant = height.hypot(1.0);
        return Ok(2.0 * PI / slant / (slant + height));
    }
    let product = height.hypot(offset - 1.0) * height.hypot(offset + 1.0);
    let excess = height * height + (offset - 1.0) * (offset + 1.0);
    let lambda = if excess > 0.0 { 2.0 * height * (height / (product + excess)) } else { 0.5 * (product - excess) };
    Ok(elliptic_cone(lambda / height, lambda.sqrt() / height))
}

/// Step of the trapezoidal sum.
const STEP: f64 = 0.25;
/// Beyond this on either side of its middle, the integrand is below e^{−38} ≈ 3·10⁻¹⁷ of its largest value.
const REACH: f64 = 38.0;

/// Solid angle of an elliptic cone whose semi-axes at unit distance are `a` and `b`.
fn elliptic_cone(a: f64, b: f64) -> f64 {
    // The integrand leaves its plateau on either side of u = 0 and of this.
    let shoulder = b.hypot(1.0).ln() - a.hypot(1.0).ln();
    let (low, high) = (shoulder.min(0.0) - REACH, shoulder.max(0.0) + REACH);
    let steps = ((high - low) / STEP).ceil();
    let term = |i: f64| {
        let u = low + STEP * i;
        // e^{−|u|}, so that neither exponential overflows.
        let small = (-u.abs()).exp();
        let twice_cosh_scaled = 1.0 + small * small;
        let (up, down) = if u > 0.0 { (1.0, small * small) } else { (small * small, 1.0) };
        let s = 1.0_f64.hypot((a * a * up + b * b * down).sqrt() / twice_cosh_scaled.sqrt());
        (a / s) * (b / (1.0 + s)) * (2.0 * small / twice_cosh_scaled)
    };
    2.0 * STEP * (0..=steps as u32).map(|i| term(f64::from(i))).sum::<f64>()
}

/// Solid angle of a sphere.
///
/// With s = R/d the sine of its half-angle: `Ω = 2π (1 − √(1 − s²)) = 2π s²/(1 + √(1 − s²))`.
///
/// - `eye`: metres; inside the sphere or on it everything is sphere on one side or on all: 4π, and 2π on the surface
/// - returns sr in [0, 4π]
/// - error: relative, a few 2⁻⁵³ outside, times that of the distance from the surface where that is small
/// - source: area of a spherical cap
pub fn sphere(eye: DVec3, sphere: &Sphere) -> Result<f64, ShapeError> {
    let distance = (sphere.center() - finite("eye", eye)?).length();
    let s = sphere.radius() / distance;
    if s > 1.0 || distance == 0.0 {
        return Ok(4.0 * PI);
    }
    let q = ((distance - sphere.radius()) / distance * (1.0 + s)).sqrt();
    Ok(2.0 * PI * s * s / (1.0 + q))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    /// Carlson's R_F by duplication (Numer. Algorithms 10, 1995, algorithm 1), to 10⁻¹⁵.
    fn carlson_rf(mut x: f64, mut y: f64, mut z: f64) -> f64 {
        loop {
            let mean = (x + y + z) / 3.0;
            let (dx, dy, dz) = (1.0 - x / mean, 1.0 - y / mean, 1.0 - z / mean);
            if dx.abs().max(dy.abs()).max(dz.abs()) < 1e-3 {
                let (e2, e3) = (dx * dy - dz * dz, dx * dy * dz);
                return (1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - 3.0 * e2 * e3 / 44.0) / mean.sqrt();
            }
            let lambda = (x * y).sqrt() + (y * z).sqrt() + (z * x).sqrt();
            (x, y, z) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
        }
    }

    /// R_C(x, y) = R_F(x, y, y).
    fn carlson_rc(x: f64, y: f64) -> f64 {
        carlson_rf(x, y, y)
    }

    /// Carlson's R_J by duplication (the same paper, algorithm 3).
    fn carlson_rj(mut x: f64, mut y: f64, mut z: f64, mut p: f64) -> f64 {
        let (mut sum, mut share) = (0.0, 1.0);
        loop {
            let mean = (x + y + z + 2.0 * p) / 5.0;
            let (dx, dy, dz, dp) = (1.0 - x / mean, 1.0 - y / mean, 1.0 - z / mean, 1.0 - p / mean);
            if dx.abs().max(dy.abs()).max(dz.abs()).max(dp.abs()) < 1e-3 {
                let product = dx * dy * dz;
                let e2 = dx * dy + dx * dz + dy * dz - 3.0 * dp * dp;
                let e3 = product + 2.0 * e2 * dp + 4.0 * dp * dp * dp;
                let e4 = (2.0 * product + e2 * dp + 3.0 * dp * dp * dp) * dp;
                let e5 = product * dp * dp;
                let series =
                    1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0 - 3.0 * e4 / 22.0 - 9.0 * e2 * e3 / 52.0
                        + 3.0 * e5 / 26.0;
                return share * series / (mean * mean.sqrt()) + 6.0 * sum;
            }
            let (rx, ry, rz, rp) = (x.sqrt(), y.sqrt(), z.sqrt(), p.sqrt());
            let lambda = rx * ry + ry * rz + rz * rx;
            let d = (rp + rx) * (rp + ry) * (rp + rz);
            let e = (p - x) * (p - y) * (p - z) / (d * d);
            sum += share / d * carlson_rc(1.0, 1.0 + e);
            share *= 0.25;
            (x, y, z, p) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda), 0.25 * (p + lambda));
        }
    }

    /// Paxton's form, and how many times larger its terms are than their sum.
    fn paxton(r0: f64, h: f64, a: f64) -> (f64, f64) {
        let far = h * h + (r0 + a) * (r0 + a);
        let alpha = 4.0 * a * r0 / ((r0 + a) * (r0 + a));
        let (complement, parameter) = ((h * h + (r0 - a) * (r0 - a)) / far, ((r0 - a) / (r0 + a)).powi(2));
        let k = carlson_rf(0.0, complement, 1.0);
        let pi = k + alpha / 3.0 * carlson_rj(0.0, complement, 1.0, parameter);
        let turn = if r0 < a { 2.0 * PI } else { 0.0 };
        let scale = 2.0 * h / far.sqrt();
        let (third, first) = (scale * (r0 - a) / (r0 + a) * pi, scale * k);
        let omega = turn + third - first;
        (omega, (turn + third.abs() + first) / omega)
    }

    fn level_disk(r0: f64, h: f64, a: f64) -> f64 {
        disk(DVec3::ZERO, &Disk::new(DVec3::new(r0, 0.0, h), DVec3::Z, a).unwrap()).unwrap()
    }

    #[test]
    fn the_duplication_meets_known_integrals() {
        // Carlson 1995, section 3.
        assert_relative_eq!(carlson_rf(1.0, 2.0, 0.0), 1.311_028_777_146_06, max_relative = 1e-14);
        assert_relative_eq!(carlson_rj(0.0, 1.0, 2.0, 3.0), 0.776_886_237_785_82, max_relative = 1e-13);
    }

    proptest! {
        #[test]
        fn a_disk_agrees_with_its_elliptic_integrals(r0 in 0.01..4.0, h in 0.01..4.0, a in 0.1..4.0) {
            let past_rim: f64 = r0 - a;
            prop_assume!(past_rim.abs() > 1e-3);
            let (omega, lost) = paxton(r0, h, a);
            assert_relative_eq!(level_disk(r0, h, a), omega, max_relative = 1e-14 * lost);
        }

        /// A polygon of many sides in a disk, in any pose: the areas differ by (2π/n)²/6 of themselves.
        #[test]
        fn a_many_sided_polygon_tends_to_the_disk(
            x in -2.0..2.0, y in -2.0..2.0, z in 0.5..2.0, tilt in (-1.0..1.0, -1.0..1.0),
        ) {
            let round = Disk::new(DVec3::new(x, y, z), DVec3::new(tilt.0, tilt.1, 1.0), 0.4).unwrap();
            let frame = crate::geometry::Frame::around(round.normal());
            let n = 1000;
            let corner = |i: i32| {
                let (sin, cos) = (2.0 * PI * f64::from(i) / f64::from(n)).sin_cos();
                round.center() + (frame.tangent * cos + frame.bitangent * sin) * round.radius()
            };
            let outline = Polygon::new((0..n).map(corner).collect()).unwrap();
            let (whole, inner) = (disk(DVec3::ZERO, &round).unwrap(), polygon(DVec3::ZERO, &outline).unwrap());
            prop_assert!(inner <= whole * (1.0 + 1e-12) && inner > whole * (1.0 - 2e-5 - 1e-12), "{inner} {whole}");
        }

        #[test]
        fn a_rectangle_is_the_signed_sum_of_four_over_corners(
            u in (-2.0..2.0, 0.1..2.0), v in (-2.0..2.0, 0.1..2.0), h in 0.1..2.0,
        ) {
            let ((u0, du), (v0, dv)) = (u, v);
            let center = DVec3::new(u0 + 0.5 * du, v0 + 0.5 * dv, h);
            let shape = Rectangle::new(center, DVec3::X * du, DVec3::Y * dv).unwrap();
            let corner = |x: f64, y: f64| {
                let sign = x.signum() * y.signum();
                if x * y == 0.0 { 0.0 } else { sign * rectangle_over_corner(x.abs(), y.abs(), h).unwrap() }
            };
            let (u1, v1) = (u0 + du, v0 + dv);
            let sum = corner(u1, v1) - corner(u0, v1) - corner(u1, v0) + corner(u0, v0);
            assert_abs_diff_eq!(rectangle(DVec3::ZERO, &shape).unwrap(), sum, epsilon = 4e-15);
            let outline = Polygon::new(shape.corners().to_vec()).unwrap();
            assert_relative_eq!(
                polygon(DVec3::ZERO, &outline).unwrap(), rectangle(DVec3::ZERO, &shape).unwrap(), max_relative = 1e-14
            );
        }
    }

    /// Ω → A cosθ/r², whatever is seen: also where closed forms of other shapes have lost all digits.
    #[test]
    fn far_shapes_are_their_foreshortened_area() {
        let eye = DVec3::ZERO;
        for size in [1e-3, 1e-6, 1e-9] {
            for direction in [DVec3::new(0.3, 0.2, 1.0), DVec3::new(5.0, 0.0, 1.0), DVec3::Z] {
                let (r2, cosine) = (direction.length_squared(), direction.z / direction.length());
                let allowed = 4.0 * size + 1e-14;
                let round = Disk::new(direction, DVec3::Z, size).unwrap();
                let square = Rectangle::new(direction, DVec3::X * size, DVec3::Y * size).unwrap();
                let ball = Sphere::new(direction, size).unwrap();
                assert_relative_eq!(
                    disk(eye, &round).unwrap(),
                    PI * size * size * cosine / r2,
                    max_relative = allowed
                );
                assert_relative_eq!(
                    rectangle(eye, &square).unwrap(),
                    size * size * cosine / r2,
                    max_relative = allowed
                );
                assert_relative_eq!(sphere(eye, &ball).unwrap(), PI * size * size / r2, max_relative = allowed);
            }
        }
    }

    /// Far outside, just outside and under the rim, at heights from huge to nothing: the two limits of the cone.
    #[test]
    fn flat_and_narrow_cones_keep_their_digits() {
        // Height → 0 under the disk: half of all directions. Beside it: Ω/h → ∫ dA/r³.
        assert_relative_eq!(level_disk(0.5, 1e-12, 1.0), 2.0 * PI, max_relative = 1e-11);
        let (near, nearer) = (level_disk(2.0, 1e-6, 1.0), level_disk(2.0, 1e-9, 1.0));
        assert_relative_eq!(near / 1e-6, nearer / 1e-9, max_relative = 1e-11);
        // Under the rim: half of the half.
        assert_relative_eq!(level_disk(1.0, 1e-9, 1.0), PI, max_relative = 1e-7);
        // No jump where the axis is left.
        assert_relative_eq!(level_disk(1e-9, 0.7, 1.0), level_disk(0.0, 0.7, 1.0), max_relative = 1e-14);
        for h in [1e-150, 1e150] {
            assert!((0.0..=2.0 * PI).contains(&level_disk(0.5, h, 1.0)));
            assert!((0.0..=2.0 * PI).contains(&level_disk(2.0, h, 1.0)));
        }
    }

    #[test]
    fn an_eye_in_the_plane_sees_nothing_and_one_inside_everything() {
        let square = Rectangle::new(DVec3::X * 3.0, DVec3::X, DVec3::Y).unwrap();
        assert_eq!(rectangle(DVec3::ZERO, &square).unwrap(), 0.0);
        assert_eq!(level_disk(3.0, 0.0, 1.0), 0.0);
        let ball = Sphere::new(DVec3::ZERO, 2.0).unwrap();
        for inside in [DVec3::ZERO, DVec3::X] {
            assert_eq!(sphere(inside, &ball).unwrap(), 4.0 * PI);
        }
        assert_eq!(sphere(DVec3::X * 2.0, &ball).unwrap(), 2.0 * PI);
    }

    #[test]
    fn what_is_no_number_is_refused() {
        let ball = Sphere::new(DVec3::ZERO, 2.0).unwrap();
        let nowhere = DVec3::new(0.0, f64::NAN, 0.0);
        assert!(matches!(sphere(nowhere, &ball), Err(ShapeError::NotFinite { field: "eye", .. })));
        assert!(triangle(DVec3::ZERO, [DVec3::X, DVec3::Y, nowhere]).is_err());
        assert!(matches!(
            rectangle_over_corner(1.0, -1.0, 1.0),
            Err(ShapeError::NotPositive { field: "side_v", .. })
        ));
    }
}
