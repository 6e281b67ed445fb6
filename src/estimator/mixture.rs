//! Multiple importance sampling: points by area and directions by cosine, each weighed against the other.
//!
//! A direction that meets source S can come from S's points, with density p_a = r²/(A cosθₛ) per solid angle, or from the
//! hemisphere, with density p_c = cosθᵢ/π. With N draws of each and ρ = p_c/p_a = A cosθᵢ cosθₛ/(π r²), the weights of Veach
//! (1997) are w_a = 1/(1 + ρᵝ) and w_c = ρᵝ/(1 + ρᵝ), and
//!
//! ```text
//! E(x) ≈ Σ_S (1/N) Σ_k  M · ρ · w_a · Vis(x, u_k)   +   (1/N) Σ_k  M · w_c       over the source that ω_k meets first
//! ```
//!
//! What peaks in one is left to the other: near a source ρ is large and the directions count, far from it the points.
#![expect(clippy::needless_range_loop, reason = "one index over several rows is what the compiler makes vectors of")]

use std::f64::consts::PI;
use std::sync::Arc;

use super::between::VisibilityMaps;
use super::draws::{hemisphere_key, mean, source_key};
use super::emitter::{Emitter, Shading, emitters, uniform_exitance};
use super::{Estimator, Job, Scratch};
use crate::configuration::{Configuration, MeasurementPoint};
use crate::number::{Machine, Registers, Work};
use crate::sampling::{DirectionBlock, Heuristic, LANES, Row, Squares, SurfaceBlock, cosine_weighted, groups};
use crate::scene::{Met, Surroundings};
use crate::texture::Texture;

/// Estimates irradiance by points on the sources and directions of the hemisphere together.
pub struct MixtureEstimator {
    heuristic: Heuristic,
    sources: Vec<Source>,
    surroundings: Surroundings,
    machine: Machine,
}

struct Source {
    emitter: Emitter,
    /// W/m²; 1 where it is read from a texture instead.
    exitance: f64,
    texture: Option<Arc<Texture>>,
    /// Square metres, over π.
    area_over_pi: f64,
}

impl MixtureEstimator {
    /// Prepares surfaces, shapes and hierarchies.
    pub fn new(configuration: &Configuration, heuristic: Heuristic) -> MixtureEstimator {
        let surroundings = Surroundings::new(configuration);
        let emitters = emitters(configuration, &surroundings);
        let sources = configuration.sources().iter().zip(emitters).map(|(source, emitter)| Source {
            exitance: uniform_exitance(source),
            texture: source.texture().cloned(),
            area_over_pi: emitter.area() / PI,
            emitter,
        });
        MixtureEstimator { heuristic, sources: sources.collect(), surroundings, machine: Machine::new() }
    }
}

impl Estimator for MixtureEstimator {
    /// N to each source and N into the hemisphere.
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        (self.sources.len() as u64 + 1) * samples
    }

    fn estimate(&self, job: &Job, _: &mut Scratch, estimates: &mut [f64]) {
        self.machine.run(Estimate { estimator: self, job, estimates });
    }
}

struct Estimate<'a, 'b> {
    estimator: &'a MixtureEstimator,
    job: &'a Job<'b>,
    estimates: &'a mut [f64],
}

/// Working memory for a block.
#[derive(Default)]
struct Scratchpad {
    /// Of each source, from the point under way.
    visibilities: Vec<VisibilityMaps>,
    /// Which source is under way.
    source: usize,
    places: SurfaceBlock,
    shading: Shading,
    directions: DirectionBlock,
    met: Met,
}

impl Work for Estimate<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, _: R) {
        let Estimate { estimator, job, estimates } = self;
        estimates.fill(0.0);
        let replicates = (job.replicates.end - job.replicates.start) as usize;
        if replicates == 0 {
            return;
        }
        let (mut squares, mut work) = (Squares::default(), Scratchpad::default());
        let rays = job.samples * replicates as u64;
        for (p, (point, row)) in job.points.iter().zip(estimates.chunks_exact_mut(replicates)).enumerate() {
            work.visibilities.clear();
            for source in &estimator.sources {
                let between = &source.emitter.between;
                work.visibilities.push(between.visibilities(estimator.machine, point.position(), rays));
            }
            for (replicate, estimate) in job.replicates.clone().zip(row.iter_mut()) {
                for (index, source) in estimator.sources.iter().enumerate() {
                    work.source = index;
                    let key = source_key(job, replicate, p, index);
                    *estimate += source.exitance
                        * mean(job, key, &mut squares, |squares, len, brought| {
                            source.by_area(estimator, point, squares, len, &mut work, brought);
                        });
                }
                *estimate += mean(job, hemisphere_key(job, replicate, p), &mut squares, |squares, len, brought| {
                    estimator.by_cosine(point, squares, len, &mut work, brought);
                });
            }
        }
    }
}

impl Source {
    /// Sets what each point on the source brings to ρ w_a Vis, times the exitance where a texture says that.
    #[inline(always)]
    fn by_area(
        &self,
        estimator: &MixtureEstimator,
        point: &MeasurementPoint,
        squares: &Squares,
        len: usize,
        work: &mut Scratchpad,
        brought: &mut Row,
    ) {
        let MixtureEstimator { heuristic, machine, .. } = *estimator;
        self.emitter.place(machine, squares, len, &mut work.places);
        let visibilities = &work.visibilities[work.source];
        self.emitter.illuminate(machine, point, &work.places, visibilities, len, &mut work.shading);
        for g in 0..groups(len) {
            for l in 0..LANES {
                // Finite, so that the product with a weight of zero is zero.
                let ratio = (self.area_over_pi * work.shading.contribution(g, l)).min(f64::MAX);
                brought[g][l] = ratio * heuristic.weight(1.0 / ratio);
                if brought[g][l] > 0.0 {
                    brought[g][l] *= self.emitter.texture_at(&work.places, g, l);
                }
            }
        }
    }
}

impl MixtureEstimator {
    /// Sets what each direction brings to M w_c of the source that it meets first.
    #[inline(always)]
    fn by_cosine(
        &self,
        point: &MeasurementPoint,
        squares: &Squares,
        len: usize,
        work: &mut Scratchpad,
        brought: &mut Row,
    ) {
        let Scratchpad { directions, met, .. } = work;
        cosine_weighted(point.normal(), squares, len, directions);
        self.surroundings.first_met(point.position(), directions, len, met);
        for g in 0..groups(len) {
            for l in 0..LANES {
                brought[g][l] = self.sources.get(met.source[g][l] as usize).map_or(0.0, |source| {
                    let cosine = point.normal().dot(directions.direction(g, l)).max(0.0);
                    let distance = met.distance[g][l];
                    let ratio = source.area_over_pi * cosine * met.cosine[g][l] / (distance * distance);
                    let read = source
                        .texture
                        .as_ref()
                        .map_or(1.0, |texture| texture.at(point.position() + directions.direction(g, l) * distance));
                    source.exitance * read * self.heuristic.weight(ratio)
                });
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
        crate::estimator::tests::same_bits(Strategy::MisPower, |room, machine| MixtureEstimator {
            machine,
            ..MixtureEstimator::new(room, Heuristic::Power)
        });
    }
}
