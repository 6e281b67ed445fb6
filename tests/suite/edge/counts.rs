//! One sample and 2³¹, one replicate, and runs that nobody would see the end of.

use assert_cmd::Command;
use etendue::case::{Replicates, Study};
use etendue::geometry::{DVec3, Disk, Shape};
use etendue::sampling::Strategy;
use etendue::trial::{self, Effort, Overrides, Settings};
use etendue::{Case, Verdict};
use predicates::prelude::*;
use predicates::str::contains;

use super::{Change, SAME, assert_tables, point, room, shown};

/// One point, half in shadow.
fn small() -> Case {
    let disk = |z: f64, radius: f64| Shape::Disk(Disk::new(DVec3::Z * z, DVec3::NEG_Z, radius).unwrap());
    let at = point(DVec3::new(0.2, 0.1, 0.0), DVec3::Z);
    Case::new(
        "small",
        "One point",
        room(vec![(disk(2.0, 0.5), 1.0)], vec![disk(1.0, 0.25)], vec![at]),
        Study::default(),
    )
}

fn settings(strategies: &[Strategy], samples: u64, replicates: Replicates) -> Settings {
    let overrides = Overrides {
        strategies: Some(strategies.to_vec()),
        samples: Some(vec![samples]),
        replicates: Some(replicates),
        ..Overrides::default()
    };
    Settings { seed: 6, effort: Effort::Quick, overrides }
}

const MOST: u64 = 1 << 31;

#[test]
fn one_sample_is_enough_for_every_strategy() {
    let cases = [small(), SAME.case("penumbra/spheres").unwrap()];
    let outcome = trial::run(&cases, &settings(&Strategy::ALL, 1, Replicates::Fixed(4096)), &|_| {}).unwrap();
    assert_tables("one sample", &outcome);
    for (name, verdict, words) in shown(&outcome) {
        assert_ne!(verdict, Verdict::Fail, "{name}: {words}");
    }
}

/// Two replicates tell next to nothing, and say so.
#[test]
fn two_replicates_claim_nothing() {
    let strategies = [Strategy::Random, Strategy::Correlated, Strategy::Stratified, Strategy::Sobol];
    let outcome = trial::run(&[small()], &settings(&strategies, 1, Replicates::Fixed(2)), &|_| {}).unwrap();
    assert_tables("two replicates", &outcome);
    for (name, verdict, words) in shown(&outcome) {
        assert_eq!(verdict, Verdict::Undecided, "{name}: {words}");
    }
}

/// Strata beyond those that are integrated one by one: bounded by what as many independent points would do, and judged.
#[test]
fn many_strata_take_no_memory_and_pass() {
    let samples = (1 << 22) + 1;
    let outcome = trial::run(&[small()], &settings(&[Strategy::Stratified], samples, Replicates::Fixed(32)), &|_| {});
    let outcome = outcome.unwrap();
    assert_tables("many strata", &outcome);
    let told = shown(&outcome);
    assert_eq!(told.len(), 1, "of a variance that is only bounded nothing is judged: {told:?}");
    let (name, verdict, words) = &told[0];
    assert_eq!((name.as_str(), *verdict), ("small stratified bias", Verdict::Pass), "{words}");
    assert!(outcome.cases[0].strategies[0].cells[0].points[0].predicted_variance.is_none());
    // The bias that would have been seen is that of independent points.
    let seen = |strategy| {
        let plans = trial::forecast(&[small()], &settings(&[strategy], samples, Replicates::Fixed(32)));
        plans[0].smallest_bias_point.expect("light is due")
    };
    let (strata, random) = (seen(Strategy::Stratified), seen(Strategy::Random));
    assert!((strata / random - 1.0).abs() < 1e-12, "{strata} {random}");
}

/// 64 GiB of strata, and hours of trials, if they were made.
#[test]
fn a_plan_of_as_many_samples_as_there_may_be_takes_no_time() {
    let strategies = [Strategy::Random, Strategy::Correlated, Strategy::Stratified];
    let plans = trial::forecast(&[small()], &settings(&strategies, MOST, Replicates::Fixed(2)));
    assert_eq!(plans.len(), 3);
    for plan in plans {
        assert_eq!((plan.rays, plan.cells.as_slice()), (2 * MOST, &[(MOST, 2)][..]), "{plan:?}");
        // Of 2³² samples, at 100 ps to a microsecond each.
        assert!(plan.seconds > 0.4 && plan.seconds < 4300.0, "{plan:?}");
        assert!(plan.predicted, "no pilot of 128 times as many: {plan:?}");
    }
}

#[test]
fn what_would_go_on_for_days_is_refused_with_its_reason() {
    let rays = |samples, replicates| {
        trial::least_rays(&small(), &settings(&[Strategy::Random, Strategy::Sobol], samples, replicates))
    };
    // A pilot of 128 more for points whose spread nothing predicts.
    assert_eq!(rays(MOST, Replicates::Fixed(2)), MOST as f64 * (2.0 + 2.0 + 128.0));
    assert_eq!(rays(1, Replicates::Auto), 128.0 + 128.0 + 8192.0);
    let etendue = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_etendue"));
        command.current_dir(env!("CARGO_TARGET_TMPDIR"));
        command
    };
    for command in ["run", "plan"] {
        etendue()
            .args([command, "penumbra/eclipse", "--samples", "2147483648"])
            .assert()
            .code(2)
            .stdout("")
            .stderr(contains("penumbra/eclipse takes 5.4e13 shadow rays at least (65 points, 3 strategies"))
            .stderr(contains("at most 8.8e12, half a day of one core, are accepted"));
    }
    for (said, accepted) in
        [(["--samples", "2147483649"], "is not in 1..=2147483648"), (["--samples", "0"], "is not in 1..=2147483648")]
    {
        etendue().arg("run").args(said).assert().code(2).stderr(contains(accepted));
    }
}

#[test]
fn one_replicate_is_refused_with_what_is_accepted() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_etendue"));
    command
        .args(["run", "penumbra/eclipse", "--replicates", "1"])
        .assert()
        .code(2)
        .stderr(contains("'1' for '--replicates").and(contains("from 2")));
    let text = "[[source.sphere]]\ncenter = [0, 0, 1]\nradius = 0.5\nexitance = 1\n[[measure.point]]\nposition = [0, 0, 0]\n\
                normal = [0, 0, 1]\n[study]\nreplicates = 1\n";
    let refused = Case::from_toml("one", text).unwrap_err().to_string();
    assert!(refused.contains("`study.replicates` is 1; an integer from 2 to"), "{refused}");
    // Whatever is changed elsewhere: the text is the shipped one's.
    assert!(Change { light: 2.0, ..SAME }.case("penumbra/eclipse").is_ok());
}
