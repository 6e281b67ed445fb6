//! Simple planar polygons, convex or not.

use glam::DVec3;

use super::Frame;
use super::shape::{ShapeError, finite};

/// Largest distance of a vertex from the common plane, in units of the polygon's size.
const PLANAR_TOLERANCE: f64 = 1e-12;

/// A simple planar polygon; the lit side is the one from which its vertices run counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    vertices: Vec<DVec3>,
    normal: DVec3,
    area: f64,
}

impl Polygon {
    /// - `vertices`: metres, at least 3, in one plane to 1e-12 of the size, an outline that nowhere meets itself
    pub fn new(vertices: Vec<DVec3>) -> Result<Polygon, ShapeError> {
        if vertices.len() < 3 {
            return Err(ShapeError::TooFewVertices { said: vertices.len() });
        }
        for vertex in &vertices {
            finite("vertices", *vertex)?;
        }
        for second in 1..vertices.len() {
            if let Some(first) = vertices[..second].iter().position(|v| *v == vertices[second]) {
                return Err(ShapeError::RepeatedVertex { first, second });
            }
        }
        let (normal, area, size) = newell(&vertices);
        if area <= 1e-14 * size * size {
            return Err(ShapeError::NoArea);
        }
        let anchor = centroid(&vertices);
        let (vertex, distance) = vertices
            .iter()
            .map(|v| (*v - anchor).dot(normal).abs())
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .expect("at least three vertices");
        // Coordinates far from the origin are rounded to multiples of their own last place: grant that much.
        let rounding = 4.0 * f64::EPSILON * vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
        let allowed = PLANAR_TOLERANCE * size + rounding;
        if distance > allowed {
            return Err(ShapeError::NotPlanar { vertex, distance, allowed });
        }
        let flat = flatten(&vertices, anchor, normal);
        if let Some((first, second)) = first_meeting_edges(&flat) {
            return Err(ShapeError::SelfCrossing { first, second });
        }
        Ok(Polygon { vertices, normal, area })
    }

    /// Metres, counter-clockwise seen from the lit side.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }
    /// Unit vector towards the lit side.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }
    /// Square metres.
    pub fn area(&self) -> f64 {
        self.area
    }
    /// True if no interior angle exceeds a straight one.
    pub fn is_convex(&self) -> bool {
        let n = self.vertices.len();
        (0..n).all(|i| {
            let (a, b, c) = (self.vertices[i], self.vertices[(i + 1) % n], self.vertices[(i + 2) % n]);
            (b - a).cross(c - b).dot(self.normal) >= 0.0
        })
    }
}

fn centroid(vertices: &[DVec3]) -> DVec3 {
    // Relative to the first vertex, so that a polygon far from the origin keeps its digits.
    let sum: DVec3 = vertices.iter().map(|v| *v - vertices[0]).sum();
    vertices[0] + sum / vertices.len() as f64
}

/// Unit normal, area and largest extent (Newell's sum of cross products about the first vertex).
fn newell(vertices: &[DVec3]) -> (DVec3, f64, f64) {
    let origin = vertices[0];
    let size = vertices.iter().map(|v| (*v - origin).length()).fold(0.0, f64::max);
    let scaled: Vec<DVec3> = vertices.iter().map(|v| (*v - origin) / size).collect();
    let sum: DVec3 = scaled.windows(2).map(|pair| pair[0].cross(pair[1])).sum();
    (sum.normalize_or_zero(), 0.5 * sum.length() * size * size, size)
}

fn flatten(vertices: &[DVec3], anchor: DVec3, normal: DVec3) -> Vec<[f64; 2]> {
    let frame = Frame::around(normal);
    vertices.iter().map(|v| [(*v - anchor).dot(frame.tangent), (*v - anchor).dot(frame.bitangent)]).collect()
}

/// The first two edges of a closed outline that share a point they should not, by the index of their first vertex.
fn first_meeting_edges(outline: &[[f64; 2]]) -> Option<(usize, usize)> {
    let n = outline.len();
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let within =
        |a: [f64; 2], b: [f64; 2], p: [f64; 2]| (0..2).all(|k| a[k].min(b[k]) <= p[k] && p[k] <= a[k].max(b[k]));
    for i in 0..n {
        let (a, b) = (outline[i], outline[(i + 1) % n]);
        for j in i + 1..n {
            let (c, d) = (outline[j], outline[(j + 1) % n]);
            let meets = if j == i + 1 || (i == 0 && j == n - 1) {
                // Neighbours share a vertex; they may not fold back onto each other.
                let (shared, before, after) = if j == i + 1 { (b, a, d) } else { (a, b, c) };
                let fold = (before[0] - shared[0]) * (after[0] - shared[0])
                    + (before[1] - shared[1]) * (after[1] - shared[1]);
                turn(before, shared, after) == 0.0 && fold > 0.0
            } else {
                let (t1, t2) = (turn(a, b, c), turn(a, b, d));
                let (t3, t4) = (turn(c, d, a), turn(c, d, b));
                (t1 * t2 < 0.0 && t3 * t4 < 0.0)
                    || (t1 == 0.0 && within(a, b, c))
                    || (t2 == 0.0 && within(a, b, d))
                    || (t3 == 0.0 && within(c, d, a))
                    || (t4 == 0.0 && within(c, d, b))
            };
            if meets {
                return Some((i, j));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_height(z: f64, flat: &[[f64; 2]]) -> Vec<DVec3> {
        flat.iter().map(|p| DVec3::new(p[0], p[1], z)).collect()
    }

    const L: [[f64; 2]; 6] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];

    #[test]
    fn an_l_shape_has_three_squares_of_area_and_faces_up() {
        let l = Polygon::new(at_height(1.0, &L)).unwrap();
        approx::assert_abs_diff_eq!(l.area(), 3.0, epsilon = 1e-15);
        assert_eq!(l.normal(), DVec3::Z);
        assert!(!l.is_convex());
    }

    #[test]
    fn what_is_no_simple_planar_polygon_is_refused() {
        let bow_tie = at_height(0.0, &[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.2]]);
        assert!(matches!(Polygon::new(bow_tie), Err(ShapeError::SelfCrossing { .. })));
        let mut bent = at_height(0.0, &L);
        bent[3].z = 1e-6;
        assert!(matches!(Polygon::new(bent), Err(ShapeError::NotPlanar { .. })));
        let line = at_height(0.0, &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]);
        assert_eq!(Polygon::new(line), Err(ShapeError::NoArea));
        let twice = at_height(0.0, &[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0]]);
        assert_eq!(Polygon::new(twice), Err(ShapeError::RepeatedVertex { first: 0, second: 2 }));
        let spike = at_height(0.0, &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 0.5], [0.0, 1.0]]);
        assert!(matches!(Polygon::new(spike), Err(ShapeError::SelfCrossing { .. })));
        let pinched = at_height(0.0, &[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.0], [0.0, 2.0]]);
        assert!(matches!(Polygon::new(pinched), Err(ShapeError::SelfCrossing { .. })));
    }

    #[test]
    fn a_tilted_polygon_far_from_the_origin_is_still_planar() {
        let far = DVec3::new(1e6, -2e6, 3e6);
        let frame = Frame::around(DVec3::new(0.3, -0.5, 0.8).normalize());
        let vertices = L.iter().map(|p| far + frame.tangent * p[0] + frame.bitangent * p[1]).collect();
        approx::assert_relative_eq!(Polygon::new(vertices).unwrap().area(), 3.0, max_relative = 1e-8);
    }
}
