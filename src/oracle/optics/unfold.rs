//! A room with one flat mirror as a room without: the sources behind the mirror shine through where it was.

use std::f64::consts::PI;

use glam::DVec3;

use super::mirror::image;
use super::{OpticsError, PlaneMirror};
use crate::configuration::{Configuration, Contents, MeasurementPoint, Mirror, MirrorShape, ReceiverShape, Source};
use crate::geometry::{Mesh, Rectangle, Shape};
use crate::radiometry::Exitance;

/// Nearer than this to the mirror's plane or to its rim, in units of the room, nothing is told.
const CLEARANCE: f64 = 1e-9;

/// The room without its mirror, in which direct light is what arrives straight and by one reflection together.
///
/// Every source stands there twice: itself, and its mirror image with the exitance times the mirror's reflectance; so does
/// every occluder. What light meets before the mirror stands as it is, what it meets behind it as its image. This is the same
/// light only while all of the receiver sees all of every image through the mirror, and nothing reaches through its plane;
/// else the room is refused. For points, past a mirror of any size: [`super::MirrorOracle`].
///
/// ```text
/// crossing points of the plane with segments from a set A before it to a set B behind it lie in the hull of those from
/// A's corners to B's corners: so corners tell whether all pass through a convex mirror
/// ```
///
/// Error: none of its own; an image's place and size keep all but the last bits (below 1e-15 of the room's size), so direct
/// light in the unfolded room is off by what [`crate::oracle`] states for it.
///
/// - `room`: one flat mirror, a receiver that is a rectangle, sources with area and without textures; else an error in words
pub fn unfolded(room: &Configuration) -> Result<Configuration, OpticsError> {
    let refused = |said: String| Err(OpticsError::Configuration { said });
    let [mirror] = room.mirrors() else {
        return refused(format!("{} mirrors; a room with one flat mirror is unfolded", room.mirrors().len()));
    };
    if !(room.glass().is_empty() && room.lamps().is_empty() && room.diffuse().is_empty()) {
        return refused("lamps, glass and diffuse surfaces are not unfolded in a mirror".to_owned());
    }
    if let Some(i) = room.sources().iter().position(|source| source.texture().is_some()) {
        return refused(format!("source {i} has a texture, which is not unfolded in a mirror"));
    }
    let Some(ReceiverShape::Rectangle(receiver)) = room.receiver().map(|receiver| receiver.shape()) else {
        return refused("the receiver is no rectangle".to_owned());
    };
    let window = Window::of(mirror)?;
    let mirrored = |shape: &Shape| -> Result<Shape, OpticsError> {
        match window.heights(shape, receiver) {
            [low, _] if low > 0.0 => Ok(lit_as_before(image(shape, window.origin, window.normal)?)?),
            _ => Err(OpticsError::Configuration {
                said: format!("a {} does not lie wholly before the mirror, as the receiver does", shape.kind()),
            }),
        }
    };
    if window.heights(&Shape::Rectangle(*receiver), receiver)[0] <= 0.0 {
        return refused("the receiver reaches through the mirror's plane".to_owned());
    }
    let mut sources = room.sources().to_vec();
    let mut occluders = room.occluders().to_vec();
    for source in room.sources() {
        let shape = mirrored(source.shape())?;
        if !window.shows(receiver, &shape) {
            return refused(format!(
                "part of the receiver does not see all of a {} in the mirror: its means over pixels are not known",
                shape.kind()
            ));
        }
        let exitance = source.exitance().watts_per_square_metre() * mirror.reflectance();
        sources.push(Source::new(shape, Exitance::new(exitance)).map_err(|error| told(&[error]))?);
    }
    for shape in room.occluders() {
        occluders.push(mirrored(shape)?);
    }
    let middle = MeasurementPoint::new(receiver.center(), receiver.normal());
    let points = match room.points() {
        [] => vec![middle.map_err(|error| told(&[error]))?],
        points => points.to_vec(),
    };
    let Contents { receiver, arrangement, .. } = room.contents().clone();
    Configuration::of(Contents { sources, occluders, receiver, points, arrangement, ..Contents::default() })
        .map_err(|errors| told(&errors))
}

fn told<E: std::fmt::Display>(errors: &[E]) -> OpticsError {
    let said: Vec<String> = errors.iter().map(E::to_string).collect();
    OpticsError::Configuration { said: said.join("; ") }
}

