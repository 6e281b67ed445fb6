//! Where truth meets evidence: one verdict on the bias of a case under one strategy.
//!
//! The statement: at every sample count the mean estimate at every point lies in the exact value's interval. Its evidence
//! is the average of the capitals of many components (see [`crate::statistics::evidence`]): each point, the mean and
//! low-order contrasts over the points, at each sample count by itself and at all of them together (a product, since
//! sample counts draw from independent streams). An average of such capitals is one, whatever depends on whatever.

use super::measure::{CellSums, Prepared};
use super::outcome::JudgedProperty;
use super::plan::{CellPlan, margin, point_margin};
use crate::case::{Replicates, Study};
use crate::sampling::Strategy;
use crate::statistics::evidence::{THRESHOLD_LOG10, ln_average, log10_capped};
use crate::statistics::interval::Z_95;
use crate::statistics::{Capital, Observed, PowerSums, Statement, Verdict};

/// What a component is about.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Subject {
    Point(usize),
    /// 0 is the mean over the points.
    Contrast(usize),
}

/// Who is judged, and what people are told of it.
pub(super) struct Judged<'a> {
    pub name: &'a str,
    /// The command line that gives the same verdict.
    pub reproduce: String,
    /// Where more replicates come from: what follows after their number.
    pub more: &'a str,
}

impl<'a> Judged<'a> {
    /// One of etendue's own strategies.
    pub fn strategy(strategy: Strategy, study: &Study, reproduce: String) -> Judged<'a> {
        Judged { name: strategy.name(), reproduce, more: Judged::more_of(study.replicates) }
    }

    /// Where estimates are made as they are asked for.
    pub fn more_of(replicates: Replicates) -> &'static str {
        match replicates {
            Replicates::Fixed(_) => "replicates would do (or --replicates auto)",
            Replicates::Auto => "replicates would do (--replicates), beyond what auto spends on a case",
        }
    }
}

/// Judges the bias of one case under one strategy.
///
/// - `cells`, `plans`: one for each sample count, in the same order
pub(super) fn bias(
    prepared: &Prepared,
    study: &Study,
    judged: Judged,
    cells: &[CellSums],
    plans: &[CellPlan],
) -> JudgedProperty {
    let subjects = (0..prepared.exact.len())
        .map(Subject::Point)
        .chain((0..prepared.contrasts.weights.len()).map(Subject::Contrast));
    // (ln capital, subject, cell or None for all together)
    let mut components: Vec<(f64, Subject, Option<usize>)> = Vec::new();
    for subject in subjects {
        let mut together = Capital::new();
        for (index, (cell, plan)) in cells.iter().zip(plans).enumerate() {
            let capital = capital(prepared, study, subject, cell, plan);
            together.times(&capital);
            components.push((capital.ln(), subject, Some(index)));
        }
        components.push((together.ln(), subject, None));
    }
    debug_assert_eq!(
        components.len(),
        super::plan::components(prepared, study),
        "the plan's power counts on this many"
    );
    let evidence = log10_capped(ln_average(components.iter().map(|(ln, ..)| *ln)));
    let biases: Vec<_> = plans.iter().map(|plan| plan.smallest_biases(prepared, study)).collect();
    let mean = biases.iter().filter_map(|biases| biases.mean).reduce(f64::max);
    let point = biases.iter().filter_map(|biases| biases.point).reduce(f64::max);
    let seen = |found: Option<f64>, asked: f64| found.is_none_or(|found| found <= asked * (1.0 + 1e-9));
    let verdict = if evidence >= THRESHOLD_LOG10 {
        Verdict::Fail
    } else if seen(mean, study.smallest_bias.mean) && seen(point, study.smallest_bias.point) {
        Verdict::Pass
    } else {
        Verdict::Undecided
    };
    let (_, subject, at) = *components
        .iter()
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .expect("a case has points and a study has sample counts");
    let shown = if verdict == Verdict::Fail { (subject, at) } else { (Subject::Contrast(0), None) };
    let effect = effect(prepared, shown.0, shown.1, cells, plans);
    let words = match verdict {
        Verdict::Fail => fail_words(prepared, judged.name, shown, cells, effect),
        Verdict::Pass => pass_words(mean, point),
        Verdict::Undecided => undecided_words(prepared, study, judged.more, plans, mean, point),
    };
    JudgedProperty {
        property: "bias",
        verdict,
        evidence,
        threshold: THRESHOLD_LOG10,
        effect: effect.0,
        effect_low: effect.0 - Z_95 * effect.1,
        effect_high: effect.0 + Z_95 * effect.1,
        smallest_bias_mean: mean,
        smallest_bias_point: point,
        words,
        note: None,
        reproduce: judged.reproduce,
    }
}

fn sums(cell: &CellSums, subject: Subject) -> &PowerSums {
    match subject {
        Subject::Point(p) => &cell.points[p],
        Subject::Contrast(k) => &cell.contrasts[k],
    }
}

