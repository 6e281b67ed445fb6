//! All that a ray from the light can meet, and which of it it meets first.

use super::body::{Body, Part};
use super::face::{Face, Sides};
use super::interface::Media;
use crate::configuration::{Configuration, MirrorShape, ReceiverShape};
use crate::geometry::{DVec3, Shape};
use crate::scene::Hierarchy;

/// What a surface without thickness does with a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Role {
    /// Occluders and sources.
    Absorbs,
    /// The index of the optic, and its reflectance.
    Reflects { optic: usize, reflectance: f64 },
    /// Which map: on the front only; the back absorbs. Of an enclosure the front is the inside.
    Receives { map: usize, inward: bool },
    /// A shade: lets through, and sends back inside.
    Scatters { albedo: f64, transmittance: f64 },
}

#[derive(Clone, Debug)]
struct Surface {
    face: Face,
    role: Role,
    sides: Sides,
}

/// Which surface a ray starts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    Nowhere,
    Face(usize),
    Glass(usize, Part),
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Met {
    Nothing,
    Face(usize),
    Glass(usize, Part),
    /// An occluding mesh.
    Mesh,
}

/// A piece of glass.
#[derive(Clone, Debug)]
struct Piece {
    body: Body,
    ior: f64,
    /// From outside to inside, and back.
    media: [Media; 2],
    /// The surfaces that may lie inside, in their order.
    within: Vec<usize>,
}

/// A configuration, prepared for rays from the light.
pub(crate) struct Room {
    surfaces: Vec<Surface>,
    /// All of them, by index.
    all: Vec<usize>,
    glass: Vec<Piece>,
    meshes: Vec<Hierarchy>,
    /// Holds every surface: no mesh lies beyond.
    bounds: (DVec3, DVec3),
    /// The surface of each of [`Configuration::sources`].
    of_source: Vec<usize>,
    /// The surface of each diffuse surface.
    of_diffuse: Vec<usize>,
    of_receiver: Option<usize>,
    n_maps: usize,
    n_mirrors: usize,
}

impl Room {
    pub fn new(configuration: &Configuration) -> Room {
        let room = configuration.contents();
        let mut surfaces = Vec::new();
        let mut add = |face: Face, role: Role, sides: Sides| {
            surfaces.push(Surface { face, role, sides });
            surfaces.len() - 1
        };
        let mut of_source: Vec<usize> = room
            .sources
            .iter()
            .filter_map(|source| Some(add(face_of(source.shape())?, Role::Absorbs, Sides::Both)))
            .collect();
        room.occluders.iter().filter_map(face_of).for_each(|face| {
            add(face, Role::Absorbs, Sides::Both);
        });
        for (optic, mirror) in room.mirrors.iter().enumerate() {
            let role = Role::Reflects { optic, reflectance: mirror.reflectance() };
            add(face_of_mirror(mirror.shape()), role, Sides::Both);
        }
        let mut n_maps = 0;
        let mut of_receiver = None;
        if let Some(receiver) = &room.receiver {
            let role = Role::Receives { map: 0, inward: false };
            of_receiver = Some(add(face_of_receiver(receiver.shape()), role, Sides::Front));
            n_maps = 1;
        }
        let mut of_diffuse = Vec::new();
        for surface in &room.diffuse {
            let inward = surface.is_inward();
            let role = match surface.transmittance() {
                0.0 => Role::Receives { map: n_maps, inward },
                transmittance => Role::Scatters { albedo: surface.albedo().ratio(), transmittance },
            };
            let index = add(face_of_receiver(surface.shape()), role, Sides::Both);
            of_diffuse.push(index);
            n_maps += 1;
            if surface.exitance().watts_per_square_metre() > 0.0 && !inward {
                of_source.push(index);
            }
        }
        let glass = room.glass.iter().map(|glass| {
            let (ior, (center, radius)) = (glass.ior(), glass.shape().bounding_sphere());
            let may_be_within = |surface: &Surface| !surface.face.is_clear_of(center, radius);
            let within = (0..surfaces.len()).filter(|k| may_be_within(&surfaces[*k])).collect();
            let media = [Media::new(1.0, ior), Media::new(ior, 1.0)];
            Piece { body: Body::new(glass.shape()), ior, media, within }
        });
        let glass = glass.collect();
        let bounds = bounds(configuration);
        let meshes = room.occluders.iter().filter_map(|shape| match shape {
            Shape::Mesh(mesh) => Some(Hierarchy::new(mesh, bounds)),
            _ => None,
        });
        let meshes = meshes.collect();
        let n_mirrors = room.mirrors.len();
        let all = (0..surfaces.len()).collect();
        Room { surfaces, all, glass, meshes, bounds, of_source, of_diffuse, of_receiver, n_maps, n_mirrors }
    }

