//! The room as lines, for whoever draws it: what each thing looks like, not what light does with it.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{Configuration, Glass, GlassShape, Lamp, Mirror, MirrorShape, ReceiverShape};
use crate::geometry::{Mesh, Rectangle, Shape};

/// Corners of a curve that is drawn as a line.
const CURVE: usize = 24;
/// Directions in which a mesh is asked for its outermost vertex.
const DIRECTIONS: usize = 96;

/// What a thing does in its room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Source,
    Lamp,
    Occluder,
    Mirror,
    Glass,
    Diffuse,
    Receiver,
}

impl Role {
    pub const ALL: [Role; 7] =
        [Role::Source, Role::Lamp, Role::Occluder, Role::Mirror, Role::Glass, Role::Diffuse, Role::Receiver];

    /// The name that reports use.
    pub fn name(self) -> &'static str {
        match self {
            Role::Source => "source",
            Role::Lamp => "lamp",
            Role::Occluder => "occluder",
            Role::Mirror => "mirror",
            Role::Glass => "glass",
            Role::Diffuse => "diffuse",
            Role::Receiver => "receiver",
        }
    }
}

/// A part of a drawing, in the room's own three dimensions, metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Stroke {
    /// A circle about a unit normal, or a sphere.
    Round {
        center: DVec3,
        normal: Option<DVec3>,
        radius: f64,
    },
    /// An outline that ends where it begins.
    Closed(Vec<DVec3>),
    Open(Vec<DVec3>),
    /// What is to be seen is the outline of all of them together.
    Hull(Vec<DVec3>),
}

/// One thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    pub role: Role,
    /// As a case file names it: `disk`, `rectangle`…
    pub shape: &'static str,
    /// Whether what it sends out, or sends back, varies over it.
    pub is_textured: bool,
    pub strokes: Vec<Stroke>,
}

/// All that stands in a room, in the order of the roles.
pub(super) fn figures(room: &Configuration) -> Vec<Figure> {
    let contents = room.contents();
    let plain = |role, shape, strokes| Figure { role, shape, is_textured: false, strokes };
    let mut figures: Vec<Figure> = contents
        .sources
        .iter()
        .map(|source| Figure {
            is_textured: source.texture().is_some(),
            ..plain(Role::Source, source.shape().kind(), of_shape(source.shape()))
        })
        .collect();
    figures.extend(contents.lamps.iter().map(of_lamp));
    figures.extend(contents.occluders.iter().map(|shape| plain(Role::Occluder, shape.kind(), of_shape(shape))));
    let mirrors = contents.mirrors.iter().map(Mirror::shape);
    figures.extend(mirrors.map(|shape| plain(Role::Mirror, shape.kind(), of_mirror(shape))));
    let glass = contents.glass.iter().map(Glass::shape);
    figures.extend(glass.map(|shape| plain(Role::Glass, shape.kind(), of_glass(shape))));
    let name = |shape: &ReceiverShape| match shape {
        ReceiverShape::Triangle(_) => "triangle",
        _ => shape.as_shape().kind(),
    };
    let surfaces = contents.diffuse.iter().map(super::DiffuseSurface::shape);
    figures.extend(surfaces.map(|shape| plain(Role::Diffuse, name(shape), of_shape(&shape.as_shape()))));
    figures.extend(contents.receiver.iter().map(|receiver| Figure {
        is_textured: receiver.texture().is_some(),
        ..plain(Role::Receiver, name(receiver.shape()), of_shape(&receiver.shape().as_shape()))
    }));
    figures
}

fn of_shape(shape: &Shape) -> Vec<Stroke> {
    vec![match shape {
        Shape::Disk(s) => circle(s.center(), s.normal(), s.radius()),
        Shape::Sphere(s) => Stroke::Round { center: s.center(), normal: None, radius: s.radius() },
        Shape::Rectangle(s) => corners(s),
        Shape::Polygon(s) => Stroke::Closed(s.vertices().to_vec()),
        Shape::Mesh(s) => Stroke::Hull(outermost(s)),
    }]
}

