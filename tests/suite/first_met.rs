//! What a ray from a shading point meets first: against a plain search, and against the shadow rays.

use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Disk, Frame, Mesh, Polygon, Rectangle, Shape, Sphere};
use etendue::radiometry::Exitance;
use etendue::sampling::{BLOCK, DirectionBlock, LANES, Row, Stream, StreamKey};
use etendue::scene::{Met, ShadowRays, Surroundings};
use etendue::statistics::budget::seed_of;
use rand::RngExt;

/// A room with every kind of source and blocker, in each other's way, and points among them.
pub fn crowded() -> Configuration {
    let v = DVec3::new;
    let frame = Frame::around(v(0.2, 0.1, -1.0).normalize());
    let flat = |z: f64, outline: &[[f64; 2]]| {
        let vertices = outline.iter().map(|p| v(-0.4, -0.6, z) + frame.tangent * p[0] + frame.bitangent * p[1]);
        Polygon::new(vertices.collect()).unwrap()
    };
    let l = [[0.0, 0.0], [1.2, 0.0], [1.2, 0.5], [0.6, 0.5], [0.6, 1.1], [0.0, 1.1]];
    let sources = [
        (Shape::Disk(Disk::new(v(0.5, 0.2, 2.0), v(-0.1, 0.0, -1.0), 0.6).unwrap()), 1.0),
        (Shape::Rectangle(Rectangle::new(v(-0.6, 0.3, 1.6), DVec3::Y * 0.9, v(0.8, 0.0, 0.2)).unwrap()), 2.5),
        (Shape::Sphere(Sphere::new(v(0.1, -0.5, 1.2), 0.3).unwrap()), 0.7),
        (Shape::Polygon(flat(1.4, &l)), 1.6),
    ];
    let sources = sources.map(|(shape, exitance)| Source::new(shape, Exitance::new(exitance)).unwrap());
    let ridge = Mesh::new(
        vec![v(-0.5, -0.2, 0.7), v(0.1, -0.4, 0.8), v(-0.3, 0.4, 0.9), v(0.2, 0.3, 0.6)],
        vec![[0, 1, 2], [1, 3, 2]],
    );
    let occluders = vec![
        Shape::Disk(Disk::new(v(0.4, 0.1, 1.0), v(0.3, 0.0, 1.0), 0.2).unwrap()),
        Shape::Rectangle(Rectangle::new(v(-0.8, 0.0, 0.5), DVec3::Y * 0.4, v(0.2, 0.0, 0.3)).unwrap()),
        Shape::Sphere(Sphere::new(v(0.5, 0.6, 0.8), 0.2).unwrap()),
        Shape::Polygon(flat(0.9, &[[0.0, 0.0], [0.5, 0.1], [0.2, 0.4]])),
        Shape::Mesh(ridge.unwrap().subdivided(3)),
    ];
    let at = |x: f64, y: f64, n: DVec3| MeasurementPoint::new(v(x, y, 0.0), n).unwrap();
    let points = vec![
        at(0.0, 0.0, DVec3::Z),
        at(0.4, 0.1, DVec3::Z),
        at(-0.9, 0.2, v(0.8, 0.0, 0.6)),
        at(0.3, -0.8, v(-0.2, -0.9, 0.3)),
        at(0.1, 0.2, v(0.0, 0.0, -1.0)),
    ];
    Configuration::new(sources.into(), occluders, None, points, Arrangement::Scattered).unwrap()
}

