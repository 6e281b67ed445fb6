//! Small rooms: shipped cases with a few of their points each, so that a whole study takes a millisecond.

use crate::case::{Case, Replicates, SmallestBias, Study, shipped};
use crate::configuration::{Arrangement, Configuration};
use crate::estimator::{Estimator, Job, Scratch, for_technique};
use crate::sampling::{Strategy, StreamKey, Technique};
use crate::statistics::budget::seed_of;

/// A small case.
pub(super) struct Room {
    pub case: Case,
    /// The share of rays that arrive at each point, from places uniform on the sources.
    pub arriving: Vec<f64>,
}

/// Name, the shipped case that it is a part of, which of its points, and how many replicates.
type Part = (&'static str, &'static str, &'static [usize], u64);

/// From plain light to what a test that trusts in normal data would stumble over.
const PARTS: &[Part] = &[
    ("one lit point", "direct/disk-over-plane", &[20], 64),
    ("tilted rectangle", "direct/tilted-source", &[4, 40, 60], 64),
    ("triangle", "direct/triangle-source", &[4, 32, 60], 128),
    ("torn polygon", "direct/l-shaped-source", &[4, 32, 60], 64),
    ("sphere", "direct/sphere-source", &[0, 32, 64], 128),
    ("two sources", "direct/two-sources", &[4, 20, 40, 60], 64),
    ("half below the horizon", "direct/half-sunk-source", &[4, 20, 34, 60], 128),
    ("umbra alone", "penumbra/eclipse", &[0, 4, 8], 128),
    ("umbra to light", "penumbra/eclipse", &[0, 9, 20, 35, 60], 256),
    // Of the source some 0.2 % and 2 % are seen there.
    ("deep penumbra", "penumbra/eclipse", &[9, 11], 256),
    ("half-plane", "penumbra/half-plane", &[20, 32, 44], 128),
    ("antumbra", "penumbra/annular-eclipse", &[0, 16, 32, 60], 128),
    ("two shadows", "penumbra/two-shadows", &[10, 26, 38, 54], 64),
    ("sphere behind sphere", "penumbra/spheres", &[0, 12, 24, 40], 256),
];

/// Samples of each source in a null run.
pub(super) const SAMPLES: [u64; 3] = [1, 4, 16];
/// Rays that `arriving` is counted from.
const COUNTED_RAYS: u64 = 1 << 16;

/// All of them.
pub(super) fn rooms() -> Vec<Room> {
    PARTS.iter().map(part).collect()
}

fn part((name, of, points, replicates): &Part) -> Room {
    let whole = shipped().find(|case| case.name() == *of).expect("a shipped case").read().expect("a test reads it");
    let whole = whole.configuration;
    let chosen = points.iter().map(|p| whole.points()[*p]).collect();
    let configuration = Configuration::new(
        whole.sources().to_vec(),
        whole.occluders().to_vec(),
        whole.receiver().cloned(),
        chosen,
        Arrangement::Scattered,
    )
    .expect("a part of a sound case");
    let study = Study {
        samples: SAMPLES.to_vec(),
        replicates: Replicates::Fixed(*replicates),
        // So coarse that nothing is undecided: evidence is what is looked at.
        smallest_bias: SmallestBias { mean: 1e9, point: 1e9 },
        ..Study::default()
    };
    let arriving = arriving(&configuration, name, COUNTED_RAYS);
    Room { case: Case::new(name, of, configuration, study), arriving }
}

/// The share of rays that arrive at each point, counted: which intervals have enough of them to be printed.
fn arriving(configuration: &Configuration, name: &str, rays: u64) -> Vec<f64> {
    let estimator: Box<dyn Estimator> = for_technique(configuration, Technique::Area);
    let points = configuration.points();
    let cell = StreamKey::root(seed_of(&format!("calibration/arriving/{name}")));
    let job = Job { strategy: Strategy::Random, samples: 1, cell, replicates: 0..rays, points };
    let mut estimates = vec![0.0; points.len() * rays as usize];
    estimator.estimate(&job, &mut Scratch::default(), &mut estimates);
    let share = |row: &[f64]| row.iter().filter(|x| **x > 0.0).count() as f64 / rays as f64;
    estimates.chunks_exact(rays as usize).map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::{Oracle, Region};

    #[test]
    fn the_rooms_are_mixed() {
        let rooms = rooms();
        let regions = |room: &Room| -> Vec<Region> {
            let oracle = Oracle::new(&room.case.configuration);
            room.case.configuration.points().iter().map(|point| oracle.at(point).region).collect()
        };
        let named = |name: &str| rooms.iter().find(|room| room.case.name == name).unwrap();
        assert!(regions(named("umbra alone")).iter().all(|region| *region == Region::Umbra));
        assert!(named("umbra alone").arriving.iter().all(|share| *share == 0.0));
        let deep = named("deep penumbra");
        assert!(regions(deep).iter().all(|region| *region == Region::Penumbra));
        assert!(deep.arriving[0] > 0.0 && deep.arriving[0] < 0.01, "{:?}", deep.arriving);
        assert!(regions(named("umbra to light")).contains(&Region::Lit));
        assert_eq!(named("one lit point").arriving, [1.0]);
        assert!(rooms.iter().any(|room| room.case.configuration.sources().len() == 2));
    }
}
