//! A bulb in a shell that scatters what it lets through: a luminaire that is lit from inside.

use std::f64::consts::PI;

use glam::DVec3;

use super::{OpticsError, share};
use crate::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use crate::geometry::{Shape, Sphere, finite_point};
use crate::oracle::exact::Oracle;
use crate::oracle::truth::Truth;
use crate::radiometry::{Exitance, Flux, PointSource};

/// A point source inside a spherical shell whose outside sends out, diffusely, a share τ of what arrives inside, and whose
/// inside sends back, diffusely, a share ρ of it.
///
/// Where the outward normal is n, at the distance d of the bulb at **a** from the middle, the bulb alone makes
/// I (R − **a**·n)/d³, d² = R² + a² − 2R **a**·n. What the inside sends back arrives everywhere alike (inside a sphere every
/// element sees every other alike). So the shell glows as if it were a source of exitance
///
/// ```text
/// M(n) = τ [ I (R − a·n)/d³ + (ρ/(1 − ρ)) I/R² ]
/// ```
///
/// and sends out 4πI τ/(1 − ρ). Centred, it is a uniform sphere source of M = τ I/((1 − ρ) R²).
///
/// - source: the law of point sources, and the sphere's interior ([`crate::radiometry::enclosure`])
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lampshade {
    shell: Sphere,
    bulb: PointSource,
    transmittance: f64,
    reflectance: f64,
}

impl Lampshade {
    /// - `bulb`: inside the shell; `transmittance` τ, `reflectance` ρ of the shell's inside: shares in [0, 1] with τ + ρ ≤ 1,
    ///   ρ < 1; what is left is absorbed
    pub fn new(
        shell: Sphere,
        bulb: PointSource,
        transmittance: f64,
        reflectance: f64,
    ) -> Result<Lampshade, OpticsError> {
        let transmittance = share("the transmittance", transmittance)?;
        let reflectance = share("the reflectance", reflectance)?;
        // Decimals that add up to one may do so but for rounding.
        if transmittance + reflectance > 1.0 + 4.0 * f64::EPSILON || reflectance == 1.0 {
            return Err(OpticsError::NothingLost { said: transmittance + reflectance });
        }
        let said = bulb.position().distance(shell.center());
        if said >= shell.radius() {
            return Err(OpticsError::OutsideShell { said, radius: shell.radius() });
        }
        Ok(Lampshade { shell, bulb, transmittance, reflectance })
    }

    /// The shell.
    pub fn shell(&self) -> Sphere {
        self.shell
    }

    /// All power that leaves the shell, W: 4πI τ/(1 − ρ).
    pub fn power(&self) -> Flux {
        Flux::new(self.bulb.power().watts() * (self.transmittance / (1.0 - self.reflectance)))
    }

    /// The equivalent exitance at a place of the shell, W/m².
    ///
    /// - `outwards`: from the middle towards the place, any length but zero
    /// - error: relative, a few 2⁻⁵³ times R over the bulb's distance from the shell
    pub fn exitance(&self, outwards: DVec3) -> Result<Exitance, OpticsError> {
        let outwards = crate::geometry::unit("outwards", outwards)?;
        Ok(Exitance::new(self.glow(outwards)))
    }

    fn glow(&self, outwards: DVec3) -> f64 {
        let radius = self.shell.radius();
        let offset = self.bulb.position() - self.shell.center();
        let distance = (outwards * radius - offset).length();
        let direct = (radius - offset.dot(outwards)) / distance / distance / distance;
        let sent_back = self.reflectance / (1.0 - self.reflectance) / (radius * radius);
        self.transmittance * self.bulb.intensity().watts_per_steradian() * (direct + sent_back)
    }

