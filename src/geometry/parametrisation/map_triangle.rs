//! The part of the map that a triangle is laid on.

use glam::DVec3;
use smallvec::SmallVec;

use super::{ParametrisationError, Texel, TexelGrid, triangle_area};

/// A map triangle that covers less of the unit square has no linear system worth solving.
const LEAST_SHARE: f64 = 1e-12;

/// Three corners in the unit square, where the vertices of a triangle are laid, in their order.
///
/// ```
/// use etendue::geometry::{DVec3, MapTriangle};
///
/// let slanted = [DVec3::ZERO, DVec3::X * 4.0, DVec3::new(1.0, 2.0, 0.0)];
/// let map = MapTriangle::similar_to(slanted)?;
/// assert_eq!(map.corners(), [[0.0, 0.0], [1.0, 0.0], [0.25, 0.5]]);
/// # Ok::<(), etendue::geometry::ParametrisationError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapTriangle {
    corners: [[f64; 2]; 3],
}

impl MapTriangle {
    /// Half of the square: (0, 0), (1, 0), (0, 1). (s, t) are then the weights of the second and third vertex, and a picture
    /// is sheared unless the triangle is a right-angled isosceles one.
    pub const HALF_SQUARE: MapTriangle = MapTriangle { corners: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] };

    /// - `corners`: (s, t) in [0, 1]², not on one line; clockwise ones mirror the picture
    pub fn new(corners: [[f64; 2]; 3]) -> Result<MapTriangle, ParametrisationError> {
        for (corner, [s, t]) in corners.into_iter().enumerate() {
            if !((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)) {
                return Err(ParametrisationError::OutsideMap { corner, s, t });
            }
        }
        let map = MapTriangle { corners };
        if map.area() < LEAST_SHARE {
            return Err(ParametrisationError::DegenerateMap { area: map.area() });
        }
        Ok(map)
    }

    /// The map triangle that undoes the distortion: similar to the triangle itself, its longest side all of the map's lower
    /// edge. (The angles at the longest side are acute and the height over it is below √3/2 of it: it always fits.)
    ///
    /// A picture then appears on the triangle as it is in the map, counter-clockwise as the vertices run; one length of the
    /// map is the length of the longest side.
    pub fn similar_to(vertices: [DVec3; 3]) -> Result<MapTriangle, ParametrisationError> {
        triangle_area(vertices)?;
        let side = |k: usize| vertices[(k + 1) % 3] - vertices[k];
        // The first of the longest.
        let first = (0..3).fold(0, |best, k| if side(k).length() > side(best).length() { k } else { best });
        let longest = side(first).length();
        let along = side(first) / longest;
        let to_tip = (vertices[(first + 2) % 3] - vertices[first]) / longest;
        let foot = to_tip.dot(along);
        let height = along.cross(to_tip).length();
        let mut corners = [[0.0, 0.0]; 3];
        corners[(first + 1) % 3] = [1.0, 0.0];
        corners[(first + 2) % 3] = [foot.clamp(0.0, 1.0), height.min(1.0)];
        MapTriangle::new(corners)
    }

    /// (s, t) of each vertex.
    pub fn corners(&self) -> [[f64; 2]; 3] {
        self.corners
    }

    /// The share of the unit square.
    pub fn area(&self) -> f64 {
        0.5 * self.twice_signed_area().abs()
    }

    /// q₀ + a (q₁ − q₀) + b (q₂ − q₀).
    pub(super) fn at(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let [q0, q1, q2] = self.corners;
        [0, 1].map(|k| q0[k] + a * (q1[k] - q0[k]) + b * (q2[k] - q0[k]))
    }

    /// a and b of a point in the map.
    pub(super) fn solve(&self, point: [f64; 2]) -> [f64; 2] {
        let [q0, q1, q2] = self.corners;
        let (first, second, offset) = (minus(q1, q0), minus(q2, q0), minus(point, q0));
        let whole = self.twice_signed_area();
        [cross(offset, second) / whole, cross(first, offset) / whole]
    }

    /// The area of the part of a texel that lies in the triangle, as a share of the unit square.
    pub(super) fn texel_share(&self, grid: TexelGrid, texel: Texel) -> f64 {
        let extent = grid.extent(texel);
        let [[s, _], [t, _]] = extent;
        // About the texel's own corner, so that a small texel keeps its digits.
        let part: SmallVec<[[f64; 2]; 8]> =
            clipped(&self.corners, extent).into_iter().map(|p| minus(p, [s, t])).collect();
        0.5 * (0..part.len()).map(|k| cross(part[k], part[(k + 1) % part.len()])).sum::<f64>().abs()
    }

    fn twice_signed_area(&self) -> f64 {
        let [q0, q1, q2] = self.corners;
        cross(minus(q1, q0), minus(q2, q0))
    }
}

/// The part of a convex outline of the map that lies in [s₀, s₁] × [t₀, t₁] (Sutherland & Hodgman 1974): its corners in the
/// order of the outline; none where nothing is left.
pub fn clipped(outline: &[[f64; 2]], extent: [[f64; 2]; 2]) -> SmallVec<[[f64; 2]; 8]> {
    let mut part: SmallVec<[[f64; 2]; 8]> = SmallVec::from_slice(outline);
    for (axis, [low, high]) in extent.into_iter().enumerate() {
        for (border, sign) in [(low, 1.0), (high, -1.0)] {
            let inside = |p: [f64; 2]| sign * (p[axis] - border);
            let before = std::mem::take(&mut part);
            for (k, to) in before.iter().enumerate() {
                let from = before[(k + before.len() - 1) % before.len()];
                let (a, b) = (inside(from), inside(*to));
                if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                    part.push(crossing(from, *to, axis, border));
                }
                if b >= 0.0 {
                    part.push(*to);
                }
            }
        }
    }
    if part.len() < 3 { SmallVec::new() } else { part }
}

/// Where a side crosses a border: the same digits whichever way the side runs, so that the parts on both sides of a border
/// fit together.
fn crossing(from: [f64; 2], to: [f64; 2], axis: usize, border: f64) -> [f64; 2] {
    let (low, high) = if from[axis] <= to[axis] { (from, to) } else { (to, from) };
    let share = (border - low[axis]) / (high[axis] - low[axis]);
    let mut at = [border; 2];
    at[1 - axis] = low[1 - axis] + share * (high[1 - axis] - low[1 - axis]);
    at
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
