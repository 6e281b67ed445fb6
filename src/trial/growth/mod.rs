//! How cost grows: with samples, occluders, triangles, points and rays from the light. Rooms that differ in one number, timed
//! on one thread, and the laws that their times follow. Times are those of the machine at hand; exponents hardly are.

mod fit;
mod rooms;

use std::hint::black_box;
use std::time::Instant;

use super::cost::median;
use super::measure::replicates_at_once;
use super::run::TrialError;
use super::settings::Effort;
use crate::configuration::Configuration;
use crate::estimator::{Estimator, Job, Scratch, for_technique};
use crate::light::{LightSettings, LightTracer};
use crate::sampling::{Strategy, StreamKey};
use crate::scene::Hierarchy;

pub use fit::{Affine, Fits, Law, PowerLaw};

/// What one repeat of a measurement takes at least, seconds: far above what a clock or a scheduler stirs.
const LEAST: f64 = 0.02;
const REPEATS: usize = 5;
/// Measurements that have taken so long already are content with fewer repeats, seconds.
const LONG: f64 = 1.0;
const FEWEST_REPEATS: usize = 3;

/// Times of rooms that differ in one number.
#[derive(Clone, Debug)]
pub struct GrowthStudy {
    /// One of [`GrowthStudy::NAMES`].
    pub name: &'static str,
    /// What was looked at, as a sentence without its stop.
    pub title: &'static str,
    /// What x counts.
    pub quantity: &'static str,
    /// What the seconds are of.
    pub timed: &'static str,
    /// What [`Observation::per_unit_ns`] is of.
    pub unit: &'static str,
    /// What is expected.
    pub law: Law,
    /// Ascending in x.
    pub observations: Vec<Observation>,
}

impl GrowthStudy {
    /// All, in the order of the report.
    pub const NAMES: [&str; 6] = ["samples", "occluders", "mesh-build", "mesh-rays", "points", "light-rays"];

    /// The laws through all observations.
    pub fn fits(&self) -> Fits {
        let pairs: Vec<(f64, f64)> = self.observations.iter().map(|seen| (seen.x as f64, seen.seconds)).collect();
        Fits::of(&pairs, self.law)
    }
}

/// One room, timed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// What [`GrowthStudy::quantity`] counts.
    pub x: u64,
    /// Of one thread, median of the repeats.
    pub seconds: f64,
    /// The quickest and the slowest repeat.
    pub seconds_low: f64,
    pub seconds_high: f64,
    /// Samples, rays, triangles or points that the seconds are of.
    pub units: f64,
    pub repeats: u64,
}

impl Observation {
    /// Nanoseconds of one [`GrowthStudy::unit`].
    pub fn per_unit_ns(&self) -> f64 {
        self.seconds * 1e9 / self.units
    }
}

/// Measures all studies on one thread, in seconds; [`Effort::Quick`] leaves out sizes and the largest mesh.
///
/// - `progress`: told each study's name as it begins
pub fn growth(effort: Effort, progress: &(dyn Fn(&str) + Sync)) -> Result<Vec<GrowthStudy>, TrialError> {
    let sizes = Sizes::of(effort);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|_| TrialError::NoThread)?;
    Ok(alone.install(|| studies(&sizes, LEAST, progress)))
}

/// What each study goes through.
#[derive(Clone, Debug)]
struct Sizes {
    samples: Vec<u64>,
    occluders: Vec<u64>,
    /// Squares along each side of a sheet, two triangles each.
    sheets: Vec<u64>,
    /// Points along each side of a grid.
    points: Vec<u64>,
    light_rays: Vec<u64>,
}

impl Sizes {
    fn of(effort: Effort) -> Sizes {
        let each = |list: &[u64]| list.to_vec();
        match effort {
            Effort::Quick => Sizes {
                samples: (1..=4).map(|k| 1 << (4 * k - 2)).collect(),
                occluders: each(&[1, 4, 16, 64]),
                sheets: each(&[22, 71, 224]),
                points: each(&[1, 4, 16, 64]),
                light_rays: each(&[1_000, 10_000, 100_000]),
            },
            Effort::Standard | Effort::Thorough => Sizes {
                samples: (1..=8).map(|k| 1 << (2 * k)).collect(),
                occluders: (0..=6).map(|k| 1 << k).collect(),
                sheets: each(&[22, 39, 71, 122, 224, 387, 707]),
                points: (0..=6).map(|k| 1 << k).collect(),
                light_rays: each(&[1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000]),
            },
        }
    }
}

