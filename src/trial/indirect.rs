//! Eye paths judged: light that has come by mirrors, glass and diffuse surfaces, at the points where the exact side knows it;
//! and what eye paths cost beside the caustic map.
//!
//! No variance of an eye path can be predicted exactly, but a bound can: its mean square obeys an equation of the same form
//! as its mean ([`RoomLight::largest_mean_square`]). The gate takes any variance from above, so a verdict leans on that bound
//! and on nothing measured, and says so.

use super::desk::Stage;
use super::onlooker::{Onlooker, Stopped};
use super::outcome::{JudgedProperty, PathOutcome, PathRow, Timing};
use super::pieces;
use crate::case::{Case, SmallestBias};
use crate::configuration::{Configuration, MeasurementPoint};
use crate::light::{Light, Moments};
use crate::oracle::optics::{Bounded, RoomLight, Way};
use crate::path::{Part, PathPoint, PathRun, PathSettings, PathTracer};
use crate::statistics::evidence::{THRESHOLD_LOG10, ln_average, log10_capped, replicates_for, smallest_shift};
use crate::statistics::interval::Z_95;
use crate::statistics::{Capital, Observed, Statement, Verdict};

/// What the sums of paths may be off by, relative to the mean.
const ROUNDING: f64 = 1e-12;
/// Of the brightest point: a point below it is shown, and no promise is made of it.
const WELL_LIT: f64 = 0.1;
/// Paths from each point, at least and at most.
const FEWEST: u64 = 1 << 12;
const MOST: u64 = 1 << 28;
/// Paths that measure how seldom the light is met, from all over the receiver.
const SURVEY: u64 = 1 << 18;
/// Where there is nothing to meet but lamps without extent.
const VAIN_SURVEY: u64 = 1 << 14;
/// Rays of the map that is compared with eye paths, of those that the case asks for.
const COMPARED: u64 = 8;

/// The names of both estimators, in tables.
const NAMES: [&str; 2] = ["eye_paths", "next_event"];

/// Follows eye paths through one case, and judges them.
///
/// - `onlooker`: told of the paths; where it errs, the case is given up
/// - `None` where no light is bent and no diffuse surface lights another; or where all of it is somebody else's
pub(super) fn indirect(
    case: &Case,
    seed: u64,
    quick: bool,
    smallest: SmallestBias,
    reproduce: &str,
    onlooker: &Onlooker,
) -> Result<Option<PathOutcome>, Stopped> {
    let room = &case.configuration;
    let mut outcome = PathOutcome::default();
    if let Some(due) = Due::found(room, || onlooker.goes_on())? {
        let smallest = due.promised(smallest);
        for next_event in [false, true] {
            let Some(spreads) = due.spreads(next_event) else {
                // Shown all the same: how often a source is met.
                if let Some((run, _)) = pieces::paths(case, seed, VAIN_SURVEY, next_event, onlooker)? {
                    outcome.rows.extend(rows(room, &due, None, &run, next_event));
                }
                continue;
            };
            let planned = due.planned(&spreads, smallest);
            let Some((run, seconds)) = pieces::paths(case, seed, planned, next_event, onlooker)? else { continue };
            outcome.rows.extend(rows(room, &due, Some(&spreads), &run, next_event));
            outcome.timings.push(timing(&due, &run, next_event, seconds));
            let judged = judge(&due, &spreads, &run, smallest, reproduce);
            outcome.verdicts.push((NAMES[usize::from(next_event)], judged));
        }
    }
    if room.has_optics() {
        against_the_map(case, seed, quick, &mut outcome, onlooker)?;
    }
    Ok((!outcome.rows.is_empty()).then_some(outcome))
}

/// Paths from each point; `None` where none are followed.
pub(super) fn planned_paths(case: &Case, next_event: bool, smallest: SmallestBias) -> Option<u64> {
    let Ok(due) = Due::found(&case.configuration, || Ok::<(), std::convert::Infallible>(()));
    let due = due?;
    Some(due.spreads(next_event).map_or(VAIN_SURVEY, |spreads| due.planned(&spreads, due.promised(smallest))))
}

/// Paths from all over the receiver.
pub(super) fn surveyed(can_reach: bool, quick: bool) -> u64 {
    if can_reach && !quick { SURVEY } else { VAIN_SURVEY }
}

/// Rays of the map that is compared with them.
pub(super) fn compared(case: &Case, quick: bool) -> u64 {
    (case.light.rays / if quick { 16 * COMPARED } else { COMPARED }).max(1)
}

