//! Estimators that are not etendue's own: somebody else's points in the unit square, or somebody else's whole estimator.
//!
//! Both are small traits without a word of any random-number crate: randomness comes as [`Draws`]. What they give is
//! checked number by number; the first that is none, or lies outside of the square, is kept as a [`GuestFault`].

use std::sync::Mutex;

use super::between::VisibilityMaps;
use super::emitter::{Emitter, Shading, add_lanes, emitters};
use super::{Estimator, Job, Scratch};
use crate::configuration::{Configuration, MeasurementPoint};
use crate::errors::errors;
use crate::number::Machine;
use crate::sampling::{BLOCK, Draws, LANES, Squares, StreamKey, SurfaceBlock};
use crate::scene::Surroundings;

/// Keys the streams of guests apart from those of etendue's own strategies.
const GUEST: u64 = u64::from_le_bytes(*b"a guest ");

/// A point set in the unit square, which etendue puts on the sources by area.
///
/// Also any closure `|draws: &mut Draws, points: &mut [[f64; 2]]|`.
///
/// ```
/// use etendue::{Case, Draws, PointSampler, judge};
///
/// /// One point in each of N strips, jittered in it.
/// struct Strips;
///
/// impl PointSampler for Strips {
///     fn points(&self, draws: &mut Draws, points: &mut [[f64; 2]]) {
///         let n = points.len() as f64;
///         for (k, point) in points.iter_mut().enumerate() {
///             *point = [(k as f64 + draws.unit()) / n, draws.unit()];
///         }
///     }
/// }
///
/// let case = Case::shipped("penumbra/eclipse")?;
/// let judgement = judge(&case).quick().samples(&[16]).points("strips", &Strips);
/// judgement.assert_passes();
/// // What the pass says: it would have seen a bias of this size in the mean over the points (relative).
/// let seen = judgement.judged().and_then(|judged| judged.smallest_bias_mean);
/// assert!(seen.is_some_and(|bias| bias < 0.05));
/// # Ok::<(), etendue::case::SelectError>(())
/// ```
pub trait PointSampler: Sync {
    /// Puts the points of one estimate, fresh ones each time.
    ///
    /// - `draws`: all randomness there is: the same stream must give the same points
    /// - `points`: as many as the estimate has; each coordinate in [0, 1). Over all streams, the points together must be
    ///   uniform: a set that is always the same is an estimator without noise, and its error is all bias
    fn points(&self, draws: &mut Draws, points: &mut [[f64; 2]]);
}

impl<F: Fn(&mut Draws, &mut [[f64; 2]]) + Sync> PointSampler for F {
    fn points(&self, draws: &mut Draws, points: &mut [[f64; 2]]) {
        self(draws, points);
    }
}

/// A whole estimator of direct irradiance.
///
/// Also any closure `|room: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws| -> f64`.
///
/// ```
/// use etendue::configuration::MeasurementPoint;
/// use etendue::{Case, Configuration, Draws, Verdict, judge};
///
/// /// A disk of radius 0.5 m at 2 m that faces down, 1 W/m², over a level floor: E, W/m².
/// fn disk(_: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws, r: fn(f64) -> f64) -> f64 {
///     let mut sum = 0.0;
///     for _ in 0..samples {
///         let (radius, turn) = (0.5 * r(draws.unit()), std::f64::consts::TAU * draws.unit());
///         let (dx, dy) = (radius * turn.cos() - point.position().x, radius * turn.sin() - point.position().y);
///         sum += 4.0 / (dx * dx + dy * dy + 4.0).powi(2);
///     }
///     0.25 * sum / samples as f64 // A M / π, and the mean of cosθᵢ cosθₛ / d²
/// }
///
/// let case = Case::shipped("direct/disk-over-plane")?;
/// let judge = || judge(&case).quick().samples(&[4]);
/// let uniform = |room: &_, point: &_, n, draws: &mut _| disk(room, point, n, draws, f64::sqrt);
/// judge().estimator("r = R √u", &uniform).assert_passes();
/// // Points that crowd in the middle are 1 % off in the mean.
/// let crowded = |room: &_, point: &_, n, draws: &mut _| disk(room, point, n, draws, |u| u);
/// assert_eq!(judge().estimator("r = R u", &crowded).verdict(), Verdict::Fail);
/// # Ok::<(), etendue::case::SelectError>(())
/// ```
pub trait IrradianceEstimator: Sync {
    /// One estimate, W/m²: of the light that comes straight from the sources.
    ///
    /// - `room`: what stands in it; the same for all estimates of a verdict
    /// - `samples`: how many to take, N ≥ 1; what a sample is is the estimator's affair
    /// - `draws`: all randomness there is: the same stream must give the same estimate
    fn irradiance(&self, room: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws) -> f64;
}

