//! Whether errors spread as predicted: verdicts on variances, and on covariances through the variance of the mean and of
//! contrasts over the points.
//!
//! The statement: the squared deviation of an estimate from the exact value has the predicted variance as its mean. Its own
//! variance, (fourth cumulant) + 2 variance², is predicted too, so the same test judges it as judges a bias (see
//! [`crate::statistics::evidence`]). Smaller errors than predicted are a fault as larger ones are: points that are better
//! than they claim are not the points that were asked for.

use std::collections::BTreeMap;

use super::judge::place_words;
use super::measure::{CellSums, Prepared};
use super::outcome::JudgedProperty;
use super::plan::{CellPlan, margin, point_margin};
use super::predict::Tolerated;
use crate::case::Study;
use crate::sampling::Strategy;
use crate::statistics::evidence::{THRESHOLD_LOG10, ln_average, log10_capped, smallest_shift};
use crate::statistics::interval::Z_95;
use crate::statistics::{Capital, Observed, PowerSums, Statement, Verdict};

/// Relative deviation of all variances alike that a pass must have been able to see.
const SMALLEST_DEVIATION: f64 = 0.2;
/// Of the value squared: a variance below this is rounding.
const ROUNDING: f64 = 1e-24;

/// Squared deviations of one quantity in one cell, and what is predicted of them.
struct Watched {
    observed: Observed,
    statement: Statement,
    /// W²/m⁴.
    predicted: f64,
    /// Relative half-width within which no deviation counts.
    slack: f64,
}

impl Watched {
    /// `None` where the variance is rounding.
    fn new(sums: &PowerSums, predicted: Tolerated, exact: f64, margin: f64, tolerance: f64) -> Option<Watched> {
        let v = predicted.spread.variance;
        if v <= ROUNDING * exact * exact || v <= margin * margin {
            return None;
        }
        let slack = predicted.error / v + 2.0 * tolerance;
        // Of a sample that is all or nothing in equal shares the square never varies; a prediction is not that sharp.
        let spread = (predicted.spread.fourth_cumulant + 2.0 * v * v).max(0.01 * v * v) * 1.02;
        let statement =
            Statement { low: v * (1.0 - slack), high: v * (1.0 + slack) + margin * margin, variance: spread };
        Some(Watched { observed: Observed::squared_deviations(sums), statement, predicted: v, slack })
    }

    fn capital(&self, planned: u64) -> Capital {
        Capital::of(&self.statement, &self.observed, planned)
    }

    /// Relative deviation of the variance.
    fn deviation(&self) -> f64 {
        self.observed.sum / self.observed.n.max(1) as f64 / self.predicted - 1.0
    }

    /// Standard deviation of one squared deviation, relative to its mean.
    fn relative_spread(&self) -> f64 {
        self.statement.variance.sqrt() / self.predicted
    }
}

/// The variance at each point.
pub(super) fn variance(
    prepared: &Prepared,
    study: &Study,
    strategy: Strategy,
    cells: &[CellSums],
    plans: &[CellPlan],
    reproduce: &str,
) -> Option<JudgedProperty> {
    let watched = (0..prepared.exact.len()).map(|p| {
        let margin = point_margin(prepared, p, study);
        let series = cells.iter().zip(plans).map(|(cell, plan)| {
            Watched::new(&cell.points[p], plan.prediction.points[p]?, prepared.exact[p], margin, study.tolerance)
        });
        series.collect()
    });
    let judge = Judge { property: "variance", of: "the variance", prepared, strategy, cells, reproduce };
    // Points that are fresh are independent of one another, and their evidence adds up.
    judge.verdict(&watched.collect::<Vec<_>>(), !strategy.shares_points())
}

/// The variance of the mean over the points and of low-order contrasts: how errors of different points move together.
pub(super) fn covariance(
    prepared: &Prepared,
    study: &Study,
    strategy: Strategy,
    cells: &[CellSums],
    plans: &[CellPlan],
    reproduce: &str,
) -> Option<JudgedProperty> {
    if prepared.exact.len() < 2 {
        return None;
    }
    let weights = &prepared.contrasts.weights;
    let watched = (0..weights.len()).map(|k| {
        let margin = margin(prepared, study, &weights[k]);
        let series = cells.iter().zip(plans).map(|(cell, plan)| {
            let predicted = plan.prediction.contrasts.as_ref()?[k];
            Watched::new(&cell.contrasts[k], predicted, prepared.contrasts.exact[0], margin, study.tolerance)
        });
        series.collect()
    });
    let of = "the variance of means and contrasts over the points";
    let judge = Judge { property: "covariance", of, prepared, strategy, cells, reproduce };
    judge.verdict(&watched.collect::<Vec<_>>(), false)
}

/// What one capital is about.
struct Group<'a> {
    members: Vec<&'a Watched>,
    /// `None`: all of them.
    subject: Option<usize>,
    cell: Option<usize>,
}

impl<'a> Group<'a> {
    fn new(members: Vec<&'a Watched>, subject: Option<usize>, cell: Option<usize>) -> Group<'a> {
        Group { members, subject, cell }
    }
}

struct Judge<'a> {
    property: &'static str,
    of: &'static str,
    prepared: &'a Prepared<'a>,
    strategy: Strategy,
    cells: &'a [CellSums],
    reproduce: &'a str,
}

