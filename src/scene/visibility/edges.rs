//! The edges of a mesh, and which of them are its silhouette from a point.

use std::sync::OnceLock;

use glam::DVec3;

use super::grid::{SIDE, draw};
use super::{SMALL, Target, VisibilityMap};
use crate::number::{Eight, Machine, Registers, Work};
use crate::sampling::LANES;
use crate::scene::Hierarchy;

/// A point looks for the silhouette when it is to send one ray for so many triangles.
const TRIANGLES_A_RAY: u64 = 8;
/// Fewer rays than this are traced sooner than a silhouette is drawn, of whatever mesh.
const FEWEST_RAYS: u64 = 2048;
/// Triangles whose edges are joined at once.
const AT_ONCE: usize = 1 << 18;

/// The edges of a mesh, found when they are first asked for.
#[derive(Default)]
pub(in crate::scene) struct SilhouetteEdges(OnceLock<Option<Edges>>);

impl SilhouetteEdges {
    /// What a point sees; `None` where too few rays are to follow, and where the mesh is not wholly between the point and
    /// the source.
    ///
    /// - `rays`: how many are to follow from this point
    pub(in crate::scene) fn seen(
        &self,
        hierarchy: &Hierarchy,
        machine: Machine,
        from: DVec3,
        target: &Target,
        rays: u64,
    ) -> Option<VisibilityMap> {
        if rays < FEWEST_RAYS || rays.saturating_mul(TRIANGLES_A_RAY) < hierarchy.faces().len() as u64 {
            return None;
        }
        self.0.get_or_init(|| Edges::new(hierarchy)).as_ref()?.seen(hierarchy, machine, from, target)
    }
}

struct Edges {
    /// Eight triangles each: a normal, as long as the sine between two edges, and how far along it the triangle lies.
    planes: Vec<[[f64; LANES]; 4]>,
    edges: Vec<Edge>,
    bounds: (DVec3, DVec3),
}

struct Edge {
    /// Vertices of the hierarchy.
    ends: [u32; 2],
    /// The triangles on its sides; the one after the last where there is none.
    sides: [u32; 2],
}

impl Edges {
    /// `None` of a mesh that is hardly joined.
    fn new(hierarchy: &Hierarchy) -> Option<Edges> {
        let vertices = hierarchy.vertices();
        let edges = edges(hierarchy);
        let nobody = hierarchy.faces().len() as u32;
        let rims = edges.iter().filter(|edge| edge.sides[1] == nobody).count();
        if rims > 32 && rims * 4 > hierarchy.faces().len() {
            return None;
        }
        let bounds = vertices
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let shortest = 10.0 * SMALL * (bounds.1 - bounds.0).max_element();
        let mut planes = vec![[[0.0; LANES]; 4]; hierarchy.faces().len().div_ceil(LANES)];
        for (k, corners) in hierarchy.faces().iter().enumerate() {
            let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
            let (ab, ac) = (b - a, c - a);
            let (one, other) = (ab.length(), ac.length());
            // What rounding could turn over faces nowhere.
            if one.min(other).min((c - b).length()) > shortest {
                let normal = ab.cross(ac) / (one * other);
                for (row, value) in planes[k / LANES].iter_mut().zip([normal.x, normal.y, normal.z, normal.dot(a)]) {
                    row[k % LANES] = value;
                }
            }
        }
        Some(Edges { planes, edges, bounds })
    }

    fn seen(&self, hierarchy: &Hierarchy, machine: Machine, from: DVec3, target: &Target) -> Option<VisibilityMap> {
        let mut visibility = VisibilityMap::towards(from, target, self.bounds)?;
        // For each triangle a bit if its front is seen, another if its back, none where that is in doubt or there is none.
        let mut sides = vec![[0_u8; LANES]; self.planes.len() + 1];
        let farthest = (self.bounds.1 - from).abs().max((self.bounds.0 - from).abs()).length();
        let doubt = SMALL * (farthest + from.abs().max_element());
        machine.run(Sides { planes: &self.planes, from, doubt, sides: &mut sides });
        let sides = sides.as_flattened();
        let mut crossed = [0; SIDE];
        for edge in &self.edges {
            if sides[edge.sides[0] as usize] & sides[edge.sides[1] as usize] == 0 {
                let [a, b] = edge.ends.map(|end| visibility.cell(hierarchy.vertices()[end as usize] - from));
                draw(&mut crossed, a, b);
            }
        }
        visibility.fill(hierarchy, from, &crossed);
        Some(visibility)
    }
}

/// For each vertex the first one at its place, so that copies of a vertex join.
fn first_at_their_place(vertices: &[DVec3]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    let at = |k: u32| vertices[k as usize];
    order.sort_unstable_by(|p, q| {
        let (a, b) = (at(*p), at(*q));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)).then(p.cmp(q))
    });
    let mut firsts = vec![0; vertices.len()];
    for same in order.chunk_by(|p, q| at(*p) == at(*q)) {
        for vertex in same {
            firsts[*vertex as usize] = same[0];
        }
    }
    firsts
}

/// Each edge once.
fn edges(hierarchy: &Hierarchy) -> Vec<Edge> {
    let firsts = first_at_their_place(hierarchy.vertices());
    let faces = hierarchy.faces();
    let nobody = faces.len() as u32;
    let mut edges = Vec::with_capacity(faces.len() * 3 / 2);
    // Both ends, the lower first, whether the triangle runs along it that way round, and the triangle.
    let mut halves: Vec<([u32; 2], bool, u32)> = Vec::new();
    // By parts, so that halves of edges take little memory beside the mesh.
    let parts = faces.len().div_ceil(AT_ONCE) as u32;
    for part in 0..parts {
        halves.clear();
        for (triangle, face) in (0..).zip(faces) {
            // Packs are filled up with their last triangle.
            if triangle > 0 && faces[triangle as usize - 1] == *face {
                continue;
            }
            let [a, b, c] = face.map(|corner| firsts[corner as usize]);
            for [p, q] in [[a, b], [b, c], [c, a]] {
                if p.min(q) % parts == part {
                    halves.push(([p.min(q), p.max(q)], p < q, triangle));
                }
            }
        }
        halves.sort_unstable();
        edges.extend(halves.chunk_by(|one, other| one.0 == other.0).map(|halves| match halves {
            [(ends, false, one), (_, true, other)] => Edge { ends: *ends, sides: [*one.min(other), *one.max(other)] },
            // A rim, and what is joined in another way, is an edge of what is seen from everywhere.
            several => Edge { ends: several[0].0, sides: [several[0].2, nobody] },
        }));
    }
    // Neighbours in space are neighbours in memory, as the hierarchy has them.
    edges.sort_unstable_by_key(|edge| edge.sides);
    edges
}

struct Sides<'a> {
    planes: &'a [[[f64; LANES]; 4]],
    from: DVec3,
    doubt: f64,
    sides: &'a mut [[u8; LANES]],
}

impl Work for Sides<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, registers: R) {
        let Sides { planes, from, doubt, sides } = self;
        for (plane, sides) in planes.iter().zip(sides) {
            let x = Eight::load(registers, &plane[0]);
            let y = Eight::load(registers, &plane[1]);
            let z = Eight::load(registers, &plane[2]);
            let mut above = [0.0; LANES];
            (x * from.x + y * from.y + z * from.z - Eight::load(registers, &plane[3])).store(&mut above);
            for lane in 0..LANES {
                sides[lane] = u8::from(above[lane] > doubt) | u8::from(above[lane] < -doubt) << 1;
            }
        }
    }
}
