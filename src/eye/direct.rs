//! The direct term of each surface: the estimators with the surface itself out of the way.

use crate::configuration::{Configuration, ConfigurationError, Contents, MeasurementPoint, Receiver, ReceiverShape};
use crate::estimator::{Estimator, Job, Scratch, for_technique};
use crate::light::Sight;
use crate::sampling::{Purpose, StreamKey};

use super::picture::Shading;

/// Points along each side of a surface at which it is asked whether a curved optic may stand before a source.
const PROBES: usize = 9;
/// Keeps the streams of pictures apart from those of measured points: "eye" in ASCII.
const PURPOSE: u64 = 0x0065_7965;

/// Where the direct light of one surface comes from.
enum Ground {
    /// No source with area lights it.
    Dark,
    /// The room in which points are on the sources.
    Estimated(Box<Configuration>),
    /// A lens or a curved mirror may be in the way: the map of rays from the light tells.
    Map,
}

/// Direct light on the surfaces of a room: the receiver, then the diffuse surfaces.
pub struct Direct {
    digest: u64,
    grounds: Vec<Ground>,
    sight: Sight,
}

impl Direct {
    /// Prepares each surface. A diffuse surface does not stand in its own light: it is convex, and is left out of its own
    /// room.
    pub fn new(configuration: &Configuration) -> Direct {
        let receiver = configuration.receiver().map(|_| of_receiver(configuration));
        let diffuse = (0..configuration.diffuse().len()).map(|surface| of_diffuse(configuration, surface));
        Direct {
            digest: configuration.digest().key(),
            grounds: receiver.into_iter().chain(diffuse).collect(),
            sight: Sight::new(configuration),
        }
    }

    /// Whether the direct light of sources with area on a surface is read from the map of rays.
    pub fn is_from_map(&self, surface: usize) -> bool {
        matches!(self.grounds.get(surface), Some(Ground::Map))
    }

    /// Estimators of all surfaces for a strategy.
    pub(super) fn estimators(&self, shading: &Shading) -> Vec<Option<Box<dyn Estimator>>> {
        let technique = shading.strategy.technique();
        let of_ground = |ground: &Ground| match ground {
            Ground::Estimated(room) => Some(for_technique(room, technique)),
            Ground::Dark | Ground::Map => None,
        };
        self.grounds.iter().map(of_ground).collect()
    }

    /// Irradiance at points of one surface in one row of a picture, W/m²: `[point][replicate]`.
    ///
    /// Streams are keyed by surface and row (the row not where points are shared), then by replicate and the point's place
    /// among those of the surface in its row.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn irradiance(
        &self,
        estimators: &[Option<Box<dyn Estimator>>],
        surface: usize,
        row: usize,
        points: &[MeasurementPoint],
        shading: &Shading,
        replicates: std::ops::Range<u64>,
        scratch: &mut Scratch,
    ) -> Vec<f64> {
        let stride = (replicates.end - replicates.start) as usize;
        let mut estimates = vec![0.0; points.len() * stride];
        if let Some(estimator) = estimators.get(surface).and_then(Option::as_ref) {
            let Shading { strategy, samples, seed } = *shading;
            let cell = StreamKey::cell(seed, self.digest, Purpose::Measurement, strategy, samples).with(PURPOSE);
            let row = if strategy.shares_points() { 0 } else { row as u64 + 1 };
            let cell = cell.with(surface as u64).with(row);
            estimator.estimate(&Job { strategy, samples, cell, replicates, points }, scratch, &mut estimates);
        }
        for (point, estimates) in points.iter().zip(estimates.chunks_mut(stride.max(1))) {
            let lamps = self.sight.from_lamps(surface, point.position(), point.normal());
            estimates.iter_mut().for_each(|estimate| *estimate += lamps);
        }
        estimates
    }
}

fn of_receiver(configuration: &Configuration) -> Ground {
    if configuration.sources().is_empty() {
        return Ground::Dark;
    }
    let contents = configuration.contents();
    let points = probes(contents.receiver.as_ref().map(|receiver| *receiver.shape()));
    let asked = Configuration::of(Contents { points, ..contents.clone() });
    match asked {
        Err(errors) if errors.iter().any(|error| matches!(error, ConfigurationError::CurvedBefore { .. })) => {
            Ground::Map
        }
        // Where the receiver touches something, single points have no value; the others do.
        _ => Ground::Estimated(Box::new(configuration.clone())),
    }
}

fn of_diffuse(configuration: &Configuration, surface: usize) -> Ground {
    let contents = configuration.contents();
    let own = &contents.diffuse[surface];
    let others = contents.diffuse.iter().enumerate().filter(|(k, _)| *k != surface);
    // As a receiver it blocks nothing, and the room reaches as far as it does.
    let room = Contents {
        diffuse: others.map(|(_, other)| other.clone()).collect(),
        receiver: Receiver::new(*own.shape(), None).ok(),
        ..contents.clone()
    };
    let mut found = None;
    for point in probes(Some(*own.shape())) {
        match Configuration::of(Contents { points: vec![point], ..room.clone() }) {
            Ok(room) if room.sources().is_empty() => return Ground::Dark,
            Ok(room) => found = found.or(Some(room)),
            Err(errors) if errors.contains(&ConfigurationError::NoSource) => return Ground::Dark,
            Err(errors) if errors.iter().any(|e| matches!(e, ConfigurationError::CurvedBefore { .. })) => {
                return Ground::Map;
            }
            // This point lies on something else.
            Err(_) => {}
        }
    }
    found.map_or(Ground::Map, |room| Ground::Estimated(Box::new(room)))
}

fn probes(shape: Option<ReceiverShape>) -> Vec<MeasurementPoint> {
    let receiver = shape.and_then(|shape| Receiver::new(shape, None).ok());
    receiver.map_or_else(Vec::new, |receiver| receiver.grid(PROBES, PROBES))
}
