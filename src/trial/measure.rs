//! One cell of a study: all points, one strategy, one sample count, many replicates.

use std::f64::consts::PI;
use std::ops::Range;
use std::time::Instant;

use super::desk::{Alone, Desk, Portion, Record, Stage, Within, is_whole};
use super::predict::Predictions;
use crate::case::Case;
use crate::configuration::Digest;
use crate::estimator::{Estimator, Job, Scratch};
use crate::number::{Machine, Registers, Work};
use crate::oracle::Truth;
use crate::sampling::{Purpose, Strategy, StreamKey};
use crate::statistics::PowerSums;
use crate::threads;

/// Parts that a cell's replicates are split into: units of work, and batches whose spread tells how sure a variance is.
pub(super) const BATCHES: u64 = 32;
/// Replicates whose estimates are kept whole, for correlations between points.
pub(super) const KEPT_REPLICATES: u64 = 512;
/// Points beyond which whole estimates are not kept.
const KEPT_POINTS: usize = 4096;
/// Shadow rays after which somebody is told: a millisecond, so that telling costs nothing.
const TOLD_RAYS: u64 = 1 << 16;
/// Low-order contrasts along the points, beside the mean.
const CONTRASTS: usize = 4;

/// The mean over the points, and contrasts that a bias with a zero mean cannot all escape: discrete cosines of the
/// point's place in the list.
#[derive(Clone, Debug)]
pub(super) struct Contrasts {
    /// [contrast][point]; the first is the mean.
    pub weights: Vec<Vec<f64>>,
    /// Of the exact values, W/m².
    pub exact: Vec<f64>,
}

impl Contrasts {
    pub fn new(exact: &[f64]) -> Contrasts {
        let n = exact.len();
        let weights: Vec<Vec<f64>> = (0..=CONTRASTS.min(n - 1))
            .map(|k| (0..n).map(|p| (PI * k as f64 * (p as f64 + 0.5) / n as f64).cos() / n as f64).collect())
            .collect();
        let exact = weights.iter().map(|row| row.iter().zip(exact).map(|(w, e)| w * e).sum()).collect();
        Contrasts { weights, exact }
    }
}

/// A case made ready for one strategy: exact values known, surfaces and hierarchies built.
#[derive(Clone, Copy)]
pub(super) struct Prepared<'a> {
    pub case: &'a Case,
    pub seed: u64,
    /// The configuration's.
    pub digest: Digest,
    pub truths: &'a [Truth],
    /// Exact irradiance at each point, W/m².
    pub exact: &'a [f64],
    /// The sources' light at each point, of which it may see a share, W/m².
    pub full: &'a [f64],
    /// What each point's estimates are rounded in units of, beside their own size, W/m².
    pub grazing: &'a [f64],
    pub estimator: &'a dyn Estimator,
    pub contrasts: &'a Contrasts,
    pub predictions: &'a Predictions,
}

/// What the replicates of one cell came to.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct CellSums {
    pub samples: u64,
    pub replicates: u64,
    /// One for each point, about the exact value.
    pub points: Vec<PowerSums>,
    /// One for each contrast, about its exact value.
    pub contrasts: Vec<PowerSums>,
    /// [batch][point]: mean squared deviation from the exact value within each batch, W²/m⁴.
    pub batches: Vec<Vec<f64>>,
    /// [replicate][point], row-major: estimates less exact values of the first replicates, W/m².
    pub kept: Vec<f64>,
    /// CPU seconds over all threads.
    #[cfg_attr(feature = "studies", serde(skip))]
    pub seconds: f64,
}

impl CellSums {
    /// Nothing yet of `replicates` that are to come.
    pub fn new(prepared: &Prepared, samples: u64, replicates: u64) -> CellSums {
        CellSums {
            samples,
            replicates,
            points: prepared.exact.iter().map(|e| PowerSums::about(*e)).collect(),
            contrasts: prepared.contrasts.exact.iter().map(|e| PowerSums::about(*e)).collect(),
            batches: Vec::new(),
            kept: Vec::new(),
            seconds: 0.0,
        }
    }

    /// Whether these are sums of such a cell, all replicates counted.
    #[cfg(feature = "studies")]
    pub fn fits(&self, prepared: &Prepared, [samples, replicates]: [u64; 2]) -> bool {
        let n_points = prepared.exact.len();
        let count = |sums: &[PowerSums]| sums.iter().all(|sums| sums.count() == replicates);
        [self.samples, self.replicates] == [samples, replicates]
            && [self.points.len(), self.contrasts.len()] == [n_points, prepared.contrasts.exact.len()]
            && count(&self.points)
            && count(&self.contrasts)
            && self.batches.len() as u64 == BATCHES.min(replicates)
            && self.batches.iter().all(|batch| batch.len() == n_points)
            && self.kept.is_empty()
    }