fn capital(prepared: &Prepared, study: &Study, subject: Subject, cell: &CellSums, plan: &CellPlan) -> Capital {
    let (exact, margin, variance) = match subject {
        Subject::Point(p) => (prepared.exact[p], point_margin(prepared, p, study), plan.point_variances[p]),
        Subject::Contrast(k) => (
            prepared.contrasts.exact[k],
            margin(prepared, study, &prepared.contrasts.weights[k]),
            plan.contrast_variances[k],
        ),
    };
    let statement = Statement::near(exact, margin, variance);
    Capital::of(&statement, &Observed::values(sums(cell, subject)), plan.replicates)
}

/// Relative deviation and its standard error, of one cell or of all weighed by their planned precision (weights that were
/// measured with the values would lean towards those that happen to look sure). A contrast is taken relative to the mean;
/// where the exact value is zero, relative to the unoccluded irradiance.
fn effect(
    prepared: &Prepared,
    subject: Subject,
    at: Option<usize>,
    cells: &[CellSums],
    plans: &[CellPlan],
) -> (f64, f64) {
    let unoccluded = |p: usize| prepared.truths[p].unoccluded_irradiance.watts_per_square_metre();
    let scale = match subject {
        Subject::Point(p) if prepared.exact[p] > 0.0 => prepared.exact[p],
        Subject::Point(p) => unoccluded(p),
        Subject::Contrast(_) if prepared.contrasts.exact[0] > 0.0 => prepared.contrasts.exact[0],
        Subject::Contrast(_) => (0..prepared.exact.len()).map(unoccluded).sum::<f64>() / prepared.exact.len() as f64,
    };
    let chosen = cells.iter().zip(plans).enumerate().filter(|(index, _)| at.is_none_or(|at| at == *index));
    let (mut weight, mut weighed, mut squares) = (0.0, 0.0, 0.0);
    let mut constant = None;
    for (_, (cell, plan)) in chosen {
        let sums = sums(cell, subject);
        let (deviation, error) = (sums.mean_deviation().unwrap_or(0.0), sums.std_error().unwrap_or(0.0));
        let planned = match subject {
            Subject::Point(p) => plan.point_variances[p],
            Subject::Contrast(k) => plan.contrast_variances[k],
        };
        if planned > 0.0 {
            let precision = plan.replicates as f64 / planned;
            weight += precision;
            weighed += deviation * precision;
            squares += (error * precision).powi(2);
        } else {
            constant = Some(deviation);
        }
    }
    let (deviation, error) = match constant {
        // A mean without spread outweighs all others.
        Some(deviation) => (deviation, 0.0),
        None if weight > 0.0 => (weighed / weight, squares.sqrt() / weight),
        None => (0.0, 0.0),
    };
    if scale > 0.0 { (deviation / scale, error / scale) } else { (deviation, error) }
}

/// Which point it is.
pub(super) fn place_words(prepared: &Prepared, p: usize) -> String {
    let x = prepared.case.configuration.points()[p].position();
    format!("at point {p} ({} m, {} m, {} m; {})", x.x, x.y, x.z, prepared.truths[p].region)
}

fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

fn pass_words(mean: Option<f64>, point: Option<f64>) -> String {
    match (mean, point) {
        (Some(mean), Some(point)) => format!(
            "no bias above {} in the mean, {} at the worst point that a tenth of the light reaches",
            percent(mean),
            percent(point)
        ),
        (Some(mean), None) => {
            format!("no bias above {} in the mean; no point is lit by a tenth or more", percent(mean))
        }
        (None, _) => "no light is due at any point and none arrived".to_owned(),
    }
}

fn fail_words(
    prepared: &Prepared,
    name: &str,
    (subject, at): (Subject, Option<usize>),
    cells: &[CellSums],
    (deviation, error): (f64, f64),
) -> String {
    let place = match subject {
        Subject::Point(p) => place_words(prepared, p),
        Subject::Contrast(0) => "in the mean over the points".to_owned(),
        Subject::Contrast(k) => format!("in contrast {k} along the points, relative to the mean"),
    };
    let count = at.map_or("all sample counts together".to_owned(), |index| format!("N = {}", cells[index].samples));
    format!("{name} is biased by {:+.3} % ± {:.3} % {place}, {count}", 100.0 * deviation, 100.0 * Z_95 * error)
}

fn undecided_words(
    prepared: &Prepared,
    study: &Study,
    more: &str,
    plans: &[CellPlan],
    mean: Option<f64>,
    point: Option<f64>,
) -> String {
    let asked = study.smallest_bias;
    let found = |x: Option<f64>| x.map_or("nothing".to_owned(), percent);
    let mut factor = 1.0_f64;
    for (found, asked) in [(mean, asked.mean), (point, asked.point)] {
        if let Some(found) = found {
            factor = factor.max((found / asked) * (found / asked));
        }
    }
    let replicates = plans.iter().map(|plan| plan.replicates as f64 * factor).fold(0.0, f64::max);
    let how = if !replicates.is_finite() {
        "no number of replicates is enough".to_owned()
    } else {
        format!("about {replicates:.0} {more}")
    };
    format!(
        "too little evidence: a bias of {} in the mean ({} asked) and {} at the worst of {} points ({} asked) would have been seen; {how}",
        found(mean),
        percent(asked.mean),
        found(point),
        prepared.exact.len(),
        percent(asked.point)
    )
}
