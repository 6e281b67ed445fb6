//! A mesh as few flat figures: faces in one plane merge, and only the outline of what they cover together remains.

use std::collections::HashMap;

use glam::DVec3;

use super::body::Flat;
use crate::geometry::{Frame, Mesh};

/// Faces whose planes differ by no more than this (radians; and, in units of the mesh's size, metres) are one plane.
const COPLANAR: f64 = 1e-12;

/// The edges of one closed loop over `n` corners.
pub(super) fn loop_of(n: usize) -> Vec<[u32; 2]> {
    (0..n as u32).map(|i| [i, (i + 1) % n as u32]).collect()
}

/// One figure for each plane that holds faces of the mesh (connected by edges or not).
///
/// The faces of a plane are turned to one side, equal corners become one, and edges that two faces run along in
/// opposite directions go away; a chain of edges on one line becomes one edge. Faces that overlap in their plane, or
/// whose edges meet without sharing corners, are left as figures of their own.
pub(super) fn flat_patches(mesh: &Mesh, scale: f64) -> Vec<Flat> {
    let points: Vec<DVec3> = mesh.vertices().iter().map(|p| *p * scale).collect();
    let size = extent(&points);
    let mut planes: Vec<(DVec3, f64, Vec<[DVec3; 3]>)> = Vec::new();
    let mut buckets: HashMap<[i64; 4], Vec<usize>> = HashMap::new();
    for triangle in 0..mesh.triangles().len() {
        let mut corners = mesh.triangles()[triangle].map(|i| points[i as usize]);
        let [a, b, c] = corners;
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        let cross = (b - a).cross(c - a);
        let mut normal = cross.normalize();
        if !normal.is_finite() {
            continue;
        }
        let level = if normal.x.abs() > 0.5 {
            normal.x
        } else if normal.y.abs() > 0.5 {
            normal.y
        } else {
            normal.z
        };
        if level < 0.0 {
            normal = -normal;
            corners.swap(1, 2);
        }
        // A thin face knows its normal only as well as its height allows.
        let slack = COPLANAR.max(16.0 * f64::EPSILON * size * longest / cross.length().max(f64::MIN_POSITIVE));
        let height = normal.dot(a) / size;
        let matches = |plane: &(DVec3, f64, Vec<[DVec3; 3]>)| {
            plane.0.distance(normal) <= slack
                && corners.iter().all(|p| (plane.0.dot(*p) / size - plane.1).abs() <= COPLANAR)
        };
        let key = [normal.x, normal.y, normal.z, height].map(|x| (x * 1e6).round() as i64);
        let home = buckets.get(&key).and_then(|list| list.iter().copied().find(|i| matches(&planes[*i])));
        let home = home.or_else(|| {
            // Rounding may have put an equal plane into a neighbouring bucket.
            neighbours(key).find_map(|k| buckets.get(&k)?.iter().copied().find(|i| matches(&planes[*i])))
        });
        match home {
            Some(i) => planes[i].2.push(corners),
            None => {
                buckets.entry(key).or_default().push(planes.len());
                planes.push((normal, height, vec![corners]));
            }
        }
    }
    planes.into_iter().flat_map(|(normal, _, faces)| merged(normal, &faces)).collect()
}

fn neighbours(key: [i64; 4]) -> impl Iterator<Item = [i64; 4]> {
    (0..81).map(move |i| {
        let shift = [i % 3 - 1, i / 3 % 3 - 1, i / 9 % 3 - 1, i / 27 - 1];
        std::array::from_fn(|k| key[k] + shift[k])
    })
}

fn extent(points: &[DVec3]) -> f64 {
    points.iter().map(|p| p.abs().max_element()).fold(f64::MIN_POSITIVE, f64::max)
}

