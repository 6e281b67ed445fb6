//! Triangle meshes.

use glam::DVec3;

use super::shape::{ShapeError, finite};

/// Triangles over shared vertices; the lit side of each is the one from which it runs counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// - `vertices`: metres; `triangles`: indices into `vertices`. Triangles without area are dropped: they block
    ///   nothing. At least one must remain.
    pub fn new(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Mesh, ShapeError> {
        for vertex in &vertices {
            finite("file", *vertex)?;
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(corner) = corners.iter().find(|c| **c as usize >= vertices.len()) {
                return Err(ShapeError::NoSuchVertex { triangle, said: *corner as usize, vertices: vertices.len() });
            }
        }
        let has_area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| vertices[i as usize]);
            (b - a).cross(c - a).length_squared() > 0.0
        };
        let triangles: Vec<_> = triangles.iter().copied().filter(has_area).collect();
        if triangles.is_empty() {
            return Err(ShapeError::NoTriangles);
        }
        Ok(Mesh { vertices, triangles })
    }

    /// Metres.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }
    /// Indices into [`Mesh::vertices`].
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
    /// The three corners of a triangle, metres.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|i| self.vertices[i as usize])
    }
    /// Square metres, all triangles together.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum()
    }

    /// The same surface with every triangle split into four at the midpoints of its edges, `levels` times over.
    ///
    /// The shape does not change (to rounding of the midpoints); the count of triangles grows by 4 a level.
    pub fn subdivided(&self, levels: u32) -> Mesh {
        let mut mesh = self.clone();
        for _ in 0..levels {
            mesh = mesh.split_in_four();
        }
        mesh
    }

    fn split_in_four(&self) -> Mesh {
        let mut vertices = self.vertices.clone();
        let mut midpoints = std::collections::HashMap::with_capacity(self.triangles.len() * 3 / 2);
        let mut midpoint = |a: u32, b: u32| {
            *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((self.vertices[a as usize] + self.vertices[b as usize]) * 0.5);
                (vertices.len() - 1) as u32
            })
        };
        let mut triangles = Vec::with_capacity(self.triangles.len() * 4);
        for &[a, b, c] in &self.triangles {
            let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
            triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        vertices.shrink_to_fit();
        Mesh { vertices, triangles }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Mesh {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        Mesh::new(vertices, vec![[0, 1, 2], [0, 2, 3]]).unwrap()
    }

    #[test]
    fn splitting_keeps_the_area_and_shares_midpoints() {
        let fine = square().subdivided(3);
        assert_eq!(fine.triangles().len(), 2 * 64);
        assert_eq!(fine.vertices().len(), 81, "a 9 × 9 grid of shared vertices");
        approx::assert_abs_diff_eq!(fine.area(), 1.0, epsilon = 1e-14);
    }

    #[test]
    fn broken_meshes_are_refused() {
        assert!(matches!(
            Mesh::new(vec![DVec3::ZERO], vec![[0, 0, 1]]),
            Err(ShapeError::NoSuchVertex { said: 1, .. })
        ));
        assert_eq!(Mesh::new(vec![DVec3::ZERO, DVec3::X], vec![[0, 1, 1]]), Err(ShapeError::NoTriangles));
    }
}
