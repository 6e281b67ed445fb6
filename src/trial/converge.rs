//! A witness without randomness, judged by convergence: where its estimates go as its effort grows.
//!
//! Nothing random means no evidence in the sense of [`crate::statistics::evidence`]; what stands in for it is an assumption,
//! and it is stated: that estimates v(n) approach a limit no more slowly than their last changes say. If changes between
//! efforts shrink as n^(−q), what is left beyond the last effort n₂ is at most about
//!
//! ```text
//! |v(n₂) − v(n₁)| / ((n₂/n₁)^q − 1)
//! ```
//!
//! and twice that is allowed for. The limit then lies within so much of the last estimate: `fail` where that leaves the exact
//! value out, `pass` where all of it lies within the bias that is asked about.

use thiserror::Error;

use super::outcome::JudgedProperty;
use crate::case::{Case, SmallestBias};
use crate::oracle::Oracle;
use crate::statistics::Verdict;

/// On what terms.
#[derive(Clone, Debug)]
pub struct ConvergenceTerms<'a> {
    /// What reports call the judged.
    pub name: &'a str,
    pub reproduce: String,
    /// Relative deviation that is no fault: single precision, the steps of an integer image. No less than 1e-5 counts.
    pub tolerance: f64,
    /// Relative biases that a pass rules out: of the mean, and at the worst point.
    pub smallest_bias: SmallestBias,
}

/// The estimates of one effort.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// What the witness counts: samples, cells along a side.
    pub effort: u64,
    /// Relative deviation of the mean over the points.
    pub mean: f64,
    /// Largest deviation of a point, relative to what is due there or, where less than a tenth of the light arrives, to that
    /// tenth.
    pub worst: f64,
    /// Index of that point.
    pub worst_point: usize,
    /// Change of the mean since the last effort, in the same unit.
    pub change_mean: Option<f64>,
    /// Largest change of a point.
    pub change_worst: Option<f64>,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct ConvergenceOutcome {
    pub case: String,
    pub name: String,
    /// By ascending effort.
    pub levels: Vec<Level>,
    /// q: changes of points shrink as effort^(−q); `None` where nothing changes.
    pub rate: Option<f64>,
    /// What is allowed for beyond the last effort: of the mean, and of the worst point.
    pub left: [f64; 2],
    /// The last estimate at every point, and what is due, W/m².
    pub points: Vec<[f64; 2]>,
    pub verdict: JudgedProperty,
}

/// Why there is no verdict.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NoConvergence {
    #[error(
        "{case}: estimates at {said} effort{} (column samples); convergence shows from {FEWEST_EFFORTS} on, the largest of which is {SPAN} times the least",
        if *said == 1 { "" } else { "s" }
    )]
    TooFewEfforts { case: String, said: usize },
    #[error("{case}: no light is due at any point, with occluders or without")]
    NoLight { case: String },
}

const FEWEST_EFFORTS: usize = 3;
const SPAN: u64 = 4;
/// Times what the last changes leave, for what they do not tell.
const SAFETY: f64 = 2.0;
/// Changes that shrink faster than 1/n are not trusted to go on so.
const FASTEST: f64 = 1.0;
/// Changes that shrink more slowly than this do not lead anywhere.
const SLOWEST: f64 = 0.2;
/// Standard errors, where a witness has replicates that differ.
const NOISE: f64 = 5.0;

/// Judges estimates at several efforts.
///
/// - `given`: for each effort, ascending, `[replicate][point]`, W/m²; replicates are averaged
pub fn judge_convergence(
    case: &Case,
    given: &[(u64, Vec<Vec<f64>>)],
    terms: &ConvergenceTerms,
) -> Result<ConvergenceOutcome, NoConvergence> {
    let (first, last) = (given.first().map_or(0, |level| level.0), given.last().map_or(0, |level| level.0));
    if given.len() < FEWEST_EFFORTS || last < SPAN * first {
        return Err(NoConvergence::TooFewEfforts { case: case.name.clone(), said: given.len() });
    }
    let scale = Scale::of(case)?;
    let means: Vec<Vec<f64>> = given.iter().map(|(_, rows)| mean(rows)).collect();
    let levels: Vec<Level> = (0..given.len()).map(|i| scale.level(given[i].0, &means, i)).collect();
    let rate = rate(&levels);
    let noise = scale.noise(&given[given.len() - 1].1);
    let left = [
        beyond(&levels, rate, |level| level.change_mean) + noise[0],
        beyond(&levels, rate, |level| level.change_worst) + noise[1],
    ];
    let verdict = verdict(terms, &levels, left, scale.bound, rate);
    let points = means[means.len() - 1].iter().zip(&scale.exact).map(|(found, due)| [*found, *due]).collect();
    Ok(ConvergenceOutcome {
        case: case.name.clone(),
        name: terms.name.to_owned(),
        levels,
        rate,
        left,
        points,
        verdict,
    })
}

