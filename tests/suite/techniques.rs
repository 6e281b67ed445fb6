//! Sampling by solid angle, by cosine, and by area and cosine weighed together: the same means as the exact side, with the
//! variances that theory says.

use std::f64::consts::PI;

use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::estimator::{Job, Scratch, for_technique};
use etendue::geometry::{DVec3, Disk, Polygon, Rectangle, Shape, Sphere};
use etendue::oracle::{Oracle, Region};
use etendue::radiometry::Exitance;
use etendue::sampling::{Heuristic, Purpose, Strategy, StreamKey, Technique};
use etendue::statistics::budget::{plausible, seed_of};

use super::{exact, first_met};

const ALL: [Strategy; 4] = [Strategy::SolidAngle, Strategy::Cosine, Strategy::MisBalance, Strategy::MisPower];

/// Tables of certified values for one point and one source each.
const TABLES: [&str; 13] = [
    "point_disk",
    "point_sphere",
    "point_polygon",
    "foreshortening",
    "occ_ball",
    "occ_disk_disk",
    "occ_disk_disk_parallel",
    "occ_disk_poly",
    "occ_multi",
    "occ_nonconvex_poly",
    "occ_poly_disk",
    "occ_poly_poly",
    "occ_sphere_source",
];

/// Estimates as [point][replicate].
fn estimate(room: &Configuration, strategy: Strategy, samples: u64, replicates: u64, test: &str) -> Vec<f64> {
    let mut estimates = vec![f64::NAN; room.points().len() * replicates as usize];
    let cell = StreamKey::cell(seed_of(test), room.digest().key(), Purpose::Measurement, strategy, samples);
    let job = Job { strategy, samples, cell, replicates: 0..replicates, points: room.points() };
    for_technique(room, strategy.technique()).estimate(&job, &mut Scratch::default(), &mut estimates);
    estimates
}

/// Mean, variance and fourth central moment.
fn moments(values: &[f64]) -> (f64, f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let power = |k: i32| values.iter().map(|x| (x - mean).powi(k)).sum::<f64>() / n;
    (mean, power(2), power(4))
}

fn room(sources: Vec<(Shape, f64)>, occluders: Vec<Shape>, points: Vec<MeasurementPoint>) -> Configuration {
    let sources = sources.into_iter().map(|(shape, m)| Source::new(shape, Exitance::new(m)).unwrap());
    Configuration::new(sources.collect(), occluders, None, points, Arrangement::Scattered).unwrap()
}

fn point(position: [f64; 3], normal: [f64; 3]) -> MeasurementPoint {
    MeasurementPoint::new(DVec3::from(position), DVec3::from(normal)).unwrap()
}

/// Each mean against the exact value, at six standard errors; returns how many could be told.
///
/// Where fewer than 300 estimates brought light, or fewer than 300 of the directions that are weighed against points can
/// have met a source or missed it, the spread does not tell how far off the mean may be.
/// One cosine-weighted ray from a single source is a coin, which exact binomial limits judge at any number of hits.
fn means_are_exact(name: &str, room: &Configuration, replicates: u64, test: &str) -> usize {
    let samples = 4;
    let oracle = Oracle::new(room);
    let mut told = 0;
    for strategy in ALL {
        let estimates = estimate(room, strategy, samples, replicates, test);
        for (point, row) in room.points().iter().zip(estimates.chunks_exact(replicates as usize)) {
            let truth = oracle.at(point);
            let (exact, bound) = (truth.irradiance.watts_per_square_metre(), truth.bound.watts_per_square_metre());
            let place = format!("{name}: {strategy} at {}", point.position());
            let (mean, variance, _) = moments(row);
            let is_mixed = matches!(strategy.technique(), Technique::Mis(_));
            let share = truth.form_factor.ratio();
            let rarer = share.min(1.0 - share) * (samples * replicates) as f64;
            assert!(row.iter().all(|x| x.is_finite() && *x >= 0.0), "{place}");
            if exact == 0.0 {
                assert_eq!(mean, 0.0, "{place}: light where none is due");
            }
            if strategy == Strategy::Cosine && room.sources().len() == 1 {
                let exitance = room.sources()[0].exitance().watts_per_square_metre();
                let hits = (row.iter().sum::<f64>() * samples as f64 / exitance).round() as u64;
                let (low, high) = ((exact - bound) / exitance, (exact + bound) / exitance);
                assert!(plausible(hits, samples * replicates, low.max(0.0), high.min(1.0)), "{place}: {hits} hits");
                told += 1;
            } else if row.iter().filter(|x| **x > 0.0).count() >= 300 && (!is_mixed || rarer >= 300.0) {
                let error = (variance / replicates as f64).sqrt();
                // Where all draws bring nearly the same, what is left is rounding.
                let allowed = 6.0 * error + bound + 1e-13 * exact;
                assert!((mean - exact).abs() <= allowed, "{place}: {mean} ± {error}, not {exact}");
                told += 1;
            }
        }
    }
    told
}

