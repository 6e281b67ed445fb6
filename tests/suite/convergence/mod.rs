//! The convergence studies: for every shipped case of direct light, the bias and the rates of the three strategies of the lecture; in
//! [`strategies`] a few rooms under each of the others.
//!
//! Each case is a test by being shipped. Its study leaves its tables and variance curves in `reports/convergence/<case>/`
//! before anything is asserted, so that the evidence is there whether the test passes or fails. [`check`] holds the
//! assertions.

mod strategies;

use std::path::{Path, PathBuf};

use etendue::case::{Case, Replicates, SmallestBias, shipped_direct};
use etendue::oracle::Region;
use etendue::report::{self, ReportOptions};
use etendue::sampling::Strategy;
use etendue::statistics::Verdict;
use etendue::trial::{self, CaseOutcome, Effort, Overrides, Rate, RatePoint, Settings, StrategyOutcome};

/// One test for each case, and the list of them.
macro_rules! cases {
    ($($test:ident: $name:literal,)*) => {
        $(#[test] fn $test() { check($name); })*
        const CASES: &[&str] = &[$($name),*];
    };
}

cases! {
    diffuser_box_converges: "direct/diffuser-box",
    disk_over_plane_converges: "direct/disk-over-plane",
    disk_receiver_converges: "direct/disk-receiver",
    half_sunk_source_converges: "direct/half-sunk-source",
    l_shaped_source_converges: "direct/l-shaped-source",
    rectangle_over_plane_converges: "direct/rectangle-over-plane",
    sphere_receiver_converges: "direct/sphere-receiver",
    sphere_source_converges: "direct/sphere-source",
    tilted_source_converges: "direct/tilted-source",
    triangle_source_converges: "direct/triangle-source",
    turning_patch_converges: "direct/turning-patch",
    two_sources_converges: "direct/two-sources",
    annular_eclipse_converges: "penumbra/annular-eclipse",
    contact_shadow_converges: "penumbra/contact-shadow",
    eclipse_converges: "penumbra/eclipse",
    eclipse_at_sunset_converges: "penumbra/eclipse-at-sunset",
    eclipse_closing_converges: "penumbra/eclipse-closing",
    eclipse_mesh_converges: "penumbra/eclipse-mesh",
    half_plane_converges: "penumbra/half-plane",
    l_shaped_occluder_converges: "penumbra/l-shaped-occluder",
    overlapping_occluders_converges: "penumbra/overlapping-occluders",
    rectangle_behind_rectangle_converges: "penumbra/rectangle-behind-rectangle",
    sphere_occluder_converges: "penumbra/sphere-occluder",
    spheres_converges: "penumbra/spheres",
    three_regions_converges: "penumbra/three-regions",
    tilted_occluder_converges: "penumbra/tilted-occluder",
    two_shadows_converges: "penumbra/two-shadows",
    blended_panel_converges: "texture/blended-panel",
    checker_panel_converges: "texture/checker-panel",
    globe_converges: "texture/globe",
    picture_panel_converges: "texture/picture-panel",
    sectors_converges: "texture/sectors",
    slanted_triangle_converges: "texture/slanted-triangle",
    tiled_ball_converges: "texture/tiled-ball",
}

#[test]
fn every_shipped_case_is_studied() {
    assert_eq!(shipped_direct().map(|case| case.name()).collect::<Vec<_>>(), CASES);
}

/// Half-widths of a 95 % interval that a measured rate may lie off: over all cases, strategies, regions and sample counts
/// about 1500 intervals are asked, from 32 batches each (Student's t with 31 degrees of freedom). At 5.4 standard
/// errors, 2.75 times the normal 1.96, the chance that any of them errs is below 1e-2; seeds are fixed, so that it is
/// drawn once and not at every run.
const WIDENED: f64 = 2.75;

/// What a pass must have been able to see here: the biases of a quick run, in a second or so a case.
const COARSE: SmallestBias = SmallestBias { mean: 0.05, point: 0.5 };

/// Studies one case, leaves the evidence, and asserts what must hold of any case.
fn check(name: &str) {
    let case = read(name);
    let outcome = match name {
        // A hundred thousand triangles: a ray costs a hundred times as much.
        "penumbra/eclipse-mesh" => study(&case, name, vec![1, 4, 16], SmallestBias { mean: 0.1, point: 1.0 }),
        _ => study(&case, name, vec![1, 4, 16, 64, 256], COARSE),
    };
    let strategies: Vec<_> = outcome.strategies.iter().map(|s| s.strategy).collect();
    assert_eq!(strategies, Strategy::LECTURE, "{name}");
    for strategy in &outcome.strategies {
        unbiased(name, strategy);
        numbers_are_sound(&outcome, strategy);
        slopes_are_those_of_theory(&outcome, strategy);
    }
    let [random, correlated, stratified] = &outcome.strategies[..] else { panic!("three strategies") };
    for ((random, correlated), stratified) in random.rates.iter().zip(&correlated.rates).zip(&stratified.rates) {
        for ((r, c), s) in random.points.iter().zip(&correlated.points).zip(&stratified.points) {
            let place = format!("{name}, {}, N = {}", region_name(random.region), r.samples);
            let same = standard_errors_apart(r, c);
            assert!(same.abs() < 1.96 * WIDENED, "{place}: sharing points moves no variance: {r:?} {c:?}");
            // Strata of equal area never lose (the variance between them is gone); one stratum is none.
            let gained = standard_errors_apart(r, s);
            let enough = if r.samples == 1 { gained.abs() < 1.96 * WIDENED } else { gained > -1.96 * WIDENED };
            assert!(enough, "{place}: stratifying loses: {r:?} {s:?}");
        }
    }
}

/// How many standard errors the first value of a rate lies above the second, on the logarithmic scale.
fn standard_errors_apart(a: &RatePoint, b: &RatePoint) -> f64 {
    let error = |point: &RatePoint| (point.high / point.low).ln() / (2.0 * 1.96);
    (a.value / b.value).ln() / error(a).hypot(error(b)).max(f64::MIN_POSITIVE)
}

fn unbiased(name: &str, strategy: &StrategyOutcome) {
    assert!(!strategy.verdicts.is_empty(), "{name}: {} is judged", strategy.strategy);
    for judged in &strategy.verdicts {
        assert!(
            // A fixed number of replicates need not decide on variances.
            judged.verdict == Verdict::Pass || (judged.property != "bias" && judged.verdict == Verdict::Undecided),
            "{name}: {} {} of {}: {} (evidence 10^{:.2}, a failure from 10^{:.0})\nevidence: {}\nagain: {}",
            judged.property,
            judged.verdict,
            strategy.strategy,
            judged.words,
            judged.evidence,
            judged.threshold,
            folder(name).display(),
            judged.reproduce,
        );
    }
}

/// Finite intervals about every variance, and exactly nothing where nothing is due.
fn numbers_are_sound(outcome: &CaseOutcome, strategy: &StrategyOutcome) {
    for cell in &strategy.cells {
        for (point, (truth, measured)) in outcome.truths.iter().zip(&cell.points).enumerate() {
            let place = format!("{}: {} N = {} point {point}", outcome.name, strategy.strategy, cell.samples);
            let numbers = [measured.mean, measured.bias, measured.bias_std_error, measured.variance, measured.mse];
            assert!(numbers.iter().all(|x| x.is_finite()), "{place}: {measured:?}");
            if let Some(interval) = measured.variance_interval {
                assert!(0.0 <= interval.low && interval.contains(measured.variance), "{place}: {measured:?}");
            }
            if matches!(truth.region, Region::Umbra | Region::BelowHorizon) {
                assert_eq!(truth.irradiance.watts_per_square_metre(), 0.0, "{place}");
                assert_eq!(numbers, [0.0; 5], "{place}: light where none is due");
            } else if truth.region == Region::Lit {
                let seen = measured.mean > 0.0 && measured.variance > 0.0 && measured.variance_interval.is_some();
                assert!(seen, "{place}: no light where all is due");
            }
        }
    }
}

fn slopes_are_those_of_theory(outcome: &CaseOutcome, strategy: &StrategyOutcome) {
    assert!(!strategy.rates.is_empty(), "{}: {} has a rate", outcome.name, strategy.strategy);
    for rate in &strategy.rates {
        let place = format!(
            "{}: {} over {} points falls as N^{:.3} ({:.3} to {:.3}); evidence: {}",
            outcome.name,
            strategy.strategy,
            region_name(rate.region),
            rate.slope,
            rate.slope_low,
            rate.slope_high,
            folder(&outcome.name).display()
        );
        assert!(rate.slope_low <= rate.slope && rate.slope <= rate.slope_high, "{place}");
        // The same fit of the predicted variances: exactly −1 for a mean of N independent terms.
        let allowed = WIDENED * 0.5 * (rate.slope_high - rate.slope_low);
        assert!((rate.slope - rate.expected_slope).abs() <= allowed, "{place}, not as N^{:.3}", rate.expected_slope);
        assert_ne!(rate.verdict, Some(Verdict::Fail), "{place}");
        if strategy.strategy != Strategy::Stratified {
            assert!((rate.expected_slope + 1.0).abs() < 1e-9, "{place}");
        }
    }
}

fn region_name(region: Option<Region>) -> &'static str {
    region.map_or("all lit", Region::name)
}

