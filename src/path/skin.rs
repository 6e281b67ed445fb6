//! What each surface of a room emits and sends on.

use crate::configuration::{Configuration, DiffuseSurface, Receiver, ReceiverShape, Source};
use crate::geometry::{DVec3, Polygon, Shape};
use crate::light::{Role, Room, Start};
use crate::sampling::Surface;

/// One surface, as a path meets it.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    pub glow: Glow,
    pub sends: Sends,
}

/// What a surface emits.
#[derive(Clone, Debug)]
pub(super) enum Glow {
    Dark,
    /// On its front.
    Source(Source),
    /// On the inside of an enclosure, W/m².
    Inside(f64),
}

impl Glow {
    /// W/m², at a place that is met on its outside (a sphere) or front.
    ///
    /// - `on_front`: whether it is
    #[inline]
    pub fn at(&self, place: DVec3, on_front: bool) -> f64 {
        match self {
            Glow::Source(source) if on_front => source.exitance_at(place).watts_per_square_metre(),
            Glow::Inside(exitance) if !on_front => *exitance,
            _ => 0.0,
        }
    }
}

/// What a surface sends on.
#[derive(Clone, Debug)]
pub(super) enum Sends {
    Nothing,
    /// From its front, or from the inside of an enclosure.
    Back {
        albedo: f64,
        inward: bool,
    },
    /// From its front, where the albedo is read from a texture.
    Read(Receiver),
    Shade {
        albedo: f64,
        transmittance: f64,
    },
}

/// All surfaces of a room, in its order.
pub(super) fn skins(configuration: &Configuration, room: &Room) -> Vec<Skin> {
    let contents = configuration.contents();
    let mut skins = vec![Skin { glow: Glow::Dark, sends: Sends::Nothing }; room.n_surfaces()];
    for (k, source) in configuration.sources().iter().enumerate() {
        if let Start::Face(index) = room.of_source(k) {
            skins[index].glow = Glow::Source(source.clone());
        }
    }
    if let (Some(index), Some(receiver)) = (room.of_receiver(), configuration.receiver()) {
        skins[index].sends = match (receiver.texture(), receiver.albedo()) {
            (Some(_), _) => Sends::Read(receiver.clone()),
            (None, Some(albedo)) => Sends::Back { albedo: albedo.ratio(), inward: false },
            (None, None) => Sends::Nothing,
        };
    }
    for (k, surface) in contents.diffuse.iter().enumerate() {
        let Start::Face(index) = room.of_diffuse(k) else { continue };
        skins[index].sends = match room.role(index) {
            Role::Scatters { albedo, transmittance } => Sends::Shade { albedo, transmittance },
            _ => Sends::Back { albedo: surface.albedo().ratio(), inward: surface.is_inward() },
        };
        let exitance = surface.exitance().watts_per_square_metre();
        if surface.is_inward() && exitance > 0.0 {
            skins[index].glow = Glow::Inside(exitance);
        }
    }
    skins
}

/// A surface that emits, as shadow rays aim at it.
pub(super) struct Target {
    pub surface: Surface,
    /// Of the room's.
    pub index: usize,
    /// Square metres.
    pub area: f64,
    /// 1 outwards, −1 for the inside of an enclosure.
    pub side: f64,
}

/// All surfaces that emit.
pub(super) fn targets(configuration: &Configuration, room: &Room) -> Vec<Target> {
    let target = |shape: &Shape, start: Start, side: f64| {
        let Start::Face(index) = start else { return None };
        Some(Target { surface: Surface::new(shape)?, index, area: shape.area(), side })
    };
    let bright = |exitance: f64| exitance > 0.0;
    let sources = configuration.sources().iter().enumerate();
    let sources = sources.filter(|(_, source)| bright(source.exitance().watts_per_square_metre()));
    let sources = sources.filter_map(|(k, source)| target(source.shape(), room.of_source(k), 1.0));
    let inside = |surface: &DiffuseSurface| surface.is_inward();
    let enclosures = configuration.diffuse().iter().enumerate();
    let enclosures =
        enclosures.filter(|(_, surface)| inside(surface) && bright(surface.exitance().watts_per_square_metre()));
    let enclosures = enclosures.filter_map(|(k, surface)| target(&surface.as_shape(), room.of_diffuse(k), -1.0));
    sources.chain(enclosures).collect()
}

/// A receiver's shape as one that points are drawn on.
pub(super) fn shape_of(receiver: &ReceiverShape) -> Shape {
    match receiver {
        ReceiverShape::Rectangle(s) => Shape::Rectangle(*s),
        ReceiverShape::Disk(s) => Shape::Disk(*s),
        ReceiverShape::Sphere(s) => Shape::Sphere(*s),
        ReceiverShape::Triangle(s) => {
            Shape::Polygon(Polygon::new(s.vertices().to_vec()).expect("a triangle is a polygon"))
        }
    }
}

/// Relative to a surface's size: nearer, a point lies on it.
const ON_SURFACE: f64 = 1e-9;

/// The diffuse surface or receiver that a point lies on, to rounding: a path from there knows that it starts on it.
pub(super) fn start_of(configuration: &Configuration, room: &Room, point: DVec3) -> Start {
    let lies_on = |shape: &ReceiverShape| match shape {
        ReceiverShape::Sphere(s) => ((point - s.center()).length() - s.radius()).abs() <= ON_SURFACE * s.radius(),
        // Beside its outline too: from within a plane it is not met.
        ReceiverShape::Rectangle(s) => in_plane(point - s.center(), s.normal()),
        ReceiverShape::Disk(s) => in_plane(point - s.center(), s.normal()),
        ReceiverShape::Triangle(s) => in_plane(point - s.vertices()[0], s.normal()),
    };
    if let (Some(receiver), Some(index)) = (configuration.receiver(), room.of_receiver())
        && lies_on(receiver.shape())
    {
        return Start::Face(index);
    }
    let diffuse = configuration.diffuse().iter().position(|surface| lies_on(surface.shape()));
    diffuse.map_or(Start::Nowhere, |k| room.of_diffuse(k))
}

fn in_plane(offset: DVec3, normal: DVec3) -> bool {
    offset.dot(normal).abs() <= ON_SURFACE * offset.length()
}
