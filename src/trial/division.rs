//! A run divided among shards, by what its cases say alone: no shard needs to know what another does, or what it found.
//!
//! The stages of all cases are laid out in a row, each as long as it should take, and the row is cut into equal pieces. A
//! unit belongs to the piece in which its middle lies. So a shard has few cases, and the exact side of a case, which every
//! shard needs that has some of it, is found by few.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::desk::Stage;
use super::indirect::{compared, surveyed};
use super::keeper::Unit;
use super::light::budgets;
use super::settings::{Effort, Settings};
use crate::case::{Case, Replicates, Study};
use crate::geometry::Shape;
use crate::oracle::optics::RoomLight;
use crate::sampling::Strategy;

/// Nanoseconds that a mesh adds to a shadow ray; of a ray from the light, of an eye path.
const PAST_A_MESH: u128 = 36;
const LIGHT_RAY: u128 = 200;
const EYE_PATH: u128 = 100;
/// Eye paths from all points that a bias as large as the mean needs, about.
const EYE_PATHS: f64 = 1e3;

/// One of the parts that a run is divided into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Shard {
    /// Counted from 0.
    pub index: u32,
    /// How many there are; ≥ 1.
    pub of: u32,
}

impl Shard {
    /// Most shards.
    pub const MOST: u32 = 100_000;

    /// Whether there is such a part.
    pub fn is_valid(self) -> bool {
        self.index < self.of && self.of <= Shard::MOST
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

/// From where to where in the row.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    start: u128,
    length: u128,
}

/// A run, laid out in a row.
pub struct Division {
    /// Of each case: its stages.
    cases: Vec<BTreeMap<Stage, Stretch>>,
    total: u128,
}

impl Division {
    pub fn new(cases: &[Case], settings: &Settings) -> Division {
        let mut total = 0;
        let of_case = |case| {
            let mut stages = BTreeMap::new();
            for (stage, length) in stages_of(case, settings) {
                // Runs of equal length are one.
                stages.entry(stage).or_insert_with(|| {
                    let start = total;
                    total += length;
                    Stretch { start, length }
                });
            }
            stages
        };
        let cases = cases.iter().map(of_case).collect();
        Division { cases, total }
    }

    /// Whose a unit is; `None` where everybody makes it who needs it.
    pub fn owner(&self, unit: &Unit, of: u32) -> Option<u32> {
        let stretch = self.stretch(unit.case, unit.portion.stage)?;
        let (index, parts) = (u128::from(unit.portion.index), u128::from(unit.portion.of.max(1)));
        let twice_parts = 2 * parts;
        // The middle, in units of a part's half.
        let middle = stretch.start * twice_parts + stretch.length * (2 * index + 1);
        let owner = middle * u128::from(of) / (self.total.max(1) * twice_parts);
        Some((owner as u32).min(of - 1))
    }

    /// Whether a shard may have anything of a stage.
    pub fn has(&self, shard: Shard, case: u32, stage: Stage) -> bool {
        match stage {
            Stage::Exact | Stage::Predictions => {
                let stages = self.cases.get(case as usize);
                let cells = stages.into_iter().flat_map(BTreeMap::keys);
                let mut cells = cells.filter(|stage| matches!(stage, Stage::Measure { .. }));
                cells.any(|stage| self.has(shard, case, *stage))
            }
            Stage::Pilot { strategy, samples } => self.has(shard, case, Stage::Measure { strategy, samples }),
            _ => self.stretch(case, stage).is_some_and(|Stretch { start, length }| {
                let edge = |index: u32| self.total * u128::from(index) / u128::from(shard.of);
                // One wider on either side than need be: who has nothing there after all makes nothing.
                start <= edge(shard.index + 1) && start + length >= edge(shard.index)
            }),
        }
    }

