//! The judge for tests in code: hand over an implementation, get a verdict.

use std::fmt;
use std::panic::Location;

use crate::case::{Case, Replicates, SmallestBias};
use crate::estimator::{Guest, GuestEstimator, GuestPoints, IrradianceEstimator, PointSampler};
use crate::statistics::Verdict;
use crate::statistics::interval::Z_95;
use crate::trial::{
    CaseOutcome, Effort, Invitation, JudgedProperty, Leaning, NotJudged, Overrides, Settings, judge_guest,
};

/// Begins a judgement on a case, with the case's own study: sample counts, replicates, smallest bias.
#[track_caller]
pub fn judge(case: &Case) -> Judge<'_> {
    let overrides = Overrides::default();
    Judge {
        case,
        settings: Settings { seed: Settings::DEFAULT_SEED, effort: Effort::Standard, overrides },
        leaning: Leaning::Pilot,
        tolerance: None,
        place: Location::caller(),
    }
}

/// A judgement to come, and its terms.
#[derive(Clone, Debug)]
#[must_use = "nothing is judged yet"]
pub struct Judge<'a> {
    case: &'a Case,
    settings: Settings,
    leaning: Leaning,
    tolerance: Option<f64>,
    place: &'static Location<'static>,
}

impl Judge<'_> {
    /// Base of all random streams; 1 if nothing is said.
    pub fn seed(mut self, seed: u64) -> Self {
        self.settings.seed = seed;
        self
    }
    /// A quick look: five times coarser, at most 64 samples.
    pub fn quick(mut self) -> Self {
        self.settings.effort = Effort::Quick;
        self
    }
    /// Sample counts N ≥ 1 instead of the case's.
    pub fn samples(mut self, samples: &[u64]) -> Self {
        self.settings.overrides.samples = Some(samples.iter().map(|n| (*n).max(1)).collect());
        self
    }
    /// Independent repeats of every estimate; else as many as the smallest bias needs.
    pub fn replicates(mut self, replicates: u64) -> Self {
        self.settings.overrides.replicates = Some(Replicates::Fixed(replicates.max(2)));
        self
    }
    /// The relative biases that a pass must have been able to see: of the mean over the points, and at every point that a
    /// tenth of the light reaches.
    pub fn smallest_bias(mut self, mean: f64, point: f64) -> Self {
        self.settings.overrides.smallest_bias = Some(SmallestBias { mean, point });
        self
    }
    /// A relative deviation that is no fault: 1e-5 for an estimator that works in f32.
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }
    /// No pilot: you state that no estimate varies more than that of as many independent points by area.
    pub fn variance_at_most_random(mut self) -> Self {
        self.leaning = Leaning::Random;
        self
    }

    /// Judges points of the unit square; etendue puts them on the sources, by area.
    pub fn points(self, name: &str, sampler: &dyn PointSampler) -> Judgement {
        let points = GuestPoints::of_sampler(&self.case.configuration, sampler);
        self.judged(name, &points)
    }

    /// Judges a whole estimator of direct irradiance.
    pub fn estimator(self, name: &str, estimator: &dyn IrradianceEstimator) -> Judgement {
        let estimator = GuestEstimator::new(&self.case.configuration, estimator);
        self.judged(name, &estimator)
    }

    fn judged(self, name: &str, guest: &dyn Guest) -> Judgement {
        let reproduce = self.reproduce();
        let invitation = Invitation { name, leaning: self.leaning, reproduce: reproduce.clone() };
        let result = match self.tolerance {
            None => judge_guest(self.case, &self.settings, &invitation, guest),
            Some(tolerance) => {
                let mut case = self.case.clone();
                case.study.tolerance = tolerance;
                judge_guest(&case, &self.settings, &invitation, guest)
            }
        };
        Judgement { case: self.case.name.clone(), name: name.to_owned(), reproduce, result }
    }

    /// Where the test stands, its name where its thread bears it, and the options that move numbers.
    fn reproduce(&self) -> String {
        let place = format!("{}:{}", self.place.file(), self.place.line());
        let options = self.settings.options(None);
        match std::thread::current().name() {
            Some(test) if test != "main" => format!("cargo test {test} ({place}, with{options})"),
            _ => format!("{place} (with{options})"),
        }
    }
}

/// What came of it.
#[derive(Clone, Debug)]
#[must_use = "a verdict that nobody looks at finds no fault"]
pub struct Judgement {
    case: String,
    name: String,
    reproduce: String,
    result: Result<CaseOutcome, NotJudged>,
}

impl Judgement {
    /// `Fail` also where something was given that is no estimate; `Undecided` also where the case has nothing to judge.
    pub fn verdict(&self) -> Verdict {
        match &self.result {
            Ok(outcome) => outcome.strategies[0].verdicts[0].verdict,
            Err(NotJudged::Fault { .. }) => Verdict::Fail,
            Err(_) => Verdict::Undecided,
        }
    }

    /// The verdict in numbers; `None` where none could be had.
    pub fn judged(&self) -> Option<&JudgedProperty> {
        self.result.as_ref().ok().map(|outcome| &outcome.strategies[0].verdicts[0])
    }

    /// Everything that was measured, as reports show it.
    pub fn outcome(&self) -> Result<&CaseOutcome, NotJudged> {
        self.result.as_ref().map_err(Clone::clone)
    }

    /// Ends the test, with all that is known, unless the verdict is a pass.
    #[track_caller]
    pub fn assert_passes(&self) {
        assert!(self.verdict() == Verdict::Pass, "{self}");
    }
}