/// The faces of one plane, counter-clockwise about `normal`.
fn merged(normal: DVec3, faces: &[[DVec3; 3]]) -> Vec<Flat> {
    let mut index: HashMap<[u64; 3], u32> = HashMap::new();
    let mut corners: Vec<DVec3> = Vec::new();
    let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
    for face in faces {
        let face = face.map(|p| {
            // Adding zero turns −0 into 0.
            *index.entry((p + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert_with(|| {
                corners.push(p);
                corners.len() as u32 - 1
            })
        });
        for k in 0..3 {
            *edges.entry([face[k], face[(k + 1) % 3]]).or_default() += 1;
        }
    }
    let single =
        |figures: &[[DVec3; 3]]| figures.iter().map(|face| outlined(normal, face.to_vec(), loop_of(3))).collect();
    if edges.values().any(|count| *count > 1) {
        return single(faces);
    }
    let mut border: Vec<[u32; 2]> = edges.keys().filter(|[a, b]| !edges.contains_key(&[*b, *a])).copied().collect();
    border.sort_unstable();
    let border = straightened(border, &corners);
    if meets_itself(normal, &corners, &border) {
        return single(faces);
    }
    let mut used: Vec<u32> = border.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let renumbered = |i: u32| used.binary_search(&i).expect("collected from the same edges") as u32;
    let edges = border.iter().map(|edge| edge.map(renumbered)).collect();
    vec![outlined(normal, used.iter().map(|i| corners[*i as usize]).collect(), edges)]
}

fn outlined(normal: DVec3, offsets: Vec<DVec3>, edges: Vec<[u32; 2]>) -> Flat {
    let convex = is_convex(normal, &offsets, &edges);
    Flat { normal, origin: DVec3::ZERO, offsets, edges, convex }
}

/// Joins edges that follow one another on one line.
fn straightened(mut border: Vec<[u32; 2]>, corners: &[DVec3]) -> Vec<[u32; 2]> {
    let mut leaving: HashMap<u32, Vec<usize>> = HashMap::new();
    let mut arriving: HashMap<u32, usize> = HashMap::new();
    for (i, [from, to]) in border.iter().enumerate() {
        leaving.entry(*from).or_default().push(i);
        *arriving.entry(*to).or_default() += 1;
    }
    let point = |i: u32| corners[i as usize];
    let mut gone = vec![false; border.len()];
    for i in 0..border.len() {
        while !gone[i] {
            let [from, to] = border[i];
            let Some([next]) = leaving.get(&to).map(Vec::as_slice) else { break };
            let next = *next;
            if next == i || gone[next] || arriving[&to] != 1 {
                break;
            }
            let far = border[next][1];
            let (before, after) = (point(to) - point(from), point(far) - point(to));
            let bend = before.cross(after).length();
            let off_line = bend / (before + after).length().max(f64::MIN_POSITIVE);
            let rounding = 4.0 * f64::EPSILON * point(to).length();
            if before.dot(after) <= 0.0 || off_line > rounding {
                break;
            }
            border[i] = [from, far];
            gone[next] = true;
        }
    }
    let mut keep = gone.iter().map(|gone| !gone);
    border.retain(|_| keep.next().unwrap_or(false));
    border
}

fn flatten(normal: DVec3, corners: &[DVec3]) -> Vec<[f64; 2]> {
    let frame = Frame::around(normal);
    corners.iter().map(|p| [p.dot(frame.tangent), p.dot(frame.bitangent)]).collect()
}

fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether edges cross or lie along one another: then faces overlap, and counting edges told nothing.
fn meets_itself(normal: DVec3, corners: &[DVec3], edges: &[[u32; 2]]) -> bool {
    let flat = flatten(normal, corners);
    let size = flat.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let noise = 64.0 * f64::EPSILON * size * size;
    let at = |i: u32| flat[i as usize];
    let between = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
        let along = (p[0] - a[0]) * (b[0] - a[0]) + (p[1] - a[1]) * (b[1] - a[1]);
        along > noise && along < (b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2) - noise
    };
    edges.iter().enumerate().any(|(i, [a, b])| {
        edges[i + 1..].iter().any(|[c, d]| {
            let (t1, t2) = (turn(at(*a), at(*b), at(*c)), turn(at(*a), at(*b), at(*d)));
            let (t3, t4) = (turn(at(*c), at(*d), at(*a)), turn(at(*c), at(*d), at(*b)));
            let crosses = t1.abs().min(t2.abs()).min(t3.abs().min(t4.abs())) > noise
                && (t1 > 0.0) != (t2 > 0.0)
                && (t3 > 0.0) != (t4 > 0.0);
            let touches = (t1.abs() <= noise && between(at(*a), at(*b), at(*c)))
                || (t2.abs() <= noise && between(at(*a), at(*b), at(*d)))
                || (t3.abs() <= noise && between(at(*c), at(*d), at(*a)))
                || (t4.abs() <= noise && between(at(*c), at(*d), at(*b)));
            crosses || touches
        })
    })
}

/// One loop that only turns left. (A loop that turns left and goes round once: its turns add up to one.)
fn is_convex(normal: DVec3, corners: &[DVec3], edges: &[[u32; 2]]) -> bool {
    let flat = flatten(normal, corners);
    if edges.len() != corners.len() {
        return false;
    }
    let next: HashMap<u32, u32> = edges.iter().map(|[a, b]| (*a, *b)).collect();
    let (mut at, mut steps, mut angle) = (edges[0][0], 0, 0.0);
    loop {
        let (Some(b), Some(c)) = (next.get(&at), next.get(&at).and_then(|b| next.get(b))) else { return false };
        let (p, q, r) = (flat[at as usize], flat[*b as usize], flat[*c as usize]);
        let bend = turn(p, q, r);
        if bend < 0.0 {
            return false;
        }
        angle += bend.atan2((q[0] - p[0]) * (r[0] - q[0]) + (q[1] - p[1]) * (r[1] - q[1]));
        (at, steps) = (*b, steps + 1);
        if at == edges[0][0] || steps > edges.len() {
            break;
        }
    }
    steps == edges.len() && (angle - std::f64::consts::TAU).abs() < 1e-6
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fan(n: u32) -> Mesh {
        let mut vertices = vec![DVec3::Z];
        vertices.extend((0..n).map(|i| {
            let t = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            DVec3::new(t.cos(), t.sin(), 1.0)
        }));
        // Every other face is wound the other way: occluders block from both sides.
        let face = |i: u32| {
            let (a, b) = (i + 1, (i + 1) % n + 1);
            if i.is_multiple_of(2) { [0, a, b] } else { [0, b, a] }
        };
        Mesh::new(vertices, (0..n).map(face).collect()).unwrap()
    }

    #[test]
    fn a_fine_flat_mesh_is_its_outline() {
        let patches = flat_patches(&fan(12).subdivided(4), 1.0);
        assert_eq!(patches.len(), 1);
        assert_eq!(patches[0].edges.len(), 12, "midpoints on straight edges are no corners");
        assert!(patches[0].convex);
    }

    #[test]
    fn a_hole_stays_a_hole() {
        let ring: Vec<DVec3> = [0.0, 3.0]
            .iter()
            .flat_map(|_| [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)])
            .enumerate()
            .map(
                |(i, (x, y))| {
                    if i < 4 { DVec3::new(x, y, 0.0) } else { DVec3::new(1.0 + x / 3.0, 1.0 + y / 3.0, 0.0) }
                },
            )
            .collect();
        let faces = (0..4).flat_map(|i| {
            let j = (i + 1) % 4;
            [[i, j, j + 4], [i, j + 4, i + 4]]
        });
        let patches = flat_patches(&Mesh::new(ring, faces.collect()).unwrap(), 1.0);
        assert_eq!((patches.len(), patches[0].edges.len(), patches[0].convex), (1, 8, false));
    }

    #[test]
    fn a_cube_has_six_faces() {
        let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let cube = Mesh::new((0..8).map(corner).collect(), faces).unwrap().subdivided(2);
        let patches = flat_patches(&cube, 1.0);
        assert_eq!(patches.len(), 6);
        assert!(patches.iter().all(|p| p.edges.len() == 4 && p.convex));
    }

    #[test]
    fn overlapping_faces_are_kept_apart() {
        let vertices = [(0.0, 0.0), (2.0, 0.0), (0.0, 2.0), (1.0, -1.0), (1.0, 3.0), (3.0, 1.0)];
        let vertices = vertices.iter().map(|(x, y)| DVec3::new(*x, *y, 0.0)).collect();
        let patches = flat_patches(&Mesh::new(vertices, vec![[0, 1, 2], [3, 4, 5]]).unwrap(), 1.0);
        assert_eq!(patches.len(), 2);
    }
}
