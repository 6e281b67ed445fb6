//! Sources as estimators see them: points by area, and what each brings to a shading point.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use crate::configuration::{Configuration, MeasurementPoint, Source};
use crate::sampling::{BLOCK, LANES, Row, Squares, StreamKey, Surface, SurfaceBlock, groups};
use crate::scene::{Blocker, ShadowRays, Surroundings};
use crate::texture::Texture;

/// A source, and what can come between it and a shading point.
pub(super) struct Emitter {
    pub(super) surface: Surface,
    /// Area × exitance / π, W/sr; of a textured source area / π, the exitance being read at each place.
    pub(super) strength: f64,
    texture: Option<Arc<Texture>>,
    blockers: Vec<Arc<Blocker>>,
}

/// Working memory of one thread; its size does not depend on the number of samples.
#[derive(Default)]
pub struct Scratch {
    pub(super) squares: Squares,
    pub(super) places: SurfaceBlock,
    pub(super) shading: Shading,
    /// One sum of lanes for each point, where points are shared.
    pub(super) sums: Vec<[f64; LANES]>,
    /// Keys of estimates side by side.
    pub(super) keys: Vec<StreamKey>,
}

/// Rays of one block from one point, and what each brings.
pub(super) struct Shading {
    rays: ShadowRays,
    pub(super) contributions: Row,
}

impl Default for Shading {
    fn default() -> Shading {
        Shading { rays: ShadowRays::default(), contributions: [[0.0; LANES]; BLOCK / LANES] }
    }
}

/// The sources, each with what stands before it.
pub(super) fn emitters(configuration: &Configuration, surroundings: &Surroundings) -> Vec<Emitter> {
    let emitters = configuration.sources().iter().enumerate().map(|(own, source)| {
        let surface = Surface::new(source.shape()).expect("a source is no mesh");
        Emitter {
            strength: surface.area() * uniform_exitance(source) / PI,
            texture: source.texture().cloned(),
            surface,
            blockers: surroundings.before(own),
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
    #[inline(always)]
    pub(super) fn add_to(&self, sum: &mut [f64; LANES], len: usize) {
        for group in &self.contributions[..groups(len)] {
            for (sum, contribution) in sum.iter_mut().zip(group) {
                *sum += contribution;
            }
        }
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
    #[inline(always)]
    pub(super) fn place(&self, squares: &Squares, len: usize, places: &mut SurfaceBlock) {
        self.surface.place(squares, len, places);
    }

    /// The exitance at a place of a block, W/m²; 1 where that is no matter of the place.
    pub(super) fn texture_at(&self, places: &SurfaceBlock, group: usize, lane: usize) -> f64 {
        let Some(texture) = &self.texture else { return 1.0 };
        let offset = DVec3::new(places.x[group][lane], places.y[group][lane], places.z[group][lane]);
        texture.at(self.surface.origin() + offset)
    }

    /// Sets the contributions of one block of source points to cosθᵢ cosθₛ / r² · Vis.
    #[expect(
        clippy::needless_range_loop,
        reason = "one index over several rows is what the compiler makes vectors of"
    )]
    #[inline(always)]
    pub(super) fn illuminate(
        &self,
        point: &MeasurementPoint,
        places: &SurfaceBlock,
        len: usize,
        shading: &mut Shading,
    ) {
        let offset = self.surface.origin() - point.position();
        let normal = point.normal();
        let Shading { rays, contributions } = shading;
        for g in 0..groups(len) {
            for l in 0..LANES {
                rays.x[g][l] = offset.x + places.x[g][l];
                rays.y[g][l] = offset.y + places.y[g][l];
                rays.z[g][l] = offset.z + places.z[g][l];
            }
        }
        if let Some(source_normal) = self.surface.flat_normal() {
            // r cosθₛ is the height of the point over the source's plane, the same for the whole source.
            let height = (-offset.dot(source_normal)).max(0.0);
            for g in 0..groups(len) {
                for l in 0..LANES {
                    let d = rays.ray(g, l);
                    let r2 = d.length_squared();
                    contributions[g][l] = normal.dot(d).max(0.0) * height / (r2 * r2);
                }
            }
            if height == 0.0 {
                return;
            }
        } else if let Some(radius) = self.surface.sphere_radius() {
            for g in 0..groups(len) {
                for l in 0..LANES {
                    let d = rays.ray(g, l);
                    let r2 = d.length_squared();
                    // r cosθₛ with the sphere's normal at the point, its offset over the radius.
                    let height = -(places.x[g][l] * d.x + places.y[g][l] * d.y + places.z[g][l] * d.z) / radius;
                    contributions[g][l] = normal.dot(d).max(0.0) * height.max(0.0) / (r2 * r2);
                }
            }
        }
        if !len.is_multiple_of(LANES) {
            contributions[len / LANES][len % LANES..].fill(0.0);
        }
        for blocker in &self.blockers {
            blocker.shade(point.position(), rays, len, contributions);
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
}

/// The lanes of a sum, added in a fixed order.
#[inline(always)]
pub(super) fn add_lanes(lanes: &[f64; LANES]) -> f64 {
    let [a, b, c, d, e, f, g, h] = *lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
