//! Whether two machines give the same numbers: a digest of some, taken from every wing of the house.

use super::predict::strata;
use crate::case::{Case, Study};
use crate::configuration::Sha256;
use crate::estimator::{Job, Scratch, for_technique};
use crate::light::{LightSettings, LightTracer};
use crate::oracle::Oracle;
use crate::oracle::optics::CausticLayout;
use crate::sampling::{Purpose, Strategy, StreamKey};

/// Points of the case at which numbers are taken, and what is taken there: a millisecond's work.
const EVERY: usize = 16;
const SAMPLES: u64 = 16;
const REPLICATES: u64 = 4;
const RAYS: u64 = 256;

/// Sixteen hexadecimal digits, which two builds share only if exact values, predictions, estimates by every strategy and
/// rays from the light come out the same on them, to the last bit (of those that are tried: half a shadow, a caustic).
pub fn numeric_fingerprint() -> String {
    let mut digest = Sha256::new();
    let mut take = |value: f64| digest.update(&value.to_bits().to_le_bytes());
    for name in ["penumbra/eclipse", "caustic/glass-ball"] {
        let Ok(case) = Case::shipped(name) else { continue };
        of_direct_light(&case, &mut take);
        of_caustics(&case, &mut take);
    }
    digest.finalize()[..8].iter().map(|byte| format!("{byte:02x}")).collect()
}

fn of_direct_light(case: &Case, take: &mut dyn FnMut(f64)) {
    let room = &case.configuration;
    let points: Vec<_> = room.points().iter().step_by(EVERY).copied().collect();
    if room.sources().is_empty() || points.is_empty() {
        return;
    }
    let oracle = Oracle::new(room);
    for point in &points {
        let truth = oracle.at(point);
        take(truth.irradiance.watts_per_square_metre());
        take(truth.bound.watts_per_square_metre());
        oracle.area_moments(0, point).iter().for_each(|moments| take(moments.spread().variance));
    }
    let study = Study { strategies: Vec::new(), ..Study::default() };
    // Strata are what predictions take longest for; one point says enough of them.
    let spreads = oracle.strata_spreads(&points[points.len() / 2], &study.samples[..2], &strata);
    spreads.into_iter().flatten().for_each(|spread| take(spread.variance));
    for strategy in Strategy::ALL {
        let estimator = for_technique(room, strategy.technique());
        let cell = StreamKey::cell(1, room.digest().key(), Purpose::Pilot, strategy, SAMPLES);
        let job = Job { strategy, samples: SAMPLES, cell, replicates: 0..REPLICATES, points: &points };
        let mut estimates = vec![0.0; points.len() * REPLICATES as usize];
        estimator.estimate(&job, &mut Scratch::default(), &mut estimates);
        estimates.iter().for_each(|estimate| take(*estimate));
    }
}

fn of_caustics(case: &Case, take: &mut dyn FnMut(f64)) {
    let room = &case.configuration;
    let Some(layout) = CausticLayout::of(room) else { return };
    for order in layout.orders().take(1) {
        layout.power_in_ring(order, 0.1, 0.2).iter().for_each(|power| take(power.value));
    }
    let settings = LightSettings { rays: RAYS, map: [8, 8], ..case.light.clone() };
    let run = LightTracer::new(room, &settings, 1).run();
    take(run.ledger.deposited);
    take(run.ledger.absorbed);
    run.maps.iter().for_each(|map| take(map.total(crate::light::Light::Both)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_machine_has_one_fingerprint() {
        let first = numeric_fingerprint();
        assert_eq!((first.len(), &first), (16, &numeric_fingerprint()));
    }
}