/// What is due at the points of a case.
struct Due<'a> {
    light: RoomLight,
    points: &'a [MeasurementPoint],
    part: Part,
    /// One for each point, W/m².
    exact: Vec<Bounded>,
}

impl Due<'_> {
    /// `None` where there is nothing to measure, or the exact side does not know it at every point.
    ///
    /// - `goes_on`: asked between points
    fn found<E>(room: &Configuration, goes_on: impl Fn() -> Result<(), E>) -> Result<Option<Due<'_>>, E> {
        let light = RoomLight::new(room);
        let Some(way) = light.judged() else { return Ok(None) };
        let mut exact: Vec<Bounded> = Vec::new();
        for point in room.points() {
            goes_on()?;
            let Some(due) = light.at(point).by(way) else { return Ok(None) };
            exact.push(due);
        }
        if exact.iter().all(|due| due.value == 0.0) {
            return Ok(None);
        }
        let part = match way {
            Way::Total => Part::Total,
            Way::Caustic => Part::Caustic,
            Way::Indirect => Part::Indirect,
        };
        Ok(Some(Due { light, points: room.points(), part, exact }))
    }

    /// Bounds of one path's variance at each point, W²/m⁴.
    fn spreads(&self, next_event: bool) -> Option<Vec<f64>> {
        let spread = |(point, due): (&MeasurementPoint, &Bounded)| {
            let square = self.light.largest_mean_square(next_event, point)?;
            // The mean square is a bound, and may fall short of the mean's by its rounding.
            Some((square - due.value * due.value).max(0.0) + ROUNDING * square)
        };
        self.points.iter().zip(&self.exact).map(spread).collect()
    }

    /// What a pass has to have seen. Eye paths seldom find a source in a mirror: to tell a caustic to a per cent would take a
    /// hundred times the paths that tell it to a tenth, and a map does it at once.
    fn promised(&self, smallest: SmallestBias) -> SmallestBias {
        match self.part {
            Part::Caustic => SmallestBias { mean: 10.0 * smallest.mean, point: 5.0 * smallest.point },
            Part::Total | Part::Indirect => smallest,
        }
    }

    fn mean(&self) -> Bounded {
        let n = self.exact.len() as f64;
        let sum = |value: fn(&Bounded) -> f64| self.exact.iter().map(value).sum::<f64>() / n;
        Bounded { value: sum(|due| due.value), bound: sum(|due| due.bound) }
    }

    fn is_well_lit(&self, point: usize) -> bool {
        let brightest = self.exact.iter().map(|due| due.value).fold(0.0, f64::max);
        self.exact[point].value >= WELL_LIT * brightest
    }

    /// Points, and their mean.
    fn components(&self) -> usize {
        self.exact.len() + 1
    }

    /// Paths from each point that would show the smallest bias.
    fn planned(&self, spreads: &[f64], smallest: SmallestBias) -> u64 {
        let n = self.components();
        let of_points = spreads.iter().enumerate().filter(|(k, _)| self.is_well_lit(*k));
        let of_points = of_points.map(|(k, spread)| replicates_for(smallest.point * self.exact[k].value, *spread, n));
        let of_mean = replicates_for(smallest.mean * self.mean().value, mean_spread(spreads), n);
        let most = (MOST / self.exact.len() as u64).max(FEWEST);
        // A tenth more, since the shift that is told includes the exact side's bound.
        let paths = of_points.fold(of_mean, u64::max).min(most);
        (paths + paths / 10).clamp(FEWEST, most)
    }
}

/// Of the mean over points whose paths are independent.
fn mean_spread(spreads: &[f64]) -> f64 {
    let n = spreads.len() as f64;
    spreads.iter().sum::<f64>() / (n * n)
}

/// That paths find a mean, and what they found.
struct Claim {
    statement: Statement,
    observed: Observed,
    n: u64,
}

