//! A whole room: what arrives at a point straight, by mirrors and glass, and by diffuse surfaces, where each is known.

use super::between::Between;
use super::inside::Inside;
use super::shade::Shade;
use super::{Bounded, MirrorOracle, PlaneMirror};
use crate::configuration::{Configuration, MeasurementPoint, MirrorShape};
use crate::geometry::Shape;

/// Light by the way that it has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Any.
    Total,
    /// By mirrors and glass alone.
    Caustic,
    /// By at least one diffuse surface that does not emit it.
    Indirect,
}

/// What arrives at a point, W/m²; `None` where it is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arriving {
    /// Straight from where it is emitted. `None` also where [`crate::oracle::Oracle`] tells it: from sources with area.
    pub direct: Option<Bounded>,
    /// By way of mirrors and glass alone.
    pub caustic: Option<Bounded>,
    /// By way of diffuse surfaces.
    pub indirect: Option<Bounded>,
    /// All of it.
    pub total: Option<Bounded>,
    /// Whether quadrature took part in any of these.
    pub by_quadrature: bool,
}

impl Arriving {
    /// The light of one way.
    pub fn by(&self, way: Way) -> Option<Bounded> {
        match way {
            Way::Total => self.total,
            Way::Caustic => self.caustic,
            Way::Indirect => self.indirect,
        }
    }
}

/// A room whose light takes bends, as far as that is known exactly.
///
/// | room | what is known |
/// |---|---|
/// | nothing sends light on | caustic and indirect light are nought |
/// | an enclosure that emits, with nothing in it | all: a furnace |
/// | the same with glass, or mirrors that lose nothing | the total: a furnace hides what is in it |
/// | an enclosure around lamps | all, at its wall |
/// | a receiver and one diffuse surface, both disks or equal rectangles, straight opposite each other | all |
/// | sources with area and one flat mirror | caustic light |
/// | a bulb in a shade | indirect light, on a black receiver |
#[derive(Clone, Debug)]
pub struct RoomLight {
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Unknown,
    Plain,
    Inside(Inside),
    Between(Between),
    Mirror {
        oracle: Box<MirrorOracle>,
        /// Of one path that finds a source by the mirror, W/m².
        brightest: f64,
        /// Whether the receiver sends nothing back.
        is_black: bool,
    },
    Shade(Shade),
}

impl RoomLight {
    /// Of any room.
    pub fn new(room: &Configuration) -> RoomLight {
        let kind = if !room.has_optics() && room.diffuse().is_empty() {
            Kind::Plain
        } else if let Some(inside) = Inside::of(room) {
            Kind::Inside(inside)
        } else if let Some(between) = Between::of(room) {
            Kind::Between(between)
        } else if let Some(shade) = Shade::of(room) {
            Kind::Shade(shade)
        } else {
            mirror(room).unwrap_or(Kind::Unknown)
        };
        RoomLight { kind }
    }

    /// At a point.
    ///
    /// - error: each part's `bound`
    pub fn at(&self, point: &MeasurementPoint) -> Arriving {
        let nought = Some(Bounded::default());
        match &self.kind {
            Kind::Unknown => Arriving::default(),
            Kind::Plain => Arriving { caustic: nought, indirect: nought, ..Arriving::default() },
            Kind::Inside(inside) => inside.at(point),
            Kind::Between(between) => between.at(point),
            Kind::Shade(shade) => shade.at(point),
            Kind::Mirror { oracle, is_black, .. } => {
                let caustic = oracle.at(point).ok().map(|truth| {
                    let [value, bound] = [truth.irradiance, truth.bound].map(|x| x.watts_per_square_metre());
                    Bounded { value, bound }
                });
                Arriving { caustic, indirect: nought.filter(|_| *is_black), ..Arriving::default() }
            }
        }
    }

    /// The light that eye paths are judged by: what no shadow ray from the point finds, or all where that is not told apart.
    /// `None` where nothing is sent on, or nothing is known.
    pub fn judged(&self) -> Option<Way> {
        match &self.kind {
            Kind::Unknown | Kind::Plain => None,
            Kind::Inside(inside) => Some(inside.judged()),
            Kind::Between(_) | Kind::Shade(_) => Some(Way::Indirect),
            Kind::Mirror { .. } => Some(Way::Caustic),
        }
    }