fn studies(sizes: &Sizes, least: f64, progress: &(dyn Fn(&str) + Sync)) -> Vec<GrowthStudy> {
    let [samples, occluders, build, rays, points, light] = GrowthStudy::NAMES;
    let begun = |name: &'static str| {
        progress(name);
        name
    };
    let samples = GrowthStudy {
        name: begun(samples),
        title: "Samples: a rectangle behind a disk, one point in the penumbra, strategy random",
        quantity: "samples N",
        timed: "one estimate",
        unit: "sample",
        law: Law::Linear,
        observations: sizes.samples.iter().map(|n| of_samples(*n, least)).collect(),
    };
    let occluders = GrowthStudy {
        name: begun(occluders),
        title: "Occluders: disks apart from each other before a rectangle, one point, N = 1024",
        quantity: "disks",
        timed: "one shadow ray",
        unit: "shadow ray",
        law: Law::Linear,
        observations: sizes.occluders.iter().map(|n| of_occluders(*n, least)).collect(),
    };
    begun(build);
    let (mut of_build, mut of_rays) = (Vec::new(), Vec::new());
    for side in &sizes.sheets {
        let (building, tracing) = of_sheet(*side, least);
        of_build.push(building);
        of_rays.push(tracing);
    }
    let build = GrowthStudy {
        name: build,
        title: "Triangles: building the hierarchy over a wavy sheet",
        quantity: "triangles",
        timed: "building the hierarchy",
        unit: "triangle",
        law: Law::Linear,
        observations: of_build,
    };
    let rays = GrowthStudy {
        name: begun(rays),
        title: "Triangles: a shadow ray through the hierarchy over a wavy sheet",
        quantity: "triangles",
        timed: "one shadow ray",
        unit: "shadow ray",
        law: Law::Logarithmic,
        observations: of_rays,
    };
    let points = GrowthStudy {
        name: begun(points),
        title: "Points: a grid below a rectangle behind a disk, N = 64 of its own at each point",
        quantity: "points",
        timed: "one estimate at every point",
        unit: "point",
        law: Law::Linear,
        observations: sizes.points.iter().map(|side| of_points(*side, least)).collect(),
    };
    let light = GrowthStudy {
        name: begun(light),
        title: "Rays from the light: a beam through a ball of glass onto a map of 64 × 64 texels",
        quantity: "light rays",
        timed: "all rays",
        unit: "light ray",
        law: Law::Linear,
        observations: sizes.light_rays.iter().map(|rays| of_light(*rays, least)).collect(),
    };
    vec![samples, occluders, build, rays, points, light]
}

/// Estimates in one room, again and again with other streams.
struct Estimating<'a> {
    room: &'a Configuration,
    estimator: Box<dyn Estimator>,
    samples: u64,
    replicates: u64,
    scratch: Scratch,
    estimates: Vec<f64>,
    next: u64,
}

