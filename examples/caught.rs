//! What does it look like when a sampler is wrong?
//!
//! `cargo run --example caught`

use std::f64::consts::TAU;

use etendue::configuration::MeasurementPoint;
use etendue::geometry::Shape;
use etendue::{Case, Configuration, Draws, Verdict, judge};

/// Two classic slips in one estimator of a disk source. Without either it is right.
fn slipped(room: &Configuration, point: &MeasurementPoint, draws: &mut Draws, slip: Slip) -> f64 {
    let source = &room.sources()[0];
    let Shape::Disk(disk) = source.shape() else { return f64::NAN };
    let (x, y) = disk.normal().any_orthonormal_pair();
    let u = draws.unit();
    // Slip one: r = u crowds the points into the middle.
    let share = if slip == Slip::RadiusIsNoRoot { u } else { u.sqrt() };
    let (sine, cosine) = (TAU * draws.unit()).sin_cos();
    let d = disk.center() + (x * cosine + y * sine) * (disk.radius() * share) - point.position();
    let cos_i = point.normal().dot(d).max(0.0) / d.length();
    // Slip two: the density per area is turned into one per solid angle, and its cosine is lost.
    let cos_s = if slip == Slip::CosineLost { 1.0 } else { (-disk.normal().dot(d)).max(0.0) / d.length() };
    source.exitance().watts_per_square_metre() * disk.radius().powi(2) * cos_i * cos_s / d.length_squared()
}

#[derive(Clone, Copy, PartialEq)]
enum Slip {
    None,
    RadiusIsNoRoot,
    CosineLost,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let case = Case::shipped("direct/disk-over-plane")?;
    for (slip, name, expected) in [
        (Slip::None, "no slip", Verdict::Pass),
        (Slip::RadiusIsNoRoot, "r = u", Verdict::Fail),
        (Slip::CosineLost, "a cosine lost", Verdict::Fail),
    ] {
        let estimator = |room: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws| {
            (0..samples).map(|_| slipped(room, point, draws, slip)).sum::<f64>() / samples as f64
        };
        let judgement = judge(&case).quick().samples(&[4]).estimator(name, &estimator);
        println!("{judgement}\n");
        assert_eq!(judgement.verdict(), expected);
    }
    Ok(())
}

#[test]
fn what_is_wrong_is_caught_and_what_is_right_is_not() {
    main().unwrap();
}
