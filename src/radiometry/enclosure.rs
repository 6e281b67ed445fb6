//! Light that goes to and fro between diffuse surfaces, where the endless sum has a closed form.

use super::{Albedo, Exitance, Intensity, Irradiance, RadiometryError, Radiosity};
use crate::geometry::positive;

/// The radiosity of a grey sphere's inside when a cap of it emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmittingCap {
    /// Everywhere alike: what is sent back of the light that arrives.
    pub reflected: Radiosity,
    /// Within the cap: emitted and reflected together.
    pub in_cap: Radiosity,
}

/// A sphere whose inside sends back a share ρ of the light, and of which a cap emits.
///
/// Every element sees every other alike (1/(4πR²) per area, wherever it is), so that what arrives is the same everywhere:
/// with the cap's share of the area hc/(2R),
///
/// ```text
/// M̄ = M hc/(2R),   reflected = ρ M̄/(1 − ρ),   in the cap M + reflected
/// ```
///
/// - `radius` R: metres, > 0; `albedo` ρ: in [0, 1); `exitance` M: W/m², ≥ 0; `cap_height` hc: metres, in (0, 2R]
/// - error: relative, below 8 · 2⁻⁵³
/// - source: the geometric series of bounces; table `sphere_interior`
pub fn cap_that_emits_inside_sphere(
    radius: f64,
    albedo: Albedo,
    exitance: Exitance,
    cap_height: f64,
) -> Result<EmittingCap, RadiometryError> {
    let (radius, again) = (positive("radius", radius)?, bounces(albedo)?);
    let exitance = emitted(exitance)?;
    if !(cap_height > 0.0 && cap_height <= 2.0 * radius) {
        return Err(RadiometryError::CapHeight { said: cap_height, radius });
    }
    let mean = exitance.watts_per_square_metre() * (cap_height / radius * 0.5);
    let reflected = Radiosity::new(mean * again);
    Ok(EmittingCap { reflected, in_cap: reflected + exitance })
}

/// The light inside a grey sphere around a point source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitSphere {
    /// Mean over the sphere of what arrives straight from the source.
    pub mean_irradiance: Irradiance,
    /// Everywhere alike: radiosity by light that has met the sphere at least once before. The first bounce,
    /// ρ × the direct irradiance, comes on top and differs from place to place.
    pub after_first_bounce: Radiosity,
}

/// A sphere whose inside sends back a share ρ of the light, around a point source of intensity I anywhere in it.
///
/// All 4πI reach the sphere, so that the mean irradiance is I/R² wherever the source is, and from the second bounce on,
/// light is the same everywhere: `ρ² (I/R²)/(1 − ρ)`.
///
/// - `intensity` I: W/sr, ≥ 0; `offset`: of the source from the centre, metres, in [0, R); `radius` R: metres, > 0;
///   `albedo` ρ: in [0, 1)
/// - error: relative, below 8 · 2⁻⁵³
/// - source: the geometric series of bounces; table `sphere_interior`
pub fn point_source_inside_sphere(
    intensity: Intensity,
    offset: f64,
    radius: f64,
    albedo: Albedo,
) -> Result<LitSphere, RadiometryError> {
    let (radius, again) = (positive("radius", radius)?, bounces(albedo)?);
    let said = intensity.watts_per_steradian();
    if !(said.is_finite() && said >= 0.0) {
        return Err(RadiometryError::Intensity { said });
    }
    if !(offset >= 0.0 && offset < radius) {
        return Err(RadiometryError::OutsideSphere { said: offset, radius });
    }
    let mean = said / radius / radius;
    Ok(LitSphere {
        mean_irradiance: Irradiance::new(mean),
        after_first_bounce: Radiosity::new(mean * albedo.ratio() * again),
    })
}

/// Radiosities of two endless parallel plates that face each other.
///
/// Each sees only the other: B₁ = M₁ + ρ₁ B₂ and B₂ = M₂ + ρ₂ B₁, hence
///
/// ```text
/// B₁ = (M₁ + ρ₁ M₂)/(1 − ρ₁ρ₂),   B₂ = (M₂ + ρ₂ M₁)/(1 − ρ₁ρ₂)
/// ```
///
/// - `exitances` M: W/m², ≥ 0; `albedos` ρ: in [0, 1], not both 1
/// - returns B₁ and B₂
/// - error: relative, below 8 · 2⁻⁵³
/// - source: the two lines above
pub fn parallel_plates(exitances: [Exitance; 2], albedos: [Albedo; 2]) -> Result<[Radiosity; 2], RadiometryError> {
    for exitance in exitances {
        emitted(exitance)?;
    }
    let [r1, r2] = albedos.map(Albedo::ratio);
    for said in [r1, r2] {
        if !(0.0..=1.0).contains(&said) || (r1 == 1.0 && r2 == 1.0) {
            return Err(RadiometryError::Albedo { said });
        }
    }
    let [m1, m2] = exitances.map(Exitance::watts_per_square_metre);
    // 1 − ρ₁ρ₂ without the difference of near-equal numbers.
    let lost = (1.0 - r1) + r1 * (1.0 - r2);
    Ok([Radiosity::new((m1 + r1 * m2) / lost), Radiosity::new((m2 + r2 * m1) / lost)])
}

