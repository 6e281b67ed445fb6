//! A ray from the light to where it ends: through mirrors and glass to a diffuse surface, or nowhere.

use super::draws::Draws;
use super::interface::{Interface, reflected};
use super::map::Landing;
use super::room::{Met, Role, Room, Start};
use super::settings::{LightSettings, Rings, Split};
use super::tally::Tally;
use crate::geometry::{DVec3, TexelGrid};

/// A branch that carries less than this share of its ray's first flux splits no further: one part is chosen.
const FAINT: f64 = 1.0 / 1024.0;
/// Squared sine of the angle between two planes of incidence that count as one: 1e-6 turns 1e-12 of the difference between
/// s and p.
const SAME_PLANE: f64 = 1e-12;
/// Squared sine of the angle of incidence below which s and p are treated alike: there is no plane to speak of.
const STRAIGHT: f64 = 1e-16;

/// A packet of flux on its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub from: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    pub start: Start,
    /// The piece of glass that it is in.
    pub medium: Option<usize>,
    /// Flux with the field across the plane of incidence, and in it, W.
    s: f64,
    p: f64,
    /// Unit normal of the plane of incidence; nought before there was one.
    plane: DVec3,
    /// Interactions so far.
    order: usize,
}

impl Ray {
    /// Unpolarised light.
    pub fn new(from: DVec3, direction: DVec3, start: Start, medium: Option<usize>, flux: f64) -> Ray {
        Ray { from, direction, start, medium, s: 0.5 * flux, p: 0.5 * flux, plane: DVec3::ZERO, order: 0 }
    }
    #[inline]
    fn flux(&self) -> f64 {
        self.s + self.p
    }
}

/// What all chains of a run share.
pub(super) struct Tracer<'a> {
    pub room: &'a Room,
    pub landings: &'a [Landing],
    pub depth: usize,
    pub split: Split,
    pub rings: Option<Rings>,
    pub tiles: Option<TexelGrid>,
}

