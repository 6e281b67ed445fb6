//! A receiver and one diffuse surface straight opposite each other: two disks, or two equal rectangles.

use super::exchange::Which;
use super::room::Arriving;
use super::{Bounded, CoaxialDisks, FacingRectangles};
use crate::configuration::{Configuration, MeasurementPoint, ReceiverShape};
use crate::geometry::DVec3;
use crate::radiometry::{Albedo, Exitance};

/// The pair, and what goes to and fro between them.
#[derive(Clone, Debug)]
pub(super) struct Between {
    pair: Pair,
    /// Of the receiver's, metres.
    center: DVec3,
    normal: DVec3,
    /// Unit vectors along the receiver.
    along: [DVec3; 2],
    albedos: [f64; 2],
    exitances: [f64; 2],
    all: Solved,
    direct: Solved,
    /// Solved for mean squares, without shadow rays: all, and what is met first.
    squares: [Solved; 2],
    /// The same with shadow rays: what comes after the first.
    asked: Solved,
}

#[derive(Clone, Copy, Debug)]
enum Pair {
    Disks { gap: f64, radii: [f64; 2] },
    Plates { gap: f64, sides: [f64; 2] },
}

#[derive(Clone, Debug)]
enum Solved {
    Disks(Box<CoaxialDisks>),
    Plates(Box<FacingRectangles>),
}

/// Directions and places agree to this, relative to the sizes.
const ALIGNED: f64 = 1e-12;
/// What is taken at its largest is looked for at some places, and taken this much larger.
const SAFELY: f64 = 1.01;

impl Pair {
    fn solve(&self, albedos: [f64; 2], exitances: [f64; 2]) -> Option<Solved> {
        let (albedos, exitances) = (albedos.map(Albedo::new), exitances.map(Exitance::new));
        Some(match *self {
            Pair::Disks { gap, radii } => {
                Solved::Disks(Box::new(CoaxialDisks::new(gap, radii, albedos, exitances).ok()?))
            }
            Pair::Plates { gap, sides } => {
                Solved::Plates(Box::new(FacingRectangles::new(gap, sides, albedos, exitances).ok()?))
            }
        })
    }

    /// Both areas, m².
    fn areas(&self) -> [f64; 2] {
        match *self {
            Pair::Disks { radii, .. } => radii.map(|radius| std::f64::consts::PI * radius * radius),
            Pair::Plates { sides: [a, b], .. } => [a * b; 2],
        }
    }

    fn gap(&self) -> f64 {
        match *self {
            Pair::Disks { gap, .. } | Pair::Plates { gap, .. } => gap,
        }
    }

    /// Some places of one of both, from its middle, metres.
    fn places(&self, which: Which) -> Vec<[f64; 2]> {
        let steps = || (0..5).map(|k| 0.25 * f64::from(k));
        match *self {
            Pair::Disks { radii: [first, second], .. } => {
                let radius = if which == Which::First { first } else { second };
                steps().map(|share| [share * radius, 0.0]).collect()
            }
            Pair::Plates { sides: [a, b], .. } => {
                steps().flat_map(|x| steps().map(move |y| [0.5 * a * x, 0.5 * b * y])).collect()
            }
        }
    }
}

impl Solved {
    /// What arrives at a place, W/m²; on a disk at its distance from the axis.
    fn irradiance(&self, which: Which, place: [f64; 2]) -> Option<Bounded> {
        match self {
            Solved::Disks(disks) => disks.irradiance(which, place[0].hypot(place[1])).ok(),
            Solved::Plates(plates) => plates.irradiance(which, place).ok(),
        }
    }
}

