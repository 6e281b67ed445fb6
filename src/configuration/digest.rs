//! A fingerprint of a configuration's physical content.

use std::fmt;

use glam::DVec3;

use super::sha256::Sha256;
use super::{Configuration, Contents, GlassShape, Lamp, MirrorShape, ReceiverShape};
use crate::geometry::{Rectangle, Shape, Sphere};
use crate::texture::{ExitancePolynomial, Lookup, Texture};

/// SHA-256 over the physical content: shapes, exitances, albedo and measurement points, each number by its bits.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Digest([u8; 32]);

impl Digest {
    pub(super) fn of(configuration: &Configuration) -> Digest {
        let room = configuration.contents();
        let mut content = Content(Sha256::new());
        content.tag("etendue configuration 1");
        content.count(room.sources.len());
        for source in &room.sources {
            content.shape(&source.shape);
            content.number(source.exitance.watts_per_square_metre());
            // What has no texture is fingerprinted as ever.
            source.texture.iter().for_each(|texture| content.texture(texture));
        }
        content.count(room.occluders.len());
        room.occluders.iter().for_each(|shape| content.shape(shape));
        if let Some(receiver) = &room.receiver {
            content.receiver(receiver.shape());
            content.number(receiver.albedo().map_or(-1.0, |albedo| albedo.ratio()));
            receiver.texture().into_iter().for_each(|texture| content.texture(texture));
        }
        content.count(room.points.len());
        for point in &room.points {
            content.vector(point.position);
            content.vector(point.normal);
        }
        // Rooms of area sources and occluders alone keep the fingerprint that they have always had.
        if !(room.lamps.is_empty() && room.mirrors.is_empty() && room.glass.is_empty() && room.diffuse.is_empty()) {
            content.lamps_and_optics(room);
        }
        Digest(content.0.finalize())
    }

    /// The first 64 bits, as a number to key random streams with.
    pub fn key(&self) -> u64 {
        u64::from_le_bytes(self.0[..8].try_into().expect("eight bytes"))
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Digest({self})")
    }
}

struct Content(Sha256);