    /// The surface of one of [`Configuration::sources`].
    pub fn of_source(&self, source: usize) -> Start {
        Start::Face(self.of_source[source])
    }
    pub fn of_diffuse(&self, surface: usize) -> Start {
        Start::Face(self.of_diffuse[surface])
    }
    pub fn of_receiver(&self) -> Option<usize> {
        self.of_receiver
    }
    /// The receiver's map, then one for each diffuse surface.
    pub fn n_maps(&self) -> usize {
        self.n_maps
    }
    /// Mirrors, then pieces of glass.
    pub fn n_optics(&self) -> usize {
        self.n_mirrors + self.glass.len()
    }
    #[inline(always)]
    pub fn optic_of_glass(&self, glass: usize) -> usize {
        self.n_mirrors + glass
    }
    pub fn ior(&self, glass: usize) -> f64 {
        self.glass[glass].ior
    }
    /// The media at its faces, as a ray comes through them from outside or, as it `leaves`, from inside.
    #[inline(always)]
    pub fn media(&self, glass: usize, leaves: bool) -> &Media {
        &self.glass[glass].media[usize::from(leaves)]
    }
    /// Surfaces without thickness; those of sources come first, in their order.
    pub fn n_surfaces(&self) -> usize {
        self.surfaces.len()
    }
    #[inline(always)]
    pub fn role(&self, surface: usize) -> Role {
        self.surfaces[surface].role
    }
    #[inline(always)]
    pub fn normal(&self, surface: usize, at: DVec3) -> DVec3 {
        self.surfaces[surface].face.normal(at)
    }
    #[inline(always)]
    pub fn glass_normal(&self, glass: usize, part: Part, at: DVec3) -> DVec3 {
        self.glass[glass].body.normal(part, at)
    }
    /// The piece of glass that a point lies in.
    pub fn medium_at(&self, point: DVec3) -> Option<usize> {
        self.glass.iter().position(|piece| piece.body.holds(point))
    }

    /// What a ray meets first, and how far away, metres.
    ///
    /// - `direction`: unit vector; `medium`: the piece of glass that the ray is in
    #[inline(always)]
    pub fn nearest(&self, from: DVec3, direction: DVec3, start: Start, medium: Option<usize>) -> (f64, Met) {
        let mut found = (f64::INFINITY, Met::Nothing);
        let mut within = &self.all;
        match medium {
            Some(glass) => {
                let left = match start {
                    Start::Glass(index, part) if index == glass => Some(part),
                    _ => None,
                };
                let piece = &self.glass[glass];
                let (distance, part) = piece.body.leave(from, direction, left);
                found = (distance, Met::Glass(glass, part));
                within = &piece.within;
            }
            None => {
                for (glass, piece) in self.glass.iter().enumerate() {
                    if matches!(start, Start::Glass(index, _) if index == glass) {
                        continue;
                    }
                    if let Some((distance, part)) = piece.body.enter(from, direction)
                        && distance < found.0
                    {
                        found = (distance, Met::Glass(glass, part));
                    }
                }
            }
        }
        for index in within {
            let surface = &self.surfaces[*index];
            let starts_here = start == Start::Face(*index);
            if let Some(distance) = surface.face.meet(from, direction, starts_here, surface.sides)
                && distance < found.0
            {
                found = (distance, Met::Face(*index));
            }
        }
        if !self.meshes.is_empty() {
            // A mesh is asked only whether it comes before: what it stops is absorbed, wherever that is.
            let far = self.way_out(from, direction).min(found.0);
            if self.mesh_before(from, direction, far) {
                found = (far, Met::Mesh);
            }
        }
        found
    }