#[test]
fn strata_gain_a_whole_power_where_the_light_is_smooth() {
    let outcome = study_of("disk-far-out", OVER_A_PLANE, vec![64, 256, 1024, 4096]);
    let [random, correlated, stratified] = slopes(&outcome);
    assert!((random + 1.0).abs() < 0.05 && (correlated + 1.0).abs() < 0.1, "{random} {correlated}");
    // The asymptote: the jitter within a stratum sees a linear integrand, whose variance is as its area squared.
    assert!((stratified + 2.0).abs() < 0.05, "{stratified}");
}

#[test]
fn an_edge_takes_half_a_power_from_the_strata() {
    let half_plane = r#"
        [[occluder.rectangle]]
        center = [-5.0, 0.0, 1.0]
        edge_u = [10.0, 0.0, 0.0]
        edge_v = [0.0, 20.0, 0.0]
    "#;
    let outcome = study_of("edge-far-out", &format!("{OVER_A_PLANE}{half_plane}"), vec![16, 64, 256, 1024, 4096]);
    let cut = outcome.truths.iter().filter(|truth| truth.shadow_edge).count();
    assert_eq!(cut, outcome.truths.len(), "the edge cuts the source for every point");
    let [random, _, stratified] = slopes(&outcome);
    assert!((random + 1.0).abs() < 0.05, "{random}");
    // √N of the N strata are cut, each as noisy as before: N^(1/2) · N^(−2).
    assert!((stratified + 1.5).abs() < 0.05, "{stratified}");
}

