//! Smooth faces between two media: where a ray goes on, and how much of it.

use crate::geometry::DVec3;

/// What a face does to a ray.
#[derive(Clone, Copy, Debug)]
pub struct Interface {
    /// Reflected share of s light (field across the plane of incidence), in [0, 1].
    pub reflectance_s: f64,
    /// Reflected share of p light (field in the plane of incidence), in [0, 1].
    pub reflectance_p: f64,
    /// Unit vector of the refracted ray; `None` where everything is reflected.
    pub refracted: Option<DVec3>,
}

impl Interface {
    /// Snell's law in vectors, and Fresnel's power shares: with c the cosine of arrival, η = nᵢ/nₜ and
    /// t = √(1 − η² (1 − c²)),
    ///
    /// ```text
    /// refracted = η d + (η c − t) n
    /// R_s = ((nᵢ c − nₜ t)/(nᵢ c + nₜ t))²,   R_p = ((nₜ c − nᵢ t)/(nₜ c + nᵢ t))²
    /// ```
    ///
    /// Where the radicand is not positive nothing is refracted (total reflection).
    ///
    /// - `direction` d: of the ray, unit vector; `normal` n: unit vector on the side that the ray comes from
    /// - `from`, `into`: indices of refraction of this side and the other, finite, > 0
    /// - error: shares absolute, some 2⁻⁵³; directions likewise, over t near total reflection
    /// - source: Fresnel's equations; Born & Wolf, *Principles of Optics*, 1.5.2
    #[inline(always)]
    pub fn meet(direction: DVec3, normal: DVec3, from: f64, into: f64) -> Interface {
        Media::new(from, into).meet(direction, normal)
    }
}

/// Two media that touch, in the order in which light comes through them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Media {
    from: f64,
    into: f64,
    /// nᵢ/nₜ, and its square.
    eta: f64,
    eta_squared: f64,
}

impl Media {
    pub fn new(from: f64, into: f64) -> Media {
        let eta = from / into;
        Media { from, into, eta, eta_squared: eta * eta }
    }

    /// [`Interface::meet`], for many rays.
    #[inline(always)]
    pub fn meet(&self, direction: DVec3, normal: DVec3) -> Interface {
        let Media { from, into, eta, eta_squared } = *self;
        if from == into {
            return Interface { reflectance_s: 0.0, reflectance_p: 0.0, refracted: Some(direction) };
        }
        // Rounding may put a grazing ray behind the face.
        let c = (-direction.dot(normal)).clamp(0.0, 1.0);
        let radicand = 1.0 - eta_squared * ((1.0 - c) * (1.0 + c));
        if radicand <= 0.0 {
            return Interface { reflectance_s: 1.0, reflectance_p: 1.0, refracted: None };
        }
        let t = radicand.sqrt();
        let s = (from * c - into * t) / (from * c + into * t);
        let p = (into * c - from * t) / (into * c + from * t);
        let refracted = (direction * eta + normal * (eta * c - t)).normalize();
        Interface { reflectance_s: s * s, reflectance_p: p * p, refracted: Some(refracted) }
    }
}

/// The mirrored direction.
///
/// - `direction`, `normal`: unit vectors, the normal on either side
#[inline(always)]
pub fn reflected(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction - normal * (2.0 * direction.dot(normal))).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    fn arriving(cosine: f64) -> DVec3 {
        DVec3::new(((1.0 - cosine) * (1.0 + cosine)).sqrt(), 0.0, -cosine)
    }

    proptest! {
        #[test]
        fn snells_law_holds_and_the_plane_is_kept(cosine in 0.001..1.0, from in 1.0..2.0, into in 1.0..2.0) {
            let d = arriving(cosine);
            let met = Interface::meet(d, DVec3::Z, from, into);
            match met.refracted {
                Some(out) => {
                    assert_abs_diff_eq!(from * d.x, into * out.x, epsilon = 1e-15);
                    assert_eq!(out.y, 0.0);
                    assert!(out.z <= 0.0);
                    // Back along the same path the same shares are reflected.
                    let back = Interface::meet(-out, DVec3::NEG_Z, into, from);
                    assert_abs_diff_eq!(back.reflectance_s, met.reflectance_s, epsilon = 1e-11);
                    assert_abs_diff_eq!(back.reflectance_p, met.reflectance_p, epsilon = 1e-11);
                    assert!((back.refracted.unwrap() + d).length() < 1e-11);
                }
                None => {
                    assert!(from * d.x >= into * (1.0 - 1e-15));
                    assert_eq!((met.reflectance_s, met.reflectance_p), (1.0, 1.0));
                }
            }
            let mirrored = reflected(d, DVec3::Z);
            assert_abs_diff_eq!(mirrored.z, cosine, epsilon = 1e-15);
            assert_abs_diff_eq!(mirrored.x, d.x, epsilon = 1e-15);
        }
    }

    /// Rows of the certified table `fresnel`: index, cosine, R_s, R_p.
    #[test]
    fn shares_are_the_tables() {
        for (n, c, s, p) in [
            (1.5, 1.0, 0.04, 0.04),
            (1.5, 0.875, 0.056_350_251_416_073_85, 0.026_252_570_530_787_14),
            (1.5, 0.5, 0.176_571_488_082_840_53, 0.001_801_937_521_585_036_2),
            (1.5, 0.75, 0.080_912_119_866_665_4, 0.012_649_374_983_949_454),
        ] {
            let met = Interface::meet(arriving(c), DVec3::Z, 1.0, n);
            assert_relative_eq!(met.reflectance_s, s, max_relative = 1e-13);
            assert_relative_eq!(met.reflectance_p, p, max_relative = 1e-13);
        }
    }

    #[test]
    fn no_contrast_no_bend() {
        let d = arriving(0.3);
        let met = Interface::meet(d, DVec3::Z, 1.3, 1.3);
        assert_eq!((met.reflectance_s, met.reflectance_p, met.refracted), (0.0, 0.0, Some(d)));
    }
}