impl fmt::Display for Judgement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Judgement { case, name, reproduce, result } = self;
        let outcome = match result {
            Ok(outcome) => outcome,
            Err(why) => return write!(f, "{} {name} on {case}: {why}\n  again: {reproduce}", self.verdict()),
        };
        let judged = &outcome.strategies[0].verdicts[0];
        writeln!(f, "{} {name} on {case}: {}", judged.verdict, judged.words)?;
        for (what, found) in [("mean of all points", mean(outcome)), ("farthest off", farthest(outcome))] {
            let Some(Found { samples, place, estimate, std_error, exact, bound }) = found else { continue };
            writeln!(
                f,
                "  {what:<18}  estimate {estimate:.6e} ± {:.1e} W/m² (95 %), exact {exact:.6e} ± {bound:.1e} W/m²; N = {samples}{place}",
                Z_95 * std_error
            )?;
        }
        let percent = |x: Option<f64>| x.map_or("nothing".to_owned(), |x| format!("{:.2} %", 100.0 * x));
        writeln!(
            f,
            "  would be seen       {} in the mean, {} at the worst point (with 99 % probability)",
            percent(judged.smallest_bias_mean),
            percent(judged.smallest_bias_point)
        )?;
        writeln!(
            f,
            "  evidence            10^{:.1} against it; a failure from 10^{:.0}",
            judged.evidence, judged.threshold
        )?;
        if let Some(note) = &judged.note {
            writeln!(f, "  note                {note}")?;
        }
        write!(f, "  again               {reproduce}")
    }
}

/// One estimate beside its exact value, W/m².
struct Found {
    samples: u64,
    place: String,
    estimate: f64,
    std_error: f64,
    exact: f64,
    bound: f64,
}

impl Found {
    fn standard_errors(&self) -> f64 {
        let off = ((self.estimate - self.exact).abs() - self.bound).max(0.0);
        if off == 0.0 { 0.0 } else { off / self.std_error }
    }
}

/// The mean over the points at the sample count where it is farthest off, in standard errors.
fn mean(outcome: &CaseOutcome) -> Option<Found> {
    let n = outcome.truths.len() as f64;
    let sum = |of: &dyn Fn(usize) -> f64| (0..outcome.truths.len()).map(of).sum::<f64>() / n;
    let exact = sum(&|p| outcome.truths[p].irradiance.watts_per_square_metre());
    let bound = sum(&|p| outcome.truths[p].bound.watts_per_square_metre());
    let cells = outcome.strategies[0].cells.iter().map(|cell| Found {
        samples: cell.samples,
        place: String::new(),
        estimate: exact + cell.mean_bias,
        std_error: cell.mean_bias_std_error,
        exact,
        bound,
    });
    cells.max_by(|a, b| a.standard_errors().total_cmp(&b.standard_errors()))
}

/// The point and sample count where the estimate is farthest off, in standard errors.
fn farthest(outcome: &CaseOutcome) -> Option<Found> {
    let cells = outcome.strategies[0].cells.iter();
    let all = cells.flat_map(|cell| {
        cell.points.iter().enumerate().map(|(p, measured)| {
            let (x, truth) = (outcome.points[p].position(), &outcome.truths[p]);
            Found {
                samples: cell.samples,
                place: format!(", point {p} ({} m, {} m, {} m; {})", x.x, x.y, x.z, truth.region),
                estimate: measured.mean,
                std_error: measured.bias_std_error,
                exact: truth.irradiance.watts_per_square_metre(),
                bound: truth.bound.watts_per_square_metre(),
            }
        })
    });
    all.max_by(|a, b| a.standard_errors().total_cmp(&b.standard_errors()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Configuration, MeasurementPoint};
    use crate::sampling::Draws;

    fn eclipse() -> Case {
        Case::shipped("penumbra/eclipse").unwrap()
    }

    #[test]
    fn a_failure_says_all_there_is() {
        let squeezed = |draws: &mut Draws, points: &mut [[f64; 2]]| {
            points.fill_with(|| [0.9 * draws.unit(), draws.unit()]);
        };
        let judgement = judge(&eclipse()).quick().samples(&[4]).seed(7).points("squeezed", &squeezed);
        assert_eq!(judgement.verdict(), Verdict::Fail);
        let said = std::panic::catch_unwind(|| judgement.assert_passes()).unwrap_err();
        let said = said.downcast_ref::<String>().unwrap();
        for part in [
            "fail squeezed on penumbra/eclipse: squeezed is biased by",
            "estimate ",
            "exact ",
            "(95 %)",
            "would be seen ",
            "leans on a pilot",
            "a_failure_says_all_there_is",
            "judgement.rs:",
            "--seed 7",
        ] {
            assert!(said.contains(part), "{part}: {said}");
        }
    }

    #[test]
    fn too_little_is_undecided_and_no_number_is_a_failure() {
        let fair = |draws: &mut Draws, points: &mut [[f64; 2]]| points.fill_with(|| [draws.unit(), draws.unit()]);
        let few = judge(&eclipse()).replicates(8).samples(&[1]).points("few", &fair);
        assert_eq!(few.verdict(), Verdict::Undecided);
        assert!(few.to_string().contains("replicates would do"), "{few}");
        let none = |_: &Configuration, _: &MeasurementPoint, _: u64, _: &mut Draws| f64::NAN;
        let none = judge(&eclipse()).quick().estimator("none", &none);
        assert_eq!((none.verdict(), none.judged()), (Verdict::Fail, None));
        assert!(none.to_string().contains("gave NaN as the irradiance at point 0 (N = 1, replicate 0)"), "{none}");
        let dark = judge(&Case::shipped("caustic/cup").unwrap()).points("dark", &fair);
        assert_eq!(dark.verdict(), Verdict::Undecided);
        assert!(dark.to_string().contains("nothing to judge"), "{dark}");
    }
}
