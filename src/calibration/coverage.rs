//! How often a printed interval holds the true value.
//!
//! The true values: of a bias, zero; of a variance, the prediction of the exact side, and where there is none the mean
//! over all the runs (whose error moves the coverage by about one part in the number of runs); of a slope, the same
//! weighted fit to the true variances; of a correlation, the prediction, for points that are drawn afresh zero, else the
//! mean over all the runs on Fisher's scale.

use crate::configuration::MeasurementPoint;
use crate::oracle::Truth;
use crate::statistics::Verdict;
use crate::statistics::interval::{Interval, normal_quantile};
use crate::statistics::proportion::{clopper_pearson, upper_limit};
use crate::statistics::slope::{Line, Noise};
use crate::trial::{CaseOutcome, Rate, RatePoint, StrategyOutcome};

/// What printed intervals claim.
const NOMINAL: f64 = 0.95;
/// What they must keep.
pub const LEAST_COVERAGE: f64 = 0.93;
/// Rays that must be expected to arrive where an interval is printed.
pub const ENOUGH_RAYS: f64 = 30.0;

/// One kind of interval, over all cases under one strategy or over all strategies in one case.
#[derive(Clone, Debug, PartialEq)]
pub struct CoverageRow {
    /// `variance` (of a point at one N), `mean_variance` (over a region's points at one N), `slope`, `correlation`,
    /// `bias` (of the mean over the points at one N), `effect` (of a verdict, all N together).
    pub interval: &'static str,
    /// `None`: all.
    pub case: Option<String>,
    /// `None`: all.
    pub strategy: Option<&'static str>,
    /// Whether [`ENOUGH_RAYS`] are expected to arrive.
    pub enough_rays: bool,
    /// Places (points or regions, sample counts, separations) that were asked, each in every run of its case and strategy.
    pub places: u64,
    /// Runs in which any of them had an interval.
    pub runs: u64,
    pub nominal: f64,
    /// Intervals that were printed, and places that had none.
    pub printed: u64,
    pub missing: u64,
    /// Of the printed, how many held the true value.
    pub covered: u64,
    /// Share covered, and its 95 % limits (Clopper and Pearson, as though the places of a run all covered or all
    /// missed: they share their rays); `None` where nothing was printed.
    pub coverage: Option<f64>,
    pub low: Option<f64>,
    pub high: Option<f64>,
    /// The lowest share at any one place, and which.
    pub worst: Option<f64>,
    pub worst_place: String,
    /// Fail: the coverage is below [`LEAST_COVERAGE`] by its upper limit, or at the worst place by its 99.9 % limit.
    /// Pass: it is above by its lower limit. `None` where too few rays arrive: nothing should be printed.
    pub verdict: Option<Verdict>,
}

/// Counts of one kind of interval in one case under one strategy.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    interval: &'static str,
    enough_rays: bool,
    case: String,
    strategy: &'static str,
    places: u64,
    runs: u64,
    printed: u64,
    missing: u64,
    covered: u64,
    /// Lowest share of any one place, how often it was printed, and its name.
    worst: Option<(f64, u64, String)>,
}

impl Tally {
    fn of(case: &str, strategy: &'static str, interval: &'static str, enough_rays: bool, places: &[&Place]) -> Tally {
        let n_runs = places.iter().map(|place| place.runs.len()).max().unwrap_or(0);
        let any = |run: &usize| places.iter().any(|place| place.runs.get(*run).is_some_and(Option::is_some));
        let mut tally = Tally {
            interval,
            enough_rays,
            case: case.to_owned(),
            strategy,
            places: places.len() as u64,
            runs: (0..n_runs).filter(any).count() as u64,
            printed: 0,
            missing: 0,
            covered: 0,
            worst: None,
        };
        for place in places {
            let printed = place.runs.iter().flatten().count() as u64;
            let covered = place.runs.iter().flatten().filter(|covered| **covered).count() as u64;
            tally.printed += printed;
            tally.covered += covered;
            tally.missing += place.runs.len() as u64 - printed;
            if printed > 0 {
                let name = format!("{case}, {strategy}, {}", place.name);
                tally.take_worse(&Some((covered as f64 / printed as f64, printed, name)));
            }
        }
        tally
    }

    fn take_worse(&mut self, other: &Option<(f64, u64, String)>) {
        if let Some((share, ..)) = other
            && self.worst.as_ref().is_none_or(|(worst, ..)| share < worst)
        {
            self.worst.clone_from(other);
        }
    }

