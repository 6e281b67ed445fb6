//! The average over one estimate's draws, block by block.

use super::Job;
use super::emitter::add_lanes;
use crate::sampling::{BLOCK, LANES, Lanes, Pattern, Row, Squares, StreamKey};

/// The source index that keys the directions of the hemisphere, which belong to no source.
const HEMISPHERE: u64 = u64::MAX;

/// The stream of one estimate's draws for one source; `point` counted from 0.
#[inline(always)]
pub(super) fn source_key(job: &Job, replicate: u64, point: usize, source: usize) -> StreamKey {
    job.cell.with(replicate).with(point as u64 + 1).with(source as u64)
}

/// The stream of one estimate's directions of the hemisphere.
#[inline(always)]
pub(super) fn hemisphere_key(job: &Job, replicate: u64, point: usize) -> StreamKey {
    job.cell.with(replicate).with(point as u64 + 1).with(HEMISPHERE)
}

/// The mean of what N points of the unit square bring.
///
/// - `bring`: sets what the first so many points of a block bring; anything beyond them is ignored
#[inline(always)]
pub(super) fn mean(
    job: &Job,
    key: StreamKey,
    squares: &mut Squares,
    mut bring: impl FnMut(&Squares, usize, &mut Row),
) -> f64 {
    let lanes = Lanes::new(key, job.samples.min(LANES as u64) as usize);
    let mut pattern = Pattern::new(job.strategy, job.samples, lanes);
    let mut brought: Row = [[0.0; LANES]; BLOCK / LANES];
    let mut sum = [0.0; LANES];
    let mut left = job.samples;
    while left > 0 {
        let len = left.min(BLOCK as u64) as usize;
        pattern.fill(squares, len);
        bring(squares, len, &mut brought);
        let (whole, rest) = (len / LANES, len % LANES);
        for group in &brought[..whole] {
            for (sum, value) in sum.iter_mut().zip(group) {
                *sum += value;
            }
        }
        if rest > 0 {
            for (sum, value) in sum.iter_mut().zip(&brought[whole][..rest]) {
                *sum += value;
            }
        }
        left -= len as u64;
    }
    add_lanes(&sum) / job.samples as f64
}
