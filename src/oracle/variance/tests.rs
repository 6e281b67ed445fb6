//! Predicted spreads by other routes: quadrature of the sources times their own kernel, and brute force over fine grids.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Contribution, RELATIVE_ERROR};
use crate::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use crate::geometry::{Disk, Polygon, Rectangle, Shape, Sphere};
use crate::oracle::Oracle;
use crate::radiometry::Exitance;

fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn sources() -> Vec<Shape> {
    let l = [(0.0, 0.0), (0.0, 1.0), (0.5, 1.0), (0.5, 0.5), (1.0, 0.5), (1.0, 0.0)];
    let convex = [(0.0, -0.4), (-0.5, 0.0), (-0.2, 0.6), (0.4, 0.5), (0.6, 0.0)];
    let polygon = |corners: &[(f64, f64)]| {
        Shape::Polygon(Polygon::new(corners.iter().map(|(x, y)| at(*x - 0.2, *y - 0.2, 2.0)).collect()).unwrap())
    };
    vec![
        Shape::Disk(Disk::new(at(0.1, 0.0, 2.0), at(0.1, 0.0, -1.0), 0.6).unwrap()),
        Shape::Rectangle(Rectangle::new(at(0.0, 0.1, 2.0), at(0.0, 1.2, 0.0), at(0.9, 0.0, 0.3)).unwrap()),
        Shape::Sphere(Sphere::new(at(0.0, 0.1, 2.0), 0.5).unwrap()),
        polygon(&[(0.0, 0.0), (0.3, 0.9), (0.9, 0.1)]),
        polygon(&convex),
        polygon(&l),
    ]
}

fn occluders() -> Vec<Vec<Shape>> {
    let disk = Shape::Disk(Disk::new(at(0.2, 0.0, 1.0), at(0.0, 0.2, 1.0), 0.25).unwrap());
    let card = Shape::Rectangle(Rectangle::new(at(-0.2, 0.2, 1.2), at(0.4, 0.1, 0.0), at(-0.1, 0.4, 0.1)).unwrap());
    let ball = Shape::Sphere(Sphere::new(at(0.1, 0.3, 1.1), 0.2).unwrap());
    vec![vec![], vec![disk.clone()], vec![disk, card, ball]]
}

fn rooms() -> Vec<(Configuration, MeasurementPoint)> {
    let mut rooms = Vec::new();
    for shape in sources() {
        for occluders in occluders() {
            for (position, normal) in [(at(0.1, 0.05, 0.0), DVec3::Z), (at(0.9, -0.3, 0.4), at(-0.8, 0.1, 0.2))] {
                let source = Source::new(shape.clone(), Exitance::new(1.5)).unwrap();
                let point = MeasurementPoint::new(position, normal).unwrap();
                let room =
                    Configuration::new(vec![source], occluders.clone(), None, vec![point], Arrangement::Scattered)
                        .unwrap();
                rooms.push((room, point));
            }
        }
    }
    rooms
}

#[test]
fn moments_are_integrals_of_the_source_times_its_kernel() {
    for (room, point) in rooms() {
        let oracle = Oracle::new(&room);
        let moments = oracle.sample_moments(0, &point, Contribution::by_area).unwrap();
        let first = oracle.at(&point).irradiance.watts_per_square_metre();
        let shape = room.sources()[0].shape();
        let (area, exitance) = (shape.area(), 1.5);
        // E X² = ∫ A M² k · k dA with k the kernel: the irradiance of a source whose exitance is A M² k.
        let textured = oracle.by_quadrature_with(&point, &|_: usize, position: DVec3| {
            let way = position - point.position();
            let r2 = way.length_squared();
            let normal = match shape {
                Shape::Sphere(ball) => (position - ball.center()) / ball.radius(),
                Shape::Disk(s) => s.normal(),
                Shape::Rectangle(s) => s.normal(),
                Shape::Polygon(s) => s.normal(),
                Shape::Mesh(_) => unreachable!(),
            };
            let kernel = point.normal().dot(way).max(0.0) * (-normal.dot(way)).max(0.0) / (PI * r2 * r2);
            area * exitance * exitance * kernel
        });
        let second = textured.irradiance.watts_per_square_metre();
        let found = moments.first_moment();
        assert!((found - first).abs() <= 0.5 * RELATIVE_ERROR * first, "{shape:?} at {point:?}: {found} {first}");
        let (variance, due) = (moments.spread().variance, second - first * first);
        assert!(
            (variance - due).abs() <= RELATIVE_ERROR * due + 1e-9 * second,
            "{shape:?} at {point:?}: {variance} {due}"
        );
    }
}

