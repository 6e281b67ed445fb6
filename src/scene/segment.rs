//! What decides whether a triangle blocks.

use glam::DVec3;

/// A segment, sheared so that it runs along one axis and triangles can be tested in the plane of the other two.
///
/// A vertex gets the same two coordinates in every triangle that has it, and the sign of an edge function, the
/// difference of two products, is then exact or zero (rounding is monotone): with edges counted as part of a triangle,
/// no ray slips through a shared edge or vertex. Source: Woop, Benthin & Wald, *Watertight Ray/Triangle Intersection*,
/// JCGT 2(1), 2013, here in f64.
pub(super) struct Segment {
    pub(super) from: DVec3,
    /// Axes, the longest of the direction last.
    pub(super) axes: [usize; 3],
    pub(super) shear: [f64; 2],
    /// One over the extent along the last axis.
    pub(super) inverse: f64,
}

impl Segment {
    /// `None` for a segment of no length.
    #[inline(always)]
    pub(super) fn new(from: DVec3, to: DVec3) -> Option<Segment> {
        let direction = to - from;
        let size = direction.abs();
        let z = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let inverse = 1.0 / direction[z];
        inverse.is_finite().then(|| Segment {
            from,
            axes,
            shear: [direction[axes[0]] * inverse, direction[axes[1]] * inverse],
            inverse,
        })
    }

    /// Whether the triangle, its edges included, lies strictly between the ends.
    #[inline(always)]
    pub(super) fn meets(&self, triangle: &[DVec3; 3]) -> bool {
        let [a, b, c] = triangle.map(|p| {
            let offset = p - self.from;
            let along = offset[self.axes[2]];
            [offset[self.axes[0]] - self.shear[0] * along, offset[self.axes[1]] - self.shear[1] * along, along]
        });
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let total = u + v + w;
        if !inside || total == 0.0 {
            return false;
        }
        let parameter = (u * a[2] + v * b[2] + w * c[2]) * self.inverse / total;
        parameter > 0.0 && parameter < 1.0
    }
}
