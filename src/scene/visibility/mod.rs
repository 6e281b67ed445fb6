//! Where a mesh hides a source from a shading point, found before any ray is sent.
//!
//! How often rays from one point meet the mesh changes only where they cross a *silhouette edge*: one with a triangle seen
//! from its front on one side and from its back, or no triangle, on the other. So the silhouette edges are drawn onto a grid
//! of cells between the point and the source; in all cells that hang together without one, the rays fare alike, and one of
//! them tells of all. Only rays through the cells of the silhouette are left to be traced.
//!
//! Nothing is taken on trust: an edge is drawn wherever rounding could make it one, with a margin on both sides that is far
//! above all rounding, so that every answer is the one of [`Hierarchy::blocks`].

mod edges;
mod grid;
#[cfg(feature = "studies")]
#[cfg(test)]
mod tests;

use glam::DVec3;

pub(super) use edges::SilhouetteEdges;
use grid::{Grid, SIDE, part};

use super::blocker::dot;
use super::{Hierarchy, ShadowRays};
use crate::geometry::{Frame, Shape, box_corners};
use crate::number::{Eight, Lanewise, Machine, Registers, Work};
use crate::sampling::{BLOCK, LANES, Row, groups};

/// The source lies in the inner cells of the grid; of the outermost nothing is said.
const INNER: u64 = (u64::MAX >> 2) << 1;
/// Parts of the grid that a ray is sent to; more of them are left to the rays themselves.
const PARTS: usize = 32;
/// Angles, and lengths by the size of the scene, that are taken for zero: far above rounding.
const SMALL: f64 = 1e-9;

/// A source as what hides it must know it.
pub(crate) struct Target {
    /// Points whose hull holds the source, metres.
    hull: Vec<DVec3>,
    /// Their mean, metres.
    middle: DVec3,
    /// Of a flat source.
    normal: Option<DVec3>,
}

impl Target {
    /// - `source`: any shape but a mesh
    pub(crate) fn new(source: &Shape) -> Target {
        let hull = source.hull();
        let normal = match source {
            Shape::Disk(s) => Some(s.normal()),
            Shape::Rectangle(s) => Some(s.normal()),
            Shape::Polygon(s) => Some(s.normal()),
            Shape::Sphere(_) | Shape::Mesh(_) => None,
        };
        Target { middle: hull.iter().sum::<DVec3>() / hull.len() as f64, hull, normal }
    }

    /// Across the source, away from a point: a flat source's normal; else towards its middle, `None` from there.
    fn away_from(&self, from: DVec3) -> Option<DVec3> {
        match self.normal {
            Some(normal) => Some(if normal.dot(self.middle - from) < 0.0 { -normal } else { normal }),
            None => (self.middle - from).try_normalize(),
        }
    }
}

/// Where a mesh is known to hide a source from one point, and where it is known not to.
pub(crate) struct VisibilityMap {
    axis: DVec3,
    /// Across, in cells at distance 1 along the axis, and the cell that the axis meets.
    right: DVec3,
    up: DVec3,
    middle: [f64; 2],
    /// How far along the axis the mesh has been passed and the source not yet met, metres.
    between: f64,
    /// One bit for each cell, row by row.
    lit: Grid,
    dark: Grid,
}

impl VisibilityMap {
    /// Nothing known yet; `None` where something within bounds is not between the point and the source.
    fn towards(from: DVec3, target: &Target, bounds: (DVec3, DVec3)) -> Option<VisibilityMap> {
        let ahead = target.away_from(from)?;
        let along = |p: &DVec3| (*p - from).dot(ahead);
        let source = target.hull.iter().map(along).fold(f64::INFINITY, f64::min);
        let (mut near, mut far, mut size) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        for corner in box_corners(bounds) {
            (near, far) = (near.min(along(&corner)), far.max(along(&corner)));
            size = size.max((corner - from).length());
        }
        // Coordinates round by their own size, and what is near shows that most.
        let rounded = 1e-6 * size + 10.0 * SMALL * (from.abs().max_element() + size);
        if !(near > rounded && far < source * (1.0 - SMALL)) {
            return None;
        }
        let frame = Frame::around(ahead);
        let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in &target.hull {
            for (k, across) in [frame.tangent, frame.bitangent].into_iter().enumerate() {
                let place = (*point - from).dot(across) / along(point);
                (least[k], most[k]) = (least[k].min(place), most[k].max(place));
            }
        }
        let inner = SIDE as f64 - 3.0;
        let scale = [0, 1].map(|k| inner / (most[k] - least[k]));
        let visibility = VisibilityMap {
            axis: ahead,
            right: frame.tangent * scale[0],
            up: frame.bitangent * scale[1],
            middle: [1.5 - least[0] * scale[0], 1.5 - least[1] * scale[1]],
            between: source,
            lit: [0; SIDE],
            dark: [0; SIDE],
        };
        // Not seen from so far, or at so low an angle, that rounding would show in a cell.
        scale.iter().all(|scale| *scale < 1e5).then_some(visibility)
    }

