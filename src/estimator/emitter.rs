//! Sources as estimators see them: points by area, and what each brings to a shading point.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use smallvec::SmallVec;

use super::between::Between;
use crate::configuration::{Configuration, MeasurementPoint, Source};
use crate::number::{Eight, Lanewise, Machine, Registers, Work};
use crate::sampling::{BLOCK, LANES, Row, Squares, StreamKey, Surface, SurfaceBlock, groups};
use crate::scene::{Displacement, Help, ShadowCache, ShadowRays, Stop, Surroundings, VisibilityMap};
use crate::texture::Texture;

/// A source, and what can come between it and a shading point.
pub(super) struct Emitter {
    pub(super) surface: Surface,
    /// Area × exitance / π, W/sr; of a textured source area / π, the exitance being read at each place.
    pub(super) strength: f64,
    texture: Option<Arc<Texture>>,
    pub(super) between: Between,
}

/// Working memory of one thread; its size does not depend on the number of samples.
#[derive(Default)]
pub struct Scratch {
    pub(super) squares: Squares,
    pub(super) places: SurfaceBlock,
    pub(super) exitances: Exitances,
    pub(super) shading: Shading,
    /// One sum of lanes for each point, where points are shared.
    pub(super) sums: Vec<[f64; LANES]>,
    /// Keys of replicates side by side.
    pub(super) keys: Vec<StreamKey>,
}

/// Exitance at the places of a block, W/m².
#[repr(align(64))]
pub(super) struct Exitances(Row);

impl Default for Exitances {
    fn default() -> Exitances {
        Exitances([[0.0; LANES]; BLOCK / LANES])
    }
}

/// Rays of one block from one point, and what each brings.
#[repr(align(64))]
pub(super) struct Shading {
    rays: ShadowRays,
    pub(super) contributions: Row,
    /// One for each of a source's blockers, as far as there have been some.
    caches: Vec<ShadowCache>,
}

impl Default for Shading {
    fn default() -> Shading {
        Shading { rays: ShadowRays::default(), contributions: [[0.0; LANES]; BLOCK / LANES], caches: Vec::new() }
    }
}

/// A block of places on a source, for [`Emitter::gather`].
pub(super) struct Block<'a> {
    pub(super) places: &'a SurfaceBlock,
    pub(super) exitances: Option<&'a Exitances>,
    /// From the point that is to gather.
    pub(super) visibilities: &'a [Option<Arc<VisibilityMap>>],
    pub(super) len: usize,
    pub(super) shading: &'a mut Shading,
}

/// The sources, each with what stands before it.
pub(super) fn emitters(configuration: &Configuration, surroundings: &Surroundings) -> Vec<Emitter> {
    let emitters = configuration.sources().iter().enumerate().map(|(own, source)| {
        let surface = Surface::new(source.shape()).expect("a source is no mesh");
        Emitter {
            strength: surface.area() * uniform_exitance(source) / PI,
            texture: source.texture().cloned(),
            between: Between::new(surroundings, own, source),
            surface,
        }
    });
    emitters.collect()
}

/// W/m²; 1 where the exitance is read at each place instead.
pub(super) fn uniform_exitance(source: &Source) -> f64 {
    if source.texture().is_some() { 1.0 } else { source.exitance().watts_per_square_metre() }
}

impl Shading {
    /// cosθᵢ cosθₛ / r² · Vis of one point, per square metre.
    #[inline(always)]
    pub(super) fn contribution(&self, group: usize, lane: usize) -> f64 {
        self.contributions[group][lane]
    }

    /// Adds a block's contributions to the lanes of a sum.
    fn add_to(&self, machine: Machine, sum: &mut [f64; LANES], len: usize) {
        machine.run(Sum { contributions: &self.contributions, sum, len });
    }
}

struct Sum<'a> {
    contributions: &'a Row,
    sum: &'a mut [f64; LANES],
    len: usize,
}

impl Work for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, registers: R) {
        let mut lanes = Eight::load(registers, self.sum);
        for group in &self.contributions[..groups(self.len)] {
            lanes = lanes + Eight::load(registers, group);
        }
        lanes.store(self.sum);
    }
}

impl Emitter {
    /// Square metres.
    pub(super) fn area(&self) -> f64 {
        self.surface.area()
    }

    /// Area × exitance / π, W/sr; area / π where the exitance is read at each place.
    pub(super) fn strength(&self) -> f64 {
        self.strength
    }

    /// Puts the first `len` points of a block on the source.
    pub(super) fn place(&self, machine: Machine, squares: &Squares, len: usize, places: &mut SurfaceBlock) {
        self.surface.place_on(machine, squares, len, places);
    }

