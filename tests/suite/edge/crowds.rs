//! A thousand occluders, and outlines of thousands of corners: each against the sum of its parts.

use std::f64::consts::PI;

use etendue::Case;
use etendue::case::{Replicates, Study};
use etendue::estimator::{Estimator, Job, Scratch};
use etendue::geometry::{DVec3, Disk, Polygon, Shape, Sphere};
use etendue::oracle::{Oracle, Region};
use etendue::sampling::{Purpose, StreamKey};
use etendue::statistics::budget::seed_of;
use etendue::trial::{Effort, Overrides, Settings};
use etendue::{AreaEstimator, Strategy};

use super::{assert_near, assert_sound, bound, irradiance, point, room, to_parallel_disk, truth};

fn settings() -> Settings {
    let overrides =
        Overrides { samples: Some(vec![16, 64]), replicates: Some(Replicates::Fixed(4096)), ..Overrides::default() };
    Settings { seed: 9, effort: Effort::Quick, overrides }
}

/// A thousand coins at half the height, none before another and none across the lamp's rim: from the lamp's light goes
/// what each of them, as a lamp, would bring.
#[test]
fn a_thousand_occluders_hide_what_each_hides() {
    let lamp = Shape::Disk(Disk::new(DVec3::Z * 2.0, DVec3::NEG_Z, 1.0).unwrap());
    let radius = 0.0078125;
    let coins: Vec<DVec3> = (0..1024)
        .map(|k| DVec3::new(f64::from(k % 32) / 32.0 - 0.484375, f64::from(k / 32) / 32.0 - 0.484375, 1.0))
        .filter(|center| center.truncate().length() < 0.45)
        .collect();
    let beside: Vec<DVec3> = (0..1024 - coins.len()).map(|k| DVec3::new(2.0 + k as f64 / 32.0, 0.0, 1.0)).collect();
    let blocks =
        |kind: fn(DVec3, f64) -> Shape| coins.iter().chain(&beside).map(|center| kind(*center, radius)).collect();
    let disks: Vec<Shape> = blocks(|center, radius| Shape::Disk(Disk::new(center, DVec3::Z, radius).unwrap()));
    let balls: Vec<Shape> = blocks(|center, radius| Shape::Sphere(Sphere::new(center, radius).unwrap()));
    assert!(disks.len() == 1024 && coins.len() > 500, "{}", coins.len());
    let found = truth(lamp.clone(), disks.clone(), DVec3::ZERO, DVec3::Z);
    let hidden: f64 = coins.iter().map(|c| to_parallel_disk(1.0, c.truncate().length(), radius)).sum();
    assert_near("disks", &found, to_parallel_disk(2.0, 0.0, 1.0) - hidden, 1e-12);
    assert_eq!(found.region, Region::Penumbra);
    // A ball's cone: (R/d)² times the cosine.
    let found = truth(lamp.clone(), balls, DVec3::ZERO, DVec3::Z);
    let hidden: f64 = coins.iter().map(|c| radius * radius / c.length_squared() * (c.z / c.length())).sum();
    assert_near("balls", &found, to_parallel_disk(2.0, 0.0, 1.0) - hidden, 1e-12);
    // The estimator's own way past a thousand.
    let at = [point(DVec3::ZERO, DVec3::Z)];
    let room = room(vec![(lamp, 1.0)], disks, at.to_vec());
    let cell = StreamKey::cell(seed_of("a_thousand_occluders"), 0, Purpose::Measurement, Strategy::Random, 1024);
    let mut estimates = [f64::NAN; 32];
    let job = Job { strategy: Strategy::Random, samples: 1024, cell, replicates: 0..32, points: &at };
    AreaEstimator::new(&room).estimate(&job, &mut Scratch::default(), &mut estimates);
    let mean = estimates.iter().sum::<f64>() / 32.0;
    let spread = estimates.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 31.0;
    let expected = irradiance(&Oracle::new(&room).at(&at[0]));
    assert!(
        (mean - expected).abs() < 7.0 * (spread / 32.0).sqrt(),
        "{mean} ± {}, {expected}",
        (spread / 32.0).sqrt()
    );
    assert!(spread.sqrt() < 0.05 * expected, "{spread:e} {expected:e}");
}

fn ring(corners: u32, radius: f64, height: f64) -> Shape {
    let turn = |k: u32| 2.0 * PI * f64::from(k) / f64::from(corners);
    let corner = |k: u32| DVec3::new(radius * turn(k).cos(), -radius * turn(k).sin(), height);
    Shape::Polygon(Polygon::new((0..corners).map(corner).collect()).unwrap())
}

/// Straight below its middle a regular polygon of n sides brings n/2π times the angle of a side, times the sine of what its
/// plane with the eye is steep by.
fn to_ring(corners: u32, radius: f64, height: f64) -> f64 {
    let n = f64::from(corners);
    let (half, apothem) = (radius * (PI / n).sin(), radius * (PI / n).cos());
    let slant = apothem.hypot(height);
    n / PI * (half / slant).atan() * apothem / slant
}

#[test]
fn outlines_of_thousands_of_corners_are_their_sums() {
    let corners = 4096;
    let wide = ring(corners, 0.5, 2.0);
    let found = truth(wide.clone(), vec![], DVec3::ZERO, DVec3::Z);
    assert_near("a lamp", &found, to_ring(corners, 0.5, 2.0), 1e-12);
    let found = truth(wide.clone(), vec![ring(corners, 0.2, 1.0)], DVec3::ZERO, DVec3::Z);
    assert_near("behind its like", &found, to_ring(corners, 0.5, 2.0) - to_ring(corners, 0.2, 1.0), 1e-11);
    // A shadow's edge across both outlines: no more than the circles' own, which they all but are.
    let at = DVec3::X * 0.25;
    let found = truth(wide.clone(), vec![ring(corners, 0.2, 1.0)], at, DVec3::Z);
    let disk = |height: f64, radius: f64| Shape::Disk(Disk::new(DVec3::Z * height, DVec3::NEG_Z, radius).unwrap());
    let round = truth(disk(2.0, 0.5), vec![disk(1.0, 0.2)], at, DVec3::Z);
    assert!((irradiance(&found) - irradiance(&round)).abs() < 1e-6, "{found:?} {round:?}");
    assert!(bound(&found) < 1e-11 && found.region == Region::Penumbra, "{found:?}");
    let points = [0.0, 0.25].map(|x| point(DVec3::X * x, DVec3::Z)).to_vec();
    let room = room(vec![(ring(256, 0.5, 2.0), 1.0)], vec![ring(256, 0.2, 1.0)], points);
    assert!(Oracle::new(&room).area_moments(0, &room.points()[0]).is_some());
    assert_sound("rings", &[Case::new("rings", "Rings", room, Study::default())], &settings());
}
