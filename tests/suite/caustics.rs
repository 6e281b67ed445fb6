//! Caustics judged: the shipped ones pass, and rooms that are not what they claim fail.

use etendue::case::{Case, shipped_caustics};
use etendue::statistics::Verdict;
use etendue::trial::{self, Effort, LightOutcome, Overrides, Settings};

fn judged(case: &Case) -> LightOutcome {
    let settings =
        Settings { seed: Settings::DEFAULT_SEED, effort: Effort::Standard, overrides: Overrides::default() };
    let outcome = trial::run(std::slice::from_ref(case), &settings, &|_| {}).expect("a run");
    outcome.cases.into_iter().next().and_then(|case| case.light).expect("light is followed")
}

fn shipped(name: &str) -> Case {
    let case = shipped_caustics().find(|case| case.name() == name).unwrap_or_else(|| panic!("{name} is not shipped"));
    case.read().unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

/// Cases whose rings (or whole receiver) have exact values.
const KNOWN: [&str; 7] = [
    "caustic/cup",
    "caustic/glass-ball",
    "caustic/paraboloid",
    "caustic/plane-mirror",
    "caustic/plano-convex",
    "caustic/slab",
    "caustic/spherical-mirror",
];

#[test]
fn the_shipped_caustics_pass() {
    for case in shipped_caustics() {
        let case = case.read().unwrap_or_else(|mistakes| panic!("{mistakes}"));
        let light = judged(&case);
        assert_eq!(light.rows.len(), 3, "{}", case.name);
        for judged in &light.verdicts {
            assert_eq!(judged.verdict, Verdict::Pass, "{} {}: {}", case.name, judged.property, judged.words);
        }
        let is_known = KNOWN.contains(&case.name.as_str());
        assert_eq!(light.bins.is_empty(), !is_known, "{}", case.name);
        assert_eq!(light.verdicts.iter().any(|judged| judged.property == "caustic"), is_known, "{}", case.name);
        for bin in &light.bins {
            assert_ne!(bin.verdict, Verdict::Fail, "{} {bin:?}", case.name);
            assert!(bin.exact >= 0.0 && bin.bound <= 1e-9 * bin.exact.max(1e-9) && bin.measured >= 0.0, "{bin:?}");
        }
    }
}

#[test]
fn what_the_rings_get_adds_up_to_the_order() {
    // All of the beam's first passage lands within the rings of this case.
    let light = judged(&shipped("caustic/paraboloid"));
    let measured: f64 = light.bins.iter().map(|bin| bin.measured).sum();
    let exact: f64 = light.bins.iter().map(|bin| bin.exact).sum();
    assert!((measured / exact - 1.0).abs() < 1e-2, "{measured} {exact}");
    assert!(exact <= light.rows[0].source_power * (1.0 + 1e-12));
}