/// A mirror image with its lit side where the image of the lit side is: a reflection turns right hands into left ones.
fn lit_as_before(shape: Shape) -> Result<Shape, OpticsError> {
    Ok(match shape {
        Shape::Rectangle(s) => Shape::Rectangle(Rectangle::new(s.center(), s.edge_v(), s.edge_u())?),
        Shape::Mesh(s) => {
            let triangles = s.triangles().iter().map(|[a, b, c]| [*a, *c, *b]).collect();
            Shape::Mesh(Mesh::new(s.vertices().to_vec(), triangles)?)
        }
        other => other,
    })
}

/// What the mirror leaves open if it is taken away: convex.
struct Window {
    shape: Shape,
    origin: DVec3,
    /// Unit; of either side.
    normal: DVec3,
}

impl Window {
    fn of(mirror: &Mirror) -> Result<Window, OpticsError> {
        let (shape, origin, normal) = match mirror.shape() {
            MirrorShape::Rectangle(s) => (Shape::Rectangle(*s), s.center(), s.normal()),
            MirrorShape::Disk(s) => (Shape::Disk(*s), s.center(), s.normal()),
            MirrorShape::Polygon(s) if s.is_convex() => (Shape::Polygon(s.clone()), s.vertices()[0], s.normal()),
            other => return Err(OpticsError::MirrorShape { said: other.kind() }),
        };
        PlaneMirror::new(shape.clone(), mirror.reflectance())?;
        Ok(Window { shape, origin, normal })
    }

    /// Of the whole room, metres.
    fn size(&self, receiver: &Rectangle, shape: &Shape) -> f64 {
        let all = corners(shape).into_iter().chain(receiver.corners());
        all.map(|p| (p - self.origin).length()).fold(0.0, f64::max)
    }

    /// The least and the greatest height of a shape over the mirror's plane on the receiver's side, metres; what is too near
    /// to the plane to tell counts as on the other side.
    fn heights(&self, shape: &Shape, receiver: &Rectangle) -> [f64; 2] {
        let side = (receiver.center() - self.origin).dot(self.normal).signum();
        let slack = CLEARANCE * self.size(receiver, shape);
        let height = |p: DVec3| side * (p - self.origin).dot(self.normal) - slack;
        corners(shape)
            .into_iter()
            .map(height)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)])
    }

    /// Whether every segment from the receiver to a shape behind the plane passes through the window.
    fn shows(&self, receiver: &Rectangle, behind: &Shape) -> bool {
        let slack = CLEARANCE * self.size(receiver, behind);
        receiver.corners().into_iter().all(|from| {
            corners(behind).into_iter().all(|to| {
                let [near, far] = [from, to].map(|p| (p - self.origin).dot(self.normal));
                near * far < 0.0 && self.holds(from + (to - from) * (near / (near - far)), slack)
            })
        })
    }

    /// Whether a point of the plane lies inside, by more than a slack in metres.
    fn holds(&self, point: DVec3, slack: f64) -> bool {
        let within = |vertices: &[DVec3]| {
            let next = vertices.iter().cycle().skip(1);
            vertices.iter().zip(next).all(|(a, b)| {
                let inwards = self.normal.cross(*b - *a).normalize();
                (point - *a).dot(inwards) > slack
            })
        };
        match &self.shape {
            Shape::Disk(s) => (point - s.center()).length() < s.radius() - slack,
            Shape::Rectangle(s) => within(&s.corners()),
            Shape::Polygon(s) => within(s.vertices()),
            Shape::Sphere(_) | Shape::Mesh(_) => false,
        }
    }
}

