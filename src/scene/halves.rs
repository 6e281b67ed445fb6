//! In place of the hierarchy of `obvhs` without the feature `fast`: the mesh halved, and halved again. The same answers,
//! since the same test of a triangle decides; slower on fine meshes.

use glam::DVec3;

use super::segment::Segment;
#[cfg(not(feature = "fast"))]
use super::{ShadowCache, ShadowRays};
use crate::geometry::Mesh;
#[cfg(not(feature = "fast"))]
use crate::sampling::{LANES, Row, groups};

/// Parts of so many triangles are not halved.
const SMALL: usize = 4;
/// Boxes reach out by this share of their coordinates: more than f64 rounding of a ray adds up to.
const PADDING: f64 = 1e-12;

/// Triangles of one mesh, and the boxes around them.
pub struct Hierarchy {
    /// In the order of the halves.
    triangles: Vec<[DVec3; 3]>,
    whole: Part,
}

/// A run of triangles.
struct Part {
    low: DVec3,
    high: DVec3,
    range: std::ops::Range<usize>,
    halves: Option<Box<[Part; 2]>>,
}

impl Hierarchy {
    /// - `mesh`: what blocks; `reach`: a box (low, high) that holds every end of every ray, metres
    pub fn new(mesh: &Mesh, reach: (DVec3, DVec3)) -> Hierarchy {
        let mut triangles: Vec<[DVec3; 3]> = (0..mesh.triangles().len()).map(|t| mesh.corners(t)).collect();
        let size = mesh.vertices().iter().chain([&reach.0, &reach.1]).map(|p| p.abs().max_element());
        let padding = PADDING * size.fold(f64::MIN_POSITIVE, f64::max);
        let n = triangles.len();
        let whole = Part::new(&mut triangles, 0..n, padding);
        Hierarchy { triangles, whole }
    }

    /// Whether a triangle lies strictly between two points.
    pub fn blocks(&self, from: DVec3, to: DVec3) -> bool {
        let Some(segment) = Segment::new(from, to) else { return false };
        self.whole.blocks(&self.triangles, &segment, from, to)
    }

    /// Sets to zero the contributions of the rays that this blocks, among the first `len` of a block.
    ///
    /// - `from`: the shading point, metres
    #[cfg(not(feature = "fast"))]
    #[expect(clippy::needless_range_loop, reason = "one index over several rows")]
    pub fn shade(
        &self,
        from: DVec3,
        rays: &ShadowRays,
        len: usize,
        contributions: &mut Row,
        _: Option<&mut ShadowCache>,
    ) {
        for g in 0..groups(len) {
            for l in 0..LANES {
                if contributions[g][l] != 0.0 && self.blocks(from, from + rays.ray(g, l)) {
                    contributions[g][l] = 0.0;
                }
            }
        }
    }
}

impl Part {
    fn new(triangles: &mut [[DVec3; 3]], range: std::ops::Range<usize>, padding: f64) -> Part {
        let own = &mut triangles[range.clone()];
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in own.iter().flatten() {
            (low, high) = (low.min(*corner), high.max(*corner));
        }
        let mut halves = None;
        if own.len() > SMALL {
            let axis = (high - low).max_position();
            let place = |triangle: &[DVec3; 3]| triangle[0][axis] + triangle[1][axis] + triangle[2][axis];
            own.sort_by(|a, b| place(a).total_cmp(&place(b)));
            let middle = range.start + own.len() / 2;
            let parts = [range.start..middle, middle..range.end];
            halves = Some(Box::new(parts.map(|half| Part::new(triangles, half, padding))));
        }
        Part { low: low - padding, high: high + padding, range, halves }
    }

    fn blocks(&self, triangles: &[[DVec3; 3]], segment: &Segment, from: DVec3, to: DVec3) -> bool {
        self.is_near(from, to)
            && match &self.halves {
                Some(halves) => halves.iter().any(|half| half.blocks(triangles, segment, from, to)),
                None => triangles[self.range.clone()].iter().any(|triangle| segment.meets(triangle)),
            }
    }

    /// Whether the box may hold a part of the way, by slabs.
    fn is_near(&self, from: DVec3, to: DVec3) -> bool {
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let (start, way) = (from[axis], to[axis] - from[axis]);
            if way == 0.0 {
                if start < self.low[axis] || start > self.high[axis] {
                    return false;
                }
                continue;
            }
            let [a, b] = [self.low[axis], self.high[axis]].map(|side| (side - start) / way);
            (enters, leaves) = (enters.max(a.min(b)), leaves.min(a.max(b)));
        }
        enters <= leaves
    }
}