    /// The exitance at a place of a block, W/m²; 1 where that is no matter of the place.
    pub(super) fn texture_at(&self, places: &SurfaceBlock, group: usize, lane: usize) -> f64 {
        let Some(texture) = &self.texture else { return 1.0 };
        let offset = DVec3::new(places.x[group][lane], places.y[group][lane], places.z[group][lane]);
        texture.at(self.surface.origin() + offset)
    }

    /// Sets the contributions of one block of source points to cosθᵢ cosθₛ / r² · Vis.
    pub(super) fn illuminate(
        &self,
        machine: Machine,
        point: &MeasurementPoint,
        places: &SurfaceBlock,
        visibilities: &[Option<Arc<VisibilityMap>>],
        len: usize,
        shading: &mut Shading,
    ) {
        let Shading { rays, contributions, caches } = shading;
        let mut stops = SmallVec::<[Stop; 2]>::new();
        self.stops(point, &mut stops);
        let rays_of_meshes = self.between.has_meshes().then_some(&mut *rays);
        machine.run(Lit { emitter: self, point, places, len, stops: &stops, rays: rays_of_meshes, contributions });
        caches.resize_with(caches.len().max(self.between.blockers.len()), ShadowCache::default);
        let blockers = self.between.blockers.iter().zip(caches).enumerate();
        for (k, (blocker, cache)) in blockers.filter(|(_, (blocker, _))| blocker.is_mesh()) {
            let help = Help { cache: Some(cache), visibility: visibilities.get(k).and_then(Option::as_deref) };
            blocker.shade_on(machine, point.position(), rays, len, contributions, help);
        }
    }

    /// Adds the contributions of a block, weighed by the exitance, to the lanes of a sum. Where that is the same all over, and
    /// only analytic shapes stand before the source, nothing is written on the way.
    ///
    /// - `exitances`: of the block's places, where [`Emitter::read`] found them
    pub(super) fn gather(&self, machine: Machine, point: &MeasurementPoint, block: Block, sum: &mut [f64; LANES]) {
        let Block { places, exitances, visibilities, len, shading } = block;
        if self.texture.is_none() && !self.between.has_meshes() {
            let mut stops = SmallVec::<[Stop; 2]>::new();
            self.stops(point, &mut stops);
            machine.run(Gathered { emitter: self, point, places, len, stops: &stops, sum });
            return;
        }
        self.illuminate(machine, point, places, visibilities, len, shading);
        match exitances {
            Some(exitances) => self.weigh_by(machine, exitances, len, shading),
            None => self.weigh(places, len, shading),
        }
        shading.add_to(machine, sum, len);
    }

    /// What its analytic blockers are to a point.
    fn stops<'a>(&'a self, point: &MeasurementPoint, stops: &mut SmallVec<[Stop<'a>; 2]>) {
        for blocker in &self.between.blockers {
            if let Some(stop) = blocker.stop(point.position()) {
                stops.push(stop);
            }
        }
    }

    /// Weighs contributions by the exitance at their places, where a texture says that.
    #[inline(always)]
    pub(super) fn weigh(&self, places: &SurfaceBlock, len: usize, shading: &mut Shading) {
        if self.texture.is_none() {
            return;
        }
        for g in 0..groups(len) {
            for l in 0..LANES {
                if shading.contributions[g][l] > 0.0 {
                    shading.contributions[g][l] *= self.texture_at(places, g, l);
                }
            }
        }
    }

    /// Reads the exitance at a block's places once, for all shading points that share them.
    pub(super) fn read(&self, places: &SurfaceBlock, len: usize, exitances: &mut Exitances) {
        if self.texture.is_none() {
            return;
        }
        for g in 0..groups(len) {
            for l in 0..LANES {
                exitances.0[g][l] = self.texture_at(places, g, l);
            }
        }
    }

    /// As [`Emitter::weigh`], bit for bit, by what [`Emitter::read`] found.
    pub(super) fn weigh_by(&self, machine: Machine, exitances: &Exitances, len: usize, shading: &mut Shading) {
        if self.texture.is_some() {
            machine.run(Weighed { exitances, contributions: &mut shading.contributions, len });
        }
    }
}

struct Weighed<'a> {
    exitances: &'a Exitances,
    contributions: &'a mut Row,
    len: usize,
}

impl Work for Weighed<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, registers: R) {
        let exitances = &self.exitances.0[..groups(self.len)];
        for (contributions, exitances) in self.contributions.iter_mut().zip(exitances) {
            (Eight::load(registers, contributions) * Eight::load(registers, exitances)).store(contributions);
        }
    }
}

/// See [`Emitter::illuminate`]; without what meshes stop, for which the rays are kept.
struct Lit<'a> {
    emitter: &'a Emitter,
    point: &'a MeasurementPoint,
    places: &'a SurfaceBlock,
    len: usize,
    stops: &'a [Stop<'a>],
    rays: Option<&'a mut ShadowRays>,
    contributions: &'a mut Row,
}

