//! Small rooms: shipped cases with a few of their points each, so that a whole study takes a millisecond.

use std::collections::BTreeMap;

use crate::case::{Case, Replicates, SmallestBias, Study, shipped};
use crate::configuration::{Arrangement, Configuration};
use crate::estimator::{Estimator, Job, Scratch, for_technique};
use crate::sampling::{Strategy, StreamKey, Technique};
use crate::statistics::budget::seed_of;

/// A small case.
pub(super) struct Room {
    pub case: Case,
    /// For each technique, the share of its rays that arrive at each point.
    arriving: BTreeMap<Technique, Vec<f64>>,
}

impl Room {
    /// The share of a strategy's rays that arrive at each point.
    pub fn arriving(&self, strategy: Strategy) -> &[f64] {
        &self.arriving[&strategy.technique()]
    }
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
/// Rays that shares are counted from.
const COUNTED_RAYS: u64 = 1 << 15;

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
    let mut shares = BTreeMap::new();
    for strategy in Strategy::ALL {
        shares.entry(strategy.technique()).or_insert_with(|| arriving(&configuration, name, strategy));
    }
    Room { case: Case::new(name, of, configuration, study), arriving: shares }
}

/// The share of a strategy's rays that arrive at each point, counted: which intervals have enough of them to be printed.
fn arriving(configuration: &Configuration, name: &str, strategy: Strategy) -> Vec<f64> {
    let estimator: Box<dyn Estimator> = for_technique(configuration, strategy.technique());
    let points = configuration.points();
    let cell = StreamKey::root(seed_of(&format!("calibration/arriving/{name}/{strategy}")));
    let job = Job { strategy, samples: 1, cell, replicates: 0..COUNTED_RAYS, points };
    let mut estimates = vec![0.0; points.len() * COUNTED_RAYS as usize];
    estimator.estimate(&job, &mut Scratch::default(), &mut estimates);
    let share = |row: &[f64]| row.iter().filter(|x| **x > 0.0).count() as f64 / COUNTED_RAYS as f64;
    estimates.chunks_exact(COUNTED_RAYS as usize).map(share).collect()
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
        assert!(named("umbra alone").arriving(Strategy::Random).iter().all(|share| *share == 0.0));
        let deep = named("deep penumbra");
        assert!(regions(deep).iter().all(|region| *region == Region::Penumbra));
        let share = deep.arriving(Strategy::Random)[0];
        assert!(share > 0.0 && share < 0.01, "{share}");
        assert!(deep.arriving(Strategy::Cosine)[0] < share, "directions must find the source first");
        assert!(regions(named("umbra to light")).contains(&Region::Lit));
        assert_eq!(named("one lit point").arriving(Strategy::Stratified), [1.0]);
        assert!(rooms.iter().any(|room| room.case.configuration.sources().len() == 2));
    }
}