impl Claim {
    fn new(due: Bounded, spread: f64, found: &Moments, n: u64) -> Claim {
        let margin = due.bound + ROUNDING * due.value;
        let observed = Observed { n, pivot: 0.0, sum: found.watts(), sum_of_squares: found.squares };
        Claim { statement: Statement::near(due.value, margin, spread), observed, n }
    }
    fn capital(&self) -> f64 {
        Capital::of(&self.statement, &self.observed, self.n).ln()
    }
    fn due(&self) -> f64 {
        0.5 * (self.statement.low + self.statement.high)
    }
    /// The relative deviation that would have been caught.
    fn seen(&self, components: usize) -> f64 {
        let margin = 0.5 * (self.statement.high - self.statement.low);
        (smallest_shift(self.statement.variance, self.n, components) + margin) / self.due()
    }
    /// Relative deviation, and its standard error by the stated variance; where nothing is due, W/m².
    fn deviation(&self) -> (f64, f64) {
        let n = self.n.max(1) as f64;
        let (off, error) = (self.observed.sum / n - self.due(), (self.statement.variance / n).sqrt());
        if self.due() > 0.0 { (off / self.due(), error / self.due()) } else { (off, error) }
    }
}

/// One claim for each point, and one for their mean, which comes last.
fn claims(due: &Due, spreads: &[f64], run: &PathRun) -> Vec<Claim> {
    let claim = |exact: Bounded, spread: f64, found: &PathPoint| {
        Claim::new(exact, spread, &found.moments(due.part), run.paths)
    };
    let points = due.exact.iter().zip(spreads).zip(&run.points);
    let mut claims: Vec<Claim> = points.map(|((exact, spread), found)| claim(*exact, *spread, found)).collect();
    claims.push(claim(due.mean(), mean_spread(spreads), &run.mean));
    claims
}

fn judge(due: &Due, spreads: &[f64], run: &PathRun, smallest: SmallestBias, reproduce: &str) -> JudgedProperty {
    let claims = claims(due, spreads, run);
    let (m, last) = (due.components(), claims.len() - 1);
    let capitals: Vec<f64> = claims.iter().map(Claim::capital).collect();
    let evidence = log10_capped(ln_average(capitals.iter().copied()));
    let mean = claims[last].seen(m);
    let well_lit = claims[..last].iter().enumerate().filter(|(k, _)| due.is_well_lit(*k));
    let worst = well_lit.map(|(_, claim)| claim.seen(m)).reduce(f64::max);
    let cut = run.mean.terminated;
    let verdict = if evidence >= THRESHOLD_LOG10 {
        Verdict::Fail
    } else if cut == 0 && mean <= smallest.mean && worst.is_none_or(|worst| worst <= smallest.point) {
        Verdict::Pass
    } else {
        Verdict::Undecided
    };
    let strongest = (0..claims.len()).max_by(|a, b| capitals[*a].total_cmp(&capitals[*b])).unwrap_or(last);
    let shown = if verdict == Verdict::Fail { strongest } else { last };
    let (effect, error) = claims[shown].deviation();
    let place = if shown == last { "in the mean".to_owned() } else { format!("at point {shown}") };
    let what = match due.part {
        Part::Total => "all light",
        Part::Caustic => "light by the mirror",
        Part::Indirect => "indirect light",
    };
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    let bar = worst.map_or(String::new(), |worst| format!(", {} at the worst point", percent(worst)));
    let words = match verdict {
        Verdict::Fail => {
            format!("{:+.2} % ± {:.2} % of the {what} that is due {place}", 100.0 * effect, 100.0 * Z_95 * error)
        }
        Verdict::Pass => {
            format!("no deviation of {what} above {} in the mean{bar}; variances by an upper bound", percent(mean))
        }
        Verdict::Undecided if cut > 0 => {
            format!("{cut} paths reached the limit of their length: what they would have found is missing")
        }
        Verdict::Undecided => {
            format!("too few paths: a deviation of {what} of {} in the mean would have been seen{bar}", percent(mean))
        }
    };
    JudgedProperty {
        property: "indirect",
        verdict,
        evidence,
        threshold: THRESHOLD_LOG10,
        effect,
        effect_low: effect - Z_95 * error,
        effect_high: effect + Z_95 * error,
        smallest_bias_mean: Some(mean),
        smallest_bias_point: worst,
        words,
        note: None,
        reproduce: reproduce.to_owned(),
    }
}