/// Distance along a unit direction to a shape and the outward cosine there (negative on the dark side), by text-book forms
/// used nowhere else.
fn meeting(shape: &Shape, from: DVec3, d: DVec3) -> Option<(f64, f64)> {
    let plane = |on: DVec3, normal: DVec3| {
        let distance = (on - from).dot(normal) / d.dot(normal);
        (distance > 0.0).then(|| (distance, from + d * distance, -d.dot(normal)))
    };
    match shape {
        Shape::Disk(s) => plane(s.center(), s.normal())
            .and_then(|(t, p, cosine)| ((p - s.center()).length() < s.radius()).then_some((t, cosine))),
        Shape::Rectangle(s) => in_outline(&s.corners(), s.normal(), plane(s.center(), s.normal())?),
        Shape::Polygon(s) => in_outline(s.vertices(), s.normal(), plane(s.vertices()[0], s.normal())?),
        Shape::Sphere(s) => {
            let oc = from - s.center();
            let (b, c) = (oc.dot(d), oc.length_squared() - s.radius() * s.radius());
            let discriminant = b * b - c;
            if discriminant <= 0.0 {
                return None;
            }
            let t = -b - discriminant.sqrt();
            (t > 0.0).then(|| (t, -d.dot((oc + d * t) / s.radius())))
        }
        Shape::Mesh(s) => (0..s.triangles().len())
            .filter_map(|triangle| {
                // Möller and Trumbore.
                let [a, b, c] = s.corners(triangle);
                let (e1, e2) = (b - a, c - a);
                let p = d.cross(e2);
                let det = e1.dot(p);
                let offset = from - a;
                let u = offset.dot(p) / det;
                let q = offset.cross(e1);
                let v = d.dot(q) / det;
                let t = e2.dot(q) / det;
                (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some((t, 0.0))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0)),
        other => panic!("no such shape: {}", other.kind()),
    }
}

/// By the angles under which the edges are seen: they sum to a whole turn inside.
fn in_outline(outline: &[DVec3], normal: DVec3, (t, p, cosine): (f64, DVec3, f64)) -> Option<(f64, f64)> {
    let n = outline.len();
    let turn: f64 = (0..n)
        .map(|i| {
            let (a, b) = (outline[i] - p, outline[(i + 1) % n] - p);
            a.cross(b).dot(normal).atan2(a.dot(b))
        })
        .sum();
    (turn.abs() > 3.0).then_some((t, cosine))
}

/// The same by looking at everything.
fn plain_search(room: &Configuration, from: DVec3, d: DVec3) -> Option<(u32, f64, f64)> {
    let sources = room.sources().iter().enumerate().map(|(i, source)| (i as u32, source.shape()));
    let occluders = room.occluders().iter().map(|shape| (Met::NOTHING, shape));
    let hits = sources.chain(occluders).filter_map(|(i, shape)| meeting(shape, from, d).map(|(t, c)| (i, t, c)));
    let (index, distance, cosine) = hits.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (index != Met::NOTHING && cosine > 0.0).then_some((index, distance, cosine))
}

fn block_of(directions: &[DVec3]) -> DirectionBlock {
    let mut block = DirectionBlock::default();
    for (i, d) in directions.iter().enumerate() {
        (block.x[i / LANES][i % LANES], block.y[i / LANES][i % LANES]) = (d.x, d.y);
        block.z[i / LANES][i % LANES] = d.z;
    }
    block
}

fn directions(draws: &mut Stream) -> Vec<DVec3> {
    (0..BLOCK)
        .map(|_| {
            // Half of them upwards, where the shapes are.
            let mut draw = || draws.random_range(-1.0..1.0);
            let d = DVec3::new(draw(), draw(), draw() + 0.7);
            d.normalize()
        })
        .collect()
}

#[test]
fn the_first_source_is_found_as_by_a_plain_search() {
    let room = crowded();
    let surroundings = Surroundings::new(&room);
    let mut draws = Stream::new(StreamKey::root(seed_of("the_first_source_is_found_as_by_a_plain_search")));
    let mut counts = vec![0; room.sources().len() + 1];
    let mut met = Met::default();
    for point in room.points() {
        for _ in 0..400 {
            let directions = directions(&mut draws);
            surroundings.first_met(point.position(), &block_of(&directions), BLOCK, &mut met);
            for (i, d) in directions.iter().enumerate() {
                let (g, l) = (i / LANES, i % LANES);
                let found = (met.source[g][l] != Met::NOTHING).then_some((
                    met.source[g][l],
                    met.distance[g][l],
                    met.cosine[g][l],
                ));
                match (found, plain_search(&room, point.position(), *d)) {
                    (None, None) => counts[room.sources().len()] += 1,
                    (Some((index, t, cosine)), Some((expected, at, outward))) => {
                        assert_eq!(index, expected, "from {} along {d}", point.position());
                        approx::assert_relative_eq!(t, at, max_relative = 1e-12);
                        approx::assert_abs_diff_eq!(cosine, outward, epsilon = 1e-7);
                        counts[index as usize] += 1;
                    }
                    (found, plain) => panic!("from {} along {d}: {found:?}, not {plain:?}", point.position()),
                }
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 1_000), "each source and the dark are met often: {counts:?}");
}

/// Whether a segment is free of all but one source.
fn is_free(surroundings: &Surroundings, source: usize, from: DVec3, ray: DVec3) -> bool {
    let fill = |value: f64| [[value; LANES]; BLOCK / LANES];
    let rays = ShadowRays { x: fill(ray.x), y: fill(ray.y), z: fill(ray.z) };
    let mut contributions: Row = fill(1.0);
    for blocker in surroundings.before(source) {
        blocker.shade(from, &rays, 1, &mut contributions);
    }
    contributions[0][0] == 1.0
}

#[test]
fn what_is_met_first_a_shadow_ray_reaches() {
    let room = crowded();
    let surroundings = Surroundings::new(&room);
    let mut draws = Stream::new(StreamKey::root(seed_of("what_is_met_first_a_shadow_ray_reaches")));
    let (mut met, mut reached, mut hidden) = (Met::default(), 0, 0);
    for point in room.points() {
        for _ in 0..100 {
            let directions = directions(&mut draws);
            surroundings.first_met(point.position(), &block_of(&directions), BLOCK, &mut met);
            for (i, d) in directions.iter().enumerate() {
                let (g, l) = (i / LANES, i % LANES);
                for (index, source) in room.sources().iter().enumerate() {
                    // Where the ray meets each source's lit side, whatever lies before it.
                    let Some((t, cosine)) = meeting(source.shape(), point.position(), *d) else { continue };
                    if cosine <= 0.0 {
                        continue;
                    }
                    let is_first = met.source[g][l] == index as u32;
                    assert_eq!(is_free(&surroundings, index, point.position(), *d * t), is_first);
                    if is_first { reached += 1 } else { hidden += 1 }
                }
            }
        }
    }
    assert!(reached > 5_000 && hidden > 5_000, "{reached} reached, {hidden} hidden");
}

#[test]
fn from_inside_a_solid_ball_nothing_is_met() {
    let source = Source::new(Shape::Sphere(Sphere::new(DVec3::Z * 3.0, 0.5).unwrap()), Exitance::new(1.0)).unwrap();
    let ball = Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0).unwrap());
    let point = MeasurementPoint::new(DVec3::X * 0.2, DVec3::Z).unwrap();
    let room = |occluders| {
        Configuration::new(vec![source.clone()], occluders, None, vec![point], Arrangement::Scattered).unwrap()
    };
    let mut met = Met::default();
    let up = block_of(&[DVec3::Z]);
    Surroundings::new(&room(vec![])).first_met(point.position(), &up, 1, &mut met);
    assert_eq!(met.source[0][0], 0);
    Surroundings::new(&room(vec![ball])).first_met(point.position(), &up, 1, &mut met);
    assert_eq!(met.source[0][0], Met::NOTHING);
}