    fn merge(&mut self, other: &Tally) {
        self.places += other.places;
        self.runs += other.runs;
        self.printed += other.printed;
        self.missing += other.missing;
        self.covered += other.covered;
        self.take_worse(&other.worst);
    }

    fn row(self, case: Option<String>, strategy: Option<&'static str>) -> CoverageRow {
        let coverage = (self.printed > 0).then(|| self.covered as f64 / self.printed as f64);
        let runs = self.runs as f64;
        let limits = coverage.and_then(|share| clopper_pearson(share * runs, runs, 0.95));
        let worst_is_too_low = self.worst.as_ref().is_some_and(|(share, printed, _)| {
            let printed = *printed as f64;
            upper_limit((share * printed).round(), printed, 0.999).is_some_and(|limit| limit < LEAST_COVERAGE)
        });
        let verdict = limits.filter(|_| self.enough_rays).map(|limits| {
            if limits.high < LEAST_COVERAGE || worst_is_too_low {
                Verdict::Fail
            } else if limits.low >= LEAST_COVERAGE {
                Verdict::Pass
            } else {
                Verdict::Undecided
            }
        });
        CoverageRow {
            interval: self.interval,
            case,
            strategy,
            enough_rays: self.enough_rays,
            places: self.places,
            runs: self.runs,
            nominal: NOMINAL,
            printed: self.printed,
            missing: self.missing,
            covered: self.covered,
            coverage,
            low: limits.map(|limits| limits.low),
            high: limits.map(|limits| limits.high),
            worst: self.worst.as_ref().map(|(share, ..)| *share),
            worst_place: self.worst.map_or(String::new(), |(.., name)| name),
            verdict,
        }
    }
}

/// For each kind of interval, enough rays first: every strategy over all cases, then every case over all strategies.
pub(super) fn rows(tallies: &[Tally]) -> Vec<CoverageRow> {
    let mut kinds: Vec<(bool, &'static str)> = Vec::new();
    for tally in tallies {
        if !kinds.contains(&(tally.enough_rays, tally.interval)) {
            kinds.push((tally.enough_rays, tally.interval));
        }
    }
    kinds.sort_by_key(|(enough, _)| !enough);
    let mut rows = Vec::new();
    for (enough, interval) in kinds {
        let of_it: Vec<&Tally> =
            tallies.iter().filter(|tally| (tally.enough_rays, tally.interval) == (enough, interval)).collect();
        rows.extend(merged(&of_it, |tally| tally.strategy).into_iter().map(|tally| {
            let strategy = tally.strategy;
            tally.row(None, Some(strategy))
        }));
        rows.extend(merged(&of_it, |tally| tally.case.as_str()).into_iter().map(|tally| {
            let case = tally.case.clone();
            tally.row(Some(case), None)
        }));
    }
    rows
}

/// Those of one name added up, names in the order of their first appearance.
fn merged<'a>(tallies: &[&'a Tally], name: impl Fn(&'a Tally) -> &'a str) -> Vec<Tally> {
    let mut names: Vec<&str> = Vec::new();
    let mut merged: Vec<Tally> = Vec::new();
    for tally in tallies {
        match names.iter().position(|known| *known == name(tally)) {
            Some(at) => merged[at].merge(tally),
            None => {
                names.push(name(tally));
                merged.push((*tally).clone());
            }
        }
    }
    merged
}

/// One interval, run after run.
struct Place {
    interval: &'static str,
    name: String,
    /// Rays expected to arrive in one run.
    rays: f64,
    /// For each run: did it cover? `None` where none was printed.
    runs: Vec<Option<bool>>,
}

/// Of one case under one strategy.
///
/// - `arriving`: share of rays that arrive at each point
/// - `outcomes`: of the same case and the same one strategy, from different seeds
pub(super) fn tallies(case: &str, arriving: &[f64], outcomes: &[CaseOutcome]) -> Vec<Tally> {
    let Some(first) = outcomes.first() else { return Vec::new() };
    let runs: Vec<&StrategyOutcome> = outcomes.iter().filter_map(|outcome| outcome.strategies.first()).collect();
    let strategy = runs.first().map_or("", |run| run.strategy.name());
    let places = Group { truths: &first.truths, points: &first.points, arriving, runs: &runs }.places();
    let mut kinds: Vec<(&'static str, bool)> = Vec::new();
    for place in &places {
        let kind = (place.interval, place.rays >= ENOUGH_RAYS);
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    let of = |(interval, enough): (&'static str, bool)| {
        let of_it: Vec<&Place> =
            places.iter().filter(|place| (place.interval, place.rays >= ENOUGH_RAYS) == (interval, enough)).collect();
        Tally::of(case, strategy, interval, enough, &of_it)
    };
    kinds.into_iter().map(of).collect()
}

/// Runs of one case under one strategy.
struct Group<'a> {
    truths: &'a [Truth],
    points: &'a [MeasurementPoint],
    arriving: &'a [f64],
    runs: &'a [&'a StrategyOutcome],
}

