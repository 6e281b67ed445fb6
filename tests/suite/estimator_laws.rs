//! The estimator against a plain loop: the same source points, one after another, each with its own naive segment test.
//!
//! The estimator works in blocks and lanes, side by side for small counts, and asks analytic shapes and hierarchies; none
//! of that may show.

use std::f64::consts::PI;

use etendue::case::{Case, shipped};
use etendue::configuration::{Arrangement, Configuration, Source};
use etendue::estimator::{AreaEstimator, Estimator, Job, Scratch};
use etendue::geometry::{DVec3, Disk, Mesh, Shape};
use etendue::radiometry::Exitance;
use etendue::sampling::{
    BLOCK, LANES, Lanes, Pattern, Purpose, Squares, Strategy, StreamKey, Surface, SurfaceBlock, Technique,
};

/// Of every kind of source and blocker one at least.
const NAMES: [&str; 8] = [
    "direct/diffuser-box",
    "direct/half-sunk-source",
    "direct/l-shaped-source",
    "penumbra/l-shaped-occluder",
    "penumbra/overlapping-occluders",
    "penumbra/spheres",
    "penumbra/tilted-occluder",
    "penumbra/two-shadows",
];

/// Side by side (1, 4, 8), part of a lane group (5), part of a block (37), several blocks and a rest (300).
const COUNTS: [u64; 6] = [1, 4, 5, 8, 37, 300];

fn read(name: &str) -> Case {
    shipped().find(|case| case.name() == name).expect(name).read().expect(name)
}

/// Every fourth point of a case, so that shadows, borders and light are all met.
fn thinned(name: &str) -> Configuration {
    let whole = read(name).configuration;
    let points = whole.points().iter().copied().step_by(4).collect();
    let receiver = whole.receiver().cloned();
    Configuration::new(whole.sources().to_vec(), whole.occluders().to_vec(), receiver, points, Arrangement::Scattered)
        .expect("a part of a sound case")
}

fn by_area() -> impl Iterator<Item = Strategy> {
    Strategy::ALL.into_iter().filter(|strategy| strategy.technique() == Technique::Area)
}

fn key(strategy: Strategy, samples: u64) -> StreamKey {
    StreamKey::cell(11, 7, Purpose::Measurement, strategy, samples)
}

/// Estimates as [point][replicate].
fn estimate(
    configuration: &Configuration,
    strategy: Strategy,
    samples: u64,
    replicates: std::ops::Range<u64>,
) -> Vec<f64> {
    let points = configuration.points();
    let mut estimates = vec![f64::NAN; points.len() * (replicates.end - replicates.start) as usize];
    let job = Job { strategy, samples, cell: key(strategy, samples), replicates, points };
    AreaEstimator::new(configuration).estimate(&job, &mut Scratch::default(), &mut estimates);
    estimates
}

/// The points of one estimate on one source.
fn source_points(shape: &Shape, strategy: Strategy, samples: u64, key: StreamKey) -> Vec<DVec3> {
    let surface = Surface::new(shape).expect("a surface");
    let mut pattern = Pattern::new(strategy, samples, Lanes::new(key, samples.min(LANES as u64) as usize));
    let (mut squares, mut places) = (Squares::default(), SurfaceBlock::default());
    let mut points = Vec::new();
    while (points.len() as u64) < samples {
        let len = (samples as usize - points.len()).min(BLOCK);
        pattern.fill(&mut squares, len);
        surface.place(&squares, len, &mut places);
        points.extend((0..len).map(|i| {
            let at = |row: &[[f64; LANES]]| row[i / LANES][i % LANES];
            surface.origin() + DVec3::new(at(&places.x), at(&places.y), at(&places.z))
        }));
    }
    points
}

