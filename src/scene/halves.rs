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
    faces: Vec<[u32; 3]>,
    /// Metres.
    vertices: Vec<DVec3>,
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
        let (mut faces, vertices) = (mesh.triangles().to_vec(), mesh.vertices().to_vec());
        let size = mesh.vertices().iter().chain([&reach.0, &reach.1]).map(|p| p.abs().max_element());
        let padding = PADDING * size.fold(f64::MIN_POSITIVE, f64::max);
        let n = faces.len();
        let whole = Part::new(&mut faces, &vertices, 0..n, padding);
        Hierarchy { faces, vertices, whole }
    }

    /// Metres.
    #[cfg(not(feature = "fast"))]
    pub(super) fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Corners of the triangles among the vertices, neighbours together.
    #[cfg(not(feature = "fast"))]
    pub(super) fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Whether a triangle lies strictly between two points.
    pub fn blocks(&self, from: DVec3, to: DVec3) -> bool {
        let Some(segment) = Segment::new(from, to) else { return false };
        self.whole.blocks(self, &segment, from, to)
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
    fn new(faces: &mut [[u32; 3]], vertices: &[DVec3], range: std::ops::Range<usize>, padding: f64) -> Part {
        let own = &mut faces[range.clone()];
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in own.iter().flatten().map(|corner| vertices[*corner as usize]) {
            (low, high) = (low.min(corner), high.max(corner));
        }
        let mut halves = None;
        if own.len() > SMALL {
            let axis = (high - low).max_position();
            let place = |face: &[u32; 3]| face.iter().map(|corner| vertices[*corner as usize][axis]).sum::<f64>();
            own.sort_by(|a, b| place(a).total_cmp(&place(b)));
            let middle = range.start + own.len() / 2;
            let parts = [range.start..middle, middle..range.end];
            halves = Some(Box::new(parts.map(|half| Part::new(faces, vertices, half, padding))));
        }
        Part { low: low - padding, high: high + padding, range, halves }
    }

    fn blocks(&self, mesh: &Hierarchy, segment: &Segment, from: DVec3, to: DVec3) -> bool {
        self.is_near(from, to)
            && match &self.halves {
                Some(halves) => halves.iter().any(|half| half.blocks(mesh, segment, from, to)),
                None => mesh.faces[self.range.clone()]
                    .iter()
                    .any(|face| segment.meets(&face.map(|corner| mesh.vertices[corner as usize]))),
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