impl Group<'_> {
    fn places(&self) -> Vec<Place> {
        let variances = self.true_variances();
        let mut places = self.variances(&variances);
        places.extend(self.rates(&variances));
        places.extend(self.correlations());
        places.extend(self.biases());
        places
    }

    /// [cell][point], W²/m⁴.
    fn true_variances(&self) -> Vec<Vec<f64>> {
        let Some(first) = self.runs.first() else { return Vec::new() };
        let mean = |cell: usize, point: usize| {
            let found = self.runs.iter().map(|run| run.cells[cell].points[point].variance);
            found.sum::<f64>() / self.runs.len() as f64
        };
        let of = |cell: usize| {
            let points = first.cells[cell].points.iter().enumerate();
            points.map(|(p, measured)| measured.predicted_variance.unwrap_or_else(|| mean(cell, p))).collect()
        };
        (0..first.cells.len()).map(of).collect()
    }

    /// Rays expected to arrive at a point in all replicates of a cell.
    fn rays(&self, cell: usize, point: usize) -> f64 {
        let cell = &self.runs[0].cells[cell];
        self.arriving[point] * (cell.samples * cell.replicates) as f64
    }

    fn variances(&self, truth: &[Vec<f64>]) -> Vec<Place> {
        let mut places = Vec::new();
        for (cell, truth) in truth.iter().enumerate() {
            for (point, truth) in truth.iter().enumerate().filter(|(_, truth)| **truth > 0.0) {
                let covered = |run: &&StrategyOutcome| {
                    run.cells[cell].points[point].variance_interval.map(|interval| holds(interval, *truth))
                };
                places.push(Place {
                    interval: "variance",
                    name: format!("point {point}, N = {}", self.runs[0].cells[cell].samples),
                    rays: self.rays(cell, point),
                    runs: self.runs.iter().map(covered).collect(),
                });
            }
        }
        places
    }

    /// Slopes, and the mean variances that they are fitted to.
    fn rates(&self, variances: &[Vec<f64>]) -> Vec<Place> {
        let mut places = Vec::new();
        for rate in &self.runs[0].rates {
            let lit = |p: &usize| self.truths[*p].irradiance.watts_per_square_metre() > 0.0;
            let of_region = |p: &usize| rate.region.is_none_or(|region| self.truths[*p].region == region);
            let points: Vec<usize> = (0..self.points.len()).filter(lit).filter(of_region).collect();
            let region = rate.region.map_or("all points".to_owned(), |region| region.to_string());
            let mean = |cell: usize| points.iter().map(|p| variances[cell][*p]).sum::<f64>() / points.len() as f64;
            let truth: Vec<(u64, f64)> =
                self.runs[0].cells.iter().enumerate().map(|(cell, shown)| (shown.samples, mean(cell))).collect();
            let true_at = |samples: u64| truth.iter().find(|(n, _)| *n == samples).map(|(_, truth)| *truth);
            let rays = |cell: usize| points.iter().map(|p| self.rays(cell, *p)).sum::<f64>();
            let same = |run: &&StrategyOutcome| run.rates.iter().find(|r| r.region == rate.region).cloned();
            let found: Vec<Option<Rate>> = self.runs.iter().map(same).collect();
            for (cell, (samples, truth)) in truth.iter().enumerate() {
                let covered = |rate: &Option<Rate>| {
                    let point = rate.as_ref()?.points.iter().find(|point| point.samples == *samples)?;
                    Some(holds(Interval { low: point.low, high: point.high }, *truth))
                };
                places.push(Place {
                    interval: "mean_variance",
                    name: format!("{region}, N = {samples}"),
                    rays: rays(cell),
                    runs: found.iter().map(covered).collect(),
                });
            }
            places.push(Place {
                interval: "slope",
                name: region,
                rays: (0..truth.len()).map(rays).fold(f64::INFINITY, f64::min),
                runs: found
                    .iter()
                    .map(|rate| {
                        let rate = rate.as_ref()?;
                        let slope = true_slope(&rate.points, &true_at)?;
                        Some(holds(Interval { low: rate.slope_low, high: rate.slope_high }, slope))
                    })
                    .collect(),
            });
        }
        places
    }

    fn correlations(&self) -> Vec<Place> {
        let mut places = Vec::new();
        let mut asked: Vec<(u64, f64)> = Vec::new();
        for found in self.runs.iter().flat_map(|run| &run.correlations) {
            if !asked.contains(&(found.samples, found.separation)) {
                asked.push((found.samples, found.separation));
            }
        }
        let mut separations: Vec<f64> = asked.iter().map(|(_, separation)| *separation).collect();
        separations.sort_by(f64::total_cmp);
        separations.dedup();
        for (samples, separation) in asked {
            let same = |run: &&StrategyOutcome| {
                run.correlations.iter().find(|c| (c.samples, c.separation) == (samples, separation)).copied()
            };
            let found: Vec<_> = self.runs.iter().map(same).collect();
            let fisher = |r: f64| r.clamp(-1.0 + 1e-15, 1.0 - 1e-15).atanh();
            let predicted = found.iter().flatten().find_map(|found| found.predicted);
            let truth = predicted.unwrap_or_else(|| {
                let count = found.iter().flatten().count() as f64;
                if self.runs[0].strategy.shares_points() {
                    (found.iter().flatten().map(|found| fisher(found.correlation)).sum::<f64>() / count).tanh()
                } else {
                    0.0
                }
            });
            let cell = self.runs[0].cells.iter().position(|cell| cell.samples == samples).unwrap_or(0);
            places.push(Place {
                interval: "correlation",
                name: format!("{separation:.2} m, N = {samples}"),
                rays: self
                    .pairs_near(separation, &separations)
                    .map(|p| self.rays(cell, p))
                    .fold(f64::INFINITY, f64::min),
                runs: found
                    .iter()
                    .map(|found| found.map(|c| holds(Interval { low: c.low, high: c.high }, truth)))
                    .collect(),
            });
        }
        places
    }

    /// Points that belong to a pair nearer to this separation than to any other.
    fn pairs_near<'a>(&'a self, separation: f64, all: &'a [f64]) -> impl Iterator<Item = usize> + 'a {
        let n = self.points.len();
        let pairs = (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)));
        pairs
            .filter(move |(i, j)| {
                let metres = (self.points[*i].position() - self.points[*j].position()).length();
                let off = |s: f64| (s - metres).abs();
                all.iter().all(|other| off(separation) <= off(*other))
            })
            // A pair with a point in the dark has no correlation.
            .filter(|(i, j)| self.arriving[*i] > 0.0 && self.arriving[*j] > 0.0)
            .flat_map(|(i, j)| [i, j])
    }

    fn biases(&self) -> Vec<Place> {
        let mut places = Vec::new();
        let lit = |cell: usize| (0..self.points.len()).map(|p| self.rays(cell, p)).sum::<f64>();
        let z = normal_quantile(NOMINAL).unwrap_or(f64::NAN);
        for (cell, shown) in self.runs[0].cells.iter().enumerate().filter(|(cell, _)| lit(*cell) > 0.0) {
            let covered = |run: &&StrategyOutcome| {
                let cell = &run.cells[cell];
                // A bar of no height is none.
                (cell.mean_bias_std_error > 0.0).then(|| cell.mean_bias.abs() <= z * cell.mean_bias_std_error)
            };
            places.push(Place {
                interval: "bias",
                name: format!("mean over the points, N = {}", shown.samples),
                rays: lit(cell),
                runs: self.runs.iter().map(covered).collect(),
            });
        }
        let all: f64 = (0..self.runs[0].cells.len()).map(lit).sum();
        let of_bias = |run: &&StrategyOutcome| {
            let judged = run.verdicts.iter().find(|judged| judged.property == "bias")?;
            (judged.effect_low < judged.effect_high)
                .then(|| holds(Interval { low: judged.effect_low, high: judged.effect_high }, 0.0))
        };
        if all > 0.0 {
            places.push(Place {
                interval: "effect",
                name: "mean over the points, all N".to_owned(),
                rays: all,
                runs: self.runs.iter().map(of_bias).collect(),
            });
        }
        places
    }
}

