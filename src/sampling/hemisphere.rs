//! Directions of a hemisphere, cosine-weighted.

use super::warp::concentric;
use super::{DirectionBlock, LANES, Squares, groups};
use crate::geometry::{DVec3, Frame};

/// The directions of the first `len` points of a block (rounded up to whole lanes), with density cosθ/π per solid angle: a
/// uniform point of the unit disk, lifted onto the hemisphere over it (Malley's method).
///
/// - `normal`: the hemisphere's pole, a unit vector
/// - error: each direction is off by a few 2⁻⁵³, and its height over the horizon by as much
#[inline(always)]
pub fn cosine_weighted(normal: DVec3, squares: &Squares, len: usize, directions: &mut DirectionBlock) {
    let frame = Frame::around(normal);
    for g in 0..groups(len) {
        for l in 0..LANES {
            let (x, y) = concentric(squares.u[g][l], squares.v[g][l]);
            let height = (1.0 - (x * x + y * y)).max(0.0).sqrt();
            let direction = frame.tangent * x + frame.bitangent * y + frame.normal * height;
            directions.set(g, l, direction);
        }
    }
}
