//! Nanoseconds per sample of the estimator's inner loop, random numbers, visibility and sums included.
//!
//! `cargo bench --bench inner_loop`: one thread, median of several rounds.

use std::time::Instant;

use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::estimator::{Job, Scratch, for_technique};
use etendue::geometry::{DVec3, Disk, Polygon, Rectangle, Shape, Sphere};
use etendue::radiometry::Exitance;
use etendue::sampling::{Strategy, StreamKey};

const ROUNDS: usize = 3;
const SAMPLES_A_ROUND: u64 = 8_000_000;

fn main() {
    let square =
        |z: f64, side: f64| Shape::Rectangle(Rectangle::new(DVec3::Z * z, DVec3::Y * side, DVec3::X * side).unwrap());
    let disk = |z: f64, radius: f64| Shape::Disk(Disk::new(DVec3::Z * z, -DVec3::Z, radius).unwrap());
    let ball = Shape::Sphere(Sphere::new(DVec3::Z * 2.0, 0.5).unwrap());
    let rooms = [
        ("rectangle", room(square(2.0, 1.0), vec![])),
        ("rectangle behind rectangle", room(square(2.0, 1.0), vec![square(1.0, 0.7)])),
        ("disk behind disk", room(disk(2.0, 0.5), vec![disk(1.0, 0.35)])),
        ("L", room(l_shape(), vec![])),
        ("sphere behind disk", room(ball, vec![disk(1.0, 0.35)])),
    ];
    println!("{:<30} {:>15} {:>6} {:>10}", "room", "strategy", "N", "ns/sample");
    for (name, room) in &rooms {
        for strategy in Strategy::ALL {
            for samples in [1, 16, 1024] {
                println!("{name:<30} {strategy:>15} {samples:>6} {:>10.2}", nanoseconds(room, strategy, samples));
            }
        }
    }
}

/// Facing down, with a re-entrant corner.
fn l_shape() -> Shape {
    let corners = [[0.0, 0.0], [0.0, 1.0], [0.5, 1.0], [0.5, 0.5], [1.0, 0.5], [1.0, 0.0]];
    Shape::Polygon(Polygon::new(corners.map(|[x, y]| DVec3::new(x - 0.5, y - 0.5, 2.0)).to_vec()).unwrap())
}

/// 65 points from under the centre to beyond the shadow.
fn room(source: Shape, occluders: Vec<Shape>) -> Configuration {
    let source = Source::new(source, Exitance::new(1.0)).unwrap();
    let point = |k: i32| MeasurementPoint::new(DVec3::X * (1.5 * f64::from(k) / 64.0), DVec3::Z).unwrap();
    Configuration::new(vec![source], occluders, None, (0..65).map(point).collect(), Arrangement::Line).unwrap()
}

fn nanoseconds(room: &Configuration, strategy: Strategy, samples: u64) -> f64 {
    let estimator = for_technique(room, strategy.technique());
    let points = room.points();
    let replicates = SAMPLES_A_ROUND / (samples * points.len() as u64);
    let (mut scratch, mut estimates) = (Scratch::default(), vec![0.0; points.len() * 256]);
    let mut rounds: Vec<f64> = (0..ROUNDS as u64)
        .map(|round| {
            let cell = StreamKey::root(round);
            let start = Instant::now();
            for first in (0..replicates).step_by(256) {
                let replicates = first..(first + 256).min(replicates);
                let out = &mut estimates[..points.len() * (replicates.end - replicates.start) as usize];
                let job = Job { strategy, samples, cell, replicates, points };
                estimator.estimate(&job, &mut scratch, std::hint::black_box(out));
            }
            start.elapsed().as_secs_f64() * 1e9 / (replicates * samples * points.len() as u64) as f64
        })
        .collect();
    rounds.sort_by(f64::total_cmp);
    rounds[ROUNDS / 2]
}