/// One row for each point.
fn rows(room: &Configuration, due: &Due, spreads: Option<&[f64]>, run: &PathRun, next_event: bool) -> Vec<PathRow> {
    let points = run.points.iter().enumerate().map(|(k, found)| {
        let spread = spreads.map(|spreads| spreads[k]);
        let verdict = spread.map(|spread| {
            let claim = Claim::new(due.exact[k], spread, &found.moments(due.part), run.paths);
            if log10_capped(claim.capital()) >= THRESHOLD_LOG10 {
                Verdict::Fail
            } else if due.exact[k].value > 0.0 && claim.seen(1) > 1.0 {
                Verdict::Undecided
            } else {
                Verdict::Pass
            }
        });
        PathRow {
            estimator: NAMES[usize::from(next_event)],
            point: Some((k, room.points()[k].position())),
            part: due.part.name(),
            paths: run.paths,
            reached_share: Some(found.reached(due.part) as f64 / run.paths as f64),
            measured: found.mean(due.part, run.paths),
            std_error: found.variance(due.part, run.paths).map(|v| (v / run.paths as f64).sqrt()),
            exact: Some(due.exact[k].value),
            bound: Some(due.exact[k].bound),
            variance: found.variance(due.part, run.paths),
            largest_variance: spread,
            verdict,
        }
    });
    points.collect()
}

fn timing(due: &Due, run: &PathRun, next_event: bool, seconds: f64) -> Timing {
    let n = run.points.len() as f64;
    let variance = run.points.iter().filter_map(|found| found.variance(due.part, run.paths)).sum::<f64>() / n;
    let cost = variance * seconds / (run.paths as f64 * n);
    let stage = NAMES[usize::from(next_event)];
    Timing { stage, rays: run.segments, seconds, efficiency: (cost > 0.0).then(|| 1.0 / cost) }
}

