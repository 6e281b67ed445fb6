//! Limits by a scan and bisection on the exact side's own classification.

use super::path::Path;
use super::{Limit, LimitMethod, Phase};
use crate::configuration::{Configuration, Source};
use crate::oracle::Region;
use crate::oracle::exact::{self, Oracle};

/// Even stretches of the first scan.
const STRETCHES: u32 = 1024;

/// How far the exact side's classification may misplace a limit, in units of the room's coordinates: contacts are judged from
/// rounded crossings. The largest misplacement in 6,000 random rooms with a closed form was a tenth of this.
const MISPLACED: f64 = 256.0 * f64::EPSILON;

/// All limits along a path, in order.
pub(super) fn limits(configuration: &Configuration, path: &Path) -> Vec<Limit> {
    let shapes = configuration.sources().iter().map(Source::shape).chain(configuration.blockers());
    let size = shapes
        .flat_map(|shape| <[_; 2]>::from(shape.bounds()))
        .chain([0.0, path.length()].map(|end| path.at(end).position()))
        .map(|corner| corner.abs().max_element())
        .fold(0.0, f64::max);
    let search = Search { oracle: Oracle::new(configuration), path, size };
    let mut found = Vec::new();
    let mut last: Option<Place> = None;
    for i in 0..=STRETCHES {
        let distance = path.length() * (f64::from(i) / f64::from(STRETCHES));
        let Some(phase) = search.phase(distance) else { continue };
        let here = Place { distance, phase };
        if let Some(last) = last.filter(|last| last.phase != phase) {
            search.between(last, here, &mut found);
        }
        last = Some(here);
    }
    found
}

#[derive(Clone, Copy)]
struct Place {
    distance: f64,
    phase: Phase,
}

struct Search<'a> {
    oracle: Oracle,
    path: &'a Path,
    /// The largest coordinate in the room, metres.
    size: f64,
}

impl Search<'_> {
    /// `None` where the exact side cannot tell.
    fn phase(&self, distance: f64) -> Option<Phase> {
        let seen = self.oracle.seen(&self.path.at(distance));
        match self.oracle.together(&seen).region {
            Region::Edge => None,
            Region::BelowHorizon => Some(Phase::BelowHorizon),
            Region::Umbra => Some(Phase::Umbra),
            Region::Lit => Some(Phase::Lit),
            Region::Penumbra if exact::is_annular(&seen) => Some(Phase::Antumbra),
            Region::Penumbra => Some(Phase::Penumbra),
        }
    }

    /// The limits between two places of different phases.
    fn between(&self, mut low: Place, mut high: Place, found: &mut Vec<Limit>) {
        while let Some(middle) = halfway(low.distance, high.distance) {
            match self.phase(middle) {
                Some(phase) if phase == low.phase => low.distance = middle,
                Some(phase) if phase == high.phase => high.distance = middle,
                Some(phase) => {
                    let middle = Place { distance: middle, phase };
                    self.between(low, middle, found);
                    self.between(middle, high, found);
                    return;
                }
                None => {
                    low.distance = self.last(low, middle);
                    high.distance = self.last(high, middle);
                    break;
                }
            }
        }
        let distance = low.distance + 0.5 * (high.distance - low.distance);
        found.push(Limit {
            distance,
            position: self.path.at(distance).position(),
            before: low.phase,
            after: high.phase,
            bound: (high.distance - low.distance) + MISPLACED * self.size,
            method: LimitMethod::Bisection,
        });
    }

    /// The last place of a phase on the way to one where it cannot be told.
    fn last(&self, known: Place, unclear: f64) -> f64 {
        let (mut known_to, mut unclear) = (known.distance, unclear);
        while let Some(middle) = halfway(known_to, unclear) {
            if self.phase(middle) == Some(known.phase) { known_to = middle } else { unclear = middle }
        }
        known_to
    }
}

/// A number between two others, if there is one.
fn halfway(a: f64, b: f64) -> Option<f64> {
    let middle = a + 0.5 * (b - a);
    (middle != a && middle != b).then_some(middle)
}