/// What is due, and what deviations from it are relative to.
struct Scale {
    exact: Vec<f64>,
    of_point: Vec<f64>,
    of_sum: f64,
    /// Of exact values, relative.
    bound: f64,
}

impl Scale {
    fn of(case: &Case) -> Result<Scale, NoConvergence> {
        let oracle = Oracle::new(&case.configuration);
        let truths: Vec<_> = case.configuration.points().iter().map(|point| oracle.at(point)).collect();
        let exact: Vec<f64> = truths.iter().map(|truth| truth.irradiance.watts_per_square_metre()).collect();
        let open = truths.iter().map(|truth| truth.unoccluded_irradiance.watts_per_square_metre());
        let most = open.clone().fold(0.0, f64::max);
        // A point that sees no source at all is measured against what others see.
        let of_point: Vec<f64> =
            exact.iter().zip(open).map(|(e, open)| e.max(0.1 * if open > 0.0 { open } else { most })).collect();
        if most <= 0.0 {
            return Err(NoConvergence::NoLight { case: case.name.clone() });
        }
        let sum: f64 = exact.iter().sum();
        let of_sum = if sum > 0.0 { sum } else { of_point.iter().sum() };
        let bounds = truths.iter().map(|truth| truth.bound.watts_per_square_metre());
        let bound = bounds.zip(&of_point).map(|(bound, scale)| bound / scale).fold(0.0, f64::max);
        Ok(Scale { exact, of_point, of_sum, bound })
    }

    /// Of one set of values from another: relative sum, and the largest of a point with its index.
    fn between(&self, a: &[f64], b: &[f64]) -> (f64, (f64, usize)) {
        let off = || a.iter().zip(b).map(|(a, b)| a - b);
        let worst = off().zip(&self.of_point).map(|(off, scale)| off / scale).enumerate();
        let worst = worst.fold(
            (0.0, 0),
            |best: (f64, usize), (p, off)| {
                if off.abs() > best.0.abs() { (off, p) } else { best }
            },
        );
        (off().sum::<f64>() / self.of_sum, worst)
    }

    fn level(&self, effort: u64, means: &[Vec<f64>], i: usize) -> Level {
        let (mean, (worst, worst_point)) = self.between(&means[i], &self.exact);
        let change = i.checked_sub(1).map(|before| self.between(&means[i], &means[before]));
        Level {
            effort,
            mean,
            worst,
            worst_point,
            change_mean: change.map(|change| change.0.abs()),
            change_worst: change.map(|change| change.1.0.abs()),
        }
    }

    /// Of means over replicates, with [`NOISE`] standard errors: of the sum, and of the worst point.
    fn noise(&self, rows: &[Vec<f64>]) -> [f64; 2] {
        if rows.len() < 2 {
            return [0.0; 2];
        }
        let k = rows.len() as f64;
        let error = |values: &dyn Fn(&[f64]) -> f64| {
            let mean = rows.iter().map(|row| values(row)).sum::<f64>() / k;
            let squares = rows.iter().map(|row| (values(row) - mean).powi(2)).sum::<f64>();
            NOISE * (squares / (k - 1.0) / k).sqrt()
        };
        let of_sum = error(&|row| row.iter().sum::<f64>()) / self.of_sum;
        let of_point = (0..self.exact.len()).map(|p| error(&|row| row[p]) / self.of_point[p]);
        [of_sum, of_point.fold(0.0, f64::max)]
    }
}

