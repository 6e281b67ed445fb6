//! What sends rays, and the rays that it sends in one group.

use std::sync::Arc;

use super::aim::{self, Cone, Lobe, Spot, Target};
use super::chain::Ray;
use super::draws::Draws;
use super::room::{Room, Start};
use super::settings::Aim;
use crate::configuration::{Configuration, Lamp, ReceiverShape};
use crate::geometry::{DVec3, Frame, Shape};
use crate::sampling::Surface;
use crate::texture::Texture;

/// Rays at each target for one that goes elsewhere.
const AIMED_FOR_ONE: usize = 8;

/// A source, prepared.
pub(super) struct Emitter {
    /// In closed form, W.
    pub power: f64,
    kind: Kind,
    /// Whether rays may start in glass.
    near_glass: bool,
}

enum Kind {
    Point {
        position: DVec3,
        cones: Vec<Cone>,
    },
    Beam {
        center: DVec3,
        radius: f64,
        frame: Frame,
        spots: Vec<Spot>,
    },
    /// `side`: 1 outwards, −1 for the inside of an enclosure.
    Area {
        surface: Surface,
        start: Start,
        side: f64,
        targets: Vec<Target>,
        texture: Option<Arc<Texture>>,
    },
}

/// Scratch of one batch.
#[derive(Default)]
pub(super) struct Group {
    pub rays: Vec<Ray>,
    lobes: Vec<Lobe>,
}

/// All emitters of a configuration: its sources, lamps, and enclosures that emit, in this order.
pub(super) fn emitters(configuration: &Configuration, room: &Room, aim: Aim) -> Vec<Emitter> {
    let contents = configuration.contents();
    let of_mirrors = contents.mirrors.iter().map(|mirror| mirror.shape().bounding_sphere());
    let of_glass = contents.glass.iter().map(|glass| glass.shape().bounding_sphere());
    let target = |(center, radius)| Target { center, radius };
    let targets: Vec<Target> = match aim {
        Aim::Optics => of_mirrors.chain(of_glass).map(target).collect(),
        Aim::Nowhere => Vec::new(),
    };
    let is_near = |ball: &Target| {
        contents.glass.iter().any(|glass| {
            let (center, radius) = glass.shape().bounding_sphere();
            (center - ball.center).length() <= radius + ball.radius
        })
    };
    let area = |shape: &Shape, texture: Option<&Arc<Texture>>, start: Start, side: f64, power: f64| {
        let (low, high) = shape.bounds();
        let ball = match shape {
            Shape::Sphere(s) => Target { center: s.center(), radius: s.radius() },
            _ => Target { center: low * 0.5 + high * 0.5, radius: 0.5 * (high - low).length() },
        };
        let surface = Surface::new(shape)?;
        let mut targets = aim::apart(targets.clone(), ball);
        // From within a target there is nothing to aim at.
        if targets.iter().any(|target| (target.center - ball.center).length() <= target.radius) {
            targets.clear();
        }
        let kind = Kind::Area { surface, start, side, targets, texture: texture.cloned() };
        Some(Emitter { power, kind, near_glass: is_near(&ball) })
    };
    let sources = configuration.sources().iter().enumerate().filter_map(|(k, source)| {
        let power = source.exitance().watts_per_square_metre() * source.shape().area();
        area(source.shape(), source.texture(), room.of_source(k), 1.0, power)
    });
    let lamps = contents.lamps.iter().map(|lamp| match lamp {
        Lamp::Point(lamp) => {
            let eye = Target { center: lamp.position(), radius: 0.0 };
            let cones = aim::cones(&aim::apart(targets.clone(), eye), lamp.position());
            let kind = Kind::Point { position: lamp.position(), cones };
            Emitter { power: lamp.power().watts(), kind, near_glass: is_near(&eye) }
        }
        Lamp::Beam(lamp) => {
            let (frame, radius) = (Frame::around(lamp.direction()), lamp.radius());
            let spots = aim::spots(&targets, lamp.center(), &frame, radius);
            let ball = Target { center: lamp.center(), radius };
            let kind = Kind::Beam { center: lamp.center(), radius, frame, spots };
            Emitter { power: lamp.power().watts(), kind, near_glass: is_near(&ball) }
        }
    });
    let enclosures = contents.diffuse.iter().enumerate().filter(|(_, surface)| surface.is_inward());
    let enclosures = enclosures.filter_map(|(k, surface)| {
        let ReceiverShape::Sphere(sphere) = surface.shape() else { return None };
        let power = surface.exitance().watts_per_square_metre() * sphere.area();
        area(&Shape::Sphere(*sphere), None, room.of_diffuse(k), -1.0, power)
    });
    let all = sources.chain(lamps).chain(enclosures);
    all.filter(|emitter| emitter.power > 0.0).collect()
}

