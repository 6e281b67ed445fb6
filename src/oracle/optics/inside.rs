//! Inside a diffuse sphere: a furnace, or a wall around lamps.

use std::f64::consts::PI;

use super::room::{Arriving, Way};
use super::{Bounded, ROUNDINGS};
use crate::configuration::{Configuration, Lamp, MeasurementPoint, ReceiverShape};
use crate::geometry::Sphere;

/// The inside of a sphere that sends back a share ρ and emits M, with lamps of powers P in it, or with glass and mirrors that
/// lose nothing.
///
/// Every element of the wall sees every other alike, so that what is sent back arrives everywhere alike:
///
/// ```text
/// I(x) = M + Σ direct(x) + ρ/(1 − ρ) (M + Σ P/(4πR²))
/// ```
///
/// Without lamps the wall's radiance is M/(π(1 − ρ)) everywhere, and a lossless body cannot change that: along a ray through
/// it as many shares come in as go out (Kirchhoff).
///
/// - source: the geometric series of bounces ([`crate::radiometry::enclosure`])
#[derive(Clone, Debug)]
pub(super) struct Inside {
    sphere: Sphere,
    albedo: f64,
    exitance: f64,
    lamps: Vec<Lamp>,
    has_optics: bool,
}

/// How near to the wall a point counts as on it, relative to the radius.
const ON_WALL: f64 = 1e-9;

impl Inside {
    pub fn of(room: &Configuration) -> Option<Inside> {
        let [wall] = room.diffuse() else { return None };
        let (ReceiverShape::Sphere(sphere), true) = (wall.shape(), wall.is_enclosure()) else { return None };
        let alone = room.sources().is_empty() && room.occluders().is_empty() && room.receiver().is_none();
        let is_lossless = room.mirrors().iter().all(|mirror| mirror.reflectance() == 1.0);
        let albedo = wall.albedo().ratio();
        let lamps = room.lamps().to_vec();
        if !alone || albedo >= 1.0 || !is_lossless || (room.has_optics() && !lamps.is_empty()) {
            return None;
        }
        let exitance = wall.exitance().watts_per_square_metre();
        Some(Inside { sphere: *sphere, albedo, exitance, lamps, has_optics: room.has_optics() })
    }

    /// Mean over the wall of what arrives straight, W/m².
    fn mean_direct(&self) -> f64 {
        let radius = self.sphere.radius();
        self.exitance + self.lamps.iter().map(Lamp::power).sum::<f64>() / (4.0 * PI * radius * radius)
    }

    /// What arrives after one bounce or more, everywhere alike, W/m².
    fn sent_back(&self) -> f64 {
        self.albedo / (1.0 - self.albedo) * self.mean_direct()
    }

    fn is_at_wall(&self, point: &MeasurementPoint) -> bool {
        let (offset, radius) = (point.position() - self.sphere.center(), self.sphere.radius());
        (offset.length() - radius).abs() <= ON_WALL * radius
            && (offset.normalize() + point.normal()).length() <= ON_WALL
    }

    /// Straight from the lamps, W/m².
    fn of_lamps(&self, point: &MeasurementPoint) -> f64 {
        let of = |lamp: &Lamp| match lamp {
            Lamp::Point(lamp) => {
                let found = lamp.irradiance_at(point.position(), point.normal());
                found.map_or(0.0, |irradiance| irradiance.watts_per_square_metre())
            }
            Lamp::Beam(lamp) => {
                let offset = point.position() - lamp.center();
                let along = offset.dot(lamp.direction());
                let across = (offset - lamp.direction() * along).length();
                let cosine = -lamp.direction().dot(point.normal());
                let is_lit = along > 0.0 && across <= lamp.radius() && cosine > 0.0;
                if is_lit { lamp.irradiance().watts_per_square_metre() * cosine } else { 0.0 }
            }
        };
        self.lamps.iter().map(of).sum()
    }

    pub fn at(&self, point: &MeasurementPoint) -> Arriving {
        let rounded = |value: f64| Some(Bounded { value, bound: ROUNDINGS * f64::EPSILON * value.abs() });
        // With lamps or optics only at the wall: in the air a lamp may be nearer, and glass before the point or behind it.
        let is_in_air = (point.position() - self.sphere.center()).length() < self.sphere.radius() * (1.0 - ON_WALL);
        if !(self.is_at_wall(point) || (is_in_air && self.lamps.is_empty() && !self.has_optics)) {
            return Arriving::default();
        }
        let (direct, sent_back) = (self.exitance + self.of_lamps(point), self.sent_back());
        let total = rounded(direct + sent_back);
        if self.has_optics {
            return Arriving { total, ..Arriving::default() };
        }
        Arriving {
            direct: rounded(direct),
            caustic: rounded(0.0),
            indirect: rounded(sent_back),
            total,
            by_quadrature: false,
        }
    }

    pub fn judged(&self) -> Way {
        if self.lamps.is_empty() { Way::Total } else { Way::Indirect }
    }

    /// `None` for lamps without shadow rays, which are never met.
    pub fn largest_mean_square(&self, next_event: bool, point: &MeasurementPoint) -> Option<f64> {
        let (m, lost, again) = (self.exitance, 1.0 - self.albedo, self.sent_back());
        if self.lamps.is_empty() {
            // One shadow ray from the wall brings M or, where glass or a mirror stands before the rest of it, nothing. Of a
            // share v it is M; the path comes upon the others by chance, with what is left of the shares, 1 − v. The mean
            // square of both together is M² (1 + 2v (1 − v)).
            let of_straight = if next_event && self.has_optics { 1.5 * m * m } else { m * m };
            let at_wall = (of_straight + 2.0 * m * again) / lost;
            if !next_event || self.is_at_wall(point) {
                return Some(at_wall);
            }
            // In the air a shadow ray brings M 4R²/r² at most, r being the nearest that the wall can be.
            let radius = self.sphere.radius();
            let nearest = radius - (point.position() - self.sphere.center()).length();
            let brightest = 4.0 * m * (radius / nearest) * (radius / nearest);
            return Some(m * (brightest + 2.0 * again) + self.albedo * at_wall);
        }
        if !next_event {
            return None;
        }
        let brightest = m + self.lamps.iter().map(|lamp| self.brightest(lamp)).sum::<f64>();
        Some(self.albedo * self.mean_direct() * (brightest + 2.0 * again) / lost)
    }

    /// The most that a lamp brings to the wall, W/m².
    fn brightest(&self, lamp: &Lamp) -> f64 {
        match lamp {
            Lamp::Point(lamp) => {
                let gap = self.sphere.radius() - (lamp.position() - self.sphere.center()).length();
                lamp.intensity().watts_per_steradian() / (gap * gap)
            }
            Lamp::Beam(lamp) => lamp.irradiance().watts_per_square_metre(),
        }
    }
}
