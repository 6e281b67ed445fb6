//! In place of the reader of pictures without the feature `studies`.

use crate::geometry::TexelGrid;
use crate::texture::Encoding;

/// A picture as light from 0 to 1, `[row][column]` from the lowest row upwards.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    pub grid: TexelGrid,
    pub values: Vec<f64>,
}

/// Says what reads pictures.
pub(super) fn read(_: &[u8], _: Encoding) -> Result<Picture, String> {
    Err("this slim build reads no pictures; the feature `studies` of the crate `etendue` does".to_owned())
}