#[test]
fn every_technique_has_the_mean_of_the_certified_tables() {
    let (mut told, mut all) = (0, 0);
    for table in TABLES {
        for row in exact::rows(table) {
            let test = "every_technique_has_the_mean_of_the_certified_tables";
            told += means_are_exact(&row.id, &row.configuration, 4_096, test);
            all += ALL.len();
        }
    }
    assert!(told * 3 > all * 2, "{told} of {all} could be told");
}

#[test]
fn every_technique_has_the_mean_of_a_crowded_room() {
    let room = first_met::crowded();
    let told = means_are_exact("crowded", &room, 16_384, "every_technique_has_the_mean_of_a_crowded_room");
    // The last point looks down.
    assert_eq!(told, ALL.len() * (room.points().len() - 1));
}

#[test]
fn every_technique_has_the_mean_in_light_penumbra_umbra_and_at_the_horizon() {
    let occluder = || Shape::Disk(Disk::new(DVec3::Z, DVec3::Z, 0.3).unwrap());
    let l = [[0.0, 0.0], [1.2, 0.0], [1.2, 0.5], [0.6, 0.5], [0.6, 1.1], [0.0, 1.1]];
    let l = l.iter().rev().map(|p| DVec3::new(p[0] - 0.5, p[1] - 0.5, 2.0)).collect();
    let shapes = [
        Shape::Disk(Disk::new(DVec3::Z * 2.0, DVec3::NEG_Z, 0.4).unwrap()),
        Shape::Rectangle(Rectangle::new(DVec3::Z * 2.0, DVec3::Y * 0.7, DVec3::X * 0.9).unwrap()),
        Shape::Polygon(Polygon::new(l).unwrap()),
        Shape::Sphere(Sphere::new(DVec3::Z * 2.0, 0.4).unwrap()),
    ];
    let points = vec![
        point([2.0, 0.1, 0.0], [0.0, 0.0, 1.0]),
        point([0.6, 0.1, 0.0], [0.0, 0.1, 1.0]),
        point([0.0, 0.0, 0.5], [0.0, 0.0, 1.0]),
        point([0.3, 1.9, 1.9], [0.2, 0.0, 1.0]),
        point([2.0, 0.0, 1.5], [-1.0, 0.0, 0.3]),
    ];
    let mut regions = Vec::new();
    for shape in shapes {
        let room = room(vec![(shape.clone(), 3.0)], vec![occluder()], points.clone());
        let oracle = Oracle::new(&room);
        regions.extend(points.iter().map(|point| oracle.at(point).region));
        means_are_exact(
            shape.kind(),
            &room,
            16_384,
            "every_technique_has_the_mean_in_light_penumbra_umbra_and_at_the_horizon",
        );
    }
    for region in [Region::Lit, Region::Penumbra, Region::Umbra] {
        assert!(regions.contains(&region), "{region} in {regions:?}");
    }
}

