//! What an exact value costs: microseconds a point, one thread; and maps of the shipped eclipse on all cores.
//!
//! `cargo bench --bench oracle`: median of several rounds; `-- NAME` asks for
//! what has this in its name only (`penumbra` and `map` are names too). Derivatives and numbers of twice the width are given beside the
//! plain value of the same room, as ratios.

use std::time::Instant;

use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Disk, Polygon, Rectangle, Shape, Sphere};
use etendue::oracle::{Oracle, Parameter};
use etendue::radiometry::Exitance;
use rayon::prelude::*;

const ROUNDS: usize = 7;

fn main() {
    let square =
        |z: f64, side: f64| Shape::Rectangle(Rectangle::new(DVec3::Z * z, DVec3::Y * side, DVec3::X * side).unwrap());
    let disk = |z: f64, radius: f64| Shape::Disk(Disk::new(DVec3::Z * z, -DVec3::Z, radius).unwrap());
    let ball = |z: f64, radius: f64| Shape::Sphere(Sphere::new(DVec3::Z * z, radius).unwrap());
    let pentagon = Shape::Polygon(
        Polygon::new(
            [(0.5, 0.0), (-0.4, 0.3), (-0.5, 0.1), (-0.3, -0.3), (0.2, -0.5)]
                .map(|(x, y)| DVec3::new(y, x, 2.0))
                .to_vec(),
        )
        .unwrap(),
    );
    let sixteen = (0..16)
        .map(|i| {
            let at =
                DVec3::new(0.15 * f64::from(i % 4) - 0.2, 0.15 * f64::from(i / 4) - 0.2, 0.9 + 0.01 * f64::from(i));
            match i % 3 {
                0 => Shape::Disk(Disk::new(at, DVec3::new(0.1, 0.2, 1.0), 0.07).unwrap()),
                1 => Shape::Rectangle(Rectangle::new(at, DVec3::X * 0.12, DVec3::Y * 0.1).unwrap()),
                _ => Shape::Sphere(Sphere::new(at, 0.06).unwrap()),
            }
        })
        .collect();
    let rooms = [
        ("disk", room(disk(2.0, 0.5), vec![])),
        ("rectangle", room(square(2.0, 1.0), vec![])),
        ("pentagon", room(pentagon, vec![])),
        ("sphere", room(ball(2.0, 0.5), vec![])),
        ("rectangle behind rectangle", room(square(2.0, 1.0), vec![square(1.0, 0.7)])),
        ("disk behind disk", room(disk(2.0, 0.5), vec![disk(1.0, 0.35)])),
        ("sphere behind sphere", room(ball(2.0, 0.5), vec![ball(1.0, 0.35)])),
        ("rectangle behind disk", room(square(2.0, 1.0), vec![disk(1.0, 0.35)])),
        ("rectangle behind 16 mixed", room(square(2.0, 1.0), sixteen)),
    ];
    let wanted = std::env::args().skip(1).find(|argument| !argument.starts_with('-')).unwrap_or_default();
    println!("{:<30} {:>10} {:>10}", "exact value", "µs/point", "ratio");
    for (name, room) in rooms.iter().filter(|(name, _)| name.contains(&wanted)) {
        let oracle = Oracle::new(room);
        println!("{name:<30} {:>10.2}", microseconds(room.points(), |point| oracle.at(point).form_factor.ratio()));
    }
    if "penumbra".contains(&wanted) {
        penumbra(&disk);
    }
    if "map".contains(&wanted) {
        map(&room(disk(2.0, 0.5), vec![disk(1.0, 0.35)]));
    }
}

/// Derivatives and numbers of twice the width, beside the plain value.
fn penumbra(disk: &impl Fn(f64, f64) -> Shape) {
    let eclipse = room(disk(2.0, 0.5), vec![disk(1.0, 0.35)]);
    let penumbra: Vec<MeasurementPoint> = points(33, 0.3, 0.9);
    let crescent: Vec<MeasurementPoint> = points(33, 0.2005, 0.203);
    let oracle = Oracle::new(&eclipse);
    let plain = microseconds(&penumbra, |point| oracle.at(point).form_factor.ratio());
    println!("{:<30} {plain:>10.2} {:>10.2}", "penumbra, plain", 1.0);
    let wide = microseconds(&crescent, |point| oracle.at(point).form_factor.ratio());
    println!("{:<30} {wide:>10.2} {:>10.2}", "penumbra, twice the width", wide / plain);
    let all = "source.0.center.x,source.0.center.y,source.0.center.z,source.0.normal.x,source.0.normal.y,source.0.normal.z,\
               source.0.radius,occluder.0.center.x,occluder.0.center.y,occluder.0.center.z,occluder.0.normal.x,\
               occluder.0.normal.y,occluder.0.normal.z,occluder.0.radius,point.position.x,point.position.y,\
               point.position.z,point.normal.x,point.normal.y,point.normal.z";
    let all: Vec<Parameter> = all.split(',').map(|path| path.trim().parse().unwrap()).collect();
    for count in [1, 8, 20] {
        let parameters = oracle.parameters(&eclipse, &all[..count]).unwrap();
        let time = microseconds(&penumbra, |point| oracle.derivatives(point, &parameters).values.unwrap()[0]);
        println!("{:<30} {time:>10.2} {:>10.2}", format!("penumbra, {count} derivatives"), time / plain);
    }
}

/// A million points on all cores.
fn map(eclipse: &Configuration) {
    let oracle = Oracle::new(eclipse);
    let side = 1000_u32;
    let start = Instant::now();
    let seen: f64 = (0..side)
        .into_par_iter()
        .map(|row| {
            let at = |i: u32| 4.0 * (f64::from(i) + 0.5) / f64::from(side) - 2.0;
            let values = (0..side).map(|column| {
                let point = MeasurementPoint::new(DVec3::new(at(column), at(row), 0.0), DVec3::Z).unwrap();
                oracle.at(&point).form_factor.ratio()
            });
            values.sum::<f64>()
        })
        .sum();
    let pixels = f64::from(side) * f64::from(side);
    println!(
        "a map of the eclipse, {side} x {side} points on {} threads: {:.2} s (mean form factor {:.6})",
        rayon::current_num_threads(),
        start.elapsed().as_secs_f64(),
        seen / pixels
    );
}

fn points(n: i32, from: f64, to: f64) -> Vec<MeasurementPoint> {
    let point = |k: i32| {
        let x = from + (to - from) * f64::from(k) / f64::from(n - 1);
        MeasurementPoint::new(DVec3::X * x, DVec3::Z).unwrap()
    };
    (0..n).map(point).collect()
}

/// 65 points from under the centre to beyond the shadow.
fn room(source: Shape, occluders: Vec<Shape>) -> Configuration {
    let source = Source::new(source, Exitance::new(1.0)).unwrap();
    Configuration::new(vec![source], occluders, None, points(65, 0.0, 1.5), Arrangement::Line).unwrap()
}

fn microseconds(points: &[MeasurementPoint], answer: impl Fn(&MeasurementPoint) -> f64) -> f64 {
    let mut rounds: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            let repeats = 40;
            for _ in 0..repeats {
                for point in points {
                    std::hint::black_box(answer(std::hint::black_box(point)));
                }
            }
            start.elapsed().as_secs_f64() * 1e6 / (f64::from(repeats) * points.len() as f64)
        })
        .collect();
    rounds.sort_by(f64::total_cmp);
    rounds[ROUNDS / 2]
}