impl<'a> Estimating<'a> {
    fn new(room: &'a Configuration, samples: u64) -> Estimating<'a> {
        let n_points = room.points().len();
        // As many at once as a run takes, so that small estimates fill a block together.
        let replicates = (65_536 / (samples * n_points as u64)).clamp(1, replicates_at_once(n_points));
        Estimating {
            room,
            estimator: for_technique(room, Strategy::Random.technique()),
            samples,
            replicates,
            scratch: Scratch::default(),
            estimates: vec![0.0; n_points * replicates as usize],
            next: 0,
        }
    }

    /// `replicates` estimates at every point.
    fn go_on(&mut self) {
        let replicates = self.next..self.next + self.replicates;
        self.next = replicates.end;
        let cell = StreamKey::root(self.samples);
        let points = self.room.points();
        let job = Job { strategy: Strategy::Random, samples: self.samples, cell, replicates, points };
        self.estimator.estimate(&job, &mut self.scratch, &mut self.estimates);
        black_box(&mut self.estimates);
    }
}

fn of_samples(n: u64, least: f64) -> Observation {
    let room = rooms::behind_a_disk(1);
    let mut estimating = Estimating::new(&room, n);
    let replicates = estimating.replicates as f64;
    Timed { x: n, units: n as f64, done_at_once: replicates }.observe(least, || estimating.go_on())
}

fn of_occluders(n: u64, least: f64) -> Observation {
    let room = rooms::behind_disks(n);
    let mut estimating = Estimating::new(&room, 1024);
    let rays = 1024.0 * estimating.replicates as f64;
    Timed { x: n, units: 1.0, done_at_once: rays }.observe(least, || estimating.go_on())
}

/// Building the hierarchy, and rays through it.
fn of_sheet(side: u64, least: f64) -> (Observation, Observation) {
    let mesh = rooms::sheet(side);
    let triangles = mesh.triangles().len() as u64;
    let reach = rooms::reach_of_sheet();
    let built = Timed { x: triangles, units: triangles as f64, done_at_once: 1.0 }
        .observe(least, || drop(black_box(Hierarchy::new(&mesh, reach))));
    let room = rooms::behind_a_sheet(mesh);
    let mut estimating = Estimating::new(&room, 1024);
    let rays = 1024.0 * (estimating.replicates * room.points().len() as u64) as f64;
    let traced = Timed { x: triangles, units: 1.0, done_at_once: rays }.observe(least, || estimating.go_on());
    (built, traced)
}

fn of_points(side: u64, least: f64) -> Observation {
    let room = rooms::behind_a_disk(side);
    let n_points = room.points().len() as u64;
    let mut estimating = Estimating::new(&room, 64);
    let replicates = estimating.replicates as f64;
    Timed { x: n_points, units: n_points as f64, done_at_once: replicates }.observe(least, || estimating.go_on())
}

fn of_light(rays: u64, least: f64) -> Observation {
    let tracer = LightTracer::new(&rooms::ball_of_glass(), &LightSettings { rays, ..LightSettings::default() }, 1);
    let sent = black_box(tracer.run()).ledger.rays;
    Timed { x: sent, units: sent as f64, done_at_once: 1.0 }.observe(least, || drop(black_box(tracer.run())))
}

/// What is timed.
struct Timed {
    x: u64,
    /// In what the seconds are of.
    units: f64,
    /// How often the work does what the seconds are of.
    done_at_once: f64,
}

impl Timed {
    /// Repeats of at least `least` seconds each, after one that warms up and tells how much work that is.
    fn observe(self, least: f64, mut work: impl FnMut()) -> Observation {
        let mut time = |times: u64| {
            let start = Instant::now();
            (0..times).for_each(|_| work());
            start.elapsed().as_secs_f64()
        };
        let begun = Instant::now();
        let mut times = 1;
        let mut took = time(times);
        while took < 0.25 * least {
            times *= if took < 0.02 * least { 8 } else { 2 };
            took = time(times);
        }
        let times = ((times as f64 * least / took).ceil() as u64).max(1);
        let mut seconds = Vec::with_capacity(REPEATS);
        while seconds.len() < REPEATS
            && (seconds.len() < FEWEST_REPEATS || begun.elapsed().as_secs_f64() < LONG.max(least))
        {
            seconds.push(time(times) / (times as f64 * self.done_at_once));
        }
        let fold = |of: fn(f64, f64) -> f64, from: f64| seconds.iter().copied().fold(from, of);
        Observation {
            x: self.x,
            seconds_low: fold(f64::min, f64::INFINITY),
            seconds_high: fold(f64::max, 0.0),
            units: self.units,
            repeats: seconds.len() as u64,
            seconds: median(seconds).unwrap_or(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tiny() -> Vec<GrowthStudy> {
        let sizes = Sizes {
            samples: vec![4, 16, 64],
            occluders: vec![1, 4],
            sheets: vec![3, 6, 9],
            points: vec![1, 2],
            light_rays: vec![100, 300],
        };
        studies(&sizes, 1e-4, &|_| {})
    }

    #[test]
    fn every_study_times_what_it_says() {
        let studies = tiny();
        assert!(studies.iter().map(|study| study.name).eq(GrowthStudy::NAMES));
        let counts = |study: usize| studies[study].observations.iter().map(|seen| seen.x).collect::<Vec<_>>();
        assert_eq!(counts(0), [4, 16, 64]);
        assert_eq!((counts(1), counts(4)), (vec![1, 4], vec![1, 4]));
        assert_eq!((counts(2), counts(3)), (vec![18, 72, 162], vec![18, 72, 162]));
        assert!(counts(5)[0] >= 100 && counts(5)[1] >= 300);
        for seen in studies.iter().flat_map(|study| &study.observations) {
            assert!(seen.seconds > 0.0 && seen.seconds_low <= seen.seconds && seen.seconds <= seen.seconds_high);
            assert!((FEWEST_REPEATS..=REPEATS).contains(&(seen.repeats as usize)), "{seen:?}");
            assert!(seen.per_unit_ns() > 0.0);
        }
    }

    #[test]
    fn repeats_are_long_enough_and_counted_out() {
        let mut calls = 0_u64;
        let seen = Timed { x: 3, units: 3.0, done_at_once: 2.0 }.observe(2e-3, || {
            calls += 1;
            std::thread::sleep(std::time::Duration::from_micros(300));
        });
        // A call sleeps for at least 300 µs and does the thing twice.
        assert!(seen.seconds_low >= 1.5e-4, "{seen:?}");
        // On a machine with other work fewer may do.
        assert!((FEWEST_REPEATS..=REPEATS).contains(&(seen.repeats as usize)), "{seen:?}");
        assert!(calls > seen.repeats, "{calls}");
    }
}
