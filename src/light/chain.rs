//! A ray from the light to where it ends: through mirrors and glass to a diffuse surface, or nowhere.

use super::draws::Draws;
use super::interface::{Interface, reflected};
use super::map::Landing;
use super::room::{Met, Role, Room, Start};
use super::settings::{LightSettings, Rings, Split};
use super::tally::Tally;
use crate::geometry::{DVec3, Frame, TexelGrid};

/// A branch that carries less than this share of its ray's first flux splits no further: one part is chosen.
pub(super) const FAINT: f64 = 1.0 / 1024.0;
/// Squared sine of the angle between two planes of incidence that count as one: 1e-6 turns 1e-12 of the difference between
/// s and p.
const SAME_PLANE: f64 = 1e-12;
/// Squared sine of the angle of incidence below which s and p are treated alike: there is no plane to speak of.
const STRAIGHT: f64 = 1e-16;

/// A packet of flux on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub from: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    pub start: Start,
    /// The piece of glass that it is in.
    pub medium: Option<usize>,
    /// Flux with the field across the plane of incidence, and in it, W.
    s: f64,
    p: f64,
    /// Normal of the plane of incidence, of any length; nought before there was one.
    plane: DVec3,
    /// The square of its length.
    plane_squared: f64,
    /// Interactions so far.
    pub order: usize,
}

impl Ray {
    /// Unpolarised light.
    pub fn new(from: DVec3, direction: DVec3, start: Start, medium: Option<usize>, flux: f64) -> Ray {
        let (s, p) = (0.5 * flux, 0.5 * flux);
        Ray { from, direction, start, medium, s, p, plane: DVec3::ZERO, plane_squared: 0.0, order: 0 }
    }
    #[inline(always)]
    pub fn flux(&self) -> f64 {
        self.s + self.p
    }

    /// Tells s and p for the plane of incidence at a face: the same as before if the plane is, else unpolarised.
    #[inline(always)]
    fn turn(&mut self, normal: DVec3, tally: &mut Tally) {
        let across = self.direction.cross(normal);
        let squared = across.length_squared();
        if squared < STRAIGHT {
            return;
        }
        let (before, before_squared) = (self.plane, self.plane_squared);
        (self.plane, self.plane_squared) = (across, squared);
        if before_squared == 0.0 || is_same_plane(before, before_squared, across, squared) {
            return;
        }
        let flux = self.flux();
        if self.s != self.p {
            tally.depolarised += 1;
            tally.depolarised_flux += flux;
        }
        (self.s, self.p) = (0.5 * flux, flux - 0.5 * flux);
    }
}

/// Whether two planes count as one, by their normals and the squares of their lengths.
#[inline(always)]
fn is_same_plane(a: DVec3, a_squared: f64, b: DVec3, b_squared: f64) -> bool {
    // Without a root where rounding cannot matter.
    let (sine, one) = (a.cross(b).length_squared(), a_squared * b_squared);
    if sine < 0.5 * SAME_PLANE * one || sine > 2.0 * SAME_PLANE * one {
        return sine < SAME_PLANE * one;
    }
    (a / a_squared.sqrt()).cross(b / b_squared.sqrt()).length_squared() <= SAME_PLANE
}

/// Where a chain of mirrors and glass ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    /// Met nothing any more.
    Escaped,
    /// At an occluding mesh.
    Mesh,
    /// At a surface that is no mirror, at a place of it.
    Surface { surface: usize, at: DVec3 },
    /// At the limit of interactions.
    Terminated,
}