/// The lecture's sum, ray by ray, and what rounding may do to it, W/m²: a cosine is known to some units in the last place
/// of 1, which is much of a grazing one.
fn plain_sum(
    configuration: &Configuration,
    strategy: Strategy,
    samples: u64,
    replicate: u64,
    point: usize,
) -> (f64, f64) {
    let receiver = &configuration.points()[point];
    let (mut sum, mut rounding) = (0.0, 0.0);
    for (index, source) in configuration.sources().iter().enumerate() {
        let shared_or_own = if strategy == Strategy::Correlated { 0 } else { point as u64 + 1 };
        let key = key(strategy, samples).with(replicate).with(shared_or_own).with(index as u64);
        let others = configuration.sources().iter().enumerate().filter(|(other, _)| *other != index);
        let blockers: Vec<&Shape> = others.map(|(_, s)| s.shape()).chain(configuration.occluders()).collect();
        let share = source.shape().area() * source.exitance().watts_per_square_metre() / samples as f64;
        for at in source_points(source.shape(), strategy, samples, key) {
            let normal = match source.shape() {
                Shape::Disk(disk) => disk.normal(),
                Shape::Rectangle(rectangle) => rectangle.normal(),
                Shape::Polygon(polygon) => polygon.normal(),
                Shape::Sphere(sphere) => (at - sphere.center()) / sphere.radius(),
                other => panic!("no such source: {}", other.kind()),
            };
            let ray = at - receiver.position();
            let (r, direction) = (ray.length(), ray.normalize());
            let (arriving, leaving) = (receiver.normal().dot(direction), -normal.dot(direction));
            let blocked = || blockers.iter().any(|shape| blocks(shape, receiver.position(), at));
            if arriving > 0.0 && leaving > 0.0 && !blocked() {
                sum += share * arriving * leaving / (PI * r * r);
                rounding += 8.0 * f64::EPSILON * share * (arriving + leaving) / (PI * r * r);
            }
        }
    }
    (sum, rounding)
}

/// A segment test used nowhere else; a mesh by each of its triangles.
fn blocks(shape: &Shape, from: DVec3, to: DVec3) -> bool {
    let Shape::Mesh(mesh) = shape else { return super::shipped_cases::blocks(shape, from, to) };
    (0..mesh.triangles().len()).any(|triangle| {
        let [a, b, c] = mesh.corners(triangle);
        let volume = |p: DVec3, q: DVec3, r: DVec3, s: DVec3| (q - p).cross(r - p).dot(s - p);
        let sides = [volume(from, to, a, b), volume(from, to, b, c), volume(from, to, c, a)];
        let through = sides.iter().all(|v| *v > 0.0) || sides.iter().all(|v| *v < 0.0);
        through && volume(a, b, c, from) * volume(a, b, c, to) < 0.0
    })
}

fn agrees_with_the_plain_sum(name: &str, configuration: &Configuration) {
    let (first, count) = (3, 5);
    let (mut lit, mut dark) = (0, 0);
    for strategy in by_area() {
        for samples in COUNTS {
            let estimates = estimate(configuration, strategy, samples, first..first + count);
            for point in 0..configuration.points().len() {
                for r in 0..count {
                    let found = estimates[point * count as usize + r as usize];
                    let (plain, rounding) = plain_sum(configuration, strategy, samples, first + r, point);
                    // Sums of up to 300 terms in another order, cosines by other roundings.
                    let same = (found - plain).abs() <= 1e-13 * plain + rounding;
                    assert!(
                        same,
                        "{name}: {strategy} N = {samples} point {point} replicate {r}: {found}, not {plain}"
                    );
                    if plain > 0.0 { lit += 1 } else { dark += 1 }
                }
            }
        }
    }
    assert!(lit > 0 && (dark > 0 || configuration.occluders().is_empty()), "{name}: {lit} lit, {dark} dark");
}

#[test]
fn blocks_and_lanes_do_not_show() {
    for name in NAMES {
        agrees_with_the_plain_sum(name, &thinned(name));
    }
}