impl Work for Lit<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, registers: R) {
        let Lit { emitter, point, places, len, stops, rays, contributions } = self;
        if let Some(rays) = rays {
            let offset = emitter.surface.origin() - point.position();
            for g in 0..groups(len) {
                let [x, y, z] = displaced(registers, offset, places, g);
                x.store(&mut rays.x[g]);
                y.store(&mut rays.y[g]);
                z.store(&mut rays.z[g]);
            }
        }
        light(registers, emitter, point, places, len, stops, Kept(contributions));
        if !len.is_multiple_of(LANES) {
            contributions[len / LANES][len % LANES..].fill(0.0);
        }
    }
}

/// See [`Emitter::gather`].
struct Gathered<'a> {
    emitter: &'a Emitter,
    point: &'a MeasurementPoint,
    places: &'a SurfaceBlock,
    len: usize,
    stops: &'a [Stop<'a>],
    sum: &'a mut [f64; LANES],
}

impl Work for Gathered<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, registers: R) {
        let Gathered { emitter, point, places, len, stops, sum } = self;
        let added = Added { registers, len, sum: Eight::load(registers, sum) };
        light(registers, emitter, point, places, len, stops, added).sum.store(sum);
    }
}

/// What becomes of the contributions of eight places.
trait Brought<R: Registers> {
    fn take(&mut self, group: usize, contributions: Eight<R>);
}

struct Kept<'a>(&'a mut Row);

impl<R: Registers> Brought<R> for Kept<'_> {
    #[inline(always)]
    fn take(&mut self, group: usize, contributions: Eight<R>) {
        contributions.store(&mut self.0[group]);
    }
}

struct Added<R: Registers> {
    registers: R,
    len: usize,
    sum: Eight<R>,
}

impl<R: Registers> Brought<R> for Added<R> {
    #[inline(always)]
    fn take(&mut self, group: usize, contributions: Eight<R>) {
        let left = self.len - group * LANES;
        if left >= LANES {
            self.sum = self.sum + contributions;
        } else {
            let mut lanes = [0.0; LANES];
            contributions.store(&mut lanes);
            lanes[left..].fill(0.0);
            self.sum = self.sum + Eight::load(self.registers, &lanes);
        }
    }
}

/// cosθᵢ cosθₛ / r² · Vis of a block of places, group by group.
#[inline(always)]
fn light<R: Registers, B: Brought<R>>(
    registers: R,
    emitter: &Emitter,
    point: &MeasurementPoint,
    places: &SurfaceBlock,
    len: usize,
    stops: &[Stop],
    mut brought: B,
) -> B {
    let offset = emitter.surface.origin() - point.position();
    let normal = point.normal();
    if let Some(source_normal) = emitter.surface.flat_normal() {
        // r cosθₛ is the height of the point over the source's plane, the same for the whole source.
        let height = Eight::load(registers, &[(-offset.dot(source_normal)).max(0.0); LANES]);
        for g in 0..groups(len) {
            brought.take(g, arriving(displaced(registers, offset, places, g), normal, height, stops));
        }
    } else if let Some(radius) = emitter.surface.sphere_radius() {
        for g in 0..groups(len) {
            let [x, y, z] = displaced(registers, offset, places, g);
            // r cosθₛ with the sphere's normal at the point, its offset over the radius.
            let px = Eight::load(registers, &places.x[g]);
            let py = Eight::load(registers, &places.y[g]);
            let pz = Eight::load(registers, &places.z[g]);
            let height = -(px * x + py * y + pz * z) / radius;
            brought.take(g, arriving([x, y, z], normal, height.positive(), stops));
        }
    }
    brought
}

/// cosθᵢ cosθₛ / r² · Vis along a displacement r.
///
/// - `height`: r cosθₛ, ≥ 0, metres
#[inline(always)]
fn arriving<T: Lanewise>(ray: Displacement<T>, normal: DVec3, height: T, stops: &[Stop]) -> T {
    let [x, y, z] = ray;
    let r2 = x * x + y * y + z * z;
    let cosine = (x * normal.x + y * normal.y + z * normal.z).positive();
    let mut light = cosine * height / (r2 * r2);
    for stop in stops {
        light = stop.dim(ray, light);
    }
    light
}

/// Eight places of a block, moved by an offset.
#[inline(always)]
fn displaced<R: Registers>(registers: R, offset: DVec3, places: &SurfaceBlock, g: usize) -> Displacement<Eight<R>> {
    [
        Eight::load(registers, &places.x[g]) + offset.x,
        Eight::load(registers, &places.y[g]) + offset.y,
        Eight::load(registers, &places.z[g]) + offset.z,
    ]
}

/// The lanes of a sum, added in a fixed order.
#[inline(always)]
pub(super) fn add_lanes(lanes: &[f64; LANES]) -> f64 {
    let [a, b, c, d, e, f, g, h] = *lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
