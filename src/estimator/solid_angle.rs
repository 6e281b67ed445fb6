//! Sampling by solid angle: directions towards each source, uniform in the directions in which it is seen.
//!
//! For each source S of exitance M that fills the solid angle Ω at x, with N directions ω_k uniform in Ω,
//!
//! ```text
//! E(x) ≈ Σ_S (1/N) Σ_k  (M/π) · Ω · cosθᵢ · Vis(x, ω_k)
//! ```
//!
//! where Vis asks for what lies between x and the place where ω_k meets the source. The source's own cosine and the distance
//! are gone: near a source nothing peaks. A disk's directions are drawn from the rectangle around its ellipse; those that
//! miss it bring nothing, and Ω is the rectangle's.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use super::between::{Between, VisibilityMaps};
use super::draws::{mean, source_key};
use super::emitter::uniform_exitance;
use super::{Estimator, Job, Scratch};
use crate::configuration::{Configuration, MeasurementPoint};
use crate::number::{Machine, Registers, Work};
use crate::sampling::{BLOCK, DirectionBlock, LANES, Row, Silhouette, Squares, View, groups};
use crate::scene::{Help, ShadowRays, Surroundings};
use crate::texture::Texture;

/// Estimates irradiance by directions towards the sources.
pub struct SolidAngleEstimator {
    emitters: Vec<Emitter>,
    machine: Machine,
}

/// A source, and what can come between it and a shading point.
struct Emitter {
    silhouette: Silhouette,
    /// Exitance / π, W/(m² sr); of a textured source 1/π, the exitance being read where a direction meets it.
    radiance: f64,
    texture: Option<Arc<Texture>>,
    between: Between,
}

impl SolidAngleEstimator {
    /// Prepares silhouettes and hierarchies.
    pub fn new(configuration: &Configuration) -> SolidAngleEstimator {
        let surroundings = Surroundings::new(configuration);
        let emitters = configuration.sources().iter().enumerate().map(|(own, source)| Emitter {
            silhouette: Silhouette::new(source.shape()).expect("a source is no mesh"),
            radiance: uniform_exitance(source) / PI,
            texture: source.texture().cloned(),
            between: Between::new(&surroundings, own, source),
        });
        SolidAngleEstimator { emitters: emitters.collect(), machine: Machine::new() }
    }
}

impl Estimator for SolidAngleEstimator {
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        self.emitters.len() as u64 * samples
    }

    fn estimate(&self, job: &Job, _: &mut Scratch, estimates: &mut [f64]) {
        self.machine.run(Estimate { estimator: self, job, estimates });
    }
}

struct Estimate<'a, 'b> {
    estimator: &'a SolidAngleEstimator,
    job: &'a Job<'b>,
    estimates: &'a mut [f64],
}

impl Work for Estimate<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, _: R) {
        let Estimate { estimator: SolidAngleEstimator { emitters, machine }, job, estimates } = self;
        estimates.fill(0.0);
        let replicates = (job.replicates.end - job.replicates.start) as usize;
        if replicates == 0 {
            return;
        }
        let (mut squares, mut aim) = (Squares::default(), Aim::default());
        for (p, (point, row)) in job.points.iter().zip(estimates.chunks_exact_mut(replicates)).enumerate() {
            for (source, emitter) in emitters.iter().enumerate() {
                emitter.silhouette.seen_from(point.position(), &mut aim.view);
                let strength = emitter.radiance * aim.view.solid_angle();
                if strength == 0.0 {
                    continue;
                }
                let rays = job.samples * replicates as u64;
                aim.visibilities = emitter.between.visibilities(*machine, point.position(), rays);
                for (replicate, estimate) in job.replicates.clone().zip(row.iter_mut()) {
                    let key = source_key(job, replicate, p, source);
                    *estimate += strength
                        * mean(job, key, &mut squares, |squares, len, brought| {
                            aim.shoot(*machine, emitter, point, squares, len, brought);
                        });
                }
            }
        }
    }
}

/// One source as one point sees it, and working memory for a block of directions towards it.
#[derive(Default)]
struct Aim {
    view: View,
    visibilities: VisibilityMaps,
    directions: DirectionBlock,
    distances: Distances,
    rays: ShadowRays,
}

struct Distances(Row);

impl Default for Distances {
    fn default() -> Distances {
        Distances([[0.0; LANES]; BLOCK / LANES])
    }
}

impl Aim {
    /// Sets what each direction brings to cosθᵢ · Vis, times the exitance where a texture says that.
    #[inline(always)]
    fn shoot(
        &mut self,
        machine: Machine,
        emitter: &Emitter,
        point: &MeasurementPoint,
        squares: &Squares,
        len: usize,
        brought: &mut Row,
    ) {
        let Aim { view, visibilities, directions, distances: Distances(distances), rays } = self;
        view.draw(squares, len, directions, distances);
        for (g, brought) in brought.iter_mut().enumerate().take(groups(len)) {
            for (l, brought) in brought.iter_mut().enumerate() {
                let (direction, distance) = (directions.direction(g, l), distances[g][l]);
                let cosine = point.normal().dot(direction).max(0.0);
                *brought = if distance > 0.0 { cosine } else { 0.0 };
                rays.x[g][l] = direction.x * distance;
                rays.y[g][l] = direction.y * distance;
                rays.z[g][l] = direction.z * distance;
            }
        }
        for (k, blocker) in emitter.between.blockers.iter().enumerate() {
            let help = Help { cache: None, visibility: visibilities.get(k).and_then(Option::as_deref) };
            blocker.shade_on(machine, point.position(), rays, len, brought, help);
        }
        if let Some(texture) = &emitter.texture {
            for (g, brought) in brought.iter_mut().enumerate().take(groups(len)) {
                for (l, brought) in brought.iter_mut().enumerate() {
                    if *brought > 0.0 {
                        let way = DVec3::new(rays.x[g][l], rays.y[g][l], rays.z[g][l]);
                        *brought *= texture.at(point.position() + way);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Strategy;

    #[test]
    fn instruction_sets_move_no_bit() {
        crate::estimator::tests::same_bits(Strategy::SolidAngle, |room, machine| SolidAngleEstimator {
            machine,
            ..SolidAngleEstimator::new(room)
        });
    }
}
