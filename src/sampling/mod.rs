//! Where points on a source and directions towards it come from: keyed streams, strategies, and the maps from the unit
//! square to a surface, to the solid angle of a shape, and to a hemisphere.
//!
//! Samples travel in blocks of [`BLOCK`] and lanes of [`LANES`]: sample i of an estimate uses lane i mod 8 of its
//! stream, first for u, then for v. That order is part of the format: a wider instruction set moves no number.

mod arc;
mod draws;
#[cfg(feature = "studies")]
mod ears;
#[cfg(feature = "studies")]
mod hemisphere;
mod lanes;
#[cfg(feature = "studies")]
mod pattern;
mod seed;
#[cfg(feature = "studies")]
mod silhouette;
#[cfg(feature = "studies")]
mod spherical;
mod squares;
mod strategy;
#[cfg(feature = "studies")]
mod stream;
mod warp;

pub use draws::Draws;
#[cfg(feature = "studies")]
pub use ears::triangulated;
#[cfg(feature = "studies")]
pub use hemisphere::cosine_weighted;
pub use lanes::{LANES, Lanes};
#[cfg(feature = "studies")]
pub use pattern::Pattern;
#[cfg(feature = "studies")]
pub(crate) use pattern::fill_side_by_side;
pub use seed::{Purpose, StreamKey};
#[cfg(feature = "studies")]
pub use silhouette::{DirectionBlock, Silhouette, View};
#[cfg(feature = "studies")]
pub use spherical::SphericalTriangle;
pub use squares::Squares;
pub use strategy::{Heuristic, PointSet, Strategy, Technique};
#[cfg(feature = "studies")]
pub use stream::Stream;
pub use warp::{Seams, Surface, SurfaceBlock, concentric};

/// Samples worked on together: small enough for the first-level cache, large enough to hide the dispatch.
pub const BLOCK: usize = 128;

/// One number for each sample of a block, lane by lane.
pub type Row = [[f64; LANES]; BLOCK / LANES];

/// Lanes needed for the first `len` samples of a block, whole ones.
#[inline(always)]
pub fn groups(len: usize) -> usize {
    len.div_ceil(LANES).min(BLOCK / LANES)
}