#[test]
fn strata_spread_as_their_own_points_do() {
    // Brute force: 64 × 64 midpoints in each stratum, by the chart and the plain test of a margin.
    for (room, point) in rooms() {
        let oracle = Oracle::new(&room);
        let field = super::Field::new(&oracle, 0, &point).unwrap();
        let rows = |n: u64| {
            // Two rows of two and three for five; four by four for sixteen.
            match n {
                5 => vec![
                    [0.0, 0.5, 0.0, 0.4],
                    [0.5, 1.0, 0.0, 0.4],
                    [0.0, 1.0 / 3.0, 0.4, 1.0],
                    [1.0 / 3.0, 2.0 / 3.0, 0.4, 1.0],
                    [2.0 / 3.0, 1.0, 0.4, 1.0],
                ],
                n => {
                    let side = (n as f64).sqrt();
                    (0..n)
                        .map(|k| {
                            let (i, j) = ((k % side as u64) as f64, (k / side as u64) as f64);
                            [i / side, (i + 1.0) / side, j / side, (j + 1.0) / side]
                        })
                        .collect()
                }
            }
        };
        let counts = [1, 5, 16];
        let spreads = oracle.strata_spreads(&point, &counts, &rows).unwrap();
        for (n, spread) in counts.into_iter().zip(spreads) {
            let fine = if n == 1 { 512 } else { 256 };
            let mut variance = 0.0;
            for [u0, u1, v0, v1] in rows(n) {
                let (mut sum, mut squares) = (0.0, 0.0);
                for i in 0..fine {
                    for j in 0..fine {
                        let place = |k: i32| (f64::from(k) + 0.5) / f64::from(fine);
                        let (u, v) = (u0 + (u1 - u0) * place(i), v0 + (v1 - v0) * place(j));
                        let (direction, landing) = field.at(u, v);
                        if field.margin(direction) > 0.0 {
                            let x = Contribution::by_area(&landing).value;
                            sum += x;
                            squares += x * x;
                        }
                    }
                }
                let count = f64::from(fine * fine);
                variance += squares / count - (sum / count) * (sum / count);
            }
            variance /= (n * n) as f64;
            let first = oracle.at(&point).irradiance.watts_per_square_metre();
            // Midpoints know an edge to 1/256 of a stratum, and each stratum's sign is its own.
            let allowed = 4e-3 * variance + 1e-10 * first * first;
            assert!(
                (spread.variance - variance).abs() <= allowed,
                "{:?} N = {n}: {} {variance}",
                room.sources()[0].shape(),
                spread.variance
            );
        }
    }
}

#[test]
fn shared_samples_agree_with_single_points() {
    let source = Source::new(sources().swap_remove(1), Exitance::new(1.5)).unwrap();
    let points: Vec<MeasurementPoint> =
        (0..5).map(|i| MeasurementPoint::new(at(0.2 * f64::from(i), 0.1, 0.0), DVec3::Z).unwrap()).collect();
    for occluders in occluders() {
        let room = Configuration::new(vec![source.clone()], occluders, None, points.clone(), Arrangement::Scattered)
            .unwrap();
        let oracle = Oracle::new(&room);
        let unit = |k: usize| (0..5).map(|p| if p == k { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
        let weights = vec![unit(0), unit(1), unit(2), unit(3), unit(4), vec![1.0; 5]];
        let pairs: Vec<(usize, usize)> = (0..5).flat_map(|i| (0..5).map(move |j| (i, j))).collect();
        let shared = oracle.shared_samples(&points, &weights, &pairs).unwrap();
        for (p, point) in points.iter().enumerate() {
            let alone = oracle.sample_moments(0, point, Contribution::by_area).unwrap().spread();
            let off = (shared.variances[p] / alone.variance - 1.0).abs();
            assert!(off < RELATIVE_ERROR, "point {p}: {off}");
            assert!((shared.sums[p].variance / shared.variances[p] - 1.0).abs() < 1e-9);
            assert!((shared.sums[p].fourth_cumulant - alone.fourth_cumulant).abs() < 1e-2 * alone.fourth_moment());
        }
        let together: f64 = shared.covariances.iter().sum();
        assert!((together / shared.sums[5].variance - 1.0).abs() < 1e-9);
    }
}

#[test]
fn directions_that_hardly_differ_spread_as_a_cap_does() {
    // A ball straight above: cosθ is uniform over [c, 1], c² = 1 − R²/d², so X = M Ω cosθ/π has variance (M Ω (1 − c)/π)²/12.
    for radius in [0.9, 0.1, 0.01] {
        let ball = Shape::Sphere(Sphere::new(at(0.0, 0.0, 2.0), radius).unwrap());
        let source = Source::new(ball, Exitance::new(1.5)).unwrap();
        let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
        let room = Configuration::new(vec![source], vec![], None, vec![point], Arrangement::Scattered).unwrap();
        let drop = {
            let s2 = radius * radius / 4.0;
            s2 / (1.0 + (1.0 - s2).sqrt())
        };
        let solid_angle = 2.0 * PI * drop;
        let moments = Oracle::new(&room)
            .sample_moments(0, &point, |place| Contribution::by_solid_angle(place, solid_angle))
            .unwrap();
        let due = (1.5 * solid_angle * drop / PI).powi(2) / 12.0;
        let found = moments.spread().variance;
        assert!((found / due - 1.0).abs() < RELATIVE_ERROR, "radius {radius}: {found} {due}");
    }
}
