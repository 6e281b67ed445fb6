//! The shipped cases show what their comments say: the borders of umbra and penumbra lie where they are said to lie.
//!
//! What a point sees is counted here by brute force over a lattice of source points, with plain segment tests that are
//! used nowhere else.

use etendue::case::{Case, shipped};
use etendue::configuration::{Configuration, MeasurementPoint};
use etendue::geometry::{DVec3, Shape};

/// Lattice points along each side of a source's parameter square.
const LATTICE: usize = 64;

/// A point of a source and its outward normal there; `None` outside of a polygon.
fn source_point(shape: &Shape, s: f64, t: f64) -> Option<(DVec3, DVec3)> {
    let turn = std::f64::consts::TAU * s;
    match shape {
        Shape::Disk(d) => {
            let (a, b) = axes(d.normal());
            Some((d.center() + (a * turn.cos() + b * turn.sin()) * (d.radius() * t.sqrt()), d.normal()))
        }
        Shape::Rectangle(r) => Some((r.center() + r.edge_u() * (s - 0.5) + r.edge_v() * (t - 0.5), r.normal())),
        Shape::Polygon(p) => {
            let (a, b) = axes(p.normal());
            let origin = p.vertices()[0];
            let flat: Vec<[f64; 2]> =
                p.vertices().iter().map(|v| [(*v - origin).dot(a), (*v - origin).dot(b)]).collect();
            let range = |k: usize| {
                let values = flat.iter().map(|v| v[k]);
                (values.clone().fold(f64::MAX, f64::min), values.fold(f64::MIN, f64::max))
            };
            let ((x0, x1), (y0, y1)) = (range(0), range(1));
            let at = [x0 + (x1 - x0) * s, y0 + (y1 - y0) * t];
            inside(&flat, at).then(|| (origin + a * at[0] + b * at[1], p.normal()))
        }
        Shape::Sphere(ball) => {
            let z = 2.0 * t - 1.0;
            let ring = (1.0 - z * z).sqrt();
            let out = DVec3::new(ring * turn.cos(), ring * turn.sin(), z);
            Some((ball.center() + out * ball.radius(), out))
        }
        other => panic!("no lattice for a {}", other.kind()),
    }
}

fn axes(normal: DVec3) -> (DVec3, DVec3) {
    let a = normal.any_orthonormal_vector();
    (a, normal.cross(a))
}

fn inside(outline: &[[f64; 2]], p: [f64; 2]) -> bool {
    let mut inside = false;
    for (i, a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        if (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1]) {
            inside = !inside;
        }
    }
    inside
}

/// Whether a shape blocks the open segment.
fn blocks(shape: &Shape, from: DVec3, to: DVec3) -> bool {
    let on_plane = |anchor: DVec3, normal: DVec3| {
        let (a, b) = ((from - anchor).dot(normal), (to - anchor).dot(normal));
        (a * b < 0.0).then(|| from + (to - from) * (a / (a - b)))
    };
    match shape {
        Shape::Disk(d) => {
            on_plane(d.center(), d.normal()).is_some_and(|hit| (hit - d.center()).length() < d.radius())
        }
        Shape::Rectangle(r) => on_plane(r.center(), r.normal()).is_some_and(|hit| {
            let along = |edge: DVec3| ((hit - r.center()).dot(edge) / edge.length_squared()).abs() < 0.5;
            along(r.edge_u()) && along(r.edge_v())
        }),
        Shape::Polygon(p) => on_plane(p.vertices()[0], p.normal()).is_some_and(|hit| {
            let (a, b) = axes(p.normal());
            let flat: Vec<[f64; 2]> = p.vertices().iter().map(|v| [v.dot(a), v.dot(b)]).collect();
            inside(&flat, [hit.dot(a), hit.dot(b)])
        }),
        Shape::Sphere(ball) => {
            let along = to - from;
            let nearest = ((ball.center() - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            (from + along * nearest - ball.center()).length() < ball.radius()
        }
        other => panic!("no segment test for a {}", other.kind()),
    }
}

/// Of the light that would arrive with neither occluder nor horizon, the share that does.
fn visible_share(configuration: &Configuration, point: &MeasurementPoint) -> f64 {
    let (mut all, mut seen) = (0.0, 0.0);
    for (index, source) in configuration.sources().iter().enumerate() {
        let others = configuration.sources().iter().enumerate().filter(|(i, _)| *i != index).map(|(_, s)| s.shape());
        let blockers: Vec<&Shape> = others.chain(configuration.occluders()).collect();
        for k in 0..LATTICE * LATTICE {
            let cell = |i: usize| (i as f64 + 0.5) / LATTICE as f64;
            let Some((at, normal)) = source_point(source.shape(), cell(k % LATTICE), cell(k / LATTICE)) else {
                continue;
            };
            let towards = at - point.position();
            let leaving = -normal.dot(towards) / towards.length();
            if leaving <= 0.0 {
                continue;
            }
            let weight = source.exitance().watts_per_square_metre() * leaving / towards.length_squared();
            all += weight;
            let blocked = || blockers.iter().any(|shape| blocks(shape, point.position(), at));
            if point.normal().dot(towards) > 0.0 && !blocked() {
                seen += weight;
            }
        }
    }
    seen / all
}

fn shares(case: &Case) -> Vec<f64> {
    case.configuration.points().iter().map(|point| visible_share(&case.configuration, point)).collect()
}

#[test]
#[ignore]
fn dump() {
    for entry in shipped() {
        if entry.name().contains("mesh") {
            continue;
        }
        let case = entry.read().unwrap_or_else(|e| panic!("{e}"));
        let shares = shares(&case);
        println!("{}", case.name);
        let kind = |s: f64| {
            if s == 0.0 {
                "umbra"
            } else if s > 1.0 - 1e-12 {
                "lit"
            } else {
                "part"
            }
        };
        let mut last = "";
        for (p, s) in case.configuration.points().iter().zip(&shares) {
            if kind(*s) != last || *s < 1e-3 && *s > 0.0 {
                last = kind(*s);
                let (q, n) = (p.position(), p.normal());
                print!("  {last} from {:.4},{:.4} {:.3}deg {s:.5} ", q.x, q.y, n.x.atan2(n.z).to_degrees());
            }
        }
        println!();
    }
}
