//! Which place of the receiver a pixel looks at.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::configuration::{Configuration, ReceiverShape};
use crate::geometry::Rectangle;

/// A grid of pixels that fills a rectangular receiver: column 0 begins where `edge_u` does, row 0 where `edge_v` ends, as one
/// sees it who stands before its receiving side with `edge_v` upwards.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PixelGrid {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The outer corner of the first pixel of row 0, metres.
    corner_m: [f64; 3],
    /// From a pixel to the next of its row, metres.
    per_column_m: [f64; 3],
    /// From a row to the next, metres.
    per_row_m: [f64; 3],
}

impl PixelGrid {
    /// Pixels that an image has at most: 2²⁴.
    pub const MOST_PIXELS: usize = 1 << 24;

    /// `None` where the receiver is no rectangle, or the count of pixels is 0 or beyond [`PixelGrid::MOST_PIXELS`].
    pub fn of_receiver(configuration: &Configuration, [width, height]: [usize; 2]) -> Option<PixelGrid> {
        let ReceiverShape::Rectangle(receiver) = configuration.receiver()?.shape() else { return None };
        let n = width.checked_mul(height).filter(|n| (1..=PixelGrid::MOST_PIXELS).contains(n));
        n?;
        let (u, v) = (receiver.edge_u(), receiver.edge_v());
        let grid = PixelGrid {
            width,
            height,
            corner_m: (receiver.center() - u * 0.5 + v * 0.5).to_array(),
            per_column_m: (u / width as f64).to_array(),
            per_row_m: (v / -(height as f64)).to_array(),
        };
        // Rounding may leave no rectangle of a pixel that is minute beside its coordinates: then of none.
        let corners = [[0, 0], [width - 1, 0], [0, height - 1], [width - 1, height - 1]];
        corners.iter().all(|place| grid.footprint(*place).is_some()).then_some(grid)
    }

    /// The same pixels, to a billionth of one.
    pub fn agrees_with(&self, other: &PixelGrid) -> bool {
        let size = DVec3::from(other.per_column_m).length().min(DVec3::from(other.per_row_m).length());
        let near = |a: [f64; 3], b: [f64; 3], times: usize| {
            (DVec3::from(a) - DVec3::from(b)).length() * times as f64 <= 1e-9 * size
        };
        (self.width, self.height) == (other.width, other.height)
            && near(self.corner_m, other.corner_m, 1)
            && near(self.per_column_m, other.per_column_m, self.width)
            && near(self.per_row_m, other.per_row_m, self.height)
    }

    pub fn n_pixels(&self) -> usize {
        self.width * self.height
    }
    /// Column and row, of `[row][column]`.
    pub fn place(&self, index: usize) -> [usize; 2] {
        [index % self.width, index / self.width]
    }
    /// The middle of a pixel, metres.
    pub fn middle(&self, [column, row]: [usize; 2]) -> DVec3 {
        DVec3::from(self.corner_m)
            + DVec3::from(self.per_column_m) * (column as f64 + 0.5)
            + DVec3::from(self.per_row_m) * (row as f64 + 0.5)
    }
    /// A pixel's footprint; it faces as the receiver does. `None` where rounding leaves no rectangle of it.
    pub fn footprint(&self, place: [usize; 2]) -> Option<Rectangle> {
        Rectangle::new(self.middle(place), self.per_column_m.into(), -DVec3::from(self.per_row_m)).ok()
    }
    /// The shorter side of a pixel, metres.
    pub fn pixel_size(&self) -> f64 {
        DVec3::from(self.per_column_m).length().min(DVec3::from(self.per_row_m).length())
    }
}
