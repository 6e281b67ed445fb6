//! How often correct estimators are found guilty.

use crate::statistics::Verdict;
use crate::statistics::proportion::{lower_limit, upper_limit};

/// Levels α that are looked at.
pub const LEVELS: [f64; 7] = [1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4];
/// Of the limits.
const LEVEL: f64 = 0.95;

/// One level of one property, over one case or all.
#[derive(Clone, Debug, PartialEq)]
pub struct AlarmRow {
    /// What was judged: `bias`, say.
    pub property: &'static str,
    /// `None`: all of them.
    pub case: Option<String>,
    /// α.
    pub level: f64,
    /// Verdicts on correct estimators, each from its own seed.
    pub runs: u64,
    /// Verdicts whose evidence reached 1/α.
    pub alarms: u64,
    /// Alarms in a run.
    pub rate: f64,
    /// The rate is below this with 95 % confidence (Clopper and Pearson, one-sided).
    pub upper_limit: f64,
    /// log10 of the largest capital of all runs.
    pub largest_evidence: f64,
    /// Pass: the upper limit is at or below α. Fail: so many alarms would come by chance in less than 1 of 20
    /// calibrations of a gate that keeps α.
    pub verdict: Verdict,
}

/// Counts of one property in one case.
#[derive(Clone, Debug)]
pub(super) struct Alarms {
    pub property: &'static str,
    pub case: String,
    runs: u64,
    counts: [u64; LEVELS.len()],
    largest: f64,
}

impl Alarms {
    pub fn new(property: &'static str, case: &str) -> Alarms {
        Alarms { property, case: case.to_owned(), runs: 0, counts: [0; LEVELS.len()], largest: f64::NEG_INFINITY }
    }

    /// Takes the evidence of one verdict, log10 of its capital.
    pub fn add(&mut self, evidence: f64) {
        self.runs += 1;
        for (count, level) in self.counts.iter_mut().zip(LEVELS) {
            *count += u64::from(evidence >= -level.log10());
        }
        self.largest = self.largest.max(evidence);
    }

    fn merge(&mut self, other: &Alarms) {
        self.runs += other.runs;
        for (count, more) in self.counts.iter_mut().zip(other.counts) {
            *count += more;
        }
        self.largest = self.largest.max(other.largest);
    }

    fn rows(&self, case: Option<&str>) -> impl Iterator<Item = AlarmRow> {
        LEVELS.into_iter().zip(self.counts).map(move |(level, alarms)| {
            let (count, runs) = (alarms as f64, self.runs as f64);
            let high = upper_limit(count, runs, LEVEL).unwrap_or(1.0);
            let low = lower_limit(count, runs, LEVEL).unwrap_or(0.0);
            AlarmRow {
                property: self.property,
                case: case.map(str::to_owned),
                level,
                runs: self.runs,
                alarms,
                rate: count / runs.max(1.0),
                upper_limit: high,
                largest_evidence: self.largest,
                verdict: if low > level {
                    Verdict::Fail
                } else if high <= level {
                    Verdict::Pass
                } else {
                    Verdict::Undecided
                },
            }
        })
    }
}

/// First all cases together, then each, for every property in the order of its first appearance.
pub(super) fn rows(counted: &[Alarms]) -> Vec<AlarmRow> {
    let mut properties: Vec<&'static str> = Vec::new();
    for alarms in counted {
        if !properties.contains(&alarms.property) {
            properties.push(alarms.property);
        }
    }
    let mut rows = Vec::new();
    for property in properties {
        let of_it = || counted.iter().filter(|alarms| alarms.property == property);
        let mut all = Alarms::new(property, "");
        of_it().for_each(|alarms| all.merge(alarms));
        rows.extend(all.rows(None));
        for alarms in of_it() {
            rows.extend(alarms.rows(Some(&alarms.case)));
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gate_that_cries_wolf_is_found_out() {
        let verdicts = |alarms: u64, runs: u64, evidence: f64| {
            let mut counted = Alarms::new("bias", "room");
            (0..runs).for_each(|run| counted.add(if run < alarms { evidence } else { -0.5 }));
            rows(&[counted]).into_iter().filter(|row| row.case.is_none()).map(|row| row.verdict).collect::<Vec<_>>()
        };
        use Verdict::{Fail, Pass, Undecided};
        assert_eq!(verdicts(0, 30_000, 0.0), [Pass; 7]);
        assert_eq!(verdicts(0, 5_000, 0.0), [Pass, Pass, Pass, Pass, Pass, Undecided, Undecided]);
        // 35 of 30,000 at 10⁴ keep 3e-3, may keep 1e-3, and break the rest.
        assert_eq!(verdicts(35, 30_000, 4.0), [Pass, Pass, Pass, Pass, Undecided, Fail, Fail]);
        // The same at 10² say nothing of the levels below.
        assert_eq!(verdicts(35, 30_000, 2.0), [Pass; 7]);
    }

    #[test]
    fn cases_add_up() {
        let mut parts = [Alarms::new("bias", "a"), Alarms::new("bias", "b")];
        parts[0].add(1.0);
        parts[1].add(0.0);
        parts[1].add(5.0);
        let rows = rows(&parts);
        assert_eq!(rows.len(), 3 * LEVELS.len());
        assert_eq!((rows[0].runs, rows[0].alarms, rows[0].largest_evidence), (3, 2, 5.0));
        assert_eq!((rows[6].level, rows[6].alarms), (1e-4, 1));
        assert_eq!((rows[7].case.as_deref(), rows[7].runs, rows[7].alarms), (Some("a"), 1, 1));
    }
}