/// Two sources one before the other: the nearer takes light from the farther and gives its own.
#[test]
fn every_technique_has_the_mean_where_sources_block_each_other() {
    let far = Shape::Rectangle(Rectangle::new(DVec3::Z * 2.0, DVec3::Y * 2.0, DVec3::X * 2.0).unwrap());
    let near = Shape::Sphere(Sphere::new(DVec3::new(0.2, 0.1, 1.0), 0.3).unwrap());
    // Turned away: it blocks, and shows its dark side.
    let dark = Shape::Disk(Disk::new(DVec3::new(-0.4, 0.0, 0.8), DVec3::Z, 0.25).unwrap());
    let points = vec![
        point([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        point([-0.5, 0.2, 0.0], [0.2, 0.0, 1.0]),
        point([0.2, 0.1, 0.3], [1.0, 0.0, 0.5]),
    ];
    let room = room(vec![(far, 1.0), (near, 5.0), (dark, 100.0)], vec![], points);
    let told =
        means_are_exact("blocking", &room, 16_384, "every_technique_has_the_mean_where_sources_block_each_other");
    assert_eq!(told, ALL.len() * room.points().len());
}

/// From specks to hemispheres, across the solid angles at which renderers change their method: 10⁻⁴, 3·10⁻⁴, 6.22 sr.
#[test]
fn solid_angles_of_any_size_have_their_mean() {
    let test = "solid_angles_of_any_size_have_their_mean";
    let tilt = DVec3::new(0.3, -0.2, -1.0);
    let frame = etendue::geometry::Frame::around(tilt.normalize());
    // Sides of a square at a metre; the last nearly fills the hemisphere.
    for side in [1e-7, 1e-6, 1e-4, 0.00999, 0.01001, 0.0173, 0.01735, 0.1, 1.0, 10.0, 89.0, 91.0, 1e3] {
        let (u, v) = (frame.tangent * side, frame.bitangent * side);
        let center = DVec3::new(0.1, 0.2, 1.0);
        let corner = |a: f64, b: f64| center + u * a + v * b;
        let shapes = [
            Shape::Rectangle(Rectangle::new(center, u, v).unwrap()),
            Shape::Polygon(Polygon::new(vec![corner(-0.5, -0.5), corner(0.9, 0.0), corner(0.0, 0.9)]).unwrap()),
            Shape::Disk(Disk::new(center, tilt, 0.5 * side).unwrap()),
            Shape::Sphere(Sphere::new(center - tilt.normalize() * (0.5 * side), 0.5 * side).unwrap()),
        ];
        for shape in shapes {
            let room = room(vec![(shape.clone(), 1.0)], vec![], vec![point([0.0; 3], [0.0, 0.1, 1.0])]);
            let exact = Oracle::new(&room).at(&room.points()[0]);
            let (exact, bound) = (exact.irradiance.watts_per_square_metre(), exact.bound.watts_per_square_metre());
            let (mean, variance, _) = moments(&estimate(&room, Strategy::SolidAngle, 16, 4_096, test));
            let error = (variance / 4_096.0).sqrt();
            let place = format!("{} of {side} m", shape.kind());
            assert!(
                (mean - exact).abs() <= 6.0 * error + bound + 1e-12 * exact,
                "{place}: {mean} ± {error}, not {exact}"
            );
            // Small or large, one direction brings nearly what another does; a disk's misses are a fifth at most.
            assert!(error < 0.01 * exact, "{place}: {error} of {exact}");
        }
    }
}

/// A grazing view: next to no solid angle, spread over half the horizon.
#[test]
fn slivers_of_solid_angle_have_their_mean() {
    let test = "slivers_of_solid_angle_have_their_mean";
    for height in [1e-3, 1e-6, 1e-9, 1e-12] {
        let shapes = [
            Shape::Rectangle(Rectangle::new(DVec3::X, DVec3::Y * 3.0, DVec3::X).unwrap()),
            Shape::Rectangle(Rectangle::new(DVec3::X * 50.6, DVec3::Y * 0.3, DVec3::X * 100.0).unwrap()),
            Shape::Disk(Disk::new(DVec3::X * 1.1, DVec3::NEG_Z, 1.0).unwrap()),
        ];
        for shape in shapes {
            // Facing the source, and seeing half of it.
            let points =
                vec![point([0.0, 0.0, -height], [1.0, 0.0, 0.2]), point([0.0, 0.0, -height], [0.3, 1.0, 0.0])];
            let room = room(vec![(shape.clone(), 1.0)], vec![], points);
            let estimates = estimate(&room, Strategy::SolidAngle, 16, 4_096, test);
            for (point, row) in room.points().iter().zip(estimates.chunks_exact(4_096)) {
                let exact = Oracle::new(&room).at(point);
                let (exact, bound) =
                    (exact.irradiance.watts_per_square_metre(), exact.bound.watts_per_square_metre());
                let (mean, variance, _) = moments(row);
                let error = (variance / 4_096.0).sqrt();
                assert!(bound < 1e-3 * error, "the exact side is exact enough: {bound}");
                let place = format!("{} from {height} m", shape.kind());
                assert!((mean - exact).abs() <= 6.0 * error, "{place}: {mean} ± {error}, not {exact}");
            }
        }
    }
}

/// Measured against predicted, in units of the standard error that the measured kurtosis gives.
fn off_by(estimates: &[f64], predicted: f64) -> f64 {
    let (_, variance, fourth) = moments(estimates);
    let n = estimates.len() as f64;
    (variance - predicted) / ((fourth - variance * variance) / n).sqrt()
}

#[test]
fn the_variance_by_cosine_is_that_of_a_lottery() {
    let room = first_met::crowded();
    let with = |exitances: &[f64]| {
        let sources = room.sources().iter().zip(exitances).map(|(source, m)| (source.shape().clone(), *m));
        self::room(sources.collect(), room.occluders().to_vec(), room.points().to_vec())
    };
    let n = room.sources().len();
    let oracles: Vec<Oracle> =
        (0..n).map(|s| Oracle::new(&with(&(0..n).map(|k| f64::from(k == s)).collect::<Vec<_>>()))).collect();
    for samples in [1, 5, 200] {
        let replicates = 100_000 / samples;
        let estimates =
            estimate(&room, Strategy::Cosine, samples, replicates, "the_variance_by_cosine_is_that_of_a_lottery");
        for (point, row) in room.points().iter().zip(estimates.chunks_exact(replicates as usize)).take(4) {
            let parts = oracles.iter().zip(room.sources()).map(|(oracle, source)| {
                (oracle.at(point).irradiance.watts_per_square_metre(), source.exitance().watts_per_square_metre())
            });
            let (first, second) = parts.fold((0.0, 0.0), |(a, b), (f, m)| (a + m * f, b + m * m * f));
            let off = off_by(row, (second - first * first) / samples as f64);
            assert!(off.abs() < 6.0, "N = {samples} at {}: off by {off} standard errors", point.position());
        }
    }
}

/// Second moments by a fine grid over a square source above a point, against what is measured.
#[test]
fn the_variances_of_the_others_are_those_of_their_integrals() {
    let test = "the_variances_of_the_others_are_those_of_their_integrals";
    for (height, exitance) in [(0.2, 1.5), (0.7, 1.0), (3.0, 4.0)] {
        let square = Rectangle::new(DVec3::new(0.3, 0.1, height), DVec3::Y * 1.2, DVec3::X * 0.8).unwrap();
        let at = point([0.0; 3], [0.3, 0.0, 1.0]);
        let room = room(vec![(Shape::Rectangle(square), exitance)], vec![], vec![at]);
        let n = 1_000;
        let area = square.area();
        let cell = area / f64::from(n * n);
        let mut omega = 0.0;
        let mut by_solid_angle = 0.0;
        // First and second moments of each part, for each heuristic.
        let mut parts = [[0.0; 4]; 2];
        for k in 0..n * n {
            let (u, v) = (f64::from(k % n) + 0.5, f64::from(k / n) + 0.5);
            let offset = square.edge_u() * (u / f64::from(n) - 0.5) + square.edge_v() * (v / f64::from(n) - 0.5);
            let ray = square.center() + offset;
            let (r, d) = (ray.length(), ray.normalize());
            let (arriving, leaving) = (d.dot(at.normal()).max(0.0), d.dot(-square.normal()).max(0.0));
            let spread = leaving / (r * r) * cell;
            omega += spread;
            by_solid_angle += (exitance * arriving / PI).powi(2) * spread;
            let (p_area, p_cosine) = (r * r / (area * leaving), arriving / PI);
            for (heuristic, sums) in [Heuristic::Balance, Heuristic::Power].into_iter().zip(&mut parts) {
                let power = |p: f64| p.powi(heuristic.exponent());
                let weight = |p: f64| power(p) / (power(p_area) + power(p_cosine));
                let radiance = exitance / PI * arriving;
                let (a, c) = (weight(p_area) * radiance / p_area, weight(p_cosine) * exitance);
                sums[0] += a * p_area * spread;
                sums[1] += a * a * p_area * spread;
                sums[2] += c * p_cosine * spread;
                sums[3] += c * c * p_cosine * spread;
            }
        }
        let exact = Oracle::new(&room).at(&at).irradiance.watts_per_square_metre();
        let mut predicted = vec![(Strategy::SolidAngle, omega * by_solid_angle - exact * exact)];
        for (strategy, [a, aa, c, cc]) in [Strategy::MisBalance, Strategy::MisPower].into_iter().zip(parts) {
            approx::assert_relative_eq!(a + c, exact, max_relative = 1e-4);
            predicted.push((strategy, aa - a * a + cc - c * c));
        }
        for (strategy, variance) in predicted {
            for samples in [1, 6] {
                let estimates = estimate(&room, strategy, samples, 100_000, test);
                let off = off_by(&estimates, variance / samples as f64);
                assert!(off.abs() < 6.0, "{strategy} N = {samples} at {height} m: off by {off} standard errors");
            }
        }
    }
}

/// Near a source the directions, far from it the points: weighing keeps the better of both.
#[test]
fn weighing_takes_the_better_of_both() {
    let test = "weighing_takes_the_better_of_both";
    let square = |height: f64| {
        let square = Rectangle::new(DVec3::Z * height, DVec3::Y, DVec3::X).unwrap();
        room(vec![(Shape::Rectangle(square), 1.0)], vec![], vec![point([0.0; 3], [0.0, 0.0, 1.0])])
    };
    let variance = |height: f64, strategy: Strategy| moments(&estimate(&square(height), strategy, 4, 20_000, test)).1;
    for strategy in [Strategy::MisBalance, Strategy::MisPower] {
        let near = |strategy| variance(0.03, strategy);
        assert!(near(strategy) < 0.05 * near(Strategy::Random), "{strategy} near");
        let far = |strategy| variance(5.0, strategy);
        assert!(far(strategy) < 0.05 * far(Strategy::Cosine), "{strategy} far");
    }
}

#[test]
fn replicates_may_be_estimated_in_any_portions() {
    let room = first_met::crowded();
    for strategy in ALL {
        for samples in [1, 5, 8, 37, 300] {
            let cell = StreamKey::cell(1, 2, Purpose::Pilot, strategy, samples);
            let estimator = for_technique(&room, strategy.technique());
            let part = |replicates: std::ops::Range<u64>| {
                let count = (replicates.end - replicates.start) as usize;
                let mut estimates = vec![f64::NAN; room.points().len() * count];
                let job = Job { strategy, samples, cell, replicates, points: room.points() };
                estimator.estimate(&job, &mut Scratch::default(), &mut estimates);
                estimates.chunks(count.max(1)).map(<[f64]>::to_vec).collect::<Vec<_>>()
            };
            let (whole, first, rest) = (part(0..20), part(0..7), part(7..20));
            for ((whole, first), rest) in whole.iter().zip(first).zip(rest) {
                assert_eq!(*whole, [first, rest].concat(), "{strategy} N = {samples}");
            }
            assert!(part(3..3).is_empty());
        }
    }
}

#[test]
fn rays_are_counted_as_they_are_traced() {
    let room = first_met::crowded();
    let n = room.sources().len() as u64;
    let rays = |technique| for_technique(&room, technique).rays_per_estimate(10);
    assert_eq!(rays(Technique::Area), 10 * n);
    assert_eq!(rays(Technique::SolidAngle), 10 * n);
    assert_eq!(rays(Technique::Cosine), 10);
    assert_eq!(rays(Technique::Mis(Heuristic::Balance)), 10 * (n + 1));
}
