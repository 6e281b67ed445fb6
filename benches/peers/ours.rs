//! etendue's side of the comparison with other programs: the same rays, the same rooms, one line of JSON a run.
//!
//! ```sh
//! cargo bench --bench ours -- rays disk 100000 random      # shadow rays against a mesh, as benches/peers/embree.c traces them
//! cargo bench --bench ours -- room c 65536                 # 65 points, so many samples each, as mitsuba_room.py
//! cargo bench --bench ours -- target c 1e-3                # one point in mid-penumbra, until its standard error is that small
//! ```
//!
//! One thread. Rooms: source at z = 2, occluder at z = 1, 65 points on x in [−1.5, 1.5] of the plane z = 0.

use std::time::Instant;

use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::estimator::{Job, Scratch, for_technique};
use etendue::geometry::{DVec3, Disk, Mesh, Rectangle, Shape};
use etendue::oracle::Oracle;
use etendue::radiometry::Exitance;
use etendue::sampling::{BLOCK, LANES, Strategy, StreamKey};
use etendue::scene::{Hierarchy, ShadowRays};

const POINTS: usize = 65;
const SAMPLES: usize = 16_384;
const ROUNDS: usize = 7;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["rays", mesh, triangles, order] => rays(mesh, triangles.parse().expect("a number of triangles"), order),
        ["target", letter, error] => target(letter, error.parse().expect("a relative standard error")),
        ["room", letter, samples] => room(letter, samples.parse().expect("a number of samples"), Strategy::Random),
        ["room", letter, samples, strategy] => {
            let strategy = Strategy::from_name(strategy).expect("a strategy's name");
            room(letter, samples.parse().expect("a number of samples"), strategy);
        }
        _ => {
            for (mesh, order) in [("disk", "random"), ("disk", "strat"), ("sphere", "random"), ("sphere", "strat")] {
                rays(mesh, 100_000, order);
            }
            for letter in ["a", "b", "c", "d", "e"] {
                room(letter, 16_384, Strategy::Random);
            }
        }
    }
}

/// Median of seconds, and what the last round gave.
fn timed<T>(mut work: impl FnMut() -> T) -> (f64, T) {
    let mut last = work();
    let mut seconds: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            last = std::hint::black_box(work());
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    (seconds[ROUNDS / 2], last)
}

/// The x of a point; Embree's figure wants it in f32.
fn across(point: usize) -> f64 {
    f64::from(-1.5_f32 + 3.0 * point as f32 / 64.0)
}

