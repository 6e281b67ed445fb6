//! Light that goes to and fro: the shipped rooms pass, and eye paths find what closed forms, quadrature and rays from the
//! light say.

use std::f64::consts::PI;

use etendue::case::{Case, shipped, shipped_interreflections};
use etendue::configuration::{
    Configuration, Contents, DiffuseSurface, Lamp, MeasurementPoint, Receiver, ReceiverShape,
};
use etendue::geometry::{DVec3, Rectangle, Sphere};
use etendue::light::{LightSettings, trace};
use etendue::path::{Part, PathRun, PathSettings, PathTracer};
use etendue::radiometry::enclosure::parallel_plates;
use etendue::radiometry::{Albedo, Beam, Exitance, Flux, Irradiance, PointSource};
use etendue::statistics::Verdict;
use etendue::statistics::budget::seed_of;
use etendue::trial::{self, CaseOutcome, Effort, Overrides, Settings};

fn judged(case: &Case, effort: Effort) -> CaseOutcome {
    let settings = Settings { seed: Settings::DEFAULT_SEED, effort, overrides: Overrides::default() };
    let outcome = trial::run(std::slice::from_ref(case), &settings, &|_| {}).expect("a run");
    outcome.cases.into_iter().next().expect("one case")
}

fn case(name: &str) -> Case {
    let case = shipped().find(|case| case.name() == name).unwrap_or_else(|| panic!("{name} is not shipped"));
    case.read().unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

#[test]
fn the_shipped_interreflections_pass() {
    let mut judged_by_paths = 0;
    for shipped in shipped_interreflections() {
        let case = shipped.read().unwrap_or_else(|mistakes| panic!("{mistakes}"));
        let outcome = judged(&case, Effort::Standard);
        for (strategy, judged) in outcome.verdicts() {
            let name = format!("{} {strategy} {}", case.name, judged.property);
            assert_eq!(judged.verdict, Verdict::Pass, "{name}: {}", judged.words);
            judged_by_paths += u32::from(judged.property == "indirect");
        }
        assert!(outcome.verdicts().next().is_some(), "{}", case.name);
    }
    // Two estimators where sources have area; lamps are found by shadow rays alone.
    assert_eq!(judged_by_paths, 2 * 4 + 3);
}

#[test]
fn all_threads_find_the_same() {
    let case = case("interreflection/coaxial-disks");
    let settings = PathSettings { next_event: true, ..PathSettings::default() };
    let run = |threads: usize| -> PathRun {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| PathTracer::new(&case.configuration, &settings, 5).at_points(50_000))
    };
    assert_eq!(run(1), run(3));
    let other = PathTracer::new(&case.configuration, &settings, 6).at_points(50_000);
    assert_ne!(run(1).points, other.points);
}

/// A mean of paths within 6.5 standard errors, and a margin, of what is due.
fn assert_found(name: &str, run: &PathRun, part: Part, due: f64, margin: f64) {
    for (k, point) in run.points.iter().enumerate() {
        let found = point.mean(part, run.paths);
        let error = (point.variance(part, run.paths).unwrap() / run.paths as f64).sqrt();
        assert!((found - due).abs() <= 6.5 * error + margin, "{name} at {k}: {found} ± {error}, due {due}");
        assert_eq!(point.terminated, 0, "{name}");
    }
}

fn wall(radius: f64, albedo: f64, exitance: f64) -> DiffuseSurface {
    let sphere = ReceiverShape::Sphere(Sphere::new(DVec3::ZERO, radius).unwrap());
    DiffuseSurface::new(sphere, Albedo::new(albedo), Exitance::new(exitance), true).unwrap()
}

fn at_wall(radius: f64) -> Vec<MeasurementPoint> {
    [DVec3::X, DVec3::new(-0.48, 0.6, 0.64), DVec3::NEG_Z]
        .map(|outwards| MeasurementPoint::new(outwards * radius, -outwards).unwrap())
        .to_vec()
}

