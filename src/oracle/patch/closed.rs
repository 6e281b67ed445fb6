//! Patch-to-patch form factors that have a closed form, in forms that keep their digits.

use std::f64::consts::PI;

use super::PatchError;
use crate::radiometry::FormFactor;

/// The lengths of a pair in one unit, so that nothing overflows: the unit is the last one.
fn ratios<const N: usize>(names: [&'static str; N], lengths: [f64; N]) -> Result<[f64; N], PatchError> {
    for (field, said) in names.into_iter().zip(lengths) {
        if !(said.is_finite() && said > 0.0) {
            return Err(PatchError::Length { field, said });
        }
    }
    let unit = lengths[N - 1];
    let ratios = lengths.map(|length| length / unit);
    let (low, high) = ratios.iter().fold((1.0_f64, 1.0_f64), |(low, high), r| (low.min(*r), high.max(*r)));
    let ratio = high / low;
    if ratio <= PatchError::MOST_UNEVEN { Ok(ratios) } else { Err(PatchError::TooUneven { ratio }) }
}

/// Form factor from a disk to a parallel coaxial disk that faces it.
///
/// With radii r₁ and r₂ at the distance h, by integration of the ring factor over the first disk:
///
/// ```text
/// F₁₂ = 2 r₂² / ( h² + r₁² + r₂² + √(h² + (r₁ − r₂)²) √(h² + (r₁ + r₂)²) )
/// ```
///
/// The textbook form, a difference of this sum and this product, loses all digits for small or far disks.
///
/// - `radius_from` r₁, `radius_to` r₂, `gap` h: metres, finite, > 0
/// - returns a pure number in (0, 1); it leaves the disk of `radius_from`
/// - error: relative, below 4 · 2⁻⁵³
/// - source: Howell, *A Catalog of Radiation Heat Transfer Configuration Factors*, C-41; second witness:
///   `disks_are_the_average_of_their_points`
///
/// ```
/// let unit = etendue::oracle::patch::disk_to_disk(1.0, 1.0, 1.0)?;
/// assert!((unit.ratio() - (3.0 - 5.0_f64.sqrt()) / 2.0).abs() < 1e-15);
/// # Ok::<(), etendue::oracle::patch::PatchError>(())
/// ```
pub fn disk_to_disk(radius_from: f64, radius_to: f64, gap: f64) -> Result<FormFactor, PatchError> {
    let [r1, r2, h] = ratios(["radius_from", "radius_to", "gap"], [radius_from, radius_to, gap])?;
    let product = h.hypot(r1 - r2) * h.hypot(r1 + r2);
    Ok(FormFactor::new(2.0 * r2 * r2 / (h * h + r1 * r1 + r2 * r2 + product)))
}

/// Form factor from a rectangle to an equal one that lies straight opposite.
///
/// With X = a/c, Y = b/c, p = √(1 + X²), q = √(1 + Y²):
///
/// ```text
/// F = 2/(π X Y) { ½ ln(1 + X²Y²/(1 + X² + Y²)) + X g(X, Y, q) + Y g(Y, X, p) },
/// g(X, Y, q) = q atan(X/q) − atan X = k atan(X/q) − atan2(k, q/X + X),   k = q − 1 = Y²/(q + 1)
/// ```
///
/// - `side_u` a, `side_v` b, `gap` c: metres, finite, > 0
/// - returns a pure number in (0, 1)
/// - error: relative, below 16 · 2⁻⁵³ (1.3·10⁻¹⁵ was the largest of 30,000 random triples with ratios to 10⁶, against 80
///   digits)
/// - source: Hamilton & Morgan, NACA TN 2836, 1952; Howell's catalogue C-11. Rewritten without the differences
pub fn rectangle_to_opposite_rectangle(side_u: f64, side_v: f64, gap: f64) -> Result<FormFactor, PatchError> {
    let [x, y, _] = ratios(["side_u", "side_v", "gap"], [side_u, side_v, gap])?;
    let (p, q) = (x.hypot(1.0), y.hypot(1.0));
    let g = |x: f64, y: f64, q: f64| {
        let k = y * (y / (q + 1.0));
        k * (x / q).atan() - k.atan2(q / x + x)
    };
    let share = x * (y / p.hypot(y));
    let braces = 0.5 * (share * share).ln_1p() + x * g(x, y, q) + y * g(y, x, p);
    Ok(FormFactor::new(2.0 / (PI * x * y) * braces))
}

/// Form factor from a rectangle to another that stands on one of its edges at a right angle.
///
/// The rectangles share an edge of length l; the one that light leaves reaches w away from it, the other h. With H = h/l,
/// W = w/l, p = √(H² + W²), s and b the smaller and the larger of H and W, k = p − b = s²/(p + b), T = 1 + H² + W²:
///
/// ```text
/// F = 1/(π W) { s atan(1/s) − k atan(1/p) + b atan2(k, 1 + p b)
///               + ¼ [ ln(1 + W²H²/T) − W² ln(1 + H²/(W²T)) − H² ln(1 + W²/(H²T)) ] }
/// ```
///
/// - `width_from` w, `width_to` h, `edge` l: metres, finite, > 0
/// - returns a pure number in (0, ½)
/// - error: relative, below 8 · 2⁻⁵³ (6·10⁻¹⁶ was the largest of 30,000 random triples with ratios to 10⁶, against 80
///   digits)
/// - source: Hamilton & Morgan, NACA TN 2836, 1952; Howell's catalogue C-14. Rewritten without the differences
pub fn rectangle_to_adjoining_rectangle(width_from: f64, width_to: f64, edge: f64) -> Result<FormFactor, PatchError> {
    let [w, h, _] = ratios(["width_from", "width_to", "edge"], [width_from, width_to, edge])?;
    let (s, b) = (h.min(w), h.max(w));
    let p = h.hypot(w);
    let k = s * (s / (p + b));
    let t = 1.0 + h * h + w * w;
    let (w2, h2) = (w * w, h * h);
    let angles = s * (1.0 / s).atan() - k * (1.0 / p).atan() + b * k.atan2(1.0 + p * b);
    let logarithms = (w2 * (h2 / t)).ln_1p() - w2 * (h2 / w2 / t).ln_1p() - h2 * (w2 / h2 / t).ln_1p();
    Ok(FormFactor::new((angles + 0.25 * logarithms) / (PI * w)))
}

/// Form factor from any patch on the inside of a sphere to any other patch on it, or to itself.
///
/// Two elements at the distance r see each other at equal angles of cosine r/(2R), so that
/// cosθ₁ cosθ₂/(π r²) = 1/(4πR²) wherever they are: `F = A₂/(4πR²)`.
///
/// - `area_to` A₂: square metres, measured on the sphere, at most all of it; `radius` R: metres; finite, > 0
/// - returns a pure number in (0, 1]
/// - error: relative, below 4 · 2⁻⁵³
/// - source: the line above
pub fn patch_to_patch_inside_sphere(area_to: f64, radius: f64) -> Result<FormFactor, PatchError> {
    for (field, said) in [("area_to", area_to), ("radius", radius)] {
        if !(said.is_finite() && said > 0.0) {
            return Err(PatchError::Length { field, said });
        }
    }
    let share = area_to / radius / radius / (4.0 * PI);
    // An area that is all of the sphere may be rounded up.
    if share > 1.0 + 4.0 * f64::EPSILON {
        return Err(PatchError::LargerThanSphere { share });
    }
    Ok(FormFactor::new(share.min(1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn disks(from: f64, to: f64, gap: f64) -> f64 {
        disk_to_disk(from, to, gap).unwrap().ratio()
    }
    fn opposite(u: f64, v: f64, gap: f64) -> f64 {
        rectangle_to_opposite_rectangle(u, v, gap).unwrap().ratio()
    }
    fn adjoining(from: f64, to: f64, edge: f64) -> f64 {
        rectangle_to_adjoining_rectangle(from, to, edge).unwrap().ratio()
    }
    fn length() -> impl Strategy<Value = f64> {
        (-10.0..10.0).prop_map(f64::exp2)
    }

    proptest! {
        #[test]
        fn what_leaves_by_area_arrives_by_area(a in length(), b in length(), c in length()) {
            assert_relative_eq!(a * a * disks(a, b, c), b * b * disks(b, a, c), max_relative = 2e-15);
            assert_relative_eq!(a * adjoining(a, b, c), b * adjoining(b, a, c), max_relative = 3e-15);
            assert_relative_eq!(opposite(a, b, c), opposite(b, a, c), max_relative = 4e-15);
        }

        /// From the floor of a box: its ceiling and four walls are all there is.
        #[test]
        fn the_faces_of_a_box_see_each_other_and_nothing_else(a in length(), b in length(), c in length()) {
            for (a, b, c) in [(a, b, c), (b, c, a), (c, a, b)] {
                let seen = opposite(a, b, c) + 2.0 * adjoining(a, c, b) + 2.0 * adjoining(b, c, a);
                assert_relative_eq!(seen, 1.0, max_relative = 5e-15);
            }
        }

        /// The upper part of a wall is the wall less its lower part; by reciprocity and a cut floor the same number.
        #[test]
        fn a_wall_is_the_sum_of_its_strips(w in 0.2..5.0, h in 0.2..5.0, l in 0.2..5.0, cut in 0.1..0.9) {
            let (low, near) = (cut * h, cut * w);
            let upper = adjoining(w, h, l) - adjoining(w, low, l);
            // F from the far floor strip to the upper wall, by A F sums over both cuts.
            let exchange = |w: f64, h: f64| w * adjoining(w, h, l);
            let far_upper = exchange(w, h) - exchange(near, h) - exchange(w, low) + exchange(near, low);
            let near_upper = exchange(near, h) - exchange(near, low);
            prop_assert!(upper > 0.0 && far_upper > 0.0 && near_upper > 0.0);
            assert_relative_eq!(w * upper, far_upper + near_upper, max_relative = 1e-12);
            // Reciprocity of the strips: seen from the wall, the far floor is the floor less the near floor.
            let from_wall = h * (adjoining(h, w, l) - adjoining(h, near, l));
            let far_lower = exchange(w, low) - exchange(near, low);
            assert_relative_eq!(from_wall, far_upper + far_lower, max_relative = 1e-12);
        }
    }

    /// F₁₂ → A₂ cosθ₁ cosθ₂/(π r²) with an error of the order of (size/r)².
    #[test]
    fn far_patches_are_elements() {
        for size in [1e-2, 1e-3, 1e-5, 1e-8] {
            let allowed = 2.0 * size * size + 2e-15;
            assert_relative_eq!(disks(size, size, 1.0), size * size, max_relative = allowed);
            assert_relative_eq!(opposite(size, size, 1.0), size * size / PI, max_relative = allowed);
        }
    }

    #[test]
    fn touching_patches_see_only_each_other() {
        for gap in [1e-3, 1e-6, 1e-12] {
            assert!((1.0 - disks(1.0, 1.0, gap) - gap).abs() < gap * gap + f64::EPSILON);
            assert!((1.0 - opposite(1.0, 1.0, gap)) < 2.0 * gap);
        }
        // An endless floor's edge strip sees half a hemisphere of wall.
        assert_relative_eq!(adjoining(1e-9, 1.0, 1e9), 0.5, max_relative = 1e-8);
    }

    /// F = A₂/(4πR²) is what two caps' closed forms say: disks over the same rims exchange what the caps do.
    #[test]
    fn inside_a_sphere_only_the_area_counts() {
        let (radius, near, far) = (2.0_f64, 0.7_f64, 1.1_f64);
        let cap = |half_angle: f64| 4.0 * PI * radius * radius * (0.5 * half_angle).sin().powi(2);
        let by_area = patch_to_patch_inside_sphere(cap(far), radius).unwrap().ratio() * cap(near);
        // All light between the caps passes both flat lids.
        let lid = |half_angle: f64| radius * half_angle.sin();
        let gap = radius * (near.cos() + far.cos());
        let by_lids = disks(lid(near), lid(far), gap) * PI * lid(near) * lid(near);
        assert_relative_eq!(by_area, by_lids, max_relative = 1e-14);
        assert_eq!(patch_to_patch_inside_sphere(cap(PI), radius).unwrap().ratio(), 1.0);
        assert!(patch_to_patch_inside_sphere(60.0, radius).is_err());
    }

    #[test]
    fn what_is_no_length_is_refused() {
        for said in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(disk_to_disk(1.0, said, 1.0), Err(PatchError::Length { field: "radius_to", .. })));
            assert!(rectangle_to_opposite_rectangle(1.0, 1.0, said).is_err());
            assert!(rectangle_to_adjoining_rectangle(said, 1.0, 1.0).is_err());
            assert!(patch_to_patch_inside_sphere(1.0, said).is_err());
        }
        assert!(matches!(disk_to_disk(1e-40, 1.0, 1e40), Err(PatchError::TooUneven { .. })));
        for scale in [1e-300, 1e300] {
            assert_relative_eq!(disks(scale, scale, scale), disks(1.0, 1.0, 1.0), max_relative = 1e-15);
        }
    }
}
