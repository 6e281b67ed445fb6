//! Reflection and refraction at a smooth face between two clear media.
//!
//! Powers, not amplitudes: reflected and transmitted shares of the power that arrives add up to one. (Radiance on the far
//! side is larger by the index squared, because the beam is narrower there; power is not.)

use super::RadiometryError;
use crate::number::{Wide, gauss_10};

/// What a smooth face sends back and lets through, for each polarisation: shares of the power that arrives, in [0, 1].
///
/// s: the electric field is perpendicular to the plane of incidence; p: it lies in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fresnel {
    /// Reflected share of s light.
    pub reflectance_s: f64,
    /// Reflected share of p light.
    pub reflectance_p: f64,
    /// Transmitted share of s light.
    pub transmittance_s: f64,
    /// Transmitted share of p light.
    pub transmittance_p: f64,
}

impl Fresnel {
    /// Shares at a face of relative index n = n_t/n_i, for light that arrives at the cosine c.
    ///
    /// With the far side's cosine t, t² = 1 − (1 − c²)/n², and m = n t = √(c² + n² − 1):
    ///
    /// ```text
    /// R_s = ((n² − 1)/(c + m)²)²
    /// R_p = ((n² − 1) (c² (n² + 1) − 1)/(n c + t)²/n²)²
    /// T_s = 4 c m/(c + m)²,   T_p = 4 n c t/(n c + t)²
    /// ```
    ///
    /// R_s is the textbook's ((c − n t)/(c + n t))² with the difference of near-equal numbers multiplied out, and likewise
    /// R_p. Where c² + n² − 1 ≤ 0 everything is reflected.
    ///
    /// - `index` n: finite, > 0, of the far medium relative to the near one; `cosine` c: in [0, 1]
    /// - error: relative, a few 2⁻⁵³ for all four, times 1/(c² + n² − 1) of T near total reflection. R_p keeps its digits up to
    ///   Brewster's angle, for the cosine that is given: its zero is found in twice the precision. (An angle known to 2⁻⁵³ has
    ///   itself an R_p of about 10⁻³² instead of zero.)
    /// - source: Fresnel's equations; table `fresnel`
    ///
    /// ```
    /// let glass = etendue::radiometry::Fresnel::at(1.5, 1.0)?;
    /// assert!((glass.reflectance() - 0.04).abs() < 1e-16);
    /// # Ok::<(), etendue::radiometry::RadiometryError>(())
    /// ```
    pub fn at(index: f64, cosine: f64) -> Result<Fresnel, RadiometryError> {
        let (n, c) = (index, cosine);
        if !(n.is_finite() && n > 0.0) {
            return Err(RadiometryError::Index { said: n });
        }
        if !(0.0..=1.0).contains(&c) {
            return Err(RadiometryError::Cosine { said: c });
        }
        let shares = |reflected: f64| Fresnel {
            reflectance_s: reflected,
            reflectance_p: reflected,
            transmittance_s: 1.0 - reflected,
            transmittance_p: 1.0 - reflected,
        };
        if n == 1.0 {
            return Ok(shares(0.0));
        }
        let contrast = (n - 1.0) * (n + 1.0);
        // Whichever of n² and c² is the small one near total reflection is left as it is.
        let radicand = if n * n < 0.5 { n.mul_add(n, -(1.0 - c) * (1.0 + c)) } else { c.mul_add(c, contrast) };
        if radicand <= 0.0 {
            return Ok(shares(1.0));
        }
        // An index beyond √(f64::MAX) is a mirror but for the grazing p ray, whose products are told by n c alone.
        let m = if n < 1e150 { radicand.sqrt() } else { n };
        let t = m / n;
        let (sum_s, sum_p) = (c + m, n * c + t);
        let amplitude_s = (n - 1.0) / sum_s * ((n + 1.0) / sum_s);
        let amplitude_p =
            if n < 1e75 { contrast / (n * sum_p) * (brewster(n, c) / (n * sum_p)) } else { (n * c - t) / sum_p };
        Ok(Fresnel {
            reflectance_s: amplitude_s * amplitude_s,
            reflectance_p: amplitude_p * amplitude_p,
            transmittance_s: 4.0 * (c / sum_s) * (m / sum_s),
            transmittance_p: 4.0 * (n * c / sum_p) * (t / sum_p),
        })
    }

    /// Of unpolarised light: the mean of both.
    pub fn reflectance(&self) -> f64 {
        0.5 * (self.reflectance_s + self.reflectance_p)
    }
    /// Of unpolarised light: the mean of both.
    ///
    /// What two faces let through is the mean of the products of each polarisation, not the product of these means.
    pub fn transmittance(&self) -> f64 {
        0.5 * (self.transmittance_s + self.transmittance_p)
    }
}

/// c² (n² + 1) − 1 = (c n)² + c² − 1, zero at Brewster's angle: in twice the width.
fn brewster(n: f64, c: f64) -> f64 {
    (Wide::product(c, n).square() + Wide::product(c, c) - Wide::ONE).narrow()
}

