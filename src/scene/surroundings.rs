//! All that a ray can meet: what stands before a source, and which source a ray from a shading point meets first.

use std::sync::Arc;

use glam::DVec3;

use super::Blocker;
use crate::configuration::Configuration;
use crate::geometry::Shape;

/// The sources and occluders of a configuration, prepared for rays.
pub struct Surroundings {
    pub(super) sources: Vec<Arc<Blocker>>,
    pub(super) occluders: Vec<Arc<Blocker>>,
}

impl Surroundings {
    /// Prepares shapes and hierarchies.
    pub fn new(configuration: &Configuration) -> Surroundings {
        let reach = reach(configuration);
        let blocker = |shape: &Shape| Arc::new(Blocker::new(shape, reach));
        Surroundings {
            sources: configuration.sources().iter().map(|source| blocker(source.shape())).collect(),
            occluders: configuration.blockers().iter().map(blocker).collect(),
        }
    }

    /// What can come between a source and a shading point: the other sources, then the occluders. A source does not block
    /// itself: a flat one cannot, a sphere's far side is the cosine's business.
    pub fn before(&self, source: usize) -> Vec<Arc<Blocker>> {
        let others =
            self.sources.iter().enumerate().filter(|(other, _)| *other != source).map(|(_, blocker)| blocker);
        others.chain(&self.occluders).cloned().collect()
    }
}

/// A box that holds every shading point and every source: all ends of all shadow rays, metres.
pub fn reach(configuration: &Configuration) -> (DVec3, DVec3) {
    let mut reach = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for source in configuration.sources() {
        let (low, high) = source.shape().bounds();
        reach = (reach.0.min(low), reach.1.max(high));
    }
    // Shading points may lie anywhere on these.
    let receiver = configuration.receiver().map(|receiver| receiver.shape().bounds());
    let diffuse = configuration.diffuse().iter().map(|surface| surface.shape().bounds());
    for (low, high) in receiver.into_iter().chain(diffuse) {
        reach = (reach.0.min(low), reach.1.max(high));
    }
    for point in configuration.points() {
        reach = (reach.0.min(point.position()), reach.1.max(point.position()));
    }
    reach
}
