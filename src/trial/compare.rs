//! Two runs beside each other: which verdicts changed, and where estimates vary more or less than before.

use std::collections::BTreeMap;

use crate::sampling::Strategy;
use crate::statistics::{Interval, Verdict};

/// What the tables of a report say of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// The version that made it, its seed and its command, as the manifest has them; empty where there is none.
    pub version: String,
    pub seed: String,
    pub command: String,
    /// Name and digest of each case, as the manifest has them.
    pub digests: BTreeMap<String, String>,
    pub verdicts: Vec<RecordedVerdict>,
    pub variances: Vec<RecordedVariance>,
}

/// A row of `verdicts.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedVerdict {
    pub case: String,
    pub strategy: String,
    pub property: String,
    pub verdict: Verdict,
    /// Relative; its 95 % interval. `None` where there is none.
    pub effect: Option<(f64, Interval)>,
    pub reproduce: String,
}

/// A row of `convergence.csv`: the variance of one estimate, W²/m⁴.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedVariance {
    pub case: String,
    pub strategy: String,
    pub point: u64,
    pub samples: u64,
    pub variance: f64,
    /// 95 %; `None` where too few rays were expected for one.
    pub interval: Option<Interval>,
}

/// A strategy of the run before, and the one of the run after that it is compared with.
pub type Pairing = Option<(String, String)>;

/// What changed from one run to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Verdicts that both runs have.
    pub compared: usize,
    /// Those that differ, those that got worse first.
    pub verdicts: Vec<VerdictChange>,
    /// One for each case and strategy that both have and that varies in both.
    pub variances: Vec<VarianceChange>,
    /// Case, strategy and property of the verdicts that one run alone has.
    pub only_before: Vec<[String; 3]>,
    pub only_after: Vec<[String; 3]>,
    /// Cases that bear one name and are not the same: their variances say nothing of the estimator.
    pub other_cases: Vec<String>,
}

/// A verdict that changed.
#[derive(Clone, Debug, PartialEq)]
pub struct VerdictChange {
    pub before: RecordedVerdict,
    pub after: RecordedVerdict,
}

impl VerdictChange {
    /// Whether it is a regression: what passed does not, or what did not fail does.
    pub fn is_worse(&self) -> bool {
        rank(self.after.verdict) > rank(self.before.verdict)
    }
}

fn rank(verdict: Verdict) -> u8 {
    match verdict {
        Verdict::Pass => 0,
        Verdict::Undecided => 1,
        Verdict::Fail => 2,
    }
}

/// How much more one estimate varies after than before: the ratio of the sums of its variances over the points that have
/// intervals in both runs.
#[derive(Clone, Debug, PartialEq)]
pub struct VarianceChange {
    pub case: String,
    pub before: String,
    pub after: String,
    /// The largest N that both runs have.
    pub samples: u64,
    pub points: usize,
    /// After over before.
    pub ratio: f64,
    /// 95 %, from the intervals of both.
    pub interval: Interval,
    /// Such that a ratio of 1 lies below it, or above it, once in a million comparisons of what did not change.
    pub sure: Interval,
    /// Whether the case is the same in both runs, so that the estimator alone can be the cause.
    pub is_same_case: bool,
}

impl VarianceChange {
    /// Whether it is a regression: more variance, beyond doubt, from the same case.
    pub fn is_worse(&self) -> bool {
        self.is_same_case && self.sure.low > 1.0
    }

    /// Whether there is less variance, beyond doubt, from the same case.
    pub fn is_better(&self) -> bool {
        self.is_same_case && self.sure.high < 1.0
    }
}

impl Comparison {
    /// Whether anything got worse.
    pub fn regresses(&self) -> bool {
        self.verdicts.iter().any(VerdictChange::is_worse) || self.variances.iter().any(VarianceChange::is_worse)
    }

    /// Whether the runs have nothing in common.
    pub fn is_empty(&self) -> bool {
        self.compared == 0 && self.variances.is_empty()
    }
}