impl<F: Fn(&Configuration, &MeasurementPoint, u64, &mut Draws) -> f64 + Sync> IrradianceEstimator for F {
    fn irradiance(&self, room: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws) -> f64 {
        self(room, point, samples, draws)
    }
}

errors! {
    /// What a guest gave that cannot be judged.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum GuestFault {
        /// An estimate that is no number.
        #[error(
            "gave {value} as the irradiance at point {point} (N = {samples}, replicate {replicate}); a finite number is accepted"
        )]
        NotFinite { point: usize, samples: u64, replicate: u64, value: f64 },
        /// A point beside the unit square.
        #[error("gave ({u}, {v}) as point {index} of {samples} (counted from 0); both coordinates lie in [0, 1)")]
        OutsideSquare { index: usize, samples: u64, u: f64, v: f64 },
    }
}

/// Samples, replicate and point of an estimate.
type Place = (u64, u64, usize);

/// The fault that stands first, whatever thread found it.
#[derive(Debug, Default)]
struct FirstFault(Mutex<Option<(Place, GuestFault)>>);

impl FirstFault {
    fn keep(&self, place: Place, fault: GuestFault) {
        let mut kept = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if kept.as_ref().is_none_or(|(first, _)| place < *first) {
            *kept = Some((place, fault));
        }
    }

    fn get(&self) -> Option<GuestFault> {
        let kept = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        kept.as_ref().map(|(_, fault)| fault.clone())
    }
}

/// An estimator that somebody brought, with what it gave that is no estimate.
pub trait Guest: Estimator {
    /// The first such, in the order of samples, replicates and points.
    fn fault(&self) -> Option<GuestFault>;

    /// Whether the points of one replicate share their randomness.
    fn shares_points(&self) -> bool {
        false
    }
}

/// The stream of one estimate; `point` counted from 0.
fn key(job: &Job, replicate: u64, point: usize) -> StreamKey {
    job.cell.with(GUEST).with(replicate).with(point as u64 + 1)
}

/// Somebody's whole estimator, asked point by point.
pub struct GuestEstimator<'a> {
    room: &'a Configuration,
    guest: &'a dyn IrradianceEstimator,
    fault: FirstFault,
}

impl<'a> GuestEstimator<'a> {
    pub fn new(room: &'a Configuration, guest: &'a dyn IrradianceEstimator) -> GuestEstimator<'a> {
        GuestEstimator { room, guest, fault: FirstFault::default() }
    }
}

impl Guest for GuestEstimator<'_> {
    fn fault(&self) -> Option<GuestFault> {
        self.fault.get()
    }
}

impl Estimator for GuestEstimator<'_> {
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        self.room.sources().len() as u64 * samples
    }

    fn estimate(&self, job: &Job, _: &mut Scratch, estimates: &mut [f64]) {
        let (samples, replicates) = (job.samples, (job.replicates.end - job.replicates.start) as usize);
        for (point, row) in estimates.chunks_exact_mut(replicates.max(1)).enumerate() {
            for (replicate, estimate) in job.replicates.clone().zip(row) {
                let mut draws = Draws::of(key(job, replicate, point));
                let value = self.guest.irradiance(self.room, &job.points[point], samples, &mut draws);
                if !value.is_finite() {
                    let fault = GuestFault::NotFinite { point, samples, replicate, value };
                    self.fault.keep((samples, replicate, point), fault);
                }
                *estimate = if value.is_finite() { value } else { 0.0 };
            }
        }
    }
}

