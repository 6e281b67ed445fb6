//! Which source a ray from a shading point meets first.

use glam::DVec3;

use super::{Blocker, Surroundings};
use crate::sampling::{BLOCK, DirectionBlock, LANES, Row, groups};

/// What the rays of a block meet first.
#[derive(Clone, Debug)]
pub struct Met {
    /// Which source's lit side, counted from 0; [`Met::NOTHING`] where the ray meets an occluder or a dark side, or nothing.
    pub source: [[u32; LANES]; BLOCK / LANES],
    /// To that source, metres; of no meaning where there is none.
    pub distance: Row,
    /// cosθₛ there; of no meaning where there is none.
    pub cosine: Row,
}

impl Met {
    /// No light comes along this ray.
    pub const NOTHING: u32 = u32::MAX;
}

impl Default for Met {
    fn default() -> Met {
        let row = [[0.0; LANES]; BLOCK / LANES];
        Met { source: [[Met::NOTHING; LANES]; BLOCK / LANES], distance: row, cosine: row }
    }
}

impl Surroundings {
    /// Follows the first `len` rays of a block (rounded up to whole lanes) to what they meet first, at any distance.
    ///
    /// A mesh is not asked how far it is: what matters is whether any of it lies before the source that was met, and only
    /// for rays that met one.
    ///
    /// - `from`: the shading point, metres; `directions`: unit vectors
    /// - error: whether a ray meets a shape is decided as for a shadow ray, in f64 without tolerance; the distance is off by
    ///   a few 2⁻⁵³ times the distances involved, over cosθₛ for a flat shape
    #[inline(always)]
    pub fn first_met(&self, from: DVec3, directions: &DirectionBlock, len: usize, met: &mut Met) {
        for g in 0..groups(len) {
            met.source[g] = [Met::NOTHING; LANES];
            met.distance[g] = [f64::INFINITY; LANES];
            met.cosine[g] = [0.0; LANES];
        }
        for (index, source) in self.sources.iter().enumerate() {
            source.meet(from, directions, len, index as u32, met);
        }
        for occluder in &self.occluders {
            occluder.meet(from, directions, len, Met::NOTHING, met);
        }
        for occluder in &self.occluders {
            let Some(hierarchy) = occluder.hierarchy() else { continue };
            for g in 0..groups(len) {
                for l in 0..LANES {
                    let end = || from + directions.direction(g, l) * met.distance[g][l];
                    if met.source[g][l] != Met::NOTHING && hierarchy.blocks(from, end()) {
                        met.source[g][l] = Met::NOTHING;
                    }
                }
            }
        }
    }
}

impl Blocker {
    /// Replaces what the rays of a block have met by this where this is nearer. Leaves meshes out.
    ///
    /// - `name`: what the lit side is called; the dark side is called nothing
    #[inline(always)]
    fn meet(&self, from: DVec3, directions: &DirectionBlock, len: usize, name: u32, met: &mut Met) {
        match self {
            Blocker::Disk { center, frame, radius } => {
                meet_flat(from - *center, frame.normal, directions, len, name, met, |p| {
                    p.length_squared() < radius * radius
                });
            }
            Blocker::Parallelogram { center, normal, dual_u, dual_v } => {
                meet_flat(from - *center, *normal, directions, len, name, met, |p| {
                    (p.dot(*dual_u).abs() < 0.5) & (p.dot(*dual_v).abs() < 0.5)
                });
            }
            Blocker::Polygon { anchor, frame, edges } => {
                meet_flat(from - *anchor, frame.normal, directions, len, name, met, |p| {
                    let (x, y) = (p.dot(frame.tangent), p.dot(frame.bitangent));
                    edges.iter().fold(false, |inside, edge| inside ^ edge.is_right_of(x, y))
                });
            }
            Blocker::Ball { center, radius_squared } => {
                meet_ball(from - *center, *radius_squared, directions, len, name, met);
            }
            Blocker::Mesh(_) => {}
        }
    }
}

/// A flat piece, one-sided in what it is called and two-sided in what it hides.
///
/// - `offset`: the shading point from the piece's origin
/// - `inside`: whether a point of its plane, from the same origin, belongs to it
#[inline(always)]
fn meet_flat(
    offset: DVec3,
    normal: DVec3,
    directions: &DirectionBlock,
    len: usize,
    name: u32,
    met: &mut Met,
    inside: impl Fn(DVec3) -> bool,
) {
    let height = offset.dot(normal);
    for g in 0..groups(len) {
        for l in 0..LANES {
            let d = directions.direction(g, l);
            let cosine = -d.dot(normal);
            // Infinite or NaN for a ray along the plane: then no comparison holds.
            let distance = height / cosine;
            let nearer = (distance > 0.0) & (distance < met.distance[g][l]) & inside(offset + d * distance);
            met.distance[g][l] = if nearer { distance } else { met.distance[g][l] };
            met.cosine[g][l] = if nearer { cosine } else { met.cosine[g][l] };
            let name = if cosine > 0.0 { name } else { Met::NOTHING };
            met.source[g][l] = if nearer { name } else { met.source[g][l] };
        }
    }
}

/// A solid ball; from inside it nothing else is seen.
///
/// The chord's half is the root of R² less the squared distance of the ray's line from the centre, which keeps its digits
/// for a small or far ball (Hearn & Baker; Haines et al., *Ray Tracing Gems*, 2019, chapter 7).
#[inline(always)]
fn meet_ball(offset: DVec3, radius_squared: f64, directions: &DirectionBlock, len: usize, name: u32, met: &mut Met) {
    let (distance_squared, radius) = (offset.length_squared(), radius_squared.sqrt());
    let outside = (distance_squared.sqrt() - radius) * (distance_squared.sqrt() + radius);
    let is_inside = distance_squared < radius_squared;
    for g in 0..groups(len) {
        for l in 0..LANES {
            let d = directions.direction(g, l);
            let middle = -offset.dot(d);
            let half = (radius_squared - (offset + d * middle).length_squared()).max(0.0).sqrt();
            let meets = (half > 0.0) & (middle > 0.0);
            let distance = if is_inside { 0.0 } else { outside / (middle + half) };
            let nearer = (is_inside | meets) & (distance < met.distance[g][l]);
            met.distance[g][l] = if nearer { distance } else { met.distance[g][l] };
            met.cosine[g][l] = if nearer { half / radius } else { met.cosine[g][l] };
            let name = if is_inside { Met::NOTHING } else { name };
            met.source[g][l] = if nearer { name } else { met.source[g][l] };
        }
    }
}