impl Content {
    fn tag(&mut self, text: &str) {
        self.count(text.len());
        self.0.update(text.as_bytes());
    }
    fn count(&mut self, n: usize) {
        self.0.update(&(n as u64).to_le_bytes());
    }
    fn number(&mut self, x: f64) {
        // −0.0 and 0.0 are the same length.
        self.0.update(&(x + 0.0).to_bits().to_le_bytes());
    }
    fn vector(&mut self, v: DVec3) {
        v.to_array().into_iter().for_each(|c| self.number(c));
    }
    fn vectors(&mut self, vs: &[DVec3]) {
        self.count(vs.len());
        vs.iter().for_each(|v| self.vector(*v));
    }
    fn shape(&mut self, shape: &Shape) {
        self.tag(shape.kind());
        match shape {
            Shape::Disk(s) => {
                self.vector(s.center());
                self.vector(s.normal());
                self.number(s.radius());
            }
            Shape::Rectangle(s) => self.vectors(&[s.center(), s.edge_u(), s.edge_v()]),
            Shape::Polygon(s) => self.vectors(s.vertices()),
            Shape::Sphere(s) => {
                self.vector(s.center());
                self.number(s.radius());
            }
            Shape::Mesh(s) => {
                self.vectors(s.vertices());
                self.count(s.triangles().len());
                s.triangles().iter().flatten().for_each(|index| self.0.update(&index.to_le_bytes()));
            }
        }
    }
    fn lamps_and_optics(&mut self, room: &Contents) {
        self.tag("lamps");
        self.count(room.lamps.len());
        for lamp in &room.lamps {
            match lamp {
                Lamp::Point(lamp) => {
                    self.tag("point");
                    self.vector(lamp.position());
                    self.number(lamp.power().watts());
                }
                Lamp::Beam(lamp) => {
                    self.tag("beam");
                    self.vector(lamp.center());
                    self.vector(lamp.direction());
                    self.number(lamp.radius());
                    self.number(lamp.irradiance().watts_per_square_metre());
                }
            }
        }
        self.tag("mirrors");
        self.count(room.mirrors.len());
        for mirror in &room.mirrors {
            self.mirror(mirror.shape());
            self.number(mirror.reflectance());
        }
        self.tag("glass");
        self.count(room.glass.len());
        for glass in &room.glass {
            self.glass(glass.shape());
            self.number(glass.ior());
        }
        self.tag("diffuse");
        self.count(room.diffuse.len());
        for surface in &room.diffuse {
            self.receiver(surface.shape());
            self.number(surface.albedo().ratio());
            self.number(surface.exitance().watts_per_square_metre());
            self.count(usize::from(surface.is_inward()));
            if surface.transmittance() > 0.0 {
                self.tag("shade");
                self.number(surface.transmittance());
            }
        }
    }
    fn sphere(&mut self, s: &Sphere) {
        self.vector(s.center());
        self.number(s.radius());
    }
    fn rectangle(&mut self, s: &Rectangle) {
        self.vectors(&[s.center(), s.edge_u(), s.edge_v()]);
    }
    fn mirror(&mut self, shape: &MirrorShape) {
        match shape {
            MirrorShape::Rectangle(s) => self.shape(&Shape::Rectangle(*s)),
            MirrorShape::Polygon(s) => self.shape(&Shape::Polygon(s.clone())),
            MirrorShape::Disk(s) => self.shape(&Shape::Disk(*s)),
            MirrorShape::Sphere(s) => self.shape(&Shape::Sphere(*s)),
            MirrorShape::SphereCap(s) => {
                self.tag("cap");
                self.sphere(&s.sphere());
                self.vector(s.axis());
                self.number(s.rim_radius());
            }
            MirrorShape::Cylinder(s) => {
                self.tag("cylinder");
                self.vectors(&[s.center(), s.axis(), s.toward()]);
                [s.radius(), s.height(), s.arc()].into_iter().for_each(|x| self.number(x));
            }
            MirrorShape::Paraboloid(s) => {
                self.tag("paraboloid");
                self.vectors(&[s.vertex(), s.axis()]);
                [s.focal_length(), s.rim_radius()].into_iter().for_each(|x| self.number(x));
            }
        }
    }
    fn glass(&mut self, shape: &GlassShape) {
        self.tag(shape.kind());
        match shape {
            GlassShape::Sphere(s) => self.sphere(s),
            GlassShape::Slab(s) => {
                self.rectangle(&s.middle());
                self.number(s.thickness());
            }
            GlassShape::PlanoConvex(s) => {
                self.vectors(&[s.vertex(), s.axis()]);
                [s.curvature_radius(), s.rim_radius()].into_iter().for_each(|x| self.number(x));
            }
        }
    }
    fn texture(&mut self, texture: &Texture) {
        match texture {
            Texture::Texels(texels) => {
                self.tag(match texels.lookup() {
                    Lookup::Nearest => "texels",
                    Lookup::Bilinear => "texels, blended",
                });
                let grid = texels.raster().grid();
                self.count(grid.ns());
                self.count(grid.nt());
                texels.raster().values().iter().for_each(|value| self.number(*value));
                // The map by where it puts things: three places tell any two maps of one surface apart.
                for at in [[0.0, 0.0], [0.125, 0.25], [0.5, 0.625]] {
                    self.vector(texels.map().to_surface(at));
                }
            }
            Texture::Polynomial(on) => {
                self.tag("polynomial");
                let ExitancePolynomial { e00, e10, e01, e20, e11, e02 } = *on.polynomial();
                [e00, e10, e01, e20, e11, e02].into_iter().for_each(|e| self.number(e));
            }
        }
    }
    fn receiver(&mut self, shape: &ReceiverShape) {
        match shape {
            ReceiverShape::Rectangle(s) => self.shape(&Shape::Rectangle(*s)),
            ReceiverShape::Disk(s) => self.shape(&Shape::Disk(*s)),
            ReceiverShape::Sphere(s) => self.shape(&Shape::Sphere(*s)),
            ReceiverShape::Triangle(s) => {
                self.tag("triangle");
                self.vectors(&s.vertices());
            }
        }
    }
}
