//! Two parallel coaxial disks that light each other.

use super::exchange::{Exchange, Facing, Twice, Which, checked};
use super::nodes::composite;
use super::{Bounded, OpticsError, length, place};
use crate::radiometry::{Albedo, Exitance};

/// Two parallel coaxial disks that face each other, both diffuse.
///
/// Radiosity depends on the distance from the axis alone; averaged over the azimuth the kernel is
///
/// ```text
/// K(r, s) ds = 2 h² S s ds/[(h² + (r − s)²)(h² + (r + s)²)]^{3/2},   S = h² + r² + s²
/// B₁(r) = M₁ + ρ₁ ∫ K(r, s) B₂(s) ds,   B₂(r) = M₂ + ρ₂ ∫ K(r, s) B₁(s) ds
/// ```
///
/// (from ∫₀^{2π} dφ/(S − T cos φ)² = 2πS/(S² − T²)^{3/2}). Solved at Gauss's nodes (Nyström's method), on panels no longer than
/// the gap: the kernel is analytic within a gap's length of them, and 20 nodes each leave less than 10⁻²⁰.
#[derive(Clone, Debug)]
pub struct CoaxialDisks {
    radii: [f64; 2],
    solved: Twice<Rings>,
}

#[derive(Clone, Copy, Debug)]
struct Rings {
    gap: f64,
}

impl Facing for Rings {
    type Place = f64;
    fn kernel(&self, r: f64, s: f64) -> f64 {
        let h = self.gap * self.gap;
        let product = (h + (r - s) * (r - s)) * (h + (r + s) * (r + s));
        2.0 * h * (h + r * r + s * s) * s / (product * product.sqrt())
    }
}

impl CoaxialDisks {
    /// Radius over gap up to which the equation is solved.
    pub const LARGEST: f64 = 40.0;

    /// - `gap`: metres, > 0; `radii`: metres, in (0, 40 gaps]; `albedos`: in [0, 1]; `exitances`: W/m², ≥ 0
    pub fn new(
        gap: f64,
        radii: [f64; 2],
        albedos: [Albedo; 2],
        exitances: [Exitance; 2],
    ) -> Result<CoaxialDisks, OpticsError> {
        length("the gap", gap)?;
        for radius in radii {
            length("the disk's radius", radius)?;
            let ratio = radius / gap;
            if ratio > Self::LARGEST {
                return Err(OpticsError::TooClose { ratio, limit: Self::LARGEST });
            }
        }
        let (albedos, exitances) = checked(albedos, exitances)?;
        let solve = |points: usize| {
            let nodes = radii.map(|radius| composite(0.0, radius, (radius / gap).ceil() as usize, points));
            Exchange::new(Rings { gap }, nodes, albedos, exitances)
        };
        Ok(CoaxialDisks { radii, solved: Twice { coarse: solve(15), fine: solve(20) } })
    }

    fn on(&self, which: Which, radius: f64) -> Result<f64, OpticsError> {
        let said = place("the radius", radius)?;
        let largest = match which {
            Which::First => self.radii[0],
            Which::Second => self.radii[1],
        };
        if (0.0..=largest).contains(&said) { Ok(said) } else { Err(OpticsError::Place { field: "the radius", said }) }
    }

    /// Emitted and reflected together, W/m², all bounces counted.
    ///
    /// - `radius`: from the axis, metres, on the disk
    /// - error: `bound`: rounding, and how far 15 and 20 nodes a panel are apart
    /// - source: the equations above; table `interreflection_disks`
    pub fn radiosity(&self, which: Which, radius: f64) -> Result<Bounded, OpticsError> {
        let at = self.on(which, radius)?;
        Ok(self.solved.told(|solved| solved.radiosity(which, at)))
    }

    /// Reflected light alone, W/m², of what has been reflected at most so many times: what a path of limited length can find.
    pub fn reflected_after(&self, which: Which, radius: f64, reflections: u32) -> Result<Bounded, OpticsError> {
        let at = self.on(which, radius)?;
        Ok(self.solved.told(|solved| solved.reflected_after(which, at, reflections)))
    }