/// Compares what both runs have.
///
/// - `pairing`: compares one strategy of the run before with another of the run after; `None`: each with its namesake
pub fn compare(before: &Record, after: &Record, pairing: &Pairing) -> Comparison {
    // What the strategy of a row before is called after; `None` where it is not asked about.
    let partner = |strategy: &str| match pairing {
        None => Some(strategy.to_owned()),
        Some((old, new)) => (strategy == old).then(|| new.clone()),
    };
    let is_asked_after = |strategy: &str| pairing.as_ref().is_none_or(|(_, new)| strategy == new);
    let is_same_case = |case: &str| match (before.digests.get(case), after.digests.get(case)) {
        (Some(one), Some(other)) => one == other,
        _ => true,
    };
    let mut comparison = Comparison {
        compared: 0,
        verdicts: Vec::new(),
        variances: variances(before, after, &partner, &is_same_case),
        only_before: Vec::new(),
        only_after: Vec::new(),
        other_cases: Vec::new(),
    };
    let key =
        |verdict: &RecordedVerdict, strategy: String| [verdict.case.clone(), strategy, verdict.property.clone()];
    let mut new: BTreeMap<[String; 3], &RecordedVerdict> = after
        .verdicts
        .iter()
        .filter(|verdict| is_asked_after(&verdict.strategy))
        .map(|verdict| (key(verdict, verdict.strategy.clone()), verdict))
        .collect();
    for old in &before.verdicts {
        let Some(strategy) = partner(&old.strategy) else { continue };
        match new.remove(&key(old, strategy)) {
            Some(now) => {
                comparison.compared += 1;
                if now.verdict != old.verdict {
                    comparison.verdicts.push(VerdictChange { before: old.clone(), after: now.clone() });
                }
            }
            None => comparison.only_before.push(key(old, old.strategy.clone())),
        }
    }
    let others = after.verdicts.iter().map(|verdict| key(verdict, verdict.strategy.clone()));
    comparison.only_after = others.filter(|key| new.contains_key(key)).collect();
    comparison.verdicts.sort_by_key(|change| !change.is_worse());
    comparison.other_cases = before.digests.keys().filter(|case| !is_same_case(case)).cloned().collect();
    comparison
}

/// Half the width of a normal's two-sided interval of 95 %, and of its one-sided one that misses once in a million, in
/// standard deviations.
const SIDES: [f64; 2] = [1.959_963_984_540_054, 4.753_424_308_822_899];

/// The variances of one case and strategy, by samples and point.
type Variances<'a> = BTreeMap<(u64, u64), &'a RecordedVariance>;

fn variances(
    before: &Record,
    after: &Record,
    partner: &dyn Fn(&str) -> Option<String>,
    is_same_case: &dyn Fn(&str) -> bool,
) -> Vec<VarianceChange> {
    let mut new: BTreeMap<(&str, &str), Variances> = BTreeMap::new();
    for row in &after.variances {
        new.entry((&row.case, &row.strategy)).or_default().insert((row.samples, row.point), row);
    }
    // In the order of the run before.
    let mut seen: Vec<(&str, &str, Variances)> = Vec::new();
    let mut places: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for row in &before.variances {
        let at = *places.entry((&row.case, &row.strategy)).or_insert_with(|| {
            seen.push((&row.case, &row.strategy, Variances::new()));
            seen.len() - 1
        });
        seen[at].2.insert((row.samples, row.point), row);
    }
    let mut changes = Vec::new();
    for (case, strategy, old) in seen {
        let Some(renamed) = partner(strategy) else { continue };
        let Some(new) = new.get(&(case, renamed.as_str())) else { continue };
        let has = |samples: &u64| new.range((*samples, 0)..=(*samples, u64::MAX)).next().is_some();
        let Some((samples, _)) = old.keys().rev().find(|(samples, _)| has(samples)) else { continue };
        let points: Vec<[&RecordedVariance; 2]> = old
            .range((*samples, 0)..=(*samples, u64::MAX))
            .filter_map(|(key, one)| Some([*one, *new.get(key)?]))
            .filter(|both| both.iter().all(|row| row.interval.is_some() && row.variance > 0.0))
            .collect();
        let one = sum(points.iter().map(|both| both[0]), strategy);
        let other = sum(points.iter().map(|both| both[1]), &renamed);
        let (Some(one), Some(other)) = (one, other) else { continue };
        let ratio = other.value / one.value;
        let interval = |widened: f64| Interval {
            low: ratio * (-widened * other.below.hypot(one.above)).exp(),
            high: ratio * (widened * other.above.hypot(one.below)).exp(),
        };
        changes.push(VarianceChange {
            case: case.to_owned(),
            before: strategy.to_owned(),
            after: renamed.clone(),
            samples: *samples,
            points: points.len(),
            ratio,
            interval: interval(1.0),
            sure: interval(SIDES[1] / SIDES[0]),
            is_same_case: is_same_case(case),
        });
    }
    changes
}

