//! Judging others in code: no false alarms of what is right, no pass of what is wrong, and everything is said.

use std::f64::consts::{PI, TAU};

use etendue::case::Study;
use etendue::configuration::{Arrangement, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Disk, Shape};
use etendue::radiometry::Exitance;
use etendue::statistics::budget::{plausible, seed_of};
use etendue::{Case, Configuration, Draws, PointSampler, Verdict, judge};

/// A disk source; three points in its light, or with a smaller disk half way, in umbra, penumbra and light.
fn room(eclipsed: bool) -> Case {
    let disk = |height: f64, radius: f64| Shape::Disk(Disk::new(DVec3::Z * height, -DVec3::Z, radius).unwrap());
    let source = Source::new(disk(2.0, 0.5), Exitance::new(2.0)).unwrap();
    let points = [0.0, 0.7, 1.4].map(|x| MeasurementPoint::new(DVec3::X * x, DVec3::new(0.2, 0.0, 1.0)).unwrap());
    let occluders = if eclipsed { vec![disk(1.0, 0.35)] } else { vec![] };
    let room = Configuration::new(vec![source], occluders, None, points.to_vec(), Arrangement::Line).unwrap();
    Case::new("room", "A room", room, Study::default())
}

/// What can be wrong with an estimator of an open disk.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slip {
    None,
    /// r = u in the place of √u.
    RadiusIsNoRoot,
    /// The density per area with the source's cosine lost.
    CosineLost,
    /// N + 1 in the place of N.
    OneTooMany,
    /// Right on average over the points, wrong at each.
    Tilted,
}

fn estimate(room: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws, slip: Slip) -> f64 {
    let source = &room.sources()[0];
    let Shape::Disk(disk) = source.shape() else { return f64::NAN };
    let (x, y) = disk.normal().any_orthonormal_pair();
    let mut sum = 0.0;
    for _ in 0..samples {
        let u = draws.unit();
        let radius = disk.radius() * if slip == Slip::RadiusIsNoRoot { u } else { u.sqrt() };
        let (sine, cosine) = (TAU * draws.unit()).sin_cos();
        let d = disk.center() + (x * cosine + y * sine) * radius - point.position();
        let cos_s = if slip == Slip::CosineLost { d.length() } else { (-disk.normal()).dot(d).abs() };
        sum += point.normal().dot(d).max(0.0) * cos_s / d.length_squared().powi(2);
    }
    let n = samples + u64::from(slip == Slip::OneTooMany);
    let factor = if slip == Slip::Tilted { 1.0 + 0.1 * (point.position().x - 0.7) } else { 1.0 };
    factor * source.exitance().watts_per_square_metre() * disk.radius().powi(2) * sum / n as f64
}

#[test]
fn a_right_estimator_raises_no_alarm() {
    let case = room(false);
    let right = |room: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws| {
        estimate(room, point, samples, draws, Slip::None)
    };
    let runs = 400;
    let seeds = (0..runs).map(|k| seed_of(&format!("a_right_estimator_raises_no_alarm/{k}")));
    let alarms = seeds.filter(|seed| {
        // Few replicates, so that the pilot's say is as rough as it may be.
        judge(&case).seed(*seed).samples(&[1, 2]).replicates(64).estimator("right", &right).verdict() == Verdict::Fail
    });
    assert!(plausible(alarms.count() as u64, runs, 0.0, 1e-6));
}

#[test]
fn right_points_behind_an_occluder_raise_no_alarm() {
    let case = room(true);
    let strata = |draws: &mut Draws, points: &mut [[f64; 2]]| {
        let n = points.len() as f64;
        for (k, point) in points.iter_mut().enumerate() {
            *point = [(k as f64 + draws.unit()) / n, draws.unit()];
        }
    };
    let runs = 300;
    for stated in [false, true] {
        let alarms = (0..runs).filter(|k| {
            let seed = seed_of(&format!("right_points_behind_an_occluder_raise_no_alarm/{stated}/{k}"));
            let judge = judge(&case).seed(seed).samples(&[4]).replicates(48);
            let judge = if stated { judge.variance_at_most_random() } else { judge };
            judge.points("strata", &strata).verdict() == Verdict::Fail
        });
        assert!(plausible(alarms.count() as u64, runs, 0.0, 1e-6), "stated: {stated}");
    }
}

#[test]
fn what_is_wrong_is_caught_from_every_seed_and_what_is_right_passes() {
    let case = room(false);
    for slip in [Slip::None, Slip::RadiusIsNoRoot, Slip::CosineLost, Slip::OneTooMany, Slip::Tilted] {
        let estimator = |room: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws| {
            estimate(room, point, samples, draws, slip)
        };
        for seed in 1..=5 {
            let judgement = judge(&case).seed(seed).samples(&[4, 16]).estimator("slipped", &estimator);
            let expected = if slip == Slip::None { Verdict::Pass } else { Verdict::Fail };
            assert_eq!(judgement.verdict(), expected, "{slip:?}, seed {seed}: {judgement}");
        }
    }
}