/// What all chains of a run share.
pub(crate) struct Tracer<'a> {
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

    /// To the next meeting, and whether the ray goes on from there; what ends is booked.
    ///
    /// - `faint`: flux below which it splits no further, W; `branches`: takes what a split sends another way
    #[inline(always)]
    pub fn step(
        &self,
        ray: &mut Ray,
        faint: f64,
        branches: &mut Vec<Ray>,
        draws: &mut Draws,
        tally: &mut Tally,
    ) -> bool {
        match self.advance(ray, faint, branches, draws, tally) {
            Ok(goes_on) => return goes_on,
            Err(End::Escaped) => tally.escaped += ray.flux(),
            Err(End::Mesh) => tally.absorbed += ray.flux(),
            Err(End::Terminated) => tally.terminated += ray.flux(),
            Err(End::Surface { surface, at }) => match self.room.role(surface) {
                Role::Receives { map, inward } => {
                    let cosine = -ray.direction.dot(self.room.normal(surface, at));
                    if (cosine > 0.0) == inward {
                        tally.absorbed += ray.flux();
                    } else {
                        self.land(ray, map, at, tally);
                    }
                }
                Role::Scatters { albedo, transmittance } => {
                    let outward = self.room.normal(surface, at);
                    let Some(direction) = scattered(ray.direction, outward, albedo, transmittance, draws) else {
                        tally.absorbed += ray.flux();
                        return false;
                    };
                    let on = Ray::new(at, direction, Start::Face(surface), ray.medium, ray.flux());
                    *ray = Ray { order: ray.order, ..on };
                    return true;
                }
                Role::Absorbs | Role::Reflects { .. } => tally.absorbed += ray.flux(),
            },
        }
        false
    }

    /// To the next meeting: whether the ray goes on by mirror or glass (not from a black mirror), or where it ends, and
    /// then it is left as it came.
    #[inline(always)]
    pub fn advance(
        &self,
        ray: &mut Ray,
        faint: f64,
        branches: &mut Vec<Ray>,
        draws: &mut Draws,
        tally: &mut Tally,
    ) -> Result<bool, End> {
        let (distance, met) = self.room.nearest(ray.from, ray.direction, ray.start, ray.medium);
        let at = ray.from + ray.direction * distance;
        match met {
            Met::Nothing => Err(End::Escaped),
            Met::Mesh => Err(End::Mesh),
            Met::Face(surface) => match self.room.role(surface) {
                Role::Reflects { optic, reflectance } => {
                    tally.reached[optic] += 1;
                    if ray.order == self.depth {
                        return Err(End::Terminated);
                    }
                    Ok(self.mirror(ray, surface, at, reflectance, tally))
                }
                _ => Err(End::Surface { surface, at }),
            },
            Met::Glass(glass, part) => {
                tally.reached[self.room.optic_of_glass(glass)] += 1;
                if ray.order == self.depth {
                    return Err(End::Terminated);
                }
                let outward = self.room.glass_normal(glass, part, at);
                let (normal, through) = if ray.medium.is_some() { (-outward, None) } else { (outward, Some(glass)) };
                let face = self.room.media(glass, ray.medium.is_some()).meet(ray.direction, normal);
                ray.turn(normal, tally);
                (ray.from, ray.start) = (at, Start::Glass(glass, part));
                ray.order += 1;
                self.split(ray, face, normal, through, faint, branches, draws);
                Ok(true)
            }
        }
    }

    #[inline(always)]
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

    /// Whether anything is sent on.
    #[inline(always)]
    fn mirror(&self, ray: &mut Ray, surface: usize, at: DVec3, reflectance: f64, tally: &mut Tally) -> bool {
        let normal = self.room.normal(surface, at);
        let (s, p) = (ray.s * reflectance, ray.p * reflectance);
        tally.absorbed += ray.flux() - (s + p);
        if reflectance == 0.0 {
            return false;
        }
        // A mirror treats both polarisations alike, and mirrors their planes.
        if ray.plane_squared > 0.0 {
            let plane = ray.plane / ray.plane_squared.sqrt();
            (ray.plane, ray.plane_squared) = (plane - normal * (2.0 * plane.dot(normal)), 1.0);
        }
        let direction = reflected(ray.direction, normal);
        *ray = Ray { from: at, direction, start: Start::Face(surface), s, p, order: ray.order + 1, ..*ray };
        true
    }

    /// Sends a ray on from a face of glass, where it stands.
    ///
    /// - `through`: the medium behind the face
    #[expect(clippy::too_many_arguments, reason = "all that a face has to do with")]
    #[inline(always)]
    fn split(
        &self,
        ray: &mut Ray,
        face: Interface,
        normal: DVec3,
        through: Option<usize>,
        faint: f64,
        branches: &mut Vec<Ray>,
        draws: &mut Draws,
    ) {
        let Some(refracted) = face.refracted else {
            ray.direction = reflected(ray.direction, normal);
            return;
        };
        let (s, p) = (ray.s * face.reflectance_s, ray.p * face.reflectance_p);
        let (flux, returned) = (ray.flux(), s + p);
        if self.split == Split::Both && flux >= faint {
            if returned > 0.0 {
                branches.push(Ray { direction: reflected(ray.direction, normal), s, p, ..*ray });
            }
            (ray.s, ray.p) = (ray.s - s, ray.p - p);
            (ray.direction, ray.medium) = (refracted, through);
        } else if draws.unit() * flux < returned {
            // One part takes the flux of both; its polarisation stays.
            let s = s * (flux / returned);
            (ray.s, ray.p) = (s, flux - s);
            ray.direction = reflected(ray.direction, normal);
        } else {
            let s = (ray.s - s) * (flux / (flux - returned));
            (ray.s, ray.p) = (s, flux - s);
            (ray.direction, ray.medium) = (refracted, through);
        }
    }
}

/// A direction of a surface element, weighed by the cosine: a uniform point of the unit disk, lifted onto the hemisphere.
#[inline(always)]
pub(crate) fn cosine_direction(normal: DVec3, draws: &mut Draws) -> DVec3 {
    let frame = Frame::around(normal);
    let (x, y) = draws.disk();
    let height = (1.0 - (x * x + y * y)).max(0.0).sqrt();
    frame.tangent * x + frame.bitangent * y + normal * height
}

/// Where a shade sends a packet: out on the other side with a probability of the transmittance, back with that of the
/// albedo (its outside sends nothing back), diffusely; else nowhere.
///
/// - `outward`: unit normal
#[inline(always)]
pub(crate) fn scattered(
    direction: DVec3,
    outward: DVec3,
    albedo: f64,
    transmittance: f64,
    draws: &mut Draws,
) -> Option<DVec3> {
    let from_inside = direction.dot(outward) > 0.0;
    let beyond = if from_inside { outward } else { -outward };
    let chosen = draws.unit();
    if chosen < transmittance {
        Some(cosine_direction(beyond, draws))
    } else if from_inside && chosen < transmittance + albedo {
        Some(cosine_direction(-outward, draws))
    } else {
        None
    }
}