#[test]
fn a_mesh_is_the_sum_of_its_triangles() {
    let room = thinned("penumbra/tilted-occluder");
    let tip = DVec3::new(0.05, -0.1, 1.3);
    let ring = (0..5).map(|k| {
        let (sine, cosine) = (PI * 0.4 * f64::from(k)).sin_cos();
        DVec3::new(0.4 * cosine, 0.3 * sine, 0.9)
    });
    let corners: Vec<DVec3> = std::iter::once(tip).chain(ring).collect();
    let cone = Mesh::new(corners, (0..5).map(|k| [0, 1 + k, 1 + (k + 1) % 5]).collect()).unwrap();
    let occluders = vec![Shape::Mesh(cone.subdivided(2))];
    let sources = room.sources().to_vec();
    let points = room.points().to_vec();
    let configuration = Configuration::new(sources, occluders, None, points, Arrangement::Scattered).unwrap();
    agrees_with_the_plain_sum("cone", &configuration);
}

#[test]
fn replicates_may_be_estimated_in_any_portions() {
    let configuration = thinned("penumbra/two-shadows");
    for strategy in by_area() {
        for samples in COUNTS {
            let whole = estimate(&configuration, strategy, samples, 0..150);
            let parts =
                [0..1, 1..40, 40..150].map(|part| (part.clone(), estimate(&configuration, strategy, samples, part)));
            for point in 0..configuration.points().len() {
                for (range, part) in &parts {
                    let count = (range.end - range.start) as usize;
                    let expected = &whole[point * 150..][range.start as usize..range.end as usize];
                    assert_eq!(&part[point * count..][..count], expected, "{strategy} N = {samples}");
                }
            }
        }
    }
}

#[test]
fn an_occluder_only_ever_takes_light_away() {
    let whole = thinned("penumbra/overlapping-occluders");
    let with = |n: usize| {
        let occluders = whole.occluders()[..n].to_vec();
        let points = whole.points().to_vec();
        Configuration::new(whole.sources().to_vec(), occluders, None, points, Arrangement::Scattered).unwrap()
    };
    for strategy in by_area() {
        for samples in COUNTS {
            let [none, one, both] = [0, 1, 2].map(|n| estimate(&with(n), strategy, samples, 0..20));
            for ((none, one), both) in none.iter().zip(&one).zip(&both) {
                assert!(none >= one && one >= both && *both >= 0.0, "{none} {one} {both}");
            }
            assert!(none != one && one != both, "{strategy} N = {samples}: each occluder takes something");
        }
    }
}

#[test]
fn light_is_proportional_to_exitance_and_adds_up_over_sources() {
    let room = thinned("penumbra/two-shadows");
    let with = |factors: [f64; 2]| {
        let sources = room
            .sources()
            .iter()
            .zip(factors)
            .map(|(source, factor)| Source::new(source.shape().clone(), Exitance::new(factor)).unwrap());
        let points = room.points().to_vec();
        let occluders = room.occluders().to_vec();
        Configuration::new(sources.collect(), occluders, None, points, Arrangement::Scattered).unwrap()
    };
    for strategy in by_area() {
        let of = |factors| estimate(&with(factors), strategy, 16, 0..20);
        let (left, right, both, twice) = (of([1.0, 0.0]), of([0.0, 1.0]), of([1.0, 1.0]), of([2.0, 2.0]));
        for i in 0..both.len() {
            assert_eq!(left[i] + right[i], both[i], "{strategy}");
            assert_eq!(2.0 * both[i], twice[i], "{strategy}");
        }
    }
}

#[test]
fn source_points_lie_on_their_source() {
    let disk = Shape::Disk(Disk::new(DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, -2.0, 0.5), 0.7).unwrap());
    let Shape::Disk(flat) = &disk else { panic!("a disk") };
    for strategy in by_area() {
        for samples in COUNTS {
            for at in source_points(&disk, strategy, samples, key(strategy, samples)) {
                let offset = at - flat.center();
                assert!(offset.length() <= flat.radius() * (1.0 + 1e-15), "{strategy}: {offset}");
                assert!(offset.dot(flat.normal()).abs() < 1e-15, "{strategy}: {offset}");
            }
        }
    }
}
