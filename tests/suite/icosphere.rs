//! Balls of triangles.

use etendue::geometry::{DVec3, Mesh};

/// An icosahedron whose faces are split in four `levels` times (20 · 4^levels faces), its corners drawn out to the unit sphere.
pub fn icosphere(levels: u32) -> Mesh {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let mut points = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        points.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
    }
    // The nearest neighbours of the twelve corners are 2 apart: every triple of neighbours is a face.
    let near = |i: usize, j: usize| (points[i].distance(points[j]) - 2.0).abs() < 1e-9;
    let mut faces = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(k, i) {
                    faces.push([i as u32, j as u32, k as u32]);
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    let mut mesh = Mesh::new(points.iter().map(|p| p.normalize()).collect(), faces).unwrap();
    for _ in 0..levels {
        let fine = mesh.subdivided(1);
        let points = fine.vertices().iter().map(|p| p.normalize()).collect();
        mesh = Mesh::new(points, fine.triangles().to_vec()).unwrap();
    }
    mesh
}