    /// What the mean square of one eye path's finding is at most, of the light that is [judged](RoomLight::judged), W²/m⁴;
    /// `None` where it is not known.
    ///
    /// The path goes on from a surface of albedo ρ with probability ρ, or with certainty and a weight of ρ, which brings
    /// less. Then its mean square obeys the radiosity equation as its mean does. Where paths find emission by chance, with
    /// B the radiosity and K what surfaces receive of each other:
    ///
    /// ```text
    /// S = K [ M (2 B − M) + ρ S ]
    /// ```
    ///
    /// and where every place asks the sources straight (D is the answer, d its mean, I all that arrives):
    ///
    /// ```text
    /// S = E D² + 2 d (I − d) + K [ ρ S ]
    /// ```
    ///
    /// since (M + Y)² = M² + 2MY + Y², where Y, what the path finds from there on, has the mean ρI. What varies over a
    /// surface in the first terms is taken at its largest.
    pub fn largest_mean_square(&self, next_event: bool, point: &MeasurementPoint) -> Option<f64> {
        match &self.kind {
            Kind::Unknown | Kind::Plain => None,
            Kind::Inside(inside) => inside.largest_mean_square(next_event, point),
            Kind::Between(between) => between.largest_mean_square(next_event, point),
            Kind::Shade(shade) => shade.largest_mean_square(next_event, point),
            // Found or not.
            Kind::Mirror { brightest, .. } => self.at(point).caustic.map(|due| (due.value + due.bound) * brightest),
        }
    }
}

