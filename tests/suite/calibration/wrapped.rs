//! Right estimates that something happens to on their way.

use etendue::estimator::{Estimator, Job, Scratch};
use etendue::sampling::Stream;
use rand::RngExt;

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Everything times this.
    Scaled(f64),
    /// One point times this.
    OnePoint(usize, f64),
    /// This much more at the first point, W/m², and less at the last: the mean over the points stays.
    Moved(f64),
    /// Stored as the nearest lower of 255 steps up to this white, W/m².
    EightBits(f64),
    /// Nothing above this leaves, W/m².
    Clamped(f64),
    /// One estimate in a thousand is no number.
    NotANumber,
    /// This share of the estimates is lost, and the rest not made up for.
    Lost(f64),
    /// Mixed with its neighbours' in the list, ¼ ½ ¼.
    Blurred,
    /// Each point has the next one's.
    OffByOne,
    /// Unbiased noise on top: the variance is this many times what it was.
    Noisier(f64),
    /// Mixed with a second estimate: the variance is this part of what it was, ½ to 1.
    Quieter(f64),
}

pub struct Wrapped {
    pub inner: Box<dyn Estimator>,
    pub change: Change,
}

/// Far beyond the replicates of any run: streams that nobody else uses.
const ELSEWHERE: u64 = 1 << 40;

impl Estimator for Wrapped {
    fn rays_per_estimate(&self, samples: u64) -> u64 {
        self.inner.rays_per_estimate(samples)
    }

    fn estimate(&self, job: &Job, scratch: &mut Scratch, estimates: &mut [f64]) {
        self.inner.estimate(job, scratch, estimates);
        let n_replicates = (job.replicates.end - job.replicates.start) as usize;
        let n_points = job.points.len();
        let mut more = |times: u64| {
            let away = times * ELSEWHERE;
            let replicates = job.replicates.start + away..job.replicates.end + away;
            let mut others = vec![0.0; estimates.len()];
            self.inner.estimate(&Job { replicates, ..job.clone() }, scratch, &mut others);
            others
        };
        let (first, second) = match self.change {
            Change::Noisier(_) => (more(1), more(2)),
            Change::Quieter(_) => (more(1), Vec::new()),
            _ => (Vec::new(), Vec::new()),
        };
        let before = estimates.to_vec();
        for p in 0..n_points {
            for r in 0..n_replicates {
                let at = p * n_replicates + r;
                let of = |p: usize| before[p.min(n_points - 1) * n_replicates + r];
                let luck = || {
                    let replicate = job.replicates.start + r as u64;
                    Stream::new(job.cell.with(replicate).with(p as u64).with(77)).random::<f64>()
                };
                let x = before[at];
                estimates[at] = match self.change {
                    Change::Scaled(factor) => factor * x,
                    Change::OnePoint(point, factor) if point == p => factor * x,
                    Change::OnePoint(..) => x,
                    Change::Moved(by) if p == 0 => x + by,
                    Change::Moved(by) if p == n_points - 1 => x - by,
                    Change::Moved(_) => x,
                    Change::EightBits(white) => (x / white * 255.0).floor() / 255.0 * white,
                    Change::Clamped(most) => x.min(most),
                    Change::NotANumber if luck() < 1e-3 => f64::NAN,
                    Change::NotANumber => x,
                    Change::Lost(share) if luck() < share => 0.0,
                    Change::Lost(_) => x,
                    Change::Blurred => 0.25 * of(p.saturating_sub(1)) + 0.5 * x + 0.25 * of(p + 1),
                    Change::OffByOne => of(p + 1),
                    Change::Noisier(factor) => x + (0.5 * (factor - 1.0)).sqrt() * (first[at] - second[at]),
                    Change::Quieter(factor) => {
                        // a² + (1 − a)² = factor.
                        let a = 0.5 * (1.0 + (2.0 * factor - 1.0).sqrt());
                        a * x + (1.0 - a) * first[at]
                    }
                };
            }
        }
    }
}