/// The same question to eye paths and to the map: what comes to the receiver by mirrors and glass?
///
/// Paths leave from all over the receiver, as they would to fill its texels. Efficiencies are of a picture with the map's
/// texels, one over (mean variance of a texel × time).
fn against_the_map(
    case: &Case,
    seed: u64,
    quick: bool,
    outcome: &mut PathOutcome,
    onlooker: &Onlooker,
) -> Result<(), Stopped> {
    let room = &case.configuration;
    if room.receiver().is_none() {
        return Ok(());
    }
    let tracer = PathTracer::new(room, &PathSettings::default(), seed);
    let survey = surveyed(tracer.can_reach(), quick);
    let eye = pieces::survey(&tracer, survey, onlooker)?;
    let rays = compared(case, quick);
    let run = pieces::light(case, seed, rays, Stage::Compared, onlooker)?;
    let (Some((eye, eye_seconds)), Some((run, map_seconds))) = (eye, run) else { return Ok(()) };
    // The receiver's is the first map.
    let Some(map) = run.maps.first() else { return Ok(()) };
    let (mut area, mut texels, mut flux, mut variance, mut square) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for texel in map.grid().texels() {
        let own = map.area(texel);
        if own <= 0.0 {
            continue;
        }
        let found = map.moments(texel, Light::Bent);
        area += own;
        texels += 1.0;
        flux += found.watts();
        variance += found.variance(map.n_groups()).unwrap_or(0.0) / own;
        square += found.watts() * found.watts() / own;
    }
    let (variance, square) = (variance / area, square / area);
    let moments = eye.mean.moments(Part::Caustic);
    let mean_square = moments.squares / eye.paths as f64;
    let of_eye = (mean_square - square).max(0.0) * texels / eye.paths as f64;
    let efficiency = |variance: f64, seconds: f64| {
        let cost = variance * seconds;
        (cost > 0.0).then(|| 1.0 / cost)
    };
    outcome.timings.push(Timing {
        stage: "caustic_by_eye_paths",
        rays: eye.paths,
        seconds: eye_seconds,
        efficiency: efficiency(of_eye, eye_seconds),
    });
    outcome.timings.push(Timing {
        stage: "caustic_by_map",
        rays: run.ledger.rays,
        seconds: map_seconds,
        efficiency: efficiency(variance, map_seconds),
    });
    let eye_variance = eye.mean.variance(Part::Caustic, eye.paths);
    let part = Part::Caustic.name();
    let nowhere = PathRow {
        estimator: NAMES[0],
        point: None,
        part,
        paths: eye.paths,
        reached_share: Some(eye.mean.reached(Part::Caustic) as f64 / eye.paths as f64),
        measured: eye.mean.mean(Part::Caustic, eye.paths),
        std_error: eye_variance.map(|variance| (variance / eye.paths as f64).sqrt()),
        exact: None,
        bound: None,
        variance: eye_variance,
        largest_variance: None,
        verdict: None,
    };
    let of_orders = (1..=run.depth()).filter_map(|order| run.deposited(0, order).variance(run.ledger.groups));
    let of_map = PathRow {
        estimator: "light_map",
        paths: run.ledger.rays,
        reached_share: None,
        measured: flux / area,
        std_error: Some(of_orders.sum::<f64>().sqrt() / area),
        variance: None,
        ..nowhere.clone()
    };
    outcome.rows.extend([nowhere, of_map]);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::shipped;
    use crate::path::Weighing;
    use crate::statistics::budget::seed_of;

    const SMALLEST: SmallestBias = SmallestBias { mean: 3e-2, point: 3e-1 };

    fn case(name: &str) -> Case {
        shipped().find(|case| case.name() == name).unwrap().read().unwrap()
    }

    fn alone(room: &Configuration) -> Option<Due<'_>> {
        let Ok(due) = Due::found(room, || Ok::<(), std::convert::Infallible>(()));
        due
    }

    fn verdict(name: &str, next_event: bool, weighing: &impl Weighing) -> Verdict {
        let case = case(name);
        let due = alone(&case.configuration).unwrap();
        let spreads = due.spreads(next_event).unwrap();
        let settings = PathSettings { next_event, ..PathSettings::default() };
        let tracer = PathTracer::new(&case.configuration, &settings, seed_of("planted faults of eye paths"));
        let run = tracer.at_points_weighing(due.planned(&spreads, SMALLEST), weighing);
        judge(&due, &spreads, &run, SMALLEST, "").verdict
    }

    struct Sound;
    impl Weighing for Sound {}

    /// The survivors' weight is not raised.
    struct RouletteForgotten;
    impl Weighing for RouletteForgotten {
        fn survived(&self, weight: f64, _: f64) -> f64 {
            weight
        }
    }

    /// A source met by chance counts although shadow rays have counted it.
    struct CountedTwice;
    impl Weighing for CountedTwice {
        fn counts(&self, _: bool, _: bool) -> bool {
            true
        }
    }

    struct AlbedoSquared;
    impl Weighing for AlbedoSquared {
        fn sent_on(&self, weight: f64, share: f64) -> f64 {
            weight * share * share
        }
    }

    const ROOMS: [&str; 3] =
        ["interreflection/furnace", "interreflection/coaxial-disks", "interreflection/facing-plates"];

    #[test]
    fn planted_faults_are_found() {
        for name in ROOMS {
            for next_event in [false, true] {
                assert_eq!(verdict(name, next_event, &Sound), Verdict::Pass, "{name} {next_event}");
                assert_eq!(verdict(name, next_event, &RouletteForgotten), Verdict::Fail, "{name} {next_event}");
                assert_eq!(verdict(name, next_event, &AlbedoSquared), Verdict::Fail, "{name} {next_event}");
            }
            assert_eq!(verdict(name, true, &CountedTwice), Verdict::Fail, "{name}");
        }
        for name in ["interreflection/lit-sphere", "interreflection/lampshade"] {
            assert_eq!(verdict(name, true, &Sound), Verdict::Pass, "{name}");
            assert_eq!(verdict(name, true, &RouletteForgotten), Verdict::Fail, "{name}");
            assert_eq!(verdict(name, true, &AlbedoSquared), Verdict::Fail, "{name}");
        }
        // Behind glass what is met by chance is all there is: counting the straight ones too is too much, as elsewhere.
        assert_eq!(verdict("interreflection/furnace-with-glass", true, &CountedTwice), Verdict::Fail);
    }

    /// What is taken for an upper bound of the variance is one, and not a bad one.
    #[test]
    fn variances_are_below_their_bounds() {
        for shipped in shipped().filter(|case| case.name().starts_with("interreflection/")) {
            let case = shipped.read().unwrap();
            let Some(due) = alone(&case.configuration) else { continue };
            for next_event in [false, true] {
                let settings = PathSettings { next_event, ..PathSettings::default() };
                let tracer = PathTracer::new(&case.configuration, &settings, seed_of("variances_are_below"));
                let Some(spreads) = due.spreads(next_event) else {
                    continue;
                };
                let run = tracer.at_points(1 << 15);
                for (found, spread) in run.points.iter().zip(&spreads) {
                    let measured = found.variance(due.part, run.paths).unwrap();
                    // Its own spread is a few per cent.
                    assert!(measured <= 1.1 * spread, "{} {next_event}: {measured} {spread}", case.name);
                    println!("{} {next_event}: {:.3} of the bound", case.name, measured / spread);
                }
            }
        }
    }
}