#[test]
fn points_that_are_not_uniform_are_caught() {
    let case = room(true);
    let never_at_the_edge = |draws: &mut Draws, points: &mut [[f64; 2]]| {
        points.fill_with(|| [0.02 + 0.96 * draws.unit(), draws.unit()]);
    };
    let always_the_same = |_: &mut Draws, points: &mut [[f64; 2]]| {
        let n = points.len() as f64;
        for (k, point) in points.iter_mut().enumerate() {
            *point = [(k as f64 + 0.5) / n, (0.754_877_666 * k as f64).fract()];
        }
    };
    let samplers: [(&str, &dyn PointSampler); 2] =
        [("never at the edge", &never_at_the_edge), ("always the same", &always_the_same)];
    for (name, sampler) in samplers {
        let judgement = judge(&case).samples(&[16]).points(name, sampler);
        assert_eq!(judgement.verdict(), Verdict::Fail, "{judgement}");
    }
}

#[test]
fn an_estimator_without_noise_passes_if_it_is_right() {
    // A point below the middle of a disk sees R² / (R² + h²).
    let place = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
    let disk = Shape::Disk(Disk::new(DVec3::Z * 2.0, -DVec3::Z, 0.5).unwrap());
    let source = Source::new(disk, Exitance::new(2.0)).unwrap();
    let room = Configuration::new(vec![source], vec![], None, vec![place], Arrangement::Scattered).unwrap();
    let case = Case::new("coaxial", "A disk", room, Study::default());
    for (factor, expected) in [(1.0, Verdict::Pass), (1.0 + 1e-9, Verdict::Fail)] {
        let exact = |_: &Configuration, _: &MeasurementPoint, _: u64, _: &mut Draws| factor * 2.0 * 0.25 / 4.25;
        let judgement = judge(&case).samples(&[1]).replicates(100).estimator("exact", &exact);
        assert_eq!(judgement.verdict(), expected, "{judgement}");
        let tolerant = judge(&case).samples(&[1]).replicates(100).tolerance(1e-6).estimator("exact", &exact);
        assert_eq!(tolerant.verdict(), Verdict::Pass, "{tolerant}");
    }
}

#[test]
fn directions_that_seldom_find_the_source_raise_no_alarm() {
    // A disk that fills 1/17 of the hemisphere from below and less from aside: with N = 1 nearly all estimates are zero.
    let case = room(false);
    let cosine = |room: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws| {
        let Shape::Disk(disk) = room.sources()[0].shape() else { return f64::NAN };
        let (x, y) = point.normal().any_orthonormal_pair();
        let mut hits = 0;
        for _ in 0..samples {
            let (r, turn) = (draws.unit().sqrt(), 2.0 * PI * draws.unit());
            let d = x * (r * turn.cos()) + y * (r * turn.sin()) + point.normal() * (1.0 - r * r).sqrt();
            let t = (disk.center().z - point.position().z) / d.z;
            hits += u64::from(t > 0.0 && (point.position() + d * t).distance(disk.center()) < disk.radius());
        }
        2.0 * hits as f64 / samples as f64
    };
    let runs = 300;
    let alarms = (0..runs).filter(|k| {
        let seed = seed_of(&format!("directions_that_seldom_find_the_source_raise_no_alarm/{k}"));
        judge(&case).seed(seed).samples(&[1]).replicates(64).estimator("cosine", &cosine).verdict() == Verdict::Fail
    });
    assert!(plausible(alarms.count() as u64, runs, 0.0, 1e-6));
    let judgement = judge(&case).samples(&[16]).estimator("cosine", &cosine);
    assert_eq!(judgement.verdict(), Verdict::Pass, "{judgement}");
}

#[test]
fn the_same_seed_gives_the_same_verdict() {
    let case = room(true);
    let fair = |draws: &mut Draws, points: &mut [[f64; 2]]| points.fill_with(|| [draws.unit(), draws.unit()]);
    let run = |seed| judge(&case).seed(seed).samples(&[4]).replicates(200).points("fair", &fair);
    assert_eq!(run(3).judged().map(|judged| judged.effect), run(3).judged().map(|judged| judged.effect));
    assert_ne!(run(3).judged().map(|judged| judged.effect), run(4).judged().map(|judged| judged.effect));
    let judged = run(3);
    let note = judged.judged().and_then(|judged| judged.note.clone()).unwrap();
    assert!(note.contains("leans on a pilot of 200 replicates"), "{note}");
    let stated = judge(&case).samples(&[4]).replicates(200).variance_at_most_random().points("fair", &fair);
    let note = stated.judged().and_then(|judged| judged.note.clone()).unwrap();
    assert!(note.contains("no larger than that of `random`"), "{note}");
}
