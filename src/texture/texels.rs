//! Values on the texels of a surface's map, and how they are read.

use glam::DVec3;

use super::axis::Axis;
use super::triangle::Bilinear;
use super::{Raster, Seams};
use crate::geometry::{Parametrisation, Texel, TexelFinder};

/// How a value is read between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lookup {
    /// The value of the texel that the point lies in.
    Nearest,
    /// Interpolated between texels, without gain or loss.
    ///
    /// On rectangles, disks and spheres values are blended over the texels' borders in coordinates of equal area: every
    /// texel's weight over the surface remains its area, and weights at a point add up to one. The seam of a sphere or a disk
    /// is a border like others; at a pole what is read tends to the mean of the row there, so that it is continuous.
    ///
    /// On triangles, whose sides cut texels anyhow, what the usual bilinear interpolation reads is multiplied by one factor
    /// for the whole map, that of its integral to the sum over texels; it differs from one by what the cut texels hold too
    /// much or too little. Texels that the triangle does not reach count as the mean of their neighbours that it does.
    Bilinear,
}

/// Values on a surface.
///
/// ```
/// use etendue::geometry::{DVec3, Parametrisation, Sphere, TexelGrid};
/// use etendue::texture::{Lookup, Raster, Texels};
///
/// let globe = Sphere::new(DVec3::ZERO, 1.0)?;
/// let map = Parametrisation::sphere(&globe, DVec3::Z, DVec3::X)?;
/// let board = Raster::checker(TexelGrid::new(8, 4)?, 2.0, 0.0)?;
/// let nearest = Texels::new(map, board.clone(), Lookup::Nearest);
/// assert_eq!(nearest.at(DVec3::new(0.5, 0.1, -0.9)), 2.0);
/// // Half of the sphere shines, however it is read.
/// let blended = Texels::new(map, board, Lookup::Bilinear);
/// assert!((nearest.integral() / globe.area() - 1.0).abs() < 1e-14);
/// assert_eq!(nearest.integral(), blended.integral());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Texels {
    map: Parametrisation,
    raster: Raster,
    lookup: Lookup,
    reading: Reading,
    integral: f64,
}

/// What the lookup needs.
#[derive(Clone, Debug, PartialEq)]
enum Reading {
    /// On round surfaces texels are found without arcs.
    Nearest(Option<TexelFinder>),
    Blended {
        columns: Axis,
        rows: Axis,
        row_means: Vec<f64>,
    },
    Triangle(Bilinear),
}

impl Texels {
    /// Values of a raster on the texels of a surface.
    pub fn new(map: Parametrisation, raster: Raster, lookup: Lookup) -> Texels {
        let grid = raster.grid();
        let integral = sum(grid.texels().map(|texel| raster.value(texel) * map.texel_area(grid, texel)));
        let reading = match (lookup, map.map_triangle()) {
            (Lookup::Nearest, _) => Reading::Nearest(TexelFinder::new(&map, grid)),
            (Lookup::Bilinear, Some(_)) => Reading::Triangle(Bilinear::new(&map, &raster, integral)),
            (Lookup::Bilinear, None) => {
                let even = |n: usize| (0..=n).map(move |k| k as f64 / n as f64);
                let below = |t: f64| map.share_below(t).unwrap_or(t);
                Reading::Blended {
                    columns: Axis::new(even(grid.ns()).collect(), map.wraps(), [false, false]),
                    rows: Axis::new(even(grid.nt()).map(below).collect(), false, map.poles()),
                    row_means: raster
                        .values()
                        .chunks(grid.ns())
                        .map(|row| sum(row.iter().copied()) / grid.ns() as f64)
                        .collect(),
                }
            }
        };
        Texels { map, raster, lookup, reading, integral }
    }

    /// The surface's map.
    pub fn map(&self) -> &Parametrisation {
        &self.map
    }
    /// The values.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }
    /// How they are read.
    pub fn lookup(&self) -> Lookup {
        self.lookup
    }

    /// The integral over the surface: the sum over texels of value × area, for either lookup.
    ///
    /// - error: a few units in the last place (the sum is compensated)
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// The value at a point of the surface, metres.
    #[inline]
    pub fn at(&self, point: DVec3) -> f64 {
        self.at_offset(point - self.map.anchor())
    }

    /// The value at a point given by its offset from the map's [anchor](Parametrisation::anchor), metres.
    pub fn at_offset(&self, offset: DVec3) -> f64 {
        if let Reading::Nearest(Some(finder)) = &self.reading {
            return self.raster.value(finder.texel_from_anchor(offset));
        }
        self.at_map(self.map.to_map_from_anchor(offset))
    }

    /// The value at a place of the map.
    pub fn at_map(&self, [s, t]: [f64; 2]) -> f64 {
        let own = self.raster.grid().texel([s, t]);
        match &self.reading {
            Reading::Nearest(_) => self.raster.value(own),
            Reading::Triangle(bilinear) => bilinear.at([s, t]),
            Reading::Blended { columns, rows, row_means } => {
                let share = self.map.share_below(t).unwrap_or(t);
                let (across, up) = (columns.blend(own.i, s), rows.blend(own.j, share));
                let row = |j: usize| {
                    let value = self.raster.value(Texel { i: across.own, j });
                    value + across.other_weight * (self.raster.value(Texel { i: across.other, j }) - value)
                };
                let value = row(up.own);
                if up.other_weight > 0.0 {
                    value + up.other_weight * (row(up.other) - value)
                } else {
                    value + up.pole_weight * (row_means[up.own] - value)
                }
            }
        }
    }

    /// Bounds of what is read on the surface.
    pub(super) fn range(&self) -> [f64; 2] {
        let grid = self.raster.grid();
        let seen = grid.texels().filter(|texel| self.map.texel_area(grid, *texel) > 0.0);
        let [low, high] = seen
            .map(|texel| self.raster.value(texel))
            .fold([f64::INFINITY, 0.0], |[low, high], value| [f64::min(low, value), f64::max(high, value)]);
        let factor = if let Reading::Triangle(bilinear) = &self.reading { bilinear.factor() } else { 1.0 };
        [low * factor, high * factor]
    }

    /// Where what is read is not smooth.
    pub(super) fn seams(&self) -> Seams {
        let grid = self.raster.grid();
        let borders = |n: usize| (1..n).map(move |k| k as f64 / n as f64);
        let middles = |n: usize| (0..n).map(move |k| (k as f64 + 0.5) / n as f64).collect();
        match &self.reading {
            Reading::Nearest(_) => {
                // The seam is a border too.
                let seam = (self.map.wraps() && grid.ns() > 1).then_some(0.0);
                Seams {
                    s: seam.into_iter().chain(borders(grid.ns())).collect(),
                    t: borders(grid.nt()).collect(),
                    is_constant_between: true,
                }
            }
            Reading::Triangle(_) => {
                Seams { s: middles(grid.ns()), t: middles(grid.nt()), is_constant_between: false }
            }
            Reading::Blended { columns, rows, .. } => Seams {
                s: columns.bends(),
                t: rows.bends().into_iter().filter_map(|share| self.map.t_of_share(share)).collect(),
                is_constant_between: false,
            },
        }
    }
}

/// Neumaier's compensated sum (1974).
pub(super) fn sum(terms: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0);
    for term in terms {
        let next = sum + term;
        lost += if sum.abs() >= term.abs() { (sum - next) + term } else { (term - next) + sum };
        sum = next;
    }
    sum + lost
}