fn circle(center: DVec3, normal: DVec3, radius: f64) -> Stroke {
    Stroke::Round { center, normal: Some(normal), radius }
}

fn corners(rectangle: &Rectangle) -> Stroke {
    Stroke::Closed(rectangle.corners().to_vec())
}

fn of_lamp(lamp: &Lamp) -> Figure {
    let (shape, strokes) = match lamp {
        Lamp::Point(lamp) => ("point", vec![Stroke::Open(vec![lamp.position()])]),
        Lamp::Beam(beam) => {
            let (from, along) = (beam.center(), beam.direction());
            let arrow = Stroke::Open(vec![from, from + along * (2.0 * beam.radius())]);
            ("beam", vec![circle(from, along, beam.radius()), arrow])
        }
    };
    Figure { role: Role::Lamp, shape, is_textured: false, strokes }
}

fn of_mirror(shape: &MirrorShape) -> Vec<Stroke> {
    match shape {
        MirrorShape::Rectangle(s) => vec![corners(s)],
        MirrorShape::Polygon(s) => vec![Stroke::Closed(s.vertices().to_vec())],
        MirrorShape::Disk(s) => vec![circle(s.center(), s.normal(), s.radius())],
        MirrorShape::Sphere(s) => vec![Stroke::Round { center: s.center(), normal: None, radius: s.radius() }],
        MirrorShape::SphereCap(s) => {
            let (sphere, axis) = (s.sphere(), s.axis());
            let widest = (s.rim_radius() / sphere.radius()).clamp(-1.0, 1.0).asin();
            let widest = if s.rim_height() < 0.0 { 0.5 * TAU - widest } else { widest };
            let mut strokes = vec![circle(sphere.center() + axis * s.rim_height(), axis, s.rim_radius())];
            strokes.extend(across(axis).map(|side| {
                Stroke::Open(curve(-widest, widest, |angle| {
                    sphere.center() + (axis * angle.cos() + side * angle.sin()) * sphere.radius()
                }))
            }));
            strokes
        }
        MirrorShape::Cylinder(s) => {
            let (axis, toward) = (s.axis(), s.toward());
            let side = axis.cross(toward);
            let half = 0.5 * s.arc();
            let round = |angle: f64| (toward * angle.cos() + side * angle.sin()) * s.radius();
            let ends = [-0.5, 0.5].map(|share| s.center() + axis * (share * s.height()));
            let mut strokes: Vec<Stroke> =
                ends.iter().map(|end| Stroke::Open(curve(-half, half, |angle| *end + round(angle)))).collect();
            // Its outermost lines: where the arc ends, and the quarters between.
            let quarters = (-2..=2).map(|k| 0.25 * TAU * f64::from(k)).filter(|angle| angle.abs() < half);
            strokes.extend(
                quarters.chain([-half, half]).map(|angle| Stroke::Open(ends.map(|end| end + round(angle)).to_vec())),
            );
            strokes
        }
        MirrorShape::Paraboloid(s) => {
            let (vertex, axis, rim) = (s.vertex(), s.axis(), s.rim_radius());
            let mut strokes = vec![circle(vertex + axis * s.depth(), axis, rim)];
            strokes.extend(across(axis).map(|side| {
                Stroke::Open(curve(-rim, rim, |r| vertex + side * r + axis * (r * r / (4.0 * s.focal_length()))))
            }));
            strokes
        }
    }
}