/// Rounding is no miss: hits of probability ½ can reach the largest variance that there is.
fn holds(interval: Interval, truth: f64) -> bool {
    let reach = 1e-12 * truth.abs();
    interval.low - reach <= truth && truth <= interval.high + reach
}

/// The slope of the true variances under the weights of one run, which its intervals tell.
fn true_slope(points: &[RatePoint], truth: &dyn Fn(u64) -> Option<f64>) -> Option<f64> {
    let (mut x, mut y, mut noise) = (Vec::new(), Vec::new(), Vec::new());
    for point in points {
        // Up to a factor, which no fit sees.
        let relative = (point.high / point.low).ln();
        x.push((point.samples as f64).ln());
        y.push(truth(point.samples)?.ln());
        noise.push((relative * relative).max(1e-24));
    }
    Line::through(&x, &y, Noise::Known { variances: &noise }).ok().map(|line| line.slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(covered: usize, missed: usize, none: usize, rays: f64) -> Place {
        let runs = [vec![Some(true); covered], vec![Some(false); missed], vec![None; none]].concat();
        Place { interval: "variance", name: format!("{covered}"), rays, runs }
    }

    fn verdict_of(places: &[Place]) -> CoverageRow {
        let enough = places[0].rays >= ENOUGH_RAYS;
        let tally = Tally::of("room", "random", "variance", enough, &places.iter().collect::<Vec<_>>());
        rows(&[tally]).remove(0)
    }

    #[test]
    fn intervals_that_cover_too_little_are_found_out() {
        assert_eq!(verdict_of(&[place(970, 30, 0, 99.0)]).verdict, Some(Verdict::Pass));
        assert_eq!(verdict_of(&[place(900, 100, 0, 99.0)]).verdict, Some(Verdict::Fail));
        assert_eq!(verdict_of(&[place(94, 6, 0, 99.0)]).verdict, Some(Verdict::Undecided));
        // One bad place among many good ones.
        let many: Vec<Place> = (0..9).map(|_| place(990, 10, 0, 99.0)).chain([place(850, 150, 0, 99.0)]).collect();
        let found = verdict_of(&many);
        assert!(found.low.unwrap() > LEAST_COVERAGE && found.verdict == Some(Verdict::Fail));
        assert_eq!((found.worst, found.worst_place.as_str()), (Some(0.85), "room, random, 850"));
    }

    #[test]
    fn places_of_one_run_count_as_one() {
        let alone = verdict_of(&[place(950, 50, 0, 99.0)]);
        let alike: Vec<Place> = (0..10).map(|_| place(950, 50, 0, 99.0)).collect();
        let together = verdict_of(&alike);
        assert_eq!((alone.low, alone.high), (together.low, together.high));
        assert_eq!((together.printed, together.covered), (10_000, 9_500));
    }

    #[test]
    fn what_is_not_printed_is_not_counted_and_few_rays_are_not_judged() {
        let found = verdict_of(&[place(95, 5, 900, 99.0)]);
        assert_eq!((found.printed, found.missing, found.coverage), (100, 900, Some(0.95)));
        let found = verdict_of(&[place(10, 90, 0, 3.0)]);
        assert_eq!((found.verdict, found.coverage), (None, Some(0.1)));
        let found = verdict_of(&[place(0, 0, 100, 99.0)]);
        assert_eq!((found.verdict, found.coverage, found.low), (None, None, None));
    }

    #[test]
    fn every_strategy_and_every_case_has_its_row() {
        let tally = |case: &str, strategy: &'static str, covered: usize| {
            Tally::of(case, strategy, "variance", true, &[&place(covered, 100 - covered, 0, 99.0)])
        };
        let found = rows(&[tally("a", "random", 90), tally("a", "sobol", 100), tally("b", "random", 95)]);
        let short = |row: &CoverageRow| (row.case.clone(), row.strategy, row.runs, row.covered);
        let (a, b) = (Some("a".to_owned()), Some("b".to_owned()));
        assert_eq!(
            found.iter().map(short).collect::<Vec<_>>(),
            [
                (None, Some("random"), 200, 185),
                (None, Some("sobol"), 100, 100),
                (a, None, 200, 190),
                (b, None, 100, 95)
            ]
        );
        assert_eq!(found[0].worst_place, "a, random, 90");
    }

    #[test]
    fn the_true_slope_is_that_of_the_true_variances() {
        let at = |samples: u64, width: f64| RatePoint { samples, value: 1.0, low: 1.0, high: width };
        let points = [at(1, 1.5), at(4, 1.2), at(16, 1.1)];
        let slope = true_slope(&points, &|n| Some(3.0 / (n * n) as f64)).unwrap();
        assert!((slope + 2.0).abs() < 1e-12, "{slope}");
        assert_eq!(true_slope(&points, &|n| (n > 1).then_some(1.0)), None);
    }
}