/// Somebody's points, put on the sources by area.
pub struct GuestPoints<'a> {
    emitters: Vec<Emitter>,
    points: Supply<'a>,
    fault: FirstFault,
}

/// Where the points of an estimate come from.
enum Supply<'a> {
    /// Fresh for each source, point and replicate.
    Sampler(&'a dyn PointSampler),
    /// Replicate r uses set r, at all points and on all sources.
    Sets(&'a [Vec<[f64; 2]>]),
}

impl<'a> GuestPoints<'a> {
    /// Points of a sampler, fresh for each shading point and source.
    pub fn of_sampler(room: &Configuration, sampler: &'a dyn PointSampler) -> GuestPoints<'a> {
        GuestPoints::new(room, Supply::Sampler(sampler))
    }

    /// - `sets`: one for each replicate, shared by all shading points and sources of it; as many points in each as the
    ///   estimate has samples
    pub fn of_sets(room: &Configuration, sets: &'a [Vec<[f64; 2]>]) -> GuestPoints<'a> {
        GuestPoints::new(room, Supply::Sets(sets))
    }

    fn new(room: &Configuration, points: Supply<'a>) -> GuestPoints<'a> {
        GuestPoints { emitters: emitters(room, &Surroundings::new(room)), points, fault: FirstFault::default() }
    }

    fn fill(&self, job: &Job, replicate: u64, point: usize, source: usize, points: &mut [[f64; 2]]) {
        match self.points {
            Supply::Sampler(sampler) => {
                sampler.points(&mut Draws::of(key(job, replicate, point).with(source as u64)), points);
            }
            Supply::Sets(sets) => match sets.get(replicate as usize) {
                Some(set) if set.len() == points.len() => points.copy_from_slice(set),
                // The judge asks for no more replicates than there are sets.
                _ => points.fill([f64::NAN; 2]),
            },
        }
        let inside = |x: f64| (0.0..1.0).contains(&x);
        if let Some(index) = points.iter().position(|[u, v]| !(inside(*u) && inside(*v))) {
            let [u, v] = points[index];
            let fault = GuestFault::OutsideSquare { index, samples: job.samples, u, v };
            self.fault.keep((job.samples, replicate, point), fault);
            points.fill([0.5; 2]);
        }
    }
}

impl Guest for GuestPoints<'_> {
    fn fault(&self) -> Option<GuestFault> {
        self.fault.get()
    }

    fn shares_points(&self) -> bool {
        matches!(self.points, Supply::Sets(_))
    }
}

impl Estimator for GuestPoints<'_> {
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        self.emitters.len() as u64 * samples
    }

    fn estimate(&self, job: &Job, _: &mut Scratch, estimates: &mut [f64]) {
        estimates.fill(0.0);
        let replicates = (job.replicates.end - job.replicates.start) as usize;
        let machine = Machine::new();
        // A set comes whole, whatever it takes; blocks keep the rest small.
        let mut points = vec![[0.0; 2]; job.samples as usize];
        let (mut squares, mut places, mut shading) =
            (Squares::default(), SurfaceBlock::default(), Shading::default());
        let rays = job.samples * replicates as u64;
        for (p, row) in estimates.chunks_exact_mut(replicates.max(1)).enumerate() {
            let from = job.points[p].position();
            let known = self.emitters.iter().map(|emitter| emitter.between.visibilities(machine, from, rays));
            let known: Vec<VisibilityMaps> = known.collect();
            for (replicate, estimate) in job.replicates.clone().zip(row) {
                for (source, (emitter, visibilities)) in self.emitters.iter().zip(&known).enumerate() {
                    self.fill(job, replicate, p, source, &mut points);
                    let mut sum = [0.0; LANES];
                    for block in points.chunks(BLOCK) {
                        let coordinates = squares.u.as_flattened_mut().iter_mut().zip(squares.v.as_flattened_mut());
                        for ((u, v), point) in coordinates.zip(block) {
                            (*u, *v) = (point[0], point[1]);
                        }
                        emitter.place(machine, &squares, block.len(), &mut places);
                        emitter.illuminate(machine, &job.points[p], &places, visibilities, block.len(), &mut shading);
                        emitter.weigh(&places, block.len(), &mut shading);
                        for k in 0..block.len() {
                            sum[k % LANES] += shading.contribution(k / LANES, k % LANES);
                        }
                    }
                    *estimate += emitter.strength() * add_lanes(&sum) / job.samples as f64;
                }
            }
        }
    }
}

#[cfg(feature = "studies")]
#[cfg(test)]
mod tests {
    use super::super::AreaEstimator;
    use super::*;
    use crate::case::Case;
    use crate::sampling::{Lanes, Pattern, Strategy};

    fn room() -> Configuration {
        // One source: the inner loop draws for each source anew, a set serves them all.
        Case::shipped("penumbra/eclipse").unwrap().configuration
    }

    #[test]
    fn the_same_points_give_the_estimates_of_the_inner_loop() {
        let room = room();
        for n in [1_u64, 5, 16, 200] {
            // Sets as `correlated` draws them: one stream for each replicate, point 0, source 0.
            let cell = StreamKey::root(3);
            let sets: Vec<Vec<[f64; 2]>> = (0..20)
                .map(|replicate| {
                    let key = cell.with(replicate).with(0).with(0);
                    let mut pattern = Pattern::new(Strategy::Correlated, n, Lanes::new(key, LANES.min(n as usize)));
                    let (mut squares, mut set) = (Squares::default(), Vec::new());
                    while (set.len() as u64) < n {
                        let len = BLOCK.min(n as usize - set.len());
                        pattern.fill(&mut squares, len);
                        let (u, v) = (squares.u.as_flattened(), squares.v.as_flattened());
                        set.extend((0..len).map(|i| [u[i], v[i]]));
                    }
                    set
                })
                .collect();
            let points = room.points();
            let job = Job { strategy: Strategy::Correlated, samples: n, cell, replicates: 0..20, points };
            let [mut own, mut guest] = [(); 2].map(|()| vec![0.0; points.len() * 20]);
            AreaEstimator::new(&room).estimate(&job, &mut Scratch::default(), &mut own);
            let estimator = GuestPoints::of_sets(&room, &sets);
            estimator.estimate(&job, &mut Scratch::default(), &mut guest);
            assert_eq!(own, guest, "N = {n}");
            assert_eq!(estimator.fault(), None);
        }
    }

    #[test]
    fn what_is_no_point_and_no_estimate_is_told_and_the_first_of_them() {
        let room = room();
        let points = room.points();
        let cell = StreamKey::root(1);
        let job = Job { strategy: Strategy::Random, samples: 3, cell, replicates: 4..9, points };
        let mut estimates = vec![f64::NAN; points.len() * 5];
        let outside = |_: &mut Draws, points: &mut [[f64; 2]]| points.fill([0.5, 1.0]);
        let estimator = GuestPoints::of_sampler(&room, &outside);
        estimator.estimate(&job, &mut Scratch::default(), &mut estimates);
        let expected = GuestFault::OutsideSquare { index: 0, samples: 3, u: 0.5, v: 1.0 };
        assert_eq!(estimator.fault(), Some(expected));
        assert!(estimates.iter().all(|estimate| estimate.is_finite()));
        let infinite = |_: &Configuration, point: &MeasurementPoint, _: u64, _: &mut Draws| {
            if *point == points[1] { f64::INFINITY } else { 1.0 }
        };
        let estimator = GuestEstimator::new(&room, &infinite);
        estimator.estimate(&job, &mut Scratch::default(), &mut estimates);
        let expected = GuestFault::NotFinite { point: 1, samples: 3, replicate: 4, value: f64::INFINITY };
        assert_eq!(estimator.fault(), Some(expected));
    }
}
