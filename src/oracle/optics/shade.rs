//! A bulb in a shade, over a black receiver.

use super::room::Arriving;
use super::{Bounded, Lampshade};
use crate::configuration::{Arrangement, Configuration, GlassShape, Lamp, MeasurementPoint, ReceiverShape, Source};
use crate::geometry::Shape;
use crate::oracle::exact::Oracle;
use crate::oracle::patch::{Patch, Tolerance, average_irradiance};
use crate::oracle::truth::Method;
use crate::radiometry::{Exitance, SolidAngle};

/// The room as a [`Lampshade`], with what stands in its light.
#[derive(Clone, Debug)]
pub(super) struct Shade {
    lampshade: Lampshade,
    occluders: Vec<Shape>,
    /// Bulb to shell at their nearest, metres.
    gap: f64,
    intensity: f64,
    transmittance: f64,
    albedo: f64,
}

impl Shade {
    pub fn of(room: &Configuration) -> Option<Shade> {
        let ([surface], [Lamp::Point(bulb)]) = (room.diffuse(), room.lamps()) else { return None };
        let ReceiverShape::Sphere(shell) = surface.shape() else { return None };
        let is_black = room.albedo().is_none_or(|albedo| albedo.ratio() == 0.0);
        if surface.transmittance() == 0.0 || !room.sources().is_empty() || room.has_optics() || !is_black {
            return None;
        }
        let (transmittance, albedo) = (surface.transmittance(), surface.albedo().ratio());
        let lampshade = Lampshade::new(*shell, *bulb, transmittance, albedo).ok()?;
        let gap = shell.radius() - (bulb.position() - shell.center()).length();
        let intensity = bulb.intensity().watts_per_steradian();
        Some(Shade { lampshade, occluders: room.occluders().to_vec(), gap, intensity, transmittance, albedo })
    }

    pub fn at(&self, point: &MeasurementPoint) -> Arriving {
        let Ok(truth) = self.lampshade.irradiance_at(point, &self.occluders) else { return Arriving::default() };
        let [value, bound] = [truth.irradiance, truth.bound].map(|x| x.watts_per_square_metre());
        let indirect = Some(Bounded { value, bound });
        let nought = Some(Bounded::default());
        let by_quadrature = truth.method == Method::Quadrature;
        Arriving { direct: nought, caustic: nought, indirect, total: indirect, by_quadrature }
    }

    /// Only shadow rays find a bulb.
    pub fn largest_mean_square(&self, next_event: bool, point: &MeasurementPoint) -> Option<f64> {
        if !next_event {
            return None;
        }
        let radius = self.lampshade.shell().radius();
        let again = 1.0 / (1.0 - self.albedo);
        let mean = self.intensity / (radius * radius);
        let (brightest, after) = (self.intensity / (self.gap * self.gap), self.albedo * again * mean);
        // At the wall, on average and at most.
        let on_average = mean * (brightest + 2.0 * after) * again;
        let at_most = brightest * (brightest + 2.0 * after) + self.albedo * on_average;
        let seen = self.lampshade.irradiance_at(point, &self.occluders).ok()?.form_factor.ratio();
        Some(self.transmittance * seen * at_most)
    }
}

/// What a centred bulb in a shade sends to the receiver, W; `None` for any other room.
///
/// - error: `bound`, an estimate of the quadrature over the receiver
pub fn power_by_lampshade(room: &Configuration) -> Option<Bounded> {
    let shade = Shade::of(room)?;
    let (lampshade, shell) = (&shade.lampshade, shade.lampshade.shell());
    if shade.gap < shell.radius() * (1.0 - 1e-15) {
        return None;
    }
    let patch = match room.receiver()?.shape() {
        ReceiverShape::Rectangle(s) => Patch::Rectangle(*s),
        ReceiverShape::Disk(s) => Patch::Disk(*s),
        _ => return None,
    };
    let mean = lampshade.power().watts() / (4.0 * std::f64::consts::PI * shell.radius() * shell.radius());
    let glow = Source::new(Shape::Sphere(shell), Exitance::new(mean)).ok()?;
    let point = MeasurementPoint::new(shell.center() + shell.radius() * 2.0, glam::DVec3::Z).ok()?;
    let lit =
        Configuration::new(vec![glow], shade.occluders.clone(), None, vec![point], Arrangement::Scattered).ok()?;
    let found = average_irradiance(&Oracle::new(&lit), &patch, Tolerance::relative(1e-9));
    let [value, bound] = [found.irradiance, found.bound].map(|x| x.watts_per_square_metre() * patch.area());
    bound.is_finite().then_some(Bounded { value, bound })
}

/// What a point source sends through a sphere of index 1 around it to the wall of an enclosure, W: all of it, whatever the
/// radii and wherever the source is. `None` for any other room.
///
/// - source: a sphere fills 4π as seen from any place in it ([`crate::radiometry::PointSource::flux_into`])
pub fn power_through_two_spheres(room: &Configuration) -> Option<Bounded> {
    let ([wall], [Lamp::Point(lamp)], [inner]) = (room.diffuse(), room.lamps(), room.glass()) else { return None };
    let GlassShape::Sphere(ball) = inner.shape() else { return None };
    let alone = room.sources().is_empty()
        && room.occluders().is_empty()
        && room.mirrors().is_empty()
        && room.receiver().is_none();
    let is_around = lamp.position().distance(ball.center()) < ball.radius();
    let fits = alone && wall.is_enclosure() && inner.ior() == 1.0 && is_around;
    let all = SolidAngle::new(4.0 * std::f64::consts::PI);
    fits.then(|| Bounded::rounded(lamp.flux_into(all).watts()))
}
