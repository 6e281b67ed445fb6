//! Which texel of a round surface holds a point, without arcs: by comparisons with the borders.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{Chart, Parametrisation, Texel, TexelGrid};

/// The borders of the texels of a disk or a sphere, in numbers that rise with s and t and cost no arc.
///
/// Agrees with [`TexelGrid::texel`] of [`Parametrisation::to_map`] but for points within rounding of a border.
#[derive(Clone, Debug, PartialEq)]
pub struct TexelFinder {
    anchor: DVec3,
    /// s = 0, s = ¼, and what t is told by.
    axes: [DVec3; 3],
    is_disk: bool,
    /// Where columns begin, all but the first, ascending; rows likewise.
    columns: Vec<f64>,
    rows: Vec<f64>,
}

impl TexelFinder {
    /// `None` for flat surfaces with straight coordinates, whose texels are found directly.
    pub fn new(map: &Parametrisation, grid: TexelGrid) -> Option<TexelFinder> {
        let borders = |n: usize| (1..n).map(move |k| k as f64 / n as f64);
        let column = |s: f64| {
            let (sin, cos) = libm::sincos(TAU * s);
            turn(cos, sin)
        };
        let columns = borders(grid.ns()).map(column).collect();
        match &map.chart {
            Chart::Disk { zero, quarter, radius, .. } => Some(TexelFinder {
                anchor: map.anchor(),
                axes: [*zero, *quarter, DVec3::ZERO],
                is_disk: true,
                columns,
                rows: borders(grid.nt()).map(|t| t * radius * radius).collect(),
            }),
            Chart::Sphere { equator, east, north, radius, .. } => Some(TexelFinder {
                anchor: map.anchor(),
                axes: [*equator, *east, *north],
                is_disk: false,
                columns,
                // Height over the equator; the sine of the angle from it keeps its digits there.
                rows: borders(grid.nt()).map(|t| radius * libm::sin(PI * (t - 0.5))).collect(),
            }),
            Chart::Rectangle(_) | Chart::Triangle { .. } => None,
        }
    }

    /// The texel that holds a point of the surface (metres).
    #[inline]
    pub fn texel(&self, point: DVec3) -> Texel {
        self.texel_from_anchor(point - self.anchor)
    }

    /// The same of a point given by its offset from the map's [anchor](Parametrisation::anchor), metres.
    #[inline]
    pub fn texel_from_anchor(&self, offset: DVec3) -> Texel {
        let [x, y, z] = self.axes.map(|axis| offset.dot(axis));
        let along_t = if self.is_disk { x * x + y * y } else { z };
        Texel { i: below(&self.columns, turn(x, y)), j: below(&self.rows, along_t) }
    }
}

/// How many borders are not above a number.
#[inline]
fn below(borders: &[f64], x: f64) -> usize {
    // A few are counted faster than they are searched.
    const FEW: usize = 16;
    if borders.len() <= FEW {
        borders.iter().map(|border| usize::from(*border <= x)).sum()
    } else {
        borders.partition_point(|border| *border <= x)
    }
}

/// Rises with the angle of (x, y) from 0 to 2π, from 0 to 4: where the ray meets the square |x| + |y| = 1, by its quarters.
#[inline]
fn turn(x: f64, y: f64) -> f64 {
    let size = x.abs() + y.abs();
    if size == 0.0 {
        return 0.0;
    }
    let along = y / size;
    if x >= 0.0 { if y >= 0.0 { along } else { 4.0 + along } } else { 2.0 - along }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Disk, Rectangle, Sphere};

    #[test]
    fn texels_are_those_of_the_map() {
        let center = DVec3::new(1.0, -2.0, 3.0);
        let globe = Sphere::new(center, 0.7).unwrap();
        let disk = Disk::new(center, DVec3::new(0.2, 0.1, -1.0), 0.7).unwrap();
        let maps = [
            Parametrisation::sphere(&globe, DVec3::new(0.1, 0.7, 0.4), DVec3::new(0.3, 0.2, -1.0)).unwrap(),
            Parametrisation::disk(&disk, Some(DVec3::X)).unwrap(),
        ];
        for map in maps {
            for (ns, nt) in [(1, 1), (3, 2), (8, 5), (64, 33), (1, 40)] {
                let grid = TexelGrid::new(ns, nt).unwrap();
                let finder = TexelFinder::new(&map, grid).expect("round");
                // Thirds of a texel, off the borders: 97 and 89 are prime to the sides.
                for k in 0..97 * 89 {
                    let at = [(k % 97) as f64 / 97.0 + 1e-3, (k / 97) as f64 / 89.0 + 1e-3];
                    let point = map.to_surface(at);
                    assert_eq!(finder.texel(point), grid.texel(at), "{ns} × {nt} at {at:?}");
                }
            }
        }
        let flat = Rectangle::new(center, DVec3::X, DVec3::Y).unwrap();
        assert_eq!(TexelFinder::new(&Parametrisation::rectangle(&flat), TexelGrid::new(2, 2).unwrap()), None);
    }

    #[test]
    fn the_turn_rises_all_around() {
        let mut last = -1.0;
        for k in 0..1000 {
            let (sin, cos) = libm::sincos(TAU * k as f64 / 1000.0);
            let here = turn(cos, sin);
            assert!(here > last && (0.0..4.0).contains(&here), "{k}: {here} after {last}");
            last = here;
        }
        assert_eq!(turn(0.0, 0.0), 0.0);
    }
}
