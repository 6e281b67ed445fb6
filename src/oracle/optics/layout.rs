//! Rooms whose caustics are known: one lamp, one optic on its axis, a flat receiver square to it.

use super::{Bounded, Caustic, Loss, MirrorOracle, PlaneMirror};
use crate::configuration::{Configuration, Glass, GlassShape, Lamp, Mirror, MirrorShape, ReceiverShape};
use crate::geometry::{DVec3, Shape};
use crate::oracle::patch::{Patch, Tolerance};
use crate::radiometry::Beam;

/// What such a room sends to its receiver, by the number of interactions on the way.
///
/// | room | orders |
/// |---|---|
/// | a beam into a paraboloid, or into a spherical mirror | 1: mirrored once |
/// | a beam through a ball or a plano-convex lens | 2: straight through |
/// | a point source over a level slab | 2, 4, 6, 8: through, with none to three double reflections inside |
///
/// The light of other orders (reflections off the glass, second reflections) is not in it.
#[derive(Clone, Debug)]
pub struct CausticLayout {
    /// Where the axis meets the receiver, metres.
    foot: DVec3,
    /// Outer radius of the largest ring around it that lies on the receiver, metres.
    room: f64,
    /// W/m² of the beam, W/sr of the point source, times what mirrors send back.
    scale: f64,
    orders: Vec<(usize, Caustic)>,
    screen: Screen,
}

/// Directions are the same, and places lie on a line, to this many metres in one.
const ALIGNED: f64 = 1e-12;
/// Double reflections in a slab that are told apart.
const ECHOES: u32 = 3;

impl CausticLayout {
    /// `None` for any other room.
    pub fn of(room: &Configuration) -> Option<CausticLayout> {
        let alone = room.sources().is_empty() && room.occluders().is_empty() && room.diffuse().is_empty();
        let [lamp] = room.lamps() else { return None };
        let receiver = Screen::of(room.receiver()?.shape())?;
        let (scale, orders) = match (alone.then_some(lamp)?, room.mirrors(), room.glass()) {
            (Lamp::Beam(beam), [mirror], []) => {
                let caustic = mirrored(beam, mirror, &receiver)?;
                (beam.irradiance().watts_per_square_metre() * mirror.reflectance(), vec![(1, caustic)])
            }
            (Lamp::Beam(beam), [], [glass]) => {
                (beam.irradiance().watts_per_square_metre(), vec![(2, refracted(beam, glass, &receiver)?)])
            }
            (Lamp::Point(lamp), [], [glass]) => {
                let intensity = lamp.power().watts() / (4.0 * std::f64::consts::PI);
                (intensity, through_slab(lamp.position(), glass, &receiver)?)
            }
            _ => return None,
        };
        let axis_from = match lamp {
            Lamp::Beam(beam) => beam.center(),
            Lamp::Point(lamp) => lamp.position(),
        };
        let foot = axis_from - receiver.normal * (axis_from - receiver.center).dot(receiver.normal);
        Some(CausticLayout { foot, room: receiver.room_around(foot), scale, orders, screen: receiver })
    }

    /// Where the axis meets the receiver, metres.
    pub fn foot(&self) -> DVec3 {
        self.foot
    }

    /// Radius of the largest disk around the foot that lies on the receiver, metres.
    pub fn room(&self) -> f64 {
        self.room
    }

    /// The orders that are known, ascending.
    pub fn orders(&self) -> impl Iterator<Item = usize> {
        self.orders.iter().map(|(order, _)| *order)
    }

    /// Power between two circles around the foot, W; `None` for an order that is not known, or circles beyond the receiver.
    pub fn power_in_ring(&self, order: usize, from: f64, to: f64) -> Option<Bounded> {
        let (_, caustic) = self.orders.iter().find(|(known, _)| *known == order)?;
        let inside = to <= self.room * (1.0 + ALIGNED);
        Some(caustic.power_in_ring(from, to).ok().filter(|_| inside)?.scaled(self.scale))
    }

    /// All power that lands on the receiver's plane, W; `None` for an order that is not known.
    pub fn power_on_plane(&self, order: usize) -> Option<Bounded> {
        let (_, caustic) = self.orders.iter().find(|(known, _)| *known == order)?;
        Some(caustic.total().scaled(self.scale))
    }

    /// All power that lands on the receiver, W; `None` for an order that is not known, and for a disk that does not lie around
    /// the axis.
    pub fn power_on_receiver(&self, order: usize) -> Option<Bounded> {
        let (_, caustic) = self.orders.iter().find(|(known, _)| *known == order)?;
        let found = match &self.screen.shape {
            ReceiverShape::Disk(disk) => {
                let is_centered = (disk.center() - self.foot).length() <= ALIGNED * disk.radius();
                caustic.power_in_ring(0.0, disk.radius()).ok().filter(|_| is_centered)
            }
            ReceiverShape::Rectangle(s) => {
                let side = |edge: DVec3| {
                    let (middle, half) = ((s.center() - self.foot).dot(edge.normalize()), 0.5 * edge.length());
                    [middle - half, middle + half]
                };
                caustic.power_in_rectangle(side(s.edge_u()), side(s.edge_v())).ok()
            }
            _ => None,
        };
        Some(found?.scaled(self.scale))
    }

