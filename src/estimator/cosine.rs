//! Sampling by cosine: directions of the hemisphere that must find the sources by themselves.
//!
//! With N directions ω_k of density cosθᵢ/π, one set for all sources together, and M(ω) the exitance of the source whose lit
//! side is met first along ω (zero where an occluder, a dark side or nothing is met),
//!
//! ```text
//! E(x) ≈ (1/N) Σ_k  M(ω_k)
//! ```
//!
//! The cosine and π are in the density. Each term is a lottery: with F_S the visible part's form factor the variance of one
//! is Σ M_S² F_S − (Σ M_S F_S)², whatever the shapes.
#![expect(clippy::needless_range_loop, reason = "one index over several rows is what the compiler makes vectors of")]

use super::draws::{hemisphere_key, mean};
use super::{Estimator, Job, Scratch};
use crate::configuration::{Configuration, Source};
use crate::number::{Machine, Registers, Work};
use crate::sampling::{DirectionBlock, LANES, Squares, cosine_weighted, groups};
use crate::scene::{Met, Surroundings};

/// Estimates irradiance by cosine-weighted directions of the hemisphere.
pub struct CosineEstimator {
    surroundings: Surroundings,
    sources: Vec<Source>,
    machine: Machine,
}

impl CosineEstimator {
    /// Prepares shapes and hierarchies.
    pub fn new(configuration: &Configuration) -> CosineEstimator {
        CosineEstimator {
            surroundings: Surroundings::new(configuration),
            sources: configuration.sources().to_vec(),
            machine: Machine::new(),
        }
    }
}

impl Estimator for CosineEstimator {
    /// N, however many sources there are.
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        samples
    }

    fn estimate(&self, job: &Job, _: &mut Scratch, estimates: &mut [f64]) {
        self.machine.run(Estimate { estimator: self, job, estimates });
    }
}

struct Estimate<'a, 'b> {
    estimator: &'a CosineEstimator,
    job: &'a Job<'b>,
    estimates: &'a mut [f64],
}

impl Work for Estimate<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, _: R) {
        let Estimate { estimator: CosineEstimator { surroundings, sources, .. }, job, estimates } = self;
        estimates.fill(0.0);
        let replicates = (job.replicates.end - job.replicates.start) as usize;
        if replicates == 0 {
            return;
        }
        let (mut squares, mut directions, mut met) = (Squares::default(), DirectionBlock::default(), Met::default());
        for (p, (point, row)) in job.points.iter().zip(estimates.chunks_exact_mut(replicates)).enumerate() {
            for (replicate, estimate) in job.replicates.clone().zip(row.iter_mut()) {
                *estimate =
                    mean(job, hemisphere_key(job, replicate, p), &mut squares, |squares: &Squares, len, brought| {
                        cosine_weighted(point.normal(), squares, len, &mut directions);
                        surroundings.first_met(point.position(), &directions, len, &mut met);
                        for g in 0..groups(len) {
                            for l in 0..LANES {
                                // No source has the index of nothing.
                                brought[g][l] = sources.get(met.source[g][l] as usize).map_or(0.0, |source| {
                                    let way = directions.direction(g, l) * met.distance[g][l];
                                    source.exitance_at(point.position() + way).watts_per_square_metre()
                                });
                            }
                        }
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
        crate::estimator::tests::same_bits(Strategy::Cosine, |room, machine| CosineEstimator {
            machine,
            ..CosineEstimator::new(room)
        });
    }
}
