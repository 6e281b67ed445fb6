//! A mesh that is not flat, prepared once: its corners, faces, and edges with the faces beside them.

use std::collections::HashMap;

use glam::DVec3;

use super::body::Body;
use crate::geometry::Mesh;

/// Faces that share corners, wound any way, joined any way.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// Equal corners are one.
    pub points: Vec<DVec3>,
    /// Indices into `points`.
    pub faces: Vec<[u32; 3]>,
    /// Indices into `points`, the lower one first.
    pub edges: Vec<[u32; 2]>,
    /// Where each edge's part of `beside` begins; one more than there are edges.
    first: Vec<u32>,
    beside: Vec<Beside>,
    /// The same surface as flat figures, faces of one plane merged: for those who ask for figures one by one.
    pub patches: Vec<Body>,
}

/// A face beside an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Beside(u32);

impl Beside {
    pub fn face(self) -> usize {
        (self.0 >> 1) as usize
    }
    /// Whether the face runs along the edge from its lower corner to its higher one.
    pub fn is_upward(self) -> bool {
        self.0 & 1 == 1
    }
}

impl Surface {
    /// - `scale`: a power of two that all lengths are multiplied by
    /// - `patches`: the mesh's flat patches, in the same scale
    pub fn new(mesh: &Mesh, scale: f64, patches: Vec<Body>) -> Surface {
        let mut index: HashMap<[u64; 3], u32> = HashMap::with_capacity(mesh.vertices().len());
        let mut points = Vec::new();
        // Adding zero turns −0 into 0.
        let place: Vec<DVec3> = mesh.vertices().iter().map(|p| *p * scale + DVec3::ZERO).collect();
        let mut faces = Vec::with_capacity(mesh.triangles().len());
        for triangle in mesh.triangles() {
            let face = triangle.map(|i| {
                let p = place[i as usize];
                *index.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
                    points.push(p);
                    points.len() as u32 - 1
                })
            });
            // Scaled down, a face may lose its area.
            if face[0] != face[1] && face[1] != face[2] && face[2] != face[0] {
                faces.push(face);
            }
        }
        let mut sides: Vec<([u32; 2], Beside)> = Vec::with_capacity(3 * faces.len());
        for (i, face) in faces.iter().enumerate() {
            for k in 0..3 {
                let (from, to) = (face[k], face[(k + 1) % 3]);
                sides.push(([from.min(to), from.max(to)], Beside((i as u32) << 1 | u32::from(from < to))));
            }
        }
        sides.sort_unstable();
        let (mut edges, mut first) = (Vec::new(), Vec::new());
        for (i, (edge, _)) in sides.iter().enumerate() {
            if edges.last() != Some(edge) {
                edges.push(*edge);
                first.push(i as u32);
            }
        }
        first.push(sides.len() as u32);
        let beside = sides.into_iter().map(|(_, beside)| beside).collect();
        Surface { points, faces, edges, first, beside, patches }
    }

    /// The faces that run along an edge.
    pub fn beside(&self, edge: usize) -> &[Beside] {
        &self.beside[self.first[edge] as usize..self.first[edge + 1] as usize]
    }

    /// Corner `j` less corner `i`.
    pub fn line(&self, i: u32, j: u32) -> DVec3 {
        self.points[j as usize] - self.points[i as usize]
    }

    /// Whether a face may reach into a ball.
    pub fn may_reach_into(&self, center: DVec3, radius: f64) -> bool {
        self.faces.iter().any(|face| {
            let [a, b, c] = face.map(|i| self.points[i as usize]);
            let normal = (b - a).cross(c - a);
            let middle = (a + b + c) / 3.0;
            let reach = a.distance(middle).max(b.distance(middle)).max(c.distance(middle));
            let off = normal.dot(center - a).abs();
            off < radius * normal.length() && middle.distance(center) < reach + radius
        })
    }
}
