//! What an answer costs: time of an estimate, how it grows with N, time to a given error. Numbers of this machine and hour.

use super::outcome::{CaseOutcome, Cell, StrategyOutcome};
use crate::oracle::Truth;
use crate::statistics::Line;
use crate::statistics::slope::Noise;

/// Share of the unoccluded light from which on a point counts where times to an error are averaged: relative errors of
/// darker points say little.
const WELL_LIT: f64 = 0.1;

/// How long it takes to know the irradiance to a given error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeTo {
    /// Of one thread.
    pub seconds: f64,
    /// Estimates at the largest N that take part, on average; below 1 a single one is finer than asked.
    pub estimates: f64,
}

/// One mesh: building its hierarchy, and shadow rays with and without it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HierarchyCost {
    pub triangles: u64,
    pub build_seconds: f64,
    /// Seconds of one shadow ray.
    pub ray_seconds: f64,
    /// The same where every triangle is tested.
    pub brute_force_seconds: f64,
    /// Of a shadow ray in a block of rays, from points that share their points on the sources: with the shadow cache, and
    /// without.
    pub block_seconds: [f64; 2],
}

impl Cell {
    /// Processor seconds of one estimate at one point; `None` where no time was kept.
    pub fn seconds_per_estimate(&self) -> Option<f64> {
        let estimates = self.replicates as f64 * self.points.len() as f64;
        (self.seconds > 0.0 && estimates > 0.0).then(|| self.seconds / estimates)
    }
}

impl StrategyOutcome {
    /// 1 / (mean variance × time) of one estimate at the largest N, m⁴/(W² s). `None` where nothing varies.
    pub fn efficiency(&self) -> Option<f64> {
        self.timings.iter().find_map(|timing| timing.efficiency)
    }

    /// Time until the relative standard error is `error`, by repeating the estimate at the largest N: with variance v of
    /// one estimate and its time t, v/(E · error)² repeats; the median over the points that a tenth or more of the light
    /// reaches.
    ///
    /// - `truths`: one for each point
    /// - `error`: > 0, relative to the exact irradiance E
    /// - `None` where no point is lit so well, or no time was kept
    pub fn time_to(&self, truths: &[Truth], error: f64) -> Option<TimeTo> {
        let cell = self.cells.last()?;
        let seconds = cell.seconds_per_estimate()?;
        let lit = truths.iter().zip(&cell.points).filter_map(|(truth, point)| {
            let exact = truth.irradiance.watts_per_square_metre();
            let open = truth.unoccluded_irradiance.watts_per_square_metre();
            (exact > 0.0 && exact >= WELL_LIT * open).then(|| point.variance / (exact * error).powi(2))
        });
        let estimates = median(lit.collect())?;
        Some(TimeTo { seconds: seconds * estimates.max(1.0), estimates })
    }

    /// (N, seconds of one estimate at one point), ascending in N.
    pub fn costs(&self) -> Vec<(f64, f64)> {
        self.cells.iter().filter_map(|cell| Some((cell.samples as f64, cell.seconds_per_estimate()?))).collect()
    }

    /// p of the line through all sample counts, seconds ∝ Nᵖ.
    pub fn growth(&self) -> Option<f64> {
        exponent(&self.costs())
    }

    /// The same between the two largest sample counts: what is left of it once starting an estimate costs little.
    pub fn last_growth(&self) -> Option<f64> {
        let costs = self.costs();
        exponent(&costs[costs.len().checked_sub(2)?..])
    }
}

impl CaseOutcome {
    /// Seconds of all its stages.
    pub fn seconds(&self) -> f64 {
        self.stages().map(|(_, seconds)| seconds).sum()
    }

    /// Every stage with its seconds: those of no strategy, of each strategy, of the light, of paths.
    pub fn stages(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let of_strategies = self.strategies.iter().flat_map(|strategy| &strategy.timings);
        let of_light = self.light.iter().map(|light| &light.timing);
        let of_paths = self.paths.iter().flat_map(|paths| &paths.timings);
        let all = self.timings.iter().chain(of_strategies).chain(of_light).chain(of_paths);
        all.map(|timing| (timing.stage, timing.seconds))
    }

    /// One entry for each mesh.
    pub fn hierarchies(&self) -> Vec<HierarchyCost> {
        let of = |stage: &'static str| self.timings.iter().filter(move |timing| timing.stage == stage);
        let each = |timing: &super::Timing| timing.seconds / timing.rays.max(1) as f64;
        let rays = of("hierarchy_rays").zip(of("brute_force_rays"));
        let blocks = of("rays_with_cache").zip(of("rays_without_cache"));
        of("hierarchy_build")
            .zip(rays.zip(blocks))
            .map(|(build, ((fast, slow), (with, without)))| HierarchyCost {
                triangles: build.rays,
                build_seconds: build.seconds,
                ray_seconds: each(fast),
                brute_force_seconds: each(slow),
                block_seconds: [each(with), each(without)],
            })
            .collect()
    }
}

/// p of y ∝ xᵖ by least squares of the logarithms. `None` below two pairs, or where something is not above zero.
fn exponent(pairs: &[(f64, f64)]) -> Option<f64> {
    let (x, y): (Vec<f64>, Vec<f64>) = pairs.iter().map(|(x, y)| (x.ln(), y.ln())).unzip();
    Line::through(&x, &y, Noise::Equal).ok().map(|line| line.slope)
}

/// The middle value, or the mean of the two in the middle; `None` of nothing, or where something is no number.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    if values.is_empty() || values.iter().any(|value| value.is_nan()) {
        return None;
    }
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    Some(if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_where_half_are_below() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 100.0]), Some(3.0));
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![1.0, f64::NAN]), None);
    }

    #[test]
    fn exponents_come_back() {
        for p in [-1.5, 0.0, 1.0, 2.0] {
            let pairs = [1.0, 4.0, 64.0, 1024.0].map(|x: f64| (x, 3e-7 * x.powf(p)));
            assert!((exponent(&pairs).unwrap() - p).abs() < 1e-13);
        }
        assert_eq!(exponent(&[(4.0, 1.0)]), None);
        assert_eq!(exponent(&[(4.0, 1.0), (8.0, 0.0)]), None);
    }
}
