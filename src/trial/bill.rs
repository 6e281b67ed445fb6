//! What the units of a run cost, and which shard pays: before anything is spent.

use std::time::Instant;

use super::desk::{Portion, Stage, is_whole};
use super::division::{Division, Shard};
use super::forecast::{CellCost, Forecast, forecast_case};
use super::indirect::{compared, planned_paths, surveyed};
use super::keeper::Unit;
use super::light::budgets;
use super::measure::BATCHES;
use super::settings::{Effort, Settings};
use crate::case::Case;
use crate::geometry::Shape;
use crate::light::{LightSettings, LightTracer};
use crate::path::{PathSettings, PathTracer};

/// Rays, and paths from each point, of one timing: some tens of milliseconds.
const TIMED_RAYS: u64 = 1 << 15;
const TIMED_PATHS: u64 = 1 << 10;
/// Bytes of a run before anything, of a triangle with its hierarchy and silhouette, of a texel of a map with its totals, of a
/// measured point with its sums. Measured; generous.
const BASE_BYTES: u64 = 48 << 20;
const TRIANGLE_BYTES: u64 = 320;
const TEXEL_BYTES: u64 = 120;
const POINT_BYTES: u64 = 16 << 10;

/// One unit, and the processor seconds that it should take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    pub unit: Unit,
    pub seconds: f64,
}

/// What a run should cost.
pub struct Bill {
    /// Of direct light, case by case and strategy by strategy.
    pub forecasts: Vec<Forecast>,
    /// All units that are somebody's own, in the order of the run.
    pub items: Vec<Item>,
    /// Of each case: processor seconds of its exact values and predictions, which every shard pays that has some of it.
    pub exact_seconds: Vec<f64>,
    /// Most memory that a process should need.
    pub bytes: u64,
    division: Division,
}

/// What one shard should cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShardCost {
    /// Units of its own.
    pub units: u64,
    pub seconds: f64,
}

impl Bill {
    /// Plans and times every case, on this machine.
    pub fn new(cases: &[Case], settings: &Settings) -> Bill {
        let mut bill = Bill {
            forecasts: Vec::new(),
            items: Vec::new(),
            exact_seconds: Vec::new(),
            bytes: cases.iter().map(bytes_of).max().unwrap_or(BASE_BYTES),
            division: Division::new(cases, settings),
        };
        for (index, case) in cases.iter().enumerate() {
            let (forecasts, cells, exact_seconds) = forecast_case(case, settings);
            bill.forecasts.extend(forecasts);
            bill.exact_seconds.push(exact_seconds);
            for CellCost { strategy, samples, rays, seconds } in cells {
                let parts = if is_whole(rays) { 1 } else { BATCHES as u32 };
                bill.add(index, Stage::Measure { strategy, samples }, parts, seconds);
            }
            bill.add_light(index, case, settings);
        }
        bill
    }

    fn add(&mut self, case: usize, stage: Stage, of: u32, seconds: f64) {
        self.items.extend((0..of).map(|index| Item {
            unit: Unit { case: case as u32, portion: Portion { stage, index, of } },
            seconds: seconds / f64::from(of),
        }));
    }

    /// Rays from the light and paths from the eye.
    fn add_light(&mut self, index: usize, case: &Case, settings: &Settings) {
        let room = &case.configuration;
        let quick = settings.effort == Effort::Quick;
        let threads = rayon::current_num_threads() as f64;
        let timed = |work: &dyn Fn()| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * threads
        };
        let light = |rays: u64| LightTracer::new(room, &LightSettings { rays, ..case.light.clone() }, settings.seed);
        if room.has_optics() || !room.lamps().is_empty() {
            let few = light(TIMED_RAYS.min(case.light.rays));
            let a_ray = timed(&|| drop(few.run())) / TIMED_RAYS.min(case.light.rays) as f64;
            let mut stages = budgets(case, quick).map(|rays| (Stage::Light { rays }, rays)).to_vec();
            if room.has_optics() && room.receiver().is_some() {
                stages.push((Stage::Compared, compared(case, quick)));
            }
            for (stage, rays) in stages {
                self.add(index, stage, light(rays).n_pieces().max(1) as u32, a_ray * rays as f64);
            }
        }
        for next_event in [false, true] {
            let smallest = settings.study(&case.study).smallest_bias;
            let Some(paths) = planned_paths(case, next_event, smallest) else { continue };
            let tracer =
                PathTracer::new(room, &PathSettings { next_event, ..PathSettings::default() }, settings.seed);
            let a_path = timed(&|| drop(tracer.at_points(TIMED_PATHS * 4))) / (TIMED_PATHS * 4) as f64;
            let pieces = tracer.asked(paths).n_pieces().max(1) as u32;
            self.add(index, Stage::Paths { next_event }, pieces, a_path * paths as f64);
        }
        if room.has_optics() && room.receiver().is_some() {
            let tracer = PathTracer::new(room, &PathSettings::default(), settings.seed);
            let a_path = timed(&|| drop(tracer.over_receiver(TIMED_PATHS * 4))) / (TIMED_PATHS * 4) as f64;
            let paths = surveyed(tracer.can_reach(), quick);
            self.add(index, Stage::Survey, 1, a_path * paths as f64);
        }
    }

    /// What each of N shards should cost, the exact side of its cases included.
    pub fn shards(&self, of: u32) -> Vec<ShardCost> {
        let mut costs = vec![ShardCost::default(); of as usize];
        for Item { unit, seconds } in &self.items {
            let owner = self.division.owner(unit, of).unwrap_or(0);
            let cost = &mut costs[owner as usize];
            cost.units += 1;
            cost.seconds += seconds;
        }
        for (index, cost) in costs.iter_mut().enumerate() {
            let shard = Shard { index: index as u32, of };
            let exact = self.exact_seconds.iter().enumerate();
            let own = exact.filter(|(case, _)| self.division.has(shard, *case as u32, Stage::Exact));
            cost.seconds += own.map(|(_, seconds)| seconds).sum::<f64>();
        }
        costs
    }

    /// Processor seconds of the run on one machine.
    pub fn seconds(&self) -> f64 {
        self.items.iter().map(|item| item.seconds).sum::<f64>() + self.exact_seconds.iter().sum::<f64>()
    }
}

fn bytes_of(case: &Case) -> u64 {
    let room = &case.configuration;
    let triangles = room.occluders().iter().map(|shape| match shape {
        Shape::Mesh(mesh) => mesh.triangles().len() as u64,
        _ => 0,
    });
    let surfaces = room.diffuse().len() as u64 + u64::from(room.receiver().is_some());
    let bent = room.has_optics() || !room.lamps().is_empty();
    let texels = if bent { (case.light.map[0] * case.light.map[1]) as u64 * surfaces } else { 0 };
    BASE_BYTES
        + TRIANGLE_BYTES * triangles.sum::<u64>()
        + TEXEL_BYTES * texels
        + POINT_BYTES * room.points().len() as u64
}