fn of_glass(shape: &GlassShape) -> Vec<Stroke> {
    match shape {
        GlassShape::Sphere(s) => vec![Stroke::Round { center: s.center(), normal: None, radius: s.radius() }],
        GlassShape::Slab(s) => s.faces().iter().map(corners).collect(),
        GlassShape::PlanoConvex(s) => {
            let (middle, axis, radius) = (s.curvature_center(), s.axis(), s.curvature_radius());
            let from_middle = s.vertex() - middle;
            let up = from_middle / from_middle.length().max(f64::MIN_POSITIVE);
            let half = (s.rim_radius() / radius).clamp(-1.0, 1.0).asin();
            let rim = middle + up * (radius * half.cos());
            let mut strokes = vec![circle(rim, axis, s.rim_radius())];
            strokes.extend(across(axis).map(|side| {
                Stroke::Closed(curve(-half, half, |angle| middle + (up * angle.cos() + side * angle.sin()) * radius))
            }));
            strokes
        }
    }
}

fn curve(from: f64, to: f64, at: impl Fn(f64) -> DVec3) -> Vec<DVec3> {
    (0..=CURVE).map(|k| at(from + (to - from) * k as f64 / CURVE as f64)).collect()
}

/// Two unit vectors square to a direction and to each other, along the room's axes where that can be.
fn across(axis: DVec3) -> [DVec3; 2] {
    let least = [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .min_by(|a, b| a.dot(axis).abs().total_cmp(&b.dot(axis).abs()))
        .unwrap_or(DVec3::X);
    let first = (least - axis * least.dot(axis)).normalize();
    [first, axis.cross(first)]
}

/// Vertices that lie outermost in directions spread over the sphere, each once.
fn outermost(mesh: &Mesh) -> Vec<DVec3> {
    let vertices = mesh.vertices();
    let golden = TAU * (1.0 - 0.5 * (5f64.sqrt() - 1.0));
    let mut found: Vec<usize> = (0..DIRECTIONS)
        .filter_map(|k| {
            let z = 1.0 - 2.0 * (k as f64 + 0.5) / DIRECTIONS as f64;
            let (sin, cos) = (golden * k as f64).sin_cos();
            let toward = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            (0..vertices.len()).max_by(|a, b| vertices[*a].dot(toward).total_cmp(&vertices[*b].dot(toward)))
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found.into_iter().map(|k| vertices[k]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;

    /// Every place that is drawn of one thing.
    fn places(figure: &Figure) -> Vec<DVec3> {
        let of = |stroke: &Stroke| match stroke {
            Stroke::Round { center, .. } => vec![*center],
            Stroke::Closed(through) | Stroke::Open(through) | Stroke::Hull(through) => through.clone(),
        };
        figure.strokes.iter().flat_map(of).collect()
    }

    #[test]
    fn every_thing_of_every_shipped_case_is_drawn_once_and_where_it_stands() {
        for case in case::select(&[]).unwrap() {
            let contents = case.configuration.contents();
            let figures = case.configuration.figures();
            let count = |role: Role| figures.iter().filter(|figure| figure.role == role).count();
            assert_eq!(count(Role::Source), contents.sources.len(), "{}", case.name);
            assert_eq!(count(Role::Occluder), contents.occluders.len(), "{}", case.name);
            assert_eq!(count(Role::Mirror), contents.mirrors.len(), "{}", case.name);
            assert_eq!(count(Role::Glass), contents.glass.len(), "{}", case.name);
            assert_eq!(count(Role::Receiver), usize::from(contents.receiver.is_some()), "{}", case.name);
            let mirrors = figures.iter().filter(|figure| figure.role == Role::Mirror).zip(&contents.mirrors);
            for (figure, mirror) in mirrors {
                let (middle, radius) = mirror.shape().bounding_sphere();
                for place in places(figure) {
                    let away = (place - middle).length();
                    assert!(away <= radius * (1.0 + 1e-9), "{}: {place} is {away} away", case.name);
                }
            }
            let glass = figures.iter().filter(|figure| figure.role == Role::Glass).zip(&contents.glass);
            for (figure, glass) in glass {
                let (middle, radius) = glass.shape().bounding_sphere();
                assert!(
                    places(figure).iter().all(|p| (*p - middle).length() <= radius * (1.0 + 1e-9)),
                    "{}",
                    case.name
                );
            }
        }
    }
}