impl Judge<'_> {
    /// - `watched`: `[subject][cell]`
    /// - `independent`: whether subjects are independent of one another
    /// - returns `None` where nothing is predicted
    fn verdict(&self, watched: &[Vec<Option<Watched>>], independent: bool) -> Option<JudgedProperty> {
        let all = || watched.iter().flatten().flatten();
        all().next()?;
        let count = |list: &[&Watched]| list.iter().map(|w| w.observed.n).sum::<u64>();
        let pooled = |list: &[&Watched]| {
            let planned = count(list);
            let mut capital = Capital::new();
            list.iter().for_each(|w| capital.times(&w.capital(planned)));
            capital.ln()
        };
        let mut groups: Vec<Group> = Vec::new();
        for (subject, series) in watched.iter().enumerate() {
            for (cell, w) in series.iter().enumerate() {
                groups.extend(w.as_ref().map(|w| Group::new(vec![w], Some(subject), Some(cell))));
            }
            groups.push(Group::new(series.iter().flatten().collect(), Some(subject), None));
        }
        if independent && watched.len() > 1 {
            for cell in 0..self.cells.len() {
                let of_cell = watched.iter().filter_map(|series| series[cell].as_ref());
                groups.push(Group::new(of_cell.collect(), None, Some(cell)));
            }
            groups.push(Group::new(all().collect(), None, None));
        }
        groups.retain(|group| !group.members.is_empty());
        let components: Vec<(f64, &Group)> = groups.iter().map(|group| (pooled(&group.members), group)).collect();
        let m = components.len();
        let evidence = log10_capped(ln_average(components.iter().map(|(ln, ..)| *ln)));
        // Many groups hold as many observations.
        let mut shifts: BTreeMap<u64, f64> = BTreeMap::new();
        for group in &groups {
            let total = count(&group.members);
            shifts.entry(total).or_insert_with(|| smallest_shift(1.0, total, m));
        }
        let smallest = |wanted: &dyn Fn(Option<usize>) -> bool| {
            let fitting = groups.iter().filter(|group| wanted(group.cell));
            fitting.map(|group| smallest_deviation(&group.members, shifts[&count(&group.members)])).reduce(f64::min)
        };
        let together = smallest(&|_| true).unwrap_or(f64::INFINITY);
        let worst = (0..self.cells.len()).filter_map(|c| smallest(&|cell| cell == Some(c))).reduce(f64::max);
        let verdict = if evidence >= THRESHOLD_LOG10 {
            Verdict::Fail
        } else if together <= SMALLEST_DEVIATION {
            Verdict::Pass
        } else {
            Verdict::Undecided
        };
        let (_, strongest) = components.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let everything: Vec<&Watched> = all().collect();
        let shown = if verdict == Verdict::Fail { &strongest.members } else { &everything };
        let (effect, error) = mean_deviation(shown);
        let words = match verdict {
            Verdict::Fail => self.fail_words(strongest, effect, error),
            Verdict::Pass => format!(
                "no deviation of {} from its prediction above {:.1} % at all sample counts alike, {} at the worst one",
                self.of,
                100.0 * together,
                worst.map_or("none".to_owned(), |x| format!("{:.0} %", 100.0 * x))
            ),
            Verdict::Undecided => format!(
                "too little evidence on {}: a deviation of {:.0} % from its prediction would have been seen ({:.0} % asked); \
                 about {:.1} times the replicates would do (--replicates)",
                self.of,
                100.0 * together,
                100.0 * SMALLEST_DEVIATION,
                (together / SMALLEST_DEVIATION).powi(2)
            ),
        };
        Some(JudgedProperty {
            property: self.property,
            verdict,
            evidence,
            threshold: THRESHOLD_LOG10,
            effect,
            effect_low: effect - Z_95 * error,
            effect_high: effect + Z_95 * error,
            smallest_bias_mean: Some(together),
            smallest_bias_point: worst,
            words,
            note: None,
            reproduce: self.reproduce.to_owned(),
        })
    }

    fn fail_words(&self, group: &Group, effect: f64, error: f64) -> String {
        let Group { subject, cell, .. } = *group;
        let place = match (self.property, subject) {
            (_, None) => "over all points".to_owned(),
            ("variance", Some(p)) => place_words(self.prepared, p),
            (_, Some(0)) => "in the mean over the points".to_owned(),
            (_, Some(k)) => format!("in contrast {k} along the points"),
        };
        let count =
            cell.map_or("all sample counts together".to_owned(), |c| format!("N = {}", self.cells[c].samples));
        format!(
            "the variance of {} is {:+.1} % ± {:.1} % off its prediction {place}, {count}",
            self.strategy,
            100.0 * effect,
            100.0 * Z_95 * error
        )
    }
}

/// Mean relative deviation over a group, each weighed by its observations, and its standard error as if independent.
fn mean_deviation(group: &[&Watched]) -> (f64, f64) {
    let total: f64 = group.iter().map(|w| w.observed.n as f64).sum();
    let share = |w: &Watched| w.observed.n as f64 / total;
    let mean = group.iter().map(|w| share(w) * w.deviation()).sum();
    let square: f64 =
        group.iter().map(|w| (share(w) * w.relative_spread()).powi(2) / w.observed.n.max(1) as f64).sum();
    (mean, square.sqrt())
}

/// The relative deviation, common to a group, that would be caught with 99 % probability.
///
/// - `shift`: that would be of a mean, in units of the standard deviation of one observation
fn smallest_deviation(group: &[&Watched], shift: f64) -> f64 {
    let total: u64 = group.iter().map(|w| w.observed.n).sum();
    // Each bet is made in units of the quantity's own spread: a deviation δ moves it by δ over its relative spread.
    let pull = group.iter().map(|w| w.observed.n as f64 / w.relative_spread()).sum::<f64>() / total as f64;
    let slack = group.iter().map(|w| w.slack).fold(0.0, f64::max);
    slack + shift / pull
}