/// Sources with area and one flat mirror.
fn mirror(room: &Configuration) -> Option<Kind> {
    let ([mirror], [], [], []) = (room.mirrors(), room.glass(), room.lamps(), room.diffuse()) else { return None };
    let shape = match mirror.shape() {
        MirrorShape::Rectangle(s) => Shape::Rectangle(*s),
        MirrorShape::Polygon(s) => Shape::Polygon(s.clone()),
        MirrorShape::Disk(s) => Shape::Disk(*s),
        _ => return None,
    };
    let oracle = MirrorOracle::new(room, &PlaneMirror::new(shape, mirror.reflectance()).ok()?).ok()?;
    let exitances = room.sources().iter().map(|source| source.largest_exitance().watts_per_square_metre());
    let brightest = exitances.fold(0.0, f64::max) * mirror.reflectance();
    let is_black = room.albedo().is_none_or(|albedo| albedo.ratio() == 0.0);
    Some(Kind::Mirror { oracle: Box::new(oracle), brightest, is_black })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Contents, DiffuseSurface, Glass, GlassShape, Lamp, Receiver, ReceiverShape};
    use crate::geometry::{DVec3, Disk, Rectangle, Sphere};
    use crate::oracle::Oracle;
    use crate::radiometry::{Albedo, Exitance, Flux, PointSource};
    use approx::assert_relative_eq;
    use std::f64::consts::PI;

    fn enclosure(albedo: f64, exitance: f64) -> DiffuseSurface {
        let sphere = ReceiverShape::Sphere(Sphere::new(DVec3::ZERO, 2.0).unwrap());
        DiffuseSurface::new(sphere, Albedo::new(albedo), Exitance::new(exitance), true).unwrap()
    }

    fn at_wall(z: f64) -> MeasurementPoint {
        let outwards = DVec3::new(((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z);
        MeasurementPoint::new(outwards * 2.0, -outwards).unwrap()
    }

    fn room(contents: Contents) -> RoomLight {
        RoomLight::new(&Configuration::of(contents).unwrap())
    }

    #[test]
    fn a_furnace_is_everywhere_alike() {
        let light = room(Contents { diffuse: vec![enclosure(0.7, 0.3)], ..Contents::default() });
        for z in [-1.0, 0.2, 0.9] {
            let found = light.at(&at_wall(z));
            assert_relative_eq!(found.total.unwrap().value, 1.0, max_relative = 1e-14);
            assert_relative_eq!(found.indirect.unwrap().value, 0.7, max_relative = 1e-14);
        }
        let ball = Glass::new(GlassShape::Sphere(Sphere::new(DVec3::X * 0.5, 0.6).unwrap()), 1.5).unwrap();
        let light = room(Contents { diffuse: vec![enclosure(0.7, 0.3)], glass: vec![ball], ..Contents::default() });
        let found = light.at(&at_wall(0.2));
        assert_relative_eq!(found.total.unwrap().value, 1.0, max_relative = 1e-14);
        assert_eq!((found.direct, found.caustic, found.indirect), (None, None, None));
    }

    /// Around a lamp: what is absorbed is what the lamp gives out. The mean over the wall by Gauss's rule.
    #[test]
    fn a_wall_absorbs_what_a_lamp_gives_out() {
        let lamp = PointSource::new(DVec3::Z * 0.8, Flux::new(30.0)).unwrap();
        let light = room(Contents {
            diffuse: vec![enclosure(0.6, 0.0)],
            lamps: vec![Lamp::Point(lamp)],
            ..Contents::default()
        });
        let halves = [-0.5, 0.5]
            .map(|middle| crate::number::gauss_10(middle, 0.5, |z| light.at(&at_wall(z)).total.unwrap().value));
        let absorbed = 0.4 * 0.5 * (halves[0] + halves[1]) * 4.0 * PI * 4.0;
        assert_relative_eq!(absorbed, 30.0, max_relative = 1e-6);
        // In the air the closed form does not hold.
        assert_eq!(light.at(&MeasurementPoint::new(DVec3::X, DVec3::X).unwrap()), Arriving::default());
    }

    #[test]
    fn disks_and_plates_tell_direct_light_as_the_oracle_does() {
        let pair = |is_disk: bool| {
            let (up, down): (ReceiverShape, ReceiverShape) = if is_disk {
                let disk = |z: f64, n: DVec3| ReceiverShape::Disk(Disk::new(DVec3::Z * z, n, 1.0).unwrap());
                (disk(0.0, DVec3::Z), disk(0.8, -DVec3::Z))
            } else {
                let plate = |z: f64, v: DVec3| {
                    ReceiverShape::Rectangle(Rectangle::new(DVec3::Z * z, DVec3::X * 2.0, v).unwrap())
                };
                (plate(0.0, DVec3::Y * 1.5), plate(0.8, DVec3::Y * -1.5))
            };
            let lit = DiffuseSurface::new(down, Albedo::new(0.7), Exitance::new(2.0), false).unwrap();
            Configuration::of(Contents {
                diffuse: vec![lit],
                receiver: Some(Receiver::new(up, Some(Albedo::new(0.5))).unwrap()),
                ..Contents::default()
            })
            .unwrap()
        };
        for is_disk in [true, false] {
            let room = pair(is_disk);
            let (light, oracle) = (RoomLight::new(&room), Oracle::new(&room));
            for (x, y) in [(0.0, 0.0), (0.4, -0.3), (0.9, 0.1)] {
                let point = MeasurementPoint::new(DVec3::new(x, y, 0.0), DVec3::Z).unwrap();
                let found = light.at(&point);
                let direct = oracle.at(&point).irradiance.watts_per_square_metre();
                assert_relative_eq!(found.direct.unwrap().value, direct, max_relative = 1e-9);
                let all = found.total.unwrap().value;
                let indirect = found.indirect.unwrap().value;
                assert_relative_eq!(direct + indirect, all, max_relative = 1e-9);
                assert!(indirect > 0.05 * direct);
                for next_event in [false, true] {
                    let square = light.largest_mean_square(next_event, &point).unwrap();
                    assert!(square > indirect * indirect, "{square} {indirect}");
                }
            }
            // Off the receiver, or turned away, nothing is known.
            for (z, n) in [(0.1, DVec3::Z), (0.0, -DVec3::Z)] {
                let point = MeasurementPoint::new(DVec3::Z * z, n).unwrap();
                assert_eq!(light.at(&point), Arriving::default());
            }
        }
    }
}