fn mean(rows: &[Vec<f64>]) -> Vec<f64> {
    let mut sums = vec![0.0; rows.first().map_or(0, Vec::len)];
    for row in rows {
        sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
    }
    sums.iter_mut().for_each(|sum| *sum /= rows.len() as f64);
    sums
}

/// The slope of the points' changes against the effort, both as logarithms, with its sign turned; `None` where fewer than two
/// efforts changed anything.
fn rate(levels: &[Level]) -> Option<f64> {
    let changes: Vec<[f64; 2]> = levels
        .iter()
        .filter_map(|level| {
            Some([libm::log(level.effort as f64), libm::log(level.change_worst.filter(|c| *c > 0.0)?)])
        })
        .collect();
    let n = changes.len() as f64;
    let [x, y] = [0, 1].map(|axis| changes.iter().map(|change| change[axis]).sum::<f64>() / n);
    let squares = changes.iter().map(|change| (change[0] - x).powi(2)).sum::<f64>();
    let products = changes.iter().map(|change| (change[0] - x) * (change[1] - y)).sum::<f64>();
    (changes.len() >= 2 && squares > 0.0).then(|| -products / squares)
}

/// What may be left beyond the last effort.
fn beyond(levels: &[Level], rate: Option<f64>, change: impl Fn(&Level) -> Option<f64>) -> f64 {
    let [.., before, last] = levels else { return f64::INFINITY };
    let (Some(latest), earlier) = (change(last), change(before).unwrap_or(0.0)) else { return f64::INFINITY };
    if latest == 0.0 && earlier == 0.0 {
        return 0.0;
    }
    let Some(rate) = rate.filter(|rate| *rate >= SLOWEST) else { return f64::INFINITY };
    let shrinks = libm::pow(last.effort as f64 / before.effort as f64, rate.min(FASTEST));
    // A last change that is small by chance does not count: it is no less than the one before lets expect.
    SAFETY * latest.max(earlier / shrinks) / (shrinks - 1.0)
}

