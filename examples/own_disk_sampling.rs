//! Is my way of sampling a disk right?
//!
//! `cargo run --example own_disk_sampling`

use std::f64::consts::{PI, TAU};

use etendue::configuration::MeasurementPoint;
use etendue::geometry::{Disk, Shape};
use etendue::{Case, Configuration, Draws, judge};

/// My own estimator: N points on the disk, r = R √u, and the average of A M cosθᵢ cosθₛ / (π d²).
fn by_my_points(room: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws) -> f64 {
    let source = &room.sources()[0];
    let Shape::Disk(disk) = source.shape() else { return f64::NAN };
    let strength = PI * disk.radius().powi(2) * source.exitance().watts_per_square_metre() / PI;
    let sum: f64 = (0..samples).map(|_| kernel(disk, point, draws.unit().sqrt(), draws.unit())).sum();
    strength * sum / samples as f64
}

/// cosθᵢ cosθₛ / d² of the place at `share` of the radius, at angle 2π `turn`.
fn kernel(disk: &Disk, point: &MeasurementPoint, share: f64, turn: f64) -> f64 {
    let (x, y) = disk.normal().any_orthonormal_pair();
    let (sine, cosine) = (TAU * turn).sin_cos();
    let d = disk.center() + (x * cosine + y * sine) * (disk.radius() * share) - point.position();
    let (cos_i, cos_s) = (point.normal().dot(d).max(0.0), (-disk.normal().dot(d)).max(0.0));
    cos_i * cos_s / d.length_squared().powi(2)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let case = Case::shipped("direct/disk-over-plane")?;
    let judgement = judge(&case).quick().samples(&[1, 16]).estimator("my disk", &by_my_points);
    println!("{judgement}");
    judgement.assert_passes();
    Ok(())
}

#[test]
fn my_disk_sampling_is_unbiased() {
    main().unwrap();
}
