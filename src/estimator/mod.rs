//! The estimators: points on the sources or directions towards them, a ray for each, the average.
//!
//! Knows nothing of the exact side; the two meet in the judge.

mod area;
mod cosine;
mod draws;
mod mixture;
mod solid_angle;

use std::ops::Range;

pub use area::{AreaEstimator, Scratch};
pub use cosine::CosineEstimator;
pub use mixture::MixtureEstimator;
pub use solid_angle::SolidAngleEstimator;

use crate::configuration::{Configuration, MeasurementPoint};
use crate::sampling::{Strategy, StreamKey, Technique};

/// Something that estimates irradiance: this is what is judged.
pub trait Estimator: Sync {
    /// Rays of one estimate with N = `samples`.
    fn rays_per_estimate(&self, samples: u64) -> u64;

    /// Estimates of the irradiance at each point, W/m², replicate by replicate.
    ///
    /// - `scratch`: working memory of the calling thread
    /// - `estimates`: `[point][replicate]`, as many as points × replicates
    fn estimate(&self, job: &Job, scratch: &mut Scratch, estimates: &mut [f64]);
}

/// What is to be estimated.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    pub strategy: Strategy,
    /// N ≥ 1 points on each source (directions towards each, directions of the hemisphere).
    pub samples: u64,
    /// Key of this strategy and sample count ([`StreamKey::cell`]); replicate, point (0 where points are shared, else
    /// counted from 1) and source are absorbed below it, in that order.
    pub cell: StreamKey,
    pub replicates: Range<u64>,
    pub points: &'a [MeasurementPoint],
}

/// The estimator of a technique, surfaces and hierarchies prepared.
pub fn for_technique(configuration: &Configuration, technique: Technique) -> Box<dyn Estimator> {
    match technique {
        Technique::Area => Box::new(AreaEstimator::new(configuration)),
        Technique::SolidAngle => Box::new(SolidAngleEstimator::new(configuration)),
        Technique::Cosine => Box::new(CosineEstimator::new(configuration)),
        Technique::Mis(heuristic) => Box::new(MixtureEstimator::new(configuration, heuristic)),
    }
}