    /// One more replicate, which somebody else made: its estimates at all points, W/m².
    pub fn add(&mut self, prepared: &Prepared, estimates: &[f64]) {
        self.points.iter_mut().zip(estimates).for_each(|(sums, estimate)| sums.add(*estimate));
        for (sums, weights) in self.contrasts.iter_mut().zip(&prepared.contrasts.weights) {
            sums.add(weights.iter().zip(estimates).map(|(weight, estimate)| weight * estimate).sum());
        }
        let n_points = prepared.exact.len();
        if n_points <= KEPT_POINTS && self.kept.len() < KEPT_REPLICATES as usize * n_points {
            self.kept.extend(estimates.iter().zip(prepared.exact).map(|(estimate, exact)| estimate - exact));
        }
    }
}

/// The same of one of its parts.
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
struct PartSums {
    points: Vec<PowerSums>,
    contrasts: Vec<PowerSums>,
    kept: Vec<f64>,
}

impl PartSums {
    /// Whether these are sums of such replicates.
    fn fits(&self, prepared: &Prepared, replicates: &Range<u64>) -> bool {
        let n_points = prepared.exact.len();
        let count = |sums: &[PowerSums]| sums.iter().all(|sums| sums.count() == replicates.end - replicates.start);
        let kept = replicates.end.min(KEPT_REPLICATES).saturating_sub(replicates.start) as usize;
        [self.points.len(), self.contrasts.len()] == [n_points, prepared.contrasts.exact.len()]
            && count(&self.points)
            && count(&self.contrasts)
            && self.kept.len() == if n_points <= KEPT_POINTS { kept * n_points } else { 0 }
    }
}

/// Measures a cell to its end, and tells nobody.
pub(super) fn measure_alone(
    prepared: &Prepared,
    purpose: Purpose,
    strategy: Strategy,
    samples: u64,
    replicates: u64,
) -> CellSums {
    let Ok(sums) = measure(prepared, purpose, strategy, samples, replicates, &Alone);
    sums.expect("nobody else has a part of it")
}

/// A cell as one unit, and what is made of it: of a small one all is kept at once, of a large one part by part.
///
/// - `fits`: whether what was kept at once is such
/// - `finish`: makes of the sums what is wanted
/// - `None`: some of it is somebody else's
pub(super) fn measure_unit<D: Desk, T: Record>(
    prepared: &Prepared,
    purpose: Purpose,
    strategy: Strategy,
    [samples, replicates]: [u64; 2],
    desk: &D,
    fits: impl Fn(&T) -> bool,
    finish: impl FnOnce(CellSums) -> (T, f64),
) -> Result<Option<(T, f64)>, D::End> {
    let rays = rays_of(prepared, samples, replicates);
    if !is_whole(rays) {
        return Ok(measure(prepared, purpose, strategy, samples, replicates, desk)?.map(finish));
    }
    let part = Portion::whole(Stage::of_cell(purpose, strategy, samples));
    desk.unit(part, rays, fits, || {
        let sums = measure(prepared, purpose, strategy, samples, replicates, &Within(desk))?;
        Ok(finish(sums.expect("nobody else has a part of it")))
    })
}

/// Shadow rays of a cell.
pub(super) fn rays_of(prepared: &Prepared, samples: u64, replicates: u64) -> u64 {
    prepared.estimator.rays_per_estimate(samples) * prepared.exact.len() as u64 * replicates
}

/// Measures a cell. The result does not depend on the number of threads: parts are fixed by the replicates alone and
/// merged in order.
///
/// - `desk`: told the shadow rays of each finished portion of a part; has the parts, unless the cell is within a unit
/// - `None`: some part is somebody else's
pub(super) fn measure<D: Desk>(
    prepared: &Prepared,
    purpose: Purpose,
    strategy: Strategy,
    samples: u64,
    replicates: u64,
    desk: &D,
) -> Result<Option<CellSums>, D::End> {
    let key = StreamKey::cell(prepared.seed, prepared.digest.key(), purpose, strategy, samples);
    let stage = Stage::of_cell(purpose, strategy, samples);
    let of = BATCHES.min(replicates) as u32;
    let range = |k: u32| {
        let edge = |k: u32| (u128::from(k) * u128::from(replicates) / u128::from(of)) as u64;
        edge(k)..edge(k + 1)
    };
    let n_points = prepared.exact.len();
    let mut sums = CellSums::new(prepared, samples, replicates);
    // A wave of parts at a time, so that memory stays bounded for maps of a million points.
    let wave = (1_000_000 / n_points).clamp(2, BATCHES as usize);
    let indices: Vec<u32> = (0..of).collect();
    let rays = rays_of(prepared, samples, 1);
    let mut is_all_here = true;
    for wave in indices.chunks(wave) {
        let done = threads::map(wave, |index| {
            let range = range(*index);
            let part = Portion { stage, index: *index, of };
            let of_part = rays * (range.end - range.start);
            let fits = |part: &PartSums| part.fits(prepared, &range);
            desk.unit(part, of_part, fits, || {
                measure_part(prepared, strategy, samples, key, range.clone(), |done| desk.traced(rays * done))
            })
        });
        for part in done {
            let Some((part, seconds)) = part? else {
                is_all_here = false;
                continue;
            };
            sums.batches.push(part.points.iter().map(|s| s.mean_square_deviation().unwrap_or(0.0)).collect());
            for (total, part) in sums.points.iter_mut().zip(&part.points) {
                total.merge(part);
            }
            for (total, part) in sums.contrasts.iter_mut().zip(&part.contrasts) {
                total.merge(part);
            }
            sums.kept.extend(part.kept);
            sums.seconds += seconds;
        }
    }
    Ok(is_all_here.then_some(sums))
}