#[test]
fn counts_that_are_no_squares_converge_as_well() {
    let outcome = study_of("odd-counts", OVER_A_PLANE, vec![2, 3, 5, 7, 12, 37, 200]);
    let [random, correlated, stratified] = slopes(&outcome);
    assert!((random + 1.0).abs() < 0.05 && (correlated + 1.0).abs() < 0.1, "{random} {correlated}");
    assert!((-2.1..-1.75).contains(&stratified), "{stratified}");
    for strategy in &outcome.strategies {
        unbiased("odd-counts", strategy);
    }
}

#[test]
fn shared_points_err_together_and_fresh_ones_do_not() {
    let outcome = study_of("errors-together", OVER_A_PLANE, vec![1, 16]);
    for strategy in &outcome.strategies {
        let counts = strategy.cells.iter().map(|cell| cell.samples);
        for samples in counts {
            let near = strategy.correlations.iter().filter(|c| c.samples == samples);
            let near = near.min_by(|a, b| a.separation.total_cmp(&b.separation)).expect("pairs of neighbours");
            let place = format!("{} N = {samples}: {near:?}", strategy.strategy);
            assert!(near.low <= near.correlation && near.correlation <= near.high, "{place}");
            if strategy.strategy.shares_points() {
                // Neighbours 12.5 mm apart, 2 m below the same points of the source.
                assert!(near.low > 0.95, "{place}");
            } else {
                let half = 0.5 * (near.high - near.low);
                assert!(near.correlation.abs() < WIDENED * half && half < 0.1, "{place}");
            }
        }
    }
    // What that means: the mean over the points gains nothing from their number.
    let mean_error = |s: usize| {
        let cell = outcome.strategies[s].cells.last().expect("cells");
        cell.mean_bias_std_error * (cell.replicates as f64).sqrt()
    };
    let ratio = mean_error(1) / mean_error(0);
    let points = (outcome.points.len() as f64).sqrt();
    assert!(ratio > 0.8 * points && ratio < 1.2 * points, "{ratio}, with {points} squared points");
}