    /// Where a displacement from the point leads, in cells.
    #[inline(always)]
    fn cell(&self, displacement: DVec3) -> [f64; 2] {
        let over = 1.0 / displacement.dot(self.axis);
        [displacement.dot(self.right) * over + self.middle[0], displacement.dot(self.up) * over + self.middle[1]]
    }

    /// Sets to zero the contributions of the rays that the mesh blocks, as [`Hierarchy::shade`] does, and traces those only
    /// that may pass the silhouette on either side.
    pub(super) fn shade(
        &self,
        machine: Machine,
        hierarchy: &Hierarchy,
        from: DVec3,
        rays: &ShadowRays,
        len: usize,
        contributions: &mut Row,
    ) {
        let (mut columns, mut rows) = (Row::default(), Row::default());
        machine.run(Cells { visibility: self, rays, len, columns: &mut columns, rows: &mut rows });
        let (mut doubtful, mut n_doubtful) = ([0_u8; BLOCK], 0);
        let (columns, rows) = (columns.as_flattened(), rows.as_flattened());
        let all = contributions.as_flattened_mut();
        for k in 0..groups(len) * LANES {
            let (column, row) = (columns[k].to_bits() % SIDE as u64, rows[k].to_bits() as usize % SIDE);
            let is_dark = self.dark[row] >> column & 1 == 1;
            let is_lit = self.lit[row] >> column & 1 == 1;
            all[k] = if is_dark { 0.0 } else { all[k] };
            doubtful[n_doubtful % BLOCK] = k as u8;
            n_doubtful += usize::from(!is_lit & (all[k] != 0.0));
        }
        let (mut left, mut light) = (ShadowRays::default(), Row::default());
        for (k, ray) in doubtful[..n_doubtful].iter().enumerate() {
            let (g, l) = (*ray as usize / LANES, *ray as usize % LANES);
            (left.x[k / LANES][k % LANES], left.y[k / LANES][k % LANES], left.z[k / LANES][k % LANES]) =
                rays.ray(g, l).into();
            light[k / LANES][k % LANES] = all[*ray as usize];
        }
        hierarchy.shade(from, &left, n_doubtful, &mut light, None);
        for (ray, light) in doubtful[..n_doubtful].iter().zip(light.as_flattened()) {
            all[*ray as usize] = *light;
        }
    }

    /// Sends a ray into each part of the grid that nothing crosses.
    fn fill(&mut self, hierarchy: &Hierarchy, from: DVec3, crossed: &Grid) {
        let mut free = crossed.map(|row| !row & INNER);
        (free[0], free[SIDE - 1]) = (0, 0);
        for _ in 0..PARTS {
            let Some(row) = free.iter().position(|row| *row != 0) else { return };
            let column = free[row].trailing_zeros();
            let part = part(&free, row, column);
            let across = [self.right, self.up].map(|axis| axis / axis.length_squared());
            let cell = [f64::from(column) + 0.5, row as f64 + 0.5];
            let way = self.axis + across[0] * (cell[0] - self.middle[0]) + across[1] * (cell[1] - self.middle[1]);
            let known =
                if hierarchy.blocks(from, from + way * self.between) { &mut self.dark } else { &mut self.lit };
            for row in 0..SIDE {
                known[row] |= part[row];
                free[row] &= !part[row];
            }
        }
    }
}

/// The cells that displacements lead to: columns and rows in the lowest bits.
struct Cells<'a> {
    visibility: &'a VisibilityMap,
    rays: &'a ShadowRays,
    len: usize,
    columns: &'a mut Row,
    rows: &'a mut Row,
}

/// Added to a number below 2⁵², it leaves the whole number before it in the lowest bits, or the next on a border.
const WHOLE: f64 = 4_503_599_627_370_496.0;

impl Work for Cells<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers>(self, registers: R) {
        let Cells { visibility, rays, len, columns, rows } = self;
        let last = Eight::load(registers, &[(SIDE - 1) as f64; LANES]);
        for g in 0..groups(len) {
            let ray = [
                Eight::load(registers, &rays.x[g]),
                Eight::load(registers, &rays.y[g]),
                Eight::load(registers, &rays.z[g]),
            ];
            let along = dot(ray, visibility.axis);
            let column = dot(ray, visibility.right) / along + (visibility.middle[0] - 0.5);
            let row = dot(ray, visibility.up) / along + (visibility.middle[1] - 0.5);
            (column.positive().at_most(last) + WHOLE).store(&mut columns[g]);
            (row.positive().at_most(last) + WHOLE).store(&mut rows[g]);
        }
    }
}