    /// Irradiance in the middle of a part of a rectangle, and its mean over the part, W/m², with the part's area, m².
    ///
    /// - `s`, `t`: shares of the edges `edge_u` and `edge_v`, ascending
    /// - `None` where an edge of the light, a caustic or the axis comes nearer to the part than it is wide
    pub fn irradiance_of_part(&self, order: usize, s: [f64; 2], t: [f64; 2]) -> Option<(f64, f64, f64)> {
        let (_, caustic) = self.orders.iter().find(|(known, _)| *known == order)?;
        let ReceiverShape::Rectangle(receiver) = &self.screen.shape else { return None };
        let extent = |edge: DVec3, [from, to]: [f64; 2]| {
            let middle = (receiver.center() - self.foot).dot(edge.normalize());
            [from, to].map(|share| middle + (share - 0.5) * edge.length())
        };
        let (x, y) = (extent(receiver.edge_u(), s), extent(receiver.edge_v(), t));
        let radius = (0.5 * (x[0] + x[1])).hypot(0.5 * (y[0] + y[1]));
        let across = (x[1] - x[0]).hypot(y[1] - y[0]);
        if caustic.edges().iter().any(|edge| (edge - radius).abs() <= across) {
            return None;
        }
        let middle = caustic.at(radius).ok()?.value()?;
        let area = (x[1] - x[0]) * (y[1] - y[0]);
        let mean = caustic.power_in_rectangle(x, y).ok()?.value / area;
        (middle > 0.0).then_some((middle * self.scale, mean * self.scale, area))
    }

    /// What lands within a radius of the foot after so many double reflections in the slab, all of them together, W; `None`
    /// where there is no slab.
    pub(super) fn through_slab(&self, glass: &Glass, lamp: DVec3, echoes: u32, radius: f64) -> Option<Bounded> {
        let mut sum = Bounded::default();
        for (_, caustic) in slab_orders(lamp, glass, &self.screen, echoes)? {
            let ring = caustic.power_in_ring(0.0, radius).ok()?.scaled(self.scale);
            sum = Bounded { value: sum.value + ring.value, bound: sum.bound + ring.bound };
        }
        Some(sum)
    }
}

/// A flat receiver.
#[derive(Clone, Debug)]
pub(super) struct Screen {
    center: DVec3,
    normal: DVec3,
    shape: ReceiverShape,
}

impl Screen {
    pub(super) fn of(shape: &ReceiverShape) -> Option<Screen> {
        let (center, normal) = match shape {
            ReceiverShape::Rectangle(s) => (s.center(), s.normal()),
            ReceiverShape::Disk(s) => (s.center(), s.normal()),
            _ => return None,
        };
        Some(Screen { center, normal, shape: *shape })
    }

    pub(super) fn center(&self) -> DVec3 {
        self.center
    }

    /// Height over the receiver's plane, on the side that receives.
    pub(super) fn height(&self, place: DVec3) -> f64 {
        (place - self.center).dot(self.normal)
    }

    /// Whether a direction is square to the receiver.
    fn faces(&self, direction: DVec3) -> bool {
        self.normal.cross(direction).length() <= ALIGNED
    }

    /// Whether two places lie on one line square to the receiver.
    fn lines_up(&self, a: DVec3, b: DVec3) -> bool {
        let (way, size) = (b - a, a.abs().max_element().max(b.abs().max_element()).max(1.0));
        (way - self.normal * way.dot(self.normal)).length() <= ALIGNED * size
    }

    fn room_around(&self, foot: DVec3) -> f64 {
        match &self.shape {
            ReceiverShape::Disk(s) => (s.radius() - (foot - s.center()).length()).max(0.0),
            ReceiverShape::Rectangle(s) => {
                let room = |edge: DVec3| 0.5 * edge.length() - (foot - s.center()).dot(edge.normalize()).abs();
                room(s.edge_u()).min(room(s.edge_v())).max(0.0)
            }
            _ => 0.0,
        }
    }
}

/// The beam runs towards the mirror, whose axis points back at it; the receiver looks at the mirror from between.
fn mirrored(beam: &Beam, mirror: &Mirror, receiver: &Screen) -> Option<Caustic> {
    let down = beam.direction();
    let (vertex, open, rim, make): (DVec3, DVec3, f64, &dyn Fn(f64, f64) -> Option<Caustic>) = match mirror.shape() {
        MirrorShape::Paraboloid(s) => {
            let focal = s.focal_length();
            (s.vertex(), s.axis(), s.rim_radius(), &move |plane, beam| Caustic::paraboloid(focal, plane, beam).ok())
        }
        MirrorShape::SphereCap(s) => {
            let radius = s.sphere().radius();
            let vertex = s.sphere().center() + s.axis() * radius;
            (vertex, -s.axis(), s.rim_radius(), &move |plane, beam| {
                Caustic::spherical_mirror(radius, plane, beam).ok()
            })
        }
        _ => return None,
    };
    let plane = (receiver.center - vertex).dot(open);
    // The receiver's back lets the beam through; light comes to its face from the mirror.
    let fits = open.dot(down) < 0.0
        && receiver.normal.dot(open) < 0.0
        && receiver.faces(down)
        && receiver.faces(open)
        && receiver.lines_up(beam.center(), vertex)
        && beam.radius() <= rim
        && (beam.center() - vertex).dot(open) > 0.0;
    if fits { make(plane, beam.radius()) } else { None }
}