/// Points whose hull holds the shape.
fn corners(shape: &Shape) -> Vec<DVec3> {
    match shape {
        Shape::Rectangle(s) => s.corners().to_vec(),
        Shape::Polygon(s) => s.vertices().to_vec(),
        Shape::Mesh(s) => s.vertices().to_vec(),
        Shape::Disk(s) => {
            // An octagon around it.
            let frame = crate::geometry::Frame::around(s.normal());
            let reach = s.radius() / (PI / 8.0).cos();
            let turn = |k: u8| PI / 4.0 * f64::from(k);
            let corner = |k: u8| (frame.tangent * turn(k).cos() + frame.bitangent * turn(k).sin()) * reach;
            (0..8).map(|k| s.center() + corner(k)).collect()
        }
        Shape::Sphere(s) => {
            let sign = |k: u8, bit: u8| if k >> bit & 1 == 0 { -s.radius() } else { s.radius() };
            (0..8).map(|k| s.center() + DVec3::new(sign(k, 0), sign(k, 1), sign(k, 2))).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::Receiver;
    use crate::geometry::{Disk, Sphere};
    use crate::oracle::Oracle;
    use crate::oracle::optics::MirrorOracle;
    use crate::radiometry::Albedo;
    use approx::assert_relative_eq;

    /// A floor, something that shines upwards and something that shines everywhere, a ball in the way, a mirror above.
    fn room(mirror: MirrorShape, ball: f64) -> Configuration {
        let up = Rectangle::new(DVec3::new(0.1, 0.05, 1.0), DVec3::X * 0.5, DVec3::Y * 0.4).unwrap();
        let globe = Sphere::new(DVec3::new(-0.6, 0.3, 1.2), 0.15).unwrap();
        let tilted = Disk::new(DVec3::new(0.5, -0.5, 0.9), DVec3::new(0.2, 0.3, 1.0), 0.2).unwrap();
        let lit = |shape: Shape, m: f64| Source::new(shape, Exitance::new(m)).unwrap();
        let floor = Rectangle::new(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0).unwrap();
        let grid = (0..49).map(|k| DVec3::new(0.3 * f64::from(k % 7) - 0.9, 0.3 * f64::from(k / 7) - 0.9, 0.0));
        Configuration::of(Contents {
            sources: vec![
                lit(Shape::Rectangle(up), 1.0),
                lit(Shape::Sphere(globe), 0.7),
                lit(Shape::Disk(tilted), 2.0),
            ],
            occluders: vec![Shape::Sphere(Sphere::new(DVec3::new(0.2, 0.2, ball), 0.2).unwrap())],
            mirrors: vec![Mirror::new(mirror, 0.8).unwrap()],
            receiver: Some(Receiver::new(ReceiverShape::Rectangle(floor), Some(Albedo::new(0.5))).unwrap()),
            points: grid.map(|p| MeasurementPoint::new(p, DVec3::Z).unwrap()).collect(),
            ..Contents::default()
        })
        .unwrap()
    }

    fn above(half: f64) -> MirrorShape {
        MirrorShape::Rectangle(Rectangle::new(DVec3::Z * 2.0, DVec3::X * 2.0 * half, DVec3::Y * 2.0 * half).unwrap())
    }

    /// Direct light and light by the mirror, each by its own oracle, add up to direct light in the unfolded room.
    #[test]
    fn an_unfolded_room_has_the_light_of_both_ways() {
        // Out of everybody's way, behind the floor.
        let bare = Oracle::new(&unfolded(&room(above(2.0), -3.0)).unwrap());
        for height in [0.5, 1.6] {
            let folded = room(above(2.0), height);
            let mirror =
                PlaneMirror::new(folded.mirrors()[0].shape().outline().unwrap().pop().unwrap(), 0.8).unwrap();
            let (direct, by_mirror) = (Oracle::new(&folded), MirrorOracle::new(&folded, &mirror).unwrap());
            let open = Oracle::new(&unfolded(&folded).unwrap());
            let mut dimmed = 0;
            for point in folded.points() {
                let both = direct.at(point).irradiance.watts_per_square_metre()
                    + by_mirror.at(point).unwrap().irradiance.watts_per_square_metre();
                let found = open.at(point).irradiance.watts_per_square_metre();
                assert_relative_eq!(found, both, max_relative = 1e-12);
                dimmed += usize::from(found < 0.99 * bare.at(point).irradiance.watts_per_square_metre());
            }
            assert!(dimmed >= 3, "the ball at {height} m shades {dimmed} points");
        }
    }

    #[test]
    fn what_is_not_seen_whole_is_refused() {
        let refused = |room: &Configuration| unfolded(room).unwrap_err().to_string();
        assert!(refused(&room(above(0.7), 0.5)).contains("does not see all"));
        assert!(unfolded(&room(above(1.2), 0.5)).is_ok());
        // The ball reaches through the mirror's plane.
        assert!(refused(&room(above(2.0), 1.9)).contains("before the mirror"));
        let disk = |radius: f64| MirrorShape::Disk(Disk::new(DVec3::Z * 2.0, DVec3::Z, radius).unwrap());
        assert!(refused(&room(disk(0.8), 0.5)).contains("does not see all"));
        assert!(unfolded(&room(disk(1.4), 0.5)).is_ok());
        let ring = crate::geometry::Cylinder::new(DVec3::Z * 2.0, DVec3::Z, 0.5, 0.1).unwrap();
        assert!(refused(&room(MirrorShape::Cylinder(ring), 0.5)).contains("flat mirror"));
    }
}
