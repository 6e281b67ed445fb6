//! The estimators: points on the sources or directions towards them, a ray for each, the average.
//!
//! Knows nothing of the exact side; the two meet in the judge.

#[cfg(feature = "studies")]
mod area;
mod between;
#[cfg(feature = "studies")]
mod cosine;
#[cfg(feature = "studies")]
mod draws;
mod emitter;
mod guest;
#[cfg(feature = "studies")]
mod mixture;
#[cfg(feature = "studies")]
mod solid_angle;

use std::ops::Range;

#[cfg(feature = "studies")]
pub use area::AreaEstimator;
#[cfg(feature = "studies")]
pub use cosine::CosineEstimator;
pub use emitter::Scratch;
pub use guest::{Guest, GuestEstimator, GuestFault, GuestPoints, IrradianceEstimator, PointSampler};
#[cfg(feature = "studies")]
pub use mixture::MixtureEstimator;
#[cfg(feature = "studies")]
pub use solid_angle::SolidAngleEstimator;

use crate::configuration::MeasurementPoint;
use crate::sampling::{Strategy, StreamKey};
#[cfg(feature = "studies")]
use crate::{configuration::Configuration, sampling::Technique};

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
#[cfg(feature = "studies")]
pub fn for_technique(configuration: &Configuration, technique: Technique) -> Box<dyn Estimator> {
    match technique {
        Technique::Area => Box::new(AreaEstimator::new(configuration)),
        Technique::SolidAngle => Box::new(SolidAngleEstimator::new(configuration)),
        Technique::Cosine => Box::new(CosineEstimator::new(configuration)),
        Technique::Mis(heuristic) => Box::new(MixtureEstimator::new(configuration, heuristic)),
    }
}

#[cfg(feature = "studies")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Arrangement, Source};
    use crate::geometry::{DVec3, Disk, Mesh, Polygon, Rectangle, Shape, Sphere};
    use crate::number::Machine;
    use crate::radiometry::Exitance;

    /// Sources and occluders of every kind.
    fn room() -> Configuration {
        let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let square = Rectangle::new(corner(0.4, 0.0, 2.0), DVec3::Y, DVec3::X).unwrap();
        let triangle = vec![corner(-1.0, 0.0, 1.5), corner(-0.5, 1.0, 1.4), corner(0.2, 0.1, 1.6)];
        let shapes = [
            Shape::Disk(Disk::new(corner(0.0, -0.5, 1.2), DVec3::new(0.1, 0.2, -1.0), 0.4).unwrap()),
            Shape::Rectangle(square),
            Shape::Polygon(Polygon::new(triangle.clone()).unwrap()),
            Shape::Sphere(Sphere::new(corner(0.7, 0.7, 1.0), 0.2).unwrap()),
        ];
        let below = triangle.iter().map(|p| *p * 0.6).collect();
        let mut occluders = vec![Shape::Mesh(Mesh::new(below, vec![[0, 1, 2]]).unwrap().subdivided(2))];
        occluders.push(Shape::Sphere(Sphere::new(corner(0.2, 0.2, 0.7), 0.15).unwrap()));
        let sources = shapes.into_iter().map(|shape| Source::new(shape, Exitance::new(1.3)).unwrap()).collect();
        let point = |x: f64| MeasurementPoint::new(DVec3::X * x, DVec3::new(0.1, -0.2, 1.0)).unwrap();
        let points = vec![point(0.0), point(0.5), point(-2.0)];
        Configuration::new(sources, occluders, None, points, Arrangement::Scattered).unwrap()
    }

    /// Estimators that differ in their instruction set only give the same bits.
    pub(super) fn same_bits<E: Estimator>(strategy: Strategy, make: impl Fn(&Configuration, Machine) -> E) {
        let room = room();
        for samples in [1, 5, 8, 300] {
            let cell = StreamKey::root(samples);
            let job = Job { strategy, samples, cell, replicates: 0..40, points: room.points() };
            let bits = |machine: Machine| {
                let mut estimates = vec![f64::NAN; 3 * 40];
                make(&room, machine).estimate(&job, &mut Scratch::default(), &mut estimates);
                estimates.into_iter().map(f64::to_bits).collect::<Vec<_>>()
            };
            for machine in Machine::all() {
                assert_eq!(bits(machine), bits(Machine::Any), "{strategy} N = {samples}, {machine:?}");
            }
        }
    }
}