fn refracted(beam: &Beam, glass: &Glass, receiver: &Screen) -> Option<Caustic> {
    let down = beam.direction();
    let falls = down.dot(receiver.normal) < 0.0 && receiver.faces(down);
    let reaches = |place: DVec3| receiver.lines_up(beam.center(), place) && (place - beam.center()).dot(down) > 0.0;
    match glass.shape() {
        GlassShape::Sphere(ball) => {
            let fits = falls && reaches(ball.center()) && beam.radius() <= ball.radius();
            let distance = receiver.height(ball.center());
            let caustic =
                Caustic::glass_ball(ball.radius(), glass.ior(), distance, beam.radius(), Loss::PerPolarisation);
            caustic.ok().filter(|_| fits)
        }
        GlassShape::PlanoConvex(lens) => {
            let fits = falls
                && reaches(lens.vertex())
                && receiver.faces(lens.axis())
                && lens.axis().dot(down) < 0.0
                && beam.radius() <= lens.rim_radius();
            let distance = receiver.height(lens.vertex());
            let caustic = Caustic::plano_convex(
                lens.curvature_radius(),
                glass.ior(),
                distance,
                beam.radius(),
                Loss::PerPolarisation,
            );
            caustic.ok().filter(|_| fits)
        }
        _ => None,
    }
}

fn through_slab(lamp: DVec3, glass: &Glass, receiver: &Screen) -> Option<Vec<(usize, Caustic)>> {
    let GlassShape::Slab(slab) = glass.shape() else { return None };
    let (top, middle) = (receiver.height(lamp), receiver.height(slab.middle().center()));
    let half = 0.5 * slab.thickness();
    let fits = receiver.faces(slab.middle().normal()) && middle - half > 0.0 && top > middle + half;
    // The rays of the widest angle that still reach the receiver must pass the faces, not the sides: the slab must be
    // wider than the receiver as seen from the lamp, which it is where it covers the receiver.
    let (foot, room) = (lamp - receiver.normal * top, receiver.room_around(lamp - receiver.normal * top));
    let offset = slab.middle().center() - foot;
    let covers = [slab.middle().edge_u(), slab.middle().edge_v()].iter().all(|edge| {
        0.5 * edge.length() - offset.dot(edge.normalize()).abs() >= room + 2.0 * slab.thickness() * f64::from(ECHOES)
    });
    if !(fits && covers) {
        return None;
    }
    slab_orders(lamp, glass, receiver, ECHOES)
}

/// Up to a number of double reflections.
fn slab_orders(lamp: DVec3, glass: &Glass, receiver: &Screen, echoes: u32) -> Option<Vec<(usize, Caustic)>> {
    let GlassShape::Slab(slab) = glass.shape() else { return None };
    let top = receiver.height(lamp);
    (0..=echoes)
        .map(|echoes| {
            let air = top - slab.thickness();
            let caustic =
                Caustic::slab_under_point_source(air, slab.thickness(), glass.ior(), echoes, Loss::PerPolarisation);
            Some((2 + 2 * echoes as usize, caustic.ok()?))
        })
        .collect()
}

/// The receiver as a patch, if it is flat.
pub(super) fn patch(room: &Configuration) -> Option<Patch> {
    match room.receiver()?.shape() {
        ReceiverShape::Rectangle(s) => Some(Patch::Rectangle(*s)),
        ReceiverShape::Disk(s) => Some(Patch::Disk(*s)),
        ReceiverShape::Triangle(_) | ReceiverShape::Sphere(_) => None,
    }
}

/// What area sources send to the receiver by way of one flat mirror, exactly: W. `None` for any other room.
///
/// - error: `bound`, an estimate of the quadrature over the receiver
pub fn power_by_flat_mirror(room: &Configuration) -> Option<Bounded> {
    let ([mirror], [], []) = (room.mirrors(), room.glass(), room.lamps()) else { return None };
    let shape = match mirror.shape() {
        MirrorShape::Rectangle(s) => Shape::Rectangle(*s),
        MirrorShape::Polygon(s) => Shape::Polygon(s.clone()),
        MirrorShape::Disk(s) => Shape::Disk(*s),
        _ => return None,
    };
    let patch = patch(room)?;
    if !room.diffuse().is_empty() {
        return None;
    }
    let mirror = PlaneMirror::new(shape, mirror.reflectance()).ok()?;
    let mean = MirrorOracle::new(room, &mirror).ok()?.average_irradiance(&patch, Tolerance::relative(1e-9));
    let [value, bound] = [mean.irradiance, mean.bound].map(|x| x.watts_per_square_metre() * patch.area());
    bound.is_finite().then_some(Bounded { value, bound })
}