/// A disk over five points of a floor.
const OVER_A_PLANE: &str = r#"
    [[source.disk]]
    center = [0.0, 0.0, 2.0]
    normal = [0.0, 0.0, -1.0]
    radius = 0.5
    exitance = 3.0
    [receiver.rectangle]
    center = [0.0, 0.0, 0.0]
    edge_u = [2.0, 0.0, 0.0]
    edge_v = [0.0, 2.0, 0.0]
    [measure]
    line = { from = [0.1, 0.2, 0.0], to = [0.15, 0.2, 0.0], points = 5 }
"#;

fn slopes(outcome: &CaseOutcome) -> [f64; 3] {
    let all = |s: &StrategyOutcome| -> f64 {
        let whole = |rate: &&Rate| rate.region.is_none();
        s.rates.iter().find(whole).expect("a rate over all points").slope
    };
    std::array::from_fn(|s| all(&outcome.strategies[s]))
}

fn read(name: &str) -> Case {
    let case = shipped_direct().find(|case| case.name() == name).unwrap_or_else(|| panic!("{name} is not shipped"));
    case.read().unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

/// Studies a case that is written down here, with enough replicates for slopes good to a hundredth (shared points: a fiftieth).
fn study_of(name: &str, text: &str, samples: Vec<u64>) -> CaseOutcome {
    let case = Case::from_toml(name, text).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    let overrides = Overrides {
        samples: Some(samples),
        replicates: Some(Replicates::Fixed(3000)),
        smallest_bias: Some(COARSE),
        ..Overrides::default()
    };
    study_with(&case, name, overrides)
}

/// Studies a case, coarsely enough for a second or so.
fn study(case: &Case, name: &str, samples: Vec<u64>, smallest_bias: SmallestBias) -> CaseOutcome {
    let overrides = Overrides {
        samples: Some(samples),
        smallest_bias: Some(smallest_bias),
        replicates: Some(Replicates::Auto),
        ..Overrides::default()
    };
    study_with(case, name, overrides)
}

fn study_with(case: &Case, name: &str, overrides: Overrides) -> CaseOutcome {
    let settings = Settings { seed: Settings::DEFAULT_SEED, effort: Effort::Standard, overrides };
    let mut outcome = trial::run(std::slice::from_ref(case), &settings, &|_| {}).expect("a run");
    let folder = folder(name);
    report::claim(&folder).expect("a folder for the evidence");
    let options = ReportOptions { generator: "as in `etendue run`", plots: true, views: &[], watched: false };
    report::write(&folder, &outcome, &options).expect("evidence on disk");
    outcome.cases.remove(0)
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/convergence").join(name)
}
