//! Values on a grid of texels.

use super::TextureError;
use crate::geometry::{Texel, TexelGrid};

/// One value for each texel of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    grid: TexelGrid,
    /// `[nt][ns]`, from t = 0.
    values: Vec<f64>,
}

/// What the numbers of a picture stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// In proportion to light.
    Linear,
    /// The curve of IEC 61966-2-1 (1999), as most pictures for the eye are stored.
    Srgb,
}

impl Encoding {
    /// Light, from 0 to 1, of a stored number, from 0 to 1.
    ///
    /// ```text
    /// sRGB: x / 12.92 up to 0.04045, beyond it ((x + 0.055) / 1.055)^2.4
    /// ```
    pub fn decode(self, stored: f64) -> f64 {
        match self {
            Encoding::Linear => stored,
            Encoding::Srgb if stored <= 0.040_45 => stored / 12.92,
            Encoding::Srgb => libm::pow((stored + 0.055) / 1.055, 2.4),
        }
    }
}

impl Raster {
    /// - `values`: `[nt][ns]`, row by row from t = 0, finite and ≥ 0
    pub fn new(grid: TexelGrid, values: Vec<f64>) -> Result<Raster, TextureError> {
        if values.len() != grid.n_texels() {
            return Err(TextureError::Length { said: values.len(), expected: grid.n_texels() });
        }
        if let Some(k) = values.iter().position(|value| !(value.is_finite() && *value >= 0.0)) {
            return Err(TextureError::Value { i: k % grid.ns(), j: k / grid.ns(), said: values[k] });
        }
        Ok(Raster { grid, values })
    }

    /// A chessboard: `first` where column and row add up to an even number, as at (0, 0), else `second`.
    pub fn checker(grid: TexelGrid, first: f64, second: f64) -> Result<Raster, TextureError> {
        let value = |texel: Texel| if (texel.i + texel.j).is_multiple_of(2) { first } else { second };
        Raster::new(grid, grid.texels().map(value).collect())
    }

    /// The grid.
    pub fn grid(&self) -> TexelGrid {
        self.grid
    }
    /// `[nt][ns]`, from t = 0.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
    /// Of one texel.
    pub fn value(&self, texel: Texel) -> f64 {
        self.values[self.grid.index(texel)]
    }
}