impl Between {
    pub fn of(room: &Configuration) -> Option<Between> {
        let [other] = room.diffuse() else { return None };
        let contents = room.contents();
        let alone = contents.sources.is_empty() && contents.occluders.is_empty() && contents.lamps.is_empty();
        let receiver =
            room.receiver().filter(|receiver| alone && !room.has_optics() && receiver.texture().is_none())?;
        let (pair, center, normal, along) = opposite(receiver.shape(), other.shape())?;
        let albedos = [receiver.albedo().map_or(0.0, |albedo| albedo.ratio()), other.albedo().ratio()];
        let exitances = [0.0, other.exitance().watts_per_square_metre()];
        let (all, direct) = (pair.solve(albedos, exitances)?, pair.solve([0.0; 2], exitances)?);
        let most = |which: Which, value: &dyn Fn([f64; 2]) -> Option<f64>| -> Option<f64> {
            let found: Option<Vec<f64>> = pair.places(which).into_iter().map(value).collect();
            Some(SAFELY * found?.into_iter().fold(0.0, f64::max))
        };
        let value =
            |solved: &Solved, which: Which, at: [f64; 2]| solved.irradiance(which, at).map(|found| found.value);
        // M (2B − M) of the other surface; the receiver emits nothing.
        let [_, m] = exitances;
        let radiosity = m + albedos[1] * most(Which::Second, &|at| value(&all, Which::Second, at))?;
        let met = [0.0, m * (2.0 * radiosity - m)];
        let squares = [pair.solve(albedos, met)?, pair.solve([0.0; 2], met)?];
        // On the receiver: one shadow ray brings M A/(π h²) at most, straight across the gap.
        let brightest = m * pair.areas()[1] / (std::f64::consts::PI * pair.gap() * pair.gap());
        let first = Which::First;
        let straight = most(first, &|at| value(&direct, first, at))?;
        let after = most(first, &|at| Some(value(&all, first, at)? - value(&direct, first, at)?))?;
        let answer = brightest * straight + 2.0 * straight * after;
        let asked = pair.solve(albedos, [albedos[0] * answer, 0.0])?;
        Some(Between { pair, center, normal, along, albedos, exitances, all, direct, squares, asked })
    }

    /// A point of the receiver that looks at the other surface, from its middle.
    fn place(&self, point: &MeasurementPoint) -> Option<[f64; 2]> {
        let offset = point.position() - self.center;
        let is_on = offset.dot(self.normal).abs() <= 1e-9 * self.pair.gap()
            && (point.normal() - self.normal).length() <= 1e-9;
        is_on.then(|| self.along.map(|axis| offset.dot(axis)))
    }

    pub fn at(&self, point: &MeasurementPoint) -> Arriving {
        let Some(place) = self.place(point) else { return Arriving::default() };
        let (all, direct) = (self.all.irradiance(Which::First, place), self.direct.irradiance(Which::First, place));
        let (Some(all), Some(direct)) = (all, direct) else { return Arriving::default() };
        let indirect = Bounded { value: (all.value - direct.value).max(0.0), bound: all.bound + direct.bound };
        Arriving {
            direct: Some(direct),
            caustic: Some(Bounded::default()),
            indirect: Some(indirect),
            total: Some(all),
            by_quadrature: true,
        }
    }

    pub fn largest_mean_square(&self, next_event: bool, point: &MeasurementPoint) -> Option<f64> {
        let place = self.place(point)?;
        let at = |solved: &Solved| solved.irradiance(Which::First, place).map(|found| found.value + found.bound);
        if self.albedos[0] * self.exitances[1] == 0.0 {
            return Some(0.0);
        }
        if next_event {
            at(&self.asked)
        } else {
            Some(at(&self.squares[0])? - self.squares[1].irradiance(Which::First, place)?.value)
        }
    }
}

/// Whether the two lie straight opposite each other: the pair, and the first one's middle, normal and two directions.
fn opposite(first: &ReceiverShape, second: &ReceiverShape) -> Option<(Pair, DVec3, DVec3, [DVec3; 2])> {
    let faces = |from: DVec3, normal: DVec3, to: DVec3, other: DVec3| {
        let way = to - from;
        let gap = way.dot(normal);
        let size = from.abs().max(to.abs()).max_element().max(gap);
        let is_straight = (way - normal * gap).length() <= ALIGNED * size && (normal + other).length() <= ALIGNED;
        (gap > 0.0 && is_straight).then_some(gap)
    };
    match (first, second) {
        (ReceiverShape::Disk(a), ReceiverShape::Disk(b)) => {
            let gap = faces(a.center(), a.normal(), b.center(), b.normal())?;
            let frame = crate::geometry::Frame::around(a.normal());
            let pair = Pair::Disks { gap, radii: [a.radius(), b.radius()] };
            Some((pair, a.center(), a.normal(), [frame.tangent, frame.bitangent]))
        }
        (ReceiverShape::Rectangle(a), ReceiverShape::Rectangle(b)) => {
            let gap = faces(a.center(), a.normal(), b.center(), b.normal())?;
            let (u, v) = (a.edge_u(), a.edge_v());
            let fits = |p: DVec3, q: DVec3| {
                let along = |x: DVec3, y: DVec3| (x - y).length().min((x + y).length()) <= ALIGNED * x.length();
                along(u, p) && along(v, q)
            };
            if !(fits(b.edge_u(), b.edge_v()) || fits(b.edge_v(), b.edge_u())) {
                return None;
            }
            let pair = Pair::Plates { gap, sides: [u.length(), v.length()] };
            Some((pair, a.center(), a.normal(), [u.normalize(), v.normalize()]))
        }
        _ => None,
    }
}
