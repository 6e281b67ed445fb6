//! Strategies beyond the lecture's three: unbiased, and with the variance that theory gives or bounds.

use etendue::case::Case;
use etendue::sampling::{PointSet, Strategy, Technique};
use etendue::statistics::Verdict;
use etendue::trial::{CaseOutcome, Overrides, RatePoint, StrategyOutcome};

use super::{
    COARSE, WIDENED, numbers_are_sound, read, slopes_are_those_of_theory, standard_errors_apart, study_with, unbiased,
};

/// Light, penumbra, umbra, an edge across the source, a source that turns away from itself.
const ROOMS: [&str; 4] =
    ["direct/rectangle-over-plane", "direct/sphere-source", "penumbra/eclipse", "penumbra/half-plane"];

macro_rules! strategies {
    ($($test:ident: $strategy:ident,)*) => {
        $(#[test] fn $test() { check(Strategy::$strategy); })*
        const TESTED: &[Strategy] = &[$(Strategy::$strategy),*];
    };
}

strategies! {
    uniform_jitter_converges: UniformJitter,
    latin_hypercube_converges: LatinHypercube,
    multi_jittered_converges: MultiJittered,
    sobol_converges: Sobol,
    solid_angle_converges: SolidAngle,
    cosine_converges: Cosine,
    mis_balance_converges: MisBalance,
    mis_power_converges: MisPower,
}

#[test]
fn every_strategy_is_studied() {
    let all: Vec<Strategy> = Strategy::LECTURE.iter().chain(TESTED).copied().collect();
    let untested = Strategy::ALL.iter().filter(|strategy| !all.contains(strategy));
    assert_eq!(untested.collect::<Vec<_>>(), Vec::<&Strategy>::new());
}

fn check(strategy: Strategy) {
    for room in ROOMS {
        let case = read(room);
        let outcome = studied(&case, &format!("{strategy}/{room}"), vec![Strategy::Random, strategy]);
        let [random, other] = &outcome.strategies[..] else { panic!("two strategies") };
        unbiased(&outcome.name, other);
        numbers_are_sound(&outcome, other);
        if strategy.technique() == Technique::Area {
            // A pilot plans these, and nothing is predicted: the asymptote stands in `rates.csv`, and theory bounds them.
            assert!(other.rates.iter().all(|rate| rate.verdict.is_none() && rate.expected_slope == rate.asymptote));
            no_worse_than_independent(&outcome, random, other);
        } else {
            slopes_are_those_of_theory(&outcome, other);
            assert!(other.rates.iter().all(|rate| rate.verdict == Some(Verdict::Pass)), "{room}: {:?}", other.rates);
        }
    }
}

/// Variance over that of independent points, at most: (N/(N − 1)) for Latin hypercubes (Owen 1997), 1 for strata, 2 for
/// scrambled nets of a power of two points in two dimensions (Owen 1997, base 2: (b/(b − 1))^(s − 1)). A shifted grid has no
/// such bound: all of it errs together.
fn no_worse_than_independent(outcome: &CaseOutcome, random: &StrategyOutcome, other: &StrategyOutcome) {
    let bound = |n: u64| match other.strategy.point_set() {
        PointSet::LatinHypercube => n as f64 / (n.max(2) - 1) as f64,
        PointSet::Sobol => 2.0,
        PointSet::MultiJittered => 1.0,
        _ => f64::INFINITY,
    };
    for (r, o) in random.rates.iter().zip(&other.rates) {
        for (r, o) in r.points.iter().zip(&o.points).filter(|(r, _)| r.samples > 1) {
            let bounded = RatePoint { value: r.value * bound(r.samples), low: r.low, high: r.high, ..*r };
            let above = standard_errors_apart(o, &bounded);
            assert!(above < 1.96 * WIDENED, "{}: {r:?} {o:?}", outcome.name);
        }
    }
}

fn studied(case: &Case, name: &str, strategies: Vec<Strategy>) -> CaseOutcome {
    let overrides = Overrides {
        strategies: Some(strategies),
        samples: Some(vec![1, 4, 16, 64, 256]),
        smallest_bias: Some(COARSE),
        ..Overrides::default()
    };
    study_with(case, name, overrides)
}

/// One shift for all cells of a grid on a square source, cut by one straight edge along its side: a whole row of cells
/// falls to either side of the edge at once (Ramamoorthi, Anderson, Meyer & Nowrouzezahrai, *A Theory of Monte Carlo
/// Visibility Sampling*, ACM Trans. Graph. 31, 2012, warn of it). N^(−1), where fresh jitter keeps N^(−3/2).
#[test]
fn uniform_jitter_falls_back_on_a_square_source_with_one_straight_edge() {
    let text = r#"
        [[source.rectangle]]
        center = [0.0, 0.0, 2.0]
        edge_u = [0.0, 1.0, 0.0]
        edge_v = [1.0, 0.0, 0.0]
        exitance = 3.0
        [[occluder.rectangle]]
        center = [-5.0, 0.0, 1.0]
        edge_u = [10.0, 0.0, 0.0]
        edge_v = [0.0, 20.0, 0.0]
        [receiver.rectangle]
        center = [0.0, 0.0, 0.0]
        edge_u = [2.0, 0.0, 0.0]
        edge_v = [0.0, 2.0, 0.0]
        [measure]
        line = { from = [-0.21, 0.0, 0.0], to = [0.23, 0.0, 0.0], points = 33 }
    "#;
    let case = Case::from_toml("straight-edge", text).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    let overrides = Overrides {
        strategies: Some(vec![Strategy::Stratified, Strategy::UniformJitter]),
        samples: Some(vec![16, 64, 256, 1024]),
        replicates: Some(etendue::case::Replicates::Fixed(1024)),
        smallest_bias: Some(COARSE),
    };
    let outcome = study_with(&case, "straight-edge", overrides);
    let slope = |s: usize| {
        let all = outcome.strategies[s].rates.iter().find(|rate| rate.region.is_none());
        all.expect("a rate over all points").slope
    };
    let (stratified, uniform) = (slope(0), slope(1));
    assert!((stratified + 1.5).abs() < 0.08, "{stratified}");
    assert!((uniform + 1.0).abs() < 0.08, "{uniform}");
}
