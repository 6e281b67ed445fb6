//! The spread of what samples bring, predicted: moments of estimates from integrals over the visible source.
//!
//! With X what one sample brings (for places uniform by area A M cosθᵢ cosθₛ Vis/(π r²)), the mean of N independent samples
//! has variance E (X − E X)²/N, and the mean of one sample in each of N strata of equal area
//! (1/N²) Σₖ Eₖ (X − Eₖ X)², Eₖ the mean over stratum k. Moments are integrals over the unit square that places are drawn
//! from, cut into cells that are wholly seen, wholly hidden, or (on a shadow's edge) too small to matter; which of these a
//! cell is follows from its distance to the shadow's outline, which the exact side knows.
//!
//! - error: variances below [`RELATIVE_ERROR`] of themselves, those of strata likewise while strata are larger than
//!   1/4096 of the source's width; third and fourth moments, which only plan and bound, below ten times that
//! - second route: `Oracle::by_quadrature_with`, of the sources times their own kernel (tests)

mod cells;
mod chart;
mod field;
mod grid;
mod moments;
mod shared;
#[cfg(test)]
mod tests;

pub(super) use chart::Chart;
pub use field::{Contribution, Landing};
pub use moments::SampleMoments;
pub use shared::Shared;

use cells::{Cell, Cells};
use field::Field;

use super::exact::{BodyAt, Oracle};
use super::textured::ROUGH;
use crate::configuration::MeasurementPoint;

/// Relative error, at most, of predicted variances.
pub const RELATIVE_ERROR: f64 = 1e-3;

/// Spread of an estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct Spread {
    /// W²/m⁴.
    pub variance: f64,
    /// Fourth cumulant, E (X − E X)⁴ − 3 variance², W⁴/m⁸.
    pub fourth_cumulant: f64,
}

impl Spread {
    /// Fourth central moment, W⁴/m⁸.
    pub fn fourth_moment(&self) -> f64 {
        self.fourth_cumulant + 3.0 * self.variance * self.variance
    }

    /// Fourth moment over the variance squared; 1, the least there is, of what never varies.
    pub fn kurtosis(&self) -> f64 {
        let square = self.variance * self.variance;
        if square > 0.0 { (self.fourth_moment() / square).max(1.0) } else { 1.0 }
    }

    /// The sum of independent quantities.
    pub fn plus(self, other: Spread) -> Spread {
        Spread {
            variance: self.variance + other.variance,
            fourth_cumulant: self.fourth_cumulant + other.fourth_cumulant,
        }
    }

    /// The quantity times a constant.
    pub fn scaled(self, factor: f64) -> Spread {
        let square = factor * factor;
        Spread { variance: square * self.variance, fourth_cumulant: square * square * self.fourth_cumulant }
    }

    /// The mean of n independent ones.
    pub fn mean_of(self, n: f64) -> Spread {
        Spread { variance: self.variance / n, fourth_cumulant: self.fourth_cumulant / (n * n * n) }
    }
}

impl Oracle {
    /// Moments of what one sample on a source brings to a point.
    ///
    /// - `source`: its index in the configuration
    /// - `contribution`: of a sample that lands in a place and is not blocked, and its density there
    /// - `None` where an occluder may reach into a sphere source, or is too finely divided (some thousand edges)
    pub fn sample_moments(
        &self,
        source: usize,
        point: &MeasurementPoint,
        contribution: impl Fn(&Landing) -> Contribution,
    ) -> Option<SampleMoments> {
        let field = Field::new(self, source, point)?;
        let due = self.due(source, point);
        if field.is_dark() || due == 0.0 {
            return Some(SampleMoments::SHADOW);
        }
        EDGE_LEVELS.into_iter().find_map(|edge_level| {
            // The mean by area comes along, as a check: it is known.
            let contributions = |landing: &Landing| [Contribution::by_area(landing), contribution(landing)];
            let cells = Cells { field: &field, contributions, finest: 0, edge_level };
            let [by_area, moments] = cells.moments(Cell::WHOLE, 0, &mut |_, _, _| {});
            agrees(by_area.first_moment(), due).then_some(moments)
        })
    }

    /// Moments of what a direction brings that is drawn by the cosine and must find the sources by itself: M of the source
    /// that it meets (where it meets it), with the source's form factor as its probability.
    pub fn cosine_moments(&self, point: &MeasurementPoint) -> Option<SampleMoments> {
        let of_source = |index: usize| {
            let source = &self.sources[index];
            if source.texture.is_some() {
                return self.sample_moments(index, point, Contribution::by_cosine);
            }
            let factor = self.of_body(BodyAt::Source(index), point).visible.value;
            Some(SampleMoments::point(source.exitance, factor))
        };
        let parts: Option<Vec<SampleMoments>> = (0..self.sources.len()).map(of_source).collect();
        Some(SampleMoments::either(&parts?))
    }