#[test]
fn a_furnace_multiplies_by_one_over_what_it_absorbs() {
    for albedo in [0.0, 0.3, 0.9, 0.99] {
        let room = Configuration::of(Contents {
            diffuse: vec![wall(2.0, albedo, 1.0)],
            points: at_wall(2.0),
            ..Contents::default()
        })
        .unwrap();
        for next_event in [false, true] {
            for roulette_after in [0, 2, 20] {
                let settings = PathSettings { next_event, roulette_after, ..PathSettings::default() };
                let run = PathTracer::new(&room, &settings, seed_of("a_furnace_multiplies")).at_points(20_000);
                let name = format!("{albedo} {next_event} {roulette_after}");
                assert_found(&name, &run, Part::Total, 1.0 / (1.0 - albedo), 1e-12);
            }
        }
    }
}

/// A lamp and a beam together in a grey sphere: what the wall sends back is the same everywhere.
#[test]
fn light_is_mixed_by_a_sphere() {
    let lamp = PointSource::new(DVec3::new(0.3, 0.2, -0.4), Flux::new(20.0)).unwrap();
    let beam = Beam::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 2.0), 0.3, Irradiance::new(7.0)).unwrap();
    let room = Configuration::of(Contents {
        diffuse: vec![wall(1.5, 0.75, 0.2)],
        lamps: vec![Lamp::Point(lamp), Lamp::Beam(beam)],
        points: at_wall(1.5),
        ..Contents::default()
    })
    .unwrap();
    let power = 20.0 + beam.power().watts();
    let due = 3.0 * (0.2 + power / (4.0 * PI * 2.25));
    let settings = PathSettings { next_event: true, ..PathSettings::default() };
    let run = PathTracer::new(&room, &settings, seed_of("light_is_mixed_by_a_sphere")).at_points(60_000);
    assert_found("mixed", &run, Part::Indirect, due, 1e-12);
}

/// Plates two hundred gaps wide, in the middle: the ends are seen under 10⁻⁴ of the hemisphere.
#[test]
fn wide_plates_are_endless_in_the_middle() {
    let plate = |z: f64, v: f64| Rectangle::new(DVec3::Z * z, DVec3::X * 200.0, DVec3::Y * v).unwrap();
    let (albedos, exitance) = ([Albedo::new(0.5), Albedo::new(0.8)], Exitance::new(1.0));
    let upper =
        DiffuseSurface::new(ReceiverShape::Rectangle(plate(1.0, -200.0)), albedos[1], exitance, false).unwrap();
    let room = Configuration::of(Contents {
        diffuse: vec![upper],
        receiver: Some(Receiver::new(ReceiverShape::Rectangle(plate(0.0, 200.0)), Some(albedos[0])).unwrap()),
        points: vec![MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap()],
        ..Contents::default()
    })
    .unwrap();
    let [_, upper] = parallel_plates([Exitance::new(0.0), exitance], albedos).unwrap();
    let due = upper.watts_per_square_metre();
    let settings = PathSettings::default();
    let run = PathTracer::new(&room, &settings, seed_of("wide_plates_are_endless")).at_points(400_000);
    // Each of some three bounces may lose as much.
    assert_found("plates", &run, Part::Total, due, 6e-4 * due);
}

/// Eye paths from all over the receiver, and rays from the light, bring the same light by the mirror and through the glass.
#[test]
fn eye_paths_find_what_the_map_holds() {
    for name in ["caustic/plane-mirror", "caustic/ball-on-a-globe"] {
        let case = case(name);
        let tracer = PathTracer::new(&case.configuration, &PathSettings::default(), seed_of(name));
        let eye = tracer.over_receiver(4_000_000).unwrap();
        let run = trace(&case.configuration, &LightSettings { rays: 400_000, ..case.light.clone() }, seed_of(name));
        let map = &run.maps[0];
        let area: f64 = map.grid().texels().map(|texel| map.area(texel)).sum();
        let orders = 1..=run.depth();
        let flux: f64 = orders.clone().map(|order| run.deposited(0, order).watts()).sum();
        let of_flux: f64 = orders.filter_map(|order| run.deposited(0, order).variance(run.ledger.groups)).sum();
        let found = eye.mean.mean(Part::Caustic, eye.paths);
        let variance = eye.mean.variance(Part::Caustic, eye.paths).unwrap() / eye.paths as f64;
        let error = (variance + of_flux / (area * area)).sqrt();
        assert!((found - flux / area).abs() <= 6.5 * error, "{name}: {found} {} ± {error}", flux / area);
        assert!(eye.mean.reached(Part::Caustic) > 1000, "{name}: {}", eye.mean.reached(Part::Caustic));
        assert!(error < 0.05 * found, "{name}: {error} of {found}");
    }
}