/// Mean reflectance of a smooth face for diffuse light from the side of the lower index.
///
/// Weighed by the cosine, R = ∫₀¹ 2 c R(c) dc. With x = e^s, where x = 1 at grazing and x₁ = (n − 1)/(n (n + 1)) at normal
/// incidence, D = 1 + (n² − 1) x/2 and w = (n² + 1) x/(2 D), the amplitudes are rational:
///
/// ```text
/// r_s = w,   r_p = (n² − 1 − 2 n² x)/(n² + 1),   1 − w = (1 − x)/D
/// R = (n² − 1)/8 ∫ (1 − w)(1 + w)(1 + r_p²/w²) w/D ds,   ln x₁ ≤ s ≤ 0
/// ```
///
/// (from c = √(n² − 1) sinh u, for which r_s = e^{−2u}). All terms are positive; the integrand is analytic for |Im s| < π
/// whatever n is, and 10 Gauss points on each piece no longer than 1 leave less than 10⁻²⁰. Walsh's closed form (1926) is a
/// sum of terms that cancel as n nears one.
///
/// - `index` n: of the denser medium relative to the other, 1 ≤ n ≤ 10⁶
/// - returns a pure number in [0, 1)
/// - error: relative, below 10⁻¹⁵
/// - source: derived above; second witness: Walsh 1926, and table `fresnel_diffuse_mean`
pub fn mean_reflectance_from_outside(index: f64) -> Result<f64, RadiometryError> {
    let n = index;
    if !(1.0..=1e6).contains(&n) {
        return Err(RadiometryError::MeanIndex { said: n });
    }
    if n == 1.0 {
        return Ok(0.0);
    }
    let contrast = (n - 1.0) * (n + 1.0);
    let (sum, normal) = (n * n + 1.0, ((n - 1.0) / (n * (n + 1.0))).ln());
    let integrand = |s: f64| {
        let x = s.exp();
        let d = 1.0 + 0.5 * contrast * x;
        let w = 0.5 * sum * x / d;
        let ratio = (contrast - 2.0 * n * n * x) / sum / w;
        -s.exp_m1() / d * (1.0 + w) * (1.0 + ratio * ratio) * w / d
    };
    let pieces = (-normal / LONGEST_PIECE).ceil();
    let half = -0.5 * normal / pieces;
    let piece = |i: u32| {
        let middle = normal + half * f64::from(2 * i + 1);
        gauss_10(middle, half, integrand)
    };
    Ok(contrast / 8.0 * (0..pieces as u32).map(piece).sum::<f64>())
}

/// Mean reflectance of a smooth face for diffuse light from the side of the higher index.
///
/// What crosses outwards is what crosses inwards, narrowed by n²: `1 − R_inside = (1 − R_outside)/n²`, which is written here
/// as `R_inside = (n² − 1 + R_outside)/n²`.
///
/// - `index` n: of the denser medium relative to the other, 1 ≤ n ≤ 10⁶
/// - returns a pure number in [0, 1)
/// - error: relative, below 10⁻¹⁵
/// - source: étendue n² cosθ dω is kept by refraction; table `fresnel_diffuse_mean`
pub fn mean_reflectance_from_inside(index: f64) -> Result<f64, RadiometryError> {
    let outside = mean_reflectance_from_outside(index)?;
    Ok(((index - 1.0) * (index + 1.0) + outside) / (index * index))
}