impl Emitter {
    /// The most rays of one group.
    pub fn rays_a_group(&self) -> usize {
        let domains = match &self.kind {
            Kind::Point { cones, .. } => cones.len(),
            Kind::Beam { spots, .. } => spots.len(),
            Kind::Area { targets, .. } => targets.len(),
        };
        AIMED_FOR_ONE * domains + 1
    }

    /// Fills a group with rays that together carry `flux`: some into each domain that is aimed at, one into the rest.
    #[inline(always)]
    pub fn send(&self, room: &Room, flux: f64, draws: &mut Draws, group: &mut Group) {
        let Group { rays, lobes } = group;
        rays.clear();
        let each = 1.0 / AIMED_FOR_ONE as f64;
        let medium = |at: DVec3| if self.near_glass { room.medium_at(at) } else { None };
        match &self.kind {
            Kind::Point { position, cones } => {
                let inside = medium(*position);
                let mut ray = |direction, share| {
                    rays.push(Ray::new(*position, direction, Start::Nowhere, inside, flux * share));
                };
                let mut rest = 1.0;
                for cone in cones {
                    rest -= cone.share();
                    for _ in 0..AIMED_FOR_ONE {
                        ray(cone.draw(draws), cone.share() * each);
                    }
                }
                ray(aim::outside(cones, draws), rest);
            }
            Kind::Beam { center, radius, frame, spots } => {
                let mut ray = |(x, y): (f64, f64), share: f64| {
                    let from = *center + (frame.tangent * x + frame.bitangent * y) * *radius;
                    rays.push(Ray::new(from, frame.normal, Start::Nowhere, medium(from), flux * share));
                };
                let mut rest = 1.0;
                for spot in spots {
                    rest -= spot.share();
                    for _ in 0..AIMED_FOR_ONE {
                        ray(spot.draw(draws), spot.share() * each);
                    }
                }
                ray(aim::place_outside(spots, draws), rest);
            }
            Kind::Area { surface, start, side, targets, texture } => {
                let offset = place(surface, texture.as_deref(), draws);
                let from = surface.origin() + offset;
                let normal = surface.flat_normal().unwrap_or_else(|| offset.normalize()) * *side;
                aim::lobes(targets, from, normal, lobes);
                let inside = medium(from);
                let mut ray = |direction, share| rays.push(Ray::new(from, direction, *start, inside, flux * share));
                let mut rest = 1.0;
                for lobe in lobes.iter() {
                    rest -= lobe.share();
                    for _ in 0..AIMED_FOR_ONE {
                        ray(lobe.draw(normal, draws), lobe.share() * each);
                    }
                }
                // Where aiming does not pay, all rays of the group go as they are emitted.
                let others = if lobes.is_empty() { AIMED_FOR_ONE * targets.len() + 1 } else { 1 };
                for _ in 0..others {
                    ray(aim::cosine_outside(lobes, normal, draws), rest / others as f64);
                }
            }
        }
    }
}

/// A place where a unit of emitted power starts, as an offset from the surface's origin: where a texture is brighter, more
/// often, so that all groups carry the same flux and the books hold the source's power as it is.
#[inline(always)]
fn place(surface: &Surface, texture: Option<&Texture>, draws: &mut Draws) -> DVec3 {
    let Some(texture) = texture else { return draws.on(surface) };
    let [_, brightest] = texture.range();
    loop {
        let offset = draws.on(surface);
        if draws.unit() * brightest < texture.at(surface.origin() + offset) {
            return offset;
        }
    }
}