/// Seconds of some replicates of a cell on one thread, worked on as a unit of a run is. Their estimates are let go.
#[cfg(feature = "studies")]
pub(super) fn seconds_of(
    prepared: &Prepared,
    purpose: Purpose,
    strategy: Strategy,
    samples: u64,
    replicates: Range<u64>,
) -> f64 {
    let key = StreamKey::cell(prepared.seed, prepared.digest.key(), purpose, strategy, samples);
    let Ok((_, seconds)) = measure_part(prepared, strategy, samples, key, replicates, |_| Alone.traced(0));
    seconds
}

/// - `progress`: told the replicates of each finished portion
/// - returns seconds, too
fn measure_part<E>(
    prepared: &Prepared,
    strategy: Strategy,
    samples: u64,
    key: StreamKey,
    replicates: Range<u64>,
    progress: impl Fn(u64) -> Result<(), E>,
) -> Result<(PartSums, f64), E> {
    let start = Instant::now();
    let exact = prepared.exact;
    let points = prepared.case.configuration.points();
    let mut unit = PartSums {
        points: exact.iter().map(|e| PowerSums::about(*e)).collect(),
        contrasts: prepared.contrasts.exact.iter().map(|e| PowerSums::about(*e)).collect(),
        kept: Vec::new(),
    };
    let mut scratch = Scratch::default();
    let mut estimates = Vec::new();
    let mut combined = Vec::new();
    let rays = prepared.estimator.rays_per_estimate(samples) * points.len() as u64;
    let mut untold = 0;
    let step = replicates_at_once(points.len());
    let machine = Machine::new();
    // Whoever wants no more of it is heard before the first part, too: the other units of a wave are still to come then.
    progress(0)?;
    for first in replicates.clone().step_by(step as usize) {
        let part = first..(first + step).min(replicates.end);
        let count = (part.end - part.start) as usize;
        estimates.resize(points.len() * count, 0.0);
        let job = Job { strategy, samples, cell: key, replicates: part.clone(), points };
        prepared.estimator.estimate(&job, &mut scratch, &mut estimates);
        combined.clear();
        combined.resize(unit.contrasts.len() * count, 0.0);
        for (p, (sums, row)) in unit.points.iter_mut().zip(estimates.chunks_exact(count)).enumerate() {
            sums.extend(row);
            let weights = prepared.contrasts.weights.as_slice();
            machine.run(Weighing { weights, point: p, estimates: row, sums: &mut combined });
        }
        for (sums, row) in unit.contrasts.iter_mut().zip(combined.chunks_exact(count)) {
            sums.extend(row);
        }
        if points.len() <= KEPT_POINTS {
            for r in 0..count.min(KEPT_REPLICATES.saturating_sub(part.start) as usize) {
                unit.kept.extend(exact.iter().enumerate().map(|(p, exact)| estimates[p * count + r] - exact));
            }
        }
        untold += count as u64;
        if untold * rays >= TOLD_RAYS || part.end == replicates.end {
            progress(std::mem::take(&mut untold))?;
        }
    }
    Ok((unit, start.elapsed().as_secs_f64()))
}

/// Replicates estimated in one go: enough for small estimates to lie side by side, few enough for the cache. Portion of
/// the format, like the block of the sums: it fixes the order of additions.
pub(super) fn replicates_at_once(n_points: usize) -> u64 {
    (32_768 / n_points as u64).clamp(1, 256)
}

/// One point's part in Σ_p weight_p · estimate_p, for each replicate and weighting.
struct Weighing<'a> {
    /// `[weighting][point]`.
    weights: &'a [Vec<f64>],
    point: usize,
    /// One for each replicate.
    estimates: &'a [f64],
    /// `[weighting][replicate]`.
    sums: &'a mut [f64],
}

impl Work for Weighing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, _: R) {
        let Weighing { weights, point, estimates, sums } = self;
        for (weights, sums) in weights.iter().zip(sums.chunks_exact_mut(estimates.len())) {
            let weight = weights[point];
            for (sum, estimate) in sums.iter_mut().zip(estimates) {
                *sum += weight * estimate;
            }
        }
    }
}