    /// The irradiance of one source at a point, W/m².
    fn due(&self, source: usize, point: &MeasurementPoint) -> f64 {
        self.light(source, point, ROUGH).value
    }

    /// Moments of what one sample by area on a source brings to a point.
    pub fn area_moments(&self, source: usize, point: &MeasurementPoint) -> Option<SampleMoments> {
        let field = Field::new(self, source, point)?;
        let due = self.due(source, point);
        if field.is_dark() || due == 0.0 {
            return Some(SampleMoments::SHADOW);
        }
        EDGE_LEVELS.into_iter().find_map(|edge_level| {
            let cells = Cells { field: &field, contributions: by_area, finest: 0, edge_level };
            let [moments] = cells.moments(Cell::WHOLE, 0, &mut |_, _, _| {});
            agrees(moments.first_moment(), due).then_some(moments)
        })
    }

    /// Spread of the estimate with one sample, uniform by area, in each of the strata of every source.
    ///
    /// - `counts`: numbers N of strata to answer for
    /// - `strata`: the strata of a count that is no power of 4, as `[u₀, u₁, v₀, v₁]`, all of area 1/N
    /// - returns one spread for each count; `None` as for `sample_moments`
    pub fn strata_spreads<I: IntoIterator<Item = [f64; 4]>>(
        &self,
        point: &MeasurementPoint,
        counts: &[u64],
        strata: &impl Fn(u64) -> I,
    ) -> Option<Vec<Spread>> {
        let mut spreads = vec![Spread::default(); counts.len()];
        for source in 0..self.sources.len() {
            let field = Field::new(self, source, point)?;
            let due = self.due(source, point);
            if field.is_dark() || due == 0.0 {
                continue;
            }
            let of_source =
                EDGE_LEVELS.into_iter().find_map(|level| strata_of(&field, counts, strata, level, due))?;
            for (spread, part) in spreads.iter_mut().zip(of_source) {
                *spread = spread.plus(part);
            }
        }
        Some(spreads)
    }
}

/// The same for one source; `None` where cells on an edge were too coarse to find the irradiance that is due.
fn strata_of<I: IntoIterator<Item = [f64; 4]>>(
    field: &Field,
    counts: &[u64],
    strata: &impl Fn(u64) -> I,
    edge_level: u32,
    due: f64,
) -> Option<Vec<Spread>> {
    let mut spreads = vec![Spread::default(); counts.len()];
    // Powers of 4 are levels of one and the same division.
    let level_of =
        |n: u64| (n.is_power_of_two() && n.trailing_zeros().is_multiple_of(2)).then(|| n.trailing_zeros() / 2);
    if let Some(finest) = counts.iter().filter_map(|n| level_of(*n)).max() {
        let cells = Cells { field, contributions: by_area, finest, edge_level };
        let [whole] = cells.moments(Cell::WHOLE, 0, &mut |level, area, [moments]| {
            for (spread, n) in spreads.iter_mut().zip(counts) {
                if level_of(*n) == Some(level) {
                    *spread = spread.plus(of_stratum(*moments, area, *n));
                }
            }
        });
        if !agrees(whole.first_moment(), due) {
            return None;
        }
    }
    for (spread, n) in spreads.iter_mut().zip(counts) {
        if level_of(*n).is_some() {
            continue;
        }
        let level = (*n as f64).log(4.0).floor() as u32;
        let cells = Cells { field, contributions: by_area, finest: level, edge_level };
        let mut mean = 0.0;
        for [u0, u1, v0, v1] in strata(*n) {
            let cell = Cell { u: [u0, u1], v: [v0, v1] };
            let [moments] = cells.moments(cell, level, &mut |_, _, _| {});
            mean += moments.first_moment();
            *spread = spread.plus(of_stratum(moments, cell.area(), *n));
        }
        if !agrees(mean, due) {
            return None;
        }
    }
    Some(spreads)
}

/// The one integrand of what is drawn by area alone.
fn by_area(landing: &Landing) -> [Contribution; 1] {
    [Contribution::by_area(landing)]
}

/// Whether a mean found on cells is the one that is due.
fn agrees(found: f64, due: f64) -> bool {
    (found - due).abs() <= 0.5 * RELATIVE_ERROR * due
}

/// Halvings of the unit square down to which cells on an edge are cut: the next where the mean that comes along is not yet
/// the one that is known.
const EDGE_LEVELS: [u32; 3] = [9, 11, 13];

/// One stratum's part in the mean over N strata.
fn of_stratum(moments: SampleMoments, area: f64, n: u64) -> Spread {
    moments.spread_within(area).scaled(1.0 / n as f64)
}