const LONGEST_PIECE: f64 = 1.0;

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_not_reflected_is_transmitted(n in 0.2..5.0, c in 0.0..=1.0) {
            let face = Fresnel::at(n, c).unwrap();
            assert_abs_diff_eq!(face.reflectance_s + face.transmittance_s, 1.0, epsilon = 1e-14);
            assert_abs_diff_eq!(face.reflectance_p + face.transmittance_p, 1.0, epsilon = 1e-14);
        }

        /// Along the refracted ray backwards the face lets the same share through.
        #[test]
        fn a_ray_and_its_reverse_lose_the_same(n in 1.0..5.0, c in 0.05..=1.0) {
            let t: f64 = 1.0 - (1.0 - c * c) / (n * n);
            let (there, back) = (Fresnel::at(n, c).unwrap(), Fresnel::at(1.0 / n, t.sqrt()).unwrap());
            assert_relative_eq!(there.transmittance_s, back.transmittance_s, max_relative = 1e-12);
            assert_relative_eq!(there.transmittance_p, back.transmittance_p, max_relative = 1e-12);
        }

        #[test]
        fn the_forms_are_the_textbooks(n in 1.05..5.0, c in 0.0..=1.0) {
            let m2: f64 = n * n - 1.0 + c * c;
            let t = m2.sqrt() / n;
            let face = Fresnel::at(n, c).unwrap();
            assert_abs_diff_eq!(face.reflectance_s, ((c - n * t) / (c + n * t)).powi(2), epsilon = 1e-14);
            assert_abs_diff_eq!(face.reflectance_p, ((n * c - t) / (n * c + t)).powi(2), epsilon = 1e-14);
        }

        #[test]
        fn the_mean_is_walshs(n in 1.2..50.0) {
            assert_relative_eq!(mean_reflectance_from_outside(n).unwrap(), walsh(n), max_relative = 2e-12);
        }
    }

    /// Walsh 1926, as handbooks quote it: exact, and a sum of terms that cancel.
    fn walsh(n: f64) -> f64 {
        let (n2, n4) = (n * n, n.powi(4));
        0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
            + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
            - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
            + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln()
    }

    /// At c = 1/2 the zero lies at n = √3, and what is left beside it, c²(n² + 1) − 1 = (n² − 3)/4, is told by n alone.
    #[test]
    fn brewsters_angle_keeps_its_digits() {
        for exponent in [-10, -20, -30, -40, -52] {
            let epsilon = 2.0_f64.powi(exponent);
            let n = 3.0_f64.sqrt() * (1.0 + epsilon);
            let c = 0.5;
            // With the rounding of the square, which is all there is at the last exponent.
            let square = n * n;
            let delta = ((square - 3.0) + n.mul_add(n, -square)) * 0.25;
            let t = (n * n - 0.75).sqrt() / n;
            let wanted = ((n * n - 1.0) * delta / (n * (n * c + t)).powi(2)).powi(2);
            assert_relative_eq!(Fresnel::at(n, c).unwrap().reflectance_p, wanted, max_relative = 1e-14);
        }
    }

    #[test]
    fn beyond_the_critical_angle_all_is_reflected() {
        let critical = (1.0_f64 - 0.64).sqrt();
        for c in [0.0, 0.3, critical - 1e-9] {
            let face = Fresnel::at(0.8, c).unwrap();
            assert_eq!((face.reflectance(), face.transmittance()), (1.0, 0.0));
        }
        assert!(Fresnel::at(0.8, critical + 1e-9).unwrap().reflectance() < 1.0);
    }

    #[test]
    fn no_contrast_no_reflection() {
        for c in [1e-9, 0.5, 1.0] {
            let face = Fresnel::at(1.0, c).unwrap();
            assert_eq!(face.reflectance(), 0.0);
            assert_relative_eq!(face.transmittance(), 1.0, max_relative = 1e-15);
        }
        assert_eq!(mean_reflectance_from_outside(1.0), Ok(0.0));
        // R → (n − 1)² × what the integral tends to: the share of grazing light grows as the contrast falls.
        let (small, smaller) =
            (mean_reflectance_from_outside(1.0 + 1e-6).unwrap(), mean_reflectance_from_outside(1.0 + 1e-8).unwrap());
        assert!(smaller < small && smaller > 0.0 && small < 1e-6);
    }

    /// The mean by brute force: the midpoint rule at 200,000 points.
    #[test]
    fn the_mean_is_the_mean() {
        for n in [1.0001, 1.01, 1.5, 8.0] {
            let points = 200_000;
            let sum: f64 = (0..points)
                .map(|i| {
                    let c = (f64::from(i) + 0.5) / f64::from(points);
                    2.0 * c * Fresnel::at(n, c).unwrap().reflectance()
                })
                .sum();
            let mean = sum / f64::from(points);
            assert_relative_eq!(mean_reflectance_from_outside(n).unwrap(), mean, max_relative = 1e-6);
            // From inside: all that is flatter than the critical cosine, then from there by c = c₀ + (1 − c₀) z², which
            // takes the root away with which R falls there.
            let critical = ((n - 1.0_f64) * (n + 1.0)).sqrt() / n;
            let beyond: f64 = (0..points)
                .map(|i| {
                    let z = (f64::from(i) + 0.5) / f64::from(points);
                    let c = critical + (1.0 - critical) * z * z;
                    2.0 * c * (1.0 - critical) * 2.0 * z * Fresnel::at(1.0 / n, c).unwrap().reflectance()
                })
                .sum();
            let mean = critical * critical + beyond / f64::from(points);
            assert_relative_eq!(mean_reflectance_from_inside(n).unwrap(), mean, max_relative = 1e-6);
        }
    }

    #[test]
    fn what_is_no_face_is_refused() {
        for n in [0.0, -1.5, f64::NAN, f64::INFINITY] {
            assert!(matches!(Fresnel::at(n, 0.5), Err(RadiometryError::Index { .. })));
            assert!(mean_reflectance_from_outside(n).is_err() && mean_reflectance_from_inside(n).is_err());
        }
        for c in [-0.1, 1.1, f64::NAN] {
            assert!(matches!(Fresnel::at(1.5, c), Err(RadiometryError::Cosine { .. })));
        }
        for n in [1e-300, 1e-10, 1e10, 1e100, 1e300] {
            for c in [0.0, 1e-300, 1e-9, 0.5, 1.0] {
                let face = Fresnel::at(n, c).unwrap();
                for share in [face.reflectance_s, face.reflectance_p, face.transmittance_s, face.transmittance_p] {
                    assert!((0.0..=1.0 + 1e-15).contains(&share), "n = {n:e}, c = {c:e}: {face:?}");
                }
            }
        }
    }
}
