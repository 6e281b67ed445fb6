//! The shipped cases of direct light show what their comments say: the borders of umbra and penumbra lie where they are said to lie.
//!
//! What a point sees is counted here by brute force over a lattice of source points, with plain segment tests that are
//! used nowhere else. Form factors are the plain sum over the same lattice.

use etendue::case::{Case, shipped_direct};
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
pub(super) fn blocks(shape: &Shape, from: DVec3, to: DVec3) -> bool {
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

/// How far along a case's line a point lies: the turn of its normal about y in degrees where normals turn, else x.
fn along(case: &Case, point: &MeasurementPoint) -> f64 {
    let points = case.configuration.points();
    let normal = point.normal();
    if points.iter().all(|p| p.normal() == normal) {
        point.position().x
    } else {
        normal.x.atan2(normal.z).to_degrees()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Sees {
    Nothing,
    Part,
    All,
}
use Sees::{All, Nothing, Part};

/// What the comments of the files say: from the start of the line to each border, and what is seen up to there.
const BORDERS: &[(&str, &[(f64, Sees)])] = &[
    ("direct/diffuser-box", &[(9.0, All)]),
    ("direct/disk-over-plane", &[(9.0, All)]),
    ("direct/disk-receiver", &[(9.0, All)]),
    ("direct/half-sunk-source", &[(9.0, Part)]),
    ("direct/l-shaped-source", &[(9.0, All)]),
    ("direct/rectangle-over-plane", &[(9.0, All)]),
    ("direct/sphere-receiver", &[(63.1117, All), (78.3010, Part), (91.0, Nothing)]),
    ("direct/sphere-source", &[(9.0, All)]),
    ("direct/tilted-source", &[(9.0, All)]),
    ("direct/triangle-source", &[(9.0, All)]),
    ("direct/turning-patch", &[(68.20, All), (84.29, Part), (91.0, Nothing)]),
    ("direct/two-sources", &[(9.0, All)]),
    ("penumbra/annular-eclipse", &[(0.8, Part), (9.0, All)]),
    ("penumbra/eclipse", &[(0.2, Nothing), (1.2, Part), (9.0, All)]),
    ("penumbra/eclipse-at-sunset", &[(26.37, All), (78.3010, Part), (91.0, Nothing)]),
    ("penumbra/eclipse-closing", &[(1e-9, Nothing), (1.0, Part), (9.0, All)]),
    ("penumbra/half-plane", &[(-0.5, Nothing), (0.5, Part), (9.0, All)]),
    ("penumbra/l-shaped-occluder", &[(-1.7, All), (-0.7, Part), (-0.35, Nothing), (1.7, Part), (9.0, All)]),
    ("penumbra/overlapping-occluders", &[(-1.3, All), (-0.3, Part), (0.5, Nothing), (3.5 / 3.0, Part), (9.0, All)]),
    ("penumbra/rectangle-behind-rectangle", &[(0.7, Nothing), (1.3, Part), (9.0, All)]),
    ("penumbra/sphere-occluder", &[(0.4, Nothing), (1.0354, Part), (9.0, All)]),
    ("penumbra/spheres", &[(0.13354, Nothing), (0.55518, Part), (9.0, All)]),
    ("penumbra/three-regions", &[(0.7, Nothing), (1.3, Part), (9.0, All)]),
    ("penumbra/tilted-occluder", &[(-1.2358, All), (-0.2770, Part), (0.2900, Nothing), (0.5807, Part), (9.0, All)]),
    ("penumbra/two-shadows", &[(-1.65, All), (1.7, Part), (9.0, All)]),
    ("texture/blended-panel", &[(9.0, All)]),
    ("texture/checker-panel", &[(-0.825, All), (9.0, Part)]),
    ("texture/globe", &[(9.0, All)]),
    ("texture/picture-panel", &[(9.0, All)]),
    ("texture/sectors", &[(-0.9563, All), (1.4478, Part), (9.0, All)]),
    ("texture/slanted-triangle", &[(9.0, All)]),
    ("texture/tiled-ball", &[(64.919, All), (76.340, Part), (91.0, Nothing)]),
];

/// Tested by themselves: its shadow has two dimensions, and its mesh is that of another case.
const ELSEWHERE: [&str; 2] = ["penumbra/contact-shadow", "penumbra/eclipse-mesh"];

#[test]
fn umbra_and_penumbra_lie_where_the_files_say() {
    let tabled = BORDERS.iter().map(|(name, _)| *name).chain(ELSEWHERE);
    let mut tabled: Vec<_> = tabled.collect();
    tabled.sort();
    assert_eq!(shipped_direct().map(|case| case.name()).collect::<Vec<_>>(), tabled, "every case has its row");
    for (name, borders) in BORDERS {
        let case = read(name);
        for point in case.configuration.points() {
            let at = along(&case, point);
            let (_, expected) =
                *borders.iter().find(|(border, _)| at < *border).expect("the last border is beyond all");
            let share = visible_share(&case.configuration, point);
            let seen = match share {
                0.0 => Nothing,
                share if share > 1.0 - 1e-12 => All,
                _ => Part,
            };
            // A sliver may fall between the lattice points; what is seen whole or not at all may not be cut.
            let sliver =
                expected == Part && borders.iter().any(|(border, _)| (at - border).abs() < 0.004 * at.abs().max(2.0));
            assert!(seen == expected || sliver, "{name} at {at}: {share} of the light, not {expected:?}");
        }
    }
}

#[test]
fn every_penumbra_line_crosses_penumbra_and_light() {
    for (name, borders) in BORDERS.iter().filter(|(name, _)| name.starts_with("penumbra/")) {
        let case = read(name);
        let points = case.configuration.points();
        let ats: Vec<f64> = points.iter().map(|point| along(&case, point)).collect();
        let mut from = f64::MIN;
        for (to, sees) in *borders {
            let n = ats.iter().filter(|at| from <= **at && **at < *to).count();
            assert!(n >= 1, "{name}: no point sees {sees:?} before {to}");
            from = *to;
        }
    }
}

#[test]
fn a_contact_shadow_softens_away_from_the_contact() {
    let case = read("penumbra/contact-shadow");
    let partly = |column: usize| {
        let points = case.configuration.points().iter().skip(column).step_by(5);
        points
            .filter(|point| {
                let share = visible_share(&case.configuration, point);
                share > 0.0 && share < 1.0 - 1e-12
            })
            .count()
    };
    assert_eq!((0..5).map(partly).collect::<Vec<_>>(), [1, 3, 5, 7, 9]);
}

#[test]
fn the_mesh_is_the_disk_of_the_eclipse() {
    let (mesh, disk) = (read("penumbra/eclipse-mesh"), read("penumbra/eclipse"));
    let fourth: Vec<_> = disk.configuration.points().iter().copied().step_by(4).collect();
    assert_eq!(mesh.configuration.points(), fourth);
    assert_eq!(mesh.configuration.sources(), disk.configuration.sources());
    let (Shape::Mesh(rings), Shape::Disk(round)) =
        (&mesh.configuration.occluders()[0], &disk.configuration.occluders()[0])
    else {
        panic!("a mesh and a disk")
    };
    assert_eq!(rings.triangles().len(), 110_976);
    let inscribed = 51.0 * (std::f64::consts::TAU / 102.0).sin() * round.radius() * round.radius();
    // A sum of 110,976 terms may be off by as many roundings.
    approx::assert_relative_eq!(rings.area(), inscribed, max_relative = 1e5 * f64::EPSILON);
    for (at, vertex) in rings.vertices().iter().enumerate() {
        let reach = (*vertex - round.center()).length();
        assert!(vertex.z == 1.0 && reach <= round.radius() * (1.0 + 1e-15), "vertex {at} lies {reach} m out");
    }
}

/// Form factors that the files' comments give, at a place on their line.
const FORM_FACTORS: &[(&str, DVec3, f64)] = &[
    ("direct/disk-over-plane", DVec3::ZERO, 0.058824),
    ("direct/rectangle-over-plane", DVec3::ZERO, 0.045201),
    ("direct/triangle-source", DVec3::ZERO, 0.037882),
    ("direct/l-shaped-source", DVec3::ZERO, 0.036268),
    ("direct/sphere-source", DVec3::ZERO, 0.04),
    ("direct/tilted-source", DVec3::new(-2.0, 0.0, 0.0), 0.012814),
    ("direct/tilted-source", DVec3::new(-1.0, 0.0, 0.0), 0.038227),
    ("direct/tilted-source", DVec3::new(0.0, 0.0, 0.0), 0.035148),
    ("direct/tilted-source", DVec3::new(1.0, 0.0, 0.0), 0.018573),
    ("direct/tilted-source", DVec3::new(2.0, 0.0, 0.0), 0.008945),
];

#[test]
fn form_factors_are_those_of_the_files() {
    for (name, position, expected) in FORM_FACTORS {
        let case = read(name);
        let point = MeasurementPoint::new(*position, DVec3::Z).unwrap();
        let source = &case.configuration.sources()[0];
        let mut n = 0;
        let mut sum = 0.0;
        let lattice = |k: usize| (k as f64 + 0.5) / LATTICE as f64;
        for k in 0..LATTICE * LATTICE {
            let Some((at, normal)) = source_point(source.shape(), lattice(k % LATTICE), lattice(k / LATTICE)) else {
                continue;
            };
            let towards = at - point.position();
            let cosines = point.normal().dot(towards).max(0.0) * (-normal.dot(towards)).max(0.0);
            sum += cosines / (std::f64::consts::PI * towards.length_squared().powi(2));
            n += 1;
        }
        // The mean over the lattice is the integral to its spacing; where the lattice is cut by an outline, to a row of it.
        approx::assert_relative_eq!(source.shape().area() * sum / f64::from(n), *expected, max_relative = 2e-3);
    }
}

fn read(name: &str) -> Case {
    let case = shipped_direct().find(|case| case.name() == name).unwrap_or_else(|| panic!("{name} is not shipped"));
    case.read().unwrap_or_else(|mistakes| panic!("{mistakes}"))
}