/// ρ/(1 − ρ): how many times over light is sent back.
fn bounces(albedo: Albedo) -> Result<f64, RadiometryError> {
    match albedo.ratio() {
        said if (0.0..1.0).contains(&said) => Ok(said / (1.0 - said)),
        said => Err(RadiometryError::Albedo { said }),
    }
}

fn emitted(exitance: Exitance) -> Result<Exitance, RadiometryError> {
    match exitance.watts_per_square_metre() {
        said if said.is_finite() && said >= 0.0 => Ok(exitance),
        said => Err(RadiometryError::Exitance { said }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    proptest! {
        /// A furnace: walls that emit what they do not send back glow with radiosity 1, whatever they are.
        #[test]
        fn a_furnace_hides_its_walls(first in 0.0..1.0, second in 0.0..1.0, radius in 0.1..10.0) {
            let emission = |albedo: f64| Exitance::new(1.0 - albedo);
            let albedos = [Albedo::new(first), Albedo::new(second)];
            for b in parallel_plates([emission(first), emission(second)], albedos).unwrap() {
                assert_relative_eq!(b.watts_per_square_metre(), 1.0, max_relative = 1e-14);
            }
            let whole =
                cap_that_emits_inside_sphere(radius, albedos[0], emission(first), 2.0 * radius).unwrap();
            assert_relative_eq!(whole.in_cap.watts_per_square_metre(), 1.0, max_relative = 1e-14);
        }

        /// The closed form is what the bounces add up to.
        #[test]
        fn plates_are_the_sum_of_their_bounces(
            m in (0.0..3.0, 0.0..3.0), first in 0.0..0.8, second in 0.0..0.8,
        ) {
            let (mut one, mut two) = (m.0, m.1);
            for _ in 0..200 {
                (one, two) = (m.0 + first * two, m.1 + second * one);
            }
            let [b1, b2] =
                parallel_plates([Exitance::new(m.0), Exitance::new(m.1)], [Albedo::new(first), Albedo::new(second)])
                    .unwrap();
            assert_relative_eq!(b1.watts_per_square_metre(), one, max_relative = 1e-14);
            assert_relative_eq!(b2.watts_per_square_metre(), two, max_relative = 1e-14);
        }

        /// All power is absorbed in the end: (1 − ρ) of what arrives, over the whole sphere, is what was emitted.
        #[test]
        fn a_sphere_absorbs_what_is_emitted(radius in 0.1..10.0, albedo in 0.01..0.99, share in 0.01..=1.0) {
            let (height, emission) = (2.0 * radius * share, Exitance::new(2.5));
            let cap = cap_that_emits_inside_sphere(radius, Albedo::new(albedo), emission, height).unwrap();
            let arriving = cap.reflected.watts_per_square_metre() / albedo;
            assert_relative_eq!((1.0 - albedo) * arriving, 2.5 * share, max_relative = 1e-13);
        }
    }

    #[test]
    fn what_never_dies_out_is_refused() {
        let (one, m) = (Albedo::new(1.0), Exitance::new(1.0));
        assert!(matches!(parallel_plates([m, m], [one, one]), Err(RadiometryError::Albedo { .. })));
        assert!(parallel_plates([m, m], [one, Albedo::new(0.5)]).is_ok());
        assert!(parallel_plates([m, m], [Albedo::new(f64::NAN), one]).is_err());
        assert!(parallel_plates([Exitance::new(-1.0), m], [one, Albedo::new(0.5)]).is_err());
        assert!(cap_that_emits_inside_sphere(1.0, one, m, 1.0).is_err());
        let half = Albedo::new(0.5);
        for height in [0.0, 2.5, f64::NAN] {
            assert!(matches!(
                cap_that_emits_inside_sphere(1.0, half, m, height),
                Err(RadiometryError::CapHeight { .. })
            ));
        }
        let i = Intensity::new(1.0);
        for offset in [-0.1, 1.0, f64::NAN] {
            assert!(matches!(
                point_source_inside_sphere(i, offset, 1.0, half),
                Err(RadiometryError::OutsideSphere { .. })
            ));
        }
        assert!(point_source_inside_sphere(Intensity::new(f64::NAN), 0.0, 1.0, half).is_err());
    }
}
