//! A block of points of the unit square.

use super::{BLOCK, LANES, Row};

/// One block of points of the unit square.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Squares {
    pub u: Row,
    pub v: Row,
}

impl Default for Squares {
    fn default() -> Squares {
        Squares { u: [[0.0; LANES]; BLOCK / LANES], v: [[0.0; LANES]; BLOCK / LANES] }
    }
}
