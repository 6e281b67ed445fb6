use super::grid::{Grid, MARGIN, SIDE, draw, part};
use super::*;
use crate::geometry::{Disk, Mesh, Polygon, Rectangle, Shape, Sphere};
use crate::sampling::{Stream, StreamKey};
use rand::RngExt;

/// A closed surface around height 1, in rows and columns, dented so that it hides parts of itself.
fn dented_ball(columns: u32) -> Mesh {
    let rows = columns / 2;
    let mut vertices = Vec::new();
    for i in 0..=rows {
        for j in 0..columns {
            let polar = std::f64::consts::PI * f64::from(i) / f64::from(rows);
            let turn = std::f64::consts::TAU * f64::from(j) / f64::from(columns);
            let radius = 0.35 * (1.0 + 0.3 * (5.0 * polar).sin() * (6.0 * turn).sin());
            let across = radius * polar.sin();
            vertices.push(DVec3::new(across * turn.cos(), across * turn.sin(), 1.0 + radius * polar.cos()));
        }
    }
    let at = |i: u32, j: u32| i * columns + j % columns;
    let quads = (0..rows * columns).map(|k| (k / columns, k % columns));
    let triangles = quads
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
    Mesh::new(vertices, triangles.collect()).unwrap()
}

/// A sheet with a square hole, its vertices given anew for each triangle, every third triangle the other way round.
fn holed_sheet(n: u32) -> Mesh {
    let mut vertices = Vec::new();
    for i in 0..n {
        for j in 0..n {
            if (i.abs_diff(n / 2) < n / 6) && (j.abs_diff(n / 3) < n / 6) {
                continue;
            }
            let at = |i: u32, j: u32| {
                let (x, y) = (f64::from(i) / f64::from(n) - 0.5, f64::from(j) / f64::from(n) - 0.5);
                DVec3::new(x, y, 1.0 + 0.2 * (9.0 * x).sin() * (7.0 * y).cos())
            };
            vertices.extend([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let triangles = (0..vertices.len() as u32 / 3)
        .map(|t| if t % 37 == 5 { [3 * t, 3 * t + 2, 3 * t + 1] } else { [3 * t, 3 * t + 1, 3 * t + 2] });
    Mesh::new(vertices, triangles.collect()).unwrap()
}

/// Triangles that stand about, none joined to another.
fn loose(draws: &mut Stream, n: usize) -> Mesh {
    let mut vertices = Vec::new();
    for _ in 0..n {
        let middle = DVec3::new(draws.random_range(-0.5..0.5), draws.random_range(-0.5..0.5), 1.0);
        for _ in 0..3 {
            vertices.push(middle + 0.2 * DVec3::new(draws.random(), draws.random(), draws.random()));
        }
    }
    Mesh::new(vertices, (0..n as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect()).unwrap()
}

/// Sources to look at, flat, tilted and round, with a draw of a point on each.
fn sources() -> Vec<Shape> {
    let at = DVec3::new(0.1, -0.1, 2.2);
    let rectangle = Rectangle::new(at, DVec3::Y, DVec3::X * 1.5).unwrap();
    let triangle = [DVec3::new(-0.6, -0.5, 2.0), DVec3::new(0.1, 0.7, 2.4), DVec3::new(0.8, -0.4, 2.2)];
    vec![
        Shape::Rectangle(rectangle),
        Shape::Disk(Disk::new(at, DVec3::new(0.2, 0.3, -1.0), 0.5).unwrap()),
        Shape::Polygon(Polygon::new(triangle.to_vec()).unwrap()),
        Shape::Sphere(Sphere::new(at, 0.4).unwrap()),
    ]
}

/// A point on a source, or on its skin.
fn on(shape: &Shape, draws: &mut Stream) -> DVec3 {
    let (u, v) = (draws.random_range(-0.5..0.5), draws.random_range(-0.5..0.5));
    match shape {
        Shape::Rectangle(s) => s.center() + s.edge_u() * u + s.edge_v() * v,
        Shape::Disk(s) => {
            let frame = Frame::around(s.normal());
            s.center() + (frame.tangent * u + frame.bitangent * v) * (2.0_f64.sqrt() * s.radius())
        }
        Shape::Polygon(s) => {
            let [a, b, c] = [s.vertices()[0], s.vertices()[1], s.vertices()[2]];
            a + (b - a) * (u + 0.5).min(v + 0.5) + (c - a) * (1.0 - (u + 0.5).max(v + 0.5))
        }
        Shape::Sphere(s) => s.center() + DVec3::new(u, v, -0.4).normalize() * s.radius(),
        Shape::Mesh(_) => unreachable!("no source"),
    }
}

/// Looks from a point past a mesh at a source, as if there were rays without end to follow.
fn look(mesh: &Mesh, from: DVec3, shape: &Shape) -> (Hierarchy, Option<VisibilityMap>) {
    let hierarchy = Hierarchy::new(mesh, (DVec3::splat(-4.0), DVec3::splat(4.0)));
    let target = Target::new(shape);
    let visibility = SilhouetteEdges::default().seen(&hierarchy, Machine::new(), from, &target, u64::MAX);
    (hierarchy, visibility)
}

/// Shades rays to these ends with and without the visibility map; gives how many were dark, lit and traced.
fn compare(hierarchy: &Hierarchy, visibility: &VisibilityMap, from: DVec3, ends: &[DVec3]) -> [usize; 3] {
    let mut counts = [0; 3];
    for ends in ends.chunks(BLOCK) {
        let (mut rays, mut light) = (ShadowRays::default(), Row::default());
        for (k, end) in ends.iter().enumerate() {
            let (g, l) = (k / LANES, k % LANES);
            (rays.x[g][l], rays.y[g][l], rays.z[g][l]) = (*end - from).into();
            light[g][l] = (k % 5) as f64;
            let [column, row] = visibility.cell(*end - from);
            let (column, row) = (column as usize, row as usize);
            counts[match (visibility.dark[row] >> column & 1, visibility.lit[row] >> column & 1) {
                (1, 0) => 0,
                (0, 1) => 1,
                _ => 2,
            }] += 1;
        }
        let mut traced = light;
        visibility.shade(Machine::new(), hierarchy, from, &rays, ends.len(), &mut light);
        hierarchy.shade(from, &rays, ends.len(), &mut traced, None);
        assert_eq!(light, traced, "from {from}");
    }
    counts
}

#[test]
fn a_visibility_map_changes_no_answer() {
    let mut draws = Stream::new(StreamKey::root(31));
    let meshes = [dented_ball(40), holed_sheet(36), holed_sheet(18).subdivided(1), loose(&mut draws, 9)];
    let mut counts = [0; 3];
    for mesh in &meshes {
        for shape in sources() {
            for turn in 0..12 {
                // From far aside, from below, and from close to the mesh.
                let reach = [1.5, 0.6, 0.3][turn % 3];
                let height = [0.0, 0.1, 0.3][turn / 3 % 3];
                let from = DVec3::new(draws.random_range(-reach..reach), draws.random_range(-reach..reach), height);
                let (hierarchy, visibility) = look(mesh, from, &shape);
                let Some(visibility) = visibility else { continue };
                let mut ends: Vec<DVec3> = (0..1500).map(|_| on(&shape, &mut draws)).collect();
                // Past edges of the mesh, by next to nothing and by a little: the silhouette's too.
                if let Shape::Rectangle(source) = &shape {
                    for _ in 0..1500 {
                        let [a, b, _] = mesh.corners(draws.random_range(0..mesh.triangles().len()));
                        let aside = 10.0_f64.powf(draws.random_range(-16.0..-2.0));
                        let past = a + (b - a) * draws.random::<f64>() + DVec3::new(aside, -aside, 0.0);
                        let end = from + (past - from) * ((source.center().z - from.z) / (past.z - from.z));
                        if (end.x - 0.1).abs() < 0.75 && (end.y + 0.1).abs() < 0.5 {
                            ends.push(end);
                        }
                    }
                }
                let found = compare(&hierarchy, &visibility, from, &ends);
                counts = std::array::from_fn(|k| counts[k] + found[k]);
            }
        }
    }
    let all: usize = counts.iter().sum();
    assert!(counts.iter().all(|count| *count > all / 20), "dark, lit, traced: {counts:?}");
}

#[test]
fn most_of_a_penumbra_is_told_without_rays() {
    let mut draws = Stream::new(StreamKey::root(32));
    let shape = &sources()[0];
    let ends: Vec<DVec3> = (0..4000).map(|_| on(shape, &mut draws)).collect();
    for mesh in [dented_ball(100), holed_sheet(60)] {
        let from = DVec3::new(0.3, 0.1, 0.0);
        let (hierarchy, visibility) = look(&mesh, from, shape);
        let [dark, lit, traced] = compare(&hierarchy, &visibility.unwrap(), from, &ends);
        assert!(dark > 400 && lit > 400 && traced < 2000, "{dark} {lit} {traced}");
    }
}

#[test]
fn what_is_not_wholly_between_gives_no_visibility() {
    let shape = &sources()[0];
    let from = DVec3::new(0.1, 0.2, 0.0);
    let ball = dented_ball(12);
    let moved = |by: DVec3| Mesh::new(ball.vertices().iter().map(|v| *v + by).collect(), ball.triangles().to_vec());
    assert!(look(&ball, from, shape).1.is_some());
    for away in [DVec3::Z * 1.2, DVec3::Z * 3.0, DVec3::Z * -0.9, DVec3::Z * -3.0] {
        assert!(look(&moved(away).unwrap(), from, shape).1.is_none(), "{away}");
    }
    // In the plane of the source, and nearly.
    for height in [2.2, 2.2 - 1e-12] {
        assert!(look(&ball, DVec3::new(3.0, 0.0, height), shape).1.is_none(), "{height}");
    }
    let mut draws = Stream::new(StreamKey::root(33));
    assert!(look(&loose(&mut draws, 40), from, shape).1.is_none(), "a mesh of rims");
}

fn looks_at_all(hierarchy: &Hierarchy, target: &Target, rays: u64) -> bool {
    SilhouetteEdges::default().seen(hierarchy, Machine::Any, DVec3::ZERO, target, rays).is_some()
}

#[test]
fn few_rays_look_for_nothing() {
    let shape = &sources()[0];
    let hierarchy = Hierarchy::new(&dented_ball(200), (DVec3::splat(-4.0), DVec3::splat(4.0)));
    let target = Target::new(shape);
    let edges = SilhouetteEdges::default();
    let looks = |rays| edges.seen(&hierarchy, Machine::Any, DVec3::ZERO, &target, rays).is_some();
    let triangles = hierarchy.faces().len() as u64;
    assert!(!looks(triangles / 8 - 1));
    assert!(looks(triangles / 8 + 1));
    // Of a mesh of few triangles, too.
    let plate = Mesh::new(vec![DVec3::Z, DVec3::X + DVec3::Z, DVec3::Y + DVec3::Z], vec![[0, 1, 2]]).unwrap();
    let hierarchy = Hierarchy::new(&plate, (DVec3::splat(-4.0), DVec3::splat(4.0)));
    let looks = |rays| looks_at_all(&hierarchy, &target, rays);
    assert!(!looks(100) && looks(10_000));
}

#[test]
fn what_is_drawn_covers_the_segment_and_little_more() {
    let mut draws = Stream::new(StreamKey::root(34));
    for turn in 0..3000 {
        let mut point = || [draws.random_range(-20.0..84.0), draws.random_range(-20.0..84.0)];
        let (a, mut b): ([f64; 2], [f64; 2]) = (point(), point());
        match turn % 6 {
            0 => b[0] = a[0],
            1 => b[1] = a[1],
            2 => b = a,
            3 => b = [a[0] + 0.01 * b[0], a[1] + 0.01 * b[1]],
            _ => {}
        }
        let mut crossed: Grid = [0; SIDE];
        draw(&mut crossed, a, b);
        let mut near: Grid = [0; SIDE];
        for step in 0..=2000 {
            let along = f64::from(step) / 2000.0;
            let place = [a[0] + (b[0] - a[0]) * along, a[1] + (b[1] - a[1]) * along];
            for corner in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
                for (reach, grid) in [(0.99 * MARGIN, None), (0.1, Some(()))] {
                    let [x, y] = [0, 1].map(|k| (place[k] + corner[k] * reach).floor());
                    if (0.0..64.0).contains(&x) && (0.0..64.0).contains(&y) {
                        match grid {
                            None => assert!(crossed[y as usize] >> x as u64 & 1 == 1, "{a:?} to {b:?}: {x}, {y}"),
                            Some(()) => near[y as usize] |= 1 << x as u64,
                        }
                    }
                }
            }
        }
        for (row, (crossed, near)) in crossed.iter().zip(&near).enumerate() {
            assert_eq!(crossed & !near, 0, "{a:?} to {b:?}, row {row}");
        }
    }
}

#[test]
fn a_part_is_what_hangs_together() {
    let mut draws = Stream::new(StreamKey::root(35));
    for density in [0.3, 0.55, 0.6, 0.65, 0.9] {
        let free: Grid =
            std::array::from_fn(|_| (0..64).fold(0, |row, k| row | u64::from(draws.random_bool(density)) << k));
        let Some(row) = free.iter().position(|row| *row != 0) else { continue };
        let column = free[row].trailing_zeros();
        // One cell after the other.
        let (mut found, mut open): (Grid, _) = ([0; SIDE], vec![(row, column as usize)]);
        while let Some((row, column)) = open.pop() {
            if free[row] >> column & 1 == 0 || found[row] >> column & 1 == 1 {
                continue;
            }
            found[row] |= 1 << column;
            open.extend(
                [(row.wrapping_sub(1), column), (row + 1, column)].into_iter().filter(|(row, _)| *row < SIDE),
            );
            open.extend([(row, column.wrapping_sub(1)), (row, column + 1)].into_iter().filter(|(_, k)| *k < SIDE));
        }
        assert_eq!(part(&free, row, column), found, "{density}");
    }
}