    /// What arrives, W/m², all bounces counted.
    pub fn irradiance(&self, which: Which, radius: f64) -> Result<Bounded, OpticsError> {
        let at = self.on(which, radius)?;
        Ok(self.solved.told(|solved| solved.irradiance(which, at)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::patch;
    use approx::assert_relative_eq;
    use std::f64::consts::PI;

    fn disks(gap: f64, radii: [f64; 2], albedos: [f64; 2], exitances: [f64; 2]) -> CoaxialDisks {
        CoaxialDisks::new(gap, radii, albedos.map(Albedo::new), exitances.map(Exitance::new)).unwrap()
    }

    /// Black disks: the form factors from a point and from disk to disk.
    #[test]
    fn without_reflection_it_is_a_form_factor() {
        for (gap, r1, r2) in [(1.0, 1.0, 1.0), (0.3, 2.0, 1.0), (0.05, 0.5, 1.0)] {
            let pair = disks(gap, [r1, r2], [0.0, 0.0], [0.0, 1.0]);
            let on_axis = pair.irradiance(Which::First, 0.0).unwrap();
            assert_relative_eq!(on_axis.value, r2 * r2 / (gap * gap + r2 * r2), max_relative = 1e-14);
            let power: f64 = composite(0.0, r1, 200, 10)
                .iter()
                .map(|(r, w)| w * 2.0 * PI * r * pair.irradiance(Which::First, *r).unwrap().value)
                .sum();
            let factor = patch::disk_to_disk(r2, r1, gap).unwrap().ratio();
            assert_relative_eq!(power, PI * r2 * r2 * factor, max_relative = 1e-12);
        }
    }

    #[test]
    fn bounces_add_up_to_all() {
        let pair = disks(0.5, [1.0, 0.7], [0.6, 0.8], [0.2, 1.0]);
        for which in [Which::First, Which::Second] {
            let all = pair.radiosity(which, 0.3).unwrap();
            let emitted = if which == Which::First { 0.2 } else { 1.0 };
            assert_eq!(pair.reflected_after(which, 0.3, 0).unwrap().value, 0.0);
            let mut last = 0.0;
            for reflections in [1, 2, 5, 10, 40] {
                let some = pair.reflected_after(which, 0.3, reflections).unwrap().value;
                assert!(some > last && emitted + some <= all.value * (1.0 + 1e-15));
                last = some;
            }
            assert_relative_eq!(emitted + last, all.value, max_relative = 1e-9);
            assert!(all.bound < 1e-13);
        }
    }

    /// What is emitted is absorbed, or leaves through the gap; and disks that nearly touch are endless plates in the middle.
    #[test]
    fn wide_disks_are_endless_plates() {
        let pair = disks(1.0, [40.0, 40.0], [0.5, 0.3], [1.0, 0.0]);
        let plates =
            crate::radiometry::enclosure::parallel_plates([1.0, 0.0].map(Exitance::new), [0.5, 0.3].map(Albedo::new))
                .unwrap();
        for (which, plate) in [Which::First, Which::Second].into_iter().zip(plates) {
            let found = pair.radiosity(which, 0.0).unwrap().value;
            assert_relative_eq!(found, plate.watts_per_square_metre(), max_relative = 2e-3);
            assert!(found < plate.watts_per_square_metre());
        }
    }

    #[test]
    fn what_is_no_pair_is_refused() {
        let (half, one) = ([0.5, 0.5].map(Albedo::new), [1.0, 0.0].map(Exitance::new));
        assert!(matches!(CoaxialDisks::new(0.0, [1.0, 1.0], half, one), Err(OpticsError::Length { .. })));
        assert!(matches!(CoaxialDisks::new(0.01, [1.0, 1.0], half, one), Err(OpticsError::TooClose { .. })));
        assert!(matches!(
            CoaxialDisks::new(1.0, [1.0, 1.0], [1.5, 0.5].map(Albedo::new), one),
            Err(OpticsError::Share { .. })
        ));
        assert!(CoaxialDisks::new(1.0, [1.0, 1.0], half, [f64::NAN, 0.0].map(Exitance::new)).is_err());
        let pair = CoaxialDisks::new(1.0, [1.0, 2.0], half, one).unwrap();
        assert!(pair.radiosity(Which::First, 1.5).is_err() && pair.radiosity(Which::Second, 1.5).is_ok());
        assert!(pair.irradiance(Which::First, f64::NAN).is_err());
    }
}