/// A sum of variances, and how far the ends of its 95 % interval are from it, as logarithms of their ratio.
struct Sum {
    value: f64,
    below: f64,
    above: f64,
}

/// `None` without points, and where an end is not above zero.
///
/// Errors at points that share nothing add up in squares; at points that share their samples (and of strategies that are not
/// ours) they may all go one way.
fn sum<'a>(points: impl Iterator<Item = &'a RecordedVariance>, strategy: &str) -> Option<Sum> {
    let is_shared = Strategy::from_name(strategy).is_none_or(Strategy::shares_points);
    let (mut value, mut below, mut above) = (0.0, 0.0, 0.0);
    for point in points {
        let interval = point.interval?;
        value += point.variance;
        let sides = [point.variance - interval.low, interval.high - point.variance];
        let powers = if is_shared { sides } else { sides.map(|side| side * side) };
        (below, above) = (below + powers[0], above + powers[1]);
    }
    if !is_shared {
        (below, above) = (below.sqrt(), above.sqrt());
    }
    (value > 0.0 && value > below).then(|| Sum {
        value,
        below: (value / (value - below)).ln(),
        above: ((value + above) / value).ln(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(case: &str, strategy: &str, verdict: Verdict) -> RecordedVerdict {
        RecordedVerdict {
            case: case.to_owned(),
            strategy: strategy.to_owned(),
            property: "bias".to_owned(),
            verdict,
            effect: None,
            reproduce: String::new(),
        }
    }

    fn variance(strategy: &str, point: u64, samples: u64, variance: f64, relative: f64) -> RecordedVariance {
        RecordedVariance {
            case: "room".to_owned(),
            strategy: strategy.to_owned(),
            point,
            samples,
            variance,
            interval: Some(Interval { low: variance * (1.0 - relative), high: variance * (1.0 + relative) }),
        }
    }

    #[test]
    fn what_got_worse_is_a_regression_and_what_got_better_is_none() {
        use Verdict::{Fail, Pass, Undecided};
        for (old, new, regresses) in [
            (Pass, Fail, true),
            (Pass, Undecided, true),
            (Undecided, Fail, true),
            (Pass, Pass, false),
            (Fail, Fail, false),
            (Fail, Pass, false),
            (Fail, Undecided, false),
        ] {
            let record = |of| Record { verdicts: vec![verdict("room", "random", of)], ..Record::default() };
            let comparison = compare(&record(old), &record(new), &None);
            assert_eq!(comparison.compared, 1);
            assert_eq!(comparison.verdicts.len(), usize::from(old != new));
            assert_eq!(comparison.regresses(), regresses, "{old:?} to {new:?}");
        }
    }

    #[test]
    fn what_one_run_alone_has_is_told() {
        let before = Record {
            verdicts: vec![verdict("a", "random", Verdict::Pass), verdict("b", "random", Verdict::Pass)],
            ..Record::default()
        };
        let after = Record {
            verdicts: vec![verdict("b", "random", Verdict::Pass), verdict("b", "lhs", Verdict::Fail)],
            ..Record::default()
        };
        let comparison = compare(&before, &after, &None);
        assert_eq!(comparison.only_before, [["a", "random", "bias"].map(String::from)]);
        assert_eq!(comparison.only_after, [["b", "lhs", "bias"].map(String::from)]);
        assert!(!comparison.regresses() && comparison.compared == 1);
        // One sampler against another: what else there is is not asked about.
        let pairing = Some(("random".to_owned(), "lhs".to_owned()));
        let comparison = compare(&before, &after, &pairing);
        assert_eq!(comparison.only_before, [["a", "random", "bias"].map(String::from)]);
        assert!(comparison.only_after.is_empty() && comparison.regresses());
    }

    #[test]
    fn variances_compare_at_the_largest_common_count() {
        let before = Record {
            variances: vec![variance("random", 0, 16, 9.0, 0.1), variance("random", 0, 64, 2.0, 0.1)],
            ..Record::default()
        };
        let after = Record {
            variances: vec![variance("random", 0, 16, 3.0, 0.1), variance("random", 0, 256, 0.1, 0.1)],
            ..Record::default()
        };
        let [change] = &compare(&before, &after, &None).variances[..] else { panic!() };
        assert_eq!((change.samples, change.points), (16, 1));
        approx::assert_relative_eq!(change.ratio, 1.0 / 3.0, max_relative = 1e-15);
        assert!(change.is_better() && !change.is_worse());
    }

    #[test]
    fn intervals_of_ratios_are_those_of_normal_logarithms() {
        // Of one point with 1 % in each run: √2 % of the ratio.
        let record = |of| Record { variances: vec![variance("random", 0, 4, of, 0.01)], ..Record::default() };
        let [change] = &compare(&record(1.0), &record(1.0), &None).variances[..] else { panic!() };
        approx::assert_relative_eq!(change.interval.high, 1.0 + 2f64.sqrt() * 0.01, max_relative = 1e-4);
        approx::assert_relative_eq!(change.interval.low, 1.0 - 2f64.sqrt() * 0.01, max_relative = 1e-3);
        // 100 points on their own: a tenth of it; of points that share samples: as much as one.
        for (strategy, expected) in [("random", 0.1), ("correlated", 1.0)] {
            let rows = (0..100).map(|point| variance(strategy, point, 4, 1.0, 0.01)).collect();
            let record = Record { variances: rows, ..Record::default() };
            let [change] = &compare(&record, &record, &None).variances[..] else { panic!() };
            let wide = (change.interval.high - 1.0) / (2f64.sqrt() * 0.01);
            approx::assert_relative_eq!(wide, expected, max_relative = 0.02);
        }
    }

    #[test]
    fn a_rise_counts_beyond_doubt_only_and_in_the_same_case() {
        let record = |of: f64, digest: &str| Record {
            variances: vec![variance("random", 0, 4, of, 0.05)],
            digests: BTreeMap::from([("room".to_owned(), digest.to_owned())]),
            ..Record::default()
        };
        let worse = |ratio, digest| compare(&record(1.0, "x"), &record(ratio, digest), &None).regresses();
        // 95 % ends at about 7 %, the doubt of one in a million at about 18 %.
        assert!(!worse(1.1, "x"));
        assert!(worse(1.3, "x"));
        assert!(!worse(1.3, "y"), "another case under the same name");
        assert_eq!(compare(&record(1.0, "x"), &record(1.0, "y"), &None).other_cases, ["room"]);
    }

    #[test]
    fn points_without_an_interval_are_left_out() {
        let bare = RecordedVariance { interval: None, ..variance("random", 1, 4, 5.0, 0.1) };
        let dark = variance("random", 2, 4, 0.0, 0.0);
        let record =
            Record { variances: vec![variance("random", 0, 4, 1.0, 0.1), bare.clone(), dark], ..Record::default() };
        assert_eq!(compare(&record, &record, &None).variances[0].points, 1);
        let record = Record { variances: vec![bare], ..Record::default() };
        assert!(compare(&record, &record, &None).is_empty());
    }
}