    /// Whether a mesh comes before a distance, metres.
    pub fn mesh_before(&self, from: DVec3, direction: DVec3, far: f64) -> bool {
        // The hierarchy is made for ends within the bounds: from outside of them, the way in meets none.
        let near = self.way_in(from, direction);
        far > near && self.meshes.iter().any(|mesh| mesh.blocks(from + direction * near, from + direction * far))
    }

    /// How far along a ray the room begins; nought for a ray that starts within it.
    fn way_in(&self, from: DVec3, direction: DVec3) -> f64 {
        let (low, high) = self.bounds;
        if from.cmpge(low).all() && from.cmple(high).all() {
            return 0.0;
        }
        let of_axis = |k: usize| {
            let border = if direction[k] > 0.0 { low[k] } else { high[k] };
            let distance = (border - from[k]) / direction[k];
            if distance.is_finite() { distance } else { 0.0 }
        };
        of_axis(0).max(of_axis(1)).max(of_axis(2)).max(0.0)
    }

    /// How far along a ray the room ends; not above nought where the ray is out of it for good.
    fn way_out(&self, from: DVec3, direction: DVec3) -> f64 {
        let (low, high) = self.bounds;
        let of_axis = |k: usize| {
            let border = if direction[k] > 0.0 { high[k] } else { low[k] };
            if direction[k] == 0.0 { f64::INFINITY } else { (border - from[k]) / direction[k] }
        };
        of_axis(0).min(of_axis(1)).min(of_axis(2))
    }
}

fn face_of(shape: &Shape) -> Option<Face> {
    match shape {
        Shape::Disk(s) => Some(Face::disk(s)),
        Shape::Rectangle(s) => Some(Face::rectangle(s)),
        Shape::Polygon(s) => Some(Face::of_polygon(s)),
        Shape::Sphere(s) => Some(Face::sphere(s)),
        Shape::Mesh(_) => None,
    }
}

fn face_of_mirror(shape: &MirrorShape) -> Face {
    match shape {
        MirrorShape::Rectangle(s) => Face::rectangle(s),
        MirrorShape::Polygon(s) => Face::of_polygon(s),
        MirrorShape::Disk(s) => Face::disk(s),
        MirrorShape::Sphere(s) => Face::sphere(s),
        MirrorShape::SphereCap(s) => Face::cap(s),
        MirrorShape::Cylinder(s) => Face::cylinder(s),
        MirrorShape::Paraboloid(s) => Face::paraboloid(s),
    }
}

fn face_of_receiver(shape: &ReceiverShape) -> Face {
    match shape {
        ReceiverShape::Rectangle(s) => Face::rectangle(s),
        ReceiverShape::Disk(s) => Face::disk(s),
        ReceiverShape::Triangle(s) => Face::polygon(&s.vertices(), s.normal()),
        ReceiverShape::Sphere(s) => Face::sphere(s),
    }
}

/// A box that holds everything that a ray can start from or that a mesh is made of, metres.
fn bounds(configuration: &Configuration) -> (DVec3, DVec3) {
    let room = configuration.contents();
    let mut reach = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut hold = |low: DVec3, high: DVec3| reach = (reach.0.min(low), reach.1.max(high));
    let shapes = configuration.sources().iter().map(|source| source.shape()).chain(configuration.blockers());
    for (low, high) in shapes.map(Shape::bounds) {
        hold(low, high);
    }
    let of_mirrors = room.mirrors.iter().map(|mirror| mirror.shape().bounding_sphere());
    let of_glass = room.glass.iter().map(|glass| glass.shape().bounding_sphere());
    let of_lamps = room.lamps.iter().map(|lamp| match lamp {
        crate::configuration::Lamp::Point(lamp) => (lamp.position(), 0.0),
        crate::configuration::Lamp::Beam(lamp) => (lamp.center(), lamp.radius()),
    });
    for (center, radius) in of_mirrors.chain(of_glass).chain(of_lamps) {
        hold(center - radius, center + radius);
    }
    for surface in &room.diffuse {
        let (low, high) = surface.as_shape().bounds();
        hold(low, high);
    }
    // A hair more, for rays that start on the border.
    let slack = (reach.1 - reach.0).max_element().max(f64::MIN_POSITIVE) * 1e-6;
    (reach.0 - slack, reach.1 + slack)
}