    /// `None` for what belongs to everybody who has some of the case.
    fn stretch(&self, case: u32, stage: Stage) -> Option<Stretch> {
        if matches!(stage, Stage::Exact | Stage::Predictions | Stage::Pilot { .. }) {
            return None;
        }
        let stages = self.cases.get(case as usize)?;
        stages.get(&stage).copied()
    }
}

/// The stages of a case with the nanoseconds that they should take, as far as can be told without finding out.
fn stages_of(case: &Case, settings: &Settings) -> Vec<(Stage, u128)> {
    let room = &case.configuration;
    let study = settings.study(&case.study);
    let mut stages = Vec::new();
    if case.measures_direct_light() {
        let has_mesh = room.occluders().iter().any(|shape| matches!(shape, Shape::Mesh(_)));
        let past = if has_mesh { PAST_A_MESH } else { 0 };
        let at_once = room.sources().len() as u128 * room.points().len() as u128;
        for strategy in &study.strategies {
            let Price { ray, needed } = price(*strategy);
            for samples in &study.samples {
                let stage = Stage::Measure { strategy: *strategy, samples: *samples };
                stages.push((stage, at_once * (ray + past) * samples_in_all(&study, *samples, needed)));
            }
        }
    }
    let quick = settings.effort == Effort::Quick;
    let bends = room.has_optics();
    if bends || !room.lamps().is_empty() {
        let rays = budgets(case, quick).map(|rays| (Stage::Light { rays }, LIGHT_RAY * u128::from(rays)));
        stages.extend(rays);
    }
    if RoomLight::new(room).judged().is_some() {
        let paths = (EYE_PATHS / square(study.smallest_bias.mean)) as u128;
        stages.extend([false, true].map(|next_event| (Stage::Paths { next_event }, EYE_PATH * paths)));
    }
    if bends {
        stages.push((Stage::Survey, EYE_PATH * u128::from(surveyed(true, quick))));
        stages.push((Stage::Compared, LIGHT_RAY * u128::from(compared(case, quick))));
    }
    stages
}

/// What a strategy takes, about.
struct Price {
    /// Nanoseconds of a shadow ray, with its point; with what its pilot adds.
    ray: u128,
    /// Samples that a bias as large as the mean needs.
    needed: f64,
}

/// Measured: means over the shipped cases, rounded. They decide who makes what, never what comes of it.
fn price(strategy: Strategy) -> Price {
    let (ray, needed) = match strategy {
        Strategy::Random => (8, 6.0),
        Strategy::Correlated => (3, 40.0),
        Strategy::Stratified => (9, 4.0),
        Strategy::UniformJitter => (60, 4.0),
        Strategy::LatinHypercube => (110, 4.0),
        Strategy::MultiJittered => (160, 4.0),
        Strategy::Sobol => (80, 4.0),
        Strategy::SolidAngle => (170, 4.0),
        Strategy::Cosine => (75, 160.0),
        Strategy::MisBalance | Strategy::MisPower => (78, 4.0),
    };
    Price { ray, needed }
}

/// Samples of a cell at one point and on one source, over all replicates: as said, or as its smallest bias should need.
fn samples_in_all(study: &Study, samples: u64, needed: f64) -> u128 {
    let replicates = match study.replicates {
        Replicates::Fixed(replicates) => u128::from(replicates),
        Replicates::Auto => {
            let bias = study.smallest_bias.mean.min(study.smallest_bias.point);
            let needed = (needed / square(bias)) as u128 / u128::from(samples);
            needed.max(128).max(16_384 / u128::from(samples))
        }
    };
    replicates * u128::from(samples)
}

/// Of a bias; none is taken for smaller than can be seen in any time.
fn square(bias: f64) -> f64 {
    let bias = bias.max(1e-9);
    bias * bias
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::desk::Portion;

    fn shipped() -> Vec<Case> {
        crate::case::shipped().map(|case| case.read().unwrap()).collect()
    }

    fn units(division: &Division) -> Vec<Unit> {
        let mut units = Vec::new();
        for (case, stages) in division.cases.iter().enumerate() {
            // In the order of the row.
            let mut stages: Vec<&Stage> = stages.keys().collect();
            stages.sort_by_key(|stage| division.stretch(case as u32, **stage).map(|stretch| stretch.start));
            for stage in stages {
                let portion = |index| Portion { stage: *stage, index, of: 32 };
                units.extend((0..32).map(|index| Unit { case: case as u32, portion: portion(index) }));
            }
        }
        units
    }

    #[test]
    fn every_unit_is_one_shards_and_that_shard_looks_for_it() {
        let settings = Settings { seed: 1, effort: Effort::Standard, overrides: Default::default() };
        let division = Division::new(&shipped(), &settings);
        for of in [1, 2, 3, 7, 100, 1000, Shard::MOST] {
            let mut last = 0;
            for unit in units(&division) {
                let owner = division.owner(&unit, of).unwrap();
                assert!(owner < of && owner >= last, "{unit:?} of {of}: {owner} after {last}");
                assert!(division.has(Shard { index: owner, of }, unit.case, unit.portion.stage), "{unit:?} of {of}");
                last = owner;
            }
        }
    }

    #[test]
    fn shards_have_few_cases_and_equal_lengths() {
        let settings = Settings { seed: 1, effort: Effort::Standard, overrides: Default::default() };
        let cases = shipped();
        let division = Division::new(&cases, &settings);
        let of = 20;
        let mut lengths = vec![0; of as usize];
        for unit in units(&division) {
            let stretch = division.stretch(unit.case, unit.portion.stage).unwrap();
            lengths[division.owner(&unit, of).unwrap() as usize] += stretch.length / 32;
        }
        let mean = division.total / u128::from(of);
        assert!(lengths.iter().all(|length| *length * 10 > mean * 8 && *length * 10 < mean * 12), "{lengths:?}");
        let looks = |index| {
            let exact = |case: &usize| division.has(Shard { index, of }, *case as u32, Stage::Exact);
            (0..cases.len()).filter(exact).count()
        };
        let looks: usize = (0..of).map(looks).sum();
        let measured = cases.iter().filter(|case| case.measures_direct_light()).count();
        assert!(looks <= measured + 2 * of as usize, "{looks} times the exact side of {measured} cases");
    }
}