impl<'a> Tracer<'a> {
    pub fn new(room: &'a Room, landings: &'a [Landing], settings: &LightSettings) -> Tracer<'a> {
        let LightSettings { depth, split, rings, tiles, .. } = *settings;
        Tracer { room, landings, depth, split, rings, tiles }
    }

    /// Follows a ray and its branches to their ends, and books all of its flux.
    ///
    /// - `branches`: scratch, empty before and after
    pub fn follow(&self, ray: Ray, branches: &mut Vec<Ray>, draws: &mut Draws, tally: &mut Tally) {
        let faint = ray.flux() * FAINT;
        tally.rays += 1;
        tally.emitted += ray.flux();
        let mut ray = ray;
        loop {
            while let Some(next) = self.step(ray, faint, branches, draws, tally) {
                ray = next;
            }
            match branches.pop() {
                Some(branch) => ray = branch,
                None => return,
            }
        }
    }

    /// To the next meeting: the ray that goes on from there, if one does.
    #[inline]
    fn step(
        &self,
        ray: Ray,
        faint: f64,
        branches: &mut Vec<Ray>,
        draws: &mut Draws,
        tally: &mut Tally,
    ) -> Option<Ray> {
        let (distance, met) = self.room.nearest(ray.from, ray.direction, ray.start, ray.medium);
        let at = ray.from + ray.direction * distance;
        match met {
            Met::Nothing => {
                tally.escaped += ray.flux();
                None
            }
            Met::Mesh => {
                tally.absorbed += ray.flux();
                None
            }
            Met::Face(surface) => match self.room.role(surface) {
                Role::Absorbs => {
                    tally.absorbed += ray.flux();
                    None
                }
                Role::Receives { map, inward } => {
                    let cosine = -ray.direction.dot(self.room.normal(surface, at));
                    if (cosine > 0.0) == inward {
                        tally.absorbed += ray.flux();
                    } else {
                        self.land(&ray, map, at, tally);
                    }
                    None
                }
                Role::Reflects { optic, reflectance } => self.mirror(ray, surface, at, optic, reflectance, tally),
            },
            Met::Glass(glass, part) => {
                tally.reached[self.room.optic_of_glass(glass)] += 1;
                if ray.order == self.depth {
                    tally.terminated += ray.flux();
                    return None;
                }
                let mut normal = self.room.glass_normal(glass, part, at);
                let (mut from, mut into) = (1.0, self.room.ior(glass));
                let leaves = ray.medium.is_some();
                if leaves {
                    (from, into, normal) = (into, from, -normal);
                }
                let arrived = Ray {
                    from: at,
                    start: Start::Glass(glass, part),
                    order: ray.order + 1,
                    ..self.turned(ray, normal, tally)
                };
                let face = Interface::meet(ray.direction, normal, from, into);
                let through = if leaves { None } else { Some(glass) };
                self.split(arrived, face, normal, through, faint, branches, draws)
            }
        }
    }

    fn land(&self, ray: &Ray, map: usize, at: DVec3, tally: &mut Tally) {
        let flux = ray.flux();
        tally.deposit(self.landings[map].cell(at, ray.order > 0), flux);
        tally.orders.add(map * (self.depth + 1) + ray.order, flux);
        // Rings lie on the receiver, whose map is the first.
        if let (Some(rings), true) = (self.rings, map == 0) {
            let ring = (at - rings.center).length() / rings.radius * rings.count as f64;
            if ring < rings.count as f64 {
                tally.rings.add(ray.order * rings.count + ring as usize, flux);
            }
        }
        if let (Some(tiles), true) = (self.tiles, map == 0) {
            let tile = tiles.index(tiles.texel(self.landings[map].parametrisation.to_map(at)));
            tally.tiles.add(ray.order * tiles.n_texels() + tile, flux);
        }
    }

    fn mirror(
        &self,
        ray: Ray,
        surface: usize,
        at: DVec3,
        optic: usize,
        reflectance: f64,
        tally: &mut Tally,
    ) -> Option<Ray> {
        tally.reached[optic] += 1;
        if ray.order == self.depth {
            tally.terminated += ray.flux();
            return None;
        }
        let normal = self.room.normal(surface, at);
        let (s, p) = (ray.s * reflectance, ray.p * reflectance);
        tally.absorbed += ray.flux() - (s + p);
        if reflectance == 0.0 {
            return None;
        }
        // A mirror treats both polarisations alike, and mirrors their planes.
        let plane = ray.plane - normal * (2.0 * ray.plane.dot(normal));
        let direction = reflected(ray.direction, normal);
        Some(Ray { from: at, direction, start: Start::Face(surface), s, p, plane, order: ray.order + 1, ..ray })
    }

    /// The ray with s and p told for the plane of incidence at a face: the same as before if the plane is, else unpolarised.
    fn turned(&self, ray: Ray, normal: DVec3, tally: &mut Tally) -> Ray {
        let across = ray.direction.cross(normal);
        let squared = across.length_squared();
        if squared < STRAIGHT {
            return ray;
        }
        let plane = across / squared.sqrt();
        if ray.plane == DVec3::ZERO || ray.plane.cross(plane).length_squared() <= SAME_PLANE {
            return Ray { plane, ..ray };
        }
        let flux = ray.flux();
        if ray.s != ray.p {
            tally.depolarised += 1;
            tally.depolarised_flux += flux;
        }
        Ray { s: 0.5 * flux, p: flux - 0.5 * flux, plane, ..ray }
    }

    /// Sends a ray on from a face of glass.
    ///
    /// - `through`: the medium behind the face
    #[expect(clippy::too_many_arguments, reason = "all that a face has to do with")]
    #[inline]
    fn split(
        &self,
        ray: Ray,
        face: Interface,
        normal: DVec3,
        through: Option<usize>,
        faint: f64,
        branches: &mut Vec<Ray>,
        draws: &mut Draws,
    ) -> Option<Ray> {
        let back = |s: f64, p: f64| Ray { direction: reflected(ray.direction, normal), s, p, ..ray };
        let Some(direction) = face.refracted else { return Some(back(ray.s, ray.p)) };
        let on = |s: f64, p: f64| Ray { direction, medium: through, s, p, ..ray };
        let (s, p) = (ray.s * face.reflectance_s, ray.p * face.reflectance_p);
        let (flux, returned) = (ray.flux(), s + p);
        if self.split == Split::Both && flux >= faint {
            if returned > 0.0 {
                branches.push(back(s, p));
            }
            return Some(on(ray.s - s, ray.p - p));
        }
        // One part takes the flux of both; its polarisation stays.
        if draws.unit() * flux < returned {
            let scale = flux / returned;
            let s = s * scale;
            Some(back(s, flux - s))
        } else {
            let scale = flux / (flux - returned);
            let s = (ray.s - s) * scale;
            Some(on(s, flux - s))
        }
    }
}
