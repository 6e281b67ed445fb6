//! Where an exitance that is read from texels is uneven within a cell of the unit square.

use glam::DVec3;

use crate::geometry::TexelGrid;
use crate::texture::{Lookup, Texels, Texture};

/// How finely a texture varies.
pub(super) struct TexelCheck<'a> {
    texels: &'a Texels,
    grid: TexelGrid,
    /// Halvings of the unit square after which its cells are smaller than texels.
    level: u32,
}

/// Halvings beyond a texel's width, so that a cell whose corners lie in one texel does so itself.
const BELOW: u32 = 1;
/// The same where values are interpolated: bends within a cell are then small.
const BELOW_BEND: u32 = 2;

impl<'a> TexelCheck<'a> {
    /// `None` for a texture that is smooth everywhere.
    pub fn of(texture: &'a Texture) -> Option<TexelCheck<'a>> {
        let texels = texture.texels()?;
        let grid = texels.raster().grid();
        let side = grid.ns().max(grid.nt()).next_power_of_two().trailing_zeros();
        let below = if texels.lookup() == Lookup::Nearest { BELOW } else { BELOW_BEND };
        Some(TexelCheck { texels, grid, level: side + below })
    }

    /// Whether a cell with these corners, and this middle, may hold more than one value (or bend much).
    pub fn is_uneven(&self, level: u32, places: [DVec3; 5]) -> bool {
        if level < self.level {
            return true;
        }
        if self.texels.lookup() != Lookup::Nearest {
            return false;
        }
        let value = |place: DVec3| self.texels.raster().value(self.grid.texel(self.texels.map().to_map(place)));
        let first = value(places[0]);
        places[1..].iter().any(|place| value(*place) != first)
    }
}