#[test]
fn a_lamp_without_extent_is_never_met() {
    let case = case("caustic/glass-ball");
    let tracer = PathTracer::new(&case.configuration, &PathSettings::default(), 1);
    assert!(!tracer.can_reach());
    let eye = tracer.over_receiver(20_000).unwrap();
    assert_eq!((eye.mean.reached(Part::Total), eye.mean.mean(Part::Total, eye.paths)), (0, 0.0));
    let outcome = judged(&case, Effort::Quick);
    let rows = &outcome.paths.expect("a survey").rows;
    assert_eq!(rows.iter().map(|row| row.estimator).collect::<Vec<_>>(), ["eye_paths", "light_map"]);
    assert!(rows[0].reached_share == Some(0.0) && rows[1].measured > 0.0);
}

/// The point source in two spheres: what has come through the inner one arrives at the outer one, all of it.
#[test]
fn two_spheres_take_the_same_power() {
    let outcome = judged(&case("interreflection/two-spheres"), Effort::Standard);
    let light = outcome.light.expect("light is followed");
    let [bin] = &light.bins[..] else { panic!("{:?}", light.bins) };
    assert_eq!((bin.order, bin.exact), (1, 100.0));
    assert!((bin.measured / 100.0 - 1.0).abs() < 1e-12, "{}", bin.measured);
    assert_eq!(bin.verdict, Verdict::Pass);
    // Brightness that does not fall with distance would make it (2 m/0.5 m)² as much.
    let books = light.rows.last().unwrap();
    assert!((books.deposited / books.source_power - 1.0).abs() < 1e-12 && books.escaped == 0.0);
}

/// P τ/(1 − ρ) comes out of the shade, and the rest is absorbed in it.
#[test]
fn a_lampshade_lets_out_its_share() {
    for name in ["interreflection/lampshade", "interreflection/lampshade-off-middle"] {
        let case = case(name);
        let settings = LightSettings { rays: 400_000, ..case.light.clone() };
        let run = trace(&case.configuration, &settings, seed_of(name));
        let out = run.ledger.deposited + run.ledger.escaped;
        let due = 60.0 * 0.5 / 0.7;
        // A packet comes out or not; on the way from the second case's shade an occluder takes some.
        let share: f64 = 0.5 / 0.7;
        let error = 60.0 * (share * (1.0 - share) / run.ledger.rays as f64).sqrt();
        if name.ends_with("middle") {
            assert!(out < due && out > 0.9 * due, "{out} {due}");
        } else {
            assert!((out - due).abs() < 5.0 * error, "{out} {due} {error}");
        }
        assert!(run.ledger.relative_residual() < 1e-12);
    }
}

#[test]
fn a_shade_that_cannot_be_is_refused() {
    let text = |more: &str| {
        format!(
            "[[source.point]]\nposition = [0.0, 0.0, 0.1]\npower = 1.0\n[[diffuse.sphere]]\ncenter = [0.0, 0.0, 0.0]\nradius = 1.0\n{more}"
        )
    };
    for (more, said) in [
        ("albedo = 0.5\ninward = true\ntransmittance = 0.6\n", "both together at most 1"),
        ("albedo = 0.5\ninward = true\ntransmittance = -0.1\n", "both together at most 1"),
        ("albedo = 0.5\ninward = true\ntransmittance = nan\n", "transmittance"),
        ("albedo = 0.5\ntransmittance = 0.1\n", "inward = true"),
        ("albedo = 0.5\nexitance = 1.0\ninward = true\ntransmittance = 0.1\n", "emits nothing"),
    ] {
        let error = Case::from_toml("shade", &text(more)).expect_err(more).to_string();
        assert!(error.contains(said), "{more}: {error}");
    }
    let shade = Case::from_toml("shade", &text("albedo = 0.5\ninward = true\ntransmittance = 0.5\n")).unwrap();
    assert_eq!(shade.configuration.diffuse()[0].transmittance(), 0.5);
}