/// SplitMix64 of an index: the same rays in every program.
fn mix(i: u64) -> u64 {
    let mut z = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Rays by the block, from one point each, and their number.
fn prepared(order: &str) -> Vec<(DVec3, ShadowRays)> {
    let side = SAMPLES.isqrt();
    let unit = |bits: u64| bits as f32 / 16_777_216.0;
    let direction = |i: usize| {
        let hash = mix(i as u64);
        let (mut u, mut v) = (unit(hash >> 40), unit((hash >> 16) & 0xff_ffff));
        if order == "strat" {
            // A jittered grid, its cells in Morton order.
            let k = i % SAMPLES;
            let cell = |shift: usize| (0..12).fold(0, |cell, bit| cell | ((k >> (2 * bit + shift)) & 1) << bit);
            (u, v) = ((cell(0) as f32 + u) / side as f32, (cell(1) as f32 + v) / side as f32);
        }
        [u - 0.5 - across(i / SAMPLES) as f32, v - 0.5]
    };
    let blocks = (0..POINTS * SAMPLES).step_by(BLOCK).map(|first| {
        let mut rays = ShadowRays::default();
        for k in 0..BLOCK {
            let [x, y] = direction(first + k);
            let (g, l) = (k / LANES, k % LANES);
            (rays.x[g][l], rays.y[g][l], rays.z[g][l]) = (f64::from(x), f64::from(y), 2.0);
        }
        (DVec3::X * across(first / SAMPLES), rays)
    });
    blocks.collect()
}

fn rays(mesh: &str, triangles: usize, order: &str) {
    let mesh_name = mesh;
    let mesh = if mesh == "sphere" { bumpy_sphere(triangles) } else { flat_disk(triangles) };
    let start = Instant::now();
    let hierarchy = Hierarchy::new(&mesh, (DVec3::new(-2.0, -0.5, 0.0), DVec3::new(2.0, 0.5, 2.0)));
    let build = start.elapsed().as_secs_f64();
    let blocks = prepared(order);
    let (seconds, hits) = timed(|| {
        let mut left = 0.0;
        for (from, rays) in &blocks {
            let mut carried = [[1.0; LANES]; BLOCK / LANES];
            hierarchy.shade(*from, rays, BLOCK, &mut carried, None);
            left += carried.as_flattened().iter().sum::<f64>();
        }
        (POINTS * SAMPLES) as f64 - left
    });
    println!(
        "{{\"who\":\"etendue\",\"mesh\":\"{mesh_name}\",\"order\":\"{order}\",\"tris\":{},\"hits\":{hits},\"build_ms\":{:.1},\
         \"mrays_per_s\":{:.3},\"peak_mib\":{:.1}}}",
        mesh.triangles().len(),
        build * 1e3,
        (POINTS * SAMPLES) as f64 / seconds / 1e6,
        peak_mib(),
    );
}

/// A room of the comparison, seen from some of its points.
fn configuration(letter: &str, points: std::ops::Range<usize>) -> Configuration {
    let rectangle =
        |z: f64, side: f64| Shape::Rectangle(Rectangle::new(DVec3::Z * z, DVec3::Y * side, DVec3::X * side).unwrap());
    let disk = |z: f64, radius: f64| Shape::Disk(Disk::new(DVec3::Z * z, -DVec3::Z, radius).unwrap());
    let (source, occluders) = match letter {
        "a" => (disk(2.0, 0.5), vec![]),
        "b" => (rectangle(2.0, 1.0), vec![]),
        "c" => (rectangle(2.0, 1.0), vec![rectangle(1.0, 0.7)]),
        "d" => (disk(2.0, 0.5), vec![disk(1.0, 0.35)]),
        "e" => (rectangle(2.0, 1.0), vec![Shape::Mesh(flat_disk(100_000))]),
        "f" => (rectangle(2.0, 1.0), vec![Shape::Mesh(flat_disk(1_000_000))]),
        _ => panic!("no room {letter}: a to f"),
    };
    let source = Source::new(source, Exitance::new(1.0)).unwrap();
    let points = points.map(|k| MeasurementPoint::new(DVec3::X * (3.0 * k as f64 / 64.0 - 1.5), DVec3::Z).unwrap());
    Configuration::new(vec![source], occluders, None, points.collect(), Arrangement::Line).unwrap()
}

/// From the start of the process to a standard error, told by the spread of replicates of 1024 samples.
fn target(letter: &str, error: f64) {
    let configuration = configuration(letter, 47..48);
    let estimator = for_technique(&configuration, Strategy::Random.technique());
    let (mut scratch, mut estimates) = (Scratch::default(), vec![0.0; 64]);
    let (mut n, mut mean, mut squares) = (0.0, 0.0, 0.0);
    let reached = |n: f64, mean: f64, squares: f64| n > 1.0 && (squares / (n - 1.0) / n).sqrt() <= error * mean;
    while !reached(n, mean, squares) {
        let replicates = n as u64..n as u64 + 64;
        let job = Job {
            strategy: Strategy::Random,
            samples: 1024,
            cell: StreamKey::root(1),
            replicates,
            points: configuration.points(),
        };
        estimator.estimate(&job, &mut scratch, &mut estimates);
        for estimate in &estimates {
            n += 1.0;
            let step = estimate - mean;
            mean += step / n;
            squares += step * (estimate - mean);
        }
    }
    println!("{{\"who\":\"etendue\",\"room\":\"{letter}\",\"samples\":{},\"mean\":{mean:.9}}}", n * 1024.0);
}

fn room(letter: &str, samples: u64, strategy: Strategy) {
    let configuration = configuration(letter, 0..POINTS);
    let estimator = for_technique(&configuration, strategy.technique());
    let points = configuration.points();
    let (mut scratch, mut estimates) = (Scratch::default(), vec![0.0; POINTS]);
    let mut round = 0;
    let (seconds, ()) = timed(|| {
        round += 1;
        let job = Job { strategy, samples, cell: StreamKey::root(round), replicates: 0..1, points };
        estimator.estimate(&job, &mut scratch, std::hint::black_box(&mut estimates));
    });
    let oracle = Oracle::new(&configuration);
    let worst = points
        .iter()
        .zip(&estimates)
        .map(|(point, estimate)| (estimate - oracle.at(point).irradiance.watts_per_square_metre()).abs());
    println!(
        "{{\"who\":\"etendue\",\"room\":\"{letter}\",\"strategy\":\"{strategy}\",\"samples\":{samples},\"msamples_per_s\":{:.3},\
         \"worst_error\":{:.2e},\"peak_mib\":{:.1}}}",
        samples as f64 * POINTS as f64 / seconds / 1e6,
        worst.fold(0.0, f64::max),
        peak_mib(),
    );
}

/// A disk of radius 0.35 at height 1, in rings of a polygon.
fn flat_disk(triangles: usize) -> Mesh {
    let spokes = if triangles == 100_000 { 224 } else { (triangles as f64 / 2.0).sqrt().round() as usize };
    let mut vertices = vec![DVec3::Z];
    for ring in 1..=spokes {
        for spoke in 0..spokes {
            let turn = std::f64::consts::TAU * spoke as f64 / spokes as f64;
            let radius = 0.35 * ring as f64 / spokes as f64;
            vertices.push(single(DVec3::new(radius * turn.cos(), radius * turn.sin(), 1.0)));
        }
    }
    let at = |ring: usize, spoke: usize| (1 + (ring - 1) * spokes + spoke % spokes) as u32;
    let mut faces: Vec<[u32; 3]> = (0..spokes).map(|j| [0, at(1, j), at(1, j + 1)]).collect();
    for i in 1..spokes {
        for j in 0..spokes {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    Mesh::new(vertices, faces).expect("a disk")
}

/// A sphere of radius 0.35 around height 1, with bumps of a tenth.
fn bumpy_sphere(triangles: usize) -> Mesh {
    let around = (triangles as f64).sqrt().round() as usize;
    let rows = around / 2 + 1;
    let radius =
        |polar: f64, turn: f64| f64::from((0.35 * (1.0 + 0.1 * (7.0 * polar).sin() * (9.0 * turn).sin())) as f32);
    let mut vertices =
        vec![DVec3::Z * (1.0 + radius(0.0, 0.0)), DVec3::Z * (1.0 - radius(std::f64::consts::PI, 0.0))];
    for i in 1..rows {
        for j in 0..around {
            let polar = std::f64::consts::PI * i as f64 / rows as f64;
            let turn = std::f64::consts::TAU * j as f64 / around as f64;
            let r = radius(polar, turn);
            let across = r * polar.sin();
            vertices.push(single(DVec3::new(across * turn.cos(), across * turn.sin(), 1.0 + r * polar.cos())));
        }
    }
    let at = |i: usize, j: usize| (2 + (i - 1) * around + j % around) as u32;
    let mut faces: Vec<[u32; 3]> = (0..around).map(|j| [0, at(1, j), at(1, j + 1)]).collect();
    for i in 1..rows - 1 {
        for j in 0..around {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    faces.extend((0..around).map(|j| [1, at(rows - 1, j + 1), at(rows - 1, j)]));
    Mesh::new(vertices, faces).expect("a sphere")
}

/// Rounded to f32, as the other programs hold it.
fn single(p: DVec3) -> DVec3 {
    p.as_vec3().as_dvec3()
}

/// The most memory that this process has held, MiB; 0 where the system does not say.
fn peak_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kib.unwrap_or(0.0) / 1024.0
}