fn verdict(
    terms: &ConvergenceTerms,
    levels: &[Level],
    left: [f64; 2],
    bound: f64,
    rate: Option<f64>,
) -> JudgedProperty {
    let last = levels[levels.len() - 1];
    let tolerance = terms.tolerance.max(super::LEAST_TOLERANCE) + bound;
    let found = [last.mean, last.worst];
    let asked = [terms.smallest_bias.mean, terms.smallest_bias.point];
    let is_off = |i: usize| found[i].abs() - left[i] > tolerance;
    let is_near = |i: usize| found[i].abs() + left[i] + bound <= asked[i];
    let percent = |x: f64| format!("{:+.3} %", 100.0 * x);
    let reach = |x: f64| if x.is_finite() { format!("{:.3} %", 100.0 * x) } else { "?".to_owned() };
    let (verdict, words) = if is_off(0) || is_off(1) {
        let words = format!(
            "{} settles off the exact value: {} ± {} in the mean, {} ± {} at point {}, at effort {} and beyond",
            terms.name,
            percent(found[0]),
            reach(left[0]),
            percent(found[1]),
            reach(left[1]),
            last.worst_point,
            last.effort
        );
        (Verdict::Fail, words)
    } else if is_near(0) && is_near(1) {
        let words = format!(
            "{} converges: within {} in the mean, {} at the worst point, at effort {} and beyond",
            terms.name,
            reach(found[0].abs() + left[0]),
            reach(found[1].abs() + left[1]),
            last.effort
        );
        (Verdict::Pass, words)
    } else {
        let words = format!(
            "not settled at effort {}: off by {} in the mean ({} more may come; {} asked), {} at point {} ({}; {} asked); \
             a larger effort would tell",
            last.effort,
            percent(found[0]),
            reach(left[0]),
            reach(asked[0]),
            percent(found[1]),
            last.worst_point,
            reach(left[1]),
            reach(asked[1])
        );
        (Verdict::Undecided, words)
    };
    // What is reported is what failed: the point if only that did.
    let shown = usize::from(verdict == Verdict::Fail && !is_off(0));
    let seen = |i: usize| Some(left[i] + tolerance).filter(|x| x.is_finite());
    let note = format!(
        "nothing random is judged here: this leans on estimates that go on changing no faster than by effort^-{:.2}, as they \
         did between the {} efforts, with twice what that leaves",
        rate.map_or(FASTEST, |rate| rate.clamp(0.0, FASTEST)),
        levels.len()
    );
    JudgedProperty {
        property: "limit",
        verdict,
        evidence: 0.0,
        threshold: crate::statistics::evidence::THRESHOLD_LOG10,
        effect: found[shown],
        effect_low: found[shown] - left[shown],
        effect_high: found[shown] + left[shown],
        smallest_bias_mean: seen(0),
        smallest_bias_point: seen(1),
        words,
        note: Some(note),
        reproduce: terms.reproduce.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn terms() -> ConvergenceTerms<'static> {
        let smallest_bias = SmallestBias { mean: 2e-3, point: 2e-2 };
        ConvergenceTerms { name: "witness", reproduce: String::new(), tolerance: 0.0, smallest_bias }
    }

    /// The exact values times 1 + `bias` + c·n^(−q) with c of either sign from point to point.
    fn judged(bias: f64, c: f64, q: f64, efforts: &[u64]) -> Result<ConvergenceOutcome, NoConvergence> {
        let case = Case::shipped("penumbra/eclipse").unwrap();
        let oracle = Oracle::new(&case.configuration);
        let exact: Vec<f64> = case
            .configuration
            .points()
            .iter()
            .map(|point| oracle.at(point).irradiance.watts_per_square_metre())
            .collect();
        let level = |n: u64| {
            let off = |p: usize| bias + c * (1.0 + (p % 3) as f64) * (n as f64).powf(-q);
            (n, vec![exact.iter().enumerate().map(|(p, e)| e * (1.0 + off(p))).collect()])
        };
        judge_convergence(&case, &efforts.iter().map(|n| level(*n)).collect::<Vec<_>>(), &terms())
    }

    #[test]
    fn what_converges_passes_and_what_settles_elsewhere_fails() {
        let efforts = [8, 16, 32, 64, 128, 256, 512, 1024];
        for (q, c) in [(0.5, 0.005), (1.0, 0.1), (1.5, 1.0), (2.0, 1.0)] {
            let right = judged(0.0, c, q, &efforts).unwrap();
            assert_eq!(right.verdict.verdict, Verdict::Pass, "{q}: {}", right.verdict.words);
            assert!((right.rate.unwrap() - q).abs() < 1e-6, "{:?}", right.rate);
            let wrong = judged(0.01, c, q, &efforts).unwrap();
            assert_eq!(wrong.verdict.verdict, Verdict::Fail, "{q}: {}", wrong.verdict.words);
            let off = wrong.levels[7].mean;
            assert!((off - 0.01).abs() <= wrong.left[0], "{off} {:?}", wrong.left);
        }
        // Nothing changes any more, and it is wrong by little.
        assert_eq!(judged(1e-3, 0.0, 1.0, &efforts).unwrap().verdict.verdict, Verdict::Fail);
        assert_eq!(judged(0.0, 0.0, 1.0, &efforts).unwrap().verdict.verdict, Verdict::Pass);
    }

    #[test]
    fn what_still_moves_is_undecided() {
        let found = judged(0.0, 0.5, 0.5, &[8, 16, 32]).unwrap();
        assert_eq!(found.verdict.verdict, Verdict::Undecided, "{}", found.verdict.words);
        // It does not shrink at all.
        let case = Case::shipped("penumbra/eclipse").unwrap();
        let n = case.configuration.points().len();
        let given: Vec<(u64, Vec<Vec<f64>>)> =
            (0..5).map(|i| (4 << i, vec![vec![0.05 + 0.02 * (i % 2) as f64; n]])).collect();
        let found = judge_convergence(&case, &given, &terms()).unwrap();
        assert_eq!(found.verdict.verdict, Verdict::Undecided, "{}", found.verdict.words);
    }

    #[test]
    fn too_few_efforts_are_refused() {
        for efforts in [&[8, 16][..], &[8, 9, 10], &[]] {
            let error = judged(0.0, 0.1, 1.0, efforts).unwrap_err();
            assert!(error.to_string().contains("convergence shows from 3 on"), "{error}");
        }
    }
}