    /// Irradiance outside the shell, past any occluders.
    ///
    /// Centred, in closed form (a uniform sphere source); else by quadrature over the shell, and it says so. Of the answer,
    /// form factor and region are those of the shell's shape.
    ///
    /// - `occluders`: outside the shell
    /// - error: `bound`, as of [`Oracle::at`] and [`Oracle::by_quadrature_with`]
    pub fn irradiance_at(&self, point: &MeasurementPoint, occluders: &[Shape]) -> Result<Truth, OpticsError> {
        let mean = self.power().watts() / (4.0 * PI * self.shell.radius() * self.shell.radius());
        let refused = |said: String| OpticsError::Configuration { said };
        let source =
            Source::new(Shape::Sphere(self.shell), Exitance::new(mean)).map_err(|e| refused(e.to_string()))?;
        let room = Configuration::new(vec![source], occluders.to_vec(), None, vec![*point], Arrangement::Scattered)
            .map_err(|all| refused(all.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")))?;
        let oracle = Oracle::new(&room);
        if self.bulb.position() == self.shell.center() {
            return Ok(oracle.at(point));
        }
        let center = finite_point("center", self.shell.center())?;
        Ok(oracle.by_quadrature_with(point, &|_, place| self.glow((place - center).normalize_or(DVec3::Z))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::truth::Method;
    use approx::assert_relative_eq;

    fn shade(offset: DVec3, transmittance: f64, reflectance: f64) -> Lampshade {
        let shell = Sphere::new(DVec3::new(0.2, -0.1, 2.0), 0.5).unwrap();
        let bulb = PointSource::new(shell.center() + offset, Flux::new(60.0)).unwrap();
        Lampshade::new(shell, bulb, transmittance, reflectance).unwrap()
    }

    fn floor(x: f64, y: f64) -> MeasurementPoint {
        MeasurementPoint::new(DVec3::new(x, y, 0.0), DVec3::Z).unwrap()
    }

    /// What glows is what the bulb sent, less what is absorbed: ∫ M dA over the shell, wherever the bulb is.
    #[test]
    fn the_shell_sends_out_what_it_lets_through() {
        for (offset, tau, rho) in [(0.0, 0.4, 0.0), (0.3, 0.5, 0.2), (0.45, 0.6, 0.4)] {
            let lamp = shade(DVec3::new(0.0, 0.0, offset), tau, rho);
            // M depends on the height alone, and equal heights hold equal areas; along the distance from the bulb it is even.
            let glow = |z: f64| {
                let outwards = DVec3::new(((1.0 - z) * (1.0 + z)).max(0.0).sqrt(), 0.0, z);
                lamp.exitance(outwards).unwrap().watts_per_square_metre()
            };
            let (near, far, panels) = (0.5 - offset, 0.5 + offset, 64);
            let mean = if offset == 0.0 {
                glow(0.3)
            } else {
                let half = 0.5 * (far - near) / f64::from(panels);
                let panel = |i: u32| {
                    crate::number::gauss_10(near + half * f64::from(2 * i + 1), half, |d| {
                        glow((0.25 + offset * offset - d * d) / offset) * d / offset
                    })
                };
                (0..panels).map(panel).sum::<f64>()
            };
            assert_relative_eq!(mean * lamp.shell().area(), lamp.power().watts(), max_relative = 1e-13);
            assert_relative_eq!(lamp.power().watts(), 60.0 * tau / (1.0 - rho), max_relative = 1e-15);
        }
    }

    #[test]
    fn centred_it_is_a_sphere_source() {
        let lamp = shade(DVec3::ZERO, 0.4, 0.25);
        let found = lamp.irradiance_at(&floor(0.2, -0.1), &[]).unwrap();
        // Straight below, wholly above the horizon: the point source's irradiance of all that power.
        let wanted = lamp.power().watts() / (4.0 * PI) / 4.0;
        assert_relative_eq!(found.irradiance.watts_per_square_metre(), wanted, max_relative = 1e-14);
        assert_eq!(found.method, Method::ClosedForm);
    }

    #[test]
    fn a_little_off_the_middle_is_nearly_centred() {
        let (centred, off) = (shade(DVec3::ZERO, 0.4, 0.0), shade(DVec3::X * 1e-7, 0.4, 0.0));
        let at = floor(0.5, 0.3);
        let [a, b] = [centred, off].map(|lamp| lamp.irradiance_at(&at, &[]).unwrap());
        assert_eq!(b.method, Method::Quadrature);
        assert_relative_eq!(
            a.irradiance.watts_per_square_metre(),
            b.irradiance.watts_per_square_metre(),
            max_relative = 1e-6
        );
    }

    /// Off the middle: the flux through a large sphere around it is all that leaves the shell.
    #[test]
    fn off_the_middle_no_power_is_lost_on_the_way() {
        let lamp = shade(DVec3::Z * 0.3, 0.5, 0.1);
        let center = lamp.shell().center();
        let far = 3.0;
        let received = |z: f64| {
            let outwards = DVec3::new(((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z);
            let point = MeasurementPoint::new(center + outwards * far, -outwards).unwrap();
            lamp.irradiance_at(&point, &[]).unwrap().irradiance.watts_per_square_metre()
        };
        let halves = [-0.5, 0.5].map(|middle| crate::number::gauss_10(middle, 0.5, received));
        let power = 2.0 * PI * far * far * (halves[0] + halves[1]);
        assert_relative_eq!(power, lamp.power().watts(), max_relative = 1e-7);
    }

    #[test]
    fn what_is_no_lampshade_is_refused() {
        let shell = Sphere::new(DVec3::ZERO, 0.5).unwrap();
        let bulb = |x: f64| PointSource::new(DVec3::X * x, Flux::new(1.0)).unwrap();
        assert!(matches!(Lampshade::new(shell, bulb(0.5), 0.5, 0.0), Err(OpticsError::OutsideShell { .. })));
        assert!(matches!(Lampshade::new(shell, bulb(0.0), 0.7, 0.4), Err(OpticsError::NothingLost { .. })));
        assert!(matches!(Lampshade::new(shell, bulb(0.0), 0.0, 1.0), Err(OpticsError::NothingLost { .. })));
        assert!(matches!(Lampshade::new(shell, bulb(0.0), f64::NAN, 0.0), Err(OpticsError::Share { .. })));
        let lamp = Lampshade::new(shell, bulb(0.1), 0.7, 0.3).unwrap();
        assert!(lamp.exitance(DVec3::ZERO).is_err());
        let on_shell = MeasurementPoint::new(DVec3::X * 0.5, DVec3::X).unwrap();
        assert!(matches!(lamp.irradiance_at(&on_shell, &[]), Err(OpticsError::Configuration { .. })));
    }
}
